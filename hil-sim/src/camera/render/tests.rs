//! The renderer against equation 1 of paper 003, written out here as the product of its four matrices.

use super::*;
use crate::world::Grid;

const EAST: f64 = 560_000.0;
const NORTH: f64 = 5_330_000.0;

fn camera() -> RenderCamera {
    let fov = 60f64.to_radians();
    RenderCamera {
        cols: 256,
        rows: 192,
        fov_h_rad: fov,
        fov_v_rad: 48f64.to_radians(),
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion: None,
    }
}

fn station(heading: f64, pitch: f64, roll: f64, follow_up: f64) -> Station {
    Station {
        east_m: EAST + 3.3,
        north_m: NORTH - 1.7,
        up_m: 125.0,
        heading_rad: heading.to_radians(),
        pitch_rad: pitch.to_radians(),
        roll_rad: roll.to_radians(),
        follow_up_rad: follow_up.to_radians(),
        boresight_rad: [0.0; 3],
    }
}

/// Six attitudes, none special; the follow-up angles are not those of a servo that follows, but for the first two.
const ATTITUDES: [[f64; 4]; 6] = [
    [0.0, 0.0, 0.0, 0.0],
    [90.0, 10.0, 8.0, 88.594_245_3],
    [30.0, 5.0, -3.0, 29.0],
    [215.0, 3.3, -9.9, 170.0],
    [-47.0, -8.0, 6.0, 0.0],
    [140.0, 12.0, 11.0, -75.0],
];

type Matrix = [[f64; 3]; 3];

fn product(a: Matrix, b: Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// Equation 1, corrected: camera (forward, up, right) from ground (north, up, east).
fn equation_1(s: &Station) -> Matrix {
    let ((sp, cp), (st, ct)) = (s.heading_rad.sin_cos(), s.pitch_rad.sin_cos());
    let ((sg, cg), (sb, cb)) = (s.roll_rad.sin_cos(), s.follow_up_rad.sin_cos());
    let follow_up = [[cb, 0.0, -sb], [0.0, 1.0, 0.0], [sb, 0.0, cb]];
    let roll = [[1.0, 0.0, 0.0], [0.0, cg, sg], [0.0, -sg, cg]];
    let pitch = [[ct, st, 0.0], [-st, ct, 0.0], [0.0, 0.0, 1.0]];
    let heading = [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]];
    product(product(follow_up, roll), product(pitch, heading))
}

/// The frame pixel of a ground point by equations 1 and 2: (m right, n forward) on the plane Y = -f, then distortion in
/// OpenCV's axes, then the offsets.
fn by_the_paper(c: &RenderCamera, s: &Station, [east, north, up]: [f64; 3]) -> (f64, f64) {
    let a = equation_1(s);
    let v_b = [north - s.north_m, up - s.up_m, east - s.east_m];
    let v_m: [f64; 3] = std::array::from_fn(|i| (0..3).map(|k| a[i][k] * v_b[k]).sum());
    let (mut x, mut y) = (v_m[2] / -v_m[1], v_m[0] / v_m[1]); // right, and backward = down in the picture
    if let Some([k1, k2, k3, p1, p2]) = c.distortion {
        let r2 = x * x + y * y;
        let radial = 1.0 + k1 * r2 + k2 * r2.powi(2) + k3 * r2.powi(3);
        let xd = x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x);
        let yd = y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y;
        (x, y) = (xd, yd);
    }
    let (kh, kv) = ((c.fov_h_rad / 2.0).tan() * 2.0 / c.cols as f64, (c.fov_v_rad / 2.0).tan() * 2.0 / c.rows as f64);
    let (m, n) = (x / kh + c.offset_m_px, -y / kv + c.offset_n_px);
    (m + (c.cols as f64 - 1.0) / 2.0, (c.rows as f64 - 1.0) / 2.0 - n)
}

/// 40 m of black ground of 0.25 m pixels at height `up_m`, in its middle a round soft dot of 1.2 m standard deviation.
fn dotted(dot: [f64; 2], up_m: f64) -> Ground {
    let side = 160;
    let half = (side - 1) as f64 / 2.0 * 0.25;
    let (west_m, north_m) = (dot[0] - half, dot[1] + half);
    let data = (0..side * side)
        .map(|i| {
            let (east, north) = (west_m + (i % side) as f64 * 0.25, north_m - (i / side) as f64 * 0.25);
            let d2 = (east - dot[0]).powi(2) + (north - dot[1]).powi(2);
            (250.0 * (-d2 / (2.0 * 1.2 * 1.2)).exp()) as f32
        })
        .collect();
    let albedo = Grid { cols: side, rows: side, west_m, north_m, step_m: 0.25, data };
    let surface = Grid { cols: 2, rows: 2, west_m, north_m, step_m: 2.0 * half, data: vec![up_m as f32; 4] };
    Ground::new(albedo, (up_m != 0.0).then_some(surface), 32633).unwrap()
}

/// Grey-weighted centre of a frame.
fn centroid(pixels: &[u8], cols: usize) -> (f64, f64) {
    let (mut sum, mut col, mut row) = (0.0, 0.0, 0.0);
    for (i, &grey) in pixels.iter().enumerate().filter(|&(_, &grey)| grey > 1) {
        sum += f64::from(grey);
        col += f64::from(grey) * (i % cols) as f64;
        row += f64::from(grey) * (i / cols) as f64;
    }
    (col / sum, row / sum)
}

/// Largest miss in pixels of a painted dot, at the plumb point and at two others, over all attitudes.
fn dot_miss(camera: &RenderCamera, up_m: f64) -> f64 {
    let renderer = Renderer::new(*camera, 4);
    let mut worst = 0f64;
    for [heading, pitch, roll, follow_up] in ATTITUDES {
        let s = station(heading, pitch, roll, follow_up);
        for offset in [[0.0, 0.0], [24.0, 9.0], [-15.0, 22.0]] {
            let dot = [s.east_m + offset[0], s.north_m + offset[1]];
            let expected = by_the_paper(camera, &s, [dot[0], dot[1], up_m]);
            let frame = renderer.render(&dotted(dot, up_m), &s, 0.0, 1, 1);
            let found = centroid(&frame.pixels, camera.cols);
            worst = worst.max((found.0 - expected.0).abs()).max((found.1 - expected.1).abs());
        }
    }
    worst
}

// A tilted view of a round dot is no round dot: at 25 deg off axis its centroid lies k sigma_px^2 tan / (f cos^2), about
// 0.02 px, off the image of its centre. So 0.05 px is the tightest that means something here; a wrong sign costs 10 px.
#[test]
fn a_painted_dot_is_where_equation_1_puts_it() {
    let miss = dot_miss(&camera(), 0.0);
    println!("plain: worst {miss:.4} px");
    assert!(miss < 0.05, "{miss} px");
    let miss = dot_miss(&camera(), 12.5);
    println!("raised ground: worst {miss:.4} px");
    assert!(miss < 0.05, "{miss} px");
}

#[test]
fn a_painted_dot_is_where_it_belongs_with_offsets_and_distortion() {
    let with = RenderCamera {
        offset_m_px: 3.25,
        offset_n_px: -5.5,
        distortion: Some([-0.12, 0.03, -0.002, 0.0015, -0.002]),
        ..camera()
    };
    let miss = dot_miss(&with, 0.0);
    println!("offsets and distortion: worst {miss:.4} px");
    assert!(miss < 0.05, "{miss} px");
}

#[test]
fn the_axes_are_the_rows_of_equation_1() {
    for [heading, pitch, roll, follow_up] in ATTITUDES {
        let s = station(heading, pitch, roll, follow_up);
        let (axes, a) = (s.axes(), equation_1(&s));
        let row = |v: [f64; 3]| [v[1], v[2], v[0]]; // east-north-up to north-up-east
        for (ours, theirs) in [(axes.forward, a[0]), (axes.down.map(|x| -x), a[1]), (axes.right, a[2])] {
            let ours = row(ours);
            assert!((0..3).all(|i| (ours[i] - theirs[i]).abs() < 1e-14), "{ours:?} {theirs:?}");
        }
    }
}

#[test]
fn signs_of_roll_and_pitch_and_the_plumb_point() {
    let renderer = Renderer::new(camera(), 1);
    let focal = 128.0 / 30f64.to_radians().tan();
    let (col, row) = renderer.nadir_px(&station(77.0, 0.0, 8.0, 0.0)).unwrap();
    assert!((col - 127.5 - focal * 8f64.to_radians().tan()).abs() < 1e-9, "roll right: nadir right of the centre");
    assert!((row - 95.5).abs() < 1e-9);
    let (col, row) = renderer.nadir_px(&station(77.0, 10.0, 0.0, 0.0)).unwrap();
    assert!(row > 95.5 + 30.0 && (col - 127.5).abs() < 1e-9, "nose up: nadir behind, so further down");
}

#[test]
fn undistortion_is_the_inverse_and_refuses_the_fold() {
    let barrel = [-0.25, 0.06, -0.004, 0.002, -0.003];
    for x in -8..=8 {
        for y in -8..=8 {
            let ideal = [f64::from(x) * 0.07, f64::from(y) * 0.07];
            let back = undistorted(&barrel, distorted(&barrel, ideal)).unwrap();
            assert!((back[0] - ideal[0]).abs() < 1e-10 && (back[1] - ideal[1]).abs() < 1e-10);
        }
    }
    // r (1 - r2) never exceeds 0.385: no ideal point lies behind a distorted radius of 0.5.
    assert_eq!(undistorted(&[-1.0, 0.0, 0.0, 0.0, 0.0], [0.5, 0.0]), None);
}

#[test]
fn samples_beside_the_ground_are_counted_and_black() {
    let mut s = station(0.0, 0.0, 0.0, 0.0);
    s.east_m = EAST + 1000.0;
    let frame = Renderer::new(camera(), 2).render(&dotted([EAST, NORTH], 0.0), &s, 0.0, 1, 1);
    assert_eq!(frame.outside, 256 * 192 * 4);
    assert!(frame.pixels.iter().all(|&grey| grey == 0));
}

#[test]
fn noise_has_the_asked_size_and_comes_from_the_seed() {
    let grid =
        Grid { cols: 2, rows: 2, west_m: EAST - 500.0, north_m: NORTH + 500.0, step_m: 1000.0, data: vec![100.0; 4] };
    let ground = Ground::new(grid, None, 32633).unwrap();
    let shot = |seed, index| render(&camera(), &ground, &station(20.0, 3.0, -4.0, 0.0), 3.0, seed, index).pixels;
    let frame = shot(5, 6);
    assert_eq!(frame, shot(5, 6));
    assert_ne!(frame, shot(5, 7));
    assert_ne!(frame, shot(6, 6));
    let mean = frame.iter().map(|&g| f64::from(g)).sum::<f64>() / frame.len() as f64;
    let variance = frame.iter().map(|&g| (f64::from(g) - mean).powi(2)).sum::<f64>() / frame.len() as f64;
    // n = 49152: standard errors 0.014 of the mean, 0.058 of the variance; rounding adds 1/12.
    assert!((mean - 100.0).abs() < 0.06, "mean {mean}");
    assert!((variance - 9.0 - 1.0 / 12.0).abs() < 0.25, "variance {variance}");
}

/// Stations along a flight of 3 m to the north, rolling by 2 degrees.
fn along(part: f64) -> Station {
    let s = station(20.0, 3.0, -4.0 + 2.0 * part, 0.0);
    Station { north_m: s.north_m + 3.0 * part, ..s }
}

#[test]
fn a_smeared_frame_is_the_mean_of_its_instants() {
    let ground = dotted([EAST, NORTH], 0.0);
    let renderer = Renderer::new(camera(), 2);
    let parts = [0.125, 0.375, 0.625, 0.875];
    let smeared = renderer.render_rows(&ground, &|_| parts.map(along).to_vec(), (1.0, 0.0), 1, 1);
    let sharp = parts.map(|part| renderer.render(&ground, &along(part), 0.0, 1, 1));
    for (i, &pixel) in smeared.pixels.iter().enumerate() {
        let mean = sharp.iter().map(|frame| f64::from(frame.pixels[i])).sum::<f64>() / 4.0;
        // Each of the four is rounded, and so is their mean.
        assert!((f64::from(pixel) - mean).abs() <= 1.0, "pixel {i}: {pixel} for {mean}");
    }
    // Its centre is that of mid-exposure to the track's bend; either end is pixels away.
    let of = |pixels: &[u8]| centroid(pixels, 256);
    let (centre, mid, start) = (
        of(&smeared.pixels),
        of(&renderer.render(&ground, &along(0.5), 0.0, 1, 1).pixels),
        of(&renderer.render(&ground, &along(0.0), 0.0, 1, 1).pixels),
    );
    assert!((centre.0 - mid.0).hypot(centre.1 - mid.1) < 0.05, "{centre:?} {mid:?}");
    assert!((centre.0 - start.0).hypot(centre.1 - start.1) > 3.0, "{centre:?} {start:?}");
}

#[test]
fn noise_is_added_once_and_one_instant_is_todays_frame() {
    let ground = dotted([EAST, NORTH], 0.0);
    let renderer = Renderer::new(camera(), 2);
    let s = along(0.0);
    let once = renderer.render(&ground, &s, 3.0, 1, 1);
    // Sums of four equal values and their quotients are exact.
    assert_eq!(renderer.render_rows(&ground, &|_| vec![s; 4], (1.0, 3.0), 1, 1).pixels, once.pixels);
    assert_eq!(renderer.render_rows(&ground, &|_| vec![s], (1.0, 3.0), 1, 1), once);
}

#[test]
fn each_row_of_a_rolling_shutter_is_that_of_its_instant() {
    let ground = dotted([EAST, NORTH], 0.0);
    let renderer = Renderer::new(camera(), 2);
    let of_row = |row: usize| along(row as f64 / 191.0);
    let rolling = renderer.render_rows(&ground, &|row| vec![of_row(row)], (1.0, 3.0), 1, 1);
    for row in [0, 60, 96, 191] {
        let instant = renderer.render(&ground, &of_row(row), 3.0, 1, 1);
        assert_eq!(rolling.pixels[row * 256..][..256], instant.pixels[row * 256..][..256], "row {row}");
    }
}

#[test]
fn the_sky_is_haze_and_not_outside() {
    // Right wing down by 80 degrees: the left border looks above the horizon, the right one at the ground beside the raster.
    let s = station(0.0, 0.0, 80.0, 0.0);
    let frame = Renderer::new(camera(), 2).render(&dotted([EAST, NORTH], 0.0), &s, 0.0, 1, 1);
    let seen = |col: usize| f64::from(frame.pixels[96 * 256 + col]);
    assert_eq!([0, 255].map(seen), [HAZE, 0.0]);
    let black = frame.pixels.iter().filter(|&&grey| grey == 0).count();
    assert!(black * 4 <= frame.outside && frame.outside < 256 * 192 * 4, "{black} {}", frame.outside);
}
