use super::*;
use crate::camera::{core_camera, render_camera, still};
use plumbline_core::homography::Homography;
use plumbline_core::tilt::follow_up_command;
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::crs::System;
use plumbline_survey::dem::DemFile;
use plumbline_survey::io::raster::{Band, GeoTransform, geotiff_bytes};

const CENTRE: [f64; 3] = [500_100.0, 5_200_050.0, 620.0];

fn file(distortion: &str) -> CameraFile {
    let text = "cols = 160\nrows = 120\nfov_h_deg = 62.0\nfov_v_deg = 48.0\noffset_m_px = 1.5\noffset_n_px = -2.0\n";
    CameraFile::from_toml_str(&format!("{text}{distortion}"), "test").expect("a camera")
}

fn texture(east: f64, north: f64) -> f64 {
    let (e, n) = (east - CENTRE[0], north - CENTRE[1]);
    128.0 + 50.0 * (e / 9.0).sin() + 50.0 * (n / 12.0 + e / 40.0).sin()
}

/// What the camera sees of the texture on a ground: each pixel's ray carried on to it step by step.
fn seen(camera: &RenderCamera, exterior: &Exterior, height: impl Fn(f64, f64) -> f64) -> Picture {
    let pixel = |at: usize| {
        let [right, forward] = camera.ray((at % camera.cols) as f64, (at / camera.cols) as f64).expect("a mild lens");
        let in_camera = [right, forward, -1.0];
        let to: [f64; 3] =
            std::array::from_fn(|axis| (0..3).map(|row| exterior.camera_from_ground[row][axis] * in_camera[row]).sum());
        let mut point = CENTRE;
        for _ in 0..200 {
            let along = (height(point[0], point[1]) - CENTRE[2]) / to[2];
            point = std::array::from_fn(|axis| CENTRE[axis] + along * to[axis]);
        }
        texture(point[0], point[1]).round() as u8
    };
    Picture { cols: camera.cols, rows: camera.rows, pixels: (0..camera.cols * camera.rows).map(pixel).collect() }
}

/// Root of the mean square of what a patch is off the texture, over its valid pixels, and their share.
fn off(patch: &Patch, cells: &Cells) -> (f64, f64) {
    let mask = patch.mask();
    let valid = (0..patch.picture.pixels.len()).filter(|&at| mask.pixels[at] != 0);
    let errors: Vec<f64> = valid
        .map(|at| {
            let [east, north] = cells.corner(at % cells.size.0, at / cells.size.0);
            let half = 0.5 * cells.resolution_m;
            f64::from(patch.picture.pixels[at]) - texture(east + half, north - half)
        })
        .collect();
    let mean = errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64;
    (mean.sqrt(), patch.valid_fraction())
}

/// A model with posts 2 m apart, by way of its file.
fn model(name: &str, height: impl Fn(f64, f64) -> f64) -> Heights {
    let (side, step) = (241usize, 2.0);
    let geo = GeoTransform { x0: CENTRE[0] - 240.0, y0: CENTRE[1] + 240.0, step_x: step, step_y: step };
    let samples: Vec<f32> = (0..side * side)
        .map(|at| {
            let (east, north) = geo.world_from_pixel((at % side) as f64, (at / side) as f64);
            height(east, north) as f32
        })
        .collect();
    let bands = [Band { description: "height", samples: &samples }];
    let bytes = geotiff_bytes(side, side, &bands, &geo, Some(System::Epsg(32633)), f32::NAN).expect("a raster");
    let path = std::env::temp_dir().join(format!("plumbline-oriented-{}-{name}.tif", std::process::id()));
    std::fs::write(&path, bytes).expect("written");
    let [x, y, _] = CENTRE;
    let heights =
        Heights::over(&DemFile::open(&path).expect("a model"), None, [x - 200.0, y - 200.0, x + 200.0, y + 200.0]);
    std::fs::remove_file(&path).expect("removed");
    heights.expect("it lies there")
}

fn cells(size: usize) -> Cells {
    Cells { centre: [CENTRE[0], CENTRE[1]], size: (size, size), resolution_m: 1.0 }
}

#[test]
fn omega_phi_kappa_turn_one_after_the_other() {
    let angles = [0.21f64, -0.34, 2.6];
    let [(so, co), (sp, cp), (sk, ck)] = angles.map(f64::sin_cos);
    let turns = [
        [[1.0, 0.0, 0.0], [0.0, co, -so], [0.0, so, co]],
        [[cp, 0.0, sp], [0.0, 1.0, 0.0], [-sp, 0.0, cp]],
        [[ck, -sk, 0.0], [sk, ck, 0.0], [0.0, 0.0, 1.0]],
    ];
    let exterior = Exterior::photogrammetric(CENTRE, angles);
    for axis in 0..3 {
        let mut v = [0.0; 3];
        v[axis] = 1.0;
        for turn in turns.iter().rev() {
            v = turn.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
        }
        for (is, wanted) in exterior.camera_from_ground[axis].iter().zip(v) {
            assert!((is - wanted).abs() < 1e-12, "axis {axis}: {is} {wanted}");
        }
    }
    // kappa turns counter-clockwise, a heading clockwise.
    let level = |heading| Attitude { heading: Radians(heading), pitch: Radians(0.0), roll: Radians(0.0) };
    let by_heading = Exterior::of_vehicle(CENTRE, level(-0.7), Radians(0.0));
    let by_kappa = Exterior::photogrammetric(CENTRE, [0.0, 0.0, 0.7]);
    for (one, other) in
        by_heading.camera_from_ground.as_flattened().iter().zip(by_kappa.camera_from_ground.as_flattened())
    {
        assert!((one - other).abs() < 1e-6, "{one} {other}");
    }
}

#[test]
fn over_a_plane_it_is_what_the_core_makes() {
    let file = file("[distortion]\nk1 = -0.12\nk2 = 0.02\np1 = 0.001\np2 = -0.0006\n");
    let (core, camera) = (core_camera(&file).expect("a camera"), render_camera(&file));
    let attitude = Attitude { heading: Radians(0.4), pitch: Radians(0.12), roll: Radians(-0.17) };
    for follow_up in [Radians(0.0), follow_up_command(attitude)] {
        let exterior = Exterior::of_vehicle(CENTRE, attitude, follow_up);
        let frame = seen(&camera, &exterior, |_, _| 500.0);
        let cells = cells(70);
        let ours = rectify(&camera, &frame, &exterior, Terrain::Plane(500.0), &cells).expect("it is seen");
        let target = still::Target { height_m: 120.0, resolution_m: 1.0, size: Some((70, 70)) };
        let homography = Homography::full(&camera_from_local(attitude, follow_up), &core);
        let theirs = still::rectify(&core, &frame, homography, &target).expect("it is seen");
        let (mask, other) = (ours.mask(), theirs.mask());
        let both: Vec<usize> = (0..70 * 70).filter(|&at| mask.pixels[at] != 0 && other.pixels[at] != 0).collect();
        assert!(both.len() > 3000, "{}", both.len());
        let apart = |at: &usize| ours.picture.pixels[*at].abs_diff(theirs.picture.pixels[*at]);
        let mean = both.iter().map(|at| f64::from(apart(at))).sum::<f64>() / both.len() as f64;
        // Two ways to average, of a texture that changes by five greys a pixel.
        assert!(mean < 1.0, "{mean}");
        assert!(off(&ours, &cells).0 < 2.0, "{:?}", off(&ours, &cells));
    }
}

#[test]
fn over_relief_the_model_puts_each_pixel_in_its_place() {
    let hills = |east: f64, north: f64| 500.0 + 0.3 * (east - CENTRE[0]) + 12.0 * ((north - CENTRE[1]) / 25.0).sin();
    let camera = render_camera(&file("[distortion]\nk1 = -0.1\n"));
    let exterior = Exterior::photogrammetric(CENTRE, [0.1, -0.06, 1.1]);
    let frame = seen(&camera, &exterior, hills);
    let cells = cells(80);
    let over_model = rectify(&camera, &frame, &exterior, Terrain::Model(&model("hills", hills)), &cells).expect("seen");
    let over_plane = rectify(&camera, &frame, &exterior, Terrain::Plane(500.0), &cells).expect("seen");
    let ((error, share), (of_plane, _)) = (off(&over_model, &cells), off(&over_plane, &cells));
    assert!(error < 2.5 && share > 0.5, "{error} over {share}");
    assert!(of_plane > 5.0 * error, "{of_plane}");
}

#[test]
fn what_stands_behind_a_hill_is_not_valid() {
    // A wall of 60 m from 30 to 32 m east of the nadir: from 120 m up it hides the ground as far as 64 m.
    let wall = |east: f64, _: f64| if (30.0..34.0).contains(&(east - CENTRE[0])) { 560.0 } else { 500.0 };
    let camera = render_camera(&file(""));
    let exterior = Exterior::photogrammetric(CENTRE, [0.0; 3]);
    let frame = Picture { cols: 160, rows: 120, pixels: vec![90; 160 * 120] };
    let cells = cells(130);
    let valid = |terrain| {
        let mask = rectify(&camera, &frame, &exterior, terrain, &cells).expect("seen").mask();
        // Along the middle row, metres east of the nadir.
        (0..130).filter(|col| mask.pixels[65 * 130 + col] != 0).map(|col| col as i32 - 65).collect::<Vec<_>>()
    };
    let (with, without) = (valid(Terrain::Model(&model("wall", wall))), valid(Terrain::Plane(500.0)));
    let hidden: Vec<i32> = without.iter().copied().filter(|east| !with.contains(east)).collect();
    let behind: Vec<i32> = hidden.iter().copied().filter(|east| *east > 36).collect();
    assert!(behind.iter().all(|east| *east <= 64) && behind.len() >= 25, "{behind:?}");
    assert!(hidden.iter().all(|east| *east >= 27), "{hidden:?}");
}

#[test]
fn what_cannot_be_made_is_told() {
    let camera = render_camera(&file(""));
    let frame = Picture { cols: 160, rows: 120, pixels: vec![90; 160 * 120] };
    let make = |angles, size| {
        let cells = Cells { size, ..cells(10) };
        rectify(&camera, &frame, &Exterior::photogrammetric(CENTRE, angles), Terrain::Plane(500.0), &cells)
            .expect_err("refused")
            .to_string()
    };
    assert!(make([0.0; 3], (0, 5)).contains("0 x 5"));
    assert!(make([0.0; 3], (5000, 5)).contains("5000 x 5"));
    assert!(make([std::f64::consts::PI, 0.0, 0.0], (9, 9)).contains("nothing"), "it looks at the sky");
}

#[test]
fn the_share_of_a_frame_that_cells_show() {
    let camera = render_camera(&file(""));
    let down = |tilt_deg: f64| Exterior::photogrammetric([0.0, 0.0, 100.0], [f64::to_radians(tilt_deg), 0.0, 0.0]);
    let over = |east_m: f64| Cells { centre: [east_m, 0.0], size: (400, 400), resolution_m: 1.0 };
    // The principal point lies 1.5 of 160 columns right of the middle, the cells end below the camera.
    let half = shown(&camera, &down(0.0), 0.0, &over(200.0));
    assert!((half - (0.5 - 1.5 / 160.0)).abs() < 0.011, "{half}");
    assert_eq!(shown(&camera, &down(0.0), 0.0, &over(0.0)), 1.0);
    // From five times the height the frame sees more than the cells; a camera that leans by 70 degrees sees the sky above 90 of 70 ± 24.
    assert!(shown(&camera, &down(0.0), -400.0, &over(0.0)) < 0.8);
    let leant = shown(&camera, &down(70.0), 0.0, &Cells { resolution_m: 1e4, ..over(0.0) });
    let horizon = 0.5 + 0.5 * 20.0_f64.to_radians().tan() / 24.0_f64.to_radians().tan();
    assert!((leant - horizon).abs() < 0.03, "{leant} {horizon}");
}
