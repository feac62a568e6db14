//! Who flies a mission: what QGroundControl calls vehicle and autopilot, and how the vehicle takes off and comes back.

/// MAV_CMD_NAV_RETURN_TO_LAUNCH.
pub const RETURN: u16 = 20;
/// MAV_CMD_NAV_TAKEOFF.
const TAKEOFF: u16 = 22;
/// MAV_CMD_NAV_VTOL_TAKEOFF.
const VTOL_TAKEOFF: u16 = 84;
/// Climb of a fixed wing: the least pitch, degrees, as ArduPilot's and PX4's own plans have it.
const CLIMB_DEG: f64 = 15.0;

/// How it stays in the air.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Kind {
    /// By its wings.
    #[default]
    FixedWing,
    /// It takes off and lands by rotors and flies by its wings.
    Vtol,
    /// By rotors.
    Multirotor,
}

impl Kind {
    /// QGroundControl's `vehicleType`: MAV_TYPE_FIXED_WING, MAV_TYPE_VTOL_TAILSITTER_QUADROTOR (by which it means any VTOL),
    /// MAV_TYPE_QUADROTOR (any multirotor).
    pub(super) fn mav_type(self) -> u8 {
        match self {
            Kind::FixedWing => 1,
            Kind::Vtol => 20,
            Kind::Multirotor => 2,
        }
    }
}

/// Whose firmware.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Autopilot {
    /// ArduPilot.
    #[default]
    Ardupilot,
    /// PX4.
    Px4,
}

impl Autopilot {
    /// QGroundControl's `firmwareType`: MAV_AUTOPILOT_ARDUPILOTMEGA, MAV_AUTOPILOT_PX4.
    pub(super) fn mav_autopilot(self) -> u8 {
        match self {
            Autopilot::Ardupilot => 3,
            Autopilot::Px4 => 12,
        }
    }
}

/// What a mission is edited for; an upload asks the vehicle itself.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Vehicle {
    /// Its kind.
    pub kind: Kind,
    /// Its firmware.
    pub autopilot: Autopilot,
    /// Whether the mission begins with a take-off to the flying height and ends with the return to the place of it.
    pub has_takeoff: bool,
}

impl Vehicle {
    /// Command and first parameter of a take-off.
    pub(super) fn takeoff(self) -> (u16, f64) {
        match self.kind {
            Kind::FixedWing => (TAKEOFF, CLIMB_DEG),
            Kind::Vtol => (VTOL_TAKEOFF, 0.0),
            Kind::Multirotor => (TAKEOFF, 0.0),
        }
    }
}
