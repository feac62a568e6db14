//! Strips and exposures of given overlaps: variable bases by the monotone fixed point (paper 004, 1.3 and 1.4).
//!
//! A pair's base is shortened until it suits the highest terrain in the overlap of its own footprints: B <- min(B, B0 (1 -
//! dh(zone(B)) / H)). A shorter base has a larger zone, so the sequence only falls, and where it ends the overlap on the ground
//! is nowhere below the wish. The paper takes the zone of the base it started from, which may miss terrain that the final one
//! sees (an eighth of all pairs fall short), and for the distance of two strips only their first photos'; here it is the
//! whole strip's.

use super::area::{Area, merged};
use super::axes::Axes;
use super::course::{Course, Follow};
use super::terrain::{Terrain, Zone};
use crate::error::InputError;

/// Most photos of a plan.
const PHOTOS_MAX: usize = 500_000;
/// Positions this close to an end have reached it: sums of bases that divide an area exactly are off by rounding.
pub(super) const END_M: f64 = 1e-6;
/// Steps of a fixed point; each takes in more of the terrain, and a handful is usual.
const STEPS_MAX: usize = 10_000;
/// Share of the nominal bases and distances below which there is no plan.
const SHORTEST: f64 = 1e-3;

/// What a camera sees from its height.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct View {
    /// Height above the base plane, H.
    pub height_m: f64,
    /// Height of the base plane above the height datum.
    pub base_height_m: f64,
    /// Footprint on the base plane, along and across: l m.
    pub footprint_m: [f64; 2],
}

/// Overlaps as shares of a footprint on the ground, at least 0 and below 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlaps {
    /// Along a strip, q.
    pub forward: f64,
    /// Between strips, p.
    pub side: f64,
}

/// A run of exposures on one line.
#[derive(Debug, Clone, PartialEq)]
pub struct Strip {
    /// Number of the line, from 0.
    pub line: usize,
    /// Place across.
    pub across_m: f64,
    /// Positions along, ascending.
    pub along_m: Vec<f64>,
    /// How high it is flown.
    pub course: Course,
}

impl View {
    /// Height above the height datum of a flight at a height above the level one.
    #[must_use]
    pub fn up_m(&self, rise_m: f64) -> f64 {
        self.base_height_m + self.height_m + rise_m
    }

    /// Heights of a strip's photos above the height datum.
    pub fn ups_m<'s>(&self, strip: &'s Strip) -> impl Iterator<Item = f64> + use<'s> {
        let view = *self;
        strip.along_m.iter().map(move |along_m| view.up_m(strip.course.rise_m(*along_m)))
    }

    /// Half a footprint over the height, along and across.
    #[must_use]
    pub fn half_tangent(&self) -> [f64; 2] {
        self.footprint_m.map(|side| 0.5 * side / self.height_m)
    }

    /// Base and distance of strips on the base plane: (1 - q) l m.
    #[must_use]
    pub fn nominal_m(&self, overlaps: &Overlaps) -> [f64; 2] {
        [(1.0 - overlaps.forward) * self.footprint_m[0], (1.0 - overlaps.side) * self.footprint_m[1]]
    }

    /// Where two photos of a strip, at `along_m` and a base further, overlap on the base plane.
    #[must_use]
    pub fn forward_zone(&self, along_m: f64, base_m: f64, across_m: f64) -> Zone {
        let [half_along, half_across] = self.footprint_m.map(|side| 0.5 * side);
        Zone {
            along: [along_m + base_m - half_along, along_m + half_along],
            across: [across_m - half_across, across_m + half_across],
        }
    }

    /// Where two strips, at `across_m` and a distance further, overlap on the base plane, over the range that `planned_m` says.
    #[must_use]
    pub fn side_zone(&self, across_m: f64, distance_m: f64, planned_m: [f64; 2]) -> Zone {
        let [half_along, half_across] = self.footprint_m.map(|side| 0.5 * side);
        Zone {
            along: [planned_m[0] - half_along, planned_m[1] + half_along],
            across: [across_m + distance_m - half_across, across_m + half_across],
        }
    }
}

/// Strips over an area.
#[derive(Debug)]
pub struct Layout<'a> {
    /// The terrain.
    pub terrain: &'a Terrain<'a>,
    /// The strips' axes.
    pub axes: Axes,
    /// The area in `[along, across]`.
    pub area: Area,
    /// What the camera sees.
    pub view: View,
    /// What is wanted.
    pub overlaps: Overlaps,
    /// How the flying height follows the ground; `None` is one height for all.
    pub follow: Option<Follow>,
}

impl Layout<'_> {
    /// The strips with variable bases and distances, line by line. Lines begin on the area's edge and end on or beyond the
    /// other; each run begins a nominal base before the area and ends one or more beyond it.
    ///
    /// # Errors
    /// The terrain reaches the camera; more than half a million photos.
    pub fn variable(&self) -> Result<Vec<Strip>, InputError> {
        let [_, nominal_m] = self.view.nominal_m(&self.overlaps);
        let mut strips = Vec::new();
        let mut photos = 0;
        let [first_m, last_m] = self.across_m();
        let mut across_m = first_m;
        for line in 0.. {
            let course = self.course(across_m);
            for run in self.runs(across_m) {
                let along_m = self.exposures(&course, across_m, run, PHOTOS_MAX - photos)?;
                photos += along_m.len();
                strips.push(Strip { line, across_m, along_m, course: course.clone() });
            }
            if across_m >= last_m - END_M {
                break;
            }
            across_m += fixed_point(nominal_m, |distance_m| {
                self.distance_m([&course, &self.course(across_m + distance_m)], across_m, distance_m)
            })?;
        }
        Ok(strips)
    }

    /// Exposures of one run, from its low end.
    fn exposures(
        &self,
        course: &Course,
        across_m: f64,
        [from_m, to_m]: [f64; 2],
        most: usize,
    ) -> Result<Vec<f64>, InputError> {
        let [nominal_m, _] = self.view.nominal_m(&self.overlaps);
        let mut at_m = from_m;
        let mut along_m = vec![at_m];
        while at_m < to_m - END_M {
            at_m += fixed_point(nominal_m, |base_m| self.base_m(course, across_m, at_m, base_m))?;
            along_m.push(at_m);
            if along_m.len() > most {
                return Err(too_many());
            }
        }
        Ok(along_m)
    }

    /// First and last value across of the area.
    #[must_use]
    pub fn across_m(&self) -> [f64; 2] {
        let [_, low, _, high] = self.area.bounds();
        [low, high]
    }

    /// The runs of a line: where the area lies within its footprints on the base plane, longer by a nominal base at both
    /// ends, made one where they would come within a base of each other.
    #[must_use]
    pub fn runs(&self, across_m: f64) -> Vec<[f64; 2]> {
        let half_m = 0.5 * self.view.footprint_m[1];
        let [first_m, last_m] = self.across_m();
        // The last line may lie so far out that it sees the area no more: the edge counts.
        let band = [(across_m - half_m).min(last_m), (across_m + half_m).max(first_m)];
        self.beyond(self.area.ranges(band))
    }

    /// From the first to the last planned exposure on a line and on the next, wherever that will be.
    #[must_use]
    pub fn planned_m(&self, across_m: f64) -> [f64; 2] {
        let [_, nominal_m] = self.view.nominal_m(&self.overlaps);
        let half_m = 0.5 * self.view.footprint_m[1];
        let runs = self.beyond(self.area.ranges([across_m - half_m, across_m + nominal_m + half_m]));
        runs.first().zip(runs.last()).map_or([0.0, 0.0], |(first, last)| [first[0], last[1]])
    }

    pub(super) fn beyond(&self, ranges: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
        let [nominal_m, _] = self.view.nominal_m(&self.overlaps);
        // The last exposure of a part overshoots its end by up to a base, and the next part starts a base further at least.
        merged(ranges.into_iter().map(|[from, to]| [from - nominal_m, to + nominal_m]).collect(), 2.0 * nominal_m)
    }
}

/// The longest base or distance, found from the nominal one down, that is no longer than what suits it.
fn fixed_point(nominal_m: f64, suits: impl Fn(f64) -> Result<f64, InputError>) -> Result<f64, InputError> {
    let mut distance_m = nominal_m;
    for _ in 0..STEPS_MAX {
        let suits_m = suits(distance_m)?;
        if suits_m >= distance_m {
            return Ok(distance_m);
        }
        if suits_m <= SHORTEST * nominal_m {
            return Err(InputError::new(
                "bases or distances shrink to nothing: the terrain comes too near to the flying height, or heights that follow it change \
                 too steeply from line to line; fly higher, or try another --strip-heading-deg",
            ));
        }
        distance_m = suits_m;
    }
    Err(InputError::failed("the bases over this terrain do not settle"))
}

pub(super) fn too_many() -> InputError {
    InputError::new(format!(
        "the plan has more than {PHOTOS_MAX} photos; fly higher, ask for less overlap or part the area"
    ))
}

/// Photos of strips.
#[must_use]
pub fn photo_count(strips: &[Strip]) -> usize {
    strips.iter().map(|strip| strip.along_m.len()).sum()
}

/// Lines that strips lie on.
#[must_use]
pub fn line_count(strips: &[Strip]) -> usize {
    strips.last().map_or(0, |strip| strip.line + 1)
}
