//! Auto exposure: how long the next frames are exposed, from how bright the last ones are.
//!
//! Each frame's rows are sampled into a [`Histogram`] as they arrive. A sensor's answer is linear, so a frame that was
//! exposed for E and has the mean grey g says by itself what exposure would have the grey G wanted: E G/g. No error is
//! summed over frames, and so the two frames that a command takes until it shows do not make the control swing; the
//! exposure that counts is the one that the frame was really taken with, which [`AutoExposure::of`] knows. What is cut off
//! at white has lost how bright it is: then the share of white pixels says how far to go down.
//!
//! The exposure is bounded by the caller's limits and by the longest that is still sharp (module `motion`), or where that
//! would be dark, by three times as much. It is held while it is about right, and once it moves, it moves until it fits: a
//! steady scene keeps a constant exposure. From frame to frame it changes by a factor of two at most, so that one odd frame
//! (a glint, a cloud's edge) cannot throw it far, and two stops take three frames. A stamp goes by the length that was
//! commanded for its very frame, so that control costs its sigma nothing.

use crate::stamp::ExposureLimits;

/// Frames from the one that a command follows to the first that is exposed by it: the sensor takes its registers over while
/// it still reads out the frame before.
pub const LATENCY_FRAMES: u32 = 2;
/// Grey that the mean of a frame is to have. Chosen below the middle, 128: ground has few pixels that are twice as bright as
/// its mean, and light may grow by a stop before most are white.
pub const MEAN_WANTED: f32 = 110.0;
/// Mean grey below which a frame is dark: noise counts for more than blur. Chosen: two stops below the one that is wanted, nine
/// sigmas of a noise of three grey levels.
const DIM: f32 = MEAN_WANTED / 4.0;
/// Longest exposure in the dark, times the longest that is sharp. Chosen: a blur of a pixel and a half in the place of half a
/// one, less than the two frame pixels that a pixel of the patch spans where frames are averaged.
const BLUR_IN_THE_DARK: f32 = 3.0;
/// Grey that at most a fiftieth of the pixels may exceed: the middle of the last bin but one, above which noise of three grey
/// levels, five sigmas, stays below 255.
const BRIGHT_WANTED: f32 = 231.5;
/// The share of pixels that may be brighter.
const BRIGHT_SHARE: f32 = 0.02;
/// By how much the exposure must be wrong before it moves, and how near it must come before it stands again. Chosen: 0.4 and
/// 0.14 stops; fields, roofs and woods under one light move the mean by a fifth.
const START: f32 = 1.32;
const STOP: f32 = 1.1;
/// Largest change from frame to frame: a stop.
const STEP: f32 = 2.0;
/// By how much the longest sharp exposure grows from frame to frame where the motion lets it. It falls at once: a vehicle that
/// turned a moment ago will turn again before a command shows. Chosen: a stop in fourteen frames.
const CALM: f32 = 1.05;
/// Of a frame that is white at many places: what is left of the exposure where nearly none is, and by how much less that is
/// where all are. Chosen: with all white a frame is at least so much too bright, and steps are no larger.
const WHITE: (f32, f32) = (0.8, 0.5);

/// Greys in a bin, and the grey that the first begins with: how dark the darker half is, the mean says.
const BIN_GREYS: u8 = 16;
const FIRST_GREY: u8 = 128;
/// Bins of the histogram.
const BINS: usize = 8;
/// Every so many rows of a frame, and every so many pixels of such a row, are counted: 2048 of 512 x 512, of which a mean is
/// good to a grey level.
const ROW_STEP: u16 = 8;
const COL_STEP: usize = 16;

/// How bright a frame's pixels are: their mean, and how many of the bright ones are how bright.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Histogram {
    count: u32,
    sum: u32,
    bins: [u16; BINS],
}

/// The numbers of a histogram that decide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Brightness {
    /// Mean grey.
    pub mean: f32,
    /// Grey that a fiftieth of the pixels exceed, to half a bin; 0 where it is below the bins.
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

    /// Counts `rows` of `cols` pixels each, of which the first is row `first` of the frame. In what pieces they come makes no
    /// difference.
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

    /// What it says; nothing while it is empty.
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

/// An exposure, and the frame from which on it holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Command {
    /// Number of the frame.
    pub from: u32,
    /// Its exposure, microseconds.
    pub us: u32,
}

/// Commands that are kept: one for each frame until it shows, and the one that holds.
const KEPT: usize = LATENCY_FRAMES as usize + 1;

/// The control.
#[derive(Clone, Debug)]
pub struct AutoExposure {
    limits: ExposureLimits,
    /// The newest commands, oldest first.
    commands: [Command; KEPT],
    is_moving: bool,
    /// Longest exposure without blur, of the worst motion that has not been outlived; infinite before the first.
    sharp_us: f32,
}

impl AutoExposure {
    /// Frames are exposed for `us` so far. The limits are in order.
    pub fn new(limits: ExposureLimits, us: u32) -> Self {
        AutoExposure { limits, commands: [Command { from: 0, us }; KEPT], is_moving: false, sharp_us: f32::INFINITY }
    }

    /// What frame `frame` was or will be exposed for, as far as is known now, microseconds.
    pub fn of(&self, frame: u32) -> u32 {
        let holds = |command: &&Command| (frame.wrapping_sub(command.from) as i32) >= 0;
        let [oldest, ..] = &self.commands;
        self.commands.iter().rev().find(holds).unwrap_or(oldest).us
    }

    /// A frame goes by whose exposure, as the vehicle moved last, would be sharp up to `sharp_us`; nothing where that is not
    /// known.
    pub fn moved(&mut self, sharp_us: Option<u32>) {
        self.sharp_us = (CALM * self.sharp_us).min(sharp_us.map_or(f32::INFINITY, |us| us as f32));
    }

    /// What frame `frame`, as bright as that, says of the exposures to come: another one, or nothing where they stay.
    pub fn after(&mut self, frame: u32, brightness: &Brightness) -> Option<u32> {
        let [least_us, longest_us] = [self.limits.least_us, self.limits.longest_us].map(|us| us as f32);
        let taken_us = self.of(frame) as f32;
        let dim_us = taken_us * DIM / at_least_one(brightness.mean);
        let most_us = self.sharp_us.max(dim_us.min(BLUR_IN_THE_DARK * self.sharp_us)).min(longest_us).max(least_us);
        let [.., newest] = &self.commands;
        let now_us = newest.us as f32;
        let wanted_us = (taken_us * factor(brightness)).max(least_us).min(most_us);
        let (up, down) = (wanted_us / now_us, now_us / wanted_us);
        let off = up.max(down);
        // Blur is no matter of taste, and where it bounds the exposure, this moves with the vehicle and not with the light.
        let is_blurred = now_us > most_us;
        let moves = off > if self.is_moving { STOP } else { START };
        // It has not come to rest before a frame was taken with the newest command.
        self.is_moving = !is_blurred && (moves || self.is_moving && taken_us != now_us);
        if !moves && !is_blurred {
            return None;
        }
        let us = wanted_us.max(now_us / STEP).min(now_us * STEP) as u32;
        (us != newest.us && us > 0).then_some(us)
    }

    /// The board will expose like this. Commands come in the order of their frames.
    pub fn command(&mut self, command: Command) {
        let [_, second, third] = self.commands;
        self.commands = [second, third, command];
    }
}

/// By what the exposure of a frame as bright as this is to be multiplied.
fn factor(brightness: &Brightness) -> f32 {
    let Brightness { mean, bright, white } = *brightness;
    if white > BRIGHT_SHARE {
        return WHITE.0 - WHITE.1 * white;
    }
    (MEAN_WANTED / at_least_one(mean)).min(BRIGHT_WANTED / at_least_one(bright))
}

/// A frame that is black says that it is at least so much too dark.
fn at_least_one(grey: f32) -> f32 {
    grey.max(1.0)
}
