//! What is missing before fixes can be made and sent, in the order in which it comes to be.

/// What is there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Present {
    /// The autopilot's heartbeat.
    pub autopilot: bool,
    /// Our clock is tied to the autopilot's.
    pub clock: bool,
    /// Attitudes of late.
    pub attitude: bool,
    /// Positions of late, on the map.
    pub position: bool,
    /// The origin of the autopilot's local frame, where fixes are sent in it.
    pub origin: bool,
    /// A height in that frame, likewise.
    pub height: bool,
    /// The autopilot's parameters have been asked for.
    pub checked: bool,
    /// None of them that is required is wrong.
    pub parameters: bool,
    /// Frames of late.
    pub camera: bool,
}

/// What is missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Missing {
    /// No heartbeat.
    Autopilot,
    /// TIMESYNC is not answered.
    Clock,
    /// No attitudes.
    Attitude,
    /// No positions.
    Position,
    /// No origin.
    Origin,
    /// No height.
    Height,
    /// Parameters are not known yet.
    Unchecked,
    /// Parameters are wrong; which, they say themselves.
    Parameters,
    /// No frames.
    Camera,
}

impl Present {
    /// The first that is missing; nothing where all is there.
    pub fn missing(&self) -> Option<Missing> {
        let each = [
            (self.autopilot, Missing::Autopilot),
            (self.clock, Missing::Clock),
            (self.attitude, Missing::Attitude),
            (self.position, Missing::Position),
            (self.origin, Missing::Origin),
            (self.height, Missing::Height),
            (self.checked, Missing::Unchecked),
            (self.parameters, Missing::Parameters),
            (self.camera, Missing::Camera),
        ];
        each.into_iter().find(|(is_there, _)| !is_there).map(|(_, what)| what)
    }
}

impl Missing {
    /// For the pilot: at most 50 characters.
    pub fn words(self) -> &'static str {
        match self {
            Missing::Autopilot => "no fixes: no heartbeat of the autopilot",
            Missing::Clock => "no fixes: TIMESYNC is not answered",
            Missing::Attitude => "no fixes: no attitude from the autopilot",
            Missing::Position => "no fixes: no position on the map",
            Missing::Origin => "no fixes: the autopilot's EKF has no origin",
            Missing::Height => "no fixes: no LOCAL_POSITION_NED",
            Missing::Unchecked => "no fixes: parameters are not read yet",
            Missing::Parameters => "no fixes: the autopilot's parameters are wrong",
            Missing::Camera => "no fixes: no frames from the camera",
        }
    }
}

/// Seconds from one telling of what is missing to the next.
const REPEATED_EVERY: u32 = 10;

/// What the pilot was told last.
#[derive(Clone, Copy, Debug, Default)]
pub struct Told {
    last: Option<Option<Missing>>,
    seconds: u32,
}

impl Told {
    /// To be called once a second: the line that is due. A vehicle that is ready is told once; what is missing when it
    /// changes, and every ten seconds.
    pub fn line(&mut self, missing: Option<Missing>) -> Option<&'static str> {
        self.seconds = self.seconds.saturating_add(1);
        let is_news = self.last != Some(missing);
        if !is_news && (missing.is_none() || self.seconds < REPEATED_EVERY) {
            return None;
        }
        (self.last, self.seconds) = (Some(missing), 0);
        Some(missing.map_or("ready for fixes", Missing::words))
    }
}

#[cfg(test)]
mod tests {
    use super::{Missing, Present, Told};

    #[test]
    fn what_is_missing_is_told_when_it_changes_and_now_and_then() {
        let mut told = Told::default();
        let lacking = Present { autopilot: true, ..Present::default() }.missing();
        assert_eq!((lacking, Present::default().missing()), (Some(Missing::Clock), Some(Missing::Autopilot)));
        let lines: [bool; 11] = core::array::from_fn(|_| told.line(lacking).is_some());
        assert_eq!(lines.map(u8::from), [1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1]);
        assert_eq!((told.line(None), told.line(None)), (Some("ready for fixes"), None));
        assert_eq!(told.line(lacking), Some(Missing::Clock.words()));
    }
}
