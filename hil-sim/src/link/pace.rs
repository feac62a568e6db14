//! How long an answer may take: TCP's estimate of its round trip (RFC 6298, with Karn's rule).

use std::time::Duration;

/// Bounds of every wait on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Patience {
    /// First wait for an answer, before any was timed.
    pub first: Duration,
    /// Shortest wait.
    pub least: Duration,
    /// Longest wait before the request is sent again.
    pub most: Duration,
    /// How long nobody may answer at the beginning.
    pub hello: Duration,
    /// How long a board may be silent in flight.
    pub stall: Duration,
    /// How long a line may be unplugged, and a board may take to reboot.
    pub absence: Duration,
}

impl Default for Patience {
    /// For a line of 20 KB/s and more and a board that works on a frame for tens of milliseconds.
    fn default() -> Self {
        Patience {
            first: Duration::from_millis(500),
            least: Duration::from_millis(300),
            most: Duration::from_secs(2),
            hello: Duration::from_secs(5),
            stall: Duration::from_secs(10),
            absence: Duration::from_secs(10),
        }
    }
}

/// The running estimate for messages of about one length.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    smoothed: Option<(f64, f64)>,
    timeout: Duration,
}

impl Pace {
    /// Nothing timed yet.
    pub fn new(patience: &Patience) -> Self {
        Pace { smoothed: None, timeout: patience.first }
    }

    /// How long to wait for the next answer.
    pub fn timeout(&self) -> Duration {
        self.timeout
    }

    /// An answer came after `took`, to a request that was sent once.
    pub fn answered(&mut self, took: Duration, patience: &Patience) {
        let took_s = took.as_secs_f64();
        let (mean_s, spread_s) = match self.smoothed {
            None => (took_s, took_s / 2.0),
            Some((mean_s, spread_s)) => {
                (0.875 * mean_s + 0.125 * took_s, 0.75 * spread_s + 0.25 * (mean_s - took_s).abs())
            }
        };
        self.smoothed = Some((mean_s, spread_s));
        self.timeout = Duration::from_secs_f64(mean_s + 4.0 * spread_s).clamp(patience.least, patience.most);
    }

    /// None came in time: twice as long from now on, until one is timed again.
    pub fn missed(&mut self, patience: &Patience) {
        self.timeout = (2 * self.timeout).min(patience.most);
    }
}

#[cfg(test)]
mod tests {
    use super::{Pace, Patience};
    use std::time::Duration;

    /// By hand from RFC 6298: R = 1 s gives 1 + 4 · 0.5 = 3 s; then R = 2 s gives 1.125 + 4 · (0.375 + 0.25) = 3.625 s.
    #[test]
    fn the_estimate_is_that_of_the_rfc() {
        let patience = Patience { most: Duration::from_secs(60), ..Patience::default() };
        let mut pace = Pace::new(&patience);
        pace.missed(&patience);
        assert_eq!(pace.timeout(), Duration::from_secs(1));
        pace.answered(Duration::from_secs(1), &patience);
        assert_eq!(pace.timeout(), Duration::from_secs(3));
        pace.answered(Duration::from_secs(2), &patience);
        assert_eq!(pace.timeout(), Duration::from_millis(3625));
        for _ in 0..9 {
            pace.missed(&patience);
        }
        assert_eq!(pace.timeout(), patience.most);
        for _ in 0..99 {
            pace.answered(Duration::from_micros(30), &patience);
        }
        assert_eq!(pace.timeout(), patience.least);
    }
}
