//! GPS_RAW_INT.

use crate::vehicle::sensors::Sample;
use mavlink::dialects::common::{GPS_RAW_INT_DATA, GpsFixType};
use plumbline_firmware::wire::extensions::GpsRaw;
use plumbline_survey::crs::Crs;
use plumbline_survey::error::InputError;

/// A position that a receiver has handed over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Received {
    /// How long ago.
    pub age_us: u64,
    /// Grid.
    pub east_m: f64,
    /// Grid.
    pub north_m: f64,
    /// One sigma of each, as it says.
    pub sigma_m: f64,
}

/// Of a receiver with or without a fix; with a place and its accuracy where these are simulated. Its stamp is that of the message's
/// being handed over, in whole milliseconds as ArduPilot has it.
pub(super) fn gnss(
    sample: &Sample,
    has_gnss: bool,
    receiver: Option<Option<Received>>,
    crs: &Crs,
) -> Result<GpsRaw, InputError> {
    let is_good = has_gnss && receiver.is_none_or(|received| received.is_some());
    let fix_type = if is_good { GpsFixType::GPS_FIX_TYPE_3D_FIX } else { GpsFixType::GPS_FIX_TYPE_NO_FIX };
    let base = GPS_RAW_INT_DATA { time_usec: sample.sampled_at_us, fix_type, ..GPS_RAW_INT_DATA::DEFAULT };
    let Some(received) = receiver.flatten().filter(|_| is_good) else { return Ok(GpsRaw { base, h_acc_mm: 0 }) };
    let (lat, lon) = crs.to_wgs84(received.east_m, received.north_m)?;
    let e7 = |degrees: f64| (degrees * 1e7).round() as i32;
    let time_usec = sample.sampled_at_us.saturating_sub(received.age_us) / 1000 * 1000;
    let base = GPS_RAW_INT_DATA { time_usec, lat: e7(lat), lon: e7(lon), ..base };
    Ok(GpsRaw { base, h_acc_mm: (1e3 * received.sigma_m).round() as u32 })
}
