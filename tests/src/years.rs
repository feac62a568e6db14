//! Patches of one orthophoto looked for in another of the same area, by both of the core's matchers alone: what they find between
//! years, and what they say of it.

pub mod chain;
pub mod displacements;
pub mod features;
pub mod made;
pub mod picture;
pub mod reliability;
pub mod table;

use crate::seeded::Random;
use displacements::Field;
use plumbline_core::image::{Run, View};
use plumbline_core::matching::Prior;
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::matching::correlation;
use plumbline_core::matching::directions::{self, Located, risk::Rule};
use plumbline_core::matching::search;
use plumbline_sim::camera::still_match::between;
use plumbline_sim::camera::still_match::quarters::{Odds, odds};
use plumbline_survey::error::InputError;
use plumbline_survey::io::raster::{GeoTransform, Raster};
use std::path::Path;

/// One orthophoto on a grid that several share.
#[derive(Clone, Debug)]
pub struct Year {
    /// The file's name without its folders.
    pub name: String,
    /// Where the grid lies.
    pub geo: GeoTransform,
    /// Columns of the grid.
    pub cols: usize,
    /// Rows of the grid.
    pub rows: usize,
    greys: Vec<f32>,
}

impl Year {
    /// The grey at a place between pixels; those of the border go on beyond it.
    fn at(&self, col: f64, row: f64) -> f64 {
        let (col, row) = (col.clamp(0.0, (self.cols - 1) as f64), row.clamp(0.0, (self.rows - 1) as f64));
        let (left, top) = ((col as usize).min(self.cols - 2), (row as usize).min(self.rows - 2));
        let (u, v) = (col - left as f64, row - top as f64);
        let grey = |dc: usize, dr: usize| f64::from(self.greys[(top + dr) * self.cols + left + dc]);
        (1.0 - v) * ((1.0 - u) * grey(0, 0) + u * grey(1, 0)) + v * ((1.0 - u) * grey(0, 1) + u * grey(1, 1))
    }
}

/// Orthophotos of one area, in one reference system and with pixels of one size, on the grid of their common upper left corner.
///
/// # Errors
/// A file is no raster, is of another reference system or pixel size than the first, or has nothing in common with the others.
pub fn years(paths: &[impl AsRef<Path>]) -> Result<Vec<Year>, InputError> {
    let rasters = paths.iter().map(|path| Raster::read(path.as_ref())).collect::<Result<Vec<_>, _>>()?;
    let Some(first) = rasters.first() else { return Ok(Vec::new()) };
    let step = [first.geo.step_x, first.geo.step_y];
    for (raster, path) in rasters.iter().zip(paths) {
        let alike = |own: f64, other: f64| (own / other - 1.0).abs() < 1e-6;
        let steps = alike(raster.geo.step_x, step[0]) && alike(raster.geo.step_y, step[1]);
        if raster.crs != first.crs || !steps {
            let what = "is of another reference system or pixel size than the first; bring them onto one grid first";
            return Err(InputError::new(format!("{} {what}", path.as_ref().display())));
        }
    }
    let corners: Vec<_> = rasters.iter().map(|raster| raster.geo.world_from_pixel(0.0, 0.0)).collect();
    let left = corners.iter().fold(f64::MIN, |left, corner| left.max(corner.0));
    let top = corners.iter().fold(f64::MAX, |top, corner| top.min(corner.1));
    let offset = |corner: &(f64, f64)| ((left - corner.0) / step[0], (corner.1 - top) / step[1]);
    // Between the last two pixels a grey is still known.
    let left_over = |length: usize, offset: f64| (length as f64 - offset - 1.0).max(0.0) as usize;
    let sizes = rasters.iter().zip(&corners).map(|(raster, corner)| {
        let (col, row) = offset(corner);
        (left_over(raster.cols, col), left_over(raster.rows, row))
    });
    let size = sizes.reduce(|a, b| (a.0.min(b.0), a.1.min(b.1))).unwrap_or_default();
    if size.0 == 0 || size.1 == 0 {
        return Err(InputError::new("the orthophotos have no area in common"));
    }
    let geo = GeoTransform { x0: left, y0: top, ..first.geo };
    let laid = rasters.iter().zip(&corners).zip(paths).map(|((raster, corner), path)| {
        let name = path.as_ref().file_name().unwrap_or_default().to_string_lossy().into_owned();
        let own = Year { name: name.clone(), geo, cols: raster.cols, rows: raster.rows, greys: raster.grey() };
        let (col, row) = offset(corner);
        let places = (0..size.1).flat_map(|y| (0..size.0).map(move |x| (x, y)));
        let greys = places.map(|(x, y)| own.at(x as f64 + col, y as f64 + row) as f32).collect();
        Year { name, geo, cols: size.0, rows: size.1, greys }
    });
    Ok(laid.collect())
}

/// Two years, and how far one lies beside the other.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    /// What patches are cut out of.
    pub ground: &'a Year,
    /// What they are looked for in.
    pub reference: &'a Year,
    /// Where another program has found the ground in the reference; the georeferences are true unless given.
    pub field: Option<&'a Field>,
}

impl Pair<'_> {
    /// How far what lies at a place of the grid is off it in the reference, pixels right and down.
    fn apart(&self, [col, row]: [f64; 2]) -> [f64; 2] {
        let Some(field) = self.field else { return [0.0; 2] };
        let geo = &self.ground.geo;
        let (east_m, north_m) = geo.world_from_pixel(col, row);
        let [east_m, north_m] = field.at(east_m, north_m);
        [east_m / geo.step_x, -north_m / geo.step_y]
    }
}

/// What a patch is looked for with, and how far it is from the picture it was cut out of.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Pixels along a side of the patch.
    pub side: u16,
    /// Pixels of the search to each side.
    pub radius: u16,
    /// One sigma of its turn, radians, and of its scale.
    pub turn_rad: f64,
    /// Of its scale.
    pub scale: f64,
    /// One sigma of its noise, grey levels.
    pub noise: f64,
}

/// What a matcher says of a trial.
#[derive(Clone, Copy, Debug)]
pub struct Answer {
    /// Found less true, pixels right and down.
    pub off: [f64; 2],
    /// Variances that it states, of the same.
    pub variance: [f64; 2],
    /// Its covariance of both.
    pub covariance: f64,
    /// The higher the surer: minus the log-odds of the risk that is stated, or the lead in its own deviations.
    pub confidence: f64,
    /// Probability of a wrong place, where the matcher states one.
    pub risk: Option<f64>,
    /// Whether it is to be believed, by the matcher's own rule.
    pub accepted: bool,
}

/// A trial's outcome.
#[derive(Clone, Copy, Debug)]
pub struct Outcome {
    /// The patch's centre in the grid.
    pub at: [f64; 2],
    /// Correlation of high-pass images.
    pub high_pass: Answer,
    /// Of gradient directions.
    pub directions: Answer,
    /// What the latter rests on.
    pub found: Located,
    /// What its quarters say where least squares hold.
    pub odds: Option<Odds>,
}

/// A patch of the ground, and the reference around the place where it is looked for.
struct Pictures {
    pixels: Vec<u8>,
    others: Vec<u8>,
    side: u16,
    window: u16,
}

impl Pictures {
    fn views(&self) -> Option<(View<'_>, View<'_>)> {
        Some((View::new(&self.pixels, (self.side, self.side))?, View::new(&self.others, (self.window, self.window))?))
    }
}

impl Trial {
    /// Looks for the patch of the pair's ground around a place of the grid in its reference; `None` where it has no texture.
    pub fn run(&self, pair: Pair<'_>, at: [usize; 2], seed: u64) -> Option<Outcome> {
        let mut random = Random::new(seed);
        let true_shift = self.shift(&mut random);
        let pictures = self.cut(pair, at, true_shift, &mut random);
        let views = pictures.views()?;
        let centre = [at[0] as f64 + true_shift[0], at[1] as f64 + true_shift[1]];
        let apart = pair.apart(centre);
        let true_shift = [0, 1].map(|axis| true_shift[axis] + apart[axis]);
        let (directions, found) = self.directions(views, true_shift)?;
        let prior = self.prior();
        let odds = found.holds.then(|| odds(&views.0, &self.runs(), (&views.1, self.radius), &found.solution, prior));
        Some(Outcome { at: centre, high_pass: self.high_pass(views, true_shift)?, directions, found, odds })
    }

    /// Uniform over the search, but for its border.
    fn shift(&self, random: &mut Random) -> [f64; 2] {
        let reach = f64::from(self.radius) - 2.0;
        [random.between(-reach, reach), random.between(-reach, reach)]
    }

    /// The patch of the ground that lies `true_shift` off a place of the grid, turned, scaled and with noise, and the reference there.
    fn cut(
        &self,
        Pair { ground, reference, .. }: Pair<'_>,
        at: [usize; 2],
        true_shift: [f64; 2],
        random: &mut Random,
    ) -> Pictures {
        let (turn, scale) = (self.turn_rad * random.normal(), 1.0 + self.scale * random.normal());
        let half = 0.5 * (f64::from(self.side) - 1.0);
        let (sin, cos) = turn.sin_cos();
        let noise: Vec<f64> = (0..usize::from(self.side).pow(2)).map(|_| self.noise * random.normal()).collect();
        let centre = [at[0] as f64 + true_shift[0], at[1] as f64 + true_shift[1]];
        let pixels: Vec<u8> = (0..noise.len())
            .map(|i| {
                let (x, y) = ((i % usize::from(self.side)) as f64 - half, (i / usize::from(self.side)) as f64 - half);
                let (x, y) = (scale * (cos * x - sin * y), scale * (sin * x + cos * y));
                (ground.at(centre[0] + x, centre[1] + y) + noise[i]).round().clamp(0.0, 255.0) as u8
            })
            .collect();
        let window = self.side + 2 * self.radius;
        let corner = [0, 1].map(|axis| at[axis] as f64 - 0.5 * (f64::from(window) - 1.0));
        let others: Vec<u8> = (0..usize::from(window).pow(2))
            .map(|i| {
                let (x, y) = (i % usize::from(window), i / usize::from(window));
                reference.at(corner[0] + x as f64, corner[1] + y as f64).round() as u8
            })
            .collect();
        Pictures { pixels, others, side: self.side, window }
    }

    fn runs(&self) -> Vec<Run> {
        (0..self.side).map(|row| Run { row, start: 0, end: self.side }).collect()
    }

    fn prior(&self) -> Prior {
        Prior { turn_rad: (self.turn_rad as f32).max(1e-3), scale: (self.scale as f32).max(1e-3) }
    }

    fn scores(&self) -> Vec<i16> {
        vec![0; (2 * usize::from(self.radius) + 1).pow(2)]
    }

    fn high_pass(&self, (patch, other): (View<'_>, View<'_>), true_shift: [f64; 2]) -> Option<Answer> {
        let (mut bytes, mut scores) = (vec![0; search::working_bytes(other.size())], self.scores());
        let rule = (self.prior(), &AcceptRule::default());
        let room = (bytes.as_mut_slice(), scores.as_mut_slice());
        let found = correlation::locate(&patch, &self.runs(), &other, self.radius, rule, room).ok()?;
        let (col, row) = found.shift();
        Some(Answer {
            off: [f64::from(col) - true_shift[0], f64::from(row) - true_shift[1]],
            variance: [0, 1].map(|axis| found.refined.map_or(f64::INFINITY, |s| f64::from(s.joint[(axis, axis)]))),
            covariance: found.refined.map_or(0.0, |s| f64::from(s.joint[(0, 1)])),
            confidence: f64::from(found.peak.score - found.peak.second) * f64::from(self.side),
            risk: None,
            accepted: found.accepted.is_ok(),
        })
    }

    fn directions(&self, (patch, other): (View<'_>, View<'_>), true_shift: [f64; 2]) -> Option<(Answer, Located)> {
        let bytes = directions::search::working_bytes(patch.size(), other.size());
        let (mut bytes, mut scores) = (vec![0; bytes], self.scores());
        let rule = (self.prior(), &Rule::default());
        let room = (bytes.as_mut_slice(), scores.as_mut_slice());
        let found = directions::locate(&patch, &self.runs(), &other, self.radius, rule, room).ok()?;
        let solution = between::solution(&patch, &self.runs(), (&other, self.radius), &found, self.prior(), 0.0);
        let (evidence, risk) = (found.peak.evidence, f64::from(found.risk));
        // Below the least risk that is stated it goes on by what the odds are made of.
        let strength = f64::from(evidence.lead * evidence.curvature) * f64::from(self.side).powi(2);
        let sure = -(risk / (1.0 - risk).max(1e-9)).ln() + 1e-3 * strength;
        let answer = Answer {
            off: [f64::from(solution.d_col) - true_shift[0], f64::from(solution.d_row) - true_shift[1]],
            variance: [0, 1].map(|axis| f64::from(solution.joint[(axis, axis)])),
            covariance: solution.joint[(0, 1)].into(),
            confidence: if found.peak.on_border { f64::MIN } else { sure },
            risk: Some(risk).filter(|_| !found.peak.on_border),
            accepted: found.accepted.is_ok(),
        };
        Some((answer, found))
    }
}
