use super::{Elevation, Plane, Posts, VOID};
use crate::frames::Local;

extern crate std;
use std::vec::Vec;

const POSTS: Posts = Posts { size: (11, 9), spacing_m: 30.0, step_m: 0.1, base_m: 400.0, vertical_epsg: 5773 };

/// Posts of a height (east, north), metres from their centre.
fn bytes(height: impl Fn(f32, f32) -> f32) -> Vec<u8> {
    let (cols, rows) = POSTS.size;
    let post = |index: u16| {
        let east = (f32::from(index % cols) - 5.0) * 30.0;
        let north = (4.0 - f32::from(index / cols)) * 30.0;
        ((height(east, north) - 400.0) / 0.1).round() as i16
    };
    (0..cols * rows).flat_map(|index| post(index).to_le_bytes()).collect()
}

fn at(east_m: f32, north_m: f32) -> Local {
    Local { east_m, north_m }
}

#[test]
fn a_plane_is_found_as_it_is() {
    let bytes = bytes(|east, north| 412.0 + 0.1 * east - 0.2 * north);
    let model = Elevation::new(&bytes, POSTS).expect("sound");
    for place in [at(0.0, 0.0), at(13.0, -41.0), at(-70.0, 30.0)] {
        let expected = 412.0 + 0.1 * place.east_m - 0.2 * place.north_m;
        assert!((model.height_m(place).expect("on the grid") - expected).abs() < 1e-3);
        let Plane { middle, height_m, slope, relief_m } = model.plane(place, 60.0).expect("all heights are there");
        assert!(middle == place && (height_m - expected).abs() < 1e-3, "{height_m} {expected}");
        assert!((slope[0] - 0.1).abs() < 1e-5 && (slope[1] + 0.2).abs() < 1e-5, "{slope:?}");
        assert!(relief_m < 0.02, "{relief_m}");
        let plane = model.plane(place, 60.0).expect("the same");
        assert!((plane.height_m(at(0.0, 0.0)) - 412.0).abs() < 1e-3);
    }
}

/// Against the normal equations of heights at the same places, solved in f64 by nalgebra.
#[test]
fn of_other_ground_it_is_the_least_squares_plane() {
    let ground = |east: f32, north: f32| 380.0 + 6.0 * (0.021 * east + 0.3).sin() + 0.0007 * north * (north + east);
    let bytes = bytes(ground);
    let model = Elevation::new(&bytes, POSTS).expect("sound");
    let (middle, half) = (at(11.0, -7.0), 77.0f32);
    let plane = model.plane(middle, half).expect("all heights are there");
    let (mut normal, mut right) = (nalgebra::Matrix3::<f64>::zeros(), nalgebra::Vector3::<f64>::zeros());
    let mut samples = Vec::new();
    for index in 0..49 {
        let (x, y) = ((index % 7 - 3) as f32 * half / 3.5, (3 - index / 7) as f32 * half / 3.5);
        let height = f64::from(model.height_m(middle.moved([x, y])).expect("on the grid"));
        let row = nalgebra::Vector3::new(1.0, f64::from(x), f64::from(y));
        normal += row * row.transpose();
        right += row * height;
        samples.push((row, height));
    }
    let solution = normal.cholesky().expect("spread").solve(&right);
    let residual = samples.iter().map(|(row, height)| (height - row.dot(&solution)).powi(2)).sum::<f64>() / 49.0;
    assert!((f64::from(plane.height_m) - solution[0]).abs() < 1e-3);
    assert!((f64::from(plane.slope[0]) - solution[1]).abs() < 1e-5);
    assert!((f64::from(plane.slope[1]) - solution[2]).abs() < 1e-5);
    assert!((f64::from(plane.relief_m) - residual.sqrt()).abs() < 2e-3, "{plane:?} {}", residual.sqrt());
    assert!(plane.relief_m > 1.0, "the ground is no plane");
}

#[test]
fn there_is_nothing_off_the_grid_and_beside_a_void() {
    let mut bytes = bytes(|_, _| 401.0);
    let whole = Elevation::new(&bytes, POSTS).expect("sound");
    // The outermost posts count, a millimetre beyond them does not.
    for (place, is_there) in [
        (at(150.0, 120.0), true),
        (at(-150.0, -120.0), true),
        (at(150.001, 0.0), false),
        (at(0.0, -120.001), false),
        (at(f32::NAN, 0.0), false),
        (at(f32::INFINITY, 0.0), false),
    ] {
        assert_eq!(whole.height_m(place).is_some(), is_there, "{place:?}");
    }
    assert!(whole.plane(at(0.0, 0.0), 130.0).is_some());
    assert!(whole.plane(at(60.0, 0.0), 130.0).is_none(), "it would reach beyond");
    assert!(whole.plane(at(0.0, 0.0), f32::NAN).is_none());
    assert!(whole.plane(at(0.0, 0.0), 0.0).is_none());
    // The post 30 m east and 30 m north.
    let index = 3 * 11 + 6;
    bytes[2 * index..2 * index + 2].copy_from_slice(&VOID.to_le_bytes());
    let holed = Elevation::new(&bytes, POSTS).expect("sound");
    assert!(holed.height_m(at(20.0, 20.0)).is_none() && holed.height_m(at(40.0, 40.0)).is_none());
    assert!(holed.height_m(at(-10.0, 20.0)).is_some());
    assert!(holed.plane(at(0.0, 0.0), 100.0).is_none());
}

#[test]
fn a_cliff_makes_no_plane() {
    let bytes = bytes(|east, _| 400.0 + 1.01 * east);
    assert!(Elevation::new(&bytes, POSTS).expect("sound").plane(at(0.0, 0.0), 60.0).is_none());
}

#[test]
fn what_cannot_be_meant_is_refused() {
    let bytes = bytes(|_, _| 400.0);
    assert!(Elevation::new(&bytes, POSTS).is_some());
    assert!(Elevation::new(&bytes[1..], POSTS).is_none());
    let bad = [
        Posts { size: (99, 1), ..POSTS },
        Posts { size: (1, 99), ..POSTS },
        Posts { size: (0, 0), ..POSTS },
        Posts { spacing_m: 0.0, ..POSTS },
        Posts { spacing_m: f32::NAN, ..POSTS },
        Posts { spacing_m: f32::INFINITY, ..POSTS },
        Posts { step_m: 0.0, ..POSTS },
        Posts { step_m: 1.1, ..POSTS },
        Posts { step_m: f32::NAN, ..POSTS },
        Posts { base_m: -20_001.0, ..POSTS },
        Posts { base_m: f32::NAN, ..POSTS },
    ];
    for posts in bad {
        assert!(Elevation::new(&bytes[..posts.bytes().min(bytes.len())], posts).is_none(), "{posts:?}");
    }
}
