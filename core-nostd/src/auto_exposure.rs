//! Auto exposure: the exposure of the next frames from the brightness of the last ones.
//!
//! Each frame's rows are sampled into a [`Histogram`] as they arrive. A sensor is linear, so a frame of exposure E and
//! mean grey g gives the exposure for grey G directly: E G/g. Nothing is integrated over frames, so the latency of two
//! frames does not make the control oscillate; E is the exposure that the frame was taken with, from
//! [`AutoExposure::of`]. Saturated pixels have lost their brightness: then the share of white pixels sets the
//! reduction.
//!
//! The exposure is bounded by the caller's limits and by the longest that is still sharp (module `motion`), or if that
//! would be dark, by three times that. It is held while it is about right, and once it changes, it changes until it
//! fits: a steady scene keeps a constant exposure. From frame to frame it changes by a factor of two at most, so that
//! one odd frame (a glint, a cloud's edge) cannot throw it far, and two stops take three frames. A stamp uses the
//! length that was commanded for its very frame, so the control does not increase its sigma.

use crate::stamp::ExposureLimits;

/// Frames from the one that a command follows to the first exposed by it: the sensor applies its registers while it
/// still reads out the frame before.
pub const LATENCY_FRAMES: u32 = 2;
/// Wanted mean grey of a frame. Chosen below the middle, 128: ground has few pixels that are twice as bright as its
/// mean, and light may grow by a stop before most are white.
pub const MEAN_WANTED: f32 = 110.0;
/// Mean grey below which a frame is dark: noise matters more than blur. Chosen: two stops below the wanted one, nine
/// sigmas of a noise of three grey levels.
const DARK_MEAN: f32 = MEAN_WANTED / 4.0;
/// Longest exposure in the dark, times the longest that is sharp. Chosen: a blur of a pixel and a half instead of half
/// a pixel, less than the two frame pixels that a pixel of the patch spans where frames are averaged.
const DARK_BLUR: f32 = 3.0;
/// Grey that at most a fiftieth of the pixels may exceed: the middle of the last bin but one, above which noise of
/// three grey levels, five sigmas, stays below 255.
const BRIGHT_WANTED: f32 = 231.5;
/// Share of pixels that may be brighter.
const BRIGHT_SHARE: f32 = 0.02;
/// Hysteresis: ratio of wanted to current exposure at which it starts to change, and at which it stops. Chosen: 0.4 and
/// 0.14 stops; fields, roofs and woods under one light move the mean by a fifth.
const START_RATIO: f32 = 1.32;
const STOP_RATIO: f32 = 1.1;
/// Largest change from frame to frame: a stop.
const STEP_MAX: f32 = 2.0;
/// Growth of the longest sharp exposure from frame to frame while the motion permits. It falls at once: a vehicle that
/// turned a moment ago will turn again before a command takes effect. Chosen: a stop in fourteen frames.
const SHARP_GROWTH: f32 = 1.05;
/// Factor of the exposure for a saturated frame: with almost no white pixels, and its decrease to all white. Chosen:
/// with all white a frame is at least so much too bright, and steps are no larger.
const SATURATED_FACTOR: (f32, f32) = (0.8, 0.5);

/// Grey levels in a bin, and the lowest grey of the first bin: the mean describes the darker half.
const BIN_GREYS: u8 = 16;
const FIRST_GREY: u8 = 128;
/// Bins of the histogram.
const BINS: usize = 8;
/// Strides of the rows and of the pixels of a row that are counted: 2048 pixels of 512 x 512, whose mean is good to a
/// grey level.
const ROW_STEP: u16 = 8;
const COL_STEP: usize = 16;

/// Brightness of a frame's pixels: their mean, and a histogram of the bright ones.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    count: u32,
    sum: u32,
    bins: [u16; BINS],
}

/// Statistics of a histogram.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightness {
    /// Mean grey.
    pub mean: f32,
    /// Grey that a fiftieth of the pixels exceed, to half a bin; 0 if it is below the bins.
    pub bright: f32,
    /// Share of pixels in the last bin, which ends at white.
    pub white: f32,
}

impl Default for Histogram {
    fn default() -> Self {
        Histogram::new()
    }
}

impl Histogram {
    /// Empty.
    pub const fn new() -> Self {
        Histogram { count: 0, sum: 0, bins: [0; BINS] }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        *self = Histogram::new();
    }

    /// Counts `rows` of `cols` pixels each, of which the first is row `first` of the frame. The result does not depend
    /// on how the rows are split into calls.
    pub fn count(&mut self, rows: &[u8], cols: u16, first: u16) {
        let skipped = (ROW_STEP - first % ROW_STEP) % ROW_STEP;
        let lines = rows.chunks_exact(usize::from(cols).max(1)).skip(usize::from(skipped));
        for line in lines.step_by(usize::from(ROW_STEP)) {
            for &pixel in line.iter().step_by(COL_STEP) {
                (self.count, self.sum) = (self.count.wrapping_add(1), self.sum.wrapping_add(pixel.into()));
                if let Some(above) = pixel.checked_sub(FIRST_GREY)
                    && let Some(bin) = self.bins.get_mut(usize::from(above / BIN_GREYS))
                {
                    *bin = bin.saturating_add(1);
                }
            }
        }
    }

    /// Its statistics; `None` while it is empty.
    pub fn brightness(&self) -> Option<Brightness> {
        if self.count == 0 {
            return None;
        }
        let share = |count: u32| count as f32 / self.count as f32;
        let (mut above, mut bright) = (0, 0.0);
        for (bin, &count) in self.bins.iter().enumerate().rev() {
            above += u32::from(count);
            if share(above) > BRIGHT_SHARE {
                bright = FIRST_GREY as f32 + BIN_GREYS as f32 * (bin as f32 + 0.5) - 0.5;
                break;
            }
        }
        let [.., white] = self.bins;
        Some(Brightness { mean: share(self.sum), bright, white: share(white.into()) })
    }
}

/// An exposure, and the first frame with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Number of the frame.
    pub from: u32,
    /// Its exposure, microseconds.
    pub us: u32,
}

/// Commands that are kept: one for each frame of the latency, and the one in effect.
const KEPT: usize = LATENCY_FRAMES as usize + 1;

/// The control loop.
#[derive(Clone, Debug)]
pub struct AutoExposure {
    limits: ExposureLimits,
    /// The newest commands, oldest first.
    commands: [Command; KEPT],
    is_moving: bool,
    /// Longest exposure without blur, of the fastest recent motion; infinite before the first.
    sharp_us: f32,
}

impl AutoExposure {
    /// All frames so far are exposed for `us`. `limits` must be in order.
    pub fn new(limits: ExposureLimits, us: u32) -> Self {
        AutoExposure { limits, commands: [Command { from: 0, us }; KEPT], is_moving: false, sharp_us: f32::INFINITY }
    }

    /// Exposure of frame `frame` by the commands so far, microseconds.
    pub fn of(&self, frame: u32) -> u32 {
        let holds = |command: &&Command| (frame.wrapping_sub(command.from) as i32) >= 0;
        let [oldest, ..] = &self.commands;
        self.commands.iter().rev().find(holds).unwrap_or(oldest).us
    }

    /// Takes a frame's longest sharp exposure, microseconds, by the vehicle's motion; `None` if unknown.
    pub fn moved(&mut self, sharp_us: Option<u32>) {
        self.sharp_us = (SHARP_GROWTH * self.sharp_us).min(sharp_us.map_or(f32::INFINITY, |us| us as f32));
    }

    /// Takes the brightness of frame `frame`; returns a new exposure, microseconds, or `None` if it stays.
    pub fn after(&mut self, frame: u32, brightness: &Brightness) -> Option<u32> {
        let [least_us, longest_us] = [self.limits.least_us, self.limits.longest_us].map(|us| us as f32);
        let taken_us = self.of(frame) as f32;
        let dark_us = taken_us * DARK_MEAN / at_least_one(brightness.mean);
        let most_us = self.sharp_us.max(dark_us.min(DARK_BLUR * self.sharp_us)).min(longest_us).max(least_us);
        let [.., newest] = &self.commands;
        let now_us = newest.us as f32;
        let wanted_us = (taken_us * factor(brightness)).max(least_us).min(most_us);
        let (up, down) = (wanted_us / now_us, now_us / wanted_us);
        let off = up.max(down);
        // Blur has no hysteresis; where it bounds the exposure, that changes with the motion and not with the light.
        let is_blurred = now_us > most_us;
        let moves = off > if self.is_moving { STOP_RATIO } else { START_RATIO };
        // The change ends only with a frame taken by the newest command.
        self.is_moving = !is_blurred && (moves || self.is_moving && taken_us != now_us);
        if !moves && !is_blurred {
            return None;
        }
        let us = wanted_us.max(now_us / STEP_MAX).min(now_us * STEP_MAX) as u32;
        (us != newest.us && us > 0).then_some(us)
    }

    /// Takes a command that the board will carry out, in the order of frames.
    pub fn command(&mut self, command: Command) {
        let [_, second, third] = self.commands;
        self.commands = [second, third, command];
    }
}

/// Factor for the exposure of a frame of this brightness.
fn factor(brightness: &Brightness) -> f32 {
    let Brightness { mean, bright, white } = *brightness;
    if white > BRIGHT_SHARE {
        return SATURATED_FACTOR.0 - SATURATED_FACTOR.1 * white;
    }
    (MEAN_WANTED / at_least_one(mean)).min(BRIGHT_WANTED / at_least_one(bright))
}

/// A black frame is at least so much too dark.
fn at_least_one(grey: f32) -> f32 {
    grey.max(1.0)
}
