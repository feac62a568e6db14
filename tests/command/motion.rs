//! `plumbline motion` and `plumbline intersect`: tables G and H of paper 000 as a person types them, and bad input.

use crate::folder::{Folder, with, without};
use crate::refusals::Refusals;
use plumbline_tests::vectors::{list, miss, number, rows};
use serde_json::Value;

/// A call that works.
pub const MOTION: &str = "motion --focal-mm 120 --angles-deg 0.5,0.5,0.5 --rates-deg-s 0.3,0.3,0.3 \
     --speed-m-s 30.555555556 --height-m 2000 --exposure-ms 5 --json -- -18,24";
pub const INTERSECT: &str = "intersect --focal-mm 120 --station-1-m 0,0,2000 --station-2-m 0,298.66666666666669,2000 \
     --angles-deg 0.5,0.5,0.5 --rates-deg-s 0.3,0.3,0.3 --speed-m-s 30.555555555555557 --stamps-ms 2.5,2.5 --json \
     -- 5.07645416,7.98444992,4.92491227,-10.1099271";

fn triple(row: &Value, key: &str) -> String {
    list::<3>(row, key).map(|value| value.to_string()).join(",")
}

/// Nine digits of up to 12.3 um, in mm.
#[test]
fn golden_g() {
    let folder = Folder::new("motion-g");
    for row in rows("000", "G_eq21") {
        let [x, y, v, t, height, focal] = ["x_mm", "y_mm", "V", "t_ms", "HA", "f_mm"].map(|key| number(&row, key));
        let (angles, rates) = (triple(&row, "ang_deg"), triple(&row, "rate_deg_s"));
        let document = folder
            .run(&format!(
                "motion --focal-mm {focal} --angles-deg {angles} --rates-deg-s {rates} --speed-m-s {v} \
                 --height-m {height} --exposure-ms {t} --pixel-mm 0.009 --json -- {x},{y} 0,0"
            ))
            .json();
        let points = document["points"].as_array().expect("a list");
        assert_eq!(points.len(), 2, "{document}");
        let point = &points[0];
        assert_eq!([number(point, "x_mm"), number(point, "y_mm")], [x, y], "{point}");
        for (ours, golden) in [("exact_mm", "exact_um"), ("first_order_mm", "eq21_um")] {
            let wanted: [f64; 2] = list::<2>(&row, golden).map(|um| 1e-3 * um);
            assert!(miss(list(point, ours), wanted) < 1e-10, "{ours} of {point} for {row}");
        }
        let [ex, ey]: [f64; 2] = list(point, "exact_mm");
        assert!((number(point, "exact_px") - ex.hypot(ey) / 0.009).abs() < 1e-9, "{point}");
        // The centroid is the point of mid-exposure, to the track's bend: below 1e-6 mm.
        assert!(miss::<2>(list(point, "centroid_mm"), list(point, "mid_exposure_mm")) < 1e-6, "{point}");
        assert!(miss::<2>(list(point, "centroid_mm"), [x + 0.5 * ex, y + 0.5 * ey]) < 3e-6, "{point}");
    }
}

/// Image points of nine digits are good to 5e-8 mm, which is 8e-6 m in height.
#[test]
fn golden_h() {
    let folder = Folder::new("intersect-h");
    for row in rows("000", "H_intersection") {
        let ([t1, t2], [x1, y1], [x2, y2]): ([f64; 2], [f64; 2], [f64; 2]) =
            (list(&row, "stamp_ms"), list(&row, "img1_mm"), list(&row, "img2_mm"));
        let call = with(INTERSECT, "--stamps-ms", &format!("{t1},{t2}"));
        let call = with(&call, "--", &format!("{x1},{y1},{x2},{y2}"));
        let document = folder.run(&call).json();
        let point = &document["points"][0];
        let found = [number(point, "x_m"), number(point, "y_m"), number(point, "z_m")];
        assert!(miss(found, list(&row, "out")) < 1e-5, "{point} for {row}");
        // Stamps at mid-exposure leave nothing over.
        assert!(t1 != 2.5 || t2 != 2.5 || number(point, "rms_mm") < 1e-7, "{point}");
    }
    // The second photo's own orientation, given twice, changes nothing.
    let twice = INTERSECT.replace("--json", "--angles-2-deg 0.5,0.5,0.5 --rates-2-deg-s 0.3,0.3,0.3 --json");
    assert_eq!(folder.run(&twice).done().stdout, folder.run(INTERSECT).done().stdout);
    let turned = INTERSECT.replace("--json", "--angles-2-deg 0.5,0.5,0.6 --json");
    assert_ne!(folder.run(&turned).done().stdout, folder.run(INTERSECT).done().stdout);
}

/// Without --json a table: one line a point below its heading.
#[test]
fn tables_for_a_person() {
    let folder = Folder::new("motion-table");
    for call in [MOTION, INTERSECT] {
        let run = folder.run(&call.replace("--json ", "")).done();
        assert_eq!(run.stdout.lines().count(), 2, "{run:?}");
        assert!(!run.stdout.contains(" px"), "{run:?}");
    }
    // With a pixel the lengths of the motion are in pixels too.
    let document = folder.run(&MOTION.replace("--json", "--pixel-mm 0.009 --json")).json();
    let text = folder.run(&MOTION.replace("--json", "--pixel-mm 0.009")).done().stdout;
    let [heading, line] = text.lines().collect::<Vec<_>>()[..] else { panic!("{text}") };
    assert!(heading.ends_with("exact px  eq. 21 px") && heading.len() == line.len(), "{text}");
    let lengths = ["exact_px", "first_order_px"].map(|key| format!("{:.6}", number(&document["points"][0], key)));
    assert!(line.ends_with(&lengths.join("   ")), "{text} {lengths:?}");
}

#[test]
fn motion_that_cannot_be_meant() {
    let folder = Folder::new("motion-bad");
    let mut refusals = Refusals::new(&folder);
    for option in ["--focal-mm", "--height-m", "--exposure-ms"] {
        for value in ["0", "-1", "NaN", "inf", "ten"] {
            refusals.expect(&with(MOTION, option, value), &[option]);
        }
        refusals.expect(&without(MOTION, option), &[option]);
    }
    refusals.expect(&MOTION.replace("--json", "--pixel-mm 0 --json"), &["--pixel-mm"]);
    refusals.expect(
        &MOTION.replace("--json", "--pixel-mm 4.5 --json"),
        &["'4.5' for '--pixel-mm", "as the pixels of sensors are; were micrometres meant, write --pixel-mm 0.0045"],
    );
    refusals.expect(&MOTION.replace("--json", "--pixel-mm 1e6 --json"), &["--pixel-mm", "0.0001 to 0.2 mm"]);
    refusals.expect(&with(MOTION, "--speed-m-s", "NaN"), &["--speed-m-s"]);
    for option in ["--angles-deg", "--rates-deg-s"] {
        for value in ["1", "1,2", "1,2,3,4", "1,,3", "NaN,0,0", "a,b,c"] {
            refusals.expect(&with(MOTION, option, value), &[option]);
        }
    }
    for point in ["1", "1,2,3", "NaN,1", "a,b"] {
        refusals.expect(&with(MOTION, "--", point), &[point]);
    }
    refusals.expect(MOTION.trim_end_matches(" -- -18,24"), &["X,Y"]);
    // The ray of 24 mm at 120 mm is 11.3 degrees ahead of the axis: with omega = -80 it goes up.
    refusals.expect(&with(MOTION, "--angles-deg", "0,80,0"), &["-18,24", "ground"]);
    refusals.expect(&with(MOTION, "--rates-deg-s", "0,36000,0"), &["-18,24", "exposure"]);
    refusals.expect(&with(MOTION, "--speed-m-s", "1e308"), &["-18,24"]);
    refusals.done();
}

#[test]
fn intersections_that_cannot_be_meant() {
    let folder = Folder::new("intersect-bad");
    let mut refusals = Refusals::new(&folder);
    for option in ["--station-1-m", "--station-2-m", "--angles-deg", "--rates-deg-s"] {
        for value in ["1", "1,2", "NaN,0,0", "a,b,c"] {
            refusals.expect(&with(INTERSECT, option, value), &[option]);
        }
    }
    for option in ["--station-1-m", "--station-2-m", "--focal-mm"] {
        refusals.expect(&without(INTERSECT, option), &[option]);
    }
    for value in ["1", "1,2,3", "NaN,0"] {
        refusals.expect(&with(INTERSECT, "--stamps-ms", value), &["--stamps-ms"]);
    }
    for (stamps, photo) in [("1e300,2.5", "1e300 ms after its shutter opened photo 1"), ("0,-1e18", "photo 2")] {
        refusals.expect(&with(INTERSECT, "--stamps-ms", stamps), &["--stamps-ms", photo]);
    }
    for points in ["1,2", "1,2,3", "1,2,3,inf"] {
        refusals.expect(&with(INTERSECT, "--", points), &[points]);
    }
    // No base, and rays that meet behind.
    refusals.expect(&with(&with(INTERSECT, "--station-2-m", "0,0,2000"), "--", "1,2,1,2"), &["1,2,1,2"]);
    refusals.expect(&with(INTERSECT, "--", "5,-10,5,8"), &["5,-10,5,8", "behind"]);
    // A parallax of 1 um at 120 mm: 8e-6 rad.
    refusals.expect(&with(INTERSECT, "--", "5,8,5,7.999"), &["5,8,5,7.999", "meet at"]);
    refusals.done();
}

#[test]
fn help_shows_the_arguments() {
    let folder = Folder::new("motion-help");
    let all = folder.run("help").done().stdout;
    assert!(all.contains("motion") && all.contains("intersect"), "{all}");
    for (verb, options) in [
        ("motion", ["--focal-mm", "--angles-deg", "--rates-deg-s", "--exposure-ms", "X,Y"]),
        ("intersect", ["--station-1-m", "--station-2-m", "--stamps-ms", "--angles-2-deg", "X1,Y1,X2,Y2"]),
    ] {
        let text = folder.run(&format!("help {verb}")).done().stdout;
        for option in options {
            assert!(text.contains(option), "{option} in {text}");
        }
    }
}

/// Rows of the contract's five keys, the sweep in 0.02 ms steps, figures only where asked for.
#[test]
fn paper_000_is_reproduced() {
    let folder = Folder::new("reproduce-000");
    let document = folder.run("reproduce 000 --json --out figures").json();
    for row in document["rows"].as_array().expect("rows") {
        let keys: Vec<&String> = row.as_object().expect("an object").keys().collect();
        assert_eq!(keys, ["difference", "ours", "paper", "quantity", "table"], "{row}");
        assert!(number(row, "ours").is_finite(), "{row}");
    }
    let sweep = document["sweep"].as_array().expect("a sweep");
    assert_eq!((sweep.len(), number(&sweep[1], "stamp_ms")), (251, 0.02));
    for name in ["figure_3.svg", "figure_4.svg", "figure_5.svg"] {
        assert!(folder.text(&format!("figures/{name}")).ends_with("</svg>\n"), "{name}");
    }
    let text = folder.run("reproduce 000").done().stdout;
    assert!(text.contains("DIFFERENCE") && text.lines().all(|line| line.chars().count() <= 120), "{text}");
}
