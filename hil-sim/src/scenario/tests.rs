use super::{BUILT_IN, Camera, FollowUpMode, Frame, Ground, Light, Scenario, WARM_UP_US};
use plumbline_survey::error::InputError;
use std::path::{Path, PathBuf};

fn text_of(name: &str) -> &str {
    BUILT_IN.iter().find(|(built_in, _)| *built_in == name).expect("it is built in").1
}

fn parse(text: &str) -> Result<Scenario, InputError> {
    Scenario::parse(text, "a.toml", Path::new("folder"), Some(Path::new("/data")))
}

#[test]
fn the_named_flights_are_sound() {
    for (name, text) in BUILT_IN {
        let scenario = parse(text).unwrap_or_else(|error| panic!("{name}: {error}"));
        assert_eq!(scenario.run.name, name);
    }
}

#[test]
fn the_default_file_says_what_the_defaults_are() {
    let default = Scenario::default();
    let named = || Scenario { file: "a.toml".into(), ..default.clone() };
    assert_eq!(parse(""), Ok(named()));
    assert_eq!(parse(BUILT_IN[0].1), Ok(named()));
    // The scene of the reference measurements.
    let frame = Frame::default();
    assert_eq!((default.camera.clone(), frame.cols, frame.fov_h_deg), (Camera::Keys(frame), 512, 60.0));
    assert_eq!((default.run.flight.height_m, default.vehicle.flight.tilt_max_deg), ([100.0, 150.0], 10.0));
    assert_eq!((default.vehicle.resolution_m, default.run.frames, default.world.noise_dn), (5.0, 300, 3.0));
    assert_eq!(default.vehicle.attitude.white_deg, 0.1);
    assert_eq!((default.vehicle.follow_up.mode, default.world.follow_up.servo_lag_s), (FollowUpMode::Followed, 0.0));
}

/// k1 of the barrel: the frame's corner, at r² = 2 tan² 30°, moves inwards by 5 %.
#[test]
fn the_barrel_draws_the_corner_in_by_five_percent() {
    let barrel = parse(text_of("barrel")).expect("the file is sound");
    let Camera::Keys(frame) = barrel.camera else { panic!("its own camera") };
    let (k_h, k_v) = frame.file().tangent_per_px();
    let r2 = (256.0 * k_h).powi(2) + (256.0 * k_v).powi(2);
    let k1 = frame.distortion.expect("a lens with distortion").k1;
    assert!((1.0 + k1 * r2 - 0.95).abs() < 1e-9);
}

#[test]
fn paths_start_at_the_file_or_at_the_data() {
    let text = r#"
        camera_file = "c.toml"
        ground = { ortho = "data:images/o.tif", dem = "/abs/d.tif" }
        replay = { att = "data:a.csv" }"#;
    let scenario = parse(text).expect("sound");
    assert_eq!(scenario.camera, Camera::File("folder/c.toml".into()));
    let ortho = PathBuf::from("/data/images/o.tif");
    assert_eq!(scenario.world.ground, Ground::Ortho { ortho, dem: Some("/abs/d.tif".into()), reference: None });
    let replay = scenario.run.replay.expect("given");
    assert_eq!((replay.att, replay.start_s, replay.time_scale), (PathBuf::from("/data/a.csv"), None, 1.0));
    let error = Scenario::parse(text, "a.toml", Path::new(""), None).expect_err("no data folder");
    assert_eq!(
        error.to_string(),
        "a.toml: ground.ortho = \"data:images/o.tif\" needs the folder of real data, which PLUMBLINE_DATA does not name"
    );
}

/// What a slip of the pen gets: one line that names the file, the key and the value.
#[test]
fn what_is_wrong_is_named() {
    for (text, words) in [
        ("frames = 0", ["a.toml: frames = 0 is not between 1 and 1000000"].as_slice()),
        ("\n[flight]\ntilt_deg = 3", &["a.toml, line 3", "`tilt_deg = 3`", "flight.tilt_deg is no key of a scenario"]),
        ("frames = \"many\"", &["a.toml, line 1", "frames = \"many\"", "invalid type"]),
        ("frames = -3", &["line 1", "frames = -3", "invalid value"]),
        ("flihgt = 3", &["a.toml, line 1 (`flihgt = 3`): flihgt is no key of a scenario"]),
        (
            "[attitude]\nrate_hz = 100\nrate = 3",
            &["a.toml, line 3 (`rate = 3`): attitude.rate is no key of a scenario"],
        ),
        ("\n[mount]\nboresight_deg = [1, 2, 3]", &["line 3", "[mount.boresight] has phi_deg"]),
        ("mount = { true_boresight_deg = [1, 2, 3] }", &["line 1", "[mount.true_boresight] has phi_deg"]),
        ("[mount.boresight]\nphi_deg = 1", &["missing field `omega_deg`"]),
        ("[mount]\nboresight = { phi_deg = 0, omega_deg = 11, kappa_deg = 0 }", &["mount.boresight.omega_deg = 11 is"]),
        ("frames 3", &["a.toml, line 1 (`frames 3`)"]),
        ("noise_dn = nan", &["noise_dn = NaN is not between 0 and 255"]),
        ("[attitude]\nwhite_deg = -0.1", &["attitude.white_deg = -0.1 is not between"]),
        ("[attitude]\nheading_drift_deg = inf", &["attitude.heading_drift_deg = inf is not between"]),
        ("[camera.distortion]\nk2 = 99.0", &["camera.distortion.k2 = 99 is not between"]),
        ("[flight]\nheight_m = [150.0, 100.0]", &["flight.height_m = [150, 100] has the higher value first"]),
        ("[shutter]\nedges = \"two\"", &["line 2", "unknown variant `two`"]),
        ("[shutter]\nlost_edge_percent = 101", &["shutter.lost_edge_percent = 101 is not between 0 and 100"]),
        ("[shutter]\nedge_jitter_us = nan", &["shutter.edge_jitter_us = NaN is not between"]),
        ("[shutter]\nclose_delay_us = 60", &["shutter.arrival_latency_us = 50", "shutter.close_delay_us = 60"]),
        ("[shutter]\narrival_jitter_us = 20", &["shutter.arrival_latency_us = 50", "before its shutter closed"]),
        ("[timer]\ndrift_ppm = 501", &["timer.drift_ppm = 501 is not between -500 and 500"]),
        ("[timer]\nrate_walk_ppm = -1", &["timer.rate_walk_ppm = -1 is not between"]),
        ("[timer]\npps_lost_s = [5, 3]", &["timer.pps_lost_s = [5, 3] has the later second first"]),
        ("[timer]\npps_lost_s = [-5, 3]", &["timer.pps_lost_s = -5 is not between"]),
        ("[attitude_faults]\nstuck_s = [5, 3]", &["attitude_faults.stuck_s = [5, 3] has the later second first"]),
        ("[attitude_faults]\ngap_s = [0, nan]", &["attitude_faults.gap_s = NaN is not between 0 and"]),
        ("[attitude_faults]\nlost_s = [0, 1]", &["line 2", "unknown field `lost_s`"]),
        ("exposure_us = 500001", &["exposure_us = 500001 is not between 1 and 500000"]),
        ("frame_interval_ms = 10\nexposure_us = 5000", &["exposure_us = 5000", "frame_interval_ms = 10"]),
        ("frame_interval_ms = 20\nrolling_shutter_ms = 20.0", &["rolling_shutter_ms = 20", "frame_interval_ms = 20"]),
        ("rolling_shutter_ms = -1.0", &["rolling_shutter_ms = -1 is not between 0 and 1000"]),
        ("exposure_samples = 0", &["exposure_samples = 0 is not between 1 and 1000"]),
        ("[camera]\nfov_v_deg = 45.0", &["follow_up.mode = \"followed\"", "camera.fov_v_deg = 45"]),
        ("[follow_up]\nmode = \"loose\"", &["line 2", "mode = \"loose\"", "unknown variant `loose`"]),
        ("[ground]\nkind = \"flat\"", &["line 2", "unknown variant `flat`"]),
        ("[ground]\ndem = \"d.tif\"", &["ground needs either kind"]),
        ("[ground]\nkind = \"procedural\"\northo = \"o.tif\"", &["takes no ortho"]),
        ("camera_file = \"c.toml\"\n[camera]\ncols = 5", &["both [camera] and camera_file"]),
        ("[replay]\nstart_s = 3", &["a.toml", "missing field `att`"]),
        ("[replay]\natt = \"a.csv\"\ntime_scale = 0.0", &["replay.time_scale = 0 is not between"]),
    ] {
        assert_named(text, words);
    }
}

/// A text is refused by one line that has all these words.
fn assert_named(text: &str, words: &[&str]) {
    let error = parse(text).expect_err(text).to_string();
    assert!(!error.contains('\n'), "{error}");
    for word in words {
        assert!(error.contains(word), "{text:?} gives {error:?} without {word:?}");
    }
}

/// What ground and weather cannot be.
#[test]
fn ground_that_cannot_be_flown_over_is_named() {
    for (text, words) in [
        ("[land]\nparcel_m = 40.0\nstripe_m = 40.0", ["land.parcel_m and land.stripe_m are both given"].as_slice()),
        ("[land]\nwater_fraction = 1.5", &["land.water_fraction = 1.5 is not between 0 and 1"]),
        ("[changes]\nsun_elevation_deg = 0.0", &["changes.sun_elevation_deg = 0 is not between 5 and 90"]),
        ("[changes.season]\nsnow = [1.0, 0.0]", &["line 2", "unknown field `snow`"]),
        ("[weather]\nhaze = -0.1", &["weather.haze = -0.1 is not between 0 and 1"]),
        ("[ground]\northo = \"o.tif\"\n[changes]\nflooded_fraction = 0.5", &["[changes] is of procedural ground"]),
        ("[ground]\northo = \"o.tif\"\n[reference]\nother_seed = 5", &["reference.other_seed is of procedural ground"]),
    ] {
        assert_named(text, words);
    }
}

/// What makes no sense in a flight that fixes keep.
#[test]
fn what_a_navigation_cannot_be_flown_with_is_named() {
    for (text, words) in [
        (
            "[follow_up]\nmode = \"fixed\"\nservo_commanded = true",
            ["follow_up.servo_commanded = true needs a servo"].as_slice(),
        ),
        ("[navigation]\nspeed = 3", &["line 2", "unknown field `speed`"]),
        ("[navigation]\nwaypoints = [[0, 0]]", &["navigation.waypoints has 1 points"]),
        ("[navigation]\nwaypoints = [[0, 0], [0, 0]]", &["navigation.waypoints has [0, 0] twice"]),
        ("[navigation]\nbank_max_deg = 12", &["navigation.bank_max_deg = 12 is more than flight.tilt_max_deg = 10"]),
        ("flight.tilt_max_deg = 25\n[navigation]\nwind_m_s = 30", &["flight.speed_m_s = 35 is too slow"]),
        ("flight.tilt_max_deg = 25\nframes = 100000\n[navigation]", &["longer than the 2 hours"]),
        (
            "flight.tilt_max_deg = 25\nautopilot_faults.gnss_s = [1, 2]\n[navigation]",
            &["knows_no_place make no sense with [navigation]"],
        ),
        (
            "flight.tilt_max_deg = 25\n[navigation]\n[[fault]]\nunit = \"clock\"\ntype = \"reboot\"\nto_s = 5",
            &["clock.reboot@0..5 makes no sense with [navigation]"],
        ),
    ] {
        assert_named(text, words);
    }
}

/// Evenly over the exposure about its middle, later from row to row, the middle row's middle being the stamp.
#[test]
fn instants_of_an_exposure_and_of_its_rows() {
    let offsets = |scenario: &Scenario, row: usize| {
        scenario.sample_offsets_us(scenario.vehicle.exposure_us, row, 512).collect::<Vec<_>>()
    };
    let mut scenario = Scenario::default();
    assert_eq!(offsets(&scenario, 0), [0.0]);
    assert_eq!(offsets(&scenario, 511), [0.0]);
    scenario.world.exposure_samples = 4;
    assert_eq!(offsets(&scenario, 100), [-750.0, -250.0, 250.0, 750.0]);
    (scenario.world.exposure_samples, scenario.vehicle.rolling_shutter_ms) = (1, 20.0);
    assert_eq!((offsets(&scenario, 0), offsets(&scenario, 511)), (vec![-10_000.0], vec![10_000.0]));
    assert!((offsets(&scenario, 255)[0] + offsets(&scenario, 256)[0]).abs() < 1e-9);
    assert_eq!(scenario.sample_offsets_us(2000, 0, 1).collect::<Vec<_>>(), [0.0]);
}

/// A data sheet's field of view is rounded; one that is meant otherwise is refused with the one that pixels need.
#[test]
fn pixels_are_square_as_far_as_a_data_sheet_says() {
    let camera =
        |fov_v: &str| parse(&format!("[camera]\ncols = 640\nrows = 480\nfov_h_deg = 60.0\nfov_v_deg = {fov_v}\n"));
    assert!(camera("46.83").is_ok(), "{:?}", camera("46.83"));
    let refused = camera("50.0").expect_err("not square").to_string();
    assert!(refused.contains("camera.fov_v_deg = 46.8264 would be"), "{refused}");
}

#[test]
fn exposures_and_light_that_cannot_be_are_named() {
    for (text, words) in [
        (
            "exposure_us = 9000\n[auto_exposure]\nis_on = true",
            ["exposure_us = 9000", "auto_exposure.longest_us = 8000"],
        ),
        (
            "frame_interval_ms = 10\n[auto_exposure]\nis_on = true",
            ["auto_exposure.longest_us = 8000", "frame_interval"],
        ),
        ("[auto_exposure]\nleast_us = 0", ["auto_exposure.least_us = 0", "between 4 and 500000"]),
        ("[light]\nstops = 11.0", ["light.stops = 11", "between -10 and 10"]),
        ("[light]\nstop = 1.0", ["light.stop", "is no key"]),
    ] {
        let error = parse(text).expect_err(text).to_string();
        for word in words {
            assert!(error.contains(word), "{text:?} gives {error:?} without {word:?}");
        }
    }
}

#[test]
fn light_grows_by_stops() {
    let mut scenario = Scenario::of_frames(240);
    let gain = |scenario: &Scenario, since_s: u64| scenario.gain(2000, WARM_UP_US + 1_000_000 * since_s);
    assert_eq!(gain(&scenario, 10), 1.0);
    assert_eq!(scenario.gain(4000, WARM_UP_US), 2.0);
    scenario.world.light = Light { stops: 1.0, from_stops: -3.0, to_stops: 0.0, over_s: None };
    assert_eq!([0, 20, 40, 60, 90].map(|at| gain(&scenario, at)), [0.25, 0.5, 1.0, 2.0, 2.0]);
    scenario.world.light.over_s = Some(6.0);
    assert_eq!([0, 2, 6].map(|at| gain(&scenario, at)), [0.25, 0.5, 2.0]);
}
