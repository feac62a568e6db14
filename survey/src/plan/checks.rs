//! What a plan asks of aircraft and camera: height over the terrain, sharpness, time.

use super::flown::{Leg, flown};
use super::lines::{Layout, Strip};
use super::planner::Request;
use super::relief::Zone;
use crate::error::InputError;

/// Bank of a turn.
const BANK_DEG: f64 = 30.0;
const GRAVITY_M_S2: f64 = 9.81;
/// Smear that still counts as sharp, pixels.
const SHARP_PX: f64 = 0.5;

/// Clearance, blur, time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Checks {
    /// Least height above the terrain along strips and turns, a turn's radius to both sides.
    pub clearance_min_m: f64,
    /// How far the picture moves during an exposure over the highest terrain in sight, pixels along.
    pub smear_px: f64,
    /// Longest exposure that keeps it within half a pixel.
    pub exposure_max_s: f64,
    /// Strips and turns.
    pub length_m: f64,
    /// Time for them.
    pub flight_time_s: f64,
    /// Radius of the turns.
    pub turn_radius_m: f64,
    /// Photos whose frames look beyond the elevation model.
    pub photos_beyond_dem: usize,
}

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
        let between = legs.windows(2).map(|pair| {
            let straight_m = (pair[1].from_m() - pair[0].to_m()).abs();
            // Parts of one line follow each other without a turn.
            let is_on_line = pair[0].strip.line == pair[1].strip.line;
            let across_m = pair[1].strip.across_m - pair[0].strip.across_m;
            if is_on_line { straight_m } else { self.turn_m(across_m) + straight_m }
        });
        along + between.sum::<f64>()
    }

    /// Half a turn onto a line at a distance: two quarters and a straight, or, where the line is nearer than a diameter, out, around
    /// and in by three arcs that touch.
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
    /// Of strips.
    ///
    /// # Errors
    /// The terrain reaches the flying height on the way.
    pub(super) fn new(layout: &Layout<'_>, strips: &[Strip], request: &Request) -> Result<Self, InputError> {
        let view = &layout.view;
        let altitude_m = view.base_height_m + view.height_m;
        let turns = Turns::new(request.limits.speed_m_s);
        let length_m = turns.length_m(strips);
        let zone = |strip: &Strip, beyond_m: f64, aside_m: f64| Zone {
            along: [strip.along_m[0] - beyond_m, strip.along_m[strip.along_m.len() - 1] + beyond_m],
            across: [strip.across_m - aside_m, strip.across_m + aside_m],
        };
        let highest_of = |beyond_m: f64, aside_m: f64| {
            let zones = strips.iter().map(|strip| zone(strip, beyond_m, aside_m));
            zones.filter_map(|zone| layout.relief.highest_in(&layout.axes, &zone)).reduce(f64::max)
        };
        let base_m = view.base_height_m;
        let on_the_way_m = highest_of(2.0 * turns.radius_m, turns.radius_m).unwrap_or(base_m);
        if on_the_way_m >= altitude_m {
            return Err(InputError::new(format!(
                "the terrain rises to {on_the_way_m:.1} m beside the strips or under the turns, above the flying height of {altitude_m:.1} m"
            )));
        }
        let [half_along, half_across] = view.footprint_m.map(|side| 0.5 * side);
        let nearest_m = altitude_m - highest_of(half_along, half_across).unwrap_or(base_m).max(base_m);
        let px_per_s =
            request.limits.speed_m_s / (2.0 * request.half_tangent[0] * nearest_m / f64::from(request.pixels[0]));
        Ok(Checks {
            clearance_min_m: altitude_m - on_the_way_m,
            smear_px: px_per_s * request.exposure_s,
            exposure_max_s: SHARP_PX / px_per_s,
            length_m,
            flight_time_s: length_m / request.limits.speed_m_s,
            turn_radius_m: turns.radius_m,
            photos_beyond_dem: beyond_dem(layout, strips),
        })
    }
}

/// Photos of which a corner's footprint on the base plane lies beyond the outermost posts.
fn beyond_dem(layout: &Layout<'_>, strips: &[Strip]) -> usize {
    let [x0, y0, x1, y1] = layout.relief.dem().bounds();
    let [half_along, half_across] = layout.view.footprint_m.map(|side| 0.5 * side);
    let is_beyond = |along: f64, across: f64| {
        [[-1.0, -1.0], [-1.0, 1.0], [1.0, -1.0], [1.0, 1.0]].iter().any(|[i, j]| {
            let [x, y] = layout.axes.point([along + i * half_along, across + j * half_across]);
            x < x0 || x > x1 || y < y0 || y > y1
        })
    };
    strips.iter().map(|strip| strip.along_m.iter().filter(|along| is_beyond(**along, strip.across_m)).count()).sum()
}

#[cfg(test)]
mod tests {
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
        let strip = |line, across_m, along_m: &[f64]| Strip { line, across_m, along_m: along_m.to_vec() };
        let strips = [strip(0, 0.0, &[0.0, 100.0]), strip(0, 0.0, &[300.0, 400.0]), strip(1, 50.0, &[0.0, 450.0])];
        let turns = Turns { radius_m: 10.0 };
        let turn = 10.0 * std::f64::consts::PI + 30.0;
        assert!((turns.length_m(&strips) - (100.0 + 200.0 + 100.0 + 50.0 + turn + 450.0)).abs() < 1e-9);
    }
}
