//! The oracle of `plumbline-sim` against the golden values of papers 003 and 000, against the algebra of eq. 3, and its
//! area average against an enclosure.
//!
//! Tolerance 1e-6 px or degrees: the vectors hold nine significant digits or six decimals, so they are good to 5e-7.

mod mistakes;

use plumbline_sim::oracle::{
    Camera, Distortion, Grid, Image, Kernel, Matrix3, attitude_linear, attitude_slerp, centre_offset,
    equivalent_pitch_roll, exact_area, follow_up_exact, frame_from_ground, frame_from_ground_simplified,
    frame_from_patch, ground_from_frame, matrix_a, mid_exposure_u32, patch_size, pixel_from_frame, pps_time, remap,
};
use plumbline_tests::vectors::{list, miss, number, rows, table};
use serde_json::Value;

const TOLERANCE: f64 = 1e-6;
/// By how much a mistake must miss, in px, degrees or ticks.
const MISS: f64 = 1e-3;

fn radians(row: &Value, key: &str) -> f64 {
    number(row, key).to_radians()
}

fn camera(cols: usize, rows: usize, fov_h_deg: f64, fov_v_deg: f64) -> Camera {
    let (fov_h_rad, fov_v_rad) = (fov_h_deg.to_radians(), fov_v_deg.to_radians());
    let distortion = Distortion::default();
    Camera { cols, rows, fov_h_rad, fov_v_rad, offset_m_px: 0.0, offset_n_px: 0.0, distortion }
}

/// The camera of a row of table B (VH, VV) or C (V).
fn camera_of(row: &Value) -> Camera {
    let size = number(row, "M") as usize;
    let (h, v) = if row["V"].is_null() { ("VH", "VV") } else { ("V", "V") };
    let centred = camera(size, size, number(row, h), number(row, v));
    Camera { offset_m_px: number(row, "m0"), offset_n_px: number(row, "n0"), ..centred }
}

fn attitude_of(row: &Value) -> (f64, f64, f64) {
    (radians(row, "phi"), radians(row, "theta"), radians(row, "gamma"))
}

/// Heading, pitch, roll and follow-up angle of a row of table B.
fn attitude_with_follow_up(row: &Value) -> (f64, f64, f64, f64) {
    let (heading, pitch, roll) = attitude_of(row);
    let follow_up = row["beta"].as_f64().map_or(follow_up_exact(heading, pitch, roll), f64::to_radians);
    (heading, pitch, roll, follow_up)
}

/// Corrected eq. 3 as the paper writes it, without offsets: (m', n', den).
fn eq3(a: &Matrix3, (k_h, k_v): (f64, f64), m: f64, n: f64) -> (f64, f64, f64) {
    let den = a[1][1] - m * k_h * a[1][2] - n * k_v * a[1][0];
    let m_frame = (m * a[2][2] + n * (k_v / k_h) * a[2][0] - a[2][1] / k_h) / den;
    let n_frame = (m * (k_h / k_v) * a[0][2] + n * a[0][0] - a[0][1] / k_v) / den;
    (m_frame, n_frame, den)
}

/// Attitudes all round the compass: heading, pitch, roll, and a follow-up angle that follows badly. Radians.
fn attitudes() -> Vec<(f64, f64, f64, f64)> {
    let mut all = Vec::new();
    for heading in (0..360).step_by(37) {
        for pitch in [-30, -7, 0, 12, 25] {
            for roll in [-28, -9, 0, 5, 30] {
                let [h, p, r] = [heading, pitch, roll].map(|deg| f64::from(deg).to_radians());
                all.push((h, p, r, follow_up_exact(h, p, r) + 0.3 * (h * 3.0).sin()));
            }
        }
    }
    all
}

#[test]
fn golden_a_follow_up_and_equivalent_angles() {
    for row in rows("003", "A_followup") {
        let (heading, pitch, roll) = attitude_of(&row);
        let (equivalent_pitch, equivalent_roll) = equivalent_pitch_roll(heading, pitch, roll);
        let ours = [follow_up_exact(heading, pitch, roll), equivalent_pitch, equivalent_roll].map(f64::to_degrees);
        assert!(miss(ours, list(&row, "out")) < TOLERANCE, "{ours:?} for {row}");
    }
}

#[test]
fn golden_b_eq_3_and_its_inverse() {
    for row in rows("003", "B_eq3") {
        let (heading, pitch, roll, follow_up) = attitude_with_follow_up(&row);
        let (a, camera) = (matrix_a(heading, pitch, roll, follow_up), camera_of(&row));
        let p = frame_from_ground(&a, &camera, number(&row, "m"), number(&row, "n"));
        assert!(p.in_front && miss([p.m, p.n], list(&row, "out")) < TOLERANCE, "{p:?} for {row}");
        assert!(miss([p.m, p.n], list(&row, "printed")) > MISS, "the misprint is met: {p:?} for {row}");
        let back = ground_from_frame(&a, &camera, p.m, p.n).expect("no distortion to undo");
        assert!(miss([back.m, back.n], [number(&row, "m"), number(&row, "n")]) < 1e-9, "{back:?} for {row}");
    }
}

#[test]
fn golden_c_eq_7() {
    for row in rows("003", "C_eq7") {
        let (pitch, roll, camera) = (radians(&row, "theta1"), radians(&row, "gamma1"), camera_of(&row));
        let (m, n) = (number(&row, "m"), number(&row, "n"));
        let p = frame_from_ground_simplified(pitch, roll, &camera, m, n).expect("a square camera");
        assert!(p.in_front && miss([p.m, p.n], list(&row, "out")) < TOLERANCE, "{p:?} for {row}");
        assert!(miss([p.m, p.n], list(&row, "printed")) > MISS, "the misprint is met: {p:?} for {row}");
    }
    assert_eq!(frame_from_ground_simplified(0.1, 0.1, &camera(640, 480, 60.0, 60.0), 1.0, 1.0), None);
}

#[test]
fn golden_d_patch_size() {
    for row in rows("003", "D_size") {
        let (cols, lines) = patch_size(number(&row, "H"), radians(&row, "VH"), radians(&row, "VV"), number(&row, "R"));
        assert!(miss([cols, lines], list(&row, "out")) < TOLERANCE, "{cols} x {lines} for {row}");
    }
}

#[test]
fn golden_e_centre_offset() {
    for row in rows("003", "E_centre") {
        let (height, pitch, roll) = (number(&row, "H"), radians(&row, "theta"), radians(&row, "gamma"));
        let (cross, along) = centre_offset(height, pitch, roll, number(&row, "R"));
        assert!(miss([cross, along], list(&row, "out")) < TOLERANCE, "{cross}, {along} for {row}");
        assert!(miss([cross, along], list(&row, "half_px")) > MISS, "the half pixel is in: {row}");
        // The same by the ray: the ground point at the frame's centre; and with the centre half a pixel off.
        let (a, camera) = (matrix_a(0.0, pitch, roll, 0.0), camera(512, 512, 60.0, 60.0));
        let cells_per_px = camera.tangent_per_px().0 * height / number(&row, "R");
        let p = ground_from_frame(&a, &camera, 0.0, 0.0).expect("no distortion to undo");
        for (slip_px, key) in [(0.0, "out"), (0.5, "half_px")] {
            let by_ray = [(-p.m + slip_px) * cells_per_px, (p.n - slip_px) * cells_per_px];
            assert!(miss(by_ray, list(&row, key)) < TOLERANCE, "{by_ray:?} for {key} of {row}");
        }
    }
}

#[test]
fn the_ray_is_eq_3() {
    let camera = camera(640, 480, 63.0, 41.0);
    let tangents = (31.5_f64.to_radians().tan() / 320.0, 20.5_f64.to_radians().tan() / 240.0);
    for (heading, pitch, roll, follow_up) in attitudes() {
        let a = matrix_a(heading, pitch, roll, follow_up);
        for (m, n) in [(0.0, 0.0), (319.5, 239.5), (-319.5, 100.25), (17.0, -239.5), (-200.0, -150.0)] {
            let p = frame_from_ground(&a, &camera, m, n);
            let (m_frame, n_frame, den) = eq3(&a, tangents, m, n);
            let scale = 1.0 + m_frame.abs().max(n_frame.abs());
            assert!(miss([p.m, p.n], [m_frame, n_frame]) < 1e-12 * scale && p.in_front && den > 0.0, "{p:?}");
        }
    }
    // Nose up by 80 degrees: a point 15 degrees behind the nadir lies behind the image plane.
    let behind = -15.0_f64.to_radians().tan() / tangents.1;
    assert!(!frame_from_ground(&matrix_a(0.0, 80.0_f64.to_radians(), 0.0, 0.0), &camera, 0.0, behind).in_front);
}

#[test]
fn eq_5_is_exact_and_eq_7_is_eq_3_when_followed() {
    let camera = Camera { offset_m_px: 1.5, offset_n_px: -2.25, ..camera(512, 512, 60.0, 60.0) };
    for (heading, pitch, roll, _) in attitudes() {
        let a = matrix_a(heading, pitch, roll, follow_up_exact(heading, pitch, roll));
        let (equivalent_pitch, equivalent_roll) = equivalent_pitch_roll(heading, pitch, roll);
        let level = matrix_a(0.0, equivalent_pitch, equivalent_roll, 0.0);
        for row in 0..3 {
            assert!(miss(a[row], level[row]) < 1e-15 * 4.0, "{a:?} is not {level:?}");
        }
        let full = frame_from_ground(&a, &camera, 120.0, -80.0);
        let simplified = frame_from_ground_simplified(equivalent_pitch, equivalent_roll, &camera, 120.0, -80.0);
        assert!(simplified.is_some_and(|p| miss([p.m, p.n], [full.m, full.n]) < 1e-9), "{simplified:?}, {full:?}");
    }
}

#[test]
fn distortion_acts_after_the_ray_and_can_be_undone() {
    let distortion = Distortion { k1: -0.1, k2: 0.01, k3: 0.001, p1: 0.002, p2: -0.003 };
    let camera = Camera { offset_m_px: 3.0, offset_n_px: -1.0, distortion, ..camera(640, 480, 63.0, 41.0) };
    let (k_h, k_v) = camera.tangent_per_px();
    // By hand for x = 0.3, y = -0.2 (forward): r^2 = 0.13, radial 0.987171197.
    let level = matrix_a(0.0, 0.0, 0.0, 0.0);
    let p = frame_from_ground(&level, &camera, 0.3 / k_h, 0.2 / k_v);
    let tangents = [(p.m - 3.0) * k_h, (p.n + 1.0) * k_v];
    assert!(miss(tangents, [0.294_981_359_1, 0.196_654_239_4]) < 1e-12, "{tangents:?}");
    for (heading, pitch, roll, follow_up) in attitudes() {
        let a = matrix_a(heading, pitch, roll, follow_up);
        for (m, n) in [(0.0, 0.0), (300.0, 200.0), (-310.5, 220.0), (10.0, -239.0)] {
            let ground = ground_from_frame(&a, &camera, m, n).expect("a mild lens");
            let back = frame_from_ground(&a, &camera, ground.m, ground.n);
            assert!(!ground.in_front || miss([back.m, back.n], [m, n]) < 1e-9, "{ground:?}, {back:?}");
        }
    }
}

/// The test image of table F with its rotation, camera and grid; and the table.
fn remap_case() -> (Image, Matrix3, Camera, Grid, Value) {
    let f = table("003", "F_remap");
    let (size, cells) = (number(&f, "M") as usize, number(&f, "W") as usize);
    let grey = |i: usize| ((31 * (i / size) + 17 * (i % size) + 5 * (((i / size) * (i % size)) % 7)) & 255) as f64;
    let image = Image::new(size, size, (0..size * size).map(grey).collect()).expect("the sizes fit");
    let a = matrix_a(0.0, radians(&f, "theta1"), radians(&f, "gamma1"), 0.0);
    let grid = Grid { cols: cells, rows: cells, resolution_m: number(&f, "R"), height_m: number(&f, "H") };
    (image, a, camera(size, size, number(&f, "V"), number(&f, "V")), grid, f)
}

#[test]
fn golden_f_remap() {
    let (image, a, camera, grid, f) = remap_case();
    let kernels = [("nn", Kernel::Nearest, 0.0), ("bilinear", Kernel::Bilinear, TOLERANCE)];
    for (key, kernel, tolerance) in kernels.into_iter().chain([("area4x4", Kernel::Area4x4, TOLERANCE)]) {
        let ours = remap(&image, &a, &camera, &grid, kernel);
        let golden = f[key].as_array().expect("rows").iter().flat_map(|row| row.as_array().expect("a row"));
        let golden: Vec<Option<f64>> = golden.map(Value::as_f64).collect();
        assert_eq!(ours.len(), golden.len());
        for (i, (ours, golden)) in ours.iter().zip(&golden).enumerate() {
            let met = match (ours, golden) {
                (Some(x), Some(y)) => (x - y).abs() <= tolerance,
                (x, y) => x == y,
            };
            assert!(met, "{key}, cell {}, {}: {ours:?} for {golden:?}", i % grid.cols, i / grid.cols);
        }
    }
}

/// Twice the area of a quadrilateral from its diagonals.
fn twice_area(q: &[(f64, f64); 4]) -> f64 {
    ((q[2].0 - q[0].0) * (q[3].1 - q[1].1) - (q[3].0 - q[1].0) * (q[2].1 - q[0].1)).abs()
}

/// Bounds of the integral of the image over a part of a cell: (area, lower, upper, nearest). The part is halved in both
/// axes until it lies in one pixel or `depth` is used up; there the least and greatest pixel that it may touch bound
/// it. Straight lines stay straight, so the parts fill the cell exactly and none leaves the box of its corners.
fn enclose(
    image: &Image,
    to_frame: &dyn Fn(f64, f64) -> (f64, f64),
    u: f64,
    v: f64,
    size: f64,
    depth: u32,
) -> [f64; 4] {
    let corners = [to_frame(u, v), to_frame(u + size, v), to_frame(u + size, v + size), to_frame(u, v + size)];
    let pixel = |x: f64, count: usize| ((x + 0.5).floor().max(0.0) as usize).min(count - 1);
    let cols = corners.map(|p| pixel(p.0, image.cols()));
    let rows = corners.map(|p| pixel(p.1, image.rows()));
    let range = |x: [usize; 4]| x.iter().copied().min().unwrap_or(0)..=x.iter().copied().max().unwrap_or(0);
    let one = range(cols).count() == 1 && range(rows).count() == 1;
    if depth > 0 && !one {
        let half = size / 2.0;
        let parts = [(u, v), (u + half, v), (u, v + half), (u + half, v + half)];
        let parts = parts.map(|(u, v)| enclose(image, to_frame, u, v, half, depth - 1));
        return std::array::from_fn(|i| parts.iter().map(|part| part[i]).sum());
    }
    let area = twice_area(&corners) / 2.0;
    let touched = range(rows).flat_map(|row| range(cols).filter_map(move |col| image.get(col, row)));
    let (low, high) = touched.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    let centre = to_frame(u + size / 2.0, v + size / 2.0);
    let nearest = image.get(pixel(centre.0, image.cols()), pixel(centre.1, image.rows())).unwrap_or(f64::NAN);
    [area, area * low, area * high, area * nearest]
}

#[test]
fn exact_area_lies_within_its_enclosure() {
    let (image, a, camera, grid, _) = remap_case();
    let exact = exact_area(&image, &a, &camera, &grid);
    let area4x4 = remap(&image, &a, &camera, &grid, Kernel::Area4x4);
    let (mut cells, mut widest, mut worst_nearest, mut widest_nearest) = (0, 0.0_f64, 0.0_f64, 0.0_f64);
    let (mut both, mut sum, mut worst) = (0, 0.0, 0.0_f64);
    for (i, value) in exact.iter().enumerate() {
        let Some(value) = *value else { continue };
        let (col, row) = ((i % grid.cols) as f64, (i / grid.cols) as f64);
        let to_frame = |u: f64, v: f64| {
            let p = frame_from_patch(&a, &camera, &grid, col + u, row + v);
            pixel_from_frame(&camera, p.m, p.n)
        };
        // 10 halvings: parts of 1/1024 of a cell.
        let [area, low, high, _] = enclose(&image, &to_frame, -0.5, -0.5, 1.0, 10);
        assert!(value > low / area - 1e-9 && value < high / area + 1e-9, "cell {i}: {value}, {low}, {high}, {area}");
        // 64 x 64 nearest pixels; both lie within the same bounds, so they differ by no more than those.
        let [area64, low64, high64, nearest64] = enclose(&image, &to_frame, -0.5, -0.5, 1.0, 6);
        assert!((nearest64 / area64 - value).abs() <= (high64 - low64) / area64, "cell {i}: {value}, {nearest64}");
        widest = widest.max((high - low) / area);
        worst_nearest = worst_nearest.max((nearest64 / area64 - value).abs());
        widest_nearest = widest_nearest.max((high64 - low64) / area64);
        cells += 1;
        if let Some(approximation) = area4x4[i] {
            both += 1;
            sum += (approximation - value).abs();
            worst = worst.max((approximation - value).abs());
        }
    }
    println!("exact area: {cells} cells, enclosed within {widest:.3} DN at most");
    println!("64 x 64 nearest - exact area: at most {worst_nearest:.3} DN (bound {widest_nearest:.1})");
    println!("area4x4 - exact area: {both} cells, mean {:.3} DN, at most {worst:.3} DN", sum / f64::from(both));
    assert!(cells > 100 && widest < 1.0, "{cells} cells, {widest} DN: the enclosure proves too little");
}

#[test]
fn exact_area_conserves() {
    let (image, a, camera, grid, _) = remap_case();
    let flat = Image::new(64, 64, vec![7.25; 64 * 64]).expect("the sizes fit");
    let distorted = Camera { distortion: Distortion { k1: -0.2, p1: 0.01, ..Distortion::default() }, ..camera };
    for camera in [camera, distorted] {
        let means = exact_area(&flat, &a, &camera, &grid);
        assert!(means.iter().flatten().count() > 100);
        assert!(means.iter().flatten().all(|mean| (mean - 7.25).abs() < 1e-12), "{means:?}");
    }
    // 8 x 8 cells together are the one cell of 8 times the size.
    let parts = Grid { cols: 8, rows: 8, ..grid };
    let whole = Grid { cols: 1, rows: 1, resolution_m: 8.0 * grid.resolution_m, ..grid };
    let (mut sum, mut area) = (0.0, 0.0);
    for (i, mean) in exact_area(&image, &a, &camera, &parts).into_iter().enumerate() {
        let (col, row) = ((i % 8) as f64, (i / 8) as f64);
        let corner = |u: f64, v: f64| {
            let p = frame_from_patch(&a, &camera, &parts, col + u, row + v);
            pixel_from_frame(&camera, p.m, p.n)
        };
        let weight = twice_area(&[corner(-0.5, -0.5), corner(0.5, -0.5), corner(0.5, 0.5), corner(-0.5, 0.5)]);
        sum += weight * mean.expect("the middle of the patch is covered");
        area += weight;
    }
    let mean = exact_area(&image, &a, &camera, &whole)[0].expect("the middle of the patch is covered");
    assert!((sum / area - mean).abs() < 1e-9, "{} for {mean}", sum / area);
}

#[test]
fn exact_area_by_hand() {
    // Level, one cell of 2.5 pixels about the centre of 4 x 4: columns and rows weigh 0.25, 1, 1, 0.25.
    let camera = camera(4, 4, 90.0, 90.0);
    let values = vec![0., 0., 0., 0., 0., 10., 0., 0., 0., 0., 0., 3., 0., 0., 0., 8.];
    let image = Image::new(4, 4, values).expect("the sizes fit");
    let grid = Grid { cols: 1, rows: 1, resolution_m: 2.5 * 0.5 * 100.0, height_m: 100.0 };
    let level = matrix_a(0.0, 0.0, 0.0, 0.0);
    let mean = exact_area(&image, &level, &camera, &grid)[0].expect("inside");
    assert!((mean - (10.0 + 0.25 * 3.0 + 0.0625 * 8.0) / 6.25).abs() < 1e-12, "{mean}");
    let beyond = Grid { resolution_m: 201.0, ..grid };
    assert_eq!(exact_area(&image, &level, &camera, &beyond), [None]);
}

#[test]
fn golden_i_stamps_and_attitude() {
    let tick = |row: &Value, key: &str| u32::try_from(row[key].as_u64().expect("a tick")).expect("32 bits");
    for row in rows("000", "I_mid_u32") {
        assert_eq!(mid_exposure_u32(tick(&row, "start"), tick(&row, "stop")), tick(&row, "mid"), "{row}");
    }
    for row in rows("000", "I_pps") {
        let time = pps_time(tick(&row, "tick"), tick(&row, "c0"), tick(&row, "c1"), number(&row, "s1"));
        assert!((time - number(&row, "out")).abs() < 1e-9, "{time} for {row}");
    }
    for row in rows("000", "I_att") {
        let [a0, a1] = ["a0", "a1"].map(|key| list(&row, key).map(f64::to_radians));
        let linear = attitude_linear(a0, a1, number(&row, "u")).map(f64::to_degrees);
        let slerp = attitude_slerp(a0, a1, number(&row, "u")).map(f64::to_degrees);
        assert!(miss(linear, list(&row, "linear")) < TOLERANCE, "{linear:?} for {row}");
        assert!(miss(slerp, list(&row, "slerp")) < TOLERANCE, "{slerp:?} for {row}");
        for u in [0.0, 1.0] {
            assert!(miss(attitude_slerp(a0, a1, u), attitude_linear(a0, a1, u)) < 1e-12, "ends of {row}");
        }
    }
}
