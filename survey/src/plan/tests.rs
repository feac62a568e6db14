//! Golden values of the strict rule over the portable elevation model (reference, 3.4), and the paper's level examples.

use super::area::Area;
use super::axes::Axes;
use super::base_height::base_height_m;
use super::combinations::base_min_m;
use super::lines::{Layout, Overlaps, Strip, View, line_count, photo_count};
use super::overlap::lines;
use super::terrain::Terrain;
use crate::dem::Dem;

/// z = 100 + 80 sin(x / 700) cos(y / 500) on posts 50 m apart.
pub(super) fn portable() -> Dem {
    let height = |k: usize| {
        let (x, y) = ((k % 141) as f64 * 50.0, (k / 141) as f64 * 50.0);
        100.0 + 80.0 * (x / 700.0).sin() * (y / 500.0).cos()
    };
    Dem {
        cols: 141,
        rows: 61,
        west_m: 0.0,
        south_m: 0.0,
        step_m: [50.0; 2],
        heights: (0..141 * 61).map(height).collect(),
    }
}

fn rectangle([x0, y0, x1, y1]: [f64; 4]) -> Area {
    Area::new(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]).expect("a rectangle")
}

pub(super) fn golden_area() -> Area {
    rectangle([500.0, 500.0, 6300.0, 1900.0])
}

/// f 50 mm, 108 x 72 mm, H = 555 m.
pub(super) fn view(base_height_m: f64) -> View {
    View { height_m: 555.0, base_height_m, footprint_m: [555.0 * 108.0 / 50.0, 555.0 * 72.0 / 50.0] }
}

fn layout<'a>(terrain: &'a Terrain<'a>, area: Area, forward: f64, side: f64) -> Layout<'a> {
    let base = base_height_m(terrain.dem(), &area).expect("known");
    Layout {
        terrain,
        axes: Axes::new(90.0),
        area,
        view: view(base),
        overlaps: Overlaps { forward, side },
        follow: None,
    }
}

fn counts(strips: &[Strip]) -> Vec<usize> {
    strips.iter().map(|strip| strip.along_m.len()).collect()
}

#[test]
fn golden_base_height() {
    let base = base_height_m(&portable(), &golden_area()).expect("known");
    assert!((base - 96.353_455_352).abs() < 1e-9, "{base}");
}

#[test]
fn golden_strips_60_30() {
    let dem = portable();
    let terrain = Terrain::new(&dem);
    let layout = layout(&terrain, golden_area(), 0.6, 0.3);
    let strips = layout.variable().expect("laid");
    assert_eq!(counts(&strips), [17, 17, 16, 17]);
    for (ours, golden) in lines(&strips).iter().zip([500.0, 1_026.543_760, 1_504.010_117, 1_979.204_286]) {
        assert!((ours - golden).abs() < 1e-6, "{ours} {golden}");
    }
    let golden = [20.48, 442.603_796, 851.400_675, 1_260.027_872, 1_668.655_069, 2_085.595_625];
    for (ours, golden) in strips[0].along_m.iter().zip(golden) {
        assert!((ours - golden).abs() < 1e-6, "{ours} {golden}");
    }
    assert!((base_min_m(&strips) - 407.309_288_063).abs() < 1e-9, "{}", base_min_m(&strips));
    let achieved = layout.achieved(&strips);
    let [forward, side] = [achieved.forward, achieved.side].map(|least| least.expect("pairs"));
    assert!((forward - 0.6).abs() < 1e-9 && (side - 0.3).abs() < 1e-9, "{forward} {side}");
}

#[test]
fn golden_strips_80_60() {
    let dem = portable();
    let terrain = Terrain::new(&dem);
    let strips = layout(&terrain, golden_area(), 0.8, 0.6).variable().expect("laid");
    assert_eq!((line_count(&strips), photo_count(&strips)), (7, 212));
    assert!((base_min_m(&strips) - 203.654_644_031).abs() < 1e-9, "{}", base_min_m(&strips));
}

#[test]
fn golden_level_ground() {
    let dem =
        Dem { cols: 200, rows: 60, west_m: -1000.0, south_m: -500.0, step_m: [50.0; 2], heights: vec![42.0; 12_000] };
    let terrain = Terrain::new(&dem);
    for (forward, side, lines, photos) in [(0.6, 0.3, 4, 64), (0.8, 0.6, 6, 168)] {
        let layout = layout(&terrain, rectangle([0.0, 0.0, 5800.0, 1400.0]), forward, side);
        let strips = layout.variable().expect("laid");
        assert_eq!((line_count(&strips), photo_count(&strips)), (lines, photos));
        // Level ground needs no other base than the nominal one.
        let [base, distance] = layout.view.nominal_m(&layout.overlaps);
        assert!((base_min_m(&strips) - base).abs() < 1e-9 && (strips[1].across_m - distance).abs() < 1e-9);
    }
}

/// A plan over level ground with one post of `peak_m` at (x, y), 201 x 201 posts of 50 m.
fn with_peak(corners: &[[f64; 2]], [x, y]: [f64; 2], peak_m: f64, speed_m_s: f64) -> Result<f64, String> {
    use super::combinations::Limits;
    use super::intersect::Sigmas;
    use super::request::Request;
    let dem =
        Dem::from_fn((201, 201), [0.0; 2], [50.0; 2], |at_x, at_y| if [at_x, at_y] == [x, y] { peak_m } else { 0.0 });
    let request = Request {
        area: Area::new(corners).expect("an area"),
        height_m: 500.0,
        half_tangent: [1.08, 0.72],
        tangent_per_px: [0.002; 2],
        overlaps: Some(Overlaps { forward: 0.6, side: 0.3 }),
        heading_deg: Some(90.0),
        limits: Limits { speed_m_s, min_interval_s: 0.038, accuracy_m: None },
        sigmas: Sigmas { image: [1e-4; 2], position_m: 0.015, attitude_rad: 1e-4 },
        exposure_s: 0.002,
        min_clearance_m: 50.0,
        seed: 1,
        tilt_deg: 0.0,
        follow: None,
    };
    let terrain = Terrain::new(&dem);
    let planned = request.plan(&terrain, &|_, _| ()).map_err(|error| error.to_string())?;
    for strip in planned.strips.windows(2).filter(|pair| pair[0].line == pair[1].line) {
        let apart = strip[1].along_m[0] - strip[0].along_m[strip[0].along_m.len() - 1];
        assert!(apart >= planned.layout.view.nominal_m(&planned.layout.overlaps)[0] - 1e-6, "parts {apart} m apart");
    }
    Ok(planned.checks.clearance_min_m)
}

#[test]
fn terrain_on_the_way_between_strips_counts() {
    // A U whose first line has two parts; the way between them leads over the peak, which no photo sees.
    let u = [
        [2000.0, 4000.0],
        [2600.0, 4000.0],
        [2600.0, 4600.0],
        [6400.0, 4600.0],
        [6400.0, 4000.0],
        [7000.0, 4000.0],
        [7000.0, 5200.0],
        [2000.0, 5200.0],
    ];
    // 500 m up and 900 m high: the flight would go 400 m below the top.
    assert_eq!(with_peak(&u, [4500.0, 4000.0], 900.0, 15.0), Ok(-400.0));
    assert_eq!(with_peak(&u, [4500.0, 2000.0], 900.0, 15.0), Ok(500.0));
    // The swing of a turn at 60 m/s, beyond the strip's end.
    let block = [[3000.0, 4000.0], [5000.0, 4000.0], [5000.0, 4400.0], [3000.0, 4400.0]];
    assert!(with_peak(&block, [7000.0, 4250.0], 480.0, 60.0).is_ok_and(|clearance| clearance < 21.0));
    // Parts of a line that would run into each other are one: see the assertion above.
    let near = [
        [2000.0, 4000.0],
        [4000.0, 4000.0],
        [4000.0, 4500.0],
        [4870.0, 4500.0],
        [4870.0, 4000.0],
        [7000.0, 4000.0],
        [7000.0, 4600.0],
        [2000.0, 4600.0],
    ];
    assert_eq!(with_peak(&near, [100.0, 100.0], 1.0, 15.0), Ok(500.0));
}
