//! Sloping ground: the map against rays that are cut with the plane in f64, and the height above it.

use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::camera::Camera;
use plumbline_core::elevation::{Elevation, Posts};
use plumbline_core::homography::FrameFromPatch;
use plumbline_core::navigation::Navigation;
use plumbline_core::pipeline::{Buffers, FollowUpMode, Memory, Pipeline, PositionSample, Settings, Situation};
use plumbline_core::pose::Wait;
use plumbline_core::tile::{Geographic, Georeference, Tile};
use plumbline_core::tilt::{Attitude, follow_up_command};
use plumbline_core::units::{Metres, Micros, Radians};
use plumbline_sim::oracle;
use plumbline_sim::scenario::{Camera as CameraOf, Scenario};
use plumbline_sim::setup::Setup;
use plumbline_tests::seeded::Random;

const SIDE: u16 = 512;
const FOV_DEG: f64 = 60.0;
/// Pixels of the frame. The map's figures are single: 1e-7 of some hundred pixels, a few times over.
const TOLERANCE_PX: f64 = 1e-3;

fn camera() -> Camera {
    let fov = Radians::from_degrees(FOV_DEG as f32);
    Camera::new((SIDE, SIDE), (fov, fov), (0.0, 0.0), None).expect("a camera")
}

fn oracle_camera() -> oracle::Camera {
    let (side, fov_rad) = (usize::from(SIDE), FOV_DEG.to_radians());
    oracle::Camera {
        cols: side,
        rows: side,
        fov_h_rad: fov_rad,
        fov_v_rad: fov_rad,
        offset_m_px: 0.0,
        offset_n_px: 0.0,
        distortion: oracle::Distortion::default(),
    }
}

fn random_attitude(random: &mut Random) -> Attitude {
    let mut angle = |limit_deg: f64| Radians(random.between(-limit_deg, limit_deg).to_radians() as f32);
    Attitude { heading: angle(180.0), pitch: angle(12.0), roll: angle(12.0) }
}

#[test]
fn a_frames_pixel_sees_the_point_where_its_ray_meets_the_plane() {
    let (camera, judge) = (camera(), oracle_camera());
    let (k_h, k_v) = judge.tangent_per_px();
    let (height_m, resolution_m, patch) = (120.0f32, 5.0f32, (31u16, 31u16));
    let mut random = Random::new(11);
    let mut seen = 0;
    for case in 0..400 {
        let attitude = random_attitude(&mut random);
        let slope = [random.between(-0.4, 0.4), random.between(-0.4, 0.4)];
        let followed = case % 2 == 0;
        let follow_up = if followed { follow_up_command(attitude) } else { Radians(random.between(-3.0, 3.0) as f32) };
        let situation = Situation {
            slope: slope.map(|slope| slope as f32),
            ..Situation::exact(Micros(0), attitude, (follow_up, followed), height_m)
        };
        let map = FrameFromPatch::new(situation.homography(&camera), &camera, (height_m, resolution_m), patch);
        let [heading, pitch, roll, turn] =
            [attitude.heading.0, attitude.pitch.0, attitude.roll.0, follow_up.0].map(f64::from);
        let a = oracle::matrix_a(heading, pitch, roll, turn);
        for (m, n) in [(0.0, 0.0), (200.0, 140.0), (-230.5, 17.0), (30.0, -250.0), (-120.0, 180.0)] {
            // The ray in heights, down by 1, and where it meets z = a x + b y - 1.
            let level = oracle::ground_from_frame(&a, &judge, m, n).expect("no distortion");
            let (east, north) = (level.m * k_h, level.n * k_v);
            let along = 1.0 / (1.0 + slope[0] * east + slope[1] * north);
            assert!(level.in_front && along > 0.0, "{attitude:?} {slope:?}");
            let metres = [along * east, along * north].map(|heights| heights * f64::from(height_m));
            let [col, row] = [15.0 + metres[0] / f64::from(resolution_m), 15.0 - metres[1] / f64::from(resolution_m)];
            let Some((col, row)) = map.frame_position(col as f32, row as f32) else { continue };
            let (true_col, true_row) = oracle::pixel_from_frame(&judge, m, n);
            let off = (f64::from(col) - true_col).hypot(f64::from(row) - true_row);
            assert!(off < TOLERANCE_PX, "{attitude:?} {slope:?} {followed}: {off}");
            seen += 1;
        }
    }
    assert!(seen > 1990, "{seen} of 2000 pixels");
}

#[test]
fn level_ground_is_mapped_to_the_bit_as_before() {
    let camera = camera();
    let mut random = Random::new(12);
    for _ in 0..50 {
        let attitude = random_attitude(&mut random);
        let follow_up = follow_up_command(attitude);
        let level = Situation::exact(Micros(0), attitude, (follow_up, true), 120.0);
        let tilt = plumbline_core::tilt::equivalent_tilt(attitude, follow_up);
        let expected = plumbline_core::homography::Homography::simplified(tilt, &camera);
        assert_eq!(level.homography(&camera), expected);
    }
}

/// Posts of a plane through 350 m over the tile's centre.
fn plane_posts(slope: [f64; 2]) -> (Posts, Vec<u8>) {
    let posts = Posts { size: (41, 41), spacing_m: 30.0, step_m: 0.01, base_m: 350.0, vertical_epsg: 0 };
    let number = |index: usize| {
        let (east, north) = (30.0 * ((index % 41) as f64 - 20.0), 30.0 * (20.0 - (index / 41) as f64));
        ((slope[0] * east + slope[1] * north) / 0.01).round() as i16
    };
    (posts, (0..41 * 41).flat_map(|index| number(index).to_le_bytes()).collect())
}

fn settings() -> Settings {
    let mut scenario = Scenario::of_frames(1);
    scenario.camera = CameraOf::of_size(64, 64);
    let flash = Setup::prepare(scenario).expect("it can be flown").flash;
    Settings { follow_up: FollowUpMode::Fixed, ..flash.configuration.settings().expect("sound") }
}

/// The situation of a vehicle that hangs still at `attitude`, 60 m east and 30 m south of the centre of a tile with or without
/// posts, whose laser says `slant_m`.
fn situation(settings: Settings, posts: Option<&(Posts, Vec<u8>)>, attitude: Attitude, slant_m: f32) -> Situation {
    let pixels = vec![0; 100 * 100];
    let centre = Geographic { lat_e7: 480_000_000, lon_e7: 160_000_000 };
    let (east, north) = ([750.0, 0.0, 0.0, 0.0, 0.0], [0.0, 1000.0, 0.0, 0.0, 0.0]);
    let georeference = Georeference { epsg: 32633, centre, east, north, convergence: Radians(0.0), point_scale: 1.0 };
    let mut tile = Tile::new(&pixels, (100, 100), Metres(5.0), georeference).expect("a tile");
    if let Some((posts, bytes)) = posts {
        tile = tile.with_elevation(Elevation::new(bytes, *posts).expect("sound")).expect("it covers the tile");
    }
    let (mut buffers, mut frame_memory) = (Box::new(Buffers::new()), vec![0; FRAME_MEMORY_BYTES]);
    let mut navigation = Navigation::new();
    let memory = Memory { buffers: &mut buffers, navigation: &mut navigation, frame: &mut frame_memory };
    let mut pipeline = Pipeline::new(settings, tile, memory).expect("a pipeline");
    let mid = Micros(1_000_000);
    for us in (960_000..1_050_000).step_by(5_000) {
        // A sensor one of whose angles stays counts as frozen.
        let trembles = |angle: Radians| Radians(angle.0 + 1e-6 * (us % 15_000) as f32 * 1e-3);
        let Attitude { heading, pitch, roll } = attitude;
        let trembling = Attitude { heading: trembles(heading), pitch: trembles(pitch), roll: trembles(roll) };
        pipeline.streams.attitude(Micros(us), trembling).expect("in order");
        pipeline.streams.slant(Micros(us), Metres(slant_m)).expect("in order");
    }
    // 0.08 hundredths of a degree of 750 m, and -0.03 of 1,000 m.
    let position = Geographic { lat_e7: centre.lat_e7 - 3_000, lon_e7: centre.lon_e7 + 8_000 };
    let sample = PositionSample::standing(position);
    pipeline.position(mid, sample).expect("in order");
    pipeline.begin_frame().expect("a range is there");
    pipeline.situate((mid, 1.0), Wait::No).expect("samples are there").expect("samples are there")
}

#[test]
fn the_height_is_that_above_the_plane_at_the_nadir() {
    let settings = settings();
    let mut random = Random::new(13);
    for _ in 0..60 {
        let attitude = random_attitude(&mut random);
        let slope = [random.between(-0.3, 0.3), random.between(-0.3, 0.3)];
        let height_m = random.between(80.0, 130.0);
        // Where the optical axis, along which the laser looks, meets the plane.
        let [heading, pitch, roll] = [attitude.heading.0, attitude.pitch.0, attitude.roll.0].map(f64::from);
        let a = oracle::matrix_a(heading, pitch, roll, 0.0);
        let down = a[1].map(|part| -part);
        let slant_m = height_m / (-down[1] + slope[0] * down[2] + slope[1] * down[0]);
        let posts = plane_posts(slope);
        let found = situation(settings, Some(&posts), attitude, slant_m as f32);
        let off = (f64::from(found.height_m) - height_m).abs();
        assert!(off < 0.02, "{attitude:?} {slope:?}: {} of {height_m}", found.height_m);
        let off = (f64::from(found.slope[0]) - slope[0]).hypot(f64::from(found.slope[1]) - slope[1]);
        assert!(off < 1e-3 && found.relief_m < 0.02, "{:?} of {slope:?}, {} m", found.slope, found.relief_m);
        // Without a model the ground is level at the laser's height, as it always was.
        let level = situation(settings, None, attitude, slant_m as f32);
        assert_eq!(level.height_m, slant_m as f32 * level.attitude.cos_tilt());
        assert_eq!((level.slope, level.relief_m), ([0.0; 2], 0.0));
        // What the slope adds to the height's uncertainty: the beam lands elsewhere.
        assert!(found.sigma_height_m > level.sigma_height_m);
    }
}

#[test]
fn off_the_model_the_ground_is_level() {
    let settings = settings();
    let (posts, mut bytes) = plane_posts([0.2, 0.1]);
    // A void 60 m east and 30 m south of the middle.
    let index = 21 * 41 + 22;
    bytes[2 * index..2 * index + 2].copy_from_slice(&i16::MIN.to_le_bytes());
    let found = situation(settings, Some(&(posts, bytes)), Attitude::default(), 100.0);
    assert_eq!((found.height_m, found.slope, found.relief_m), (100.0 * found.attitude.cos_tilt(), [0.0; 2], 0.0));
}
