//! `plumbline reproduce` as a script sees it.

use crate::folder::Folder;
use crate::refusals::Refusals;
use plumbline_tests::vectors::{number, rows};
use serde_json::Value;

/// The row whose quantity is `quantity`.
fn row<'a>(all: &'a Value, quantity: &str) -> &'a Value {
    let mut found = all["rows"].as_array().expect("rows").iter().filter(|row| row["quantity"] == quantity);
    let row = found.next().unwrap_or_else(|| panic!("no row {quantity}"));
    assert!(found.next().is_none(), "two rows {quantity}");
    row
}

/// Smoothing is at or below the reference's figures, with the margin of 3 % that noise of other seeds needs.
#[test]
fn paper_001() {
    let folder = Folder::new("reproduce-001");
    let all = folder.run("reproduce 001 --json --out figures").json();
    for row in all["rows"].as_array().expect("rows") {
        let keys: Vec<&String> = row.as_object().expect("a row").keys().collect();
        assert_eq!(keys, ["difference", "ours", "paper", "quantity", "table"], "{row}");
    }
    for golden in rows("001", "S_interpolants") {
        for (name, key) in [("D2", "d2"), ("D3", "d3")] {
            let row = row(&all, &format!("T = {} s: {name} GCV, rms between samples, m", golden["T"]));
            assert!(number(row, "ours") < 1.03 * number(&golden, key), "{row} {golden}");
        }
    }
    for figure in 1..=4 {
        assert!(folder.text(&format!("figures/figure_{figure}.svg")).starts_with("<svg"));
    }
    let page = folder.text("figures/report.html");
    let differ = all["rows"].as_array().expect("rows").iter().filter(|row| row["difference"].is_string()).count();
    assert!(page.contains(&format!("{differ} differ")) && page.matches("data:image/svg+xml").count() == 4, "{differ}");
    let text = folder.run("reproduce 001").done().stdout;
    assert!(text.contains("DIFFERENCE") && text.contains("0.11"), "{text}");
}

#[test]
fn figures_that_cannot_be_written() {
    let folder = Folder::new("reproduce-refused");
    folder.write("file", "");
    folder.make("in-the-way");
    folder.make("in-the-way/figure_2.svg");
    let mut refusals = Refusals::new(&folder);
    for place in ["none/out", "file", "in-the-way"] {
        refusals.expect(&format!("reproduce 001 --out {place}"), &[place]);
    }
    refusals.done();
}
