//! A constant error of the attitude larger than its prior sigma.

use super::{After, CONSUMER, flown_by, flown_knowing};
use crate::navigation::filter::Filter;
use std::vec::Vec;

const MISALIGNED: [f32; 2] = [0.0175, -0.0175];

/// A leg of 20 s, then circles.
fn turning(at_s: f32) -> f32 {
    if at_s < 20.0 { 0.5 } else { 0.5 + 0.15 * (at_s - 20.0) }
}

#[test]
fn turns_find_what_was_not_stated() {
    let after = flown_knowing(&CONSUMER, 90.0, 24.0, turning, |_| MISALIGNED);
    // On the leg the prior sigma holds.
    assert!(after[..70].iter().all(|after| after.sigma_rad < 1.1 * CONSUMER.tilt_rad), "{:?}", after[69]);
    // A circle later it is detected and removed.
    let end = &after[250..];
    let is_known = |after: &After| {
        let off = |axis: usize| (after.tilt_rad[axis] - MISALIGNED[axis]).abs();
        off(0) < 3.0 * after.sigma_rad && off(1) < 3.0 * after.sigma_rad && after.sigma_rad < 0.01
    };
    assert!(end.iter().all(is_known), "{:?}", end[end.len() - 1]);
    assert!(end.iter().all(|after| after.squares < 9.2), "{:?}", end[end.len() - 1]);
    // It is explained: frames keep their fixes.
    assert!(after.iter().all(|after| after.unexplained_rad < 0.005), "{after:?}");
}

#[test]
fn nothing_is_found_where_it_is_as_stated() {
    for headed in [turning, |_| 0.5] {
        let after = flown_knowing(&CONSUMER, 300.0, 24.0, headed, |_| [0.0025, 0.0]);
        let large = |after: &&After| after.tilt_rad.iter().any(|rad| rad.abs() > CONSUMER.tilt_rad);
        assert_eq!(after.iter().filter(large).count(), 0);
        let end = after[after.len() - 1];
        assert!(end.sigma_rad < 1.1 * CONSUMER.tilt_rad, "{end:?}");
    }
}

/// The sensitivity is the difference of two filters, one with the misalignment: the filter is linear in it until noise
/// exceeds a gate in one of them.
#[test]
fn it_moves_the_estimate_as_the_filter_does() {
    const BY_RAD: f32 = 0.001;
    let settled = |tilt: [f32; 2]| {
        let mut filter = Filter::new();
        flown_by(&mut filter, &CONSUMER, 40.0, 24.0, |at_s| 0.1 * at_s, |_| tilt);
        (filter.settled.expect("it was found").state, filter.misalignment.sensitivity)
    };
    let (plain, moved) = settled([0.0; 2]);
    for axis in 0..2 {
        let mut tilt = [0.0; 2];
        tilt[axis] = BY_RAD;
        let by: Vec<f32> = ((plain - settled(tilt).0) / BY_RAD).iter().copied().collect();
        let said: Vec<f32> = moved.column(axis).iter().copied().collect();
        let is_near = |(by, said): (&f32, &f32)| (by - said).abs() < 0.02 * said.abs().max(1.0);
        assert!(by.iter().zip(&said).all(is_near), "{by:?}\n{said:?}");
    }
}
