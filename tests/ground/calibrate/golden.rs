//! The reference's block (adjustment.md, 2.4): 1,129 observations with unit weights.

use plumbline_survey::calibrate::{Block, Calibration, Observations};
use serde_json::Value;

pub const BLOCK: &str = include_str!("../../../examples/calibrate/block.json");
pub const OBSERVATIONS: &str = include_str!("../../../examples/calibrate/observations.csv");

fn solution() -> Value {
    let file: Value = serde_json::from_str(BLOCK).expect("JSON");
    file["solution"].clone()
}

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|v| v.as_f64().expect("a number")).collect()
}

#[test]
fn the_golden_block() {
    let block = Block::parse(BLOCK, "block.json").expect("a block");
    let observations = Observations::parse(OBSERVATIONS, "observations.csv", &block).expect("observations");
    let calibration = Calibration::new(&block, &observations, &mut |_, _| {}).expect("calibrated");
    let golden = solution();
    assert_eq!(calibration.size, (2258, 450));
    let sigma0 = golden["s0_px"].as_f64().expect("a number");
    assert!((calibration.sigma0_px - sigma0).abs() < 1e-9, "{} {sigma0}", calibration.sigma0_px);
    assert!(calibration.iterations <= 6, "{}", calibration.iterations);
    for (head, golden) in golden["heads_rad"].as_array().expect("heads").iter().enumerate() {
        for (k, golden) in numbers(golden).into_iter().enumerate() {
            let off_deg = (calibration.heads[head][k] - golden).to_degrees();
            assert!(off_deg.abs() < 1e-8, "head {head}, angle {k}: {off_deg:e} deg");
        }
    }
    let sigmas = calibration.unknowns.iter().map(|unknown| unknown.sigma.to_degrees() * 3600.0);
    for (ours, golden) in sigmas.zip(numbers(&golden["head_sd_arcsec"])) {
        assert!((ours - golden).abs() < 1e-6 * golden, "{ours} {golden}");
    }
    for (ours, golden) in calibration.stations.iter().zip(golden["stations"].as_array().expect("stations")) {
        for (k, golden) in numbers(golden).into_iter().enumerate() {
            let limit = if k < 3 { 1e-10 } else { 1e-7 };
            assert!((ours[k] - golden).abs() < limit, "{k}: {} {golden}", ours[k]);
        }
    }
    // Redundancies add up to what the equations have more than the unknowns.
    let sum: f64 = calibration.residuals.iter().flat_map(|residual| residual.redundancy).sum();
    assert!((sum - (2258.0 - 450.0)).abs() < 1e-6, "{sum}");
    assert!(calibration.outliers.is_empty(), "{:?}", calibration.outliers);
}

/// A mistake of 20 px is found, at its place, and Huber's loss keeps it from the angles.
#[test]
fn a_mistake_is_found_and_kept_away() {
    let block = Block::parse(BLOCK, "block.json").expect("a block");
    let mut observations = Observations::parse(OBSERVATIONS, "observations.csv", &block).expect("observations");
    let clean = Calibration::new(&block, &observations, &mut |_, _| {}).expect("calibrated");
    observations.seen[500].image_px[0] += 20.0;
    let of = |block: &Block| Calibration::new(block, &observations, &mut |_, _| {}).expect("calibrated");
    let squares = of(&block);
    assert_eq!(squares.outliers[0], 500);
    let robust_text = BLOCK.replacen('{', "{\"sigma_px\": 0.4, \"huber_sigmas\": 2.5, ", 1);
    let robust = of(&Block::parse(&robust_text, "block.json").expect("a block"));
    assert_eq!(robust.outliers[0], 500);
    let off = |calibration: &Calibration| {
        (1..4).flat_map(|head| (0..3).map(move |k| (head, k))).fold(0.0, |most: f64, (head, k)| {
            most.max((calibration.heads[head][k] - clean.heads[head][k]).to_degrees().abs() * 3600.0)
        })
    };
    assert!(off(&robust) < 0.5 * off(&squares), "{} {}", off(&robust), off(&squares));
    assert!(off(&robust) < 1.5, "{}", off(&robust));
}
