//! Why samples cannot be smoothed.

use super::Order;

/// Largest turn from one sample to the next, degrees. With a third of a circle a wrong sample between two good ones, which
/// are less than that apart, cannot leave whole turns behind: the two steps beside it add up to 240 degrees at most.
pub const TURN_MAX_DEG: f64 = 120.0;

/// A gap between two samples that count.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// Index of the sample after it.
    pub after: usize,
    /// Instant of the last sample before it, seconds.
    pub from_s: f64,
    /// Instant of the first sample after it, seconds.
    pub to_s: f64,
}

impl Gap {
    /// How long it is, seconds.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.to_s - self.from_s
    }
}

/// Most gaps that an error names.
const NAMED: usize = 5;

/// Bad samples or options. Samples are counted from 0.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "what the fields are is said with their variant")]
pub enum SmoothError {
    /// An angle that turns so far from one sample to the next that the way round is not certain.
    TurnTooFar { sample: usize, turn_deg: f64 },
    /// A value that looks like an angle counted over its end, in a channel that is not smoothed as one.
    TurnedOver { sample: usize, jump: f64, turn: f64 },
    /// Fewer samples than the order can smooth.
    TooFew { samples: usize, order: Order },
    /// A time or value that is not a finite number.
    NotFinite { sample: usize, what: &'static str },
    /// A time that does not come after the one before.
    NotForward { sample: usize, t_s: f64, before_s: f64 },
    /// Times so far apart, or two of them so near to each other, that their powers are no numbers, seconds.
    SpacingOutOfRange { sample: usize, spacing_s: f64 },
    /// Values so small that their squares vanish.
    ValuesTooSmall { largest: f64 },
    /// Gaps longer than the limit, which is in seconds.
    GapTooLong { gaps: Vec<Gap>, limit_s: f64 },
    /// A weight below zero or not finite, or two that are too far apart to be added.
    BadWeight { sample: usize, weight: f64 },
    /// Too few samples have a weight above zero: the channel has no rank.
    RankDeficient { counting: usize, order: Order },
    /// All samples are equal: a sensor that is stuck, with residuals that say nothing of its noise.
    AllEqual { value: f64 },
    /// GCV has no minimum to find: the samples lie on a polynomial that every smoothing factor reproduces.
    NothingToWeigh { order: Order },
    /// GCV compares nothing with one sample more than the order.
    TooFewForGcv { counting: usize, order: Order },
    /// A smoothing factor that is not above zero.
    AlphaNotPositive { alpha: f64 },
    /// A smoothing factor so small that no residual is left to tell the noise by.
    AlphaTooSmall { alpha: f64, limit: f64 },
    /// A smoothing factor that leaves no digits.
    AlphaTooLarge { alpha: f64, limit: f64 },
    /// The outlier gate is not above zero, or rejects more than a quarter of the samples: they are no outliers.
    GateRejects { rejected: usize, counting: usize },
    /// An instant outside the samples, seconds.
    OutOfRange { t_s: f64, from_s: f64, to_s: f64 },
}

impl SmoothError {
    /// One sentence without a full stop; `place` names a sample, for example by the line it stands in.
    #[must_use]
    pub fn sentence(&self, place: &dyn Fn(usize) -> String) -> String {
        match self.sample() {
            Some(sample) => format!("{}: {}", place(sample), self.reason()),
            None => self.reason(),
        }
    }

    /// The sample at which it lies, where it lies at one.
    fn sample(&self) -> Option<usize> {
        match self {
            SmoothError::TurnTooFar { sample, .. }
            | SmoothError::TurnedOver { sample, .. }
            | SmoothError::NotFinite { sample, .. }
            | SmoothError::NotForward { sample, .. }
            | SmoothError::SpacingOutOfRange { sample, .. }
            | SmoothError::BadWeight { sample, .. } => Some(*sample),
            SmoothError::GapTooLong { gaps, .. } => gaps.first().map(|gap| gap.after),
            _ => None,
        }
    }

    /// The sentence without the sample.
    fn reason(&self) -> String {
        match self {
            SmoothError::TurnTooFar { turn_deg, .. } => {
                format!("the angle turns by {turn_deg:.1} deg; beyond {TURN_MAX_DEG} the way round is not certain")
            }
            SmoothError::TurnedOver { jump, turn, .. } => {
                let ends = if *turn < 360.0 { "pi or 2 pi radians" } else { "180 or 360 degrees" };
                format!(
                    "the value jumps by {jump:.1}, as an angle does that is counted over {ends}; if it is one, name it under --angles"
                )
            }
            SmoothError::TooFew { samples, order } => {
                let samples = if *samples == 1 { "1 sample".to_owned() } else { format!("{samples} samples") };
                format!("{samples}, but order {order} needs {} at least", order.differences() + 1)
            }
            SmoothError::NotFinite { what, .. } => format!("the {what} is not a finite number"),
            SmoothError::NotForward { t_s, before_s, .. } if t_s == before_s => format!("the time {t_s} is repeated"),
            SmoothError::NotForward { t_s, before_s, .. } => {
                format!("the time {t_s} goes back, {before_s} stands before it")
            }
            SmoothError::SpacingOutOfRange { spacing_s, .. } => {
                format!("{spacing_s:e} after the time before, beyond the range of numbers")
            }
            SmoothError::ValuesTooSmall { largest } => {
                format!("no value is above {largest:e}: their squares are beyond the range of numbers")
            }
            SmoothError::GapTooLong { gaps, limit_s } => gaps_too_long(gaps, *limit_s),
            SmoothError::BadWeight { weight, .. } => {
                format!("{weight} is no weight (0, or between 1e-6 and 1e6 of the mean)")
            }
            SmoothError::RankDeficient { counting, order } => format!(
                "rank-deficient: {counting} samples have a weight above 0, order {order} needs {}",
                order.differences() + 1
            ),
            SmoothError::AllEqual { value } => {
                format!("all samples are equal ({value}): a stuck sensor, whose noise cannot be estimated")
            }
            SmoothError::NothingToWeigh { order } => format!(
                "GCV is undefined: the samples lie on a polynomial of degree {}, which every alpha reproduces",
                order.differences() - 1
            ),
            SmoothError::TooFewForGcv { counting, order } => {
                format!("GCV is undefined for {counting} samples, order {order} needs {}", order.differences() + 2)
            }
            SmoothError::AlphaNotPositive { alpha } => format!("alpha {alpha} is not above 0"),
            SmoothError::AlphaTooSmall { alpha, limit } => {
                format!("alpha {alpha:e} is below {limit:e}, where the residuals are no more than rounding")
            }
            SmoothError::AlphaTooLarge { alpha, limit } => {
                format!("alpha {alpha} is above {limit:.3e}, where the equations' condition number passes 1e13")
            }
            SmoothError::GateRejects { rejected, counting } => format!(
                "the outlier gate rejects {rejected} of {counting} samples, more than a quarter: these are no outliers"
            ),
            SmoothError::OutOfRange { t_s, from_s, to_s } => {
                format!("the time {t_s} is outside the samples, {from_s} to {to_s}")
            }
        }
    }
}

fn gaps_too_long(gaps: &[Gap], limit_s: f64) -> String {
    let name = |gap: &Gap| format!("{:.3} s at {}", gap.length_s(), gap.from_s);
    let named: Vec<String> = gaps.iter().take(NAMED).map(name).collect();
    let more = if gaps.len() > NAMED { format!(" and {} more", gaps.len() - NAMED) } else { String::new() };
    // A limit of so many spacings has the digits of a mean.
    let limit = (limit_s * 1e6).round() / 1e6;
    format!("gap longer than the limit of {limit} s: {}{more}", named.join(", "))
}

impl std::fmt::Display for SmoothError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.sentence(&|sample| format!("sample {}", sample + 1)))
    }
}

impl std::error::Error for SmoothError {}
