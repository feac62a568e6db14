//! The simulated autopilot's parameters: set as documented, but for the scenario's faults.

use crate::scenario::WrongParameters;
use mavlink::dialects::common::{MavParamType, PARAM_VALUE_DATA};

/// Names and values.
#[derive(Debug, Clone)]
pub struct Parameters(Vec<(&'static str, f32)>);

impl Parameters {
    /// As documented (`docs/autopilots.md`), with the loop rate that it runs at.
    pub fn new(loop_rate_hz: u32, wrong: &WrongParameters) -> Self {
        let parameters = [
            ("SCHED_LOOP_RATE", loop_rate_hz as f32, None),
            ("VISO_TYPE", 1.0, wrong.viso_type),
            ("VISO_DELAY_MS", 0.0, wrong.viso_delay_ms),
            ("VISO_POS_M_NSE", 0.2, wrong.viso_pos_m_nse),
            ("EK3_SRC2_POSXY", 6.0, wrong.ek3_src2_posxy),
            ("EK3_SRC2_VELXY", 0.0, wrong.ek3_src2_velxy),
            ("EK3_SRC2_POSZ", 1.0, wrong.ek3_src2_posz),
            ("EK3_SRC2_VELZ", 0.0, wrong.ek3_src2_velz),
            ("EK3_SRC2_YAW", 1.0, wrong.ek3_src2_yaw),
            ("EK3_GLITCH_RAD", 25.0, wrong.ek3_glitch_rad),
        ];
        Parameters(parameters.map(|(name, right, wrong)| (name, wrong.unwrap_or(right))).to_vec())
    }

    /// Those that it has.
    fn known(&self) -> impl Iterator<Item = (&'static str, f32)> + '_ {
        self.0.iter().copied().filter(|(_, value)| !value.is_nan())
    }

    /// The answer to a request by name, which is none for one that it does not have.
    pub fn answer(&self, name: &str) -> Option<PARAM_VALUE_DATA> {
        let index = self.known().position(|(known, _)| known == name)?;
        self.all().into_iter().nth(index)
    }

    /// All of them, in the order of their numbers.
    pub fn all(&self) -> Vec<PARAM_VALUE_DATA> {
        let value = |(index, (name, value)): (usize, (&str, f32))| {
            let mut bytes = [0; 16];
            bytes[..name.len()].copy_from_slice(name.as_bytes());
            PARAM_VALUE_DATA {
                param_value: value,
                param_count: self.known().count() as u16,
                param_index: index as u16,
                param_id: bytes.into(),
                param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            }
        };
        self.known().enumerate().map(value).collect()
    }
}
