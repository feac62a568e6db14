//! A procedural landscape for flights without data: fields, woods, a river, roads, villages with houses that stand up.
//!
//! It is no model of any place. What matters is that it carries texture at every scale from half a metre to 200 m, so that
//! the matching has something to hold on to everywhere, and that houses have true heights, so that what a real frame does
//! at a roof happens here too. Everything follows from the seed; each ingredient draws from its own ChaCha stream, so a
//! change to one leaves the others.
//!
//! Local coordinates in here: `[x east, y north]` in metres from the centre of the land.

mod buildings;
mod changes;
mod fractal;
mod layout;
mod paint;
mod parcels;
mod pattern;
mod polygon;
mod sun;
mod trees;
mod water;

use super::{Bounds, Grid, Ground, GroundError};
use crate::scenario::{Changes, Land};
use std::sync::{Mutex, PoisonError};
pub(super) use water::{Lakes, wavy};

/// Pixels a side.
const SIDE: usize = 3600;
/// Metres a pixel.
const STEP_M: f64 = 0.5;
/// Where it lies, and with it a plan that names no place: EPSG code, grid east and north of the centre. Chosen: farmland west of
/// Vienna.
pub const PROCEDURAL_PLACE: (u32, [f64; 2]) = (EPSG, [CENTRE_EAST_M, CENTRE_NORTH_M]);
const EPSG: u32 = 32633;
const CENTRE_EAST_M: f64 = 560_000.0;
const CENTRE_NORTH_M: f64 = 5_330_000.0;
/// Stretch of the finished picture about its middle grey.
const CONTRAST: f32 = 1.2;

/// Landscapes that stay in memory, 100 MB each: a program flies over one, tests of flights over a few in turn.
const KEPT: usize = 3;
/// The last landscapes and what they were painted from, the last used at the end. Painting one takes seconds of all cores.
static PAINTED: Mutex<Vec<(Painting, Ground)>> = Mutex::new(Vec::new());

/// What decides a landscape.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Painting {
    seed: u64,
    land: Land,
    changes: Changes,
}

/// Streams of the seed, one an ingredient. Fractals use up to 16 numbers from theirs on.
mod streams {
    pub(super) const LAYOUT: u64 = 1;
    pub(super) const TREES: u64 = 2;
    pub(super) const BUILDINGS: u64 = 3;
    pub(super) const CHANGES: u64 = 4;
    pub(super) const LAKES: u64 = 5;
    pub(super) const WAVES: u64 = 6;
    pub(super) const SOIL: u64 = 0x30;
    pub(super) const GRAIN: u64 = 0x40;
}

/// Local coordinate of a pixel index along one axis, west to east or (negated) north to south.
fn local_m(index: usize) -> f64 {
    (index as f64 - (SIDE as f64 - 1.0) / 2.0) * STEP_M
}

/// Fractional pixel (col, row) of a local point.
fn pixel_of([x, y]: [f64; 2]) -> [f64; 2] {
    let middle = (SIDE as f64 - 1.0) / 2.0;
    [x / STEP_M + middle, middle - y / STEP_M]
}

/// Pixel indices from `low` to `high` inclusive that lie on the land.
fn clipped(low: f64, high: f64) -> std::ops::Range<usize> {
    let limit = SIDE as f64;
    (low.floor().clamp(0.0, limit) as usize)..((high.ceil() + 1.0).clamp(0.0, limit) as usize)
}

/// A seeded landscape of 1.8 km x 1.8 km at 0.5 m, EPSG:32633, centred at 560000 E, 5330000 N.
///
/// Flat at height 0 but for the houses (roofs 4 to 15 m high, in the surface); trees are painted, not raised. The same
/// seed gives the same bytes. About 100 MB.
pub fn procedural(seed: u64) -> Ground {
    procedural_as(seed, Land::default(), Changes::default())
}

/// As [`procedural`], of such land, after such changes.
pub fn procedural_as(seed: u64, land: Land, changes: Changes) -> Ground {
    let painting = Painting { seed, land, changes };
    let painted = || PAINTED.lock().unwrap_or_else(PoisonError::into_inner);
    let taken = |kept: &mut Vec<(Painting, Ground)>| {
        let index = kept.iter().position(|(of, _)| *of == painting)?;
        Some(kept.remove(index).1)
    };
    // Not locked while painting, which waits for other threads that may want a landscape, too.
    let found = taken(&mut painted());
    let ground = found.unwrap_or_else(|| painted_anew(&painting));
    let mut kept = painted();
    // Another thread may have painted the same.
    let ground = taken(&mut kept).unwrap_or(ground);
    if kept.len() == KEPT {
        kept.remove(0);
    }
    kept.push((painting, ground.clone()));
    ground
}

/// The landscape of [`procedural`] in a square of `side_m` around `centre` of the system `epsg`: in its middle, and beyond its
/// borders continued by its mirror images. Nothing more is painted or kept, however large it is.
pub fn procedural_around(seed: u64, epsg: u32, centre: [f64; 2], side_m: f64) -> Ground {
    procedural(seed).mirrored(epsg, centre, side_m)
}

fn painted_anew(&Painting { seed, land, changes }: &Painting) -> Ground {
    let mut layout = layout::Layout::new(seed);
    let grain = fractal::fractal(seed, streams::GRAIN, SIDE, 9);
    let sun = sun::direction(&changes);
    let lakes = (land.water_fraction > 0.0).then(|| Lakes::new(seed, land.water_fraction));
    let stands = |at: [f64; 2]| !land.has_pattern() && lakes.as_ref().is_none_or(|lakes| lakes.is_dry(at));
    let mut houses = buildings::place(seed, &layout);
    let mut trees = trees::place(seed, &layout, &houses);
    houses.retain(|house| stands(house.at()));
    trees.retain(|tree| stands(tree.at()));
    // What grows and is built stays when the fields change.
    changes::make(&changes, seed, &mut layout);
    let mut albedo = paint::paint(&layout, &grain);
    pattern::lay(&land, &mut albedo, &grain);
    trees::draw(&mut albedo, &trees, &grain, sun, changes.season.trees);
    let mut surface = vec![0f32; SIDE * SIDE];
    buildings::draw(&mut albedo, &mut surface, &houses, &grain, sun);
    buildings::shade(&mut albedo, &surface, &houses, sun);
    for value in &mut albedo {
        *value = (118.0 + CONTRAST * (*value - 118.0)).clamp(6.0, 250.0);
    }
    if let Some(lakes) = &lakes {
        water::fill(lakes, seed, &mut albedo);
    }
    let grid = |data| Grid {
        cols: SIDE,
        rows: SIDE,
        west_m: CENTRE_EAST_M + local_m(0),
        north_m: CENTRE_NORTH_M - local_m(0),
        step_m: STEP_M,
        data,
    };
    Ground::from_checked(grid(albedo), grid(surface), EPSG)
}

/// The landscape of [`procedural`] as a texture over another `surface`: its picture, without the houses' heights, stretched
/// over all of `bounds`, which is finer than needed where they are smaller than the landscape. Both are in the system
/// `epsg`.
///
/// # Errors
/// A surface that is no ground.
pub fn draped(seed: u64, bounds: &Bounds, surface: Grid, epsg: u32) -> Result<Ground, GroundError> {
    let side_m = (bounds.east_m - bounds.west_m).max(bounds.north_m - bounds.south_m);
    let landscape = procedural(seed);
    let data = landscape.albedo_grid().data.clone();
    let step_m = side_m / (SIDE - 1) as f64;
    let albedo = Grid { cols: SIDE, rows: SIDE, west_m: bounds.west_m, north_m: bounds.north_m, step_m, data };
    Ground::new(albedo, Some(surface), epsg)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Root mean square difference between the means of neighbouring blocks of `size` x `size` pixels.
    fn contrast(data: &[f32], size: usize) -> f64 {
        let across = SIDE / size;
        let mean = |col: usize, row: usize| {
            let of_row = |r: usize| data[r * SIDE + col * size..][..size].iter().map(|&v| f64::from(v)).sum::<f64>();
            (row * size..(row + 1) * size).map(of_row).sum::<f64>() / (size * size) as f64
        };
        let squares = (0..across).flat_map(|row| (0..across - 1).map(move |col| (col, row)));
        let sum: f64 = squares.map(|(col, row)| (mean(col, row) - mean(col + 1, row)).powi(2)).sum();
        (sum / (across * (across - 1)) as f64).sqrt()
    }

    /// The least standard deviation of the 400 means over 5 m in a square of 100 m.
    fn weakest_square(albedo: &[f32]) -> f64 {
        let spread = |square: usize| {
            let (col, row) = (square % 18 * 200, square / 18 * 200);
            let mean_of_cell = |i: usize| {
                let (c, r) = (col + i % 20 * 10, row + i / 20 * 10);
                let of_row = |r: usize| albedo[r * SIDE + c..][..10].iter().map(|&v| f64::from(v)).sum::<f64>();
                (r..r + 10).map(of_row).sum::<f64>() / 100.0
            };
            let means: Vec<f64> = (0..400).map(mean_of_cell).collect();
            let mean = means.iter().sum::<f64>() / 400.0;
            (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / 400.0).sqrt()
        };
        (0..18 * 18).map(spread).fold(f64::MAX, f64::min)
    }

    #[test]
    fn same_seed_same_bytes_texture_everywhere_and_houses_with_heights() {
        let painted = |seed| painted_anew(&Painting { seed, land: Land::default(), changes: Changes::default() });
        let lands = [1, 1, 7].map(painted);
        let bytes = |grid: &Grid| grid.data.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let [one, again, other] = lands.each_ref().map(|land| bytes(land.albedo_grid()));
        assert!(one == again, "albedo of the same seed");
        assert!(one != other, "albedo of another seed");
        let [one, again, other] = lands.each_ref().map(|land| bytes(land.surface_grid().unwrap()));
        assert!(one == again, "surface of the same seed");
        assert!(one != other, "surface of another seed");

        for land in &lands[1..] {
            let (albedo, surface) = (&land.albedo_grid().data, &land.surface_grid().unwrap().data);
            for size in [1, 4, 10, 40, 100, 400] {
                let contrast = contrast(albedo, size);
                println!("neighbours of {:5.1} m differ by {contrast:.1}", size as f64 * STEP_M);
                assert!(contrast > 6.0, "{contrast} at {size} pixels");
            }
            // It must stand well out of a noise of 3.
            let weakest = weakest_square(albedo);
            println!("weakest square of 100 m: {weakest:.1}");
            assert!(weakest > 6.0, "{weakest}");

            let (low, high) = surface.iter().fold((f32::MAX, f32::MIN), |(l, h), &v| (l.min(v), h.max(v)));
            let share = |from: f32| surface.iter().filter(|&&h| h > from).count() as f64 / surface.len() as f64;
            println!("heights {low} to {high} m, built {:.2} %", 100.0 * share(0.0));
            assert!(low == 0.0 && (12.0..=15.0).contains(&high), "{low} to {high}");
            assert!(share(0.0) > 0.004 && share(0.0) < 0.1 && share(4.0) > 0.5 * share(0.0));
        }
    }

    /// Fields are mirrored, flooded ones one grey; the evening's shadows fall to the east, which the morning's do not.
    #[test]
    fn what_has_happened_to_the_land_is_painted() {
        let changes = Changes {
            sun_azimuth_deg: Some(270.0),
            sun_elevation_deg: Some(20.0),
            inverted_fraction: 1.0,
            flooded_fraction: 0.3,
            ..Changes::default()
        };
        let [before, after] = [Changes::default(), changes].map(|changes| procedural_as(1, Land::default(), changes));
        let [one, other] = [&before, &after].map(|ground| &ground.albedo_grid().data);
        let stretched = |grey: f32| 118.0 + CONTRAST * (grey - 118.0);
        let share = |is: &dyn Fn(f32, f32) -> bool| {
            one.iter().zip(other).filter(|(one, other)| is(**one, **other)).count() as f64 / one.len() as f64
        };
        let flooded = share(&|_, other| (other - stretched(52.0)).abs() < 0.01);
        let mirrored = share(&|one, other| (one + other - 2.0 * stretched(122.0)).abs() < 0.01);
        // Fields are some two thirds of the land, without their shadows, tracks and hedges.
        println!("{flooded:.3} flooded, {mirrored:.3} mirrored");
        assert!((0.08..0.3).contains(&flooded) && (0.2..0.7).contains(&mirrored), "{flooded} {mirrored}");

        // What stands stays where it is. 6 m east of a wall that is at least 4 m high is in its shadow of 11 m in the evening.
        let heights = &before.surface_grid().expect("houses").data;
        assert!(heights == &after.surface_grid().expect("houses").data);
        let foot = |i: &usize| heights[*i] > 4.0 && heights[*i + 1..].iter().take(4).any(|height| *height == 0.0);
        let shaded: Vec<usize> =
            (0..heights.len() - 40).filter(foot).map(|i| i + 12).filter(|i| heights[*i] == 0.0).collect();
        let mean = |data: &[f32]| shaded.iter().map(|i| f64::from(data[*i])).sum::<f64>() / shaded.len() as f64;
        println!("{} places: {:.1} in the morning, {:.1} in the evening", shaded.len(), mean(one), mean(other));
        assert!(shaded.len() > 500 && mean(other) < mean(one) - 20.0, "{} {}", mean(one), mean(other));
    }
}
