//! The order and direction in which strips are flown.

use super::lines::Strip;

/// A strip on its way.
#[derive(Debug, Clone, Copy)]
pub struct Leg<'s> {
    /// The strip.
    pub strip: &'s Strip,
    /// Whether it is flown from its high end.
    pub is_back: bool,
}

impl Leg<'_> {
    /// Place along of the first exposure.
    #[must_use]
    pub fn from_m(&self) -> f64 {
        self.end(self.is_back)
    }

    /// Place along of the last exposure.
    #[must_use]
    pub fn to_m(&self) -> f64 {
        self.end(!self.is_back)
    }

    /// Where the way begins and ends: so far before the first exposure and behind the last.
    #[must_use]
    pub fn led(&self, out_m: f64) -> [f64; 2] {
        let out_m = if self.is_back { -out_m } else { out_m };
        [self.from_m() - out_m, self.to_m() + out_m]
    }

    /// The waypoints between two positions in the direction of flight: along, and height above the level flying height, ends included.
    #[must_use]
    pub fn way(&self, [from_m, to_m]: [f64; 2]) -> Vec<[f64; 2]> {
        let course = &self.strip.course;
        let point = |at: f64| [at, course.rise_m(at)];
        let mut way = vec![point(from_m.min(to_m))];
        way.extend(course.between(from_m.min(to_m), from_m.max(to_m)));
        way.push(point(from_m.max(to_m)));
        if self.is_back {
            way.reverse();
        }
        way
    }

    /// Exposures have at least one position.
    fn end(&self, is_high: bool) -> f64 {
        let along_m = &self.strip.along_m;
        if is_high { along_m[along_m.len() - 1] } else { along_m[0] }
    }
}

/// Strips line by line, every other line backwards, the parts of a line in the order in which they are met.
pub fn flown(strips: &[Strip]) -> impl Iterator<Item = Leg<'_>> {
    strips.chunk_by(|a, b| a.line == b.line).flat_map(|parts| {
        let is_back = !parts[0].line.is_multiple_of(2);
        (0..parts.len()).map(move |k| {
            let part = if is_back { parts.len() - 1 - k } else { k };
            Leg { strip: &parts[part], is_back }
        })
    })
}
