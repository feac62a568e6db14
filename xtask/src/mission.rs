//! Missions for QGroundControl, read by other authors' programs (`tests/plan/qgc_plan.py`), and told to them in flight
//! (`tests/watched/ground_station.py`).

use super::process::run;
use super::steps::Outcome;
use super::{Failure, places, python};
use std::fs;
use std::path::Path;
use std::process::Command;

/// What the script imports.
const MODULES: [python::Module; 2] = [("jsonschema", "jsonschema==4.26.0"), ("pymavlink", "pymavlink==2.4.49")];

/// Plans a small area for every vehicle and autopilot, without and with a trigger for each photo, at one height and following the ground,
/// without and with a take-off, and has the missions read.
pub fn check() -> Outcome {
    python::with(&MODULES).map_or_else(Outcome::Skipped, |python| planned_and_read(&python).into())
}

fn planned_and_read(python: &Path) -> Result<(), Failure> {
    let folder = places::scratch().join("mission");
    let failed = |error: std::io::Error| format!("{}: {error}", folder.display());
    fs::create_dir_all(&folder).map_err(failed)?;
    let camera = "cols = 96\nrows = 96\nfov_h_deg = 60.0\nfov_v_deg = 60.0\noffset_m_px = 0.0\noffset_n_px = 0.0\n";
    fs::write(folder.join("camera.toml"), camera).map_err(failed)?;
    // A slope of one in ten, so that heights differ along the strips.
    let row = |_| (0..141).map(|col| format!("{:.1}", 2.5 * f64::from(col))).collect::<Vec<_>>().join(" ");
    let grid = (0..141).map(row).collect::<Vec<_>>().join("\n");
    let head = "ncols 141\nnrows 141\nxllcenter -1500\nyllcenter -1500\ncellsize 25\n";
    fs::write(folder.join("dem.asc"), format!("{head}{grid}\n")).map_err(failed)?;
    for (out, extra) in missions() {
        let mut plan = Command::new(places::tested("plumbline"));
        plan.args(["plan", "--dem", "dem.asc", "--area", "0,0,400,300", "--camera", "camera.toml"]);
        plan.args(["--height-m", "300", "--overlap", "60/30", "--origin", "48,11", "--out", &out]).args(extra);
        run(plan.current_dir(&folder))?;
        run(Command::new(python).arg(places::root().join("tests/plan/qgc_plan.py")).arg(folder.join(&out)))?;
    }
    // And what a ground station is told that watches such a flight.
    let script = places::root().join("tests/watched/ground_station.py");
    run(Command::new(python).arg(script).arg(places::tested("plumbline")).arg(&folder))
}

/// A folder for each mission, and its options.
fn missions() -> Vec<(String, Vec<&'static str>)> {
    let mut missions = vec![("line".to_owned(), Vec::new()), ("triggers".to_owned(), vec!["--trigger-items"])];
    for vehicle in ["fixed-wing", "vtol", "multirotor"] {
        for autopilot in ["ardupilot", "px4"] {
            let of = ["--vehicle", vehicle, "--autopilot", autopilot];
            let follow = ["--follow-terrain", "10", "--trigger-items"];
            missions.push((format!("{vehicle}-{autopilot}"), [&of[..], &["--takeoff-and-return"]].concat()));
            missions.push((
                format!("{vehicle}-{autopilot}-follow"),
                [&of[..], &follow, &["--takeoff-and-return"]].concat(),
            ));
        }
    }
    missions
}
