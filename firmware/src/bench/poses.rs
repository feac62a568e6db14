//! Attitudes to find the worst: every heading in steps, several tilts, with a camera that follows and one that does not.

use core::fmt;
use plumbline_core::tilt::{Attitude, follow_up_command};
use plumbline_core::units::Radians;

/// An attitude and a follow-up angle, degrees where they are printed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Clockwise from north, degrees.
    pub heading_deg: u16,
    /// Nose up and right wing down, degrees.
    pub pitch_roll_deg: (i8, i8),
    /// Whether the camera follows exactly, else it is fixed to the body: β = 0.
    pub is_followed: bool,
}

/// Degrees between headings.
const HEADING_STEP_DEG: u16 = 15;
/// Pitch and roll of what is otherwise quoted, and tilts up to the largest.
const TILTS_DEG: [(i8, i8); 4] = [(8, 10), (0, 0), (10, 0), (30, 0)];

impl Pose {
    /// All poses.
    pub fn all() -> impl Iterator<Item = Pose> {
        [true, false].into_iter().flat_map(|is_followed| {
            TILTS_DEG.into_iter().flat_map(move |pitch_roll_deg| {
                let headings = (0..360).step_by(HEADING_STEP_DEG as usize);
                headings.map(move |heading_deg| Pose { heading_deg, pitch_roll_deg, is_followed })
            })
        })
    }

    /// The attitude.
    pub fn attitude(&self) -> Attitude {
        let (pitch, roll) = self.pitch_roll_deg;
        Attitude {
            heading: Radians::from_degrees(f32::from(self.heading_deg)).wrapped(),
            pitch: Radians::from_degrees(f32::from(pitch)),
            roll: Radians::from_degrees(f32::from(roll)),
        }
    }

    /// The follow-up angle.
    pub fn follow_up(&self) -> Radians {
        if self.is_followed { follow_up_command(self.attitude()) } else { Radians(0.0) }
    }
}

impl fmt::Display for Pose {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (pitch, roll) = self.pitch_roll_deg;
        let follow_up = if self.is_followed { "followed" } else { "0" };
        write!(f, "heading {} pitch {pitch} roll {roll} beta {follow_up}", self.heading_deg)
    }
}
