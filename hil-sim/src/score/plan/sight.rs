//! Which of the photos that were taken see a ground point, and by which ray.

use crate::camera::render::Station;
use crate::setup::Setup;
use plumbline_survey::plan::axes::Axes;
use plumbline_survey::plan::cells::{Cell, Cells};
use plumbline_survey::plan::sight::Ray;
use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};

/// A ground point is hidden where its ray ends so much above it, as a share of the ray: bilinear ground is met within 1e-9.
const HIDDEN: f64 = 1e-3;

/// A photo with the pose of its middle.
#[derive(Clone, Copy, Debug)]
pub struct Taken {
    /// Its strip, in the order of flight.
    pub strip: usize,
    /// Its number among those taken of the strip.
    pub photo: usize,
    /// Where it was taken from.
    pub station: Station,
}

/// Of each cell inside the area the rays of the photos that see its centre, strip by strip, in level tangents along and across
/// the strips' axes.
pub fn see(setup: &Setup, axes: &Axes, cells: &Cells, taken: &[Taken]) -> Vec<Vec<Ray>> {
    let rays = |cell: &Cell| {
        let [east, north] = cells.centre(cell.col, cell.row);
        let point = [east, north, setup.ground.height(east, north)];
        taken.iter().filter_map(|photo| ray(setup, axes, photo, point)).collect()
    };
    cells.inside.par_iter().map(rays).collect()
}

fn ray(setup: &Setup, axes: &Axes, photo: &Taken, point: [f64; 3]) -> Option<Ray> {
    let station = &photo.station;
    let camera = setup.renderer.camera();
    let (col, row) = setup.renderer.project(station, point)?;
    let inside = |at: f64, count: usize| (-0.5..=count as f64 - 0.5).contains(&at);
    if !(inside(col, camera.cols) && inside(row, camera.rows)) {
        return None;
    }
    let eye = [station.east_m, station.north_m, station.up_m];
    let sight: [f64; 3] = std::array::from_fn(|axis| point[axis] - eye[axis]);
    let hit = setup.ground.intersect(eye, sight)?;
    let depth_m = -sight[2];
    let is_seen = depth_m > 0.0 && (hit[2] - point[2]).abs() <= HIDDEN * depth_m;
    if !is_seen {
        return None;
    }
    let tangent = axes.of([sight[0] / depth_m, sight[1] / depth_m]);
    Some(Ray { strip: photo.strip, photo: photo.photo, tangent, depth_m })
}
