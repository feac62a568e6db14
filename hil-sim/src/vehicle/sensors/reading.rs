//! What a sensor says.

/// What a sensor says, before its message rounds it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Reading {
    /// A pulse per second: the edge itself, at a whole second.
    Pps {
        /// Which second.
        second: u64,
    },
    /// Attitude.
    Attitude {
        /// Clockwise from TRUE north, within (−π, π]: heading on the grid + grid convergence.
        heading_true_rad: f64,
        /// Nose up.
        pitch_rad: f64,
        /// Right wing down.
        roll_rad: f64,
        /// Velocity towards true north, east and down, free of noise.
        velocity_ned_m_s: [f64; 3],
    },
    /// The servo's encoder.
    FollowUp {
        /// Counter-clockwise from above, within (−π, π].
        follow_up_rad: f64,
    },
    /// Laser range; `None` without an echo.
    Range {
        /// Along the camera's axis, metres.
        slant_m: Option<f64>,
    },
    /// Position prior.
    Position {
        /// Grid.
        east_m: f64,
        /// Grid.
        north_m: f64,
        /// Above the height datum.
        up_m: f64,
        /// Velocity towards true north, east and down.
        velocity_ned_m_s: [f64; 3],
    },
}

/// A reading and its two instants, microseconds of the autopilot's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sample {
    /// When it was measured; its message's stamp.
    pub sampled_at_us: u64,
    /// When the board has it.
    pub arrived_at_us: u64,
    /// What was measured.
    pub reading: Reading,
}
