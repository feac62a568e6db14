//! What the board tells the pilot of satellite navigation, and when.

use crate::vehicle::aloft::moment::ToldOfGnss;

/// Reads the lines.
#[derive(Debug, Default)]
pub(super) struct Told {
    lines: usize,
    pub(super) gnss: ToldOfGnss,
}

impl Told {
    /// Those that have come since the last time, at an instant.
    pub(super) fn read(&mut self, lines: &[String], at_us: u64) {
        let at_s = 1e-6 * at_us as f64;
        for line in lines.get(self.lines..).unwrap_or_default() {
            if let Some(metres) = line.strip_prefix("satellites disagree with the map by ") {
                let offset_m = metres.strip_suffix(" m").and_then(|metres| metres.parse().ok());
                self.gnss.offset_m = self.gnss.offset_m.or(offset_m);
                self.gnss.disagreed_at_s = self.gnss.disagreed_at_s.or(Some(at_s));
            } else if line == "satellites agree with the map again" {
                self.gnss.agreed_at_s = Some(at_s);
            }
        }
        self.lines = lines.len();
    }
}

#[cfg(test)]
mod tests {
    use super::{Told, ToldOfGnss};

    #[test]
    fn the_first_begin_and_the_last_end_count() {
        let mut told = Told::default();
        let line = str::to_owned;
        let (by, again) = ("satellites disagree with the map by ", "satellites agree with the map again");
        let mut lines = vec![line("fixes again"), format!("{by}14 m")];
        told.read(&lines, 20_000_000);
        told.read(&lines, 21_000_000);
        lines.extend([line(again), format!("{by}30 m")]);
        told.read(&lines, 50_000_000);
        lines.push(line(again));
        told.read(&lines, 60_000_000);
        let wanted = ToldOfGnss { disagreed_at_s: Some(20.0), offset_m: Some(14.0), agreed_at_s: Some(60.0) };
        assert_eq!(told.gnss, wanted);
    }
}
