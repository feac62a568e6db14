//! Radiometry, share and shape of the changes, and where a cell lies.

use super::*;
use crate::world::Grid;

const PLAIN: Radiometry =
    Radiometry { gamma: 1.0, gain: 1.0, offset: 0.0, noise_dn: 0.0, changed_fraction: 0.0, seed: 3 };
const WEST: f64 = 560_000.25;
const NORTH: f64 = 5_330_000.25;

fn ground(f: impl Fn(usize, usize) -> f32) -> Ground {
    let side = 2000;
    let data = (0..side * side).map(|i| f(i % side, i / side)).collect();
    let albedo = Grid { cols: side, rows: side, west_m: WEST, north_m: NORTH, step_m: 0.5, data };
    Ground::new(albedo, None, 32633).unwrap()
}

#[test]
fn constant_ground_gives_the_radiometric_formula() {
    let g = ground(|_, _| 100.0);
    let tile = |r: &Radiometry| reference_tile(&g, WEST + 50.0, NORTH - 50.0, 40, 30, 5.0, r);
    assert!(tile(&PLAIN).iter().all(|&grey| grey == 100));
    let other = Radiometry { gamma: 0.8, gain: 1.1, offset: -7.0, ..PLAIN };
    // (100/255)^0.8 = 0.472945; times 255 x 1.1 = 280.5 gives 132.66, less 7.
    assert!(tile(&other).iter().all(|&grey| grey == 126));
    let noisy = tile(&Radiometry { noise_dn: 3.0, ..PLAIN });
    let mean = noisy.iter().map(|&grey| f64::from(grey)).sum::<f64>() / 1200.0;
    let sd = (noisy.iter().map(|&grey| (f64::from(grey) - mean).powi(2)).sum::<f64>() / 1200.0).sqrt();
    assert!((mean - 100.0).abs() < 0.35 && (sd - 3.0).abs() < 0.25, "mean {mean}, sd {sd}");
}

#[test]
fn the_wished_share_changes_in_blobs_not_in_single_cells() {
    let g = ground(|_, _| 128.0);
    for wished in [0.02, 0.1, 0.3] {
        let r = Radiometry { changed_fraction: wished, ..PLAIN };
        let side = 900;
        let tile = reference_tile(&g, WEST + 50.0, NORTH - 50.0, side, side, 1.0, &r);
        let changed = |i: usize| tile[i].abs_diff(128) > 15;
        let count = (0..tile.len()).filter(|&i| changed(i)).count();
        let share = count as f64 / tile.len() as f64;
        println!("wished {wished}: {share:.4}");
        assert!((share - wished).abs() < 0.015, "wished {wished}, got {share}");
        // In blobs of 15 m or more at most a third of the cells has a neighbour that did not change.
        let border = (0..tile.len() - side)
            .filter(|&i| i % side + 1 < side && changed(i) && !(changed(i + 1) && changed(i + side)))
            .count();
        assert!((border as f64) < 0.33 * count as f64, "{border} of {count}");
    }
}

#[test]
fn overlapping_tiles_show_the_same_changes() {
    let g = ground(|c, r| ((c * 7 + r * 13) % 200) as f32);
    let r = Radiometry { changed_fraction: 0.1, ..PLAIN };
    let one = reference_tile(&g, WEST + 50.0, NORTH - 50.0, 100, 100, 5.0, &r);
    let two = reference_tile(&g, WEST + 150.0, NORTH - 100.0, 60, 60, 5.0, &r);
    for row in 0..60 {
        assert_eq!(two[row * 60..][..60], one[(row + 10) * 100 + 20..][..60]);
    }
    let again = reference_tile(&g, WEST + 50.0, NORTH - 50.0, 100, 100, 5.0, &r);
    assert_eq!(one, again);
    let other = reference_tile(&g, WEST + 50.0, NORTH - 50.0, 100, 100, 5.0, &Radiometry { seed: 4, ..r });
    assert_ne!(one, other);
}

#[test]
fn a_dot_appears_in_the_cell_that_holds_it_and_its_grey_is_kept() {
    // Pixels 400..=405 east, 600..=602 south: 3 m x 1.5 m of 255 on black, centre (560201.5, 5329699.75).
    let g = ground(|c, r| if (400..=405).contains(&c) && (600..=602).contains(&r) { 255.0 } else { 0.0 });
    let (west, north) = (560_201.5 - 7.0 * 5.0, 5_329_699.75 + 4.0 * 5.0);
    let tile = reference_tile(&g, west, north, 20, 15, 5.0, &PLAIN);
    let brightest = (0..tile.len()).max_by_key(|&i| tile[i]).unwrap();
    assert_eq!((brightest % 20, brightest / 20), (7, 4));
    // 4.5 of 25 square metres: 45.9.
    assert_eq!(tile[brightest], 46);
    assert!(tile.iter().enumerate().all(|(i, &grey)| i == brightest || grey == 0));
}

#[test]
fn cells_beside_the_ground_are_zero() {
    let g = ground(|_, _| 100.0);
    let tile = reference_tile(&g, WEST, NORTH, 4, 4, 5.0, &PLAIN);
    assert_eq!(&tile[..5], &[0, 0, 0, 0, 0]);
    assert_eq!(tile[5], 100);
}

#[test]
fn a_cell_holds_its_own_square_of_land_and_nothing_else() {
    // 10 x 10 pixels of 0.5 m, whose borders are those of one cell of 5 m.
    let g = ground(|c, r| if (400..410).contains(&c) && (600..610).contains(&r) { 255.0 } else { 0.0 });
    let (west, north) = (WEST + 404.5 * 0.5 - 3.0 * 5.0, NORTH - 604.5 * 0.5 + 2.0 * 5.0);
    let tile = reference_tile(&g, west, north, 8, 6, 5.0, &PLAIN);
    assert!(tile.iter().enumerate().all(|(i, &grey)| grey == if i == 2 * 8 + 3 { 255 } else { 0 }), "{tile:?}");
}
