use super::*;

/// What a camera straight above the grid's origin at 100 m sees of grey ground of 100, ray by ray: 201 to the east and back.
fn seen(weather: &Weather, frame: u64, at_s: f64) -> Vec<f64> {
    let directions: Vec<[f64; 3]> = (-100..=100).map(|i| [f64::from(i) / 100.0, 0.0, -1.0]).collect();
    let mut seen = vec![100.0; directions.len()];
    weather.at(frame, at_s, 0.0).pass([0.0, 0.0, 100.0], &directions, &vec![100.0; directions.len()], &mut seen);
    seen
}

fn of(weather: scenario::Weather) -> Weather {
    Weather::new(1, &weather, &Land::default())
}

#[test]
fn clear_air_changes_nothing_and_haze_is_a_mixture() {
    assert_eq!(seen(&of(scenario::Weather::default()), 3, 9.0), vec![100.0; 201]);
    let hazy = of(scenario::Weather { haze: 0.3, airlight_dn: 180.0, ..scenario::Weather::default() });
    assert!(seen(&hazy, 0, 0.0).iter().all(|grey| (grey - 124.0).abs() < 1e-9));
}

/// A layer at 60 m, 40 m below the camera: a ray's place in it is 40 m times its slope.
#[test]
fn clouds_drift_and_pass_by_faster_than_the_ground() {
    let sky =
        scenario::Weather { cloud_fraction: 0.5, cloud_size_m: 15.0, cloud_wind_m_s: [4.0, 0.0], ..Default::default() };
    let clouds = of(sky);
    let first = seen(&clouds, 0, 0.0);
    assert!(first.contains(&100.0) && first.contains(&230.0), "{first:?}");
    // In a second 4 m, which are 10 rays in the layer; a frame's number does not matter.
    let later = seen(&clouds, 7, 1.0);
    assert!(first[..191].iter().zip(&later[10..]).all(|(one, other)| (one - other).abs() < 1e-6));
    assert_ne!(first, later);
    // Over higher ground the layer is higher; from below there is none.
    let mut below = [100.0];
    clouds.at(0, 0.0, 50.0).pass([0.0, 0.0, 100.0], &[[0.0, 0.0, -1.0]], &[50.0], &mut below);
    assert_eq!(below, [100.0]);
}

/// Water is other water in each frame, in the same places; land is as it was.
#[test]
fn waves_are_others_in_each_frame_and_stay_on_the_lakes() {
    use crate::world::procedural_as;
    let land = Land { water_fraction: 0.5, ..Land::default() };
    let weather = Weather::new(1, &scenario::Weather::default(), &land);
    let [east, north] = procedural_as(1, Land::default(), scenario::Changes::default()).bounds().centre();
    let looked = |frame: u64| {
        let directions: Vec<[f64; 3]> = (-500..=500).map(|i| [f64::from(i) / 100.0, 0.3, -1.0]).collect();
        let mut seen = vec![100.0; directions.len()];
        let along = vec![100.0; directions.len()];
        weather.at(frame, 0.0, 0.0).pass([east, north, 100.0], &directions, &along, &mut seen);
        seen
    };
    let [first, again, other] = [1, 1, 2].map(looked);
    assert_eq!(first, again);
    let wet = |seen: &[f64]| seen.iter().map(|grey| *grey != 100.0).collect::<Vec<_>>();
    assert_eq!(wet(&first), wet(&other));
    let water = wet(&first).iter().filter(|wet| **wet).count();
    assert!((250..750).contains(&water), "{water} of 1001");
    let alike = first.iter().zip(&other).filter(|(one, other)| one == other).count();
    assert_eq!(alike, 1001 - water);
}
