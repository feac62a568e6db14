use super::{SYNTHETIC, Setup, radiometry_of};
use crate::scenario::Run;
use crate::scenario::footprint::half_tangents;
use crate::scenario::{BUILT_IN, Scenario, WARM_UP_US};
use crate::world::reference::Radiometry;
use plumbline_survey::io::data::shared_data;
use std::path::Path;

fn parse(text: &str) -> Scenario {
    Scenario::parse(text, "a.toml", Path::new(""), Some(Path::new("/data"))).expect("sound")
}

fn built_in(name: &str) -> &str {
    BUILT_IN.iter().find(|(built_in, _)| *built_in == name).expect("it is built in").1
}

/// Over procedural ground the reference has synthetic differences; over an orthophoto only those that the scenario asks for.
#[test]
fn nothing_is_added_to_a_picture_of_the_world_but_what_is_asked_for() {
    let of = |text: &str| radiometry_of(&parse(text));
    let (made_up, none) = (Radiometry { seed: 1, ..SYNTHETIC }, Radiometry { seed: 1, ..Radiometry::SAME });
    assert_eq!(of(""), made_up);
    assert_eq!(of("[ground]\northo = \"o.tif\""), none);
    assert_eq!(of("[ground]\northo = \"o.tif\"\nreference = \"other.tif\""), none);
    let changed = of("[ground]\northo = \"o.tif\"\n[reference]\nchanged_fraction = 0.3");
    assert_eq!(changed, Radiometry { changed_fraction: 0.3, ..none });
    for name in ["default", "naip", "vienna"] {
        assert_eq!(of(built_in(name)), made_up, "{name}");
    }
}

/// 70 s of the log, in which it leans by 18.9 degrees: its frames stay on the picture, a cone about their corners does not.
#[test]
fn vienna_flies_longer_than_its_calm_minute() {
    let Some(data) = shared_data() else {
        assert!(std::env::var_os("PLUMBLINE_REQUIRE_DATA").is_none(), "no folder of real data");
        println!("skipped: no folder of real data (set PLUMBLINE_DATA)");
        return;
    };
    let scenario = Scenario::parse(built_in("vienna"), "vienna", Path::new(""), Some(&data)).expect("sound");
    let setup =
        Setup::prepare(Scenario { run: Run { frames: 300, ..scenario.run }, ..scenario }).expect("it can be flown");
    let bounds = setup.ground.bounds();
    let [across, along] = half_tangents(&setup.payload.camera);
    for frame in 0..300 {
        let state = setup.motion.state(WARM_UP_US + frame * setup.scenario.run.frame_interval_us());
        let axes = setup.station(&state).axes();
        for (right, forward) in [(across, along), (across, -along), (-across, along), (-across, -along)] {
            let ray = std::array::from_fn(|i| axes.down[i] + right * axes.right[i] + forward * axes.forward[i]);
            let hit = setup.ground.intersect([state.east_m, state.north_m, state.up_m], ray).expect("ground");
            assert!(bounds.contains(hit[0], hit[1]), "frame {frame}: {hit:?}");
        }
    }
}
