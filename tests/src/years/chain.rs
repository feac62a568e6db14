//! Patches side by side that all lie off by the same: what the sum of their evidence decides, as on board.

use super::table::WRONG_PX;
use super::{Pair, Trial};
use crate::seeded::Random;
use plumbline_core::matching::directions::aboard::{WORKING_BYTES, frame_peak};
use plumbline_core::navigation::reckoning::Moment;
use plumbline_core::navigation::surface::{Frame, Surface};
use plumbline_core::tile::Local;
use plumbline_core::units::Micros;

/// What a chain says after one patch of it more.
#[derive(Clone, Copy, Debug)]
pub struct Link {
    /// Probability that the highest place is wrong, as stated.
    pub risk: f64,
    /// Whether it is.
    pub is_wrong: bool,
}

/// Adds up to `count` patches from a place of the grid on, along its columns, each beside the one before, on a surface of the core's that
/// keeps all evidence, as in the map's own year. A patch without texture adds nothing; where the highest place is on the surface's border there is no link.
pub fn chain(trial: &Trial, pair: Pair<'_>, at: [usize; 2], count: usize, seed: u64) -> Vec<Option<Link>> {
    let mut random = Random::new(seed);
    let true_shift = trial.shift(&mut random);
    let mut surface = Surface::new();
    let side_m = f32::from(trial.side);
    let mut bytes = vec![0; WORKING_BYTES];
    let link = |number: usize| {
        let at = [at[0] + number * usize::from(trial.side), at[1]];
        // One metre a pixel and one patch a second; what is stated of the velocity is that it is exact.
        let moment = Moment { at: Micros(1_000_000 * (1 + number as u64)), velocity_m_per_s: [side_m, 0.0] };
        surface.propagate(moment, [0.0; 2], 0.0);
        let searched = Local { east_m: at[0] as f32, north_m: -(at[1] as f32) };
        let middle = surface.recentre(searched, (searched, 0.0), side_m, 1.0);
        let pictures = trial.cut(pair, at, true_shift, &mut random);
        let (patch, other) = pictures.views()?;
        let rule = (trial.prior(), false);
        let add = |scores: &_, valid| {
            surface.add(&Frame::new(scores, valid), 1.0);
            None
        };
        // Without texture nothing is added.
        let _ = frame_peak(&patch, &trial.runs(), &other, (trial.radius, middle), rule, &mut bytes, add);
        let decided = surface.decision(1.0)?;
        let apart = pair.apart([at[0] as f64 + true_shift[0], at[1] as f64 + true_shift[1]]);
        let found = [f64::from(decided.nadir.east_m), -f64::from(decided.nadir.north_m)];
        let off = [0, 1].map(|axis| found[axis] - at[axis] as f64 - true_shift[axis] - apart[axis]);
        Some(Link { risk: decided.risk.into(), is_wrong: off[0].hypot(off[1]) > WRONG_PX })
    };
    (0..count).map(link).collect()
}

/// Share of the chains that end with a decision, and how many of these are wrong: the first link whose risk is at most so high decides.
pub fn decided(chains: &[Vec<Option<Link>>], risk_max: f64) -> (f64, usize) {
    let first = |chain: &Vec<Option<Link>>| chain.iter().flatten().find(|link| link.risk <= risk_max).copied();
    let links: Vec<Link> = chains.iter().filter_map(first).collect();
    let wrong = links.iter().filter(|link| link.is_wrong).count();
    (links.len() as f64 / chains.len().max(1) as f64, wrong)
}

/// The largest share of chains that a threshold in hindsight decides, at most such a share of them wrongly.
pub fn coverage(chains: &[Vec<Option<Link>>], wrong_share: f64) -> f64 {
    // A tenth of a decade from 1 down to 1e-12.
    let thresholds = (0..120).map(|step| 10f64.powf(-0.1 * f64::from(step)));
    let allowed = thresholds
        .map(|risk_max| decided(chains, risk_max))
        .filter(|(share, wrong)| *wrong as f64 <= wrong_share * share * chains.len() as f64);
    allowed.map(|(share, _)| share).fold(0.0, f64::max)
}

/// The head of [`line()`].
pub const HEAD: &str = "patches  chains  at1e-3  at1e-2  decided   wrong";

/// One line: chains cut to so many patches, what they cover at two shares of wrong ones, and what is decided at a stated risk.
pub fn line(chains: &[Vec<Option<Link>>], count: usize, risk_max: f64) -> String {
    let cut: Vec<Vec<Option<Link>>> = chains.iter().map(|chain| chain.iter().take(count).copied().collect()).collect();
    let (share, wrong) = decided(&cut, risk_max);
    let (sure, less) = (coverage(&cut, 1e-3), coverage(&cut, 1e-2));
    format!("{count:7} {:7} {sure:7.3} {less:7.3} {share:8.3} {wrong:7}", chains.len())
}

#[cfg(test)]
mod tests {
    use super::{Link, coverage, decided};

    #[test]
    fn the_first_link_that_is_sure_enough_decides() {
        let link = |risk: f64, is_wrong: bool| Some(Link { risk, is_wrong });
        let chains = [
            vec![link(0.5, true), link(1e-5, false)],
            vec![link(1e-2, true), link(1e-5, false)],
            vec![None, link(1e-5, true)],
            vec![link(0.5, false), None],
        ];
        assert_eq!(decided(&chains, 1e-4), (0.75, 1));
        assert_eq!(decided(&chains, 0.1), (0.75, 2));
        assert_eq!((coverage(&chains, 0.0), coverage(&chains, 0.34)), (0.0, 0.75));
    }
}
