//! Exact crossings against a slow and obvious march.

use super::*;
use crate::noise::pixels::{stream, uniform};

/// Rolling ground of +-6 m with blocks of 4 to 15 m on it, 0.5 m pixels, 100 m x 80 m, at large coordinates.
fn town() -> Surface {
    town_on(6.0)
}

/// [`town`] on rolling ground of that height.
fn town_on(relief: f64) -> Surface {
    let (cols, rows) = (200, 160);
    let mut data: Vec<f32> = (0..cols * rows)
        .map(|i| (relief * ((i % cols) as f64 / 31.0).sin() * ((i / cols) as f64 / 23.0).cos()) as f32)
        .collect();
    let mut rng = stream(11, 0);
    for _ in 0..25 {
        let (c, r) = (uniform(&mut rng, 0.0, 170.0) as usize, uniform(&mut rng, 0.0, 130.0) as usize);
        let height = uniform(&mut rng, 4.0, 15.0) as f32;
        for row in r..r + 25 {
            data[row * cols + c..row * cols + c + 18].fill(height);
        }
    }
    Surface::new(Grid { cols, rows, west_m: 560_000.0, north_m: 5_330_000.0, step_m: 0.5, data })
}

/// Steps of 2 mm along the ray until it is below the surface: slow and obvious.
fn march(surface: &Surface, origin: [f64; 3], direction: [f64; 3]) -> Option<f64> {
    let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    let step = 0.002 / length;
    let mut along = 0.0;
    while origin[2] + along * direction[2] > -10.0 {
        let at = |axis: usize| origin[axis] + along * direction[axis];
        let (col, row) = surface.grid.pixel(at(0), at(1));
        if surface.grid.covers(col, row) {
            if surface.height(at(0), at(1)) >= at(2) {
                return Some(along);
            }
        } else if along > 0.0 {
            return None;
        }
        along += step;
    }
    None
}

#[test]
fn agrees_with_a_brute_force_march() {
    let surface = town();
    let mut rng = stream(12, 0);
    let (mut hits, mut misses, mut silhouettes) = (0, 0, 0);
    for _ in 0..1500 {
        let origin = [
            560_000.0 + uniform(&mut rng, 5.0, 94.0),
            5_330_000.0 - uniform(&mut rng, 5.0, 74.0),
            uniform(&mut rng, 16.0, 40.0),
        ];
        let direction = [uniform(&mut rng, -1.2, 1.2), uniform(&mut rng, -1.2, 1.2), -1.0];
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        match (surface.intersect(origin, direction), march(&surface, origin, direction)) {
            (Some(ours), Some(theirs)) if (ours - theirs).abs() * length < 0.02 => hits += 1,
            (None, None) => misses += 1,
            _ => silhouettes += 1,
        }
    }
    println!("{hits} hits, {misses} misses, {silhouettes} silhouettes");
    assert!(hits > 1000 && misses > 50, "{hits} hits, {misses} misses");
    // A ray may pass an edge by less than the 2 mm step of the judge.
    assert!(silhouettes <= 2, "{silhouettes} of 1500 rays disagree");
}

#[test]
fn the_point_that_is_met_lies_on_the_surface() {
    let surface = town();
    let mut rng = stream(13, 0);
    for _ in 0..20_000 {
        let origin = [560_050.0, 5_329_960.0, 30.0];
        let direction = [uniform(&mut rng, -1.0, 1.0), uniform(&mut rng, -1.0, 1.0), -1.0];
        let Some(t) = surface.intersect(origin, direction) else { continue };
        let [e, n, u]: [f64; 3] = std::array::from_fn(|axis| origin[axis] + t * direction[axis]);
        // 1e-9 m of rounding in coordinates of 5e6, times the steepest wall (15 m over 0.5 m).
        assert!((surface.height(e, n) - u).abs() < 1e-7);
    }
}

#[test]
fn rays_along_the_grid_lines_plumb_and_upwards() {
    let surface = town();
    let height = surface.height(560_050.0, 5_329_960.0);
    let plumb = surface.intersect([560_050.0, 5_329_960.0, 100.0], [0.0, 0.0, -2.0]).unwrap();
    assert!((100.0 - 2.0 * plumb - height).abs() < 1e-9);
    assert!(surface.intersect([560_050.0, 5_329_960.0, 100.0], [0.0, 0.0, 1.0]).is_none());
    assert!(surface.intersect([560_050.0, 5_329_960.0, 14.0], [1.0, 0.0, 0.0]).is_none_or(|t| t < 50.0));
    assert!(surface.intersect([560_050.0, 5_329_960.0, -50.0], [0.0, 0.0, 1.0]).is_none(), "from below");
    assert!(surface.intersect([560_050.0, 5_329_960.0, 30.0], [0.0, 0.0, 0.0]).is_none(), "no direction");
    assert!(surface.intersect([559_000.0, 5_329_960.0, 30.0], [0.0, 0.0, -1.0]).is_none(), "beside the raster");
}

#[test]
fn a_ray_that_crosses_one_cell_twice_stops_at_the_first() {
    // A saddle: along the diagonal its height is 8 s - 8 s^2, so a level ray at height 1 meets it at (8 -+ sqrt 32) / 16.
    let grid = Grid { cols: 2, rows: 2, west_m: 0.0, north_m: 0.0, step_m: 1.0, data: vec![0.0, 4.0, 4.0, 0.0] };
    let along = Surface::new(grid).intersect([0.0, 0.0, 1.0], [1.0, -1.0, 0.0]).unwrap();
    assert!((along - (8.0 - 32f64.sqrt()) / 16.0).abs() < 1e-12, "{along}");
}

#[test]
fn rays_beside_each_other_meet_what_each_meets_alone() {
    let towns = [town(), town_on(0.0)];
    let mut rng = stream(14, 0);
    let (mut level, mut met) = (0, 0);
    for run in 0..400 {
        let surface = &towns[run % 2];
        let origin = [
            560_000.0 + uniform(&mut rng, 0.0, 100.0),
            5_330_000.0 - uniform(&mut rng, 0.0, 80.0),
            uniform(&mut rng, 10.0, 60.0),
        ];
        let [east, north, step] =
            [(-0.8, 0.8), (-0.8, 0.8), (0.0, 0.003)].map(|(low, high)| uniform(&mut rng, low, high));
        let directions: Vec<[f64; 3]> = (0..50).map(|i| [east + f64::from(i) * step, north, -1.0]).collect();
        let mut along = vec![0.0; directions.len()];
        surface.intersect_all(origin, &directions, &mut along);
        for (direction, along) in directions.iter().zip(along) {
            let alone = surface.intersect(origin, *direction);
            assert_eq!(alone.is_none(), along.is_nan());
            assert!(alone.is_none_or(|alone| (alone - along).abs() < 1e-9), "{alone:?} {along}");
            met += usize::from(alone.is_some());
        }
        level += usize::from(surface.heights_below(origin, &directions).is_some_and(|[low, high]| low == high));
    }
    println!("{met} rays meet the ground, {level} runs on level ground");
    assert!(met > 10_000 && level > 20, "{met} {level}");
}
