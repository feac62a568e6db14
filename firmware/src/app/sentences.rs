//! What the pilot reads of the autopilot and of its fixes: lines of at most 50 characters.

use super::Line;
use crate::autopilot::parameters::Finding;
use crate::autopilot::requests::Complaint;
use crate::autopilot::{sources, watch};
use plumbline_core::pipeline::Refusal;

/// A request that was in vain.
pub(super) fn complaint(complaint: Complaint) -> Line {
    match complaint {
        Complaint::Denied(stream, interval_us) => {
            let mut digits = [0; DIGITS];
            let hz = 1_000_000 / interval_us.max(1);
            Line::of([stream.name(), " at ", whole(hz, &mut digits), " Hz denied: raise SCHED_LOOP_RATE"])
        }
        Complaint::Slow(stream) => Line::of(["autopilot sends too little ", stream.name()]),
    }
}

/// A parameter that is not as it should be.
pub(super) fn parameter(finding: Finding) -> Line {
    match finding {
        Finding::Wrong(name, is, should) => {
            let (mut first, mut second) = ([0; DIGITS], [0; DIGITS]);
            Line::of([name, " is ", number(is, &mut first), ", set it to ", number(should, &mut second)])
        }
        Finding::Unknown(name) => Line::of([name, " is unknown to the autopilot"]),
    }
}

/// Fixes that do not come, or come again.
pub(super) fn fixes(news: watch::News) -> Line {
    match news {
        watch::News::Lost(seconds, reason) => {
            let mut digits = [0; DIGITS];
            let reason = reason.map_or("no_frames", Refusal::name);
            Line::of(["no fixes for ", whole(seconds.into(), &mut digits), " s: ", reason])
        }
        watch::News::Back => Line::new("fixes again"),
        watch::News::Disagrees(metres) => {
            let mut digits = [0; DIGITS];
            Line::of(["satellites disagree with the map by ", whole(metres.into(), &mut digits), " m"])
        }
        watch::News::Agrees => Line::new("satellites agree with the map again"),
        watch::News::Moved => Line::new("the EKF's origin has moved: fixes follow it"),
    }
}

/// What became of a set of sources.
pub(super) fn source_set(news: sources::News) -> Line {
    let (set, what) = match news {
        sources::News::Taken(set) => (set, " of the EKF is in use"),
        sources::News::Denied(set) => (set, " is denied by the autopilot"),
        sources::News::Unanswered(set) => (set, " is not acknowledged"),
    };
    let mut digits = [0; DIGITS];
    Line::of(["source set ", whole(set.into(), &mut digits), what])
}

/// Characters of a number at most.
const DIGITS: usize = 12;

/// A number in decimal digits.
fn whole(number: u32, digits: &mut [u8; DIGITS]) -> &str {
    decimal(number, 0, false, digits)
}

/// A number with up to two decimals, as far as it is one and not too large.
fn number(value: f32, digits: &mut [u8; DIGITS]) -> &str {
    // Beyond, single precision has no hundredths.
    const LARGEST: f32 = 99_999.0;
    if value.is_nan() || value.abs() > LARGEST {
        return "?";
    }
    let hundredths = (value.abs() * 100.0 + 0.5) as u32;
    let is_negative = value < 0.0 && hundredths > 0;
    if hundredths.is_multiple_of(100) {
        decimal(hundredths / 100, 0, is_negative, digits)
    } else if hundredths.is_multiple_of(10) {
        decimal(hundredths / 10, 1, is_negative, digits)
    } else {
        decimal(hundredths, 2, is_negative, digits)
    }
}

/// Decimal digits of a number, the last `decimals` of them behind a point.
fn decimal(number: u32, decimals: usize, is_negative: bool, digits: &mut [u8; DIGITS]) -> &str {
    let mut from = digits.len();
    let mut put = |byte: u8| {
        from = from.saturating_sub(1);
        if let Some(place) = digits.get_mut(from) {
            *place = byte;
        }
    };
    let (mut rest, mut count) = (number, 0);
    while rest > 0 || count <= decimals {
        if decimals > 0 && count == decimals {
            put(b'.');
        }
        put(b'0' + (rest % 10) as u8);
        (rest, count) = (rest / 10, count + 1);
    }
    if is_negative {
        put(b'-');
    }
    digits.get(from..).and_then(|used| core::str::from_utf8(used).ok()).unwrap_or("?")
}

#[cfg(test)]
mod tests {
    use super::{DIGITS, complaint, fixes, number, parameter, source_set, whole};
    use crate::app::Line;
    use crate::autopilot::parameters::Finding;
    use crate::autopilot::requests::{Complaint, Stream};
    use crate::autopilot::{sources, watch};
    use plumbline_core::pipeline::Refusal;

    extern crate std;
    use std::string::String;
    use std::vec::Vec;

    fn text(line: Line) -> String {
        String::from_utf8(line.0.into_iter().take_while(|byte| *byte != 0).collect::<Vec<_>>()).unwrap()
    }

    #[test]
    fn numbers_are_as_short_as_they_can_be() {
        for (value, wanted) in [
            (0.0, "0"),
            (6.0, "6"),
            (0.2, "0.2"),
            (1.25, "1.25"),
            (-0.5, "-0.5"),
            (-17.0, "-17"),
            (10.05, "10.05"),
            (99_999.0, "99999"),
            (1e9, "?"),
            (f32::NAN, "?"),
            (f32::NEG_INFINITY, "?"),
            (-0.001, "0"),
            (0.07, "0.07"),
        ] {
            assert_eq!(number(value, &mut [0; DIGITS]), wanted);
        }
        assert_eq!((whole(0, &mut [0; DIGITS]), whole(u32::MAX, &mut [0; DIGITS])), ("0", "4294967295"));
    }

    #[test]
    fn lines_say_what_is_wrong_and_what_is_right() {
        assert_eq!(text(parameter(Finding::Wrong("EK3_SRC2_POSXY", 3.0, 6.0))), "EK3_SRC2_POSXY is 3, set it to 6");
        assert_eq!(text(parameter(Finding::Wrong("VISO_POS_M_NSE", 1.5, 0.2))), "VISO_POS_M_NSE is 1.5, set it to 0.2");
        assert_eq!(text(parameter(Finding::Unknown("VISO_TYPE"))), "VISO_TYPE is unknown to the autopilot");
        let longest = text(parameter(Finding::Wrong("SIXTEEN_LETTERS_", -99_999.0, 99_999.0)));
        assert_eq!(longest, "SIXTEEN_LETTERS_ is -99999, set it to 99999");
        let lost = watch::News::Lost(10, Some(Refusal::LowScore));
        assert_eq!(text(fixes(lost)), "no fixes for 10 s: low_score");
        assert_eq!(text(fixes(watch::News::Lost(65_530, None))), "no fixes for 65530 s: no_frames");
        assert_eq!(text(fixes(watch::News::Back)), "fixes again");
        assert_eq!(text(fixes(watch::News::Disagrees(14))), "satellites disagree with the map by 14 m");
        assert_eq!(text(fixes(watch::News::Disagrees(u16::MAX))), "satellites disagree with the map by 65535 m");
        assert_eq!(text(fixes(watch::News::Agrees)), "satellites agree with the map again");
        assert_eq!(text(source_set(sources::News::Taken(2))), "source set 2 of the EKF is in use");
        assert_eq!(text(source_set(sources::News::Denied(2))), "source set 2 is denied by the autopilot");
        let denied = text(complaint(Complaint::Denied(Stream::Attitude, 5_000)));
        assert_eq!(denied, "attitude at 200 Hz denied: raise SCHED_LOOP_RATE");
    }
}
