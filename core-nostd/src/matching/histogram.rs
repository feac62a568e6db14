//! Quartiles of grey levels, and the limits beyond which a grey says "different", not "how different".

/// Counts of grey levels.
pub(super) struct Histogram {
    counts: [u32; 256],
    total: u32,
}

impl Histogram {
    /// Empty.
    pub(super) fn new() -> Self {
        Histogram { counts: [0; 256], total: 0 }
    }

    /// Counts `pixels`.
    pub(super) fn add(&mut self, pixels: &[u8]) {
        for &pixel in pixels {
            self.counts[pixel as usize] += 1;
        }
        self.total += pixels.len() as u32;
    }

    /// Lower quartile, median, upper quartile.
    pub(super) fn quartiles(&self) -> [f32; 3] {
        let mut quartiles = [0.0; 3];
        let (mut below, mut next) = (0, 0);
        for (grey, &count) in self.counts.iter().enumerate() {
            below += count;
            while next < 3 && 4 * below >= (next + 1) * self.total {
                quartiles[next as usize] = grey as f32;
                next += 1;
            }
        }
        quartiles
    }
}

/// Greys between which a picture is believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    low: u8,
    high: u8,
}

impl Limits {
    /// Nothing is limited.
    pub const NONE: Limits = Limits { low: 0, high: u8::MAX };

    /// One quartile range beyond the quartiles: a normal distribution loses 4 % of its pixels at each end, a picture of
    /// two halves nothing.
    pub(super) fn of(histogram: &Histogram) -> Self {
        let [lower, _, upper] = histogram.quartiles();
        let range = (upper - lower).max(2.0);
        Limits { low: (lower - range).max(0.0) as u8, high: (upper + range).min(255.0) as u8 }
    }

    /// `grey` within the limits.
    #[inline(always)]
    pub(super) fn apply(self, grey: u8) -> u8 {
        grey.max(self.low).min(self.high)
    }
}
