//! The core's matcher on single pictures.

use plumbline_core::image::{Run, View};
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::matching::correlation::locate;
use plumbline_core::matching::search::working_bytes;
use plumbline_core::matching::{MatchError, Prior};
use plumbline_core::pipeline::Refusal;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::Picture;
use serde::Serialize;

/// Where a patch's centre lies relative to the reference's centre.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Columns to the right, pixels.
    pub d_col: f32,
    /// Rows downwards, pixels.
    pub d_row: f32,
    /// Normalised cross-correlation at the peak.
    pub score: f32,
    /// The best one away from the peak.
    pub second_peak: f32,
    /// Whether the match would become a fix.
    pub accepted: bool,
    /// Why not.
    pub reason: Option<&'static str>,
}

/// A still picture is taken to be turned and scaled rightly to this sigma: half a degree and half a percent.
const PRIOR: Prior = Prior { turn_rad: 0.0087, scale: 0.005 };

/// Finds `patch` within ±`radius` of the middle of `reference`, which must hold both.
///
/// # Errors
/// One sentence for pictures without texture or larger than the matcher takes.
pub fn find(patch: &Picture, runs: &[Run], reference: &Picture, radius: u16) -> Result<Place, InputError> {
    let size = |picture: &Picture| (picture.cols as u16, picture.rows as u16);
    let too_large = || InputError::new("the reference has more than 65535 columns or rows");
    if reference.cols > u16::MAX as usize || reference.rows > u16::MAX as usize {
        return Err(too_large());
    }
    let whole = View::new(&reference.pixels, size(reference)).ok_or_else(too_large)?;
    let window_size = (size(patch).0 + 2 * radius, size(patch).1 + 2 * radius);
    let corner = |outer: usize, inner: u16| (outer as i32 - inner as i32) / 2;
    let (left, top) = (corner(reference.cols, window_size.0), corner(reference.rows, window_size.1));
    let window = whole
        .window(left, top, window_size)
        .ok_or_else(|| InputError::new("the reference is smaller than patch and search"))?;
    // The window's centre may lie half a pixel off the reference's.
    let off =
        |corner: i32, inner: u16, outer: usize| corner as f32 + 0.5 * (inner as f32 - 1.0) - 0.5 * (outer as f32 - 1.0);
    let off = (off(left, window_size.0, reference.cols), off(top, window_size.1, reference.rows));

    let view = View::new(&patch.pixels, size(patch)).ok_or_else(|| InputError::new("the patch is empty"))?;
    let side = 2 * radius as usize + 1;
    let mut scores = vec![0; side * side];
    let mut bytes = vec![0; working_bytes(window_size)];
    let rule = (PRIOR, &AcceptRule::default());
    let located =
        locate(&view, runs, &window, radius, rule, (&mut bytes, &mut scores)).map_err(|error| match error {
            MatchError::Featureless => InputError::new("the patch has no valid pixels or only one grey"),
            MatchError::OutsideReference => InputError::new("the reference is smaller than patch and search"),
            MatchError::Capacity => InputError::new("the mask does not fit the patch"),
        })?;
    let shift = located.shift();
    Ok(Place {
        d_col: shift.0 + off.0,
        d_row: shift.1 + off.1,
        score: located.grey_correlation[0],
        second_peak: located.grey_correlation[1],
        accepted: located.accepted.is_ok(),
        reason: located.accepted.err().map(|rejection| Refusal::from(rejection).name()),
    })
}
