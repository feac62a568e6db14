//! Courses against the ground they follow, looked at post by post and ray by ray, apart from how they are made.

use super::*;
use crate::dem::Dem;
use crate::plan::area::Area;
use crate::plan::axes::Axes;
use crate::plan::checks::Turns;
use crate::plan::flown::{Leg, flown};
use crate::plan::lines::{Overlaps, Strip, View};
use crate::plan::terrain::Terrain;

const HEIGHT_M: f64 = 300.0;
const HALF: [f64; 2] = [0.36, 0.54];
const FOLLOW: Follow = Follow { tolerance_m: 12.0, climb: 0.15, lead_m: 60.0 };

/// Hills with gullies across and a scarp, 201 x 151 posts of 20 m.
fn rough() -> Dem {
    Dem::from_fn((201, 151), [-500.0, -400.0], [20.0; 2], |x, y| {
        let hills = 120.0 * (x / 400.0).sin() * (y / 300.0).cos() + 0.08 * x;
        let gully = -40.0 * (-((x + 0.5 * y - 1500.0) / 60.0).powi(2)).exp();
        let scarp = if y > 900.0 + 0.2 * x { 70.0 } else { 0.0 };
        400.0 + hills + gully + scarp
    })
}

fn layout<'t>(terrain: &'t Terrain<'t>, heading_deg: f64, follow: Option<Follow>) -> Layout<'t> {
    let area = Area::new(&[[200.0, 200.0], [2600.0, 200.0], [2600.0, 1700.0], [200.0, 1700.0]]).expect("an area");
    let axes = Axes::new(heading_deg);
    Layout {
        terrain,
        axes,
        area: area.mapped(|corner| axes.of(corner)),
        view: View { height_m: HEIGHT_M, base_height_m: 450.0, footprint_m: HALF.map(|half| 2.0 * half * HEIGHT_M) },
        overlaps: Overlaps { forward: 0.7, side: 0.4 },
        follow,
    }
}

fn up_m(layout: &Layout<'_>, strip: &Strip, along_m: f64) -> f64 {
    layout.view.base_height_m + HEIGHT_M + strip.course.rise_m(along_m)
}

#[test]
fn heights_above_the_ground_keep_the_tolerance_and_ways_the_climb() {
    let dem = rough();
    let terrain = Terrain::new(&dem);
    for (heading_deg, follow) in
        [(90.0, FOLLOW), (0.0, FOLLOW), (37.0, FOLLOW), (90.0, Follow { climb: 5.0, ..FOLLOW })]
    {
        let layout = layout(&terrain, heading_deg, Some(follow));
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        for strip in &layout.variable().expect("laid") {
            let ends = [strip.along_m[0] - follow.lead_m, strip.along_m[strip.along_m.len() - 1] + follow.lead_m];
            let steps = 4000;
            let at = |step: usize| ends[0] + (ends[1] - ends[0]) * step as f64 / steps as f64;
            for step in 0..steps {
                let [x, y] = layout.axes.point([at(step), strip.across_m]);
                let above = up_m(&layout, strip, at(step)) - dem.height(x, y).expect("known");
                (lowest, highest) = (lowest.min(above), highest.max(above));
                let climbed = up_m(&layout, strip, at(step + 1)) - up_m(&layout, strip, at(step));
                assert!(climbed.abs() <= follow.climb * (at(step + 1) - at(step)) + 1e-6, "{heading_deg} {}", at(step));
            }
        }
        // Between a crossing and the middle bilinear ground bends by no more than 0.05 m here.
        assert!(lowest > HEIGHT_M - follow.tolerance_m - 0.05, "{heading_deg}: {lowest}");
        // Where the climb allows it, no part of a strip but its ends is higher than the tolerance.
        assert!(highest > HEIGHT_M + follow.tolerance_m || follow.climb > 1.0, "{heading_deg}: {highest}");
    }
}

#[test]
fn no_turn_is_steeper_than_the_climb() {
    let dem = rough();
    let terrain = Terrain::new(&dem);
    for heading_deg in [90.0, 37.0] {
        let layout = layout(&terrain, heading_deg, Some(FOLLOW));
        let strips = layout.variable().expect("laid");
        let legs: Vec<Leg<'_>> = flown(&strips).collect();
        for pair in legs.windows(2) {
            let (left, entered) = (pair[0].led(FOLLOW.lead_m)[1], pair[1].led(FOLLOW.lead_m)[0]);
            let turn = Turns { radius_m: FOLLOW.lead_m }.turn_m(pair[1].strip.across_m - pair[0].strip.across_m);
            let climbed = up_m(&layout, pair[1].strip, entered) - up_m(&layout, pair[0].strip, left);
            let way = turn + (entered - left).abs();
            assert!(climbed.abs() <= FOLLOW.climb * way, "{heading_deg}: {climbed} m over {way} m");
        }
    }
}

/// Whether a photo at `[along, across, up]` sees a ground point, terrain in between left aside.
fn sees(photo: [f64; 3], point: [f64; 2], ground: f64) -> bool {
    (0..2).all(|axis| (point[axis] - photo[axis]).abs() <= HALF[axis] * (photo[2] - ground))
}

/// What two photos over level ground at this height have in common along an axis, as a share of the larger one.
fn share(a: [f64; 3], b: [f64; 3], axis: usize, ground: f64) -> f64 {
    let [one, other] = [a, b].map(|photo| {
        let half = HALF[axis] * (photo[2] - ground);
        [photo[axis] - half, photo[axis] + half]
    });
    (one[1].min(other[1]) - one[0].max(other[0])) / (one[1] - one[0]).max(other[1] - other[0])
}

#[test]
fn the_overlap_is_kept_on_every_ground_point_that_both_see() {
    let dem = rough();
    let terrain = Terrain::new(&dem);
    for heading_deg in [90.0, 37.0] {
        let layout = layout(&terrain, heading_deg, Some(FOLLOW));
        let strips = layout.variable().expect("laid");
        let achieved = layout.achieved(&strips);
        let photo = |strip: &Strip, at: f64| [at, strip.across_m, up_m(&layout, strip, at)];
        let mut least = [f64::INFINITY; 2];
        for (k, strip) in strips.iter().enumerate() {
            for pair in strip.along_m.windows(2) {
                let next = strips.get(k + 1).and_then(|next| {
                    let beside =
                        next.along_m.iter().min_by(|a, b| (*a - pair[0]).abs().total_cmp(&(*b - pair[0]).abs()));
                    beside.map(|at| photo(next, *at))
                });
                let here = photo(strip, pair[0]);
                for (axis, other) in [(0, Some(photo(strip, pair[1]))), (1, next)] {
                    let Some(other) = other else { continue };
                    for point in (0..400).map(|k| [f64::from(k % 20) / 19.0 - 0.5, f64::from(k / 20) / 19.0 - 0.5]) {
                        let at = [here[0] + 260.0 * point[0], here[1] + 420.0 * point[1]];
                        let [x, y] = layout.axes.point(at);
                        let Some(ground) = dem.height(x, y) else { continue };
                        if sees(here, at, ground) && sees(other, at, ground) {
                            least[axis] = least[axis].min(share(here, other, axis, ground));
                        }
                    }
                }
            }
        }
        assert!(least[0] >= 0.7 - 1e-9 && least[1] >= 0.4 - 1e-9, "{heading_deg}: {least:?}");
        // What is stated is not far below what is found.
        let [forward, side] = [achieved.forward, achieved.side].map(|share| share.expect("pairs"));
        assert!(forward <= least[0] + 1e-9 && side <= least[1] + 1e-9, "{forward} {side} {least:?}");
        assert!(forward >= 0.7 - 1e-9 && side >= 0.4 - 1e-9, "{forward} {side}");
    }
}

#[test]
fn over_level_ground_following_changes_nothing() {
    let dem = Dem::from_fn((201, 151), [-500.0, -400.0], [20.0; 2], |_, _| 450.0);
    let terrain = Terrain::new(&dem);
    let level = layout(&terrain, 90.0, None).variable().expect("laid");
    let follow = layout(&terrain, 90.0, Some(FOLLOW)).variable().expect("laid");
    assert_eq!(level.len(), follow.len());
    for (a, b) in level.iter().zip(&follow) {
        assert_eq!((a.across_m, &a.along_m), (b.across_m, &b.along_m));
        assert!(!b.course.is_level() && b.course.range_m([-1e4, 1e4]) == [0.0; 2]);
    }
}

#[test]
fn unknown_ground_is_taken_for_as_high_as_the_higher_side() {
    let mut profile = [[0.0, f64::NAN], [1.0, 5.0], [2.0, f64::NAN], [3.0, 9.0], [4.0, f64::NAN]];
    fill(&mut profile);
    assert_eq!(profile.map(|point| point[1]), [5.0, 5.0, 9.0, 9.0, 9.0]);
}
