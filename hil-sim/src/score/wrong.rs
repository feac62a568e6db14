//! When a fix is wrong: `wrong_fixes` of `report.json`, and what the pages call so.

use super::{Scored, length};

/// A fix is wrong beyond the first, or beyond the second and so many of its own sigmas, pixels of the reference.
const WRONG_PX: f64 = 3.0;
const DOUBTFUL_PX: f64 = 1.5;
const WRONG_SIGMAS: f64 = 5.0;

impl Scored {
    /// Whether a fix misleads: it is off by more than an error of matching can be, or by more than it says and a pixel and a half.
    pub fn is_wrong(&self, resolution_m: f64) -> bool {
        let Some(off_px) = self.error_m.map(|error| length(error) / resolution_m) else { return false };
        off_px > WRONG_PX || off_px > DOUBTFUL_PX && self.nees.is_none_or(|nees| nees > WRONG_SIGMAS * WRONG_SIGMAS)
    }
}

/// What makes a fix wrong in words, after "off by".
pub fn meaning() -> String {
    format!("more than {WRONG_PX} px, or more than {WRONG_SIGMAS} of its own sigmas and {DOUBTFUL_PX} px")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wrong_is_what_is_far_off_or_farther_than_it_says() {
        let is_wrong = |off_px: f64, sigmas: f64| {
            let scored = Scored {
                frame: 0,
                accepted: true,
                truth_px: None,
                error_px: None,
                integer_px: None,
                raw_px: None,
                error_m: Some([0.0, 2.0 * off_px]),
                nees: Some(sigmas * sigmas),
                attitude_px: None,
                place: None,
                cost: None,
            };
            scored.is_wrong(2.0)
        };
        assert_eq!(
            [is_wrong(3.1, 1.0), is_wrong(2.9, 4.9), is_wrong(1.6, 5.1), is_wrong(1.4, 9.0)],
            [true, false, true, false]
        );
        assert_eq!(meaning(), "more than 3 px, or more than 5 of its own sigmas and 1.5 px");
    }
}
