//! Two photos, or two lines beside each other, at heights of their own: how much of one the other sees.
//!
//! A photo at depth d over level ground sees t d to each side (t the tangent of half its field of view). Two at depths d1 and d2, B apart,
//! see t (d1 + d2) - B in common, or all of the smaller one where B is below t |d1 - d2|. As a share of the larger, d its depth, that is
//! 1 - (t |d1 - d2| + max(B, t |d1 - d2|)) / (2 t d), which falls with the height of the ground. At equal heights it is paper 004's
//! 1 - B / (l (1 - dh / H)), to the last bit.

use super::course::Course;
use super::lines::{Layout, View};
use super::terrain::Zone;
use crate::error::InputError;

/// A pair over ground of some height.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    /// Depth of the deeper one over H.
    share: f64,
    /// Difference of both depths over H.
    apart: f64,
}

impl Pair {
    /// How far apart they may be along an axis, for a nominal base or distance on the base plane and a footprint there.
    pub(super) fn suits_m(&self, nominal_m: f64, footprint_m: f64) -> f64 {
        nominal_m * self.share - 0.5 * footprint_m * self.apart
    }

    /// The share of the larger that both see.
    pub(super) fn overlap(&self, distance_m: f64, footprint_m: f64) -> f64 {
        let aside_m = 0.5 * footprint_m * self.apart;
        // Terrain that reaches the camera leaves nothing to overlap.
        if self.share - self.apart > 0.0 {
            1.0 - (aside_m + distance_m.max(aside_m)) / (footprint_m * self.share)
        } else {
            f64::NEG_INFINITY
        }
    }
}

impl View {
    /// A pair at these heights above the level flying height, over the highest ground that both see.
    pub(super) fn pair(&self, rise_m: [f64; 2], highest_m: Option<f64>) -> Pair {
        let reference_m = self.base_height_m + rise_m[0].min(rise_m[1]);
        self.pair_over(rise_m, highest_m.unwrap_or(reference_m) - reference_m)
    }

    /// A pair over ground that rises so far above the plane that lies H below the lower one.
    fn pair_over(&self, rise_m: [f64; 2], above_m: f64) -> Pair {
        let apart = (rise_m[0] - rise_m[1]).abs() / self.height_m;
        Pair { share: 1.0 - above_m / self.height_m + apart, apart }
    }

    /// A pair over ground that is nowhere lower than that plane: the wish is kept on it whatever lies deeper.
    ///
    /// # Errors
    /// The terrain reaches the camera.
    fn wanted(&self, rise_m: [f64; 2], highest_m: Option<f64>) -> Result<Pair, InputError> {
        let reference_m = self.base_height_m + rise_m[0].min(rise_m[1]);
        let above_m = highest_m.map_or(0.0, |highest| highest - reference_m).max(0.0);
        if above_m >= self.height_m {
            return Err(self.reached(reference_m, above_m));
        }
        Ok(self.pair_over(rise_m, above_m))
    }

    fn reached(&self, reference_m: f64, above_m: f64) -> InputError {
        InputError::new(format!(
            "the terrain rises to {:.1} m within sight of a strip, above the flying height of {:.1} m ({:.1} m over the base plane at {:.1} m): it takes more than \
             --height-m {:.0}, with --min-clearance-m added to that",
            reference_m + above_m,
            reference_m + self.height_m,
            self.height_m,
            self.base_height_m,
            above_m.ceil()
        ))
    }

    /// Half a footprint at a height above the level flying height, on the plane that lies H below a lower one.
    fn half_m(&self, axis: usize, above_m: f64) -> f64 {
        0.5 * self.footprint_m[axis] + self.half_tangent()[axis] * above_m
    }
}

/// A part of two neighbouring lines: where both look, and how high each flies there at least and at most.
struct Section {
    zone: Zone,
    rise_m: [[f64; 2]; 2],
}

impl Section {
    /// The heights at which two lines overlap least: the overlap rises with the lower one's height, and over that of the higher one it has
    /// no greatest loss but at the ends of its range.
    fn pairs(&self) -> impl Iterator<Item = [f64; 2]> {
        let [[a_low, a_high], [b_low, b_high]] = self.rise_m;
        let level = a_low.max(b_low);
        [(level, b_low), (a_high, b_low), (a_low, level), (a_low, b_high)]
            .into_iter()
            .filter(move |(a, b)| *a <= a_high && *b <= b_high)
            .map(|(a, b)| [a, b])
    }
}

impl Layout<'_> {
    /// Where a photo of a strip and the next, a base further, both look: on the plane H below the lower one.
    fn forward_section(&self, course: &Course, across_m: f64, along_m: f64, base_m: f64) -> (Zone, [f64; 2]) {
        let rise_m = [course.rise_m(along_m), course.rise_m(along_m + base_m)];
        if course.is_level() {
            return (self.view.forward_zone(along_m, base_m, across_m), rise_m);
        }
        let low_m = rise_m[0].min(rise_m[1]);
        let [back_m, front_m] = rise_m.map(|rise| self.view.half_m(0, rise - low_m));
        let aside_m = self.view.half_m(1, 0.0);
        let along = [along_m + base_m - front_m, along_m + back_m];
        (Zone { along, across: [across_m - aside_m, across_m + aside_m] }, rise_m)
    }

    /// The base that suits the terrain that a photo and the next, `base_m` further, see.
    ///
    /// # Errors
    /// The terrain reaches the camera.
    pub(super) fn base_m(&self, course: &Course, across_m: f64, along_m: f64, base_m: f64) -> Result<f64, InputError> {
        let (zone, rise_m) = self.forward_section(course, across_m, along_m, base_m);
        let pair = self.view.wanted(rise_m, self.terrain.highest_in(&self.axes, &zone))?;
        Ok(pair.suits_m(self.view.nominal_m(&self.overlaps)[0], self.view.footprint_m[0]))
    }

    /// Overlap of a photo with the next of its strip, a base further.
    #[must_use]
    pub fn forward_overlap_on(&self, course: &Course, across_m: f64, along_m: f64, base_m: f64) -> f64 {
        let (zone, rise_m) = self.forward_section(course, across_m, along_m, base_m);
        let highest_m = self.terrain.highest_in(&self.axes, &zone);
        self.view.pair(rise_m, highest_m).overlap(base_m, self.view.footprint_m[0])
    }

    /// The distance that suits the terrain that a line and the next, `distance_m` further, see.
    ///
    /// # Errors
    /// The terrain reaches the camera.
    pub(super) fn distance_m(&self, courses: [&Course; 2], across_m: f64, distance_m: f64) -> Result<f64, InputError> {
        let (nominal_m, footprint_m) = (self.view.nominal_m(&self.overlaps)[1], self.view.footprint_m[1]);
        let mut suits_m = f64::INFINITY;
        for section in self.sections(courses, across_m, distance_m) {
            let highest_m = self.terrain.highest_in(&self.axes, &section.zone);
            for rise_m in section.pairs() {
                suits_m = suits_m.min(self.view.wanted(rise_m, highest_m)?.suits_m(nominal_m, footprint_m));
            }
        }
        Ok(suits_m)
    }

    /// Overlap of a line with the next, each on its course.
    #[must_use]
    pub fn side_overlap_on(&self, courses: [&Course; 2], across_m: f64, distance_m: f64) -> f64 {
        let of_section = |section: Section| {
            let highest_m = self.terrain.highest_in(&self.axes, &section.zone);
            let overlap = |rise_m| self.view.pair(rise_m, highest_m).overlap(distance_m, self.view.footprint_m[1]);
            section.pairs().map(overlap).fold(f64::INFINITY, f64::min)
        };
        self.sections(courses, across_m, distance_m).into_iter().map(of_section).fold(f64::INFINITY, f64::min)
    }

    /// Two lines cut into sections of half a nominal base. A section is seen by photos of both lines that lie within half a base of it, so
    /// each line's heights count that far around it. At level heights all of a line is one section.
    fn sections(&self, courses: [&Course; 2], across_m: f64, distance_m: f64) -> Vec<Section> {
        let (view, planned_m) = (&self.view, self.planned_m(across_m));
        let whole = view.side_zone(across_m, distance_m, planned_m);
        if courses.iter().all(|course| course.is_level()) {
            return vec![Section { zone: whole, rise_m: [[0.0; 2]; 2] }];
        }
        let half_base_m = 0.5 * view.nominal_m(&self.overlaps)[0];
        let [from_m, to_m] = whole.along;
        let count = ((to_m - from_m) / half_base_m).ceil().max(1.0);
        let at = |k: f64| from_m + (to_m - from_m) * k / count;
        let section = |k: usize| {
            let along = [at(k as f64), at(k as f64 + 1.0)];
            let around =
                [along[0] - half_base_m, along[1] + half_base_m].map(|at| at.clamp(planned_m[0], planned_m[1]));
            let rise_m = courses.map(|course| course.range_m(around));
            let low_m = rise_m[0][0].min(rise_m[1][0]);
            let [near_m, far_m] = rise_m.map(|[_, high]| view.half_m(1, high - low_m));
            let across = [across_m + distance_m - far_m, across_m + near_m];
            Section { zone: Zone { along, across }, rise_m }
        };
        (0..count as usize).map(section).collect()
    }
}
