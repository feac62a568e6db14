//! Streams at the door: latencies, stamps from the future, a sender whose clock begins anew.

use plumbline_core::pipeline::{Arrival, Instants, Latencies, SampleError, Streams};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Metres, Micros, Radians};

fn level() -> Attitude {
    Attitude::default()
}

fn arriving(sampled_us: u64, arrived_us: u64, sigma_us: f32) -> Instants {
    let arrival = Some(Arrival { at: Micros(arrived_us), sigma_us });
    Instants { sampled_at: Micros(sampled_us), stamp_sigma_us: 0.0, arrival }
}

/// Few messages from the future, as many as there may be, cost no more true samples than they lie ahead.
#[test]
fn stamps_from_the_future_do_not_stop_the_others() {
    let latencies = Latencies { attitude_us: 4_000, ..Latencies::default() };
    for (ahead_us, is_taken) in [(90_000, false), (49_000, true), (4_000, true)] {
        let mut streams = Streams::new(latencies);
        let mut refused = 0;
        for ms in (0..4_000u64).step_by(5) {
            let now_us = 1_000_000 + 1_000 * ms;
            // Five a second.
            if ms % 200 == 0 {
                let taken = streams.attitude(arriving(now_us + ahead_us, now_us, 300.0), level());
                assert_eq!(taken.is_ok(), is_taken, "{ahead_us} us ahead: {taken:?}");
            }
            refused += u32::from(streams.attitude(arriving(now_us - 3_000, now_us, 300.0), level()).is_err());
        }
        assert_eq!(refused, 0, "{ahead_us} us ahead");
        // Nothing that was ahead is left among them.
        let stamps: Vec<u64> = streams.attitude.history().samples().map(|(at, _)| at.0).collect();
        assert!(stamps.windows(2).all(|pair| pair[1] - pair[0] == 5_000), "{stamps:?}");
    }
}

#[test]
fn a_value_holds_its_latency_before_its_stamp() {
    let latencies = Latencies { attitude_us: 5_000, range_us: 20_000, ..Latencies::default() };
    let mut streams = Streams::new(latencies);
    let at = arriving(100_000, 108_000, 0.0);
    streams.attitude(at, level()).expect("a sample");
    streams.slant(at, Metres(100.0)).expect("a sample");
    streams.follow_up(at, Radians(0.1)).expect("a sample");
    assert_eq!(streams.attitude.history().newest().map(|(at, _)| at), Some(Micros(95_000)));
    assert_eq!(streams.slant.history().newest(), Some((Micros(80_000), 100.0)));
    assert_eq!(streams.follow_up.history().newest().map(|(at, _)| at), Some(Micros(100_000)));
    // Attitude, follow-up angle, range, position.
    assert_eq!(streams.delays_us(), [13_000, 8_000, 28_000, 0]);
    // Older than the clock itself.
    assert_eq!(streams.slant(Micros(19_999), Metres(100.0)), Err(SampleError::Invalid));
}

#[test]
fn stamps_from_the_future_are_refused() {
    let mut streams = Streams::new(Latencies::default());
    let future = Err(SampleError::Future);
    for (sampled_us, expected) in [(1_200_000, future), (1_050_001, future), (1_050_000, Ok(()))] {
        assert_eq!(streams.attitude(arriving(sampled_us, 1_000_000, 0.0), level()), expected, "stamped {sampled_us}");
    }
    // A board that does not know the time cannot tell.
    assert_eq!(streams.attitude(Micros(9_000_000), level()), Ok(()));
}

#[test]
fn numbers_that_are_none_are_refused() {
    let mut streams = Streams::new(Latencies::default());
    for bad in [f32::NAN, f32::INFINITY] {
        let attitude = Attitude { pitch: Radians(bad), ..level() };
        assert_eq!(streams.attitude(Micros(5), attitude), Err(SampleError::Invalid));
        assert_eq!(streams.follow_up(Micros(5), Radians(bad)), Err(SampleError::Invalid));
        assert_eq!(streams.slant(Micros(5), Metres(bad)), Err(SampleError::Invalid));
    }
    assert_eq!(streams.slant(Micros(5), Metres(655.35)), Err(SampleError::Invalid));
    assert_eq!(streams.attitude.history().newest(), None);
}

/// A few stamps backwards are mistakes; many in a row are a sender that has started anew, whose old samples are worth nothing.
#[test]
fn a_sender_that_starts_anew_is_believed_in_time() {
    let mut streams = Streams::new(Latencies::default());
    for i in 0..10u64 {
        streams.attitude(Micros(60_000_000 + 5_000 * i), level()).expect("forwards");
    }
    for i in 0..19u64 {
        assert_eq!(streams.attitude(Micros(5_000 * i), level()), Err(SampleError::Backwards), "{i}");
    }
    streams.attitude(Micros(60_050_000), level()).expect("the old clock goes on");
    for i in 0..19u64 {
        assert_eq!(streams.attitude(Micros(5_000 * i), level()), Err(SampleError::Backwards), "{i}");
    }
    streams.attitude(Micros(95_000), level()).expect("the twentieth in a row");
    assert_eq!(streams.attitude.history().samples().count(), 1);
    streams.attitude(Micros(100_000), level()).expect("forwards");
}
