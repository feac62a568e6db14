//! Collinearity of a camera of one or more heads (paper 002, section 3.2, whose formulas the print has lost).
//!
//! A station has one orientation (phi, omega, kappa, X, Y, Z), the platform's; a head has a mount (angles, centre d) that
//! all stations share. With v = X - S, R_v the station's and R_i the head's rotation:
//!
//! ```text
//! q = R_v' v - d_i        u = R_i' q        tangents (-u1/u3, -u2/u3) -> lens -> x, y
//! ```
//!
//! Known lever arms and the first head's angles are constraints by construction: they are no unknowns at all. That leaves
//! 6m + 3(p-q) + 9 for m stations, p points, q of them known, and four heads. Beyond the paper a head may have a
//! centre, a time offset against the stations' instants and an interior orientation of its own, each with what is known of
//! it beforehand as observations with sigmas.

mod linearised;
mod sight;

pub use linearised::RigAt;
pub use sight::project;

use super::lens::{INTERIOR, INTERIOR_NAMES, Interior};
use super::model::{Link, Structure};

/// How many numbers a head has.
pub const HEAD: usize = 7 + INTERIOR;
/// What they are: angles, centre, time offset; the interior orientation follows.
const MOUNT_NAMES: [&str; 7] = ["phi", "omega", "kappa", "dx", "dy", "dz", "dt"];
/// What a station's numbers are.
pub const STATION_NAMES: [&str; 6] = ["phi", "omega", "kappa", "X", "Y", "Z"];
/// Index of the time offset in a head's numbers.
pub const TIME: usize = 6;
/// Index of the first number of the interior orientation.
pub const LENS: usize = 7;

/// Name of a head's number.
#[must_use]
pub fn head_name(number: usize) -> &'static str {
    if number < LENS { MOUNT_NAMES[number] } else { INTERIOR_NAMES[number - LENS] }
}

/// A head: start values, and which of them are unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Head {
    /// Phi, omega, kappa (rad, head to platform), centre (m, platform), time offset (s), interior orientation.
    pub values: [f64; HEAD],
    /// Indices of those that are unknowns, ascending.
    pub free: Vec<usize>,
}

impl Head {
    /// A head of which the angles are unknown unless it is the first.
    #[must_use]
    pub fn new(angles_rad: [f64; 3], d_m: [f64; 3], interior: Interior, is_first: bool) -> Self {
        let mut values = [0.0; HEAD];
        values[..3].copy_from_slice(&angles_rad);
        values[3..6].copy_from_slice(&d_m);
        values[LENS..].copy_from_slice(&interior.0);
        Head { values, free: if is_first { Vec::new() } else { vec![0, 1, 2] } }
    }
}

/// A station: start values (phi, omega, kappa in rad, X, Y, Z in m), and how they change, a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Station {
    /// Phi, omega, kappa, X, Y, Z.
    pub values: [f64; 6],
    /// Their rates; they matter where a head has a time offset.
    pub rates: [f64; 6],
    /// Whether they are unknowns.
    pub is_free: bool,
}

/// A point on the ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// East, north, up, metres.
    pub position_m: [f64; 3],
    /// Whether it is unknown.
    pub is_free: bool,
}

/// A point seen by a head at a station: x right, y up from the frame's centre, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Which station.
    pub station: usize,
    /// Which head.
    pub head: usize,
    /// Which point.
    pub point: usize,
    /// Image point.
    pub image_px: [f64; 2],
}

/// A block of stations, heads, points and observations as an adjustment.
#[derive(Debug)]
pub struct Rig {
    /// The stations.
    pub stations: Vec<Station>,
    /// The heads.
    pub heads: Vec<Head>,
    /// The points.
    pub points: Vec<Point>,
    /// The observations.
    pub observations: Vec<Observation>,
    /// Standard deviation of an image coordinate of each head, pixels.
    pub sigma_px: Vec<f64>,
    structure: Structure,
    /// Unknowns before the points'.
    reduced: usize,
    /// Block of each station and head.
    station_block: Vec<Option<u32>>,
    head_block: Vec<Option<u32>>,
    /// First unknown of each station, head and point, if it has any.
    station_at: Vec<Option<usize>>,
    head_at: Vec<Option<usize>>,
    point_at: Vec<Option<usize>>,
}

impl Rig {
    /// Lays out the unknowns: stations, heads, points.
    #[must_use]
    pub fn new(
        stations: Vec<Station>,
        heads: Vec<Head>,
        points: Vec<Point>,
        observations: Vec<Observation>,
        sigma_px: Vec<f64>,
    ) -> Self {
        let mut structure = Structure::default();
        let mut next = 0;
        let mut lay = |sizes: &mut Vec<usize>, size: usize| {
            if size == 0 {
                return (None, None);
            }
            let first = next;
            next += size;
            sizes.push(size);
            (Some(first), Some(sizes.len() as u32 - 1))
        };
        let sizes = &mut structure.sizes;
        let (station_at, station_block): (Vec<_>, Vec<_>) =
            stations.iter().map(|station| lay(sizes, if station.is_free { 6 } else { 0 })).unzip();
        let (head_at, head_block): (Vec<_>, Vec<_>) = heads.iter().map(|head| lay(sizes, head.free.len())).unzip();
        let mut free = 0;
        let numbers: Vec<Option<u32>> = points
            .iter()
            .map(|point| {
                free += u32::from(point.is_free);
                point.is_free.then(|| free - 1)
            })
            .collect();
        structure.points = free as usize;
        let point_at = numbers.iter().map(|number| number.map(|number| next + 3 * number as usize)).collect();
        structure.links = observations
            .iter()
            .map(|seen| Link {
                station: station_block[seen.station],
                head: head_block[seen.head],
                point: numbers[seen.point],
            })
            .collect();
        Rig {
            reduced: next,
            stations,
            heads,
            points,
            observations,
            sigma_px,
            structure,
            station_block,
            head_block,
            station_at,
            head_at,
            point_at,
        }
    }

    /// Adds what is known of a station's numbers beforehand: rows of unit variance over phi, omega, kappa, X, Y, Z. It says
    /// nothing where the station is not unknown.
    pub fn expect_station(&mut self, station: usize, target: [f64; 6], rows: Vec<Vec<f64>>) {
        if let Some(block) = self.station_block[station].map(|block| block as usize) {
            self.structure.priors.push(super::Prior {
                place: super::Place::Block(block),
                target: target.to_vec(),
                rows,
            });
        }
    }

    /// Adds what is known of single numbers of a head beforehand: (index, value, sigma); those that are no unknowns are
    /// passed over.
    pub fn expect_head(&mut self, head: usize, known: &[(usize, f64, f64)]) {
        let Some(block) = self.head_block[head].map(|block| block as usize) else { return };
        let free = &self.heads[head].free;
        let known: Vec<_> = known
            .iter()
            .filter_map(|&(number, value, sigma)| Some((free.binary_search(&number).ok()?, value, sigma)))
            .collect();
        let place = super::Place::Block(block);
        self.structure.priors.push(super::Prior::of_sigmas(place, free.len(), &known));
    }

    /// Adds what is known of a point beforehand: rows of unit variance over X, Y, Z.
    pub fn expect_point(&mut self, point: usize, target: [f64; 3], rows: Vec<Vec<f64>>) {
        if let Some(at) = self.point_at[point] {
            let place = super::Place::Point((at - self.reduced) / 3);
            self.structure.priors.push(super::Prior { place, target: target.to_vec(), rows });
        }
    }

    /// Start values of all unknowns.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        let stations = self.stations.iter().filter(|station| station.is_free).flat_map(|station| station.values);
        let heads = self.heads.iter().flat_map(|head| head.free.iter().map(|number| head.values[*number]));
        let points = self.points.iter().filter(|point| point.is_free).flat_map(|point| point.position_m);
        stations.chain(heads).chain(points).collect()
    }

    /// A station's numbers at some values of the unknowns.
    #[must_use]
    pub fn station(&self, x: &[f64], station: usize) -> [f64; 6] {
        match self.station_at[station] {
            Some(at) => std::array::from_fn(|k| x[at + k]),
            None => self.stations[station].values,
        }
    }

    /// A head's numbers.
    #[must_use]
    pub fn head(&self, x: &[f64], head: usize) -> [f64; HEAD] {
        let mut values = self.heads[head].values;
        if let Some(at) = self.head_at[head] {
            for (k, number) in self.heads[head].free.iter().enumerate() {
                values[*number] = x[at + k];
            }
        }
        values
    }

    /// A point's position.
    #[must_use]
    pub fn point(&self, x: &[f64], point: usize) -> [f64; 3] {
        match self.point_at[point] {
            Some(at) => std::array::from_fn(|k| x[at + k]),
            None => self.points[point].position_m,
        }
    }

    /// Index of a head's number among the unknowns.
    #[must_use]
    pub fn head_unknown(&self, head: usize, number: usize) -> Option<usize> {
        Some(self.head_at[head]? + self.heads[head].free.binary_search(&number).ok()?)
    }

    /// Index of a station's first number among the unknowns.
    #[must_use]
    pub fn station_unknown(&self, station: usize) -> Option<usize> {
        self.station_at[station]
    }

    /// Index of a point's first coordinate among the unknowns.
    #[must_use]
    pub fn point_unknown(&self, point: usize) -> Option<usize> {
        self.point_at[point]
    }

    /// The point that the model counts as its `number`th.
    #[must_use]
    pub fn free_point(&self, number: usize) -> Option<usize> {
        (0..self.points.len()).filter(|point| self.points[*point].is_free).nth(number)
    }

    /// What an unknown of the reduced system is called: heads and stations are counted from 0, as in the files.
    #[must_use]
    pub fn name(&self, unknown: usize) -> String {
        for (station, at) in self.station_at.iter().enumerate() {
            if let Some(at) = at.filter(|at| (*at..at + 6).contains(&unknown)) {
                return format!("{} of station {station}", STATION_NAMES[unknown - at]);
            }
        }
        for (head, at) in self.head_at.iter().enumerate() {
            let free = &self.heads[head].free;
            if let Some(at) = at.filter(|at| (*at..at + free.len()).contains(&unknown)) {
                return format!("{} of head {head}", head_name(free[unknown - at]));
            }
        }
        format!("unknown {unknown}")
    }
}
