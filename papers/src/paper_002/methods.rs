//! Three ways to the mounting angles on the same made-up flight: one exposure's cross overlap (section 2.3), every picture on
//! its own (2.4), and the constrained block (3).

use super::world::{self, F_PX, HEIGHT_M, InteriorError, NOISE_PX, World};
use nalgebra::{Matrix3, Vector3};
use plumbline_sim::noise::{stream, uniform};
use plumbline_survey::adjust::rig::{HEAD, Head, Station};
use plumbline_survey::adjust::{Interior, Options, SolveError, rotation};
use plumbline_survey::calibrate::seam::{image_of, mismatches, rms_and_max};
use plumbline_survey::calibrate::{Block, Calibration, Observations, PointPrior, mount, picture};

/// Grid on which a seam is looked at, pixels of the virtual image.
pub const SEAM_STEP_PX: f64 = 200.0;

/// What a method made of a block.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Angles of heads 2 to 4 less the true ones, arc seconds: phi, omega, kappa, head by head.
    pub errors_arcsec: Vec<f64>,
    /// Their standard deviations as the adjustment has them; none where it has none.
    pub sigmas_arcsec: Vec<f64>,
    /// Seams: root mean square and largest, pixels.
    pub seam_px: (f64, f64),
    /// Distances between the centres of two heads of a station, metres; empty where they are known.
    pub distances_m: Vec<f64>,
    /// Correlation of a picture's phi with its X.
    pub correlation: f64,
    /// Standard deviation of unit weight, pixels.
    pub sigma0_px: f64,
    /// Observations.
    pub observations: usize,
}

const ARCSEC: f64 = 3600.0;
/// Stream of the noise of a calibration block.
pub(super) const CONSTRAINED: &str = "constrained";

fn judged(truth: &[[f64; HEAD]], calibrated: &[[f64; HEAD]]) -> (Vec<f64>, (f64, f64)) {
    let errors = (1..truth.len())
        .flat_map(|head| (0..3).map(move |k| (head, k)))
        .map(|(head, k)| (calibrated[head][k] - truth[head][k]).to_degrees() * ARCSEC)
        .collect();
    (errors, rms_and_max(&mismatches(truth, calibrated, &world::virtual_image(), SEAM_STEP_PX)))
}

fn outcome(world: &World, heads: &[[f64; HEAD]], calibration: &Calibration) -> Outcome {
    let (errors_arcsec, seam_px) = judged(&world.heads, heads);
    let angles = calibration.unknowns.iter().filter(|unknown| unknown.number < 3);
    let phi_x = calibration.correlations.iter().find(|pair| pair.a.starts_with("phi") && pair.b.starts_with("X"));
    Outcome {
        errors_arcsec,
        sigmas_arcsec: angles.map(|unknown| unknown.sigma.to_degrees() * ARCSEC).collect(),
        seam_px,
        distances_m: Vec::new(),
        correlation: phi_x.map_or(0.0, |pair| pair.value),
        sigma0_px: calibration.sigma0_px,
        observations: calibration.residuals.len(),
    }
}

/// The constrained block; with its interiors as unknowns where `estimated` says what is known of them.
///
/// # Errors
/// None for these blocks; the adjustment's own are passed on.
pub fn constrained(
    seed: u64,
    points: usize,
    error: InteriorError,
    estimated: Option<InteriorError>,
) -> Result<Outcome, SolveError> {
    let world = World::calibration(seed, points, error);
    let mut rng = stream(seed, CONSTRAINED);
    let observations = world.observed(&mut rng, NOISE_PX);
    let mut block = world.start(&mut rng);
    if let Some(known) = estimated {
        world::self_calibrating(&mut block, known);
    }
    let rig = block.rig(&observations.seen);
    let calibration = Calibration::of_rig(&rig, &Options::default(), &mut |_, _| {})?;
    Ok(outcome(&world, &calibration.heads, &calibration))
}

/// Every picture with an orientation of its own; the mounts are the means over the stations.
///
/// # Errors
/// As [`constrained`].
pub fn unconstrained(seed: u64, points: usize) -> Result<Outcome, SolveError> {
    let world = World::calibration(seed, points, InteriorError::default());
    let mut rng = stream(seed, CONSTRAINED);
    let observations = world.observed(&mut rng, NOISE_PX);
    let block = world.start(&mut rng);
    let heads = world.heads.len();
    // One station a picture, with one head in the middle of it.
    let pictures = block.stations.iter().flat_map(|station| {
        block.heads.iter().map(|head| {
            let values = picture(&station.values, &head.values);
            Station { values, rates: [0.0; 6], is_free: true }
        })
    });
    let alone = Block {
        stations: pictures.collect(),
        heads: vec![Head::new([0.0; 3], [0.0; 3], Interior::ideal(F_PX), true)],
        sigma_px: vec![NOISE_PX],
        ..block.clone()
    };
    let mut seen = observations.seen.clone();
    for seen in &mut seen {
        seen.station = heads * seen.station + seen.head;
        seen.head = 0;
    }
    let calibration = Calibration::of_rig(&alone.rig(&seen), &Options::default(), &mut |_, _| {})?;
    let pictures = |station: usize| &calibration.stations[heads * station..heads * (station + 1)];
    let rotation_of = |values: &[f64; 6]| rotation::matrix([values[0], values[1], values[2]]);
    let mut means = world::design();
    for (head, mean) in means.iter_mut().enumerate().skip(1) {
        // Head to first head, averaged over the stations, behind the first head's known mount.
        let sum: Matrix3<f64> = (0..world.stations.len())
            .map(|station| rotation_of(&pictures(station)[0]).transpose() * rotation_of(&pictures(station)[head]))
            .sum();
        let (turn, _) = rotation::nearest(sum).ok_or(SolveError::NotFinite)?;
        let angles = rotation::angles_rad(&(mount(&world.heads[0]) * turn));
        mean[..3].copy_from_slice(&angles);
    }
    let mut of_means = outcome(&world, &means, &calibration);
    for station in 0..world.stations.len() {
        let centres: Vec<Vector3<f64>> =
            pictures(station).iter().map(|values| Vector3::new(values[3], values[4], values[5])).collect();
        for (k, a) in centres.iter().enumerate() {
            of_means.distances_m.extend(centres[k + 1..].iter().map(|b| (a - b).norm()));
        }
    }
    Ok(of_means)
}

/// One exposure, and `matches` points where two heads or more overlap. Of the ground is known that it lies within the
/// relief, which the short bases need: they leave the distance open to some hundred metres.
///
/// # Errors
/// As [`constrained`].
pub fn cross_overlap(seed: u64, matches: usize) -> Result<Outcome, SolveError> {
    let mut world = World::calibration(seed, 0, InteriorError::default());
    let mut rng = stream(seed, "cross overlap");
    world.stations.truncate(1);
    world.stations[0].values = [0.0, 0.0, 0.0, 0.0, 0.0, HEIGHT_M];
    world.stations[0].is_free = false;
    (world.points, world.known) = (Vec::new(), 0);
    let half = world::virtual_image();
    while world.points.len() < matches {
        let [x, y] = half.half_px.map(|side| (2.0 * uniform(&mut rng) - 1.0) * side);
        let ray = Vector3::new(x, y, -F_PX);
        if world.heads.iter().filter(|head| image_of(head, &ray, half.head_half_px).is_some()).count() > 1 {
            let [east, north] = [x, y].map(|value| value / F_PX * HEIGHT_M);
            world.points.push([east, north, world::ground_m(east, north)]);
        }
    }
    let observations: Observations = world.observed(&mut rng, NOISE_PX);
    let mut block = world.start(&mut rng);
    block.stations = world.stations.clone();
    for (index, point) in block.points.iter_mut().enumerate() {
        point.position_m[2] = 0.0;
        let sigma_m = [1000.0, 1000.0, 0.5 * world::RELIEF_M];
        block.point_priors.push(PointPrior { point: index, position_m: point.position_m, sigma_m });
    }
    let rig = block.rig(&observations.seen);
    let calibration = Calibration::of_rig(&rig, &Options::default(), &mut |_, _| {})?;
    Ok(outcome(&world, &calibration.heads, &calibration))
}

/// Root mean square.
#[must_use]
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values.into_iter().fold((0.0, 0), |(sum, count), value| (sum + value * value, count + 1));
    (sum / f64::from(count.max(1))).sqrt()
}
