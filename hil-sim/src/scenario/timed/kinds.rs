//! What can fail, and in what way: the one list of units, types and what their values mean.

use std::fmt;

/// What fails and how. Units and types bear the words of MAVLink's FAILURE_UNIT and FAILURE_TYPE where these have one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum What {
    /// No position messages.
    PositionOff,
    /// Position and velocity stay, under fresh stamps.
    PositionStuck,
    /// The position stays; its velocity goes on.
    PositionStuckPosition,
    /// The position is off to the east at once.
    PositionJump,
    /// The position moves off to the east, and its velocity says so.
    PositionDrag,
    /// The velocity alone is off to the east.
    PositionWrongVelocity,
    /// The receiver has no position.
    GnssOff,
    /// The receiver's position is off to the east at once.
    GnssJump,
    /// The receiver's position moves off to the east, and its velocity says so.
    GnssDrag,
    /// No range messages.
    RangeOff,
    /// The range stays.
    RangeStuck,
    /// The range is longer.
    RangeBias,
    /// The range is multiplied.
    RangeScale,
    /// The range comes in whole steps.
    RangeSteps,
    /// No attitude messages.
    AttitudeOff,
    /// The whole attitude stays, under fresh stamps.
    AttitudeStuck,
    /// Pitch and roll are larger.
    AttitudeBias,
    /// Pitch and roll are multiplied.
    AttitudeScale,
    /// Values are older than their stamps and than what the board is told.
    AttitudeDelayed,
    /// Values are renewed seldom, under fresh stamps.
    AttitudeStale,
    /// Pitch stays.
    AttitudeStuckPitch,
    /// Roll stays.
    AttitudeStuckRoll,
    /// The heading is off clockwise.
    HeadingBias,
    /// The heading stays.
    HeadingStuck,
    /// The position's altitude is higher.
    BaroBias,
    /// The position's altitude is multiplied.
    BaroScale,
    /// No messages of the follow-up angle.
    EncoderOff,
    /// The follow-up angle stays.
    EncoderStuck,
    /// The follow-up angle is larger.
    EncoderBias,
    /// TIMESYNC answers tell another time.
    ClockOffset,
    /// TIMESYNC answers take longer back than there.
    ClockAsymmetry,
    /// TIMESYNC answers take longer back by a random time.
    ClockJitter,
    /// Pulses come later than the whole second.
    ClockPhase,
    /// The autopilot is silent, and boots at the end: its clock begins at 0, its streams are the slow ones that nobody asked for.
    ClockReboot,
    /// Nothing arrives.
    LinkOff,
    /// Messages arrive twice.
    LinkDuplicates,
    /// Messages arrive after the one that follows them.
    LinkReordering,
    /// Each message is followed by an old one.
    LinkReplay,
    /// Another component sends the streams, too, with other values.
    LinkSecondSender,
    /// The frame before comes again.
    CameraRepeated,
    /// Little of the light is left.
    CameraDark,
    /// There is dirt on the lens.
    CameraDirty,
    /// Rows are black.
    CameraDeadRows,
    /// Every second frame has another gain.
    CameraGainSteps,
    /// The board has no power, and boots at the end.
    PowerOff,
}

/// What a fault's value is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Value {
    /// Its unit of measure.
    pub unit: &'static str,
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

/// A row of the list.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kind {
    /// What fails.
    pub unit: &'static str,
    /// How.
    pub name: &'static str,
    /// Both as one.
    pub what: What,
    /// Its value, where it has one.
    pub value: Option<Value>,
}

const fn plain(unit: &'static str, name: &'static str, what: What) -> Kind {
    Kind { unit, name, what, value: None }
}

const fn valued(
    unit: &'static str,
    name: &'static str,
    what: What,
    (measure, low, high): (&'static str, f64, f64),
) -> Kind {
    Kind { unit, name, what, value: Some(Value { unit: measure, low, high }) }
}

/// All of them, the types of one unit together.
pub const KINDS: &[Kind] = &[
    plain("position", "off", What::PositionOff),
    plain("position", "stuck", What::PositionStuck),
    plain("position", "stuck_position", What::PositionStuckPosition),
    valued("position", "jump", What::PositionJump, ("m", -1e5, 1e5)),
    valued("position", "drag", What::PositionDrag, ("m/s", -300.0, 300.0)),
    valued("position", "wrong_velocity", What::PositionWrongVelocity, ("m/s", -300.0, 300.0)),
    plain("gnss", "off", What::GnssOff),
    valued("gnss", "jump", What::GnssJump, ("m", -1e5, 1e5)),
    valued("gnss", "drag", What::GnssDrag, ("m/s", -300.0, 300.0)),
    plain("range", "off", What::RangeOff),
    plain("range", "stuck", What::RangeStuck),
    valued("range", "bias", What::RangeBias, ("m", -1000.0, 1000.0)),
    valued("range", "scale", What::RangeScale, ("times", 0.0, 100.0)),
    valued("range", "steps", What::RangeSteps, ("m", 0.01, 1000.0)),
    plain("attitude", "off", What::AttitudeOff),
    plain("attitude", "stuck", What::AttitudeStuck),
    valued("attitude", "bias", What::AttitudeBias, ("deg", -90.0, 90.0)),
    valued("attitude", "scale", What::AttitudeScale, ("times", -10.0, 10.0)),
    valued("attitude", "delayed", What::AttitudeDelayed, ("ms", 0.0, 10_000.0)),
    valued("attitude", "stale", What::AttitudeStale, ("ms", 1.0, 60_000.0)),
    plain("attitude", "stuck_pitch", What::AttitudeStuckPitch),
    plain("attitude", "stuck_roll", What::AttitudeStuckRoll),
    valued("heading", "bias", What::HeadingBias, ("deg", -180.0, 180.0)),
    plain("heading", "stuck", What::HeadingStuck),
    valued("baro", "bias", What::BaroBias, ("m", -1e4, 1e4)),
    valued("baro", "scale", What::BaroScale, ("times", 0.0, 10.0)),
    plain("encoder", "off", What::EncoderOff),
    plain("encoder", "stuck", What::EncoderStuck),
    valued("encoder", "bias", What::EncoderBias, ("deg", -180.0, 180.0)),
    valued("clock", "offset", What::ClockOffset, ("ms", -3.6e6, 3.6e6)),
    valued("clock", "asymmetry", What::ClockAsymmetry, ("ms", 0.0, 1000.0)),
    valued("clock", "jitter", What::ClockJitter, ("ms", 0.0, 1000.0)),
    valued("clock", "phase", What::ClockPhase, ("ms", 0.0, 900.0)),
    plain("clock", "reboot", What::ClockReboot),
    plain("link", "off", What::LinkOff),
    valued("link", "duplicates", What::LinkDuplicates, ("%", 0.0, 100.0)),
    valued("link", "reordering", What::LinkReordering, ("%", 0.0, 100.0)),
    valued("link", "replay", What::LinkReplay, ("s", 0.1, 600.0)),
    plain("link", "second_sender", What::LinkSecondSender),
    plain("camera", "repeated", What::CameraRepeated),
    valued("camera", "dark", What::CameraDark, ("times", 0.0, 1.0)),
    valued("camera", "dirty", What::CameraDirty, ("blobs", 1.0, 1000.0)),
    valued("camera", "dead_rows", What::CameraDeadRows, ("%", 0.0, 100.0)),
    valued("camera", "gain_steps", What::CameraGainSteps, ("times", 0.0, 100.0)),
    plain("power", "off", What::PowerOff),
];

impl What {
    /// Its row of the list.
    #[must_use]
    pub fn kind(self) -> Option<&'static Kind> {
        KINDS.iter().find(|kind| kind.what == self)
    }
}

impl Kind {
    /// The row of a unit and a type.
    ///
    /// # Errors
    /// What there is instead.
    pub fn named(unit: &str, name: &str) -> Result<&'static Kind, String> {
        let of_unit: Vec<&Kind> = KINDS.iter().filter(|kind| kind.unit == unit).collect();
        if of_unit.is_empty() {
            let mut units: Vec<&str> = KINDS.iter().map(|kind| kind.unit).collect();
            units.dedup();
            return Err(format!("the fault's unit {unit:?} is none of {}", units.join(", ")));
        }
        of_unit.iter().find(|kind| kind.name == name).copied().ok_or_else(|| {
            let names: Vec<String> = of_unit.iter().map(|kind| kind.to_string()).collect();
            format!("the unit {unit} has no fault {name:?}, it has {}", names.join(", "))
        })
    }

    /// The value that it is given, checked; 0 where it takes none.
    ///
    /// # Errors
    /// What it takes.
    pub fn checked(&self, value: Option<f64>) -> Result<f64, String> {
        let Kind { unit, name, .. } = self;
        match (self.value, value) {
            (None, None) => Ok(0.0),
            (None, Some(value)) => Err(format!("{unit}.{name} = {value} takes no value")),
            (Some(Value { unit: measure, low, high }), None) => {
                Err(format!("{unit}.{name} needs a value from {low} to {high} [{measure}]"))
            }
            (Some(Value { low, high, .. }), Some(value)) if (low..=high).contains(&value) => Ok(value),
            (Some(Value { unit: measure, low, high }), Some(value)) => {
                Err(format!("{unit}.{name} = {value} is not between {low} and {high} [{measure}]"))
            }
        }
    }
}

impl fmt::Display for Kind {
    /// The type, with its value's unit in brackets.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.value {
            Some(value) => write!(f, "{} [{}]", self.name, value.unit),
            None => f.write_str(self.name),
        }
    }
}
