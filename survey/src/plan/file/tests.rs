//! A plan's file is refused by every value that no plan can have.

use super::*;
use crate::io::output::tests::scratch;
use serde_json::{Value, json};

/// A plan of one strip of two photos, as JSON.
fn json() -> Value {
    json!({
        "version": 1, "dem": "dem.asc", "epsg": null, "origin_deg": [48.0, 11.0],
        "camera": { "cols": 100, "rows": 80, "fov_h_deg": 50.0, "fov_v_deg": 40.0, "offset_m_px": 0.0, "offset_n_px": 0.0,
                    "pixel_mm": 0.01, "distortion": [0.1, 0.0, 0.0, 0.0, 0.0] },
        "height_m": 300.0, "base_height_m": 100.0, "gsd_m": 2.8, "strip_heading_deg": 90.0, "speed_m_s": 30.0,
        "min_interval_s": 1.0, "overlap_wanted": { "forward": 0.6, "side": 0.3 },
        "overlap_min": { "forward": 0.6, "side": null }, "photo_count": 2, "base_min_m": 90.0, "interval_min_s": 3.0,
        "area": [[0.0, 0.0], [90.0, 0.0], [90.0, 50.0]],
        "strips": [{ "line": 0, "heading_deg": 90.0, "photos": [{ "x": 0.0, "y": 0.0, "z": 400.0 },
                     { "x": 90.0, "y": 0.0, "z": 400.0, "lat": 48.0, "lon": 11.0 }] }],
        "noise": { "image_px": 0.3, "position_m": 0.0, "attitude_deg": 0.01 }, "accuracy": null,
        "checks": { "clearance_min_m": 250.0, "smear_px": 0.1, "exposure_max_s": 0.01, "exposure_s": 0.001,
                    "length_m": 90.0, "flight_time_s": 3.0, "turn_radius_m": 120.0, "photos_beyond_dem": 0 },
        "constant_base": null, "combinations": [],
    })
}

pub fn plan() -> PlanFile {
    serde_json::from_value(json()).expect("a plan")
}

fn read(json: &Value, name: &str) -> Result<PlanFile, String> {
    let path = scratch(&format!("plan-file-{name}")).join("plan.json");
    std::fs::write(&path, json.to_string()).expect("written");
    PlanFile::read(&path).map_err(|error| error.to_string())
}

#[test]
fn a_plan_of_an_older_version_is_read() {
    let plan = read(&json(), "old").expect("read");
    assert_eq!((plan.flight_order.len(), plan.swath_min.side, plan.dem_sha256), (0, None, None));
}

#[test]
fn every_value_that_no_plan_has_is_refused_by_its_name() {
    for (pointer, value, says) in [
        ("/version", json!(2), "version 2"),
        ("/camera/cols", json!(0), "cols"),
        ("/camera/rows", json!(0), "rows"),
        ("/camera/fov_h_deg", json!(180.0), "fov_h_deg"),
        ("/camera/fov_v_deg", json!(-1.0), "fov_v_deg"),
        ("/camera/pixel_mm", json!(0.0), "pixel_mm"),
        ("/height_m", json!(-300.0), "height_m"),
        ("/gsd_m", json!(0.0), "gsd_m"),
        ("/speed_m_s", json!(0.0), "speed_m_s"),
        ("/min_interval_s", json!(-1.0), "min_interval_s"),
        ("/base_min_m", json!(0.0), "base_min_m"),
        ("/interval_min_s", json!(-3.0), "interval_min_s"),
        ("/noise/image_px", json!(0.0), "noise.image_px"),
        ("/noise/position_m", json!(-1.0), "noise.position_m"),
        ("/checks/turn_radius_m", json!(0.0), "checks.turn_radius_m"),
        ("/checks/length_m", json!(-1.0), "checks.length_m"),
        ("/overlap_wanted/side", json!(1.0), "overlap_wanted.side"),
        ("/origin_deg/0", json!(91.0), "origin_deg"),
        ("/photo_count", json!(3), "photo_count"),
        ("/strips/0/line", json!(9), "line"),
        ("/strips/0/photos", json!([]), "strips[0]"),
        ("/strips/0/photos/1/lat", json!(98.0), "latitude"),
        ("/area", json!([]), "area"),
    ] {
        let mut json = json();
        *json.pointer_mut(pointer).expect("a value") = value;
        let error = read(&json, "refused").expect_err(pointer);
        assert!(error.contains("plan.json") && error.contains(says), "{pointer}: {error}");
    }
}

/// A plan as it is written, with everything in it that a plan can have.
fn whole() -> Value {
    let mut json = json();
    json["epsg"] = json!(32633);
    json["overlap_min"]["side"] = json!(0.3);
    json["swath_min"] = json!({ "side": 0.2 });
    json["flight_order"] = json!([[0, 0], [0, 1]]);
    json["accuracy"] = json!({ "plan_m": 0.1, "height_m": 0.2, "simulated_plan_m": 0.1, "simulated_height_m": 0.2,
        "plan_max_m": 0.3, "height_max_m": 0.4, "cells": 9, "gaps": 1, "seed": u64::MAX });
    json["constant_base"] = json!({ "base_m": 80.0, "spacing_m": 60.0, "lines": 1, "photos": 1, "photos_saved": -1 });
    json["combinations"] = json!([{ "forward": 0.6, "side": 0.3, "lines": 1, "photos": 2, "interval_min_s": 3.0,
        "gaps": 0, "plan_m": 0.1, "height_m": 0.2, "ruled_out": null, "chosen": true }]);
    json["vertical"] =
        json!({ "datum": "ellipsoid", "epsg": 5773, "geoid": "egm96.gtx", "geoid_height_m": [46.1, 46.2] });
    let photo = &mut json["strips"][0]["photos"][0];
    (photo["lat"], photo["lon"]) = (json!(48.0), json!(11.0));
    serde_json::to_value(serde_json::from_value::<PlanFile>(json).expect("a plan")).expect("written")
}

/// The pointers of all numbers.
fn numbers_of(value: &Value, at: &str, found: &mut Vec<String>) {
    match value {
        Value::Object(entries) => {
            entries.iter().for_each(|(key, value)| numbers_of(value, &format!("{at}/{key}"), found))
        }
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(k, value)| numbers_of(value, &format!("{at}/{k}"), found));
        }
        Value::Number(_) => found.push(at.to_owned()),
        _ => {}
    }
}

/// No absurd value of any number is accepted, and what refuses it names it.
#[test]
fn every_number_of_a_plan_is_checked_by_its_name() {
    let plan = whole();
    read(&plan, "whole").expect("read");
    let mut pointers = Vec::new();
    numbers_of(&plan, "", &mut pointers);
    assert!(pointers.len() > 80, "{}", pointers.len());
    for pointer in pointers {
        let is_whole = !plan.pointer(&pointer).expect("a number").is_f64();
        let absurd = [json!(-1e30), json!(1e30), json!("NaN"), json!([]), json!(true)];
        for value in absurd.into_iter().chain(is_whole.then(|| json!(0.5))).chain(is_whole.then(|| json!(-1e9 as i64)))
        {
            let mut changed = plan.clone();
            *changed.pointer_mut(&pointer).expect("a value") = value.clone();
            let error = read(&changed, "absurd").expect_err(&format!("{pointer} {value}"));
            let key = pointer.split('/').rfind(|key| key.parse::<usize>().is_err()).expect("a key");
            assert!(error.contains(key) || value == json!([]), "{pointer} {value}: {error}");
        }
    }
    let mut changed = plan;
    changed["strips"][0]["photos"][1]["z"] = json!(-1e30);
    assert!(read(&changed, "indices").is_err_and(|error| error.contains("strips[0].photos[1].z is -1e")));
}

#[test]
fn the_order_of_flight_has_each_photo_once() {
    for (order, is_one) in [
        (json!([[0, 1], [0, 0]]), true),
        (json!([[0, 0]]), false),
        (json!([[0, 0], [0, 0]]), false),
        (json!([[0, 0], [1, 0]]), false),
    ] {
        let mut json = json();
        json["flight_order"] = order;
        assert_eq!(read(&json, "order").is_ok(), is_one, "{}", json["flight_order"]);
    }
}
