//! When the next planned exposure is due.
//!
//! A plan is strips of points on the tile's grid. A point is due when the camera's coordinate along the strip reaches it.
//! Positions are few and late, so the camera's position is predicted again at every call, and an exposure is committed to as
//! late as the calls and the trigger allow: [`COMMIT_US`] ahead. What is doubtful is not exposed and counted with its
//! reason.
//!
//! The order is that of the plan and never goes back: a point is exposed once or never. Turns do not trigger, since points
//! lie ahead of who turns in towards them, and beside or behind who flies another way. Where a later strip is entered, all
//! before it have been passed by; so a board that boots in mid-flight goes on at the strip that is flown.
//!
//! Cost: some 300 instructions a call on a strip; beside it the later strips are checked, some 150 each.

use crate::math::{self, hypot};
use crate::pose::position::PositionState;
use crate::tile::Local;
use crate::units::{Micros, Radians};

/// An exposure is committed to when it is at most so far ahead, microseconds. Calls are at most 100 ms apart, so it is at
/// least half of this ahead then.
pub const COMMIT_US: u32 = 200_000;
/// What is nearer than this cannot be triggered any more, microseconds.
pub(crate) const LEAST_US: u32 = 40_000;
/// Slower than this, metres a second, nothing flies along a strip.
const SPEED_MIN: f32 = 0.5;
/// Cosine of the largest angle between velocity and strip, 45 degrees: beyond it the vehicle turns.
const COS_ALONG: f32 = 0.707;
/// Cosine of that angle where a later strip is entered, 15 degrees: a turn that crosses its line does not give up the strips
/// before.
const COS_ENTERED: f32 = 0.966;
/// Multiple of the limit across within which a vehicle still flies this strip, and its points are missed; beyond it is
/// elsewhere. Chosen.
const BESIDE: f32 = 3.0;
/// Exposures that are remembered until their frames have been stamped. A call commits to one at most, and calls are 50 ms apart:
/// those of [`COMMIT_US`] ahead, and of as long behind, in which a frame is read out and worked on.
const TAKEN: usize = 8;
/// A frame's mid-exposure is this near to the one that was committed to, microseconds. Chosen between what a stamp by
/// pulses is off, some microseconds, and 25 ms, half of the 50 ms between two exposures.
const SAME_US: u32 = 5_000;

/// A strip in the order of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strip {
    /// Number of its first point in flight.
    pub first: u32,
    /// Number behind its last one.
    pub end: u32,
    /// Direction of flight from grid north: that of a strip whose points do not say it, since there is but one.
    pub course: Radians,
}

/// A plan, wherever it lies.
pub trait Planned {
    /// Strip `number` from 0; `None` behind the last.
    fn strip(&self, number: u16) -> Option<Strip>;
    /// Where photo `number` is to be taken.
    fn point(&self, number: u32) -> Option<Local>;
}

/// What a plan asks of its exposures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Least time between two, microseconds: what the camera, and the work on a frame, can do.
    pub interval_us: u32,
    /// Farthest from the line, metres.
    pub across_m: f32,
}

/// What became of the points so far.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Committed to.
    pub exposed: u32,
    /// Missed: behind the vehicle before they could be committed to.
    pub passed: u32,
    /// Missed: too far off the line.
    pub off_line: u32,
    /// Missed: too soon after the one before.
    pub too_soon: u32,
}

/// An exposure that is committed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Exposure {
    /// Number of the photo.
    pub photo: u32,
    /// When its middle is to be.
    pub mid: Micros,
}

/// How far a plan has been flown.
#[derive(Clone, Copy, Debug)]
pub struct Exposures {
    limits: Limits,
    strip: u16,
    next: u32,
    /// The newest ones, in no order.
    taken: [Option<Exposure>; TAKEN],
    counts: Counts,
}

/// The camera against a strip's line.
struct Along {
    /// Unit vector, (east, north).
    towards: (f32, f32),
    /// Metres a second along it, and across it to the right.
    speed: (f32, f32),
}

impl Along {
    /// `None` where the camera does not fly along the strip: the cosine of the angle between is not above `cos`.
    fn of(plan: &impl Planned, strip: &Strip, camera: &PositionState, cos: f32) -> Option<Along> {
        let (first, last) = (plan.point(strip.first)?, plan.point(strip.end.wrapping_sub(1))?);
        let (east, north) = (last.east_m - first.east_m, last.north_m - first.north_m);
        let length = hypot(east, north);
        let towards = if length > 0.0 { (east / length, north / length) } else { math::sin_cos(strip.course.0) };
        let (v_east, v_north) = (camera.east_m_per_s, camera.north_m_per_s);
        let speed = (v_east * towards.0 + v_north * towards.1, v_east * towards.1 - v_north * towards.0);
        let is_along = speed.0 > SPEED_MIN && speed.0 > cos * hypot(v_east, v_north);
        is_along.then_some(Along { towards, speed })
    }

    /// A point ahead of the camera: metres along the strip, and metres that the camera is right of it.
    fn to(&self, point: Local, camera: &PositionState) -> (f32, f32) {
        let (east, north) = (point.east_m - camera.east_m, point.north_m - camera.north_m);
        let (d_east, d_north) = self.towards;
        (east * d_east + north * d_north, north * d_east - east * d_north)
    }
}

impl Exposures {
    /// Nothing flown yet.
    pub const fn new(limits: Limits) -> Self {
        let counts = Counts { exposed: 0, passed: 0, off_line: 0, too_soon: 0 };
        Exposures { limits, strip: 0, next: 0, taken: [None; TAKEN], counts }
    }

    /// What became of the points so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Number of the point that comes next.
    pub fn next(&self) -> u32 {
        self.next
    }

    /// The photo whose exposure was committed to for `mid`.
    pub fn photo_at(&self, mid: Micros) -> Option<u32> {
        let is_it = |exposure: &&Exposure| exposure.mid.since(mid).unsigned_abs() <= SAME_US;
        self.taken.iter().flatten().find(is_it).map(|exposure| exposure.photo)
    }

    /// What to commit to `now`, the camera being at `camera`. To be called ten times a second.
    pub fn commit(&mut self, plan: &impl Planned, camera: &PositionState, now: Micros) -> Option<Exposure> {
        if self.along(plan, camera).is_none() {
            self.enter(plan, camera)?;
        }
        let (strip, along) = self.along(plan, camera)?;
        while self.next < strip.end {
            let (ahead_m, right_m) = along.to(plan.point(self.next)?, camera);
            let seconds = ahead_m / along.speed.0;
            // Named, so that what is no number is not due, nor on the line.
            let is_due = seconds * 1e6 <= COMMIT_US as f32;
            if !is_due {
                return None;
            }
            let photo = self.next;
            self.next += 1;
            if seconds * 1e6 < LEAST_US as f32 {
                self.counts.passed += 1;
                continue;
            }
            let is_on_line = (right_m + along.speed.1 * seconds).abs() <= self.limits.across_m;
            if !is_on_line {
                self.counts.off_line += 1;
                continue;
            }
            let mid = Micros(now.0.saturating_add(((seconds * 1e6) as u32).into()));
            let is_soon = |before: &Exposure| mid.since(before.mid).unsigned_abs() < self.limits.interval_us;
            if self.taken.iter().flatten().any(is_soon) {
                self.counts.too_soon += 1;
                continue;
            }
            let exposure = Exposure { photo, mid };
            self.taken[self.counts.exposed as usize % TAKEN] = Some(exposure);
            self.counts.exposed += 1;
            return Some(exposure);
        }
        self.strip += 1;
        None
    }

    /// The current strip, if the camera flies along it and near enough to mean it.
    fn along(&self, plan: &impl Planned, camera: &PositionState) -> Option<(Strip, Along)> {
        let strip = plan.strip(self.strip)?;
        let along = Along::of(plan, &strip, camera, COS_ALONG)?;
        let (_, right_m) = along.to(plan.point(self.next)?, camera);
        (right_m.abs() <= BESIDE * self.limits.across_m).then_some((strip, along))
    }

    /// Goes on to the later strip that the camera is on, if it is on one: near its line, between its ends.
    fn enter(&mut self, plan: &impl Planned, camera: &PositionState) -> Option<()> {
        let mut number = self.strip;
        loop {
            number = number.checked_add(1)?;
            let strip = plan.strip(number)?;
            let Some(along) = Along::of(plan, &strip, camera, COS_ENTERED) else { continue };
            let (to_first_m, right_m) = along.to(plan.point(strip.first)?, camera);
            let (to_last_m, _) = along.to(plan.point(strip.end.wrapping_sub(1))?, camera);
            let is_there = to_first_m * 1e6 <= along.speed.0 * COMMIT_US as f32 && to_last_m >= 0.0;
            if is_there && right_m.abs() <= self.limits.across_m {
                self.counts.passed += strip.first.saturating_sub(self.next);
                (self.strip, self.next) = (number, strip.first);
                return Some(());
            }
        }
    }
}

#[cfg(test)]
mod tests;
