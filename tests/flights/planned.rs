//! Plans flown: the firmware exposes where it was planned, on every link alike, and what came of it is told.

use plumbline_firmware::boot;
use plumbline_sim::link::Link;
use plumbline_sim::link::device::Device;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::pace::Patience;
use plumbline_sim::link::qemu::{Qemu, default_image};
use plumbline_sim::link::serial::Serial;
use plumbline_sim::replay::read::read;
use plumbline_sim::replay::{self, replay};
use plumbline_sim::run::{Flight, Keep, fly};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::score::plan::{Flown, Missed, flown};
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{fixes_csv, score};
use plumbline_sim::setup::planned::store::of_file;
use plumbline_sim::setup::{PlanToFly, Setup};
use plumbline_survey::dem::Dem;
use plumbline_survey::plan::PlanFile;
use plumbline_survey::plan::area::Area;
use plumbline_survey::plan::axes::Axes;
use plumbline_survey::plan::cells::{Cells, Summary};
use plumbline_survey::plan::course::Course;
use plumbline_survey::plan::intersect::Sigmas;
use plumbline_survey::plan::lines::{Strip, View};
use plumbline_survey::plan::sight::Photos;
use plumbline_survey::plan::terrain::Terrain;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};

/// Flying height, base plane, fields of view and frame of all plans here.
const HEIGHT_M: f64 = 300.0;
const BASE_HEIGHT_M: f64 = 100.0;
const PIXELS: (u32, u32) = (96, 72);
const HALF_TANGENT: (f64, f64) = (0.4, 0.3);
/// Overlaps of 60 and 30 %, over the base plane.
const BASE_M: f64 = 0.4 * 2.0 * 0.3 * HEIGHT_M;
const SPACING_M: f64 = 0.7 * 2.0 * 0.4 * HEIGHT_M;
const SPEED_M_S: f64 = 30.0;

/// No noise, no deviation, no tilt.
const EXACT: &str = "[plan]\ndeviation_m = [0.0, 0.0]\n[flight]\ntilt_max_deg = 0.0\nheading_wander_deg = 0.0\n\
                     [position]\nsigma_m = 0.0\nwhite_m = 0.0\nvelocity_sigma_m_s = 0.0\n";

/// A folder with an elevation model, removed in the end.
struct Folder(PathBuf);

impl Folder {
    /// `relief_m`: how high its hills are above the base plane, at most.
    fn new(name: &str, relief_m: f64) -> Self {
        let folder = std::env::temp_dir().join(format!("plumbline-planned-{name}-{}", std::process::id()));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).expect("a folder");
        let (cols, rows, step) = (100, 100, 25.0);
        let mut text = format!("ncols {cols}\nnrows {rows}\nxllcenter -1000\nyllcenter -1000\ncellsize {step}\n");
        for row in (0..rows).rev() {
            for col in 0..cols {
                let (x, y) = (-1000.0 + step * f64::from(col), -1000.0 + step * f64::from(row));
                let height = BASE_HEIGHT_M + relief_m * (x / 170.0).sin() * (y / 140.0).cos();
                text.push_str(&format!("{height:.3} "));
            }
            text.push('\n');
        }
        fs::write(folder.join("dem.asc"), text).expect("written");
        Folder(folder)
    }

    /// Three strips of six photos, the middle one flown back; everything `aside_m` further north.
    fn plan(&self, name: &str, aside_m: f64) -> PathBuf {
        let strip = |line: u32| {
            let photo = |n: u32| {
                json!({ "x": f64::from(n) * BASE_M, "y": aside_m + f64::from(line) * SPACING_M,
                        "z": BASE_HEIGHT_M + HEIGHT_M })
            };
            json!({ "line": line, "heading_deg": if line == 1 { 270.0 } else { 90.0 },
                    "photos": (0..6).map(photo).collect::<Vec<Value>>() })
        };
        let degrees = |tangent: f64| 2.0 * tangent.atan().to_degrees();
        let plan = json!({
            "version": 1, "dem": "dem.asc", "epsg": null, "origin_deg": [48.2, 16.3],
            "camera": { "cols": PIXELS.0, "rows": PIXELS.1, "fov_h_deg": degrees(HALF_TANGENT.0),
                        "fov_v_deg": degrees(HALF_TANGENT.1), "offset_m_px": 0.0, "offset_n_px": 0.0,
                        "pixel_mm": null, "distortion": null },
            "height_m": HEIGHT_M, "base_height_m": BASE_HEIGHT_M,
            "gsd_m": 2.0 * HALF_TANGENT.0 * HEIGHT_M / f64::from(PIXELS.0),
            "strip_heading_deg": 90.0, "speed_m_s": SPEED_M_S, "min_interval_s": 1.0,
            "overlap_wanted": { "forward": 0.6, "side": 0.3 }, "overlap_min": { "forward": 0.6, "side": 0.3 },
            "photo_count": 18, "base_min_m": BASE_M, "interval_min_s": BASE_M / SPEED_M_S,
            "area": [[BASE_M, 0.0], [4.0 * BASE_M, 0.0], [4.0 * BASE_M, 2.0 * SPACING_M], [BASE_M, 2.0 * SPACING_M]],
            "strips": [strip(0), strip(1), strip(2)],
            "noise": { "image_px": 0.5, "position_m": 0.1, "attitude_deg": 0.01 },
            "accuracy": null,
            "checks": { "clearance_min_m": 250.0, "smear_px": 0.1, "exposure_max_s": 0.01, "exposure_s": 0.001,
                        "length_m": 5000.0, "flight_time_s": 200.0, "turn_radius_m": 120.0, "photos_beyond_dem": 0 },
            "constant_base": { "base_m": BASE_M, "spacing_m": SPACING_M, "lines": 3, "photos": 18, "photos_saved": 0 },
            "combinations": [],
        });
        let path = self.0.join(name);
        fs::write(&path, plan.to_string()).expect("written");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn setup(plan: &Path, scenario: &str) -> Setup {
    let read = Scenario::parse_planned(scenario, "test", Path::new(""), None).expect("a scenario");
    let plan = PlanToFly { file: plan.to_owned(), dem: None, has_resolution: read.1 };
    Setup::along_plan(read.0, &plan).expect("it can be flown")
}

/// A flight over a link, what came of its plan, and its fixes.csv.
fn fly_over(setup: &Setup, link: &mut dyn Link) -> (Flight, Flown, String) {
    let flight = fly(setup, link, Keep::default(), &mut ()).expect("it flies");
    let scored = score(setup, &flight, &Unrectified::default());
    let csv = fixes_csv(setup, &flight, &scored);
    let flown = flown(setup, &flight).expect("it had a plan");
    (flight, flown, csv)
}

fn in_process(setup: &Setup) -> (Flight, Flown, String) {
    fly_over(setup, &mut InProcess::new(&setup.flash).expect("it boots"))
}

/// Off the planned place along and across the strip, mean and largest of both.
fn off(flown: &Flown) -> [[f64; 2]; 2] {
    flown.position_error_m.expect("photos were taken").map(|error| [error.mean, error.max])
}

/// An exposure so long that its shutter would have had to open before the firmware commits to it, 200 ms ahead: the firmware
/// counts the photos as exposed, and none was taken.
#[test]
fn commitments_that_come_too_late_are_counted_as_such() {
    let folder = Folder::new("late", 0.0);
    let scenario = format!("exposure_us = 500000\nframe_interval_ms = 2000\n{EXACT}");
    let (flight, flown, _) = in_process(&setup(&folder.plan("plan.json", 0.0), &scenario));
    assert_eq!(flight.plan.expect("it reports its plan").exposed, 18);
    assert_eq!((flown.exposed, flown.missed), (0, Missed { late: 18, ..Missed::default() }));
}

#[test]
fn without_noise_photos_are_taken_where_they_are_planned_to_centimetres() {
    let folder = Folder::new("exact", 0.0);
    let setup = setup(&folder.plan("plan.json", 0.0), EXACT);
    let (flight, flown, _) = in_process(&setup);
    assert_eq!((flown.photos, flown.exposed, flown.missed), (18, 18, Missed::default()));
    let numbers: Vec<u32> = flight.frames.iter().filter_map(|record| record.photo).map(|photo| photo.photo).collect();
    assert_eq!(numbers, (0..18).collect::<Vec<_>>());
    assert_eq!(flown.named, 18, "{:?}", flight.photos);
    // Along, the plan's and the message's places are rounded to 1e-7 degrees, 0.6 cm each, and the velocity to 1 cm/s, of which
    // it is propagated for half a second at most: 0.25 cm. Across, nothing of it matters.
    let [[_, along], [_, across]] = off(&flown);
    assert!(along < 0.016 && across < 1e-6, "{flown:?}");
    // Flat ground, level photos: the overlaps are those of the base plane.
    let overlap = flown.overlap.achieved.expect("photos were taken");
    assert!((overlap.forward.expect("pairs") - 0.6).abs() < 0.002, "{overlap:?}");
    assert!((overlap.side.expect("pairs") - 0.3).abs() < 0.002, "{overlap:?}");
    // What the planner itself says of these photos, which it takes to be level and in place.
    let dem = Dem::from_fn((60, 60), [-300.0, -300.0], [25.0, 25.0], |_, _| BASE_HEIGHT_M);
    let terrain = Terrain::new(&dem);
    let (x, y) = (4.0 * BASE_M, 2.0 * SPACING_M);
    let area = Area::new(&[[BASE_M, 0.0], [x, 0.0], [x, y], [BASE_M, y]]).expect("an area");
    let along_m: Vec<f64> = (0..6).map(|n| f64::from(n) * BASE_M).collect();
    let strips = [0, 1, 2].map(|line| Strip {
        line,
        across_m: line as f64 * SPACING_M,
        along_m: along_m.clone(),
        course: Course::default(),
    });
    let footprint_m = [2.0 * HALF_TANGENT.1 * HEIGHT_M, 2.0 * HALF_TANGENT.0 * HEIGHT_M];
    let view = View { height_m: HEIGHT_M, base_height_m: BASE_HEIGHT_M, footprint_m };
    let pixel = [2.0 * HALF_TANGENT.1 / f64::from(PIXELS.1), 2.0 * HALF_TANGENT.0 / f64::from(PIXELS.0)];
    let sigmas = Sigmas { image: pixel.map(|t| 0.5 * t), position_m: 0.1, attitude_rad: 0.01f64.to_radians() };
    let known =
        Cells::new(&terrain, &area, 10_000).known(&Photos::new(&strips, &terrain, Axes::new(90.0), &view), &sigmas);
    let summary = Summary::new(&known).expect("it is seen");
    let (achieved, noisy) = (flown.accuracy_m.achieved.expect("seen"), flown.simulated_m.achieved.expect("seen"));
    for axis in 0..2 {
        assert!((achieved[axis] / summary.rms_m[axis] - 1.0).abs() < 0.02, "{achieved:?} {:?}", summary.rms_m);
        // Thousands of points, whose errors hang together by those of 18 photos, eight times.
        assert!((noisy[axis] / achieved[axis] - 1.0).abs() < 0.2, "{noisy:?} {achieved:?}");
    }
    let covered = 1.0 - summary.gaps as f64 / known.len() as f64;
    assert!((flown.coverage.achieved.expect("cells") - covered).abs() < 0.01, "{flown:?} {covered}");
}

/// What the navigation does not know it cannot hold: 0.1 m of drift, 0.02 m of noise, 0.05 m/s over half a second, and what
/// the track bends meanwhile, a metre at 0.05 Hz; five sigmas of it.
#[test]
fn with_noise_photos_are_taken_within_what_the_navigation_knows() {
    let folder = Folder::new("noisy", 20.0);
    let setup = setup(&folder.plan("plan.json", 0.0), "");
    let (_, flown, csv) = in_process(&setup);
    assert_eq!((flown.exposed, flown.missed, flown.named), (18, Missed::default(), 18));
    let sigma = (0.1f64.powi(2) + 0.02f64.powi(2) + (0.05f64 * 0.5).powi(2)).sqrt() + 0.5 * 0.1 * 0.25;
    let [[_, along], [_, across]] = off(&flown);
    assert!(along < 5.0 * sigma && along > 0.01, "{along} {sigma}");
    // Across it is the track's deviation.
    assert!(across < 5.0 && across > 0.1, "{across}");
    let accepted = csv.lines().skip(1).filter(|line| line.split(',').nth(2) == Some("1")).count();
    assert!(accepted >= 15, "{accepted} fixes\n{csv}");
}

#[test]
fn a_flight_beside_its_lines_takes_no_photo_and_says_why() {
    let folder = Folder::new("beside", 0.0);
    let mut flies = setup(&folder.plan("plan.json", 0.0), EXACT);
    // A tenth of the swath of 240 m is the limit.
    flies.flash.plan = setup(&folder.plan("beside.json", 40.0), EXACT).flash.plan;
    let (flight, flown, _) = in_process(&flies);
    assert_eq!((flight.frames.len(), flown.exposed), (0, 0));
    assert_eq!(flown.missed, Missed { off_line: 18, ..Missed::default() });
    assert_eq!(flown.position_error_m, None);
}

/// A plan that names its photos' latitudes and longitudes makes the store that is flown, whichever way its strips are listed.
#[test]
fn a_plan_file_makes_the_store_that_is_flown() {
    let folder = Folder::new("store", 0.0);
    let path = folder.plan("plan.json", 0.0);
    let flies = setup(&path, EXACT);
    let mut file = PlanFile::read(&path).expect("a plan");
    assert!(of_file(&file).expect_err("it has no latitudes").to_string().contains("--origin"));
    let planned = flies.plan.as_ref().expect("a plan");
    for strip in &mut file.strips {
        for photo in &mut strip.photos {
            let [east, north] = planned.place.grid([photo.x, photo.y]).expect("a place");
            let (lat, lon) = planned.place.crs.to_wgs84(east, north).expect("a place");
            (photo.lat, photo.lon) = (Some(lat), Some(lon));
        }
    }
    let store = of_file(&file).expect("a store");
    // Header, head and three strips, whose courses are from true north in one and from the grid's in the other.
    let photos = 32 + 16 + 3 * 8;
    assert_eq!(store[photos..], flies.flash.plan[photos..]);
    assert_eq!((store.len(), &store[32..48]), (photos + 18 * 8, &flies.flash.plan[32..48]));
    let stores = flies.flash.stores().expect("usable");
    assert!(boot::read(&stores.configuration, &stores.tiles, &store).expect("it boots").plan.is_some());
}

/// A log holds no plan, and needs none to be run again.
#[test]
fn a_planned_flight_replays_to_its_own_fixes() {
    let folder = Folder::new("log", 0.0);
    let setup = setup(&folder.plan("plan.json", 0.0), "frames = 6");
    let mut link = InProcess::logged(&setup.flash).expect("it boots");
    let (_, _, csv) = fly_over(&setup, &mut link);
    let log = read(&link.close_log(), None).expect("a log");
    let replayed = replay(&log, None).expect("it runs");
    assert_eq!((replayed.frames, replayed.same, replayed.different), (6, 6, 0), "{:?}", replayed.first_difference);
    assert_eq!(replay::fixes_csv(&log, None, &replayed).expect("a place"), csv);
}

#[test]
fn frames_end_the_flight_early() {
    let folder = Folder::new("early", 0.0);
    let scenario = format!("frames = 4\n{EXACT}");
    let setup = setup(&folder.plan("plan.json", 0.0), &scenario);
    let (flight, flown, csv) = in_process(&setup);
    assert_eq!((flight.frames.len(), flown.exposed, flown.missed.not_reached), (4, 4, 14));
    assert_eq!(csv.lines().count(), 5);
    assert!(flight.frames.iter().all(|record| record.report.is_some()));
}

#[test]
fn a_board_on_a_line_flies_the_same_plan() {
    let folder = Folder::new("links", 20.0);
    let setup = setup(&folder.plan("plan.json", 0.0), "");
    let (_, expected, csv) = in_process(&setup);
    let device = Device::socket(&folder.0.join("socket")).expect("a socket");
    let mut serial = Serial::open(&setup.flash, device.path(), Patience::default()).expect("it takes the plan");
    let (_, flown, of_serial) = fly_over(&setup, &mut serial);
    assert!(of_serial == csv && flown == expected, "{of_serial}\n{csv}");
}

#[test]
#[ignore = "long: a whole plan on the emulated core"]
fn the_emulated_board_flies_the_same_plan() {
    let folder = Folder::new("emulated", 20.0);
    let setup = setup(&folder.plan("plan.json", 0.0), "");
    let (_, expected, csv) = in_process(&setup);
    let image = default_image();
    if !image.is_file() {
        println!("skipped: there is no image {}, `cargo xtask build` makes it", image.display());
        return;
    }
    let mut emulated = match Qemu::launch(&setup.flash, &image) {
        Ok(emulated) => emulated,
        Err(why) => {
            println!("skipped: {why}");
            return;
        }
    };
    let (flight, flown, of_emulated) = fly_over(&setup, &mut emulated);
    assert!(of_emulated == csv && flown == expected, "{of_emulated}\n{csv}");
    assert_eq!(flight.health.overruns, 0);
}
