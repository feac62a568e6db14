//! What a plan asks of aircraft and camera: height over the terrain, sharpness, time.

use super::clearance::{Part, nearest};
use super::file::Checks;
use super::flown::{Leg, flown};
use super::lines::{Layout, Strip};
use super::request::Request;
use super::terrain::{Terrain, Zone};
use crate::dem::Dem;
use crate::error::InputError;
use crate::io::raster::for_people;

/// Bank of a turn.
const BANK_DEG: f64 = 30.0;
const GRAVITY_M_S2: f64 = 9.81;
/// What a slope may be off by in its last digits.
const ROUNDING: f64 = 1e-6;
/// Smear that still counts as sharp, pixels.
pub const SHARP_PX: f64 = 0.5;

/// Turns of one radius: 30 degrees of bank in still air.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turns {
    /// v^2 / (g tan 30 deg).
    pub radius_m: f64,
}

impl Turns {
    /// At a speed.
    #[must_use]
    pub fn new(speed_m_s: f64) -> Self {
        Turns { radius_m: speed_m_s * speed_m_s / (GRAVITY_M_S2 * BANK_DEG.to_radians().tan()) }
    }

    /// Strips as they are flown, with the turns between them.
    #[must_use]
    pub fn length_m(&self, strips: &[Strip]) -> f64 {
        let legs: Vec<Leg<'_>> = flown(strips).collect();
        let along: f64 = legs.iter().map(|leg| (leg.to_m() - leg.from_m()).abs()).sum();
        along + legs.windows(2).map(|pair| self.between_m(&pair[0], &pair[1])).sum::<f64>()
    }

    /// From the end of a strip to the start of the next.
    fn between_m(&self, left: &Leg<'_>, entered: &Leg<'_>) -> f64 {
        let straight_m = (entered.from_m() - left.to_m()).abs();
        // Parts of one line follow each other without a turn.
        let is_on_line = left.strip.line == entered.strip.line;
        let across_m = entered.strip.across_m - left.strip.across_m;
        if is_on_line { straight_m } else { self.turn_m(across_m) + straight_m }
    }

    /// Half a turn onto a line at a distance: two quarters and a straight, or, where the line is nearer than a diameter,
    /// out, around and in by three arcs that touch.
    #[must_use]
    pub fn turn_m(&self, distance_m: f64) -> f64 {
        let (radius_m, distance_m) = (self.radius_m, distance_m.abs());
        let half_turn_m = std::f64::consts::PI * radius_m;
        if distance_m >= 2.0 * radius_m {
            return half_turn_m + distance_m - 2.0 * radius_m;
        }
        half_turn_m + 4.0 * radius_m * ((2.0 * radius_m + distance_m) / (4.0 * radius_m)).acos()
    }
}

impl Checks {
    /// Why the flight is not safe, if it is not, in one sentence: the first of [`Self::dangers`].
    #[must_use]
    pub fn unsafe_because(&self) -> Option<String> {
        self.dangers().into_iter().next()
    }

    /// Whether the clearance is nowhere but over ground that is known.
    #[must_use]
    pub fn is_clearance_known(&self) -> bool {
        !self.leaves_model && self.strips_off_dem == 0 && !self.passes_unknown
    }

    /// How much the model's highest ground would leave beyond the model, metres, where that is less than is wanted.
    #[must_use]
    pub fn near_beyond_m(&self) -> Option<f64> {
        self.beyond_m.filter(|beyond_m| *beyond_m < self.clearance_wanted_m)
    }

    /// What is not safe, the worst first: the heights are probably none, the clearance that was asked for is not there, or nobody knows it, or the vehicle does not climb to
    /// it in time.
    #[must_use]
    pub fn dangers(&self) -> Vec<String> {
        let mut dangers: Vec<String> = self.heights_doubt.iter().map(|doubt| doubt.why().to_owned()).collect();
        let (least_m, wanted_m) = (self.clearance_min_m, self.clearance_wanted_m);
        if least_m < wanted_m {
            let least = if least_m > 0.0 {
                format!("the flight passes {least_m:.1} m above the terrain")
            } else {
                format!("the terrain rises {:.1} m above the flying height", -least_m)
            };
            dangers.push(format!(
                "{least} beside the strips or under the turns, less than --min-clearance-m {wanted_m}{}: flown {:.0} m higher it is kept there",
                self.nearest.map_or_else(String::new, |nearest| format!(
                    ", on {} near x {}, y {}, where the ground is at {:.1} m",
                    nearest.part(),
                    for_people(nearest.x),
                    for_people(nearest.y),
                    nearest.ground_m
                )),
                (wanted_m - least_m).ceil()
            ));
        }
        if self.strips_off_dem > 0 {
            dangers.push(format!(
                "{} of the strips leave the elevation model, so the clearance there is not known: it takes a larger elevation model or a smaller area",
                self.strips_off_dem
            ));
        }
        if let Some(beyond_m) = self.near_beyond_m().filter(|_| self.strips_off_dem == 0) {
            dangers.push(format!(
                "the ends of strips or the turns reach beyond the elevation model, where the ground is not known: as high as the model's highest it \
                 leaves {beyond_m:.1} m, less than --min-clearance-m {wanted_m}; it takes a larger elevation model, a smaller area or, for narrower \
                 turns, a lower --speed-m-s"
            ));
        }
        if self.passes_unknown {
            dangers.push(
                "the elevation model has posts without a height beside the strips or under the turns, so the clearance there is not known: it \
                 takes a model without such holes or an area farther from them"
                    .to_owned(),
            );
        }
        if self.climb_wanted_percent > 0.0 && self.climb_percent > self.climb_wanted_percent * (1.0 + ROUNDING) {
            dangers.push(format!(
                "the height changes by {:.1} % of the way from one strip to the next, more than --climb-percent {}",
                self.climb_percent, self.climb_wanted_percent
            ));
        }
        dangers
    }

    /// Of strips.
    ///
    /// # Errors
    /// The terrain reaches the flying height within sight of the strips.
    pub(super) fn new(layout: &Layout<'_>, strips: &[Strip], request: &Request) -> Result<Self, InputError> {
        let turns = Turns::new(request.limits.speed_m_s);
        let length_m = turns.length_m(strips);
        let way = Way::new(layout, strips, &turns);
        let unknown = unknown_posts(layout);
        let unknown = unknown.as_ref().map(Terrain::new);
        let passes_unknown = unknown
            .as_ref()
            .is_some_and(|unknown| way.parts.iter().any(|part| unknown.highest_in(&layout.axes, &part.zone).is_some()));
        let nearest = nearest(layout, &way.parts);
        let nearest_m = nearest_m(layout, strips, request.min_clearance_m)?;
        let px_per_s = request.limits.speed_m_s / (request.tangent_per_px[0] * nearest_m);
        Ok(Checks {
            clearance_min_m: nearest
                .map_or_else(|| way.over_base_m(layout), |nearest| nearest.flown_m - nearest.ground_m),
            nearest,
            smear_px: px_per_s * request.exposure_s,
            exposure_s: request.exposure_s,
            exposure_max_s: SHARP_PX / px_per_s,
            length_m,
            flight_time_s: length_m / request.limits.speed_m_s,
            turn_radius_m: turns.radius_m,
            photos_beyond_dem: beyond_dem(layout, strips, unknown.as_ref()),
            clearance_wanted_m: request.min_clearance_m,
            passes_unknown,
            leaves_model: way.parts.iter().any(|part| is_outside(layout, &part.zone)),
            beyond_m: way.beyond_m(layout),
            strips_off_dem: strips.iter().filter(|strip| is_off_dem(layout, strip)).count(),
            climb_percent: 100.0 * way.climb,
            climb_wanted_percent: request.follow.map_or(0.0, |follow| 100.0 * follow.climb),
            heights_doubt: None,
        })
    }
}

/// A strip, longer by `beyond_m` and wider by `aside_m` on all sides.
fn around(strip: &Strip, beyond_m: f64, aside_m: f64) -> Zone {
    let along_m = &strip.along_m;
    Zone {
        along: [along_m[0] - beyond_m, along_m[along_m.len() - 1] + beyond_m],
        across: [strip.across_m - aside_m, strip.across_m + aside_m],
    }
}

/// Where the aircraft may be, and how low at least; how steeply it climbs or descends.
struct Way {
    parts: Vec<Part>,
    climb: f64,
}

impl Way {
    /// Along the strips with a radius to all sides, and from the end of each to the start of the next. A turn onto a near line
    /// swings out by up to 1 + sqrt(3) radii.
    fn new(layout: &Layout<'_>, strips: &[Strip], turns: &Turns) -> Self {
        let (view, radius_m) = (&layout.view, turns.radius_m);
        let swing_m = (1.0 + 3.0_f64.sqrt()) * radius_m;
        let mut way = Way { parts: Vec::new(), climb: 0.0 };
        let legs: Vec<Leg<'_>> = flown(strips).collect();
        for (leg, strip) in legs.iter().map(|leg| leg.strip).enumerate() {
            let of_strip = along(layout, strip, radius_m).into_iter();
            way.parts.extend(of_strip.map(|(zone, up_m)| Part { zone, up_m, leg, is_turn: false }));
            let Zone { along: [from_m, to_m], .. } = around(strip, radius_m, 0.0);
            way.climb = way.climb.max(strip.course.steepest(from_m, to_m));
        }
        for (leg, pair) in legs.windows(2).enumerate() {
            let ([from, to], [one, other]) =
                ([pair[0].to_m(), pair[1].from_m()], [pair[0].strip.across_m, pair[1].strip.across_m]);
            let zone = Zone {
                along: [from.min(to) - swing_m, from.max(to) + swing_m],
                across: [one.min(other) - radius_m, one.max(other) + radius_m],
            };
            let ends = [pair[0].led(radius_m)[1], pair[1].led(radius_m)[0]];
            let [left_m, entered_m] = [0, 1].map(|k| pair[k].strip.course.rise_m(ends[k]));
            way.parts.push(Part { zone, up_m: view.up_m(left_m.min(entered_m)), leg, is_turn: true });
            way.climb = way.climb.max((left_m - entered_m).abs() / turns.between_m(&pair[0], &pair[1]));
        }
        way
    }

    /// Least height beyond the model above its highest ground.
    fn beyond_m(&self, layout: &Layout<'_>) -> Option<f64> {
        let beyond = self.parts.iter().filter(|part| is_outside(layout, &part.zone));
        let lowest_m = beyond.map(|part| part.up_m).reduce(f64::min)?;
        Some(lowest_m - layout.terrain.highest()?)
    }

    /// Height over the base plane, where nothing is known of the ground.
    fn over_base_m(&self, layout: &Layout<'_>) -> f64 {
        let lowest_m = self.parts.iter().map(|part| part.up_m).fold(f64::INFINITY, f64::min);
        lowest_m - layout.view.base_height_m
    }
}

/// A strip in parts, each with its lowest height: at one height it is one, and where the ground is followed they are as long as a step of
/// the model.
fn along(layout: &Layout<'_>, strip: &Strip, radius_m: f64) -> Vec<(Zone, f64)> {
    let whole = around(strip, radius_m, radius_m);
    let [from_m, to_m] = whole.along;
    let [dx, dy] = layout.terrain.dem().step_m;
    let count = if strip.course.is_level() { 1.0 } else { ((to_m - from_m) / dx.min(dy)).ceil().max(1.0) };
    let at = |k: usize| from_m + (to_m - from_m) * k as f64 / count;
    let part = |k: usize| {
        let along = [at(k), if k as f64 + 1.0 == count { to_m } else { at(k + 1) }];
        (Zone { along, ..whole }, layout.view.up_m(strip.course.range_m(along)[0]))
    };
    (0..count as usize).map(part).collect()
}

/// The least height of a photo above the highest terrain that it may see, which is nowhere lower than H below it.
///
/// # Errors
/// The terrain reaches the flying height there.
fn nearest_m(layout: &Layout<'_>, strips: &[Strip], clearance_m: f64) -> Result<f64, InputError> {
    let view = &layout.view;
    let [half_along, half_across] = view.footprint_m.map(|side| 0.5 * side);
    let depth_m = |zone: Zone, up_m: f64| {
        let highest_m = layout.terrain.highest_in(&layout.axes, &zone);
        (up_m - highest_m.unwrap_or(f64::NEG_INFINITY).max(up_m - view.height_m), up_m)
    };
    let of_strip = |strip: &Strip| {
        let whole = around(strip, half_along, half_across);
        if strip.course.is_level() {
            return depth_m(whole, view.up_m(0.0));
        }
        let of_photo =
            |(at, up_m): (&f64, f64)| depth_m(Zone { along: [at - half_along, at + half_along], ..whole }, up_m);
        let all = strip.along_m.iter().zip(view.ups_m(strip)).map(of_photo);
        all.fold((f64::INFINITY, 0.0), |least, one| if one.0 < least.0 { one } else { least })
    };
    let least = strips.iter().map(of_strip).reduce(|least, one| if one.0 < least.0 { one } else { least });
    match least.unwrap_or((view.height_m, 0.0)) {
        (nearest_m, _) if nearest_m > 0.0 => Ok(nearest_m),
        (nearest_m, up_m) => Err(InputError::new(format!(
            "the terrain within sight of the strips rises to {:.1} m, above the flying height of {up_m:.1} m: --height-m {:.0} passes it by \
             --min-clearance-m {clearance_m}",
            up_m - nearest_m,
            (view.height_m + clearance_m - nearest_m).ceil()
        ))),
    }
}

/// Whether a strip leaves the model: all of its photos, or two that follow each other, are taken beyond it. The one by which a strip overshoots
/// the area is on the way of the turn.
fn is_off_dem(layout: &Layout<'_>, strip: &Strip) -> bool {
    let across = [strip.across_m; 2];
    let is_off: Vec<bool> =
        strip.along_m.iter().map(|at| is_outside(layout, &Zone { along: [*at; 2], across })).collect();
    is_off.iter().all(|is_off| *is_off) || is_off.windows(2).any(|pair| pair[0] && pair[1])
}

/// Whether a zone reaches beyond the model, whose outermost posts stand for half a step around them.
fn is_outside(layout: &Layout<'_>, zone: &Zone) -> bool {
    let dem = layout.terrain.dem();
    let ([x0, y0, x1, y1], [dx, dy]) = (dem.bounds(), dem.step_m.map(|step| 0.5 * step));
    let corners = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| layout.axes.point([zone.along[i], zone.across[j]]));
    corners.iter().any(|[x, y]| *x < x0 - dx || *x > x1 + dx || *y < y0 - dy || *y > y1 + dy)
}

/// A model in which the posts stand out of which nothing is known; `None` where all are.
fn unknown_posts(layout: &Layout<'_>) -> Option<Dem> {
    let dem = layout.terrain.dem();
    dem.heights.iter().any(|height| height.is_nan()).then(|| {
        let heights = dem.heights.iter().map(|height| if height.is_nan() { 1.0 } else { f64::NAN });
        Dem { heights: heights.collect(), ..*dem }
    })
}

/// Photos whose footprints on the base plane reach beyond the outermost posts or hold one whose height is unknown.
fn beyond_dem(layout: &Layout<'_>, strips: &[Strip], unknown: Option<&Terrain<'_>>) -> usize {
    let dem = layout.terrain.dem();
    let [x0, y0, x1, y1] = dem.bounds();
    let [half_along, half_across] = layout.view.footprint_m.map(|side| 0.5 * side);
    let is_beyond = |along: f64, across: f64| {
        let footprint = Zone {
            along: [along - half_along, along + half_along],
            across: [across - half_across, across + half_across],
        };
        let corners =
            [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| layout.axes.point([footprint.along[i], footprint.across[j]]));
        corners.iter().any(|[x, y]| *x < x0 || *x > x1 || *y < y0 || *y > y1)
            || unknown.is_some_and(|unknown| unknown.highest_in(&layout.axes, &footprint).is_some())
    };
    strips.iter().map(|strip| strip.along_m.iter().filter(|along| is_beyond(**along, strip.across_m)).count()).sum()
}

#[cfg(test)]
mod tests {
    use super::super::course::Course;
    use super::*;

    #[test]
    fn a_turn_onto_the_same_line_is_five_thirds_of_a_circle_and_a_wide_one_a_half() {
        let turns = Turns { radius_m: 100.0 };
        let pi = std::f64::consts::PI;
        // Distance 0: each of the outer arcs is 60 degrees and the inner one 300.
        assert!((turns.turn_m(0.0) - 100.0 * (420.0_f64).to_radians()).abs() < 1e-9);
        assert!((turns.turn_m(200.0) - 100.0 * pi).abs() < 1e-9);
        assert!((turns.turn_m(-500.0) - (100.0 * pi + 300.0)).abs() < 1e-9);
        // 30 m/s at 30 degrees of bank.
        assert!((Turns::new(30.0).radius_m - 158.9).abs() < 0.1);
    }

    #[test]
    fn strips_are_flown_there_and_back() {
        let strip = |line, across_m, along_m: &[f64]| Strip {
            line,
            across_m,
            along_m: along_m.to_vec(),
            course: Course::default(),
        };
        let strips = [strip(0, 0.0, &[0.0, 100.0]), strip(0, 0.0, &[300.0, 400.0]), strip(1, 50.0, &[0.0, 450.0])];
        let turns = Turns { radius_m: 10.0 };
        let turn = 10.0 * std::f64::consts::PI + 30.0;
        assert!((turns.length_m(&strips) - (100.0 + 200.0 + 100.0 + 50.0 + turn + 450.0)).abs() < 1e-9);
    }
}
