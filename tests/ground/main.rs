//! What is computed on the ground: calibration, smoothing, stitching, real frames and logs, the comparison of kernels.

mod calibrate;
mod compare;
mod flight_logs;
mod heads;
mod logs;
mod real;
mod smooth;
