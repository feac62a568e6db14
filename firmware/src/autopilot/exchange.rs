//! The time requests that are on their way: only what answers one of them is an answer.

/// Requests that may be on their way at once: at ten a second those of four tenths of a second, on a link whose round trip
/// takes tens of milliseconds.
const PENDING: usize = 4;

/// Their stamps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Exchange {
    sent_ns: [Option<i64>; PENDING],
}

impl Exchange {
    /// A request was sent; the oldest is given up for it.
    pub fn sent(&mut self, stamp_ns: i64) {
        self.sent_ns.rotate_right(1);
        if let Some(newest) = self.sent_ns.first_mut() {
            *newest = Some(stamp_ns);
        }
    }

    /// Whether an answer with this stamp answers one. It does so once.
    pub fn answers(&mut self, stamp_ns: i64) -> bool {
        let found = self.sent_ns.iter_mut().find(|sent| **sent == Some(stamp_ns));
        found.map(|sent| *sent = None).is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::{Exchange, PENDING};

    #[test]
    fn an_answer_counts_once_and_only_of_what_was_asked() {
        let mut exchange = Exchange::default();
        assert!(!exchange.answers(5));
        (1..=PENDING as i64).for_each(|stamp| exchange.sent(stamp));
        assert!(exchange.answers(2) && !exchange.answers(2) && exchange.answers(1));
        // The oldest is given up.
        (11..11 + PENDING as i64).for_each(|stamp| exchange.sent(stamp));
        assert!(!exchange.answers(3) && exchange.answers(11));
    }
}
