//! The elevation model beside a tile: from the ground that is flown over, or from a file.

use crate::scenario::{self, Scenario};
use crate::world::tile::Tile;
use crate::world::tile::elevation::Model;
use crate::world::{Bounds, Ground};
use plumbline_firmware::shared_memory::AREA_MAX;
use plumbline_survey::crs::Crs;
use plumbline_survey::dem::{DemFile, Heights};
use plumbline_survey::error::InputError;
use std::path::Path;

/// Posts around a tile for which a file is read. Chosen: one more than there are.
const AROUND: f64 = 2.0;

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

/// The model of an elevation model in a file, of any reference system that is known; without one it counts as on the tile's grid.
/// What the file does not know are posts without a height.
///
/// # Errors
/// A file that is missing or broken, or knows no height over the tile.
pub fn of_file(
    path: &Path,
    tile: &Tile,
    crs: &Crs,
    posts_m: f64,
    vertical_epsg: u32,
) -> Result<Option<Model>, InputError> {
    let named = |error: InputError| InputError::new(format!("{}: {error}", path.display()));
    let file = DemFile::open(path)?;
    let r = tile.resolution_m;
    let (width_m, depth_m) = ((tile.cols - 1) as f64 * r, (tile.rows - 1) as f64 * r);
    let [west_m, north_m] = [tile.west_m, tile.north_m];
    let tile_bounds = Bounds { west_m, east_m: west_m + width_m, south_m: north_m - depth_m, north_m };
    let Bounds { west_m, east_m, south_m, north_m } = tile_bounds.grown(AROUND * posts_m + r);
    let heights = Heights::over(&file, Some(crs), [west_m, south_m, east_m, north_m])?;
    let height = |east_m: f64, north_m: f64| heights.at(east_m, north_m);
    Model::over(tile, posts_m, vertical_epsg, height).map_err(named)
}
