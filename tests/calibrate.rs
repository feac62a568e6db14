//! Calibration of a camera of several heads: the reference's golden block, blocks without a datum, files that are none.

#[path = "calibrate/bal.rs"]
mod bal;
#[path = "calibrate/beyond.rs"]
mod beyond;
#[path = "calibrate/golden.rs"]
mod golden;
#[path = "calibrate/mounts.rs"]
mod mounts;
#[path = "calibrate/refused.rs"]
mod refused;
#[path = "calibrate/simulated.rs"]
mod simulated;
