//! Auto exposure against a scene and a sensor of the test's own: linear up to white, and two frames late.

use plumbline_core::auto_exposure::{AutoExposure, Brightness, Command, Histogram, LATENCY_FRAMES, MEAN_WANTED};
use plumbline_core::stamp::ExposureLimits;

const LIMITS: ExposureLimits = ExposureLimits { least_us: 60, longest_us: 20_000 };
/// At 4 Hz frame 4 is taken a second after frame 0.
const SECOND: u32 = 4;

/// A frame of 512 x 512: ground of greys from 30 to 190, mean 110, when it is exposed for 2 ms in the nominal light.
fn frame(light: f32, us: u32) -> Vec<u8> {
    let grey = |index: usize| 30.0 + 160.0 * ((index * 7919) % 1009) as f32 / 1008.0;
    let gain = light * us as f32 / 2000.0;
    (0..512 * 512).map(|index| (gain * grey(index)).min(255.0) as u8).collect()
}

fn brightness(light: f32, us: u32) -> Brightness {
    let mut histogram = Histogram::new();
    histogram.count(&frame(light, us), 512, 0);
    histogram.brightness().expect("pixels")
}

/// Exposures of so many frames, of which the first was set to `us`.
fn exposed(us: u32, frames: u32, light: impl Fn(u32) -> f32, sharp_us: Option<u32>) -> Vec<u32> {
    let mut control = AutoExposure::new(LIMITS, us);
    (0..frames)
        .map(|frame| {
            let us = control.of(frame);
            control.moved(sharp_us);
            if let Some(us) = control.after(frame, &brightness(light(frame), us)) {
                control.command(Command { from: frame + LATENCY_FRAMES, us });
            }
            us
        })
        .collect()
}

/// Stops from one to the other.
fn stops(us: u32, wanted_us: f32) -> f32 {
    (us as f32 / wanted_us).log2()
}

#[test]
fn two_stops_of_light_are_followed_within_a_second() {
    let exposures = exposed(2000, 20, |_| 0.25, None);
    println!("darker: {exposures:?}");
    assert_eq!(exposures[..2], [2000, 2000], "no command shows before the second frame behind it");
    assert!(stops(exposures[SECOND as usize], 8000.0).abs() < 0.2);
    let exposures = exposed(2000, 20, |_| 4.0, None);
    println!("brighter: {exposures:?}");
    // White pixels do not say how bright they are, so the last third of a stop takes longer.
    assert!(stops(exposures[SECOND as usize], 500.0).abs() < 0.4);
    assert!(stops(exposures[2 * SECOND as usize], 500.0).abs() < 0.2);
}

#[test]
fn no_step_is_larger_than_a_stop_and_nothing_swings() {
    for light in [0.05, 0.25, 0.5, 0.9, 1.3, 2.0, 4.0, 16.0] {
        let exposures = exposed(2000, 60, |_| light, None);
        for pair in exposures.windows(2) {
            assert!((0.49..=2.01).contains(&(f64::from(pair[1]) / f64::from(pair[0]))), "{light}: {exposures:?}");
        }
        let still = &exposures[20..];
        assert!(still.iter().all(|&us| us == still[0]), "{light}: {exposures:?}");
        let mean = brightness(light, still[0]).mean;
        // Within what moves nothing, or at a limit, or held down by what is bright.
        let fits = (MEAN_WANTED / 1.4..MEAN_WANTED * 1.4).contains(&mean);
        assert!(fits || still[0] == LIMITS.longest_us, "{light}: {mean}");
    }
}

#[test]
fn a_steady_scene_keeps_its_exposure() {
    // Fields and woods: a fifth more and less.
    let exposures = exposed(2000, 200, |frame| 1.0 + 0.2 * (frame as f32 * 0.7).sin(), None);
    assert!(exposures.iter().all(|&us| us == 2000), "{exposures:?}");
}

#[test]
fn exposures_stay_sharp_and_within_their_limits() {
    let sharp = exposed(2000, 20, |_| 0.9, Some(1500));
    assert_eq!(sharp[..4], [2000, 2000, 1500, 1500]);
    // Two and a half stops too dark: noise counts for more than blur, three times as far.
    let dark = exposed(2000, 20, |_| 0.1, Some(1500));
    assert_eq!(dark.last(), Some(&4500));
    assert_eq!(exposed(2000, 20, |_| 0.01, None).last(), Some(&LIMITS.longest_us));
    assert_eq!(exposed(2000, 20, |_| 1000.0, None).last(), Some(&LIMITS.least_us));
}

#[test]
fn the_worst_motion_is_outlived_slowly() {
    let mut control = AutoExposure::new(LIMITS, 2000);
    let mean = brightness(0.5, 2000);
    control.moved(Some(1200));
    assert_eq!(control.after(0, &mean), Some(1200));
    control.command(Command { from: 2, us: 1200 });
    // Calm all at once: longer exposures come back by a twentieth a frame, in steps that are worth it.
    let mut after = |frame| {
        control.moved(Some(10_000));
        control.after(frame, &mean)
    };
    let after: Vec<_> = (1..8).map(&mut after).collect();
    assert!(after[..4].iter().all(Option::is_none) && after[6] > Some(1500), "{after:?}");
}

#[test]
fn a_frame_has_the_exposure_that_was_commanded_for_it() {
    let mut control = AutoExposure::new(LIMITS, 1000);
    // Numbers of frames wrap.
    let first = u32::MAX - 2;
    control.command(Command { from: first, us: 1100 });
    control.command(Command { from: first.wrapping_add(1), us: 1200 });
    control.command(Command { from: first.wrapping_add(4), us: 1300 });
    let of: Vec<_> = (0..6).map(|n| control.of(first.wrapping_add(n))).collect();
    assert_eq!(of, [1100, 1200, 1200, 1200, 1300, 1300]);
}

#[test]
fn pieces_of_a_frame_count_as_the_whole() {
    let frame = frame(1.0, 2000);
    let whole = {
        let mut histogram = Histogram::new();
        histogram.count(&frame, 512, 0);
        histogram
    };
    for rows in [1, 2, 3, 4, 8, 13, 16, 64] {
        let mut histogram = Histogram::new();
        for (piece, pixels) in frame.chunks(512 * rows).enumerate() {
            histogram.count(pixels, 512, (piece * rows) as u16);
        }
        assert_eq!(histogram, whole, "{rows} rows at a time");
    }
    let said = whole.brightness().expect("pixels");
    let mean = frame.iter().map(|&pixel| f64::from(pixel)).sum::<f64>() / frame.len() as f64;
    assert!((f64::from(said.mean) - mean).abs() < 1.5 && (176.0..192.0).contains(&said.bright), "{said:?}, {mean}");
    assert_eq!(Histogram::new().brightness(), None);
}
