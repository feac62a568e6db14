//! The elevation model beside a tile: from the ground that is flown over, or from a file.

use crate::scenario::{self, Scenario};
use crate::world::tile::Tile;
use crate::world::tile::elevation::Model;
use crate::world::{Bounds, Grid, Ground};
use plumbline_firmware::shared_memory::AREA_MAX;
use plumbline_survey::crs::{Crs, System};
use plumbline_survey::dem::{Dem, DemFile, Heights};
use plumbline_survey::error::InputError;
use plumbline_survey::io::raster::{Posts, Raster, SampleType, check_elevation, check_square};
use plumbline_survey::io::shell::quoted;
use plumbline_survey::plan::file::{Vertical, above_the_sea};
use std::path::Path;

/// Posts around a tile for which a file is read. Chosen: one more than there are.
const AROUND: f64 = 2.0;
/// In a store: nobody says what its heights are above.
const NOT_KNOWN: u32 = 0;

/// The model of a flight: what the ground itself is made of, at the scenario's posts. `None` where it is not made of an elevation
/// model, and where that is level.
///
/// # Errors
/// One sentence where it does not fit beside the tile.
pub(super) fn of_flight(
    scenario: &Scenario,
    ground: &Ground,
    tile: &Tile,
    is_planned: bool,
) -> Result<Option<Model>, InputError> {
    let reference = &scenario.world.reference;
    let has_dem = matches!(&scenario.world.ground, scenario::Ground::Ortho { dem: Some(_), .. });
    if reference.elevation_posts_m == 0.0 || !(has_dem || is_planned) {
        return Ok(None);
    }
    let height = |east_m: f64, north_m: f64| Some(ground.height(east_m, north_m) + reference.elevation_bias_m);
    let model = Model::over(tile, reference.elevation_posts_m, reference.elevation_epsg, height)?;
    if model.as_ref().is_some_and(|model| tile.pixels.len() + model.bytes.len() > AREA_MAX) {
        return Err(InputError::new(format!(
            "{}: posts {} m apart do not fit the board's flash beside the reference; reference.elevation_posts_m says how far",
            scenario.file, reference.elevation_posts_m
        )));
    }
    Ok(model)
}

/// The elevation model under an orthophoto that is in a reference system.
pub(super) fn surface(path: &Path, (ortho, epsg): (&Path, u32)) -> Result<Grid, InputError> {
    let raster = Raster::read(path)?;
    if let Some(other) = raster.crs.filter(|other| *other != System::Epsg(epsg)) {
        return Err(InputError::new(format!(
            "{} is in EPSG:{epsg}, but the elevation model in {other}: gdalwarp -t_srs EPSG:{epsg} -r bilinear {} {}",
            ortho.display(),
            quoted(&path.display().to_string()),
            quoted(&path.with_extension(format!("{epsg}.tif")).display().to_string())
        )));
    }
    check_square(path, &raster.geo, "bilinear")?;
    check_elevation(path, raster.bands, raster.sample_type == SampleType::U8)?;
    let post = |index: usize| raster.sample(index % raster.cols, index / raster.cols, 0).map_or(f64::NAN, f64::from);
    let samples: Vec<f64> = (0..raster.rows * raster.cols).map(post).collect();
    let place = |index: usize| raster.geo.world_from_pixel((index % raster.cols) as f64, (index / raster.cols) as f64);
    let posts = Posts {
        path,
        samples: &samples,
        cols: raster.cols,
        step_m: [raster.geo.step_x, raster.geo.step_y],
        scaling: raster.scalings[0],
        unit_m: raster.height_unit_m,
        has_nodata: raster.nodata.is_some(),
        are_declared_heights: raster.has_heights,
        is_ascii: false,
        place: &place,
    };
    posts.check()?;
    let heights = samples.iter().map(|sample| posts.height_m(*sample) as f32).collect();
    Ok(super::grid(&raster, heights))
}

/// What speaks against the heights of the elevation model under an orthophoto, with the model's name.
///
/// # Errors
/// The model cannot be read.
pub(super) fn doubt(scenario: &Scenario, ground: &Ground) -> Result<Option<String>, InputError> {
    let scenario::Ground::Ortho { dem: Some(path), .. } = &scenario.world.ground else { return Ok(None) };
    let Some(grid) = ground.surface_grid() else { return Ok(None) };
    let heights = Dem {
        cols: grid.cols,
        rows: grid.rows,
        // Where it lies and which way is up makes no difference to steepness.
        west_m: 0.0,
        south_m: 0.0,
        step_m: [grid.step_m; 2],
        heights: grid.data.iter().map(|height| f64::from(*height)).collect(),
    };
    let doubt = heights.doubt(DemFile::open(path)?.is_unit_stated());
    Ok(doubt.map(|doubt| doubt.of(path)))
}

/// The model of an elevation model in a file, of any reference system that is known; without one it counts as on the tile's grid.
/// What the file does not know are posts without a height. With it what speaks against its heights. They are above what the file says, or
/// `vertical_epsg` where it says nothing.
///
/// # Errors
/// A file that is missing or broken, or knows no height over the tile; heights that are none in metres above the sea, or that the file says to be
/// above something else.
pub fn of_file(
    path: &Path,
    tile: &Tile,
    crs: &Crs,
    posts_m: f64,
    vertical_epsg: Option<u16>,
) -> Result<(Option<Model>, Option<String>), InputError> {
    let named = |error: InputError| InputError::new(format!("{}: {error}", path.display()));
    let file = DemFile::open(path)?;
    above_the_sea(&file, "")?;
    let vertical = Vertical::new(file.height_datum(), vertical_epsg, None)?;
    let r = tile.resolution_m;
    let (width_m, depth_m) = ((tile.cols - 1) as f64 * r, (tile.rows - 1) as f64 * r);
    let [west_m, north_m] = [tile.west_m, tile.north_m];
    let tile_bounds = Bounds { west_m, east_m: west_m + width_m, south_m: north_m - depth_m, north_m };
    let Bounds { west_m, east_m, south_m, north_m } = tile_bounds.grown(AROUND * posts_m + r);
    let heights = Heights::over(&file, Some(crs), [west_m, south_m, east_m, north_m])?;
    let height = |east_m: f64, north_m: f64| heights.at(east_m, north_m);
    let model = Model::over(tile, posts_m, vertical.epsg.unwrap_or(NOT_KNOWN), height).map_err(named)?;
    if let Some(model) = model.as_ref().filter(|model| !model.has_cell()) {
        let (cols, rows) = model.posts.size;
        let (voids, all) = (model.voids(), usize::from(cols) * usize::from(rows));
        return Err(named(InputError::new(format!(
            "{voids} of {all} posts {posts_m} m apart have no height, and nowhere do four around a place, so that no height is known: a smaller \
             --posts-m, or a model that covers the tile, gives them"
        ))));
    }
    Ok((model, heights.doubt().map(|doubt| doubt.of(path))))
}
