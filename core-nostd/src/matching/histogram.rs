//! Medians by counting: exact to a bin, one pass, a kilobyte of stack.

/// Counts in 256 bins.
pub(super) struct Histogram {
    counts: [u32; 256],
    total: u32,
}

impl Histogram {
    /// Empty.
    pub(super) fn new() -> Self {
        Histogram { counts: [0; 256], total: 0 }
    }

    /// Empty again.
    pub(super) fn clear(&mut self) {
        *self = Histogram::new();
    }

    /// Counts one value.
    #[inline(always)]
    pub(super) fn add(&mut self, bin: u8) {
        self.counts[bin as usize] += 1;
        self.total += 1;
    }

    /// Where half of the values lie below, in bins: bin k reaches from k to k + 1. 0 when nothing was counted.
    pub(super) fn median(&self) -> f32 {
        self.quantile(0.5)
    }

    /// Where `part` of the values lie below, in bins.
    pub(super) fn quantile(&self, part: f32) -> f32 {
        quantile(self.counts.iter().copied(), part * self.total as f32)
    }

    /// The median of sizes, where bin 255 - k counts the values of bin k with the other sign.
    pub(super) fn folded_median(&self) -> f32 {
        let sizes = self.counts.iter().zip(self.counts.iter().rev()).take(128).map(|(a, b)| a + b);
        quantile(sizes, 0.5 * self.total as f32)
    }
}

/// Where `wanted` of the counted values lie below, in bins; 0 when nothing was counted.
fn quantile(counts: impl Iterator<Item = u32>, wanted: f32) -> f32 {
    let (mut below, whole) = (0, wanted as u32);
    for (bin, count) in counts.enumerate() {
        if count > 0 && below + count >= whole && (below + count) as f32 >= wanted {
            return bin as f32 + (wanted - below as f32) / count as f32;
        }
        below += count;
    }
    0.0
}

#[cfg(test)]
mod tests {
    use super::Histogram;

    #[test]
    fn the_median_lies_within_its_bin() {
        let mut histogram = Histogram::new();
        assert!(histogram.median() == 0.0);
        for bin in [3, 3, 3, 3] {
            histogram.add(bin);
        }
        assert!(histogram.median() == 3.5);
        for bin in [0, 200, 201, 202, 255] {
            histogram.add(bin);
        }
        // Four and a half of nine: one below bin 3, three and a half of its four.
        assert!((histogram.median() - 3.875).abs() < 1e-6);
    }
}
