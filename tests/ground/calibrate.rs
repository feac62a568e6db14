//! Calibration of a camera of several heads: the reference's golden block, blocks without a datum, files that are none.

mod bal;
mod beyond;
mod golden;
mod mounts;
mod refused;
mod simulated;
