//! Real frames: four nadir frames of a drone, rectified by the core with their own metadata, neighbours registered to
//! each other by the core's matcher.
//!
//! Two steps: the whole overlap at 0.5 m a pixel around the offset that GPS gives, then parts of 12 m at 0.2 m a pixel,
//! which is the largest patch on board (61 of 64 pixels), around the first result. The ground is no plane, so the parts
//! have offsets of their own; the offset of the pair is that of the plane through them at the middle of the overlap.

mod frames;
mod ground;
mod plane;
mod register;

use frames::{Exposure, FILES, STORED_TURN_DEG, exposures, picture};
use ground::Ground;
use plane::{Placed, Plane};
use plumbline_survey::io::data;
use plumbline_survey::io::picture::Picture;
use register::{Part, Registered, likeness, register};
use std::io::Write;
use std::path::PathBuf;

/// Pixels of the first and of the second step, metres.
const COARSE_M: f64 = 0.5;
/// See [`COARSE_M`].
const FINE_M: f64 = 0.2;
/// Search of both steps, pixels: the largest on board. 5 m, then 2 m.
const RADIUS_PX: u16 = 10;
/// Parts are this far apart, metres, and reach as far to each side.
const SPACING_M: f64 = 6.0;
/// How far GPS and picture may be apart over a base of 14 m, metres: GPS without corrections 1 m over 7 s; the focal
/// length, rounded to 2.5 %, 0.35 m; the height above the ground below instead of above the place of take-off, 3 m of
/// 40 m, 1.0 m; the heading, 2°, 0.5 m; two tilts to half a degree in flight, 0.5 m. Together 1.6 m, which the root mean
/// square of the pairs has to keep, each pair twice that.
const GPS_M: f64 = 1.6;
/// Root mean square of what two gimbal yaws are off against each other, degrees: each a degree, as a compass is.
const YAW_DEG: f64 = 1.4;
/// How well both directions of matching must agree, metres: a quarter of a fine pixel.
const AGREE_M: f64 = 0.05;

/// A line that shows without `--nocapture` too.
fn say(line: &str) {
    writeln!(std::io::stderr(), "{line}").expect("stderr takes a line");
}

/// The frames' folder, or `None` after one line.
fn folder(test: &str) -> Option<PathBuf> {
    data::for_test(test, "images/brighton")
}

/// Whole overlap, then parts.
struct Registration {
    whole: Registered,
    parts: Vec<Placed>,
    tried: usize,
    plane: Plane,
}

/// Registers the second of two frames to the first; each is given coarse and fine.
fn registered(a: &[Ground; 2], b: &[Ground; 2], gps_m: [f64; 2]) -> Registration {
    let whole = register(&a[0], &b[0], gps_m, &Part::WHOLE, RADIUS_PX).expect("texture");
    let places = (-6..=6).flat_map(|north| (-6..=6).map(move |east| [east, north].map(|i| SPACING_M * f64::from(i))));
    let (mut parts, mut tried) = (Vec::new(), 0);
    for place in places {
        let part = Part { centre_m: place, half_m: [SPACING_M; 2] };
        // Outside of the overlap there is nothing to search.
        let Ok(found) = register(&a[1], &b[1], whole.offset_m, &part, RADIUS_PX) else { continue };
        tried += 1;
        if found.located.accepted.is_ok() {
            parts.push((place, found));
        }
    }
    let plane = Plane::fit(&parts);
    Registration { whole, parts, tried, plane }
}

fn apart([a, b]: [f64; 2], [c, d]: [f64; 2]) -> f64 {
    (a - c).hypot(b - d)
}

fn against([east, north]: [f64; 2]) -> [f64; 2] {
    [-east, -north]
}

fn pictures(folder: &std::path::Path) -> Vec<(Exposure, Picture)> {
    exposures(folder).into_iter().zip(FILES.map(|file| picture(&folder.join(file)))).collect()
}

#[test]
fn neighbours_register_where_gps_and_gimbal_say() {
    let Some(folder) = folder("neighbours_register_where_gps_and_gimbal_say") else { return };
    let frames = pictures(&folder);
    let grounds: Vec<[Ground; 2]> = frames
        .iter()
        .map(|(exposure, picture)| {
            [COARSE_M, FINE_M].map(|resolution_m| Ground::new(picture, exposure, STORED_TURN_DEG, resolution_m))
        })
        .collect();
    let (mut turns_deg, mut offs_m) = (Vec::new(), Vec::new());
    for first in 0..3 {
        let [(a, _), (b, _)] = &frames[first..first + 2] else { unreachable!() };
        let names = format!("{} to {}", &FILES[first][4..8], &FILES[first + 1][4..8]);
        let gps_m = a.gps_offset_m(b);
        let there = registered(&grounds[first], &grounds[first + 1], gps_m);
        let back = registered(&grounds[first + 1], &grounds[first], against(gps_m));
        let offset_m = there.plane.offset_m;
        let likeness_at = |offset_m| likeness(&grounds[first][1], &grounds[first + 1][1], offset_m);
        let likenesses = [[0.0; 2], gps_m, offset_m].map(likeness_at);
        report(&names, [a, b], gps_m, [&there, &back], likenesses);

        for registration in [&there, &back] {
            let whole = &registration.whole;
            // Whether the whole overlap is accepted is stated, not demanded: relief makes it a match to be doubted. As
            // it is matched as if it were plane, it is good to the relief and the pixel.
            let from_plane_m = apart(whole.offset_m, registration.plane.offset_m);
            assert!(from_plane_m < COARSE_M, "{names}: the two steps are {from_plane_m:.2} m apart");
            // Objects above the ground are matched too, rightly, at offsets of their own.
            let off = registration.plane.residuals_m.iter().filter(|&&r| r > 0.5 * COARSE_M).count();
            assert!(4 * off <= registration.parts.len(), "{names}: {off} of {} are off", registration.parts.len());
        }
        let off_m = apart(offset_m, gps_m);
        assert!(off_m < 2.0 * GPS_M, "{names}: {off_m:.2} m from GPS");
        offs_m.push(off_m);
        for axis in [0, 1] {
            let sum_m = offset_m[axis] + back.plane.offset_m[axis];
            assert!(sum_m.abs() < AGREE_M, "{names}, axis {axis}: there and back leave {sum_m:.3} m");
        }
        let [without, by_gps, with] = likenesses;
        assert!(with > without + 0.1 && with > by_gps, "{names}: correlations {likenesses:?}");
        turns_deg.push(there.plane.turn_rad.to_degrees());
    }
    let rms = |values: &[f64]| (values.iter().map(|value| value * value).sum::<f64>() / values.len() as f64).sqrt();
    assert!(rms(&offs_m) < GPS_M, "{offs_m:.2?} m from GPS");
    assert!(rms(&turns_deg) < YAW_DEG, "the gimbal's yaw is off by {turns_deg:.2?} degrees from frame to frame");
}

/// What one pair gave.
fn report(
    names: &str,
    [a, b]: [&Exposure; 2],
    gps_m: [f64; 2],
    [there, back]: [&Registration; 2],
    likenesses: [f32; 3],
) {
    let plane = &there.plane;
    let [east, north] = plane.offset_m;
    let (length, angle) = (east.hypot(north) / gps_m[0].hypot(gps_m[1]), |v: [f64; 2]| v[0].atan2(v[1]).to_degrees());
    let slope = plane.rise_per_m.map(|rise| (rise * a.rel_alt_m).atan().to_degrees());
    let yaw = b.gimbal_deg[2] - a.gimbal_deg[2];
    let turn = plane.turn_rad.to_degrees();
    let whole = &there.whole;
    say(&format!(
        "{names}: GPS {:.2} {:.2} m, registered {east:.2} {north:.2} m (east north), difference {:.2} {:.2} m: \
         length {:+.1} %, direction {:+.1} deg; back {:.2} {:.2} m; gimbal yaw {yaw:+.1} deg, picture {:+.1} deg, \
         residual turn {turn:+.2} deg, scale {:+.2} %; ground rises {:+.1} {:+.1} deg",
        gps_m[0],
        gps_m[1],
        east - gps_m[0],
        north - gps_m[1],
        100.0 * (length - 1.0),
        angle(plane.offset_m) - angle(gps_m),
        back.plane.offset_m[0],
        back.plane.offset_m[1],
        yaw + turn,
        100.0 * plane.scale,
        slope[0],
        slope[1],
    ));
    say(&format!(
        "    whole overlap at {COARSE_M} m: {:.2} {:.2} m, sigma {:.2} {:.2} m, score {:.2}, second {:.2}, {}; {} of {} \
         parts at {FINE_M} m accepted, median {:.2} m from their plane; correlation without, by GPS, registered {:.2?}",
        whole.offset_m[0],
        whole.offset_m[1],
        whole.sigma_m[0],
        whole.sigma_m[1],
        whole.located.grey_correlation[0],
        whole.located.grey_correlation[1],
        if whole.located.accepted.is_ok() { "accepted" } else { "refused" },
        there.parts.len(),
        there.tried,
        plane.median_m(),
        likenesses
    ));
}

/// The stored pixels are upside down against the gimbal's yaw: taken as they are, frames register against the flight.
#[test]
fn gps_tells_which_way_the_pictures_are_turned() {
    let Some(folder) = folder("gps_tells_which_way_the_pictures_are_turned") else { return };
    let frames = pictures(&folder);
    for pair in frames.windows(2) {
        let [a, b] = [&pair[0], &pair[1]].map(|(exposure, picture)| Ground::new(picture, exposure, 0.0, COARSE_M));
        let gps_m = pair[0].0.gps_offset_m(&pair[1].0);
        let found = |expected_m| register(&a, &b, expected_m, &Part::WHOLE, RADIUS_PX).expect("texture");
        let [along, back] = [gps_m, against(gps_m)].map(found);
        assert!(along.located.accepted.is_err(), "{along:?}");
        assert!(back.located.peak.score > 2.0 * along.located.peak.score, "{back:?} {along:?}");
        let off_m = apart(back.offset_m, against(gps_m));
        assert!(off_m < 2.0 * GPS_M, "{off_m:.2} m from the opposite of GPS");
    }
}
