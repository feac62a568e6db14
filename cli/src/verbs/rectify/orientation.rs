//! How the camera is turned: as a vehicle's attitude, or by aerotriangulation.

use crate::outcome::Failure;
use crate::verbs::attitude::{AttitudeArgs, FollowUp, follow_up};
use crate::verbs::finite;
use plumbline_core::camera::Camera;
use plumbline_core::homography::Homography;
use plumbline_core::tilt::{Attitude, camera_from_local, equivalent_tilt, follow_up_command};
use plumbline_core::units::Radians;
use plumbline_sim::camera::oriented::Exterior;
use plumbline_survey::error::InputError;

#[derive(Debug, clap::Args)]
pub struct OrientationArgs {
    /// Heading, degrees clockwise from north (with a position: from grid north)
    #[arg(long, value_parser = finite, requires_all = ["pitch_deg", "roll_deg"], allow_negative_numbers = true)]
    heading_deg: Option<f64>,
    /// Pitch, degrees, nose up positive
    #[arg(long, value_parser = finite, requires = "heading_deg", allow_negative_numbers = true)]
    pitch_deg: Option<f64>,
    /// Roll, degrees, right wing down positive
    #[arg(long, value_parser = finite, requires = "heading_deg", allow_negative_numbers = true)]
    roll_deg: Option<f64>,
    /// Follow-up angle of the camera about the vehicle's up axis, degrees counter-clockwise from above; `auto`, as without the
    /// option: it follows exactly, `none`: it does not turn
    #[arg(long, value_parser = follow_up, requires = "heading_deg", allow_negative_numbers = true)]
    follow_up_deg: Option<FollowUp>,
    /// Instead of heading, pitch and roll: omega, degrees, of R = R_omega R_phi R_kappa; camera x right, y up in the picture, z
    /// backwards
    #[arg(long, value_parser = finite, requires_all = ["phi_deg", "kappa_deg"], conflicts_with = "heading_deg", allow_negative_numbers = true)]
    omega_deg: Option<f64>,
    /// Phi, degrees
    #[arg(long, value_parser = finite, requires = "omega_deg", allow_negative_numbers = true)]
    phi_deg: Option<f64>,
    /// Kappa, degrees, counter-clockwise from grid east
    #[arg(long, value_parser = finite, requires = "omega_deg", allow_negative_numbers = true)]
    kappa_deg: Option<f64>,
}

/// One of the two.
pub enum Orientation {
    /// Heading, pitch, roll and follow-up angle.
    Vehicle { attitude: Attitude, follow_up: Radians, is_followed: bool },
    /// ω, φ, κ, radians.
    Photogrammetric([f64; 3]),
}

impl Orientation {
    /// Of what was given.
    pub fn new(given: &OrientationArgs) -> Result<Self, Failure> {
        let OrientationArgs { heading_deg, pitch_deg, roll_deg, follow_up_deg, omega_deg, phi_deg, kappa_deg } = given;
        match (
            [heading_deg, pitch_deg, roll_deg].map(Option::as_ref),
            [omega_deg, phi_deg, kappa_deg].map(Option::as_ref),
        ) {
            ([Some(heading), Some(pitch), Some(roll)], _) => {
                let given = AttitudeArgs::new([*heading, *pitch, *roll], follow_up_deg.unwrap_or(FollowUp::Auto));
                let attitude = given.looking_down()?;
                let (follow_up, is_followed) = (given.follow_up(attitude), given.is_followed(attitude));
                Ok(Orientation::Vehicle { attitude, follow_up, is_followed })
            }
            (_, [Some(omega), Some(phi), Some(kappa)]) => {
                let angles = [*omega, *phi, *kappa].map(|angle| (angle % 360.0).to_radians());
                if angles[0].cos() * angles[1].cos() < 1e-3 {
                    return Err(Failure::Input(InputError::new(format!(
                        "--omega-deg {omega} --phi-deg {phi}: the camera looks at or above the horizon"
                    ))));
                }
                Ok(Orientation::Photogrammetric(angles))
            }
            _ => Err(Failure::Input(InputError::new(
                "how the camera is turned is missing: --heading-deg, --pitch-deg and --roll-deg, or --omega-deg, \
                 --phi-deg and --kappa-deg",
            ))),
        }
    }

    /// Share of a slant range along the optical axis that is height.
    pub fn cos_tilt(&self) -> f64 {
        match self {
            Orientation::Vehicle { attitude, .. } => f64::from(attitude.cos_tilt()),
            Orientation::Photogrammetric([omega, phi, _]) => omega.cos() * phi.cos(),
        }
    }

    /// Exterior orientation at a position.
    pub fn exterior(&self, position: [f64; 3]) -> Exterior {
        match *self {
            Orientation::Vehicle { attitude, follow_up, .. } => Exterior::of_vehicle(position, attitude, follow_up),
            Orientation::Photogrammetric(angles) => Exterior::photogrammetric(position, angles),
        }
    }

    /// Eq. 7 where it holds, eq. 3 otherwise, as on board; nothing for ω, φ, κ.
    pub fn homography(&self, camera: &Camera) -> Option<Homography> {
        let Orientation::Vehicle { attitude, follow_up, is_followed } = *self else { return None };
        Some(if is_followed && camera.is_isotropic() {
            Homography::simplified(equivalent_tilt(attitude, follow_up), camera)
        } else {
            Homography::full(&camera_from_local(attitude, follow_up), camera)
        })
    }

    /// Follow-up angle, equivalent pitch and equivalent roll, degrees; nothing for ω, φ, κ.
    pub fn angles_deg(&self) -> Option<[f32; 3]> {
        let Orientation::Vehicle { attitude, follow_up, .. } = *self else { return None };
        let equivalent = equivalent_tilt(attitude, follow_up_command(attitude));
        Some([follow_up, equivalent.pitch, equivalent.roll].map(|angle| angle.to_degrees()))
    }
}
