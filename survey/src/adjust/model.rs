//! What the solver has to know of an adjustment: its unknowns, what each observation touches, its derivatives.
//!
//! The unknowns are *blocks* that stay in the reduced system (a station's orientation, what the stations of one head
//! share) followed by *points*, three numbers each, which are eliminated. All unknowns are plain numbers to which a step is
//! added.

/// Most unknowns of a station's block: 6, or 9 in Bundle Adjustment in the Large.
pub const STATION_MAX: usize = 9;
/// Most unknowns of a head's block.
pub const HEAD_MAX: usize = 15;

/// What an image observation touches; `None` is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Link {
    /// Block of the station.
    pub station: Option<u32>,
    /// Block of the head.
    pub head: Option<u32>,
    /// The point.
    pub point: Option<u32>,
}

/// One observation (two equations) at some values of the unknowns, divided by its standard deviation.
#[derive(Clone, Debug)]
pub struct Row {
    /// Computed minus observed.
    pub residual: [f64; 2],
    /// Its derivatives by the station's block.
    pub station: [[f64; STATION_MAX]; 2],
    /// By the head's block.
    pub head: [[f64; HEAD_MAX]; 2],
    /// By the point.
    pub point: [[f64; 3]; 2],
}

impl Row {
    /// All zero.
    #[must_use]
    pub fn zero() -> Self {
        Row { residual: [0.0; 2], station: [[0.0; STATION_MAX]; 2], head: [[0.0; HEAD_MAX]; 2], point: [[0.0; 3]; 2] }
    }

    /// Multiplied by a number.
    pub(super) fn scale(&mut self, by: f64) {
        let all = self.residual.iter_mut().chain(self.station.as_flattened_mut());
        all.chain(self.head.as_flattened_mut()).chain(self.point.as_flattened_mut()).for_each(|value| *value *= by);
    }
}

/// Where a prior acts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// A block of the reduced system.
    Block(usize),
    /// A point.
    Point(usize),
}

/// Something known of one block or point beforehand: residual `rows` (x - target), of unit variance.
#[derive(Clone, Debug, PartialEq)]
pub struct Prior {
    /// Of which.
    pub place: Place,
    /// Expected values, as many as the block has.
    pub target: Vec<f64>,
    /// Whitening rows, each as long as the target.
    pub rows: Vec<Vec<f64>>,
}

impl Prior {
    /// Single unknowns with their standard deviations: (index in the block, expected value, sigma).
    #[must_use]
    pub fn of_sigmas(place: Place, size: usize, known: &[(usize, f64, f64)]) -> Self {
        let mut target = vec![0.0; size];
        let mut rows = Vec::new();
        for &(index, value, sigma) in known {
            target[index] = value;
            let mut row = vec![0.0; size];
            row[index] = 1.0 / sigma;
            rows.push(row);
        }
        Prior { place, target, rows }
    }

    /// The residuals at some values.
    pub(super) fn residuals<'a>(&'a self, x: &'a [f64]) -> impl Iterator<Item = f64> + 'a {
        self.rows.iter().map(move |row| row.iter().zip(x.iter().zip(&self.target)).map(|(a, (x, t))| a * (x - t)).sum())
    }
}

/// The shape of an adjustment.
#[derive(Clone, Debug, Default)]
pub struct Structure {
    /// Unknowns of each block, in the order of the state.
    pub sizes: Vec<usize>,
    /// Number of points.
    pub points: usize,
    /// One an observation.
    pub links: Vec<Link>,
    /// What is known beforehand.
    pub priors: Vec<Prior>,
}

impl Structure {
    /// Unknowns of all blocks.
    #[must_use]
    pub fn reduced(&self) -> usize {
        self.sizes.iter().sum()
    }

    /// All unknowns.
    #[must_use]
    pub fn unknowns(&self) -> usize {
        self.reduced() + 3 * self.points
    }

    /// All equations.
    #[must_use]
    pub fn equations(&self) -> usize {
        2 * self.links.len() + self.priors.iter().map(|prior| prior.rows.len()).sum::<usize>()
    }
}

/// An adjustment's functional model.
pub trait Model: Sync {
    /// The model at some values of the unknowns.
    type At<'a>: At
    where
        Self: 'a;

    /// Its shape.
    fn structure(&self) -> &Structure;

    /// Prepares what the observations have in common.
    fn at<'a>(&'a self, x: &'a [f64]) -> Self::At<'a>;
}

/// A model at some values of its unknowns.
pub trait At: Sync {
    /// The residual of an observation; `None` where the point is not in front of the camera.
    fn residual(&self, observation: usize) -> Option<[f64; 2]>;

    /// The residual and its derivatives; whether the point is in front of the camera.
    fn linearise(&self, observation: usize, row: &mut Row) -> bool;
}
