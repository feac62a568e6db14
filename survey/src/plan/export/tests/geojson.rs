//! `plan.geojson` and the footprints in it.

use super::{Scene, grid, json, level, local, number};
use crate::plan::export::Outputs;
use serde_json::Value;

/// RFC 7946 knows longitude and latitude alone: a feature in local metres has no geometry.
fn geometry(feature: &Value) -> &Value {
    let local = &feature["properties"]["local_geometry"];
    assert!(feature["geometry"].is_null() != local.is_null(), "{feature}");
    if local.is_null() { &feature["geometry"] } else { local }
}

fn ring(feature: &Value) -> Vec<[f64; 2]> {
    let ring = geometry(feature)["coordinates"][0].as_array().expect("a ring");
    ring.iter().map(|at| [number(&at[0]), number(&at[1])]).collect()
}

#[test]
fn geojson_has_every_thing_with_its_rings_the_right_way_round() {
    // Strips due north have mirrored axes.
    for (heading_deg, place) in [(90.0, grid()), (0.0, grid()), (30.0, local(None)), (0.0, local(Some([48.0, 11.0])))] {
        Scene { heading_deg, ..place }.outputs(|outputs| {
            let file = outputs.file;
            let json = json(outputs, "plan.geojson");
            let features = json["features"].as_array().expect("features");
            let of = |kind: &str| features.iter().filter(|one| one["properties"]["kind"] == kind).collect::<Vec<_>>();
            assert_eq!((of("area").len(), of("strip").len()), (1, file.strips.len()));
            assert_eq!((of("photo").len(), of("footprint").len()), (file.photo_count, file.photo_count));
            for feature in of("area").into_iter().chain(of("footprint")) {
                let ring = ring(feature);
                assert_eq!((ring.len(), ring[0]), (5, ring[4]));
                let doubled: f64 = ring
                    .windows(2)
                    .map(|p| {
                        (p[0][0] - ring[0][0]) * (p[1][1] - ring[0][1])
                            - (p[1][0] - ring[0][0]) * (p[0][1] - ring[0][1])
                    })
                    .sum();
                assert!(doubled > 0.0, "{feature}");
            }
            for feature in of("photo") {
                let at = &feature["properties"];
                let strip = &file.strips[at["strip"].as_u64().expect("a number") as usize];
                let photo = strip.photos[at["number"].as_u64().expect("a number") as usize];
                let [x, y] = photo.lon.zip(photo.lat).map_or([photo.x, photo.y], |(lon, lat)| [lon, lat]);
                let place = &geometry(feature)["coordinates"];
                assert_eq!(feature["geometry"].is_null(), photo.lat.is_none(), "{feature}");
                let near = if photo.lat.is_some() { 0.6e-7 } else { 0.6e-3 };
                assert!((number(&place[0]) - x).abs() < near && (number(&place[1]) - y).abs() < near, "{feature}");
                assert!((number(&place[2]) - photo.z).abs() < 0.6e-3);
            }
            assert_eq!(json["note"].as_str().expect("a note").contains("local"), !outputs.place.is_known());
        });
    }
}

/// Level ground at the base plane: 720 x 1080 m. Over hills each corner lies on its ray and on the ground.
#[test]
fn footprints_lie_on_the_ground() {
    let corners = |outputs: &Outputs<'_>| {
        let json = json(outputs, "plan.geojson");
        let features = json["features"].as_array().expect("features");
        let is = |one: &&Value| one["properties"]["kind"] == "footprint" && one["properties"]["strip"] == 0;
        features.iter().filter(is).map(ring).collect::<Vec<_>>()
    };
    Scene { height: level, ..local(None) }.outputs(|outputs| {
        for (ring, photo) in corners(outputs).iter().zip(&outputs.file.strips[0].photos) {
            for [x, y] in ring {
                assert!(((x - photo.x).abs() - 360.0).abs() < 2e-3 && ((y - photo.y).abs() - 540.0).abs() < 2e-3);
            }
        }
    });
    local(None).outputs(|outputs| {
        for (ring, photo) in corners(outputs).iter().zip(&outputs.file.strips[0].photos) {
            for [x, y] in ring {
                let depth_m = (x - photo.x).abs() / 0.72;
                assert!(((y - photo.y).abs() - 1.08 * depth_m).abs() < 5e-3, "not on the ray");
                let ground_m = outputs.planned.layout.terrain.dem().height(*x, *y).expect("known");
                assert!((photo.z - depth_m - ground_m).abs() < 0.01, "{ground_m}");
            }
        }
    });
}
