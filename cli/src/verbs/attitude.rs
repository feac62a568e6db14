//! Attitude and follow-up angle as options, the same for every verb.

use super::finite;
use crate::outcome::Failure;
use plumbline_core::tilt::{Attitude, follow_up_command};
use plumbline_core::units::Radians;
use plumbline_survey::error::InputError;
use plumbline_survey::logs::units::GIMBAL_DEG;

#[derive(Debug, clap::Args)]
pub struct AttitudeArgs {
    /// Heading, degrees clockwise from north
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    heading_deg: f64,
    /// Pitch, degrees, nose up positive
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    pitch_deg: f64,
    /// Roll, degrees, right wing down positive
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    roll_deg: f64,
    /// Follow-up angle of the camera about the vehicle's up axis, degrees counter-clockwise from above; `auto`: it
    /// follows exactly, `none`: it does not turn
    #[arg(long, default_value = "auto", value_parser = follow_up, allow_negative_numbers = true)]
    follow_up_deg: FollowUp,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FollowUp {
    Auto,
    None,
    Degrees(f64),
}

/// A follow-up angle as an option.
pub fn follow_up(text: &str) -> Result<FollowUp, String> {
    match text {
        "auto" => Ok(FollowUp::Auto),
        "none" => Ok(FollowUp::None),
        _ => finite(text).map(FollowUp::Degrees).map_err(|_| "auto, none or a finite number of degrees".to_owned()),
    }
}

impl FollowUp {
    /// The angle in f64 radians, given the exact one.
    pub fn radians(self, exact_rad: f64) -> f64 {
        match self {
            FollowUp::Auto => exact_rad,
            FollowUp::None => 0.0,
            FollowUp::Degrees(degrees) => (degrees % 360.0).to_radians(),
        }
    }
}

/// A follow-up angle nearer than this to the exact one is the followed one.
const FOLLOWED_DEG: f64 = 1e-3;

impl AttitudeArgs {
    /// Heading, pitch and roll, degrees, and the follow-up angle.
    pub fn new([heading_deg, pitch_deg, roll_deg]: [f64; 3], follow_up_deg: FollowUp) -> Self {
        AttitudeArgs { heading_deg, pitch_deg, roll_deg, follow_up_deg }
    }

    /// Heading, pitch, roll in f64 radians, for the oracle.
    pub fn angles_rad(&self) -> [f64; 3] {
        // Whole turns are taken off before the conversion, so that any finite heading keeps its precision.
        [self.heading_deg % 360.0, self.pitch_deg % 360.0, self.roll_deg % 360.0].map(f64::to_radians)
    }

    /// The attitude, with the optical axis below the horizon.
    pub fn attitude(&self) -> Result<Attitude, Failure> {
        let [heading, pitch, roll] = self.angles_rad().map(|angle| Radians(angle as f32));
        let attitude = Attitude { heading, pitch, roll };
        for (option, degrees) in [("--pitch-deg", self.pitch_deg), ("--roll-deg", self.roll_deg)] {
            if degrees.abs() > 360.0 {
                return Err(Failure::Input(InputError::new(format!(
                    "{option} {degrees}: not between -360 and 360 degrees"
                ))));
            }
        }
        let [_, pitch_rad, roll_rad] = self.angles_rad();
        if pitch_rad.cos() < 1e-3 || roll_rad.cos() < 1e-3 {
            return Err(Failure::Input(InputError::new(format!(
                "--pitch-deg {} --roll-deg {}: the camera looks at or above the horizon{}",
                self.pitch_deg,
                self.roll_deg,
                self.gimbal()
            ))));
        }
        Ok(attitude)
    }

    /// The attitude of a camera that takes a picture of the ground.
    ///
    /// # Errors
    /// As [`Self::attitude`]; a pitch that is that of a gimbal, whose -90 looks down.
    pub fn looking_down(&self) -> Result<Attitude, Failure> {
        let attitude = self.attitude()?;
        let gimbal = self.gimbal();
        if gimbal.is_empty() {
            return Ok(attitude);
        }
        let what = "the camera looks nearly at the horizon";
        Err(Failure::Input(InputError::new(format!("--pitch-deg {}: {what}{gimbal}", self.pitch_deg))))
    }

    /// What was likely meant by a pitch near -90.
    fn gimbal(&self) -> String {
        if (-95.0..=-GIMBAL_DEG).contains(&self.pitch_deg) {
            // As many digits as were given.
            let meant = (1e6 * (self.pitch_deg + 90.0)).round() / 1e6;
            return format!(
                "; 0 is a camera that looks straight down: for a gimbal's pitch of {} write --pitch-deg {meant}",
                self.pitch_deg
            );
        }
        String::new()
    }

    /// The follow-up angle to use in f64 radians, given the exact one.
    pub fn follow_up_rad(&self, exact_rad: f64) -> f64 {
        self.follow_up_deg.radians(exact_rad)
    }

    /// The core's follow-up angle.
    pub fn follow_up(&self, attitude: Attitude) -> Radians {
        match self.follow_up_deg {
            FollowUp::Auto => follow_up_command(attitude),
            _ => Radians(self.follow_up_rad(0.0) as f32),
        }
    }

    /// Whether the angle is the one that eq. 7 presumes.
    pub fn is_followed(&self, attitude: Attitude) -> bool {
        let off = Radians(self.follow_up(attitude).0 - follow_up_command(attitude).0).wrapped();
        f64::from(off.to_degrees().abs()) < FOLLOWED_DEG
    }
}
