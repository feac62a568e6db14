//! Stated risks against what happened, in half decades, with intervals by scenes: what fools one patch of a scene fools its others.

use super::Outcome;
use super::table::stated;
use crate::bootstrap;
use std::collections::HashMap;

/// Pixels along a side of a scene. Chosen: a large patch.
const SCENE_PX: f64 = 65.0;
/// Half decades from 1e-5 to 1, and risks of 1 themselves.
const BINS: usize = 11;

/// A stated risk, whether the place was wrong, and the scene that it was in.
pub type Stated = (f64, bool, (u64, u32, u32));

/// What patches' directions state, with their scenes; `land` tells apart what has no ground in common.
pub fn of_scenes(outcomes: &[Outcome], land: u64) -> Vec<Stated> {
    let scene = |at: f64| (at / SCENE_PX) as u32;
    let of = |outcome: &Outcome| {
        let (risk, is_wrong) = stated(std::slice::from_ref(outcome)).next()?;
        Some((risk, is_wrong, (land, scene(outcome.at[0]), scene(outcome.at[1]))))
    };
    outcomes.iter().filter_map(of).collect()
}

/// Half a decade of stated risk.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bin {
    /// Mean of the risks.
    pub mean: f64,
    /// Wrong places.
    pub wrong: usize,
    /// All of them.
    pub count: usize,
    /// Scenes with any.
    pub scenes: usize,
    /// Interval of the share of wrong ones, 19 times of 20.
    pub interval: [f64; 2],
}

impl Bin {
    /// Share of wrong ones.
    #[must_use]
    pub fn observed(&self) -> f64 {
        self.wrong as f64 / self.count as f64
    }
}

/// Those half decades that have any.
#[must_use]
pub fn bins(stated: &[Stated]) -> Vec<Bin> {
    let mut of_bins = vec![Vec::new(); BINS];
    for entry in stated {
        let bin = ((entry.0.log10() + 5.0) * 2.0).floor().clamp(0.0, BINS as f64 - 1.0) as usize;
        of_bins[bin].push(*entry);
    }
    of_bins.iter().filter(|of_bin| !of_bin.is_empty()).map(|of_bin| bin(of_bin)).collect()
}

fn bin(stated: &[Stated]) -> Bin {
    let mut scenes: HashMap<_, (usize, usize)> = HashMap::new();
    for (_, is_wrong, scene) in stated {
        let scene = scenes.entry(*scene).or_default();
        *scene = (scene.0 + usize::from(*is_wrong), scene.1 + 1);
    }
    // In an order of their own, so that the same trials give the same interval.
    let mut of_scenes: Vec<_> = scenes.into_iter().collect();
    of_scenes.sort_unstable();
    let counts: Vec<(usize, usize)> = of_scenes.into_iter().map(|(_, counts)| counts).collect();
    let wrong = counts.iter().map(|scene| scene.0).sum();
    let mean = stated.iter().map(|entry| entry.0).sum::<f64>() / stated.len() as f64;
    Bin { mean, wrong, count: stated.len(), scenes: counts.len(), interval: interval(&counts, wrong) }
}

/// By drawing scenes anew. Where none is wrong the rule of three for the scenes, each worth one trial at least.
fn interval(scenes: &[(usize, usize)], wrong: usize) -> [f64; 2] {
    if wrong == 0 {
        return [0.0, (3.0 / scenes.len() as f64).min(1.0)];
    }
    let counts: Vec<(f64, f64)> = scenes.iter().map(|&(wrong, count)| (wrong as f64, count as f64)).collect();
    bootstrap::interval(&counts)
}

/// The table.
#[must_use]
pub fn lines(name: &str, bins: &[Bin]) -> Vec<String> {
    let line = |bin: &Bin| {
        let [low, high] = bin.interval;
        let Bin { mean, wrong, count, scenes, .. } = bin;
        let (observed, ratio) = (bin.observed(), mean / bin.observed());
        format!("{mean:11.1e} {wrong:6} {count:7} {scenes:7} {observed:9.1e} {low:8.1e} to {high:7.1e} {ratio:16.2}")
    };
    let head = "stated risk  wrong      of  scenes  observed    19 times of 20  stated/observed".to_owned();
    [String::new(), name.to_owned(), head].into_iter().chain(bins.iter().map(line)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Stated, bins};

    /// Ten scenes, of which one is wrong in all of its ten patches: as few independent trials as there are scenes.
    #[test]
    fn an_interval_counts_scenes_and_not_patches() {
        let patches = |wrong: &dyn Fn(u32, u32) -> bool| -> Vec<Stated> {
            (0..100).map(|at| (2e-2, wrong(at / 10, at % 10), (0, at / 10, 0))).collect()
        };
        let alike = bins(&patches(&|scene, _| scene == 0));
        let apart = bins(&patches(&|_, patch| patch == 0));
        assert_eq!((alike.len(), alike[0].wrong, alike[0].count, alike[0].scenes), (1, 10, 100, 10));
        assert_eq!((alike[0].observed(), apart[0].observed()), (0.1, 0.1));
        assert!(alike[0].interval[0] == 0.0 && alike[0].interval[1] >= 0.3, "{:?}", alike[0].interval);
        assert_eq!(apart[0].interval, [0.1, 0.1]);
        let none = bins(&patches(&|_, _| false));
        assert_eq!(none[0].interval, [0.0, 0.3]);
    }

    #[test]
    fn bins_are_half_decades() {
        let stated = [1e-5, 2.9e-5, 3.3e-5, 0.5, 1.0].map(|risk| (risk, false, (0, 0, 0)));
        let counts: Vec<usize> = bins(&stated).iter().map(|bin| bin.count).collect();
        assert_eq!(counts, [2, 1, 1, 1]);
    }
}
