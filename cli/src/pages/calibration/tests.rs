//! The page of the reference's golden block, and of what else a block may be.

use super::before::Before;
use super::observed::Observed;
use super::page;
use super::seams::Seams;
use plumbline_charts::format::number;
use plumbline_survey::adjust::rig::{Station, project};
use plumbline_survey::calibrate::{Block, Calibration, Observations, Symmetrised};
use serde_json::{Value, json};
use std::sync::OnceLock;

const BLOCK: &str = include_str!("../../../../examples/calibrate/block.json");
const OBSERVATIONS: &str = include_str!("../../../../examples/calibrate/observations.csv");

struct Calibrated {
    block: Block,
    observations: Observations,
    calibration: Calibration,
    page: String,
}

/// Adjusts a block of such observations.
fn calibrated(block: &str, observations: &str) -> Calibrated {
    let block = Block::parse(block, "block.json").expect("a block");
    let observations = Observations::parse(observations, "some/folder/observations.csv", &block).expect("observations");
    let calibration = Calibration::new(&block, &observations, &mut |_, _| {}).expect("a calibration");
    let page = page(&block, &observations, &calibration);
    Calibrated { block, observations, calibration, page }
}

/// One block for all tests.
fn golden() -> &'static Calibrated {
    static GOLDEN: OnceLock<Calibrated> = OnceLock::new();
    GOLDEN.get_or_init(|| calibrated(BLOCK, OBSERVATIONS))
}

/// The golden block with other keys.
fn with(keys: Value) -> String {
    let mut block: Value = serde_json::from_str(BLOCK).expect("JSON");
    let keys = keys.as_object().expect("keys").clone();
    block.as_object_mut().expect("an object").extend(keys);
    block.to_string()
}

/// Nothing from outside, no number missing, every tag closed in its turn.
fn is_whole(page: &str) {
    for outside in ["http", "src=", "<script", "<link", "@import", "url("] {
        // A picture may refer to a part of itself.
        assert!(!page.replace("url(#", "").contains(outside), "{outside}");
    }
    for broken in ["NaN", "inf", "e308"] {
        // The style sheet and the words of the page hold none of them either.
        assert!(!page.contains(broken), "{broken}: {:?}", page.split_once(broken).map(|(before, _)| before.len()));
    }
    let cells = page.split("<td class=\"n").skip(1).map(|rest| rest.split_once('>').map_or("", |(_, cell)| cell));
    assert!(cells.clone().count() > 30 && cells.clone().all(|cell| !cell.starts_with('<')), "an empty number cell");
    let mut open = Vec::new();
    for tag in page.split('<').skip(1).map(|rest| rest.split('>').next().unwrap_or("")) {
        let name = tag.split([' ', '\n']).next().unwrap_or("");
        match name.strip_prefix('/') {
            Some(name) => assert_eq!(open.pop(), Some(name)),
            None if tag.ends_with('/') || ["!DOCTYPE", "meta", "br"].contains(&name) => {}
            None => open.push(name),
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn the_golden_page_holds_the_references_numbers() {
    let golden = golden();
    is_whole(&golden.page);
    // Reference 2.4.
    let degrees = |value: f64| format!("{}°", number(value, 5, ""));
    let heads = [21.821723039, 18.437945138, -21.926675123, -17.621259812, 22.004683758, -17.833414261];
    let told = heads.map(degrees);
    for told in told.iter().map(String::as_str).chain(["0.394\u{202f}px", "2\u{202f}258 / 450", "1\u{202f}129"]) {
        assert!(golden.page.contains(told), "{told}");
    }
    for told in ["better than assumed", "The block has no cols and rows: ", "0.1500\u{202f}m", "Line "] {
        assert!(golden.page.contains(told), "{told}");
    }
    assert!(golden.page.contains("Lines of observations.csv,") && !golden.page.contains("some/folder"));
    assert!(page(&golden.block, &golden.observations, &golden.calibration) == golden.page);
}

/// Two computations of the same sum: the start residuals' and the adjustment's cost; and that the design is worth less than
/// the calibration.
#[test]
fn residuals_before_are_those_the_adjustment_began_with() {
    let golden = golden();
    let before = Before::new(&golden.block, &golden.observations);
    let squares = |all: &[Option<[f64; 2]>]| all.iter().flatten().flatten().map(|v| v * v).sum::<f64>();
    let (start, end) = golden.calibration.cost;
    assert!((squares(&before.at_start) / (2.0 * start) - 1.0).abs() < 1e-12);
    // At the adjusted values they are the adjustment's own, with its signs.
    let mut adjusted = golden.block.clone();
    adjusted.heads.iter_mut().zip(&golden.calibration.heads).for_each(|(head, values)| head.values = *values);
    adjusted
        .stations
        .iter_mut()
        .zip(&golden.calibration.stations)
        .for_each(|(station, values)| station.values = *values);
    adjusted.points.iter_mut().zip(&golden.calibration.points).for_each(|(point, at)| point.position_m = *at);
    for (before, after) in
        Before::new(&adjusted, &golden.observations).at_start.iter().zip(&golden.calibration.residuals)
    {
        let before = before.expect("in front");
        assert!((0..2).all(|k| (before[k] - after.v_px[k]).abs() < 1e-7), "{before:?} {:?}", after.v_px);
    }
    let designed = squares(before.designed.as_ref().expect("an adjustment of stations and points"));
    assert!(designed < squares(&before.at_start) && designed > 100.0 * 2.0 * end, "{designed}");
}

/// Reference 2.1: 1 arc second is 0.033509 px on the axis, and grows on the plane with the square of the ray's length.
#[test]
fn predicted_seams_are_what_the_covariance_says() {
    let golden = golden();
    let symmetrised = Symmetrised::new(&golden.calibration.heads);
    let arc_second = 1.0 / super::ARC_SECONDS;
    // Which unknowns are phi, of heads 1 to 3: turning all three alike is no seam among them.
    let is_phi: Vec<bool> = golden.calibration.unknowns.iter().map(|unknown| unknown.number == 0).collect();
    let seams = |is_off: &dyn Fn(usize) -> bool| {
        let mut calibration = golden.calibration.clone();
        for (a, row) in calibration.covariance.iter_mut().enumerate() {
            for (b, value) in row.iter_mut().enumerate() {
                *value = if is_off(a) && is_off(b) { arc_second * arc_second } else { 0.0 };
            }
        }
        for (k, unknown) in calibration.unknowns.iter_mut().enumerate() {
            unknown.sigma = if is_off(k) { arc_second } else { 0.0 };
        }
        Seams::new(&golden.block, &golden.observations, &calibration, &symmetrised)
    };
    let alone = seams(&|k| is_phi[k] && golden.calibration.unknowns[k].head == 1);
    let together = seams(&|k| is_phi[k]);
    assert!(alone.places.len() > 300, "{}", alone.places.len());
    for pair in alone.pairs() {
        let (rms, max) = alone.rms_and_max(Some(pair)).expect("places");
        if pair.contains(&1) {
            assert!(rms > 0.0335 && max < 0.0336 * (1.0 + 1.2 * 1.2), "{pair:?} {rms} {max}");
        } else {
            assert!(max < 1e-6, "{pair:?} {max}");
        }
        let (_, max) = together.rms_and_max(Some(pair)).expect("places");
        assert!(if pair.contains(&0) { max > 0.0335 } else { max < 1e-6 }, "{pair:?} {max}");
    }
}

/// Observations without noise: what is left in the virtual image is what the parallax was not taken off exactly, nothing.
#[test]
fn without_noise_two_heads_put_a_point_to_one_place() {
    let golden = golden();
    let calibration = &golden.calibration;
    let mut observations = golden.observations.clone();
    for seen in &mut observations.seen {
        let station = Station { values: calibration.stations[seen.station], rates: [0.0; 6], is_free: true };
        let at = project(&calibration.heads[seen.head], &station, calibration.points[seen.point]);
        seen.image_px = at.expect("in front");
    }
    let symmetrised = Symmetrised::new(&calibration.heads);
    let observed = Observed::new(&golden.block, &observations, calibration, &symmetrised, 6911.764706);
    let (count, [(before, _), (_, after)]) = observed.of(None).expect("points seen twice");
    assert!(count > 100 && before > 10.0 && after < 1e-6, "{count} {before} {after}");
}

#[test]
fn everything_that_was_estimated_is_told() {
    let block = with(json!({
        "interior_free": ["c", "xp", "yp", "k1"],
        "interior_sigma": {"c": 1.0, "xp": 1.0, "yp": 1.0, "k1": 1e-4},
        "heads_d_sigma_m": 0.005, "sigma_px": 0.4,
        "cols": 7228, "rows": 5428, "virtual_cols": 15400, "virtual_rows": 10400,
    }));
    let all = calibrated(&block, OBSERVATIONS);
    is_whole(&all.page);
    let c = all.calibration.sigma(2, 7).expect("c of head 2");
    for told in [&number(c, 3, "px"), "as assumed", "Lever arms are unknowns", "15\u{202f}400 × 10\u{202f}400"] {
        assert!(all.page.contains(told), "{told}");
    }
    assert!(!all.page.contains("no cols and rows") && !all.page.contains("Nothing of it was estimated"));
}

/// One head, which has nothing unknown: no seams and no gain, but a page.
#[test]
fn a_camera_of_one_head_has_a_page() {
    let lines = OBSERVATIONS.lines().filter(|line| line.starts_with("station") || line.split(',').nth(1) == Some("0"));
    let observations = lines.collect::<Vec<_>>().join("\n");
    let of: Vec<usize> = observations.lines().skip(1).filter_map(|line| line.split(',').nth(2)?.parse().ok()).collect();
    let points = golden().block.points.len();
    let known: Vec<usize> =
        (0..points).filter(|point| *point < 30 || of.iter().filter(|seen| *seen == point).count() < 2).collect();
    let one = calibrated(
        &with(json!({
            "heads_d_m": [[0.0, 0.0, 0.0]], "head_start_rad": [[-0.38, 0.31, 0.0]], "fixed_points": known,
            "point_start": golden().calibration.points,
        })),
        &observations,
    );
    is_whole(&one.page);
    assert!(one.page.contains("Camera of 1 head<") && !one.page.contains("Seams"));
    assert!(!one.page.contains("Calibration brings") && !one.page.contains("−0.00000°"));
}
