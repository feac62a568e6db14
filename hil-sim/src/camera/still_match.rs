//! The core's matchers on single pictures.

pub mod between;
pub mod quarters;

use crate::coefficients;
use plumbline_core::image::{Run, View};
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::matching::correlation;
use plumbline_core::matching::directions::risk::{RISK_MIN, Rule};
use plumbline_core::matching::{MatchError, Prior, Rejection};
use plumbline_core::matching::{directions, search};
use plumbline_core::pipeline::Refusal;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::Picture;
use serde::Serialize;

/// Where a patch's centre lies relative to the reference's centre.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Columns to the right, pixels.
    pub d_col: f32,
    /// Rows downwards, pixels.
    pub d_row: f32,
    /// Normalised cross-correlation at the peak, of what the matcher looks at.
    pub score: f32,
    /// The best one away from the peak.
    pub second_peak: f32,
    /// One sigma of `d_col`, pixels.
    pub sigma_col: f32,
    /// One sigma of `d_row`.
    pub sigma_row: f32,
    /// Probability that the place is wrong by more than three pixels.
    pub risk: f32,
    /// Digest of the numbers that the risk is made of; null where none is stated.
    pub risk_coefficients: Option<String>,
    /// Whether the match is to be believed.
    pub accepted: bool,
    /// Why not.
    pub reason: Option<&'static str>,
}

/// A still picture is taken to be turned and scaled rightly to this sigma: half a degree and half a percent.
const PRIOR: Prior = Prior { turn_rad: 0.0087, scale: 0.005 };

/// Finds `patch` within ±`radius` of a place in `reference`, which may be of another year: by gradient directions. `near`: column and row of
/// that place; the middle unless given. Where patch and search do not fit around it, they are moved as far as they must.
/// `risk_max`: what is accepted, at least [`RISK_MIN`]. `map_px`: one sigma on each axis of where the reference has its ground, pixels.
///
/// # Errors
/// One sentence for pictures without texture or larger than the matcher takes, and for a risk below what it can state.
pub fn find(
    patch: &Picture,
    runs: &[Run],
    (reference, near): (&Picture, Option<(f64, f64)>),
    radius: u16,
    (risk_max, map_px): (f32, f32),
) -> Result<Place, InputError> {
    if !(RISK_MIN..1.0).contains(&risk_max) {
        let why =
            format!("a risk of {risk_max} cannot be asked for: what it was learnt from supports {RISK_MIN} to below 1");
        return Err(InputError::new(why));
    }
    let (window, off) = window(patch, reference, near, radius)?;
    let view = View::new(&patch.pixels, size(patch)).ok_or_else(|| InputError::new("the patch is empty"))?;
    let mut scores = vec![0; (2 * usize::from(radius) + 1).pow(2)];
    let mut bytes = vec![0; directions::search::working_bytes(view.size(), window.size())];
    let rule = (PRIOR, &Rule { risk_max, ..Rule::default() });
    let located = directions::locate(&view, runs, &window, radius, rule, (&mut bytes, &mut scores)).map_err(told)?;
    let solution = between::solution(&view, runs, (&window, radius), &located, PRIOR, map_px);
    let sigma = |axis| solution.joint[(axis, axis)].sqrt();
    Ok(Place {
        d_col: solution.d_col + off.0,
        d_row: solution.d_row + off.1,
        score: located.peak.score,
        second_peak: located.peak.second,
        sigma_col: sigma(0),
        sigma_row: sigma(1),
        risk: located.risk,
        risk_coefficients: Some(coefficients::of_match()),
        accepted: located.accepted.is_ok(),
        reason: located.accepted.err().map(named),
    })
}

/// Lays `patch` onto `reference`, a picture of the same moment, within ±`radius`: by the matcher that flies, which sees finer detail. Scores are
/// those of the greys; no risk is stated (1).
///
/// # Errors
/// As [`find`].
pub fn align(patch: &Picture, runs: &[Run], reference: &Picture, radius: u16) -> Result<Place, InputError> {
    let (window, off) = window(patch, reference, None, radius)?;
    let view = View::new(&patch.pixels, size(patch)).ok_or_else(|| InputError::new("the patch is empty"))?;
    let mut scores = vec![0; (2 * usize::from(radius) + 1).pow(2)];
    let mut bytes = vec![0; search::working_bytes(window.size())];
    let rule = (PRIOR, &AcceptRule::default());
    let located = correlation::locate(&view, runs, &window, radius, rule, (&mut bytes, &mut scores)).map_err(told)?;
    let shift = located.shift();
    let sigma = |axis| located.refined.map_or(f32::INFINITY, |solution| solution.joint[(axis, axis)].sqrt());
    Ok(Place {
        d_col: shift.0 + off.0,
        d_row: shift.1 + off.1,
        score: located.grey_correlation[0],
        second_peak: located.grey_correlation[1],
        sigma_col: sigma(0),
        sigma_row: sigma(1),
        risk: 1.0,
        risk_coefficients: None,
        accepted: located.accepted.is_ok(),
        reason: located.accepted.err().map(named),
    })
}

fn size(picture: &Picture) -> (u16, u16) {
    (picture.cols as u16, picture.rows as u16)
}

fn named(rejection: Rejection) -> &'static str {
    Refusal::from(rejection).name()
}

fn told(error: MatchError) -> InputError {
    InputError::new(match error {
        MatchError::Featureless => "the patch has no valid pixels or only one grey",
        MatchError::OutsideReference => "the reference is smaller than patch and search",
        MatchError::Capacity => "the mask does not fit the patch",
    })
}

/// The part of the reference that a search looks at, its middle or around a place, and how far its centre lies off the reference's.
fn window<'a>(
    patch: &Picture,
    reference: &'a Picture,
    near: Option<(f64, f64)>,
    radius: u16,
) -> Result<(View<'a>, (f32, f32)), InputError> {
    let too_large = || InputError::new("the reference has more than 65535 columns or rows");
    if reference.cols > u16::MAX as usize || reference.rows > u16::MAX as usize {
        return Err(too_large());
    }
    let whole = View::new(&reference.pixels, size(reference)).ok_or_else(too_large)?;
    let inner = (size(patch).0 + 2 * radius, size(patch).1 + 2 * radius);
    let corner = |outer: usize, inner: u16| (outer as i32 - inner as i32) / 2;
    let around = |at: f64, outer: usize, inner: u16| {
        let most = outer.saturating_sub(inner.into()) as f64;
        (at - 0.5 * (f64::from(inner) - 1.0)).round().clamp(0.0, most) as i32
    };
    let (left, top) = match near {
        None => (corner(reference.cols, inner.0), corner(reference.rows, inner.1)),
        Some((col, row)) => (around(col, reference.cols, inner.0), around(row, reference.rows, inner.1)),
    };
    let window = whole
        .window(left, top, inner)
        .ok_or_else(|| InputError::new("the reference is smaller than patch and search"))?;
    // The window's centre may lie half a pixel off the reference's.
    let off =
        |corner: i32, inner: u16, outer: usize| corner as f32 + 0.5 * (inner as f32 - 1.0) - 0.5 * (outer as f32 - 1.0);
    Ok((window, (off(left, inner.0, reference.cols), off(top, inner.1, reference.rows))))
}
