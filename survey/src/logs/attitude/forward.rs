//! Samples of a log put in order: what is no attitude, or not later than the one before, is left out.

use super::Sample;
use crate::logs::no_reboot;

/// Samples as far as they were taken.
#[derive(Debug, Default)]
pub(super) struct Forward {
    pub samples: Vec<Sample>,
    /// Not finite, or no rotation.
    none: usize,
    /// Not later than the one before.
    late: usize,
}

impl Forward {
    /// Takes the next sample: its instant, and roll, pitch, yaw.
    ///
    /// # Errors
    /// Time has gone back.
    pub fn take(&mut self, t_s: f64, [roll_rad, pitch_rad, yaw_rad]: [f64; 3]) -> Result<(), String> {
        if ![t_s, roll_rad, pitch_rad, yaw_rad].iter().all(|value| value.is_finite()) {
            self.none += 1;
            return Ok(());
        }
        if let Some(before) = self.samples.last() {
            no_reboot(before.t_s, t_s)?;
            if t_s <= before.t_s {
                self.late += 1;
                return Ok(());
            }
        }
        self.samples.push(Sample { t_s, roll_rad, pitch_rad, yaw_rad });
        Ok(())
    }

    /// The end of a sentence on what was left out.
    pub fn left_out(&self) -> String {
        let mut text = String::new();
        if self.none > 0 {
            text += &format!(", {} left out that are none", self.none);
        }
        if self.late > 0 {
            text += &format!(", {} left out that are not later than the one before", self.late);
        }
        text
    }
}
