//! Every file against what stands in it, on plans over simulated ground.

mod coverage;
mod geojson;
mod kml;
mod mission;

use super::Outputs;
use super::vehicle::Vehicle;
use crate::camera_file::CameraFile;
use crate::crs::System;
use crate::dem::{Dem, Frame, Geoid};
use crate::plan::area::Area;
use crate::plan::combinations::Limits;
use crate::plan::course::Follow;
use crate::plan::file::Noise;
use crate::plan::intersect::Sigmas;
use crate::plan::lines::Overlaps;
use crate::plan::place::Place;
use crate::plan::terrain::Terrain;
use crate::plan::{ModelFile, Request};
use serde_json::Value;
use std::collections::BTreeMap;

/// A plan to be made: 500 m up with footprints of 720 m along and 1080 m across on the base plane, 60/30 %.
struct Scene {
    place: Place,
    /// Corner of lowest x and y of the area of 1200 x 600 m, working metres.
    corner: [f64; 2],
    heading_deg: f64,
    trigger_items: bool,
    vehicle: Vehicle,
    /// Whether only the half below the diagonal is the area.
    is_triangle: bool,
    height: fn(f64, f64) -> f64,
    follow: Option<Follow>,
    geoid: Option<Geoid>,
}

fn hills(x: f64, y: f64) -> f64 {
    100.0 + 60.0 * (x / 700.0).sin() * (y / 500.0).cos()
}

fn level(_: f64, _: f64) -> f64 {
    42.0
}

fn grid() -> Scene {
    Scene {
        place: Place::new(Frame::new(Some(System::Epsg(32633)), [500_000.0, 5_300_000.0]).expect("a grid"), None)
            .expect("a place"),
        corner: [500_000.0, 5_300_000.0],
        heading_deg: 90.0,
        trigger_items: false,
        vehicle: Vehicle::default(),
        is_triangle: false,
        height: hills,
        follow: None,
        geoid: None,
    }
}

fn local(origin_deg: Option<[f64; 2]>) -> Scene {
    Scene { place: Place::new(Frame::Local, origin_deg).expect("a place"), corner: [0.0, 0.0], ..grid() }
}

impl Scene {
    fn outputs(&self, look: impl FnOnce(&Outputs<'_>)) {
        let [x, y] = self.corner;
        let dem = Dem::from_fn((161, 141), [x - 3000.0, y - 3000.0], [50.0; 2], self.height);
        let terrain = Terrain::new(&dem);
        let corners = [[x, y], [x + 1200.0, y], [x + 1200.0, y + 600.0], [x, y + 600.0]];
        let corners = if self.is_triangle { &corners[..3] } else { &corners[..] };
        let half_tangent = [0.72_f64, 1.08];
        let sigmas = Sigmas { image: [2e-4, 2e-4], position_m: 0.015, attitude_rad: 1e-4 };
        let request = Request {
            area: Area::new(corners).expect("an area"),
            height_m: 500.0,
            half_tangent,
            tangent_per_px: [2.0 * 0.72 / 720.0, 2.0 * 1.08 / 1080.0],
            overlaps: Some(Overlaps { forward: 0.6, side: 0.3 }),
            heading_deg: Some(self.heading_deg),
            limits: Limits { speed_m_s: 35.0, min_interval_s: 0.038, accuracy_m: None },
            sigmas,
            exposure_s: 0.002,
            min_clearance_m: 50.0,
            seed: 1,
            tilt_deg: 0.0,
            follow: self.follow,
        };
        let planned = request.plan(&terrain, &|_, _| {}).expect("planned");
        let [fov_v, fov_h] = half_tangent.map(|tangent| 2.0 * tangent.atan().to_degrees());
        let camera = format!(
            "cols = 1080\nrows = 720\nfov_h_deg = {fov_h}\nfov_v_deg = {fov_v}\noffset_m_px = 0\noffset_n_px = 0\n"
        );
        let camera = CameraFile::from_toml_str(&camera, "camera.toml").expect("a camera");
        let noise = Noise { image_px: 0.1, position_m: 0.015, attitude_deg: 0.0057 };
        let dem = ModelFile { name: "folder/a<b&c.tif".to_owned(), path: String::new(), sha256: String::new() };
        let file = planned.file(&request, &self.place, &camera, noise, &dem).expect("a file");
        look(&Outputs {
            planned: &planned,
            file: &file,
            place: &self.place,
            trigger_items: self.trigger_items,
            vehicle: self.vehicle,
            geoid: self.geoid.as_ref(),
        });
    }
}

fn text(outputs: &Outputs<'_>, name: &str) -> String {
    let files: BTreeMap<&str, Vec<u8>> = outputs.files().expect("files").into_iter().collect();
    String::from_utf8(files[name].clone()).expect("UTF-8")
}

fn json(outputs: &Outputs<'_>, name: &str) -> Value {
    serde_json::from_str(&text(outputs, name)).expect("JSON")
}

fn number(value: &Value) -> f64 {
    value.as_f64().expect("a number")
}

#[test]
fn a_place_that_nobody_knows_leaves_two_files_out() {
    let names = |scene: Scene| {
        let mut names = Vec::new();
        scene.outputs(|outputs| names = outputs.files().expect("files").iter().map(|(name, _)| *name).collect());
        names.sort_unstable();
        names
    };
    assert_eq!(names(local(None)), ["coverage.tif", "plan.geojson", "plan.json"]);
    let all = ["coverage.tif", "plan.geojson", "plan.json", "plan.kml", "plan.plan"];
    assert_eq!(names(local(Some([48.0, 11.0]))), all);
}

#[test]
fn the_same_plan_gives_the_same_bytes() {
    let made = || {
        let mut files = Vec::new();
        grid().outputs(|outputs| files = outputs.files().expect("files"));
        files
    };
    assert_eq!(made(), made());
}

#[test]
fn what_an_earlier_plan_left_is_not_taken_for_this_ones() {
    let folder = std::env::temp_dir().join(format!("plumbline-planning-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("made");
    std::fs::write(folder.join("plan.kml"), "old").expect("written");
    std::fs::write(folder.join("other.kml"), "another's").expect("written");
    super::write(&folder, &[("plan.json", b"new".to_vec())]).expect("written");
    let left: Vec<bool> =
        ["plan.json", "plan.kml", "other.kml"].iter().map(|name| folder.join(name).exists()).collect();
    let _ = std::fs::remove_dir_all(&folder);
    assert_eq!(left, [true, false, true]);
}
