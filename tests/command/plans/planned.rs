//! A plan as its file has it.

use super::terrain::Terrain;
use crate::command::{Run, plumbline};
use serde_json::Value;
use std::path::{Path, PathBuf};

/// A folder of its own for one test, empty.
pub fn scratch(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("plumbline-plan-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// f 50 mm and 108 x 72 mm along x across, with pixels of 0.1 mm.
pub fn camera(folder: &Path) -> PathBuf {
    let fov = |half_mm: f64| 2.0 * (half_mm / 50.0).atan().to_degrees();
    let text = format!(
        "cols = 720\nrows = 1080\nfov_h_deg = {}\nfov_v_deg = {}\noffset_m_px = 0.0\noffset_n_px = 0.0\npixel_mm = 0.1\n",
        fov(36.0),
        fov(54.0)
    );
    let path = folder.join("camera.toml");
    std::fs::write(&path, text).expect("written");
    path
}

/// Half the field of view along and across, as tangents.
pub const HALF: [f64; 2] = [54.0 / 50.0, 36.0 / 50.0];

pub struct Plan {
    pub json: Value,
    /// By line: places of the exposures of its strips in metres.
    pub strips: Vec<(usize, Vec<[f64; 2]>)>,
    pub altitude: f64,
    pub height: f64,
}

/// Plans and reads the file that was written.
pub fn plan(folder: &Path, terrain: &Terrain, options: &str) -> Plan {
    let (dem, camera) = (terrain.file.display(), camera(folder));
    let arguments = format!(
        "plan --dem {dem} --camera {} {options} --json --out {}",
        camera.display(),
        folder.join("out").display()
    );
    let run = Run::from(plumbline(folder, &arguments).output().expect("it runs"));
    assert!(!run.stderr.contains("panicked"), "{run:?}");
    let told = run.json();
    let text = std::fs::read_to_string(folder.join("out/plan.json")).expect("plan.json");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    assert_eq!(json, told);
    let number = |value: &Value| value.as_f64().expect("a number");
    let strips: Vec<(usize, Vec<[f64; 2]>)> = json["strips"]
        .as_array()
        .expect("strips")
        .iter()
        .map(|strip| {
            let photos = strip["photos"].as_array().expect("photos").iter();
            let places = photos.map(|photo| terrain.metres([number(&photo["x"]), number(&photo["y"])])).collect();
            (strip["line"].as_u64().expect("a line") as usize, places)
        })
        .collect();
    let altitude = number(&json["strips"][0]["photos"][0]["z"]);
    let height = number(&json["height_m"]);
    assert!((altitude - height - number(&json["base_height_m"])).abs() < 1e-9);
    assert_eq!(json["photo_count"].as_u64(), Some(strips.iter().map(|(_, photos)| photos.len() as u64).sum()));
    Plan { json, strips, altitude, height }
}

impl Plan {
    /// Unit vectors along and across, by the heading.
    pub fn axes(&self) -> [[f64; 2]; 2] {
        let heading = self.json["strip_heading_deg"].as_f64().expect("a heading").to_radians();
        [[heading.sin(), heading.cos()], [-heading.cos(), heading.sin()]]
    }
}
