//! `report.html`.

use super::{grid, text};

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
