//! `plan.plan` against places that another library computes, and the order of flight.

use super::{Scene, grid, json, number, text};
use crate::dem::Geoid;
use crate::io::output::tests::scratch;
use crate::plan::PlanFile;
use crate::plan::file::StripFile;
use serde_json::Value;

/// Photos of a plan as they are flown: latitude, longitude.
fn flown(file: &PlanFile) -> Vec<[f64; 2]> {
    let of = |strip: &StripFile| {
        let mut photos: Vec<[f64; 2]> =
            strip.photos.iter().map(|photo| [photo.lat.expect("known"), photo.lon.expect("known")]).collect();
        if strip.heading_deg >= 180.0 {
            photos.reverse();
        }
        photos
    };
    file.strips.iter().flat_map(of).collect()
}

#[test]
fn the_mission_leads_in_a_turn_before_the_first_photo() {
    grid().outputs(|outputs| {
        let plan = json(outputs, "plan.plan");
        let items = plan["mission"]["items"].as_array().expect("items");
        assert_eq!((items.len(), outputs.mission_items()), (1 + 2 * outputs.file.strips.len(), items.len()));
        assert_eq!((&items[0]["command"], &items[0]["params"][1]), (&Value::from(178), &Value::from(35.0)));
        // pyproj, EPSG:32633 to 4326, of x = 500000 - 0.4 * 720 - 35^2 / (9.81 tan 30 deg), y = 5300000.
        let first = &items[1]["params"];
        assert!((number(&first[4]) - 47.853_341_747_7).abs() < 1e-7, "{first}");
        assert!((number(&first[5]) - 14.993_258_815_1).abs() < 1e-7, "{first}");
        // Every strip begins and ends 216.3 m (a turn's radius) outside its photos, whichever way it is flown. pyproj's
        // geodesic over 0.001 degrees of longitude: 74,844 m a degree; the grid's metre is 0.4 mm short.
        for (pair, strip) in items[1..].chunks(2).zip(&outputs.file.strips) {
            let lon = |place: usize| number(&pair[place]["params"][5]);
            let photos =
                [strip.photos.first(), strip.photos.last()].map(|photo| photo.and_then(|p| p.lon).expect("known"));
            let [from, to] = if strip.heading_deg == 90.0 { photos } else { [photos[1], photos[0]] };
            let out = if strip.heading_deg == 90.0 { 74_844.0 } else { -74_844.0 };
            let led_m = [(from - lon(0)) * out, (lon(1) - to) * out];
            assert!(led_m.iter().all(|led_m| (led_m - 216.3).abs() < 0.5), "{led_m:?}");
        }
        for (index, item) in items.iter().enumerate() {
            assert_eq!(item["doJumpId"], Value::from(index + 1));
        }
        for item in &items[1..] {
            assert_eq!((&item["frame"], &item["AltitudeMode"]), (&Value::from(0), &Value::from(2)));
            assert!((number(&item["params"][6]) - outputs.file.strips[0].photos[0].z).abs() <= 0.005);
        }
    });
}

#[test]
fn triggers_follow_waypoints_at_the_photos_in_the_order_of_flight() {
    Scene { trigger_items: true, ..grid() }.outputs(|outputs| {
        let plan = json(outputs, "plan.plan");
        let items = plan["mission"]["items"].as_array().expect("items");
        assert_eq!(items.len(), outputs.mission_items());
        let triggered: Vec<[f64; 2]> = items
            .windows(2)
            .filter(|pair| pair[1]["command"] == 203)
            .map(|pair| [number(&pair[0]["params"][4]), number(&pair[0]["params"][5])])
            .collect();
        let photos = flown(outputs.file);
        assert_eq!((triggered.len(), photos.len()), (outputs.file.photo_count, outputs.file.photo_count));
        for (ours, photo) in triggered.iter().zip(&photos) {
            assert!((0..2).all(|k| (ours[k] - photo[k]).abs() <= 0.6e-7), "{ours:?} {photo:?}");
        }
    });
}

/// From heights above the ellipsoid the geoid's are subtracted, in the mission and in KML alone.
#[test]
fn altitudes_are_above_the_sea_where_a_geoid_is_given() {
    // 40 m at the equator, a metre more each degree north, GTX in steps of a degree.
    let mut bytes: Vec<u8> = [0.0_f64, 0.0, 1.0, 1.0].iter().flat_map(|number| number.to_be_bytes()).collect();
    [80_i32, 40].iter().for_each(|count| bytes.extend(count.to_be_bytes()));
    (0..80 * 40).for_each(|index| bytes.extend((40.0 + (index / 40) as f32).to_be_bytes()));
    let path = scratch("mission-geoid").join("geoid.gtx");
    std::fs::write(&path, bytes).expect("written");
    let geoid = || Geoid::over(&path, [14.9, 47.7, 15.2, 48.0]).expect("a geoid");
    let plain = |scene: Scene| {
        let mut found = (Value::Null, String::new(), 0.0);
        scene.outputs(|outputs| {
            found = (json(outputs, "plan.plan"), text(outputs, "plan.kml"), outputs.file.strips[0].photos[0].z);
        });
        found
    };
    let (mission, kml, z) = plain(grid());
    let (above_sea, sea_kml, same_z) = plain(Scene { geoid: Some(geoid()), ..grid() });
    assert_eq!(z, same_z);
    let items = |plan: &Value| plan["mission"]["items"].as_array().expect("items").clone();
    for (item, sea) in items(&mission).iter().zip(items(&above_sea)).skip(1) {
        let (altitude, lat) = (number(&item["params"][6]), number(&item["params"][4]));
        for found in [&sea["params"][6], &sea["Altitude"]] {
            assert!((number(found) - (altitude - 40.0 - lat)).abs() < 0.011, "{item} {sea}");
        }
    }
    let ground = |plan: &Value| number(&plan["mission"]["plannedHomePosition"][2]);
    assert!((ground(&mission) - ground(&above_sea) - 87.85).abs() < 0.1, "{}", ground(&above_sea));
    assert!(kml.contains(&format!(",{z:.2}")) && !sea_kml.contains(&format!(",{z:.2}")), "{z}");
    assert!(sea_kml.contains("above mean sea level"));
}
