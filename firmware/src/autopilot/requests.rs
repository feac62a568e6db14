//! What the autopilot is asked for: that it sends what the application lives on, at the rates that it wants.
//!
//! Autopilots send a companion everything once a second and what matters to us not at all, unless asked by
//! MAV_CMD_SET_MESSAGE_INTERVAL. What came of it shows in what arrives: each stream is counted, and asked for again while it
//! is slower than wanted. So neither a reboot of either side nor a lost command needs an event of its own. A rate that is
//! denied as too fast is asked for at half; one command is on its way at a time, since an acknowledgement does not say which
//! message's interval it means.

use crate::wire::command::{
    ACCEPTED, Ask, DENIED, IN_PROGRESS, REQUEST_MESSAGE, SET_MESSAGE_INTERVAL, TEMPORARILY_REJECTED, UNSUPPORTED,
};
use plumbline_core::units::Ticks;

/// Streams that are asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stream {
    /// AUTOPILOT_STATE_FOR_GIMBAL_DEVICE: attitude, stamped in microseconds.
    Attitude,
    /// ATTITUDE_QUATERNION: attitude, stamped in milliseconds; where the other is not to be had.
    CoarseAttitude,
    /// GLOBAL_POSITION_INT.
    Position,
    /// DISTANCE_SENSOR.
    Range,
    /// LOCAL_POSITION_NED: the height that goes into a fix.
    Local,
    /// GPS_RAW_INT: whether satellite navigation works.
    Gnss,
}

impl Stream {
    /// In the order in which they are asked for.
    pub const ALL: [Stream; 6] =
        [Stream::Attitude, Stream::CoarseAttitude, Stream::Position, Stream::Range, Stream::Local, Stream::Gnss];

    /// The message's id.
    pub fn message(self) -> u32 {
        match self {
            Stream::Attitude => 286,
            Stream::CoarseAttitude => 31,
            Stream::Position => 33,
            Stream::Range => 132,
            Stream::Local => 32,
            Stream::Gnss => 24,
        }
    }

    /// Its name for the pilot.
    pub fn name(self) -> &'static str {
        match self {
            Stream::Attitude | Stream::CoarseAttitude => "attitude",
            Stream::Position => "position",
            Stream::Range => "range",
            Stream::Local => "local position",
            Stream::Gnss => "GNSS state",
        }
    }

    /// Whether it arrives whatever the vehicle does. The local position begins with a position, a range finder may be
    /// elsewhere.
    fn is_always_there(self) -> bool {
        matches!(self, Stream::Attitude | Stream::CoarseAttitude | Stream::Position)
    }
}

/// GPS_GLOBAL_ORIGIN.
const ORIGIN: u32 = 49;
/// How long a stream is counted before its rate is judged: at 5 Hz ten samples.
const WINDOW_TICKS: u32 = 2_000_000;
/// A stream counts as slow below so many tenths of what is wanted. Rates are made of whole loops, and the last sample of a
/// window may be late; half of what is wanted is far below.
const SLOW_TENTHS: u32 = 8;
/// How long a command's acknowledgement is waited for: ArduPilot answers within a loop, links within tens of milliseconds.
const ANSWER_TICKS: u32 = 1_000_000;
/// Between two requests for the origin: often while it is not known, and now and then, since who sets it anew need not say so.
const ORIGIN_TICKS: [u32; 2] = [2_000_000, 10_000_000];
/// Longest interval that is asked for: what an autopilot sends unasked.
const INTERVAL_MAX_US: u32 = 1_000_000;
/// Windows in vain after which the other attitude is asked for, and after which the pilot is told.
const VAIN_WINDOWS: u8 = 3;

/// A stream and what came of it.
#[derive(Clone, Copy, Debug)]
struct Subscription {
    /// Wanted from one sample to the next, microseconds; 0 for one that is not wanted.
    wanted_us: u32,
    /// What is asked for: the same, or longer where that was denied.
    asked_us: u32,
    /// Samples in this window.
    count: u32,
    /// Slow windows in a row.
    vain: u8,
    is_due: bool,
}

/// What the pilot is to be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Complaint {
    /// The autopilot denies a stream at this interval in microseconds.
    Denied(Stream, u32),
    /// A stream does not come, or too slowly, though it was asked for.
    Slow(Stream),
}

/// All requests.
#[derive(Debug)]
pub struct Requests {
    streams: [Subscription; Stream::ALL.len()],
    /// The command on its way: its number, its stream, and when it was sent.
    waiting: Option<(u16, Option<Stream>, Ticks)>,
    window_since: Option<Ticks>,
    origin_asked: Option<Ticks>,
    complaint: Option<Complaint>,
}

/// Nominal intervals, microseconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Intervals {
    /// Attitude.
    pub attitude_us: u32,
    /// Position.
    pub position_us: u32,
    /// Slant range.
    pub range_us: u32,
}

/// Height for the fix, and the state of satellite navigation: ten and five times a second.
const LOCAL_US: u32 = 100_000;
const GNSS_US: u32 = 200_000;

impl Requests {
    /// Nothing asked yet.
    pub fn new(intervals: &Intervals) -> Self {
        let wanted = |stream| match stream {
            Stream::Attitude => intervals.attitude_us,
            // Once the other does not come.
            Stream::CoarseAttitude => 0,
            Stream::Position => intervals.position_us,
            Stream::Range => intervals.range_us,
            Stream::Local => LOCAL_US,
            Stream::Gnss => GNSS_US,
        };
        let streams = Stream::ALL.map(wanted).map(|us: u32| {
            let us = us.min(INTERVAL_MAX_US);
            Subscription { wanted_us: us, asked_us: us, count: 0, vain: 0, is_due: us > 0 }
        });
        Requests { streams, waiting: None, window_since: None, origin_asked: None, complaint: None }
    }

    fn of(&mut self, stream: Stream) -> Option<&mut Subscription> {
        Stream::ALL.iter().zip(&mut self.streams).find(|(other, _)| **other == stream).map(|(_, found)| found)
    }

    /// A sample of a stream arrived.
    pub fn arrived(&mut self, stream: Stream) {
        if let Some(subscription) = self.of(stream) {
            subscription.count = subscription.count.saturating_add(1);
        }
    }

    /// A command was acknowledged.
    pub fn acknowledged(&mut self, command: u16, result: u8) {
        let Some((waiting, stream, _)) = self.waiting else { return };
        if waiting != command || result == IN_PROGRESS {
            return;
        }
        self.waiting = None;
        let Some(stream) = stream else { return };
        let Some(subscription) = self.of(stream) else { return };
        match result {
            ACCEPTED => {}
            TEMPORARILY_REJECTED => subscription.is_due = true,
            DENIED | UNSUPPORTED if stream == Stream::Attitude => self.take_coarse_attitude(),
            _ => {
                let denied_us = subscription.asked_us;
                subscription.asked_us = (2 * denied_us).min(INTERVAL_MAX_US);
                subscription.is_due = subscription.asked_us > denied_us;
                self.complaint = Some(Complaint::Denied(stream, denied_us));
            }
        }
    }

    /// What is to be sent on this beat, where the autopilot is there; at most one command. Whether the origin is known decides
    /// how often it is asked for.
    pub fn next(&mut self, now: Ticks, is_origin_known: bool) -> Option<Ask> {
        let since = |then: Ticks| now.0.wrapping_sub(then.0);
        let began = *self.window_since.get_or_insert(now);
        if since(began) >= WINDOW_TICKS {
            self.judge(since(began));
            self.window_since = Some(now);
        }
        if self.waiting.is_some_and(|(_, _, sent)| since(sent) < ANSWER_TICKS) {
            return None;
        }
        self.waiting = None;
        let due = Stream::ALL.iter().zip(&mut self.streams).find(|(_, stream)| stream.is_due && stream.wanted_us > 0);
        if let Some((stream, subscription)) = due {
            subscription.is_due = false;
            let interval_us = subscription.asked_us;
            self.waiting = Some((SET_MESSAGE_INTERVAL, Some(*stream), now));
            return Some(Ask::Interval(stream.message(), interval_us));
        }
        let [often, rarely] = ORIGIN_TICKS;
        let every = if is_origin_known { rarely } else { often };
        if self.origin_asked.is_none_or(|asked| since(asked) >= every) {
            self.origin_asked = Some(now);
            self.waiting = Some((REQUEST_MESSAGE, None, now));
            return Some(Ask::Message(ORIGIN));
        }
        None
    }

    /// Whether each stream came as fast as it was asked for in the last `ticks`; what did not is asked for again.
    fn judge(&mut self, ticks: u32) {
        let mut wants_coarse = false;
        let mut complaint = None;
        for (stream, subscription) in Stream::ALL.iter().zip(&mut self.streams) {
            let expected = ticks.checked_div(subscription.asked_us).unwrap_or(0);
            let is_slow = 10 * subscription.count < SLOW_TENTHS * expected;
            subscription.count = 0;
            subscription.vain = if is_slow { subscription.vain.saturating_add(1) } else { 0 };
            subscription.is_due |= is_slow;
            if subscription.vain == VAIN_WINDOWS {
                wants_coarse |= *stream == Stream::Attitude;
                if *stream != Stream::Attitude && stream.is_always_there() {
                    complaint = Some(Complaint::Slow(*stream));
                }
            }
        }
        if wants_coarse {
            self.take_coarse_attitude();
        }
        self.complaint = self.complaint.or(complaint);
    }

    /// Asks for the other attitude instead.
    fn take_coarse_attitude(&mut self) {
        let wanted_us = self.of(Stream::Attitude).map_or(0, |fine| {
            (fine.is_due, fine.asked_us) = (false, 0);
            core::mem::take(&mut fine.wanted_us)
        });
        if let Some(coarse) = self.of(Stream::CoarseAttitude).filter(|_| wanted_us > 0) {
            *coarse = Subscription { wanted_us, asked_us: wanted_us, count: 0, vain: 0, is_due: true };
        }
    }

    /// What the pilot is to be told, once.
    pub fn complaint(&mut self) -> Option<Complaint> {
        self.complaint.take()
    }
}

#[cfg(test)]
mod tests {
    use super::{Complaint, Intervals, ORIGIN, Requests, Stream};
    use crate::wire::command::{ACCEPTED, Ask, DENIED, REQUEST_MESSAGE, SET_MESSAGE_INTERVAL};
    use plumbline_core::units::Ticks;

    extern crate std;
    use std::collections::BTreeMap;
    use std::vec::Vec;

    const INTERVALS: Intervals = Intervals { attitude_us: 5_000, position_us: 200_000, range_us: 20_000 };
    /// MAV_RESULT_FAILED, ArduPilot's answer to what is too fast.
    const FAILED: u8 = 4;
    const BEAT_TICKS: u32 = 100_000;

    /// An autopilot that sends what it is asked for, up to a rate, and knows some messages only.
    struct Partner {
        fastest_us: u32,
        unknown: &'static [u32],
        streams: BTreeMap<u32, u32>,
        asked: Vec<Ask>,
        is_deaf: bool,
    }

    impl Partner {
        fn new(fastest_us: u32, unknown: &'static [u32]) -> Self {
            Partner { fastest_us, unknown, streams: BTreeMap::new(), asked: Vec::new(), is_deaf: false }
        }

        /// One beat of `requests`, and what arrives until the next.
        fn beat(&mut self, requests: &mut Requests, now: Ticks, is_origin_known: bool) {
            let ask = requests.next(now, is_origin_known);
            self.asked.extend(ask);
            match ask {
                Some(Ask::Interval(message, interval_us)) if !self.is_deaf => {
                    let result = if self.unknown.contains(&message) {
                        DENIED
                    } else if interval_us < self.fastest_us {
                        FAILED
                    } else {
                        self.streams.insert(message, interval_us);
                        ACCEPTED
                    };
                    requests.acknowledged(SET_MESSAGE_INTERVAL, result);
                }
                Some(Ask::Message(_)) if !self.is_deaf => requests.acknowledged(REQUEST_MESSAGE, ACCEPTED),
                _ => {}
            }
            for stream in Stream::ALL {
                let count = self.streams.get(&stream.message()).map_or(0, |us| BEAT_TICKS / us);
                (0..count).for_each(|_| requests.arrived(stream));
            }
        }

        fn beats(&mut self, requests: &mut Requests, from: u32, count: u32) {
            (from..from + count).for_each(|beat| self.beat(requests, Ticks(beat.wrapping_mul(BEAT_TICKS)), true));
        }

        fn intervals(&self) -> Vec<(u32, u32)> {
            let interval = |ask: &Ask| if let Ask::Interval(message, us) = ask { Some((*message, *us)) } else { None };
            self.asked.iter().filter_map(interval).collect()
        }
    }

    #[test]
    fn every_stream_is_asked_for_once_where_it_comes() {
        let (mut requests, mut partner) = (Requests::new(&INTERVALS), Partner::new(1, &[]));
        // The timer wraps meanwhile.
        partner.beats(&mut requests, 42_900, 120);
        let wanted = [(286, 5_000), (33, 200_000), (132, 20_000), (32, 100_000), (24, 200_000)];
        // Of a stream slower than a beat whole samples arrive only: those of 5 Hz are none here.
        let asked: Vec<_> = partner.intervals().into_iter().filter(|(_, us)| *us < 200_000).collect();
        assert_eq!(asked, wanted.into_iter().filter(|(_, us)| *us < 200_000).collect::<Vec<_>>());
        assert!(wanted.iter().all(|stream| partner.intervals().contains(stream)));
        assert_eq!(partner.asked.iter().filter(|ask| **ask == Ask::Message(ORIGIN)).count(), 2, "every ten seconds");
    }

    #[test]
    fn an_autopilot_that_boots_anew_is_asked_again() {
        let (mut requests, mut partner) = (Requests::new(&INTERVALS), Partner::new(1, &[]));
        partner.beats(&mut requests, 0, 100);
        (partner.streams, partner.asked) = (BTreeMap::new(), Vec::new());
        partner.beats(&mut requests, 100, 50);
        assert!([286, 132, 32].iter().all(|message| partner.streams.contains_key(message)), "{:?}", partner.streams);
    }

    #[test]
    fn what_is_denied_as_too_fast_is_asked_for_at_half() {
        // A loop of 50 Hz, to which 50 Hz are too fast.
        let (mut requests, mut partner) = (Requests::new(&INTERVALS), Partner::new(20_001, &[]));
        let mut complaints = Vec::new();
        for beat in 0..40 {
            partner.beats(&mut requests, beat, 1);
            complaints.extend(requests.complaint());
        }
        assert_eq!(partner.streams.get(&286), Some(&40_000));
        assert_eq!(partner.streams.get(&132), Some(&40_000));
        assert!(complaints.contains(&Complaint::Denied(Stream::Attitude, 5_000)), "{complaints:?}");
    }

    #[test]
    fn the_other_attitude_is_taken_where_the_first_is_unknown_or_does_not_come() {
        let (mut requests, mut partner) = (Requests::new(&INTERVALS), Partner::new(1, &[286]));
        partner.beats(&mut requests, 0, 20);
        assert_eq!((partner.streams.get(&31), partner.streams.get(&286)), (Some(&5_000), None));
        assert_eq!(requests.complaint(), None);
        // Acknowledged, and never sent.
        let (mut requests, mut partner) = (Requests::new(&INTERVALS), Partner::new(1, &[]));
        for beat in 0..80 {
            partner.beats(&mut requests, beat, 1);
            partner.streams.remove(&286);
        }
        assert_eq!(partner.streams.get(&31), Some(&5_000));
    }

    #[test]
    fn one_command_is_on_its_way_at_a_time() {
        let (mut requests, mut partner) = (Requests::new(&INTERVALS), Partner::new(1, &[]));
        partner.is_deaf = true;
        partner.beats(&mut requests, 0, 50);
        // One a second, until it answers; and an acknowledgement of another command is none.
        assert_eq!(partner.asked.len(), 5, "{:?}", partner.asked);
        requests.acknowledged(400, ACCEPTED);
        partner.beats(&mut requests, 51, 1);
        assert_eq!(partner.asked.len(), 6);
        partner.beats(&mut requests, 52, 1);
        assert_eq!(partner.asked.len(), 6);
    }
}
