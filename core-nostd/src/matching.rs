//! Where a rectified patch lies in the reference: what a matcher is asked, what it answers, and which one flies.
//!
//! `fix` and `pipeline` know what stands in this file and nothing of what is behind it. Another matcher is a module that
//! implements [`Matcher`] and a line here that chooses it.
//!
//! [`mod@correlation`] is the matcher that flies: [`mod@search`], correlation of high-pass images over whole-pixel shifts;
//! [`mod@refine`], least squares around the peak; [`acceptance`], what both must reach to become a fix. Far from the
//! predicted position [`mod@reacquire`] replaces the search. [`mod@perspective`] shows the tilt where the attitude is in doubt.
//!
//! [`mod@directions`] is the matcher for maps of another year, which states the risk of each match. In flight it judges what the one above finds.
//!
//! Constants whose doc speaks of *the four series* were measured over 1,500 synthetic matches of each: a tilted footprint in
//! 34 x 34 pixels, searched within ±10, shifted by up to 8; textures as in `tests/src/textures.rs`, waves of 5 to 40 pixels.
//! Easy: 40 grey levels, noise of 3 in the reference and 2 in the patch. Turned: a heading off by 0.5° (one sigma) and a
//! tenth of the rows of other ground besides. Hard: 15 grey levels, noise of 5 and 3, 0.5°, a fifth of other ground. Weak: 8
//! grey levels, noise of 6 and 3, 0.3°, a tenth of other ground. Of none of them a match that was off by a pixel was
//! accepted.

pub(crate) mod kernels;
mod histogram;
mod high_pass;
pub(crate) mod local_maximum;
mod grey_correlation;
mod coarse_ranking;
pub mod search;
pub mod refine;
pub mod perspective;
pub mod acceptance;
pub mod reacquire;
pub mod correlation;
pub mod directions;

use crate::image::{Run, View};
pub use acceptance::AcceptRule;
pub use grey_correlation::grey_correlation;
use nalgebra::Matrix2;
use perspective::Curvature;
use refine::SubPixel;

/// The matcher that flies.
pub type OnBoard = correlation::Correlation;

/// What a matcher is asked.
#[derive(Clone, Copy, Debug)]
pub struct Request<'a> {
    /// The rectified patch.
    pub patch: View<'a>,
    /// Its valid pixels, sorted by row.
    pub runs: &'a [Run],
    /// The reference tile.
    pub tile: View<'a>,
    /// The tile's (column, row) under the patch's upper left pixel, as predicted.
    pub predicted: (i32, i32),
    /// Where the nadir lies from the patch's centre, columns to the right and rows down.
    pub nadir: (i16, i16),
    /// How far off the prediction may be, pixels along each axis.
    pub radius: u16,
    /// What is known of turn and scale.
    pub prior: Prior,
    /// What an accepted match must reach.
    pub rule: &'a AcceptRule,
}

impl<'a> Request<'a> {
    /// The part of the tile that is searched; `None` if it does not lie wholly in it.
    fn window(&self) -> Option<View<'a>> {
        let ((cols, rows), radius) = (self.patch.size(), self.radius);
        let corner = (self.predicted.0 - radius as i32, self.predicted.1 - radius as i32);
        self.tile.window(corner.0, corner.1, (cols + 2 * radius, rows + 2 * radius))
    }
}

/// What is known of the picture's turn and scale before matching, one sigma each.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Prior {
    /// Of the heading, radians.
    pub turn_rad: f32,
    /// Of the height, as a share of it.
    pub scale: f32,
}

/// What a matcher answers, accepted or not. Shifts are those of the nadir against the predicted one, columns to the right and
/// rows downwards, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Match {
    /// The best estimate: sub-pixel where there is one, whole pixels otherwise.
    pub shift: (f32, f32),
    /// Whole-pixel shift with the highest score, of the patch's centre.
    pub peak: (i16, i16),
    /// Normalised cross-correlation of the greys at the peak and at the best other shift, 0 where there is none.
    pub grey_correlation: [f32; 2],
    /// The sub-pixel match of the patch's centre, accepted or not.
    pub refined: Option<SubPixel>,
    /// The shift that deserves to become a fix, or why none does.
    pub accepted: Result<Shift, Rejection>,
}

/// A shift with its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shift {
    /// Columns to the right, pixels.
    pub d_col: f32,
    /// Rows downwards, pixels.
    pub d_row: f32,
    /// Covariance of (d_col, d_row), square pixels.
    pub covariance: Matrix2<f32>,
    /// Variance in it of each axis that matches of the same ground share: that of a map of another year.
    pub map_variance: f32,
    /// How far turn and scale, by which the shift was carried from the patch's centre to the nadir, are the picture's own: 0 where
    /// they are the prior's or nothing was carried, 1 where they are the picture's alone.
    pub carried: Carried,
    /// Turn and scale.
    pub alone: Alone,
}

/// What the picture alone has of turn, clockwise, radians, and scale less 1: each with its variance, and nothing where it shows
/// nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alone {
    /// Of the turn.
    pub turn: Option<(f32, f32)>,
    /// Of the scale.
    pub scale: Option<(f32, f32)>,
}

/// Shares of 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Carried {
    /// Of the turn.
    pub turn: f32,
    /// Of the scale.
    pub scale: f32,
}

/// Finds a patch in a tile.
pub trait Matcher {
    /// Bytes of working memory that a search takes at most.
    const WORKING_BYTES: usize;

    /// Where the patch lies in the tile. `memory`: [`Matcher::WORKING_BYTES`] of any content.
    ///
    /// # Errors
    /// [`MatchError`] where nothing could be tried; whether what was found is good enough, [`Match::accepted`] says.
    fn locate(&mut self, request: &Request<'_>, memory: &mut [u8]) -> Result<Match, MatchError>;

    /// The curvature of the displacements over a picture that [`Matcher::locate`] has found with the same request, which shows the
    /// camera's tilt; `None` if the picture does not determine it. `memory`: as there.
    fn curvature(&mut self, request: &Request<'_>, found: &Match, memory: &mut [u8]) -> Option<Curvature>;
}

/// Why no match could be tried.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum MatchError {
    /// The patch, with the search radius on all sides, does not lie wholly in the reference.
    OutsideReference,
    /// The working memory is too small, or a run lies outside the patch.
    Capacity,
    /// The patch has no valid pixels, or no texture in them.
    Featureless,
}

/// Why a match is not accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// Fewer valid pixels than a distinctive template needs.
    FewPixels,
    /// The peak lies on the border of the search.
    OnBorder,
    /// The correlation is too low for the number of pixels.
    LowScore,
    /// Another shift is almost as good.
    Ambiguous,
    /// The sub-pixel solution's own sigma is too large, or too little of the picture agrees with it.
    Imprecise,
    /// Too few pixels for a sub-pixel solution, or no texture in one direction.
    TooLittle,
    /// The sub-pixel solution left the peak, or would invert the picture.
    Diverged,
    /// A second kind of evidence does not confirm it.
    Undecided,
}

/// Valid pixels of a patch.
fn valid(runs: &[Run]) -> usize {
    runs.iter().map(|run| run.end.saturating_sub(run.start) as usize).sum()
}
