//! What of a log could not be read.

/// Bytes that are no records.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Damage {
    /// Passed over in the middle, with the records among them.
    pub skipped: usize,
    /// In how many places.
    pub places: usize,
    /// Of a record that the file's end cuts off.
    pub cut: usize,
    /// Milliseconds that the logger itself says it had no room for.
    pub dropped_ms: u64,
    /// How often it says so.
    pub dropouts: usize,
}

impl Damage {
    /// Bytes that are passed over in one place.
    pub fn skip(&mut self, bytes: usize) {
        self.skipped += bytes;
        self.places += 1;
    }

    /// What a user has to know of it.
    pub fn sentence(&self) -> Option<String> {
        let mut parts = Vec::new();
        if self.skipped > 0 {
            let places = if self.places == 1 { "1 place".to_owned() } else { format!("{} places", self.places) };
            parts.push(format!("{} bytes in {places} are damaged and were skipped", self.skipped));
        }
        if self.cut > 0 {
            parts.push(format!("the log ends within a record, whose {} bytes were left out", self.cut));
        }
        if self.dropouts > 0 {
            parts.push(format!(
                "the logger dropped {:.3} s in {} places",
                self.dropped_ms as f64 * 1e-3,
                self.dropouts
            ));
        }
        (!parts.is_empty()).then(|| parts.join("; "))
    }
}
