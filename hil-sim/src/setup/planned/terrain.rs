//! The plan's elevation model as the ground that is flown over.

use super::Planned;
use super::place::Place;
use crate::world::{Bounds, Grid};
use plumbline_survey::crs::System;
use plumbline_survey::dem::{Dem, DemFile, Frame};
use plumbline_survey::error::InputError;
use plumbline_survey::io::input::sha256;
use plumbline_survey::plan::PlanFile;
use rayon::prelude::{IndexedParallelIterator, ParallelIterator, ParallelSliceMut};
use std::iter;
use std::path::Path;

/// Most posts along a side of the ground: 64 MB of heights.
const SIDE_MAX: usize = 4096;
/// Posts from one converted place to the next, between which places are interpolated: over 16 posts of 30 m the curvature
/// of a meridian on a grid is below a centimetre.
const LATTICE: usize = 16;

/// An elevation model in its own frame.
#[derive(Debug)]
pub struct Terrain {
    dem: Dem,
    frame: Frame,
    is_unit_stated: bool,
    /// Of what is unknown.
    base_height_m: f64,
}

impl Terrain {
    /// The plan's model, or `other` in its place, as far as `bounds` of the grid reach.
    ///
    /// # Errors
    /// A file that is missing or broken, of another reference system than the plan's, or elsewhere.
    pub fn read(
        file: &PlanFile,
        plan_path: &Path,
        other: Option<&Path>,
        place: &Place,
        bounds: &Bounds,
    ) -> Result<Self, InputError> {
        let path = other.map_or_else(|| file.model_path(plan_path), |other| Ok(other.to_owned()))?;
        let opened = DemFile::open(&path)?;
        let planned = file.epsg.map(System::Epsg);
        if opened.system() != planned {
            let named = |system: Option<System>| system.map_or("local metres".to_owned(), |system| system.to_string());
            return Err(InputError::new(format!(
                "{}: the elevation model is in {}, the plan in {}",
                path.display(),
                named(opened.system()),
                named(planned)
            )));
        }
        let frame = Frame::new(planned, place.plan(bounds.centre())?)?;
        let Bounds { west_m, east_m, south_m, north_m } = *bounds;
        let mut wanted = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        // Grids are turned against each other: the borders' middles count too.
        for [u, v] in [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 0.5], [1.0, 0.5], [0.0, 1.0], [0.5, 1.0], [1.0, 1.0]] {
            let corner = [west_m + u * (east_m - west_m), south_m + v * (north_m - south_m)];
            let [x, y] = frame.metres(place.plan(corner)?);
            wanted = [wanted[0].min(x), wanted[1].min(y), wanted[2].max(x), wanted[3].max(y)];
        }
        let dem = opened.window(&frame, wanted, &mut |_, _| {})?;
        let is_unit_stated = opened.is_unit_stated();
        Ok(Terrain { dem, frame, is_unit_stated, base_height_m: file.base_height_m })
    }

    /// What has to be known of a flight over `other`, which this is, in the place of the plan's own model: nothing where both are one
    /// file.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn instead_of(&self, planned: &Planned, plan_path: &Path, other: &Path) -> Result<Vec<String>, InputError> {
        let (plan, file) = (&planned.file, other.display());
        if plan.dem_sha256.as_ref() == Some(&sha256(other)?) {
            return Ok(Vec::new());
        }
        let lowest_m =
            planned.lines.iter().flat_map(|line| &line.heights).map(|point| point[1]).fold(f64::MAX, f64::min);
        let [_, high_m] = self.range_m();
        let above = if high_m > lowest_m {
            format!("; its ground rises to {high_m:.1} m, above the lowest flying height of {lowest_m:.1} m")
        } else {
            String::new()
        };
        let instead = format!(
            "--dem {file}: not the elevation model that {} was made over ({}), so its clearance and overlap need not hold here, \
             `plumbline plan --dem {file}` makes a plan that does{above}",
            plan_path.display(),
            plan.dem
        );
        let doubt = self.dem.doubt(self.is_unit_stated).map(|doubt| doubt.of(other));
        Ok(iter::once(instead).chain(doubt).collect())
    }

    /// Lowest and highest known height.
    pub fn range_m(&self) -> [f64; 2] {
        self.dem.range_m().unwrap_or([self.base_height_m; 2])
    }

    /// Heights on the grid over all of `bounds`: bilinear, and the base plane's where the model knows nothing.
    ///
    /// # Errors
    /// A place that the plan's system does not have.
    pub fn surface(&self, place: &Place, bounds: &Bounds) -> Result<Grid, InputError> {
        let (width_m, depth_m) = (bounds.east_m - bounds.west_m, bounds.north_m - bounds.south_m);
        let [step_x, step_y] = self.dem.step_m;
        let step_m = step_x.min(step_y).max(width_m.max(depth_m) / (SIDE_MAX - 2) as f64);
        let count = |length_m: f64| (length_m / step_m).ceil() as usize + 2;
        let (cols, rows) = (count(width_m), count(depth_m));
        // Where the lattice's nodes are in the model's metres.
        let (nodes_across, nodes_down) = (cols.div_ceil(LATTICE) + 1, rows.div_ceil(LATTICE) + 1);
        let node = |index: usize| {
            let along = |count: usize| (count * LATTICE) as f64 * step_m;
            let (col, row) = (index % nodes_across, index / nodes_across);
            Ok(self.frame.metres(place.plan([bounds.west_m + along(col), bounds.north_m - along(row)])?))
        };
        let nodes = (0..nodes_across * nodes_down).map(node).collect::<Result<Vec<[f64; 2]>, InputError>>()?;
        let mut data = vec![0.0f32; cols * rows];
        data.par_chunks_mut(cols).enumerate().for_each(|(row, heights)| {
            let (down, v) = (row / LATTICE, (row % LATTICE) as f64 / LATTICE as f64);
            for (col, height) in heights.iter_mut().enumerate() {
                let (across, u) = (col / LATTICE, (col % LATTICE) as f64 / LATTICE as f64);
                let at = |right: usize, below: usize| nodes[(down + below) * nodes_across + across + right];
                let [x, y] = [0, 1].map(|axis| {
                    let upper = at(0, 0)[axis] * (1.0 - u) + at(1, 0)[axis] * u;
                    let lower = at(0, 1)[axis] * (1.0 - u) + at(1, 1)[axis] * u;
                    upper * (1.0 - v) + lower * v
                });
                *height = self.dem.height(x, y).unwrap_or(self.base_height_m) as f32;
            }
        });
        Ok(Grid { cols, rows, west_m: bounds.west_m, north_m: bounds.north_m, step_m, data })
    }
}
