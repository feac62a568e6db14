//! Simulated frames of four heads, stitched, beside what one camera sees. 700 m up, pixels ten times the paper's, 1 m on the
//! ground.

use super::four::four;
use plumbline_sim::camera::heads::Rig;
use plumbline_sim::camera::render::Station;
use plumbline_sim::camera::stitch::{Seam, Simulated, mismatches, pairs, simulate, stitch};
use plumbline_sim::world::{Grid, Ground, procedural};
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::io::picture::Picture;
use std::path::Path;
use std::sync::OnceLock;

const LARGER: f64 = 10.0;
const HEIGHT_M: f64 = 700.0;
/// What the seams may be off.
const SEAM_MAX_PX: f64 = 0.15;

/// The procedural ground, 1.8 km a side, its houses standing up.
fn ground() -> &'static Ground {
    static GROUND: OnceLock<Ground> = OnceLock::new();
    GROUND.get_or_init(|| procedural(1))
}

/// Over its middle, a little askew, the ground filling the image.
fn station() -> Station {
    let [east_m, north_m] = ground().bounds().centre();
    let (pitch_rad, roll_rad) = (0.01, -0.008);
    Station { east_m, north_m, up_m: HEIGHT_M, heading_rad: 0.02, pitch_rad, roll_rad, ..Station::default() }
}

fn simulated(ground: &Ground, known: &CameraFile, height_m: Option<f64>) -> Simulated {
    simulate(ground, &station(), (&four(LARGER), known), height_m, (2.0, 5)).expect("a virtual image")
}

/// The largest shift of any seam; all four heads have to be in.
fn worst_seam(simulated: &Simulated) -> f64 {
    let mut heads = [0; 4];
    let mut worst = 0.0_f64;
    for seam in &simulated.seams {
        println!("{seam:?}");
        seam.heads.iter().for_each(|&head| heads[head] += seam.windows);
        worst = worst.max(seam.max_px.unwrap_or(0.0));
    }
    assert!(heads.iter().all(|windows| *windows >= 10), "windows of each head: {heads:?}");
    worst
}

fn keep(name: &str, picture: &Picture) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("heads");
    std::fs::create_dir_all(&folder).expect("a folder");
    plumbline_survey::io::picture::write_grey_png(&folder.join(name), picture).expect("written");
}

/// Houses of up to 15 m stand on the ground; the virtual image is made for the plane below.
#[test]
fn four_heads_make_the_picture_of_one_camera() {
    let ours = simulated(ground(), &four(LARGER), Some(HEIGHT_M));
    let (cols, rows) = ours.mosaic.size;
    keep("mosaic.png", &Picture { cols, rows, pixels: ours.mosaic.samples.clone() });
    keep("ideal.png", &ours.ideal);
    for (index, frame) in ours.frames.iter().enumerate() {
        keep(&format!("head{}.png", index + 1), &frame.grey());
    }
    let worst = worst_seam(&ours);
    println!("seams {worst:.3} px, greys {:.2} DN RMS, all over {:?}", ours.grey_rms_dn, ours.off);
    assert_eq!(ours.mosaic.coverage, 1.0, "the assumed tilts cover the image");
    assert!(worst <= SEAM_MAX_PX, "{worst} px");
    // Nor is the whole off: every window of the image lies where the one camera sees it.
    assert!(ours.off.windows >= 100 && ours.off.max_px.expect("windows") <= SEAM_MAX_PX, "{:?}", ours.off);
}

/// Hills of some metres under the same picture: parallax of the heads is f d dh/H², 0.01 px for 7 m.
#[test]
fn relief_of_some_metres_leaves_the_seams_together() {
    let flat = ground().surface_grid().expect("a surface");
    let (cols, rows, step_m) = (flat.cols / 20, flat.rows / 20, flat.step_m * 20.0);
    let hill = |index: usize| {
        let (col, row) = ((index % cols) as f64 * step_m, (index / cols) as f64 * step_m);
        (4.0 * (col / 130.0).sin() + 3.0 * (row / 90.0).cos()) as f32
    };
    let hills = Grid { cols, rows, step_m, data: (0..cols * rows).map(hill).collect(), ..*flat };
    let ground = ground().clone().with_surface(Some(hills)).expect("a ground");
    let ours = simulated(&ground, &four(LARGER), Some(HEIGHT_M));
    let worst = worst_seam(&ours);
    println!("hills: seams {worst:.3} px, greys {:.2} DN RMS, all over {:?}", ours.grey_rms_dn, ours.off);
    assert!(worst <= SEAM_MAX_PX, "{worst} px");
    assert!(ours.off.max_px.expect("windows") <= SEAM_MAX_PX, "{:?}", ours.off);
}

/// What the figures are there for: a head that is a tenth of a degree off its calibration is seen in its own seams, by what
/// that is in pixels, and in no others.
#[test]
fn a_head_that_is_off_its_calibration_shows_in_its_seams() {
    let mut known = four(LARGER);
    // 691 px times 0.1 degrees.
    known.heads[3].rotation_deg[0] += 0.1;
    let ours = simulated(ground(), &known, Some(HEIGHT_M));
    for seam in &ours.seams {
        let rms = seam.rms_px.expect("windows");
        println!("{seam:?}");
        if seam.heads.contains(&3) {
            // Along x it is 1.2 px on the axis and more beside it, by 1 + tan²; in the virtual image up to half as much again.
            assert!((1.0..2.2).contains(&rms), "{seam:?}");
        } else {
            assert!(rms < SEAM_MAX_PX, "{seam:?}");
        }
    }
}

/// Heads two metres and more apart over ground 100 m below: with the height their seams fit, without they do not.
#[test]
fn the_height_takes_off_the_parallax() {
    let mut wide = four(LARGER);
    wide.heads.iter_mut().for_each(|head| head.d_m = head.d_m.map(|arm| 20.0 * arm));
    let station = station();
    let flat = ground().clone().with_surface(None).expect("flat");
    let ours = |height_m| simulate(&flat, &station, (&wide, &wide), height_m, (2.0, 5)).expect("a virtual image");
    let (near, far) = (ours(Some(HEIGHT_M)), ours(None));
    // 691 px x 1.8 m / 700 m between heads side by side in x, 2.4 m between those in y.
    let (near, far) = (worst_seam(&near), worst_seam(&far));
    println!("with the height {near:.3} px, without {far:.3} px");
    assert!(near <= SEAM_MAX_PX && far > 1.5, "{near} {far}");
}

/// Hard seams hold greys of one head each, and lie where two axes are equally near; both ways cover the same pixels.
#[test]
fn a_hard_seam_takes_each_pixel_from_the_nearest_head() {
    let file = four(40.0);
    let rig = Rig::new(&file, None).expect("four heads");
    let grey = |head: usize| {
        let Head { cols, rows } = Head::of(&file, head);
        plumbline_survey::io::picture::Bands(vec![Picture {
            cols,
            rows,
            pixels: vec![50 * (head as u8 + 1); cols * rows],
        }])
    };
    let frames: Vec<_> = (0..4).map(grey).collect();
    let hard = stitch(&rig, &frames, Seam::Hard, &|| ()).expect("an image");
    let feather = stitch(&rig, &frames, Seam::Feather, &|| ()).expect("an image");
    assert_eq!(hard.coverage, feather.coverage);
    let (cols, rows) = hard.size;
    for row in 0..rows {
        for col in 0..cols {
            // Row 0 is forward: heads 1 and 2.
            let quadrant = usize::from(2 * col >= cols) + 2 * usize::from(2 * row >= rows);
            let on_seam = 2 * col + 1 == cols || 2 * row + 1 == rows;
            let value = hard.samples[row * cols + col];
            assert!(on_seam || value == 50 * (quadrant as u8 + 1), "{value} at {col}, {row}");
        }
    }
    // Feathered, the middle is the mean of all, and no step along a row is more than a fifth of that between two heads.
    let middle = i16::from(feather.samples[(rows / 2) * cols + cols / 2]);
    assert!((middle - 125).abs() <= 3, "{middle}");
    let line = &feather.samples[(rows / 4) * cols..][..cols];
    let steps = line.windows(2).map(|pair| i16::from(pair[1]) - i16::from(pair[0]));
    assert!(steps.into_iter().all(|step| (0..=10).contains(&step)), "{line:?}");
    assert!(mismatches(&rig, &frames[..3], &pairs(&rig), &|| ()).is_err(), "three frames for four heads");
}

/// Size of a head's frame.
struct Head {
    cols: usize,
    rows: usize,
}

impl Head {
    fn of(file: &CameraFile, head: usize) -> Self {
        let head = &file.heads[head];
        Head { cols: head.cols as usize, rows: head.rows as usize }
    }
}
