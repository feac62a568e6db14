//! Calibration of a camera of several heads: the reference's golden block, blocks without a datum, files that are none.

#[path = "calibrate/golden.rs"]
mod golden;
#[path = "calibrate/refused.rs"]
mod refused;
