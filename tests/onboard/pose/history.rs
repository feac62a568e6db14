//! Histories: table I of paper 000 and what a stream does in the field.

use plumbline_core::pose::{Backwards, History, PoseError};
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians};
use plumbline_tests::mutants;
use plumbline_tests::seeded::config;
use plumbline_tests::vectors::{list, miss, number, rows, turn_deg};
use proptest::prelude::{prop_assert, proptest};

fn attitude(degrees: [f64; 3]) -> Attitude {
    let [heading, pitch, roll] = degrees.map(|deg| Radians(deg.to_radians() as f32));
    Attitude { heading, pitch, roll }
}

fn degrees(attitude: Attitude) -> [f64; 3] {
    [attitude.heading, attitude.pitch, attitude.roll].map(|angle| f64::from(angle.0).to_degrees())
}

/// The difference of two attitudes in degrees, the heading's the short way round.
fn miss_attitude(a: [f64; 3], b: [f64; 3]) -> f64 {
    miss([turn_deg(a[0], b[0]), a[1], a[2]], [0.0, b[1], b[2]])
}

#[test]
fn golden_i_attitude() {
    let mut long_way = 0.0f64;
    for row in rows("000", "I_att") {
        let (a0, a1): ([f64; 3], [f64; 3]) = (list(&row, "a0"), list(&row, "a1"));
        let at = 5_000_000 + (5000.0 * number(&row, "u")) as u64;
        let mut history: History<Attitude, 3, 4> = History::new();
        for (stamp, sample) in [(5_000_000, a0), (5_005_000, a1)] {
            history.push(Micros(stamp), attitude(sample)).expect("forwards");
        }
        let ours = degrees(history.at(Micros(at), 5000).expect("between both").value);
        assert!(miss_attitude(ours, list(&row, "linear")) < 1e-4, "{ours:?} for {row}");
        long_way = long_way.max(miss_attitude(mutants::attitude_long_way(a0, a1, number(&row, "u")), ours));
    }
    assert!(long_way > 1.0, "the core goes the long way round");
}

fn history(stamps: &[u64]) -> History<f32, 1, 4> {
    let mut history = History::new();
    for &stamp in stamps {
        history.push(Micros(stamp), stamp as f32).expect("forwards");
    }
    history
}

#[test]
fn a_history_never_extrapolates() {
    assert!(History::<f32, 1, 4>::new().at(Micros(5), 100).is_err());
    let history = history(&[1000, 1100, 1200, 1300, 1400]);
    // Five samples in a ring of four: the first is forgotten.
    for (at, expected) in [(1000, PoseError::TooOld), (1099, PoseError::TooOld), (1401, PoseError::NotYet)] {
        assert_eq!(history.at(Micros(at), 100).map(|i| i.value), Err(expected), "at {at}");
    }
    for (at, value, u) in [(1100, 1100.0, 0.0), (1125, 1125.0, 0.25), (1399, 1399.0, 0.99), (1400, 1400.0, 0.0)] {
        let found = history.at(Micros(at), 100).expect("inside");
        assert!((found.value - value).abs() < 1e-3 && (found.u - u).abs() < 1e-6, "{found:?} at {at}");
    }
}

#[test]
fn a_history_does_not_bridge_gaps_nor_run_backwards() {
    let mut history = history(&[1000, 1100, 1301]);
    assert_eq!(history.at(Micros(1200), 200).map(|i| i.value), Err(PoseError::Gap));
    assert!(history.at(Micros(1200), 201).is_ok());
    assert!(history.at(Micros(1050), 100).is_ok(), "the gap is elsewhere");
    for stamp in [0, 1300, 1301] {
        assert_eq!(history.push(Micros(stamp), 9.0), Err(Backwards), "stamp {stamp}");
    }
    assert_eq!(history.newest(), Some((Micros(1301), 1301.0)));
    // Samples hours apart are a gap too, whatever the counter's width.
    history.push(Micros(1301 + (1 << 32) + 50), 1.0).expect("forwards");
    assert_eq!(history.at(Micros(1400), 100).map(|i| i.value), Err(PoseError::Gap));
}

proptest! {
    #![proptest_config(config(2, 2000))]

    /// Linear in each angle, the heading the short way round, at ±180° and everywhere else.
    #[test]
    fn headings_go_the_short_way(from in -180.0f64..360.0, turn in -179.0f64..179.0, u_us in 0u64..=5000,
                                 pitch in -60.0f64..60.0, roll in -60.0f64..60.0) {
        let mut history: History<Attitude, 3, 4> = History::new();
        prop_assert!(history.push(Micros(0), attitude([from, 0.0, roll])).is_ok());
        prop_assert!(history.push(Micros(5000), attitude([(from + turn).rem_euclid(360.0), pitch, -roll])).is_ok());
        let found = history.at(Micros(u_us), 5000);
        prop_assert!(found.is_ok());
        let (ours, u) = (found.map(|i| degrees(i.value)).unwrap_or_default(), u_us as f64 / 5000.0);
        let off = miss_attitude(ours, [from + u * turn, u * pitch, roll * (1.0 - 2.0 * u)]);
        prop_assert!(off < 1e-4, "{ours:?}, {off} degrees off");
    }
}
