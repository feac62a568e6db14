//! Every file against what stands in it, on plans over made-up ground.

use super::Outputs;
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::dem::{Dem, Frame};
use plumbline_survey::plan::area::Area;
use plumbline_survey::plan::combinations::Limits;
use plumbline_survey::plan::file::Noise;
use plumbline_survey::plan::intersect::Sigmas;
use plumbline_survey::plan::lines::Overlaps;
use plumbline_survey::plan::place::Place;
use plumbline_survey::plan::relief::Relief;
use plumbline_survey::plan::{PlanFile, Request};
use plumbline_survey::raster::Raster;
use serde_json::Value;
use std::collections::BTreeMap;

/// A plan to be made: 500 m up with footprints of 720 m along and 1080 m across on the base plane, 60/30 %.
struct Scene {
    place: Place,
    /// Corner of lowest x and y of the area of 1200 x 600 m, working metres.
    corner: [f64; 2],
    heading_deg: f64,
    trigger_items: bool,
    /// Whether only the half below the diagonal is the area.
    is_triangle: bool,
    height: fn(f64, f64) -> f64,
}

fn hills(x: f64, y: f64) -> f64 {
    100.0 + 60.0 * (x / 700.0).sin() * (y / 500.0).cos()
}

fn level(_: f64, _: f64) -> f64 {
    42.0
}

fn grid() -> Scene {
    Scene {
        place: Place::new(Frame::new(Some(32633), [500_000.0, 5_300_000.0]).expect("a grid"), None).expect("a place"),
        corner: [500_000.0, 5_300_000.0],
        heading_deg: 90.0,
        trigger_items: false,
        is_triangle: false,
        height: hills,
    }
}

fn local(origin_deg: Option<[f64; 2]>) -> Scene {
    Scene { place: Place::new(Frame::Local, origin_deg).expect("a place"), corner: [0.0, 0.0], ..grid() }
}

impl Scene {
    fn outputs(&self, look: impl FnOnce(&Outputs<'_>)) {
        let [x, y] = self.corner;
        let dem = Dem::from_fn((161, 141), [x - 3000.0, y - 3000.0], [50.0; 2], self.height);
        let relief = Relief::new(&dem);
        let corners = [[x, y], [x + 1200.0, y], [x + 1200.0, y + 600.0], [x, y + 600.0]];
        let corners = if self.is_triangle { &corners[..3] } else { &corners[..] };
        let half_tangent = [0.72_f64, 1.08];
        let sigmas = Sigmas { image: [2e-4, 2e-4], position_m: 0.015, attitude_rad: 1e-4 };
        let request = Request {
            area: Area::new(corners).expect("an area"),
            height_m: 500.0,
            half_tangent,
            pixels: [720, 1080],
            overlaps: Some(Overlaps { forward: 0.6, side: 0.3 }),
            heading_deg: Some(self.heading_deg),
            limits: Limits { speed_m_s: 35.0, min_interval_s: 0.038, accuracy_m: None },
            sigmas,
            exposure_s: 0.002,
            seed: 1,
        };
        let planned = request.plan(&relief, &|_, _| {}).expect("planned");
        let [fov_v, fov_h] = half_tangent.map(|tangent| 2.0 * tangent.atan().to_degrees());
        let camera = format!(
            "cols = 1080\nrows = 720\nfov_h_deg = {fov_h}\nfov_v_deg = {fov_v}\noffset_m_px = 0\noffset_n_px = 0\n"
        );
        let camera = CameraFile::from_toml_str(&camera, "camera.toml").expect("a camera");
        let noise = Noise { image_px: 0.1, position_m: 0.015, attitude_deg: 0.0057 };
        let file = planned.file(&request, &self.place, &camera, noise, "folder/a<b&c.tif").expect("a file");
        look(&Outputs { planned: &planned, file: &file, place: &self.place, trigger_items: self.trigger_items });
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

/// Photos of a plan as they are flown: latitude, longitude.
fn flown(file: &PlanFile) -> Vec<[f64; 2]> {
    let of = |strip: &plumbline_survey::plan::file::StripFile| {
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
        // One degree of longitude is 74.7 km here: the second strip comes back.
        let lon = |item: usize| number(&items[item]["params"][5]);
        assert!(lon(2) - lon(1) > (1200.0 + 2.0 * 216.0) / 74_700.0 && lon(3) > lon(4), "{items:?}");
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

#[test]
fn a_place_that_nobody_knows_leaves_two_files_out() {
    let names = |scene: Scene| {
        let mut names = Vec::new();
        scene.outputs(|outputs| names = outputs.files().expect("files").iter().map(|(name, _)| *name).collect());
        names.sort_unstable();
        names
    };
    assert_eq!(names(local(None)), ["coverage.tif", "plan.geojson", "plan.json", "report.html"]);
    let mut all = super::FILES;
    all.sort_unstable();
    assert_eq!(names(local(Some([48.0, 11.0]))), all);
}

fn ring(feature: &Value) -> Vec<[f64; 2]> {
    let ring = feature["geometry"]["coordinates"][0].as_array().expect("a ring");
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
                let place = &feature["geometry"]["coordinates"];
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
                let ground_m = outputs.planned.layout.relief.dem().height(*x, *y).expect("known");
                assert!((photo.z - depth_m - ground_m).abs() < 0.01, "{ground_m}");
            }
        }
    });
}

/// Every tag is closed by its own name, in order; nothing stands unescaped between them.
fn is_well_formed(xml: &str) -> bool {
    let mut open = Vec::new();
    for part in xml.split('<').skip(1) {
        let Some((tag, after)) = part.split_once('>') else { return false };
        if after
            .split('&')
            .skip(1)
            .any(|rest| !["amp;", "lt;", "gt;", "quot;"].iter().any(|name| rest.starts_with(name)))
        {
            return false;
        }
        match tag.strip_prefix('/') {
            Some(name) if open.pop() != Some(name) => return false,
            Some(_) => {}
            None if tag.starts_with('?') || tag.ends_with('/') => {}
            None => open.extend(tag.split(' ').next()),
        }
    }
    open.is_empty()
}

#[test]
fn kml_is_well_formed_and_has_every_photo() {
    assert!(
        is_well_formed("<a b=\"1\"><c>&amp;</c></a>")
            && !is_well_formed("<a><b></a></b>")
            && !is_well_formed("<a>&</a>")
    );
    grid().outputs(|outputs| {
        let kml = text(outputs, "plan.kml");
        assert!(is_well_formed(&kml), "{kml}");
        assert!(kml.contains("a&lt;b&amp;c.tif") && !kml.contains("folder"));
        assert_eq!(kml.matches("<Point>").count(), outputs.file.photo_count);
        assert_eq!(kml.matches("<LineString>").count(), outputs.file.strips.len());
        let photo = &outputs.file.strips[0].photos[0];
        let (lat, lon) = (photo.lat.expect("known"), photo.lon.expect("known"));
        let rounded = |deg: f64| (deg * 1e7).round() / 1e7;
        let coordinates = format!("<coordinates>{},{},{:.2}</coordinates>", rounded(lon), rounded(lat), photo.z);
        assert!(kml.contains(&coordinates), "{coordinates}");
    });
}

#[test]
fn the_coverage_is_read_back_at_the_right_places() {
    let degrees = Place::new(Frame::new(Some(4326), [11.0, 48.0]).expect("a frame"), None).expect("a place");
    let scenes = [grid(), local(None), Scene { place: degrees, ..local(None) }];
    for (index, scene) in scenes.into_iter().enumerate() {
        Scene { is_triangle: true, ..scene }.outputs(|outputs| {
            let path = std::env::temp_dir().join(format!("plumbline-coverage-{}-{index}.tif", std::process::id()));
            let files: BTreeMap<&str, Vec<u8>> = outputs.files().expect("files").into_iter().collect();
            std::fs::write(&path, &files["coverage.tif"]).expect("written");
            let raster = Raster::read(&path).expect("readable");
            let _ = std::fs::remove_file(&path);
            let (cells, known) = (&outputs.planned.cells, &outputs.planned.known);
            assert_eq!((raster.cols, raster.rows, raster.bands), (cells.cols, cells.rows, 4));
            assert_eq!((raster.crs, raster.nodata), (outputs.place.frame().epsg(), Some(-9999.0)));
            let mut seen = 0;
            for (cell, known) in cells.inside.iter().zip(known) {
                let [x, y] = outputs.place.frame().world(cells.centre(cell.col, cell.row));
                let (col, row) = raster.geo.pixel_from_world(x, y);
                assert!((col - col.round()).abs() < 1e-4 && (row - row.round()).abs() < 1e-4, "{col} {row}");
                let sample = |band| raster.sample(col.round() as usize, row.round() as usize, band);
                assert_eq!((sample(0), sample(1)), (Some(known.photos as f32), Some(known.in_strip as f32)));
                assert_eq!([sample(2), sample(3)], [0, 1].map(|axis| known.sd_m.map(|sd| sd[axis] as f32)));
                seen += 1;
            }
            let valid = (0..raster.cols * raster.rows)
                .filter(|index| raster.sample(index % raster.cols, index / raster.cols, 0).is_some());
            assert_eq!(valid.count(), seen, "outside the triangle nothing is known");
            assert!(seen < raster.cols * raster.rows * 2 / 3, "{seen}");
        });
    }
}

#[test]
fn the_page_has_the_plans_figures_and_needs_nothing_else() {
    grid().outputs(|outputs| {
        let (file, page) = (outputs.file, text(outputs, "report.html"));
        let accuracy = file.accuracy.as_ref().expect("seen twice");
        for figure in [
            format!("<h1>{} photos on {} lines</h1>", file.photo_count, file.strips.last().expect("strips").line + 1),
            format!("{:.3}\u{202f}m", accuracy.plan_m),
            format!("{:.3}\u{202f}m", accuracy.height_m),
            format!("{:.1}\u{202f}min", file.checks.flight_time_s / 60.0),
            format!("{:.3}\u{202f}s", file.interval_min_s),
            format!("{:.1}\u{202f}m", file.constant_base.base_m),
            "a&lt;b&amp;c.tif".to_owned(),
        ] {
            assert!(page.contains(&figure), "{figure}");
        }
        let photos = page.split("stroke=\"#b3261e\"").next().and_then(|before| before.rsplit("d=\"").next());
        assert_eq!(photos.map(|path| path.matches("h0").count()), Some(file.photo_count), "a dot each");
        for outside in ["http:", "https:", "<script", "src=\"/", "@import"] {
            assert!(!page.contains(outside), "{outside}");
        }
    });
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
