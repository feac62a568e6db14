//! How far two heads of one station did put the same point apart in the virtual image.

use super::seams::{on_plane, rms_and_max};
use nalgebra::Vector3;
use plumbline_survey::adjust::rig::HEAD;
use plumbline_survey::adjust::rotation;
use plumbline_survey::calibrate::seam::ray_of;
use plumbline_survey::calibrate::{Block, Calibration, Observations, Symmetrised, mount};
use std::collections::BTreeMap;

/// A point that two heads of one station saw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twice {
    /// The two heads.
    pub heads: [usize; 2],
    /// Distance of its two places in the virtual image of the heads as designed, pixels.
    pub before_px: f64,
    /// Of the heads as calibrated.
    pub after_px: f64,
}

/// All of them.
#[derive(Clone, Debug)]
pub struct Observed(pub Vec<Twice>);

impl Observed {
    /// Looks for points that several heads of a station saw. The parallax between the heads' centres is taken off with the
    /// point's depth below the virtual camera, which is the adjusted one before and after.
    #[must_use]
    pub fn new(
        block: &Block,
        observations: &Observations,
        calibration: &Calibration,
        symmetrised: &Symmetrised,
        f_px: f64,
    ) -> Self {
        let designed: Vec<[f64; HEAD]> = block.heads.iter().map(|head| head.values).collect();
        let designed = Symmetrised::new(&designed);
        let stations: Vec<[f64; 6]> = calibration.stations.iter().map(|station| symmetrised.station(station)).collect();
        let mut together: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
        for (index, seen) in observations.seen.iter().enumerate() {
            together.entry((seen.station, seen.point)).or_default().push(index);
        }
        let mut twice = Vec::new();
        for ((station, point), mut of) in together {
            of.sort_unstable_by_key(|index| observations.seen[*index].head);
            let depth_m = height(&stations[station], calibration.points[point]);
            let at = |heads: &[[f64; HEAD]], index: usize| {
                let seen = &observations.seen[index];
                in_virtual(&heads[seen.head], seen.image_px, depth_m, f_px)
            };
            for (k, &first) in of.iter().enumerate() {
                for &second in &of[k + 1..] {
                    let apart = |heads: &[[f64; HEAD]]| {
                        let (a, b) = (at(heads, first)?, at(heads, second)?);
                        Some((a[0] - b[0]).hypot(a[1] - b[1]))
                    };
                    let (Some(before_px), Some(after_px)) = (apart(&designed.heads), apart(&symmetrised.heads)) else {
                        continue;
                    };
                    let heads = [first, second].map(|index| observations.seen[index].head);
                    twice.push(Twice { heads, before_px, after_px });
                }
            }
        }
        Observed(twice)
    }

    /// How many of a pair (or of all), and root mean square and largest, before and after.
    #[must_use]
    pub fn of(&self, pair: Option<[usize; 2]>) -> Option<(usize, [(f64, f64); 2])> {
        let of = || self.0.iter().filter(|twice| pair.is_none_or(|pair| pair == twice.heads));
        let before = rms_and_max(of().map(|twice| twice.before_px))?;
        let after = rms_and_max(of().map(|twice| twice.after_px))?;
        Some((of().count(), [before, after]))
    }
}

/// Height of a point in the virtual camera's frame, m: negative in front.
fn height(station: &[f64; 6], point_m: [f64; 3]) -> f64 {
    let rotation = rotation::matrix([station[0], station[1], station[2]]);
    let from_centre = Vector3::from(point_m) - Vector3::new(station[3], station[4], station[5]);
    rotation.tr_mul(&from_centre).z
}

/// Where an image point at a depth comes to lie in the virtual image.
fn in_virtual(head: &[f64; HEAD], image_px: [f64; 2], depth_m: f64, f_px: f64) -> Option<[f64; 2]> {
    let ray = mount(head) * ray_of(head, image_px)?;
    let centre = Vector3::new(head[3], head[4], head[5]);
    on_plane(&(centre + ray * ((depth_m - centre.z) / ray.z)), f_px)
}
