//! The elevation model beside a tile: from the ground that is flown over, or from a file.

use super::grown;
use crate::scenario::{self, Scenario};
use crate::world::tile::Tile;
use crate::world::tile::elevation::Model;
use crate::world::{Bounds, Ground};
use plumbline_firmware::shared_memory::AREA_MAX;
use plumbline_survey::crs::Crs;
use plumbline_survey::dem::{DemFile, Frame};
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
    let other = file.epsg().filter(|&epsg| epsg != crs.epsg()).map(Crs::from_epsg).transpose().map_err(named)?;
    let in_file = |[east_m, north_m]: [f64; 2]| match &other {
        None => Ok([east_m, north_m]),
        Some(other) => {
            let (lat_deg, lon_deg) = crs.to_wgs84(east_m, north_m)?;
            other.from_wgs84(lat_deg, lon_deg).map(|(x, y)| [x, y])
        }
    };
    let r = tile.resolution_m;
    let (width_m, depth_m) = ((tile.cols - 1) as f64 * r, (tile.rows - 1) as f64 * r);
    let [west_m, north_m] = [tile.west_m, tile.north_m];
    let tile_bounds = Bounds { west_m, east_m: west_m + width_m, south_m: north_m - depth_m, north_m };
    let Bounds { west_m, east_m, south_m, north_m } = grown(&tile_bounds, AROUND * posts_m + r);
    let frame = Frame::new(file.epsg(), in_file(tile.centre()).map_err(named)?).map_err(named)?;
    let mut wanted = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    // Grids are turned against each other: the borders' middles count too.
    for [u, v] in [[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [0.0, 0.5], [1.0, 0.5], [0.0, 1.0], [0.5, 1.0], [1.0, 1.0]] {
        let place = [west_m + u * (east_m - west_m), south_m + v * (north_m - south_m)];
        let [x, y] = frame.metres(in_file(place).map_err(named)?);
        wanted = [wanted[0].min(x), wanted[1].min(y), wanted[2].max(x), wanted[3].max(y)];
    }
    let dem = file.window(&frame, wanted, &mut |_, _| {})?;
    let height = |east_m: f64, north_m: f64| {
        let [x, y] = frame.metres(in_file([east_m, north_m]).ok()?);
        dem.height(x, y)
    };
    Model::over(tile, posts_m, vertical_epsg, height).map_err(named)
}
