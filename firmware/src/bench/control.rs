//! What the control of exposure and servo costs: a frame's histogram, the next exposure, the longest that is sharp, and the
//! servo's command, by libm as well.

use super::poses::Pose;
use super::region::{Stand, region};
use core::hint::black_box;
use plumbline_core::auto_exposure::{AutoExposure, Histogram};
use plumbline_core::camera::Camera;
use plumbline_core::motion::{Moving, Rates, Velocity, image_motion};
use plumbline_core::stamp::ExposureLimits;
use plumbline_core::tilt::{approximate_follow_up_command, follow_up_command};
use plumbline_core::units::Radians;

/// Rates of a vehicle that turns at some ten degrees a second about each axis.
const RATES: Rates = Rates { heading: 0.1, pitch: -0.2, roll: 0.15, follow_up: 0.1 };
const VELOCITY: Velocity = Velocity { north: 20.0, up: 0.0, east: -10.0 };
/// Longest sharp exposure, below the one that the frame was taken with: the exposure must change.
const SHARP_US: u32 = 90;
/// Side of the frame, pixels, and rows that are handed over at a time, as those of the workload `frame` are.
const SIDE: u16 = 512;
const ROWS: u16 = 2;

/// Runs all of it; whether the exposure was changed. `picture`: at least 512 x 512 pixels.
pub fn run(stand: &mut impl Stand, picture: &[u8]) -> bool {
    let fov = Radians::from_degrees(60.0);
    let Ok(camera) = Camera::new((SIDE, SIDE), (fov, fov), (0.0, 0.0), None) else { return false };
    let mut histogram = Histogram::new();
    region(stand, ("exposure", "histogram"), "any", || {
        let pieces = picture.chunks_exact(usize::from(SIDE * ROWS)).take(usize::from(SIDE / ROWS));
        for (piece, first) in pieces.zip((0..SIDE).step_by(usize::from(ROWS))) {
            histogram.count(piece, SIDE, first);
        }
    });
    let mut control = AutoExposure::new(ExposureLimits { least_us: 60, longest_us: 8000 }, 100);
    control.moved(Some(SHARP_US));
    let next = region(stand, ("exposure", "next"), "any", || {
        histogram.brightness().and_then(|brightness| control.after(7, &brightness))
    });
    let mut are_sharp = true;
    for pose in Pose::all() {
        let (attitude, follow_up) = (pose.attitude(), pose.follow_up());
        let moving = Moving { attitude, follow_up, rates: RATES, velocity: VELOCITY, height_m: 120.0 };
        let name = ("longest sharp exposure", "all");
        are_sharp &= region(stand, name, pose, || image_motion(&camera, black_box(&moving), 0)).is_ok();
        region(stand, ("servo command", "all"), pose, || approximate_follow_up_command(black_box(attitude)));
        region(stand, ("servo command, by libm", "all"), pose, || follow_up_command(black_box(attitude)));
    }
    are_sharp && next == Some(SHARP_US)
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::{SIDE, Stand, run};
    use crate::bench::texture::checks;
    use core::fmt::Arguments;

    struct Nobody;

    impl Stand for Nobody {
        fn report(&mut self, _: Arguments<'_>) {}

        fn cycles(&mut self) -> Option<u32> {
            None
        }
    }

    #[test]
    fn the_exposure_is_changed() {
        let mut picture = std::vec![0; usize::from(SIDE) * usize::from(SIDE)];
        checks(&mut picture, SIDE.into(), 1);
        assert!(run(&mut Nobody, &picture));
    }
}
