//! Cameras, noise and terrain of the paper's two tests.

use super::super::Row;
use super::{own, row};
use plumbline_survey::dem::{Dem, DemFile, Frame};
use plumbline_survey::error::InputError;
use plumbline_survey::io::data::shared_data;
use plumbline_survey::plan::area::Area;
use plumbline_survey::plan::axes::Axes;
use plumbline_survey::plan::base_height::base_height_m;
use plumbline_survey::plan::combinations::Limits;
use plumbline_survey::plan::intersect::Sigmas;
use plumbline_survey::plan::lines::{Layout, Overlaps, Strip, View, photo_count};
use plumbline_survey::plan::terrain::Terrain;
use rayon::prelude::*;

/// Metres of a degree of latitude, and of longitude at the equator, on the sphere that the plans are made on.
const M_PER_DEG: [f64; 2] = [111_320.0, 111_133.0];
/// The paper's noise: image, position, attitude.
const NOISE: [f64; 3] = [2e-6, 0.015, 1e-4];
/// Speed and interval, of which the paper gives neither.
pub const LIMITS: Limits = Limits { speed_m_s: 55.0, min_interval_s: 2.5, accuracy_m: None };

/// A test: lengths of the camera in metres, overlaps, and where it is flown.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    focal_m: f64,
    format_m: [f64; 2],
    height_m: f64,
    /// Overlaps of the constant bases that were flown.
    pub flown: Overlaps,
    /// x0, y0, x1, y1.
    window_m: [f64; 4],
    /// The paper's limits for plan and height, where the combinations are looked at.
    pub limits: Option<[f64; 2]>,
}

/// Badaling, hills: six lines. A window of 5.8 x 1.4 km with 168 m of relief; size and place are ours.
pub const TEST_1: Test = Test {
    focal_m: 0.050,
    format_m: [0.108, 0.072],
    height_m: 555.0,
    flown: Overlaps { forward: 0.8, side: 0.6 },
    window_m: [19_500.0, 13_500.0, 25_300.0, 14_900.0],
    limits: Some([0.5, 0.4]),
};

/// Northern Jiangxi, mountains. The whole of [`mountains`], 60.0 x 63.6 km, is ours.
pub const TEST_2: Test = Test {
    focal_m: 0.047,
    format_m: [0.070_72, 0.106_08],
    height_m: 3150.0,
    flown: Overlaps { forward: 0.688, side: 0.3 },
    window_m: [0.0, 0.0, 59_959.9, 63_623.6],
    limits: None,
};

impl Test {
    /// The area.
    #[must_use]
    pub fn area(&self) -> Area {
        rectangle(self.window_m)
    }

    /// Noise in tangents, metres and radians.
    #[must_use]
    pub fn sigmas(&self) -> Sigmas {
        let [image_m, position_m, attitude_rad] = NOISE;
        Sigmas { image: [image_m / self.focal_m; 2], position_m, attitude_rad }
    }

    /// Footprint on the base plane.
    fn footprint_m(&self) -> [f64; 2] {
        self.format_m.map(|side| side * self.height_m / self.focal_m)
    }

    /// Strips due east over the area.
    ///
    /// # Errors
    /// The terrain has a hole there.
    pub fn layout<'r>(&self, terrain: &'r Terrain<'r>, overlaps: Overlaps) -> Result<Layout<'r>, InputError> {
        let area = self.area();
        let base_height_m = base_height_m(terrain.dem(), &area)?;
        let view = View { height_m: self.height_m, base_height_m, footprint_m: self.footprint_m() };
        Ok(Layout { terrain, axes: Axes::new(90.0), area, view, overlaps, follow: None })
    }

    /// Strips with the nominal bases, as over level ground.
    ///
    /// # Errors
    /// None.
    pub fn level(&self, overlaps: Overlaps) -> Result<Vec<Strip>, InputError> {
        let [x0, y0, x1, y1] = self.window_m;
        let dem = Dem::from_fn((2, 2), [x0, y0], [x1 - x0, y1 - y0], |_, _| 0.0);
        self.layout(&Terrain::new(&dem), overlaps)?.variable()
    }
}

fn rectangle([x0, y0, x1, y1]: [f64; 4]) -> Area {
    // Four corners of a window that is larger than nothing make an area.
    match Area::new(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) {
        Ok(area) => area,
        Err(error) => unreachable!("{error}"),
    }
}

/// Hills around Jacksboro, Tennessee, in metres from their south-western post; `None` without the folder of real data.
///
/// # Errors
/// The file is broken.
pub fn hills() -> Result<Option<Dem>, InputError> {
    let Some(path) = shared_data().map(|data| data.join("dem/jacksboro_3arcsec.tif")).filter(|path| path.is_file())
    else {
        return Ok(None);
    };
    let file = DemFile::open(&path)?;
    let [x0, y0, x1, y1] = file.bounds();
    let frame = Frame::new(file.system(), [0.5 * (x0 + x1), 0.5 * (y0 + y1)])?;
    let ([west, south], [east, north]) = (frame.metres([x0, y0]), frame.metres([x1, y1]));
    let dem = file.window(&frame, [west, south, east, north], &mut |_, _| ())?;
    let (cols, rows) = (dem.cols, dem.rows);
    let lat = (0.5 * (y0 + y1)).to_radians();
    let step_m =
        [(x1 - x0) / (cols - 1) as f64 * M_PER_DEG[0] * lat.cos(), (y1 - y0) / (rows - 1) as f64 * M_PER_DEG[1]];
    Ok(Some(Dem { west_m: 0.0, south_m: 0.0, step_m, ..dem }))
}

/// That terrain mirrored at its eastern and northern border, and half as high again.
#[must_use]
pub fn mountains(hills: &Dem) -> Dem {
    let mirrored = |at: usize, count: usize| if at < count { at } else { 2 * count - 1 - at };
    let (cols, rows) = (2 * hills.cols, 2 * hills.rows);
    let post = |k: usize| 1.5 * hills.at(mirrored(k % cols, hills.cols), mirrored(k / cols, hills.rows));
    Dem { cols, rows, heights: (0..cols * rows).map(post).collect(), ..*hills }
}

/// Percent of photos that variable bases save against the cheapest constant ones, over windows of test 1's size a kilometre
/// apart.
///
/// # Errors
/// None where the windows have no holes.
pub fn windows(hills: &Dem, overlaps: Overlaps) -> Result<Vec<f64>, InputError> {
    let terrain = Terrain::new(hills);
    let [x0, y0, x1, y1] = TEST_1.window_m;
    let [_, _, east, north] = hills.bounds();
    let places: Vec<[f64; 2]> = (1..)
        .map(|k| f64::from(k) * 1000.0)
        .take_while(|x| x + 7000.0 < east)
        .flat_map(|x| (1..).map(|k| f64::from(k) * 1000.0).take_while(|y| y + 3000.0 < north).map(move |y| [x, y]))
        .collect();
    let saved = places.par_iter().map(|[x, y]| {
        let window_m = [*x, *y, x + x1 - x0, y + y1 - y0];
        let test = Test { window_m, ..TEST_1 };
        let area = test.area();
        let posts = (0..hills.rows).flat_map(|row| (0..hills.cols).map(move |col| (col, row)));
        let place = |(col, row): &(usize, usize)| [*col as f64 * hills.step_m[0], *row as f64 * hills.step_m[1]];
        let heights = posts.filter(|post| area.contains(place(post))).map(|(col, row)| hills.at(col, row));
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(low, high), h| (low.min(h), high.max(h)));
        if !(100.0..=250.0).contains(&(high - low)) {
            return Ok(None);
        }
        let layout = test.layout(&terrain, overlaps)?;
        // Over the steepest of them the terrain outside the window reaches the camera.
        let (Ok(variable), Ok(constant)) = (layout.variable(), layout.constant()) else { return Ok(None) };
        let [variable, constant] = [&variable, &constant.strips].map(|strips| photo_count(strips) as f64);
        Ok(Some(100.0 * (constant - variable) / constant))
    });
    Ok(saved.collect::<Result<Vec<_>, InputError>>()?.into_iter().flatten().collect())
}

/// What follows from the equations alone.
pub fn equations() -> Vec<Row> {
    let table = "Equations";
    let level = |test: &Test, forward: f64, side: f64| {
        let view = View { height_m: test.height_m, base_height_m: 0.0, footprint_m: test.footprint_m() };
        view.nominal_m(&Overlaps { forward, side })
    };
    let mut rows = vec![own(table, "scale of test 1, 1 :".into(), TEST_1.height_m / TEST_1.focal_m)];
    let [along, across] = TEST_1.footprint_m();
    rows.push(own(table, "its footprint along, m".into(), along));
    rows.push(own(table, "its footprint across, m".into(), across));
    for (forward, side) in [(0.6, 0.3), (0.8, 0.6)] {
        let [base, distance] = level(&TEST_1, forward, side);
        rows.push(own(table, format!("its base at {:.0} %, m", 100.0 * forward), base));
        rows.push(own(table, format!("its distance of strips at {:.0} %, m", 100.0 * side), distance));
    }
    rows.push(own(table, "scale of test 2, 1 :".into(), TEST_2.height_m / TEST_2.focal_m));
    let [base, distance] = level(&TEST_2, 0.6, 0.3);
    rows.push(own(table, "its base at 60 %, m".into(), base));
    rows.push(own(table, "its distance of strips at 30 %, m".into(), distance));
    // q' = q + (1 - q) dh / H: what 60 % on ground 0.22 H above the base plane is on the plane, the overlap flown in test 2.
    rows.push(row(
        table,
        "60 % on the ground at dh / H = 0.22, on the base plane, %".into(),
        68.8,
        100.0 * (0.6 + 0.4 * 0.22),
        None,
    ));
    rows
}
