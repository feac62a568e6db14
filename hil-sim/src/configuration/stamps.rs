//! Shutter, timer and pulses in the configuration store: the calibrated values are the true ones.

use crate::scenario::{EdgeSource, Vehicle};
use crate::vehicle::sensors::hold_off_us;
use plumbline_firmware::stores::configuration::Stamps;

/// Tolerance of an ordinary crystal, one sigma.
const RATE_SIGMA_PPM: f32 = 30.0;
/// What TIMESYNC may be off beside its round trip.
const TIMESYNC_SIGMA_US: f32 = 100.0;
/// A stamp that is less certain than 5 ms moves a frame by a fifth of a metre at 40 m/s.
const SIGMA_MAX_US: f32 = 5000.0;

/// The stamps' settings of a vehicle.
pub(super) fn of(vehicle: &Vehicle) -> Stamps {
    let (shutter, timer) = (&vehicle.shutter, &vehicle.timer);
    // Lengths and arrivals are whole microseconds in the simulator.
    let rounded = |sigma: f64| if sigma > 0.0 { sigma.hypot(1.0 / 12.0_f64.sqrt()) as f32 } else { 0.0 };
    // The stamp is the middle row's; the first row arrives when the last has been exposed.
    let last_row_us = vehicle.rolling_shutter_us().div_ceil(2) as u32;
    Stamps {
        wired: match shutter.edges {
            EdgeSource::Both => 0,
            EdgeSource::One => 1,
            EdgeSource::None => 3,
        },
        opens_rising: true,
        delays_us: (shutter.open_delay_us, shutter.close_delay_us),
        hold_off_us: hold_off_us(vehicle),
        edge_sigma_us: shutter.edge_jitter_us as f32,
        exposure_us: Some((vehicle.exposure_us, rounded(shutter.exposure_jitter_us))),
        readout_us: (shutter.arrival_latency_us + last_row_us, rounded(shutter.arrival_jitter_us)),
        pulse_sigma_us: timer.pps_jitter_us as f32,
        rate_ppm: (RATE_SIGMA_PPM, timer.rate_walk_ppm as f32),
        timesync_sigma_us: TIMESYNC_SIGMA_US,
        sigma_max_us: SIGMA_MAX_US,
        exposure_limits_us: vehicle.auto_exposure.is_on.then(|| vehicle.exposures_us().into()),
    }
}
