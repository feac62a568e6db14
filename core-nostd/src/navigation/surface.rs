//! Where the vehicle may be by all frames together: evidence of several pieces of ground, added up before any of them decides.
//!
//! Where the map is of another year a single patch says little, and what it says may be wrong: a shore line that has moved, a field that is
//! cut. But each frame's scores say something of every shift, and those of other ground are wrong elsewhere. So they are added, as the
//! vehicle moves: a track before it is detected (Barniv 1985; for scenes, US patent 5,146,228 of 1990, expired). The sum is a surface over
//! the places where the nadir may be, two pixels apart, carried on by the velocity. Between two pieces of ground each place takes over from
//! one nearby what the velocity may be off by, at the cost of how improbable that is (the step of Viterbi's algorithm).
//!
//! Ground counts once: a frame is added where the vehicle has come three quarters of a footprint from all those that have been. Until it comes
//! to the next piece, a frame of more texture takes the place of the one that has been added.
//! No piece of ground says more than 90, since one in 120 is wrong however clear it is.

pub mod agreement;
mod top;
mod places;

use super::reckoning::{Moment, way_m};
use crate::matching::directions::half::{MIDDLE, SHIFTS, STEP_PX, Scores};
use crate::matching::local_maximum::vertex;
use crate::math::{exp, hypot, ln, round};
use crate::tile::Local;
use crate::units::Micros;
use agreement::Agreement;
use heapless::Deque;
use places::{DRIFT_MIN, Kept, Places};
use top::Top;

/// What a piece of ground says against a shift at most: of patches of 21 to 64 pixels alone one in 120 is wrong that says as much.
/// Of 40, 60, 90 and none the one that decides most sums of two to eight patches at one wrong of 10,000.
const CAP: f32 = 90.0;
/// The log-odds that the highest of a surface is more than three pixels off are `ALWAYS` − `EVIDENCE` l^`POWER`, l being its lead over all
/// that is away from it.
///
/// Learnt by logistic regression over sums of one, two, three, five and eight patches of 21 to 64 pixels side by side, each year of eight
/// looked for in every other (5 m a pixel, farmland and lakes). Stated and observed agree within a factor of 2.5 from 0.2 down to 1e-3,
/// whatever the number of patches; below, fewer are wrong than stated.
const ALWAYS: f32 = 1.115;
const EVIDENCE: f32 = 0.3612;
const POWER: f32 = 0.6;
/// Evidence that a frame may have for another place and still be matched where all of them together put it: a twentieth of what decides. By itself
/// a frame is not asked: of 5,800 that lay beside the decided place in flights between years one was off by more than 3 pixels, whatever they led by.
const CONTRADICTS: f32 = 10.0;
/// Share of the evidence that is left when the next piece of ground comes, where the map is of another year: all there is is
/// worth the last ten. The map lies differently off by place and the velocity is off by more than it states, so that old
/// evidence holds the surface back where the nadir was. Of 0.8, 0.85, 0.9 and 1 what gives most fixes at no more wrong ones: at
/// 1 of 3,100 decided places in flights between years 82 were off by more than 3 pixels, at 0.9 and 0.85 none. In its own year
/// all is kept: what an attitude that is off puts elsewhere has to outweigh all that was before.
const KEPT_SHARE: f32 = 0.9;
/// Least curvature of a frame's scores that is taken for one.
const CURVATURE_MIN: f32 = 0.02;
/// A frame of the newest piece of ground takes the place of the one that stands for it if it has so many times its texture. Chosen: what is
/// gained by less is not worth the work.
const BETTER: f32 = 1.1;
/// Share of the smaller side of a footprint by which the vehicle has to have come from ground that has been added.
const FRESH: f32 = 0.75;
/// Pieces of ground that are remembered. Chosen: a circle of as many footprints is flown for the second time after a minute or more.
const GROUNDS: usize = 13;
/// Longest time between two frames over which a surface is carried on, microseconds: that of places.
const STEP_MAX_US: i32 = 9_000_000;
/// Share by which the surface is moved to where least squares have found the nadir. Chosen: a velocity that is off is made good over a few
/// of them.
const GAIN: f32 = 0.3;
/// And as if it lay no further off than this, pixels: what is further off is seldom the velocity, and frames of one piece of
/// ground are wrong alike. In 28 flights between years, patches of 35 pixels, seven frames that had been led astray so were
/// fixed more than 3 pixels off, and none with this bound. Of 0.5, 0.75, 1 and none the one that had none of those.
const ASIDE_MAX_PX: f32 = 0.75;
/// And all frames of a piece of ground together move it no further, pixels, beside what dead reckoning may be off by: they see the same.
/// In 56 closed loops between years after the loss of satellites, patches of 35 and 64 pixels, two of 2,471 fixes were more than 3 pixels
/// off without this bound and none of 1,920 with it. Chosen: less than a map of another year is off by place.
const LED_MAX_PX: f32 = 0.4;
/// What dead reckoning may be off by since the newest piece of ground, pixels, one sigma, for the surface to say anything: a third of what is
/// called wrong. A vehicle that flew over ground it had been over before was fixed 5.9 pixels off by what it had known a minute earlier.
const DRIFT_MAX_PX: f32 = 1.0;
/// Frames over which the share of those is taken of which least squares hold: a minute, longer than ground of the same state is seen. Over a quarter
/// of that a wood of fifty frames between two years passed for a map of the ground's own.
const HOLDING_FRAMES: u8 = 250;
/// The share before any frame, and as how many frames that counts; and from which on the map is of the ground's own year. Within a year six to nine
/// of ten frames hold, between years up to two, but as long as a field that has not changed is seen all do: of 560 matches of least squares between
/// years 22, most of them of the first second, were off by more than five of their sigmas when the map was taken to be of the ground's own year
/// until frames said otherwise.
const HOLDING_FIRST: f32 = 0.2;
const HOLDING_COUNTS: u8 = 15;
const HOLDING_MIN: f32 = 0.4;
/// No place of any tile is as far from its centre, metres: a quarter of the Earth's circumference.
const FAR_M: f32 = 1e7;
/// Evidence of least squares that hold, and for places within so many shifts. Of 23,000 wrong peaks one had such a solution: as much as decides
/// by itself.
const HELD: f32 = 250.0;
const HELD_STEPS: f32 = 1.5;

/// All numbers that the risk of a decision is made of, for whoever keeps a record of which they were.
pub const COEFFICIENTS: [f32; 10] =
    [CAP, ALWAYS, EVIDENCE, POWER, CONTRADICTS, KEPT_SHARE, CURVATURE_MIN, FRESH, LED_MAX_PX, DRIFT_MAX_PX];

/// The place that a surface has decided for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Decided {
    /// Where the nadir is.
    pub nadir: Local,
    /// Probability that it is more than three pixels off.
    pub risk: f32,
}

/// Evidence for each place.
#[derive(Clone, Debug)]
pub struct Surface {
    places: Places,
    /// What they were before the newest piece of ground, and the texture of the frame that stands for that.
    before: Kept,
    texture: f32,
    /// The nadir at the shift in the middle.
    middle: Local,
    moment: Moment,
    /// What dead reckoning may be off by since the newest piece of ground, one sigma of each axis, metres: less where frames' own tops
    /// confirm it, and all of it.
    drift_m: f32,
    since_m: f32,
    /// By how much frames of that piece have moved it, metres east and north.
    led_m: [f32; 2],
    /// The way flown, and where it was when ground was added.
    gone: Local,
    /// The newest frame's ground has not been counted before, or is the newest piece that has.
    is_fresh: bool,
    is_newest: bool,
    grounds: Deque<Local, GROUNDS>,
    /// Whether frames by themselves say the same.
    pub agreement: Agreement,
    /// Share of the last frames of which least squares held, and how many they are, those included that [`HOLDING_FIRST`] counts as.
    holding: f32,
    frames: u8,
}

impl Default for Surface {
    fn default() -> Self {
        Surface::new()
    }
}

impl Surface {
    /// Nothing known.
    pub const fn new() -> Self {
        let origin = Local { east_m: 0.0, north_m: 0.0 };
        Surface {
            places: Places::new(),
            before: Kept::new(),
            texture: 0.0,
            middle: origin,
            moment: Moment { at: Micros(0), velocity_m_per_s: [0.0; 2] },
            drift_m: 0.0,
            since_m: 0.0,
            led_m: [0.0; 2],
            gone: origin,
            is_fresh: false,
            is_newest: false,
            grounds: Deque::new(),
            agreement: Agreement::new(),
            holding: HOLDING_FIRST,
            frames: HOLDING_COUNTS,
        }
    }

    /// Carries it on to a frame. `off_m_per_s`: by how much the velocity is known to be off, east and north; `sigma_m_per_s`: what else it may
    /// be off by, each axis.
    pub fn carry(&mut self, moment: Moment, off_m_per_s: [f32; 2], sigma_m_per_s: f32) {
        let before = core::mem::replace(&mut self.moment, moment);
        let step_us = moment.at.since(before.at);
        if !(0..=STEP_MAX_US).contains(&step_us) {
            self.clear();
            return;
        }
        let seconds = step_us as f32 * 1e-6;
        let [east_m, north_m] = way_m(before, moment);
        let way = [east_m - off_m_per_s[0] * seconds, north_m - off_m_per_s[1] * seconds];
        self.middle = self.middle.moved(way);
        self.gone = self.gone.moved(way);
        self.drift_m += sigma_m_per_s * seconds;
        self.since_m += sigma_m_per_s * seconds;
    }

    /// Forgets all evidence.
    fn clear(&mut self) {
        self.grounds.clear();
        self.agreement = Agreement::new();
    }

    /// Moves it so that it lies around the nadir of a search, and says by how many pixels (columns, rows) its middle is off that: each −1, 0
    /// or 1. Evidence that lies nowhere near is forgotten.
    ///
    /// `expected`: where the navigation has it, and one sigma of that, each axis, metres; 0 where it does not say. It counts
    /// once, before there is any evidence.
    ///
    /// `side_m`: smaller side of the frame's footprint.
    pub fn around(&mut self, nadir: Local, expected: (Local, f32), side_m: f32, px_m: f32) -> (i16, i16) {
        let is_other = |ground: &Local| ground.off_m(self.gone) >= FRESH * side_m;
        let mut grounds = self.grounds.iter().rev();
        let newest = grounds.next().is_none_or(is_other);
        let others = grounds.all(is_other);
        (self.is_fresh, self.is_newest) = (newest && others, !newest && others);
        if self.grounds.is_empty() {
            (self.middle, self.drift_m) = (nadir, 0.0);
            self.places = Places::expected(self.steps(expected.0, px_m), expected.1 / (f32::from(STEP_PX) * px_m));
            return (0, 0);
        }
        let off = |metres: f32| round((metres / px_m).clamp(-1e3, 1e3)) as i16;
        let by = (off(self.middle.east_m - nadir.east_m), off(nadir.north_m - self.middle.north_m));
        let steps = |px: i16| px / STEP_PX;
        let (cols, rows) = (steps(by.0), steps(by.1));
        if cols.unsigned_abs().max(rows.unsigned_abs()) as usize >= SHIFTS {
            self.clear();
            return self.around(nadir, expected, side_m, px_m);
        }
        self.shift(cols, rows, px_m);
        (by.0 - STEP_PX * cols, by.1 - STEP_PX * rows)
    }

    /// Moves the middle by so many shifts to the left and upwards.
    fn shift(&mut self, cols: i16, rows: i16, px_m: f32) {
        if (cols, rows) == (0, 0) {
            return;
        }
        let step_m = f32::from(STEP_PX) * px_m;
        self.middle = self.middle.moved([-f32::from(cols) * step_m, f32::from(rows) * step_m]);
        self.places.shift(cols, rows);
        self.before.shift(cols, rows);
    }

    /// Steps from the middle to a place, (columns, rows).
    fn steps(&self, place: Local, px_m: f32) -> (f32, f32) {
        let step_m = f32::from(STEP_PX) * px_m;
        ((place.east_m - self.middle.east_m) / step_m, (self.middle.north_m - place.north_m) / step_m)
    }
}

impl Surface {
    /// The newest frame's ground is counted, with what dead reckoning may have been off by on the way to it.
    fn count_ground(&mut self, px_m: f32) {
        if self.grounds.back() == Some(&self.gone) {
            return;
        }
        if self.grounds.is_full() {
            self.grounds.pop_front();
        }
        // There is room.
        let _ = self.grounds.push_back(self.gone);
        (self.led_m, self.since_m) = ([0.0; 2], 0.0);
        if self.is_another_year() {
            self.places.fade(KEPT_SHARE);
        }
        // What is less than can be told goes on adding up.
        let steps = self.drift_m / (f32::from(STEP_PX) * px_m);
        if steps > DRIFT_MIN {
            self.places.widen(steps);
            self.drift_m = 0.0;
        }
        self.before = Kept::of(&self.places);
    }

    /// Adds the scores of a frame whose ground is fresh, or the newest and better seen than before.
    pub fn add(&mut self, frame: &Frame<'_>, px_m: f32) {
        if self.is_fresh {
            self.count_ground(px_m);
        } else if self.is_newest && frame.texture > BETTER * self.texture {
            self.places = self.before.places();
        } else {
            return;
        }
        self.texture = frame.texture;
        self.places.add(frame.scores, frame.weight, frame.top.score);
        self.places.settle();
    }

    /// Where all of it puts the nadir, if that is not on the border, and if dead reckoning may still be believed.
    pub fn top(&self, px_m: f32) -> Option<Decided> {
        if self.drift_m > DRIFT_MAX_PX * px_m {
            return None;
        }
        let (top, second) = self.places.highest();
        Some(Decided { nadir: self.nadir(&top, px_m)?, risk: risk(top.score - second) })
    }

    /// The nadir of the parabolas through a top, if that is not on the border and a place.
    fn nadir(&self, top: &Top, px_m: f32) -> Option<Local> {
        let at = |row: usize, col: usize| self.places.evidence.get(row).and_then(|line| line.get(col)).copied();
        let (above, left) = (top.row.checked_sub(1)?, top.col.checked_sub(1)?);
        let of = |before: f32, after: f32| vertex(before, top.score, after);
        let cols = top.col as f32 - MIDDLE as f32 + of(at(top.row, left)?, at(top.row, top.col + 1)?);
        let rows = top.row as f32 - MIDDLE as f32 + of(at(above, top.col)?, at(top.row + 1, top.col)?);
        let step_m = f32::from(STEP_PX) * px_m;
        let nadir = self.middle.moved([cols * step_m, -rows * step_m]);
        (nadir.east_m.abs() < FAR_M && nadir.north_m.abs() < FAR_M).then_some(nadir)
    }

    /// Whether a frame does not contradict the place where all of them together are.
    pub fn agrees(&self, frame: &Frame<'_>) -> bool {
        frame.weight * (frame.top.score - Top::of(&self.places.evidence).around(frame.scores)) <= CONTRADICTS
    }

    /// Counts a frame of which least squares held, or did not.
    pub fn count(&mut self, holds: bool) {
        self.frames = (self.frames + 1).min(HOLDING_FRAMES);
        self.holding += (f32::from(u8::from(holds)) - self.holding) / f32::from(self.frames + 1);
    }

    /// Whether the map seems to be of another year than the ground: least squares hold of few frames.
    pub fn is_another_year(&self) -> bool {
        self.holding < HOLDING_MIN
    }

    /// Least squares hold at a nadir: evidence against every place further off than what is called a wrong match. Where it is the place that
    /// is worth most the surface is moved a little, so that it is there.
    pub fn held(&mut self, nadir: Local, px_m: f32) {
        // Nothing takes the place of what is that certain.
        if self.is_fresh {
            self.count_ground(px_m);
            self.texture = f32::MAX;
        }
        let (cols, rows) = self.steps(nadir, px_m);
        let (col, row) = (MIDDLE as f32 + cols, MIDDLE as f32 + rows);
        self.places.hold(if self.is_fresh { HELD } else { 0.0 }, (col, row), HELD_STEPS);
        let top = self.places.settle();
        let is_there = (top.row as f32 - row).abs().max((top.col as f32 - col).abs()) <= HELD_STEPS;
        if is_there && let Some(before) = self.nadir(&top, px_m) {
            let by_m = self.towards(before, nadir, px_m);
            self.middle = self.middle.moved(by_m);
        }
    }

    /// A frame's own top lies at a nadir where all frames together put it `before`: the surface is moved a little, so that it is there, as far
    /// as frames of one piece of ground may move it.
    pub fn found(&mut self, before: Local, nadir: Local, px_m: f32) {
        let by_m = self.towards(before, nadir, px_m);
        let led_m: [f32; 2] = core::array::from_fn(|axis| self.led_m[axis] + by_m[axis]);
        let most_m = hypot(LED_MAX_PX * px_m, self.since_m);
        let share = (most_m / hypot(led_m[0], led_m[1]).max(f32::MIN_POSITIVE)).min(1.0);
        let led_m = led_m.map(|metres| share * metres);
        self.middle = self.middle.moved(core::array::from_fn(|axis| led_m[axis] - self.led_m[axis]));
        self.led_m = led_m;
    }

    /// A share of the way from one place to another, metres east and north; what dead reckoning may be off by shrinks with it.
    fn towards(&mut self, before: Local, nadir: Local, px_m: f32) -> [f32; 2] {
        let off_m = nadir.off_m(before);
        let most_m = ASIDE_MAX_PX * px_m;
        let gain = if off_m > most_m { GAIN * most_m / off_m } else { GAIN };
        self.drift_m *= 1.0 - gain;
        [nadir.east_m - before.east_m, nadir.north_m - before.north_m].map(|metres| gain * metres)
    }
}

/// The scores of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Frame<'s> {
    scores: &'s Scores,
    top: Top,
    /// Evidence of a score of 1, and what it would be if it were not limited.
    weight: f32,
    texture: f32,
}

impl<'s> Frame<'s> {
    /// Over so many valid pixels.
    ///
    /// Where it would say more than it may, all of it says less: cut off it would have a top of a single shift, and the next one's top lies
    /// beside that.
    pub fn new(scores: &'s Scores, valid: u32) -> Self {
        let top = Top::of(scores);
        let texture = valid as f32 * top.curvature(scores).max(CURVATURE_MIN);
        let lead = texture * (top.score - top.second(scores));
        let weight = if lead > CAP { texture * (CAP / lead) } else { texture };
        Frame { scores, top, weight, texture }
    }
}

/// The probability that the highest of a surface, which leads by so much, is a wrong place.
fn risk(lead: f32) -> f32 {
    let log_odds = ALWAYS - EVIDENCE * exp(POWER * ln(lead.max(f32::MIN_POSITIVE)));
    1.0 / (1.0 + exp(-log_odds))
}

#[cfg(test)]
mod tests;
