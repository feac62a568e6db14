use super::*;

/// Over no ground: the autopilot alone, around a rectangle in wind, for `seconds`.
fn flown(seed: u64, text: &str, seconds: u64) -> Track {
    let text =
        format!("flight.tilt_max_deg = 25\nflight.speed_m_s = 22\n[navigation]\nwind_m_s = 5\ngust_m_s = 1\n{text}");
    let mut scenario = Scenario::parse(&text, "a.toml", std::path::Path::new(""), None).expect("sound");
    scenario.run.seed = seed;
    let waypoints = vec![[-300.0, -250.0], [-300.0, 250.0], [300.0, 250.0], [300.0, -250.0]];
    let course = Course { waypoints, up_m: 320.0, base_up_m: 200.0 };
    let mut aloft = Aloft::new(&scenario, Mounting::default(), &course).expect("it navigates");
    aloft.state(1_000_000 * seconds);
    aloft.finish().1
}

/// The mean over seeds and time of a figure of the moments from `from_s` on.
fn mean_of(tracks: &[Track], from_s: f64, pick: impl Fn(&Moment) -> Option<f64>) -> f64 {
    let all: Vec<f64> = tracks
        .iter()
        .flat_map(|track| &track.moments)
        .filter(|moment| moment.at_s >= from_s)
        .filter_map(pick)
        .collect();
    all.iter().sum::<f64>() / all.len() as f64
}

/// With satellite navigation, whose noise is white, the filter knows how wrong it is. A flight has some ten independent errors of
/// two freedoms (they live for seconds): the mean of 12 flights is off by sqrt(2 / 240) = 9 %, three sigmas are 27 %. Errors of scale are
/// no states and count for the rest.
#[test]
fn with_satellites_the_filter_knows_how_wrong_it_is() {
    for grade in ["consumer", "tactical"] {
        let tracks: Vec<Track> = (1..=12).map(|seed| flown(seed, &format!("grade = \"{grade}\""), 60)).collect();
        let nees = mean_of(&tracks, 15.0, |moment| moment.nees) / 2.0;
        let rms_m = mean_of(&tracks, 15.0, |moment| Some(moment.error_m().powi(2))).sqrt();
        println!("{grade}: NEES {nees:.3} a degree of freedom, {rms_m:.2} m");
        assert!((0.7..1.35).contains(&nees), "{grade}: {nees}");
        assert!(rms_m < 1.5, "{grade}: {rms_m}");
    }
}

/// Without anything it drifts, the better sensor by less.
#[test]
fn without_satellites_it_drifts_by_its_grade() {
    let drift = |grade: &str| {
        let text = format!("grade = \"{grade}\"\ngnss_lost_s = 20");
        let tracks: Vec<Track> = (1..=6).map(|seed| flown(seed, &text, 120)).collect();
        let at_end = mean_of(&tracks, 119.0, |moment| Some(moment.error_m().powi(2))).sqrt();
        // Nobody sends fixes: the filter that gets none is the same.
        assert!(
            tracks.iter().flat_map(|track| &track.moments).all(|m| m.free_error_m().is_none_or(|e| e == m.error_m()))
        );
        println!("{grade}: {at_end:.1} m after 100 s");
        at_end
    };
    let (consumer, tactical) = (drift("consumer"), drift("tactical"));
    assert!(consumer > 50.0 && tactical < 0.5 * consumer, "{consumer} {tactical}");
}

/// A barometer that is off by 15 m and 4 % of 120 m has it fly 19 m too low, and say that it is right.
#[test]
fn a_wrong_barometer_is_believed() {
    let track = flown(1, "baro_bias_m = 15\nbaro_scale = 1.04\nbaro_drift_m = 0", 120);
    let tracks = [track];
    let truth_m = mean_of(&tracks, 100.0, |moment| Some(moment.truth_m[2]));
    let believed_m = mean_of(&tracks, 100.0, |moment| Some(moment.believed_m[2]));
    // It holds 120 m of its own: 1.04 h + 15.
    let expected_m = 200.0 + (120.0 - 15.0) / 1.04;
    assert!((truth_m - expected_m).abs() < 2.0 && (believed_m - 320.0).abs() < 2.0, "{truth_m} {believed_m}");
}

#[test]
fn the_same_seed_is_the_same_flight_in_whatever_order_it_is_asked_for() {
    let once = flown(3, "gnss_lost_s = 5", 10);
    assert_eq!(once, flown(3, "gnss_lost_s = 5", 10));
    assert_ne!(once.moments, flown(4, "gnss_lost_s = 5", 10).moments);
}
