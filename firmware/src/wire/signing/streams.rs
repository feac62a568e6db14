//! The newest time of each stream of signed messages: a sender's on one of its links.

use super::Verdict;
use super::clock::SECOND;
use heapless::Vec;

/// Streams that are known at a time: a vehicle has an autopilot, a ground station and a few devices. Chosen.
pub const STREAMS: usize = 8;
/// How far behind our own time the first message of a stream may be: a minute, as the specification has it.
pub const BEHIND: u64 = 60 * SECOND;

/// Who sends, and on which of its links.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    /// System id.
    pub system: u8,
    /// Component id.
    pub component: u8,
    /// Link id.
    pub link: u8,
}

/// The streams that are known, for ever: forgetting one would let its messages be replayed.
#[derive(Clone, Debug, Default)]
pub struct Streams(Vec<(Stream, u64), STREAMS>);

impl Streams {
    /// None known.
    pub const fn new() -> Self {
        Streams(Vec::new())
    }

    /// The verdict on a message whose signature holds. `own`: our own time.
    pub fn take(&mut self, stream: Stream, stamp: u64, own: u64) -> Verdict {
        if let Some((_, last)) = self.0.iter_mut().find(|(known, _)| *known == stream) {
            let is_newer = stamp > *last;
            *last = stamp.max(*last);
            return if is_newer { Verdict::Taken } else { Verdict::Replayed };
        }
        if stamp.saturating_add(BEHIND) < own {
            return Verdict::Late;
        }
        if self.0.push((stream, stamp)).is_ok() { Verdict::Taken } else { Verdict::Crowded }
    }
}

#[cfg(test)]
mod tests {
    use super::{BEHIND, STREAMS, Stream, Streams, Verdict};

    fn stream(link: u8) -> Stream {
        Stream { system: 1, component: 1, link }
    }

    #[test]
    fn a_time_is_taken_once_and_older_ones_no_more() {
        let mut streams = Streams::new();
        let verdicts = [100, 100, 99, 101, 101].map(|stamp| streams.take(stream(0), stamp, 0));
        let (taken, replayed) = (Verdict::Taken, Verdict::Replayed);
        assert_eq!(verdicts, [taken, replayed, replayed, taken, replayed]);
        // Each stream has a time of its own: other links, other components, other systems.
        for other in [stream(1), Stream { component: 2, ..stream(0) }, Stream { system: 2, ..stream(0) }] {
            assert_eq!(streams.take(other, 50, 0), Verdict::Taken);
        }
    }

    #[test]
    fn a_new_stream_is_a_minute_behind_at_most() {
        let own = 10 * BEHIND;
        let mut streams = Streams::new();
        assert_eq!(streams.take(stream(0), own - BEHIND - 1, own), Verdict::Late);
        assert_eq!(streams.take(stream(0), own - BEHIND, own), Verdict::Taken);
        // One that is known may be further behind: it has its own order.
        assert_eq!(streams.take(stream(0), own - BEHIND + 1, 2 * own), Verdict::Taken);
        assert_eq!(streams.take(stream(1), u64::MAX, own), Verdict::Taken);
    }

    #[test]
    fn what_is_late_takes_no_room_and_a_full_table_refuses_new_streams_alone() {
        let mut streams = Streams::new();
        for link in 0..50 {
            assert_eq!(streams.take(stream(link), 0, BEHIND + 1), Verdict::Late);
        }
        for link in 0..STREAMS as u8 {
            assert_eq!(streams.take(stream(link), 5, 0), Verdict::Taken);
        }
        assert_eq!(streams.take(stream(100), 5, 0), Verdict::Crowded);
        assert_eq!(streams.take(stream(0), 6, 0), Verdict::Taken);
        assert_eq!(streams.take(stream(0), 6, 0), Verdict::Replayed);
    }
}
