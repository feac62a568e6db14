//! Where the sun stands: what is lit and where shadows fall.

use crate::scenario::Changes;

/// Direction to the sun, east, north, up: from the south-south-east, 48 deg high.
const SUN: [f64; 3] = [0.2863, -0.6045, 0.7431];

/// The direction to the sun.
pub(super) fn direction(changes: &Changes) -> [f64; 3] {
    if changes.sun_azimuth_deg.is_none() && changes.sun_elevation_deg.is_none() {
        return SUN;
    }
    let azimuth = changes.sun_azimuth_deg.map_or(SUN[0].atan2(SUN[1]), f64::to_radians);
    let (up, level) = changes.sun_elevation_deg.map_or(SUN[2].asin(), f64::to_radians).sin_cos();
    [level * azimuth.sin(), level * azimuth.cos(), up]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_stands_where_it_is_told() {
        let at = |azimuth, elevation| {
            direction(&Changes { sun_azimuth_deg: azimuth, sun_elevation_deg: elevation, ..Changes::default() })
        };
        assert_eq!(at(None, None), SUN);
        let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 5e-4);
        // What is not said stays: 154.66 degrees, 48.0 degrees; of four digits, the length of SUN is 1 to 2e-4.
        assert!(near(at(Some(154.656), None), SUN) && near(at(None, Some(47.997)), SUN), "{:?}", at(None, Some(48.0)));
        assert!(near(at(Some(270.0), Some(30.0)), [-0.866_025, 0.0, 0.5]));
    }
}
