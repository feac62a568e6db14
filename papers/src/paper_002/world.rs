//! A four-head camera over made-up ground: what is true, what is measured, where an adjustment starts.
//!
//! Section 4's numbers; what the paper's lost tables held is the reference's choice (adjustment.md, 2.1): centres at
//! (-/+0.045, +/-0.060) m, design tilts phi -/+22, omega +/-18 degrees.

use plumbline_sim::noise::{normal, stream, uniform};
use plumbline_survey::adjust::rig::{HEAD, Head, LENS, Observation, Point, Station, project};
use plumbline_survey::adjust::{Interior, Loss};
use plumbline_survey::calibrate::seam::Virtual;
use plumbline_survey::calibrate::{Block, Observations, Sizes};
use rand_chacha::ChaCha12Rng;

/// Principal distance of heads and virtual image, mm, and the side of a pixel.
pub const F_MM: f64 = 47.0;
/// Side of a pixel, mm.
pub const PIXEL_MM: f64 = 0.0068;
/// Principal distance, pixels.
pub const F_PX: f64 = F_MM / PIXEL_MM;
/// Columns and rows of a head's frame and of the virtual image.
pub const HEAD_PX: [f64; 2] = [7228.0, 5428.0];
/// Columns and rows of the virtual image.
pub const VIRTUAL_PX: [f64; 2] = [15_400.0, 10_400.0];
/// Height of the flight above the mean ground, m.
pub const HEIGHT_M: f64 = 700.0;
/// Measured image coordinates have this standard deviation, pixels.
pub const NOISE_PX: f64 = 0.4;
/// Terrain: largest amount above and below the mean, m.
pub const RELIEF_M: f64 = 50.0;
/// Standard deviation of a mounting angle against its design, degrees.
const MOUNT_DEG: f64 = 0.3;
/// Centres of the heads in the platform, m.
pub const CENTRES_M: [[f64; 3]; 4] =
    [[-0.045, 0.060, 0.0], [0.045, 0.060, 0.0], [-0.045, -0.060, 0.0], [0.045, -0.060, 0.0]];
/// Design angles phi, omega of the heads, degrees.
pub const DESIGN_DEG: [[f64; 2]; 4] = [[-22.0, 18.0], [22.0, 18.0], [-22.0, -18.0], [22.0, -18.0]];

/// How far beyond the frame, in half sides, a lens may bring a point back into it.
const BEYOND: f64 = 1.05;

/// The virtual image with the heads' frames.
#[must_use]
pub fn virtual_image() -> Virtual {
    Virtual { f_px: F_PX, half_px: VIRTUAL_PX.map(|side| side / 2.0), head_half_px: HEAD_PX.map(|side| side / 2.0) }
}

/// The heads as designed.
#[must_use]
pub fn design() -> Vec<[f64; HEAD]> {
    (0..4)
        .map(|head| {
            let [phi, omega] = DESIGN_DEG[head].map(f64::to_radians);
            Head::new([phi, omega, 0.0], CENTRES_M[head], Interior::ideal(F_PX), head == 0).values
        })
        .collect()
}

/// By how much the heads' true interiors are off what is assumed: standard deviations at the paper's "2 um".
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct InteriorError {
    /// Of the principal point and of the principal distance, px.
    pub linear_px: f64,
    /// Of the radial distortion at the corner of a head's frame, px.
    pub radial_px: f64,
}

/// What is true.
#[derive(Clone, Debug)]
pub struct World {
    /// Heads.
    pub heads: Vec<[f64; HEAD]>,
    /// Stations.
    pub stations: Vec<Station>,
    /// Points on the ground.
    pub points: Vec<[f64; 3]>,
    /// How many of the first of them are known.
    pub known: usize,
}

/// Mounts within 0.3 degrees (standard deviation) of the design, the first as designed; interiors off by `error`.
#[must_use]
pub fn mounted(rng: &mut ChaCha12Rng, error: InteriorError) -> Vec<[f64; HEAD]> {
    let mut heads = design();
    let corner = (HEAD_PX[0] / 2.0).hypot(HEAD_PX[1] / 2.0) / F_PX;
    for (index, head) in heads.iter_mut().enumerate() {
        for angle in &mut head[..3] {
            let off = MOUNT_DEG.to_radians() * normal(rng);
            *angle += if index == 0 { 0.0 } else { off };
        }
        for value in &mut head[LENS..LENS + 3] {
            *value += error.linear_px * normal(rng);
        }
        head[LENS + 3] += error.radial_px / F_PX / corner.powi(3) * normal(rng);
    }
    heads
}

/// Terrain: three waves, up to [`RELIEF_M`].
#[must_use]
pub fn ground_m(east_m: f64, north_m: f64) -> f64 {
    RELIEF_M * ((east_m / 310.0).sin() * (north_m / 270.0).cos() * 0.7 + 0.3 * ((east_m + 2.0 * north_m) / 190.0).sin())
}

/// A station near its place: position off by 5 m, tilts by 2 degrees, heading by 3 (standard deviations).
pub fn station(rng: &mut ChaCha12Rng, place_m: [f64; 2], heading_kappa: f64) -> Station {
    let tilt = 2f64.to_radians();
    Station {
        values: [
            tilt * normal(rng),
            tilt * normal(rng),
            heading_kappa + 3f64.to_radians() * normal(rng),
            place_m[0] + 5.0 * normal(rng),
            place_m[1] + 5.0 * normal(rng),
            HEIGHT_M + 5.0 * normal(rng),
        ],
        rates: [0.0; 6],
        is_free: true,
    }
}

impl World {
    /// The calibration block of section 4.2: 3 lines east-west of 3, 4 north-south of 4, narrow side along the flight,
    /// 80 % forward and 60 % side overlap; `count` unknown points and 12 known ones.
    #[must_use]
    pub fn calibration(seed: u64, count: usize, error: InteriorError) -> Self {
        let mut rng = stream(seed, "calibration block");
        let heads = mounted(&mut rng, error);
        let footprint = VIRTUAL_PX.map(|side| side / F_PX * HEIGHT_M);
        let (base, spacing) = (0.2 * footprint[1], 0.4 * footprint[0]);
        let turn = std::f64::consts::FRAC_PI_2;
        let mut stations = Vec::new();
        for line in 0..3 {
            for k in 0..3 {
                let place = [(f64::from(k) - 1.0) * base, (f64::from(line) - 1.0) * spacing];
                stations.push(station(&mut rng, place, if line % 2 == 0 { -turn } else { turn }));
            }
        }
        for line in 0..4 {
            for k in 0..4 {
                let place = [(f64::from(line) - 1.5) * spacing, (f64::from(k) - 1.5) * base];
                stations.push(station(&mut rng, place, if line % 2 == 0 { 0.0 } else { 2.0 * turn }));
            }
        }
        let known: Vec<[f64; 3]> = (0..16)
            .map(|k| [f64::from(k % 4) * 600.0 - 900.0, f64::from(k / 4) * 600.0 - 900.0])
            .filter(|place| place.iter().any(|v| v.abs() < 600.0))
            .map(|[east, north]| [east, north, ground_m(east, north)])
            .collect();
        let mut world = World { heads, stations, known: known.len(), points: known };
        world.add_points(&mut rng, count, [1550.0, 1450.0], 3, &|world, station, point| {
            (0..world.heads.len()).any(|head| world.image(station, head, point).is_some())
        });
        world
    }

    /// Adds points within so many metres of the middle that `stations` stations at least see, as `sees` has it.
    pub fn add_points(
        &mut self,
        rng: &mut ChaCha12Rng,
        count: usize,
        half_m: [f64; 2],
        stations: usize,
        sees: &dyn Fn(&World, &Station, [f64; 3]) -> bool,
    ) {
        let wanted = self.points.len() + count;
        while self.points.len() < wanted {
            let [east, north] = half_m.map(|half| (2.0 * uniform(rng) - 1.0) * half);
            let point = [east, north, ground_m(east, north)];
            if self.stations.iter().filter(|station| sees(self, station, point)).count() >= stations {
                self.points.push(point);
            }
        }
    }

    /// Where a head of a station sees a point, if its frame holds it.
    #[must_use]
    pub fn image(&self, station: &Station, head: usize, point: [f64; 3]) -> Option<[f64; 2]> {
        // Far beyond the frame the lens' polynomial means nothing, and may fold back into it.
        let mut ideal = self.heads[head];
        ideal[LENS..].copy_from_slice(&Interior::ideal(F_PX).0);
        let near = project(&ideal, station, point)?;
        if (0..2).any(|k| near[k].abs() > BEYOND * HEAD_PX[k] / 2.0) {
            return None;
        }
        let image = project(&self.heads[head], station, point)?;
        (image[0].abs() <= HEAD_PX[0] / 2.0 && image[1].abs() <= HEAD_PX[1] / 2.0).then_some(image)
    }

    /// Everything that every head sees of the points, with noise.
    #[must_use]
    pub fn observed(&self, rng: &mut ChaCha12Rng, noise_px: f64) -> Observations {
        let mut seen = Vec::new();
        for (station, at) in self.stations.iter().enumerate() {
            for head in 0..self.heads.len() {
                for (point, on) in self.points.iter().enumerate() {
                    if let Some(image) = self.image(at, head, *on) {
                        let image_px = image.map(|value| value + noise_px * normal(rng));
                        seen.push(Observation { station, head, point, image_px });
                    }
                }
            }
        }
        Observations { lines: (0..seen.len()).map(|index| index + 2).collect(), seen, name: "simulated".to_owned() }
    }

    /// Where an adjustment starts: heads as designed, stations and points off by 3 m and 0.2 degrees.
    #[must_use]
    pub fn start(&self, rng: &mut ChaCha12Rng) -> Block {
        let off =
            |rng: &mut ChaCha12Rng, k: usize| if k < 3 { 0.2f64.to_radians() * normal(rng) } else { 3.0 * normal(rng) };
        let stations = self
            .stations
            .iter()
            .map(|station| {
                let mut values = station.values;
                values.iter_mut().enumerate().for_each(|(k, value)| *value += off(rng, k));
                Station { values, ..*station }
            })
            .collect();
        let points = self
            .points
            .iter()
            .enumerate()
            .map(|(index, point)| {
                let is_free = index >= self.known;
                let position_m = point.map(|value| if is_free { value + 3.0 * normal(rng) } else { value });
                Point { position_m, is_free }
            })
            .collect();
        let heads = design()
            .into_iter()
            .enumerate()
            .map(|(index, values)| Head { values, free: if index == 0 { Vec::new() } else { vec![0, 1, 2] } })
            .collect();
        Block {
            heads,
            stations,
            points,
            sigma_px: vec![NOISE_PX; self.heads.len()],
            head_priors: Vec::new(),
            station_priors: Vec::new(),
            point_priors: Vec::new(),
            loss: Loss::Squares,
            sizes: Sizes {
                pixel_mm: Some(PIXEL_MM),
                head: Some(HEAD_PX.map(|side| side as u32)),
                virtual_image: Some(VIRTUAL_PX.map(|side| side as u32)),
                virtual_f_px: Some(F_PX),
            },
        }
    }
}

/// Makes the interiors of a block's heads unknown: c, principal point and k1, known beforehand to `error`.
pub fn self_calibrating(block: &mut Block, error: InteriorError) {
    let corner = (HEAD_PX[0] / 2.0).hypot(HEAD_PX[1] / 2.0) / F_PX;
    for (index, head) in block.heads.iter_mut().enumerate() {
        for place in LENS..LENS + 4 {
            head.free.push(place);
            let sigma = if place < LENS + 3 { error.linear_px } else { error.radial_px / F_PX / corner.powi(3) };
            block.head_priors.push((index, place, head.values[place], sigma));
        }
    }
}
