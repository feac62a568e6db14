//! Made-up land before and after changes, as many of it as anybody wants.

use super::Year;
use plumbline_sim::scenario::{Changes, Land, Season};
use plumbline_sim::world::{Ground, procedural_as};
use plumbline_survey::io::raster::GeoTransform;

/// Metres a pixel. Chosen: a field of 100 to 200 m then has some 50 pixels a side, as those of the real years have.
const PIXEL_M: f64 = 3.0;
/// Sun of the scenario `shadows`, season of `seasons`.
const SUN_DEG: (f64, f64) = (280.0, 15.0);
const SEASON: Season = Season { bare: [0.6, 10.0], crops: [1.1, 45.0], meadow: [0.8, -10.0], trees: [1.3, 0.0] };

/// The land of a seed as the reference has it, and after each of several changes: those of the scenarios of hard ground and some of them together.
/// `repeats`: parcels that are nearly alike instead of what the land itself has.
#[must_use]
pub fn made(seed: u64, repeats: bool) -> (Year, Vec<Year>) {
    let land = if repeats { Land { parcel_m: 40.0, repeats: 0.9, ..Land::default() } } else { Land::default() };
    let none = Changes::default();
    let sun = Changes { sun_azimuth_deg: Some(SUN_DEG.0), sun_elevation_deg: Some(SUN_DEG.1), ..none };
    let changes = [
        Changes { season: SEASON, ..none },
        Changes { ploughed_fraction: 0.6, ..none },
        Changes { flooded_fraction: 0.5, ..none },
        Changes { inverted_fraction: 0.5, ..none },
        sun,
        Changes { season: SEASON, ploughed_fraction: 0.9, flooded_fraction: 0.2, ..sun },
    ];
    let year = |changes| sampled(&procedural_as(seed, land, changes), format!("made {seed}"));
    (year(none), changes.into_iter().map(year).collect())
}

/// Means of the ground's own pixels.
fn sampled(ground: &Ground, name: String) -> Year {
    const FINE: usize = 3;
    let bounds = ground.bounds();
    let geo =
        GeoTransform { x0: bounds.west_m + PIXEL_M, y0: bounds.north_m - PIXEL_M, step_x: PIXEL_M, step_y: PIXEL_M };
    let count = |length_m: f64| (length_m / PIXEL_M) as usize - 2;
    let (cols, rows) = (count(bounds.east_m - bounds.west_m), count(bounds.north_m - bounds.south_m));
    let grey = |col: usize, row: usize| {
        let by = |at: usize| (at as f64 + 0.5) / FINE as f64 - 0.5;
        let fine = (0..FINE * FINE).map(|at| {
            let (east, north) = geo.world_from_pixel(col as f64 + by(at % FINE), row as f64 + by(at / FINE));
            ground.albedo(east, north).unwrap_or_default()
        });
        (fine.sum::<f64>() / (FINE * FINE) as f64) as f32
    };
    let greys =
        (0..rows).flat_map(|row| (0..cols).map(move |col| (col, row))).map(|(col, row)| grey(col, row)).collect();
    Year { name, geo, cols, rows, greys }
}
