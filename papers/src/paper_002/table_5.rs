//! Table 5: aerial triangulation of 39 virtual images made with the calibrated heads, judged at check points.

use super::methods::{self, rms};
use super::world::{self, F_PX, HEIGHT_M, InteriorError, NOISE_PX, VIRTUAL_PX, World};
use nalgebra::Vector3;
use plumbline_sim::noise::{normal, stream};
use plumbline_survey::adjust::rig::{HEAD, Head, Observation, Point, Station, project};
use plumbline_survey::adjust::{Interior, Options, Rig, SolveError};
use plumbline_survey::calibrate::seam::ray_of;
use plumbline_survey::calibrate::{Calibration, Symmetrised, mount};
use rand_chacha::ChaCha12Rng;

/// Images of a line, and lines.
const LINES: (i32, i32) = (13, 3);
/// Forward and side overlap.
const OVERLAP: (f64, f64) = (0.60, 0.35);
/// Unknown tie points that are no check points.
const TIES: usize = 700;
/// Check points.
pub const CHECKS: usize = 40;
/// Known points: columns along the lines and rows across; the paper shows them in a figure only.
pub const CONTROLS: (i32, i32) = (5, 3);

/// What the triangulation comes to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Checked {
    /// Root mean square error of the check points in plan (east and north together), m.
    pub plan_m: f64,
    /// And in height, m.
    pub height_m: f64,
    /// Standard deviation of unit weight, px.
    pub sigma0_px: f64,
    /// Virtual images.
    pub images: usize,
}

/// Calibrates the heads from a block of their own, makes virtual images with them and triangulates those.
///
/// # Errors
/// None for these blocks; the adjustment's own are passed on.
pub fn checked(seed: u64, points: usize) -> Result<Checked, SolveError> {
    let calibration_world = World::calibration(seed, points, InteriorError::default());
    let mut rng = stream(seed, methods::CONSTRAINED);
    let observations = calibration_world.observed(&mut rng, NOISE_PX);
    let rig = calibration_world.start(&mut rng).rig(&observations.seen);
    let calibrated = Calibration::of_rig(&rig, &Options::default(), &mut |_, _| {})?.heads;
    triangulated(seed, &calibration_world.heads, &calibrated)
}

fn triangulated(seed: u64, truth: &[[f64; HEAD]], calibrated: &[[f64; HEAD]]) -> Result<Checked, SolveError> {
    let mut rng = stream(seed, "virtual images");
    let turned = Symmetrised::new(calibrated);
    let (world, first_tie) = virtual_block(&mut rng, truth, &turned);
    let rig = measured(&mut rng, &world, &turned);
    let adjusted = Calibration::of_rig(&rig, &Options::default(), &mut |_, _| {})?;
    let errors = |axes: &[usize]| -> f64 {
        let of = |point: usize| {
            axes.iter().map(|k| (adjusted.points[point][*k] - world.points[point][*k]).powi(2)).sum::<f64>()
        };
        rms((world.known..first_tie).map(|point| of(point).sqrt()))
    };
    Ok(Checked {
        plan_m: errors(&[0, 1]),
        height_m: errors(&[2]),
        sigma0_px: adjusted.sigma0_px,
        images: world.stations.len(),
    })
}

/// The block as it is: stations, known points, check points, tie points, and the index of the first tie point.
fn virtual_block(rng: &mut ChaCha12Rng, truth: &[[f64; HEAD]], turned: &Symmetrised) -> (World, usize) {
    let footprint = VIRTUAL_PX.map(|side| side / F_PX * HEIGHT_M);
    let (base, spacing) = ((1.0 - OVERLAP.0) * footprint[1], (1.0 - OVERLAP.1) * footprint[0]);
    let mut world = World { heads: truth.to_vec(), stations: Vec::new(), points: Vec::new(), known: 0 };
    for line in 0..LINES.1 {
        for image in 0..LINES.0 {
            let place =
                [f64::from(2 * image - LINES.0 + 1) / 2.0 * base, f64::from(2 * line - LINES.1 + 1) / 2.0 * spacing];
            let kappa = if line % 2 == 0 { -1.0 } else { 1.0 } * std::f64::consts::FRAC_PI_2;
            world.stations.push(world::station(rng, place, kappa));
        }
    }
    let half = [f64::from(LINES.0 - 1) / 2.0 * base, spacing];
    for row in 0..CONTROLS.1 {
        for col in 0..CONTROLS.0 {
            let part = |index: i32, count: i32| f64::from(2 * index - count + 1) / f64::from(count - 1);
            let [east, north] = [part(col, CONTROLS.0) * half[0], part(row, CONTROLS.1) * half[1]];
            world.points.push([east, north, world::ground_m(east, north)]);
        }
    }
    world.known = world.points.len();
    let sees =
        |world: &World, station: &Station, point: [f64; 3]| virtual_point(world, turned, station, point).is_some();
    world.add_points(rng, CHECKS, half, 3, &sees);
    let first_tie = world.points.len();
    world.add_points(rng, TIES, [half[0] + 0.4 * base, half[1] + 300.0], 2, &sees);
    (world, first_tie)
}

/// The block as it is measured in the virtual images, with start values that are off.
fn measured(rng: &mut ChaCha12Rng, world: &World, turned: &Symmetrised) -> Rig {
    let mut seen = Vec::new();
    for (station, at) in world.stations.iter().enumerate() {
        for (point, on) in world.points.iter().enumerate() {
            let Some(image) = virtual_point(world, turned, at, *on) else { continue };
            let image_px = image.map(|value| value + NOISE_PX * normal(rng));
            seen.push(Observation { station, head: 0, point, image_px });
        }
    }
    let mut off = |value: f64, by: f64| value + by * normal(rng);
    let station = |station: &Station| {
        let values = turned.station(&station.values);
        Station { values: std::array::from_fn(|k| off(values[k], if k < 3 { 3e-3 } else { 3.0 })), ..*station }
    };
    let stations = world.stations.iter().map(station).collect();
    let point = |(index, point): (usize, &[f64; 3])| {
        let is_free = index >= world.known;
        Point { position_m: point.map(|value| off(value, if is_free { 3.0 } else { 0.0 })), is_free }
    };
    let points = world.points.iter().enumerate().map(point).collect();
    let head = Head::new([0.0; 3], [0.0; 3], Interior::ideal(F_PX), true);
    Rig::new(stations, vec![head], points, seen, vec![NOISE_PX])
}

/// Where the virtual image shows a point: the head nearest to it delivers the pixel, which goes along the calibrated ray
/// to the plane of the mean ground and from there to the virtual centre.
fn virtual_point(world: &World, turned: &Symmetrised, at: &Station, on: [f64; 3]) -> Option<[f64; 2]> {
    let as_platform = Station { values: turned.station(&at.values), ..*at };
    let ideal = Head::new([0.0; 3], [0.0; 3], Interior::ideal(F_PX), true).values;
    let nominal = project(&ideal, &as_platform, on)?;
    let ray = Vector3::new(nominal[0], nominal[1], -F_PX).normalize();
    let head = (0..world.heads.len()).filter(|head| world.image(at, *head, on).is_some()).max_by(|a, b| {
        let along = |head: usize| -mount(&turned.heads[head]).column(2).dot(&ray);
        along(*a).total_cmp(&along(*b))
    })?;
    let calibrated = &turned.heads[head];
    let direction = mount(calibrated) * ray_of(calibrated, world.image(at, head, on)?)?;
    let centre = Vector3::new(calibrated[3], calibrated[4], calibrated[5]);
    let ground = centre + direction * ((-HEIGHT_M - centre.z) / direction.z);
    let image = [-F_PX * ground.x / ground.z, -F_PX * ground.y / ground.z];
    (0..2).all(|k| image[k].abs() <= VIRTUAL_PX[k] / 2.0).then_some(image)
}
