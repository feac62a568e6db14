//! From the scores of a search to an accepted sub-pixel match, or a doubt.

use super::View;
use super::judge::{AcceptRule, Doubt};
use super::refine::{Prior, RefineError, SubPixel, refine};
use super::search::Peak;
use crate::rectify::Run;

/// Why there is no match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Rejection {
    /// It is doubtful.
    Doubt(Doubt),
    /// It could not be refined.
    Refine(RefineError),
}

impl From<Doubt> for Rejection {
    fn from(doubt: Doubt) -> Self {
        Rejection::Doubt(doubt)
    }
}

impl From<RefineError> for Rejection {
    fn from(error: RefineError) -> Self {
        Rejection::Refine(error)
    }
}

/// Refines the peak and decides.
///
/// Where a second place correlates almost as well, both are refined and their residuals compared: least-squares
/// matching does not count changed ground, which correlation does, and at a wrong place the residuals stay large. The
/// better one wins, by a clear margin or not at all.
///
/// # Errors
/// [`Rejection`].
pub fn decide(
    patch: &View<'_>,
    runs: &[Run],
    reference: &View<'_>,
    radius: u16,
    peak: &Peak,
    prior: Prior,
    rule: &AcceptRule,
) -> Result<SubPixel, Rejection> {
    let valid = runs.iter().map(|run| run.end.saturating_sub(run.start) as u32).sum();
    rule.peak(peak, valid)?;
    let solution = refine(patch, runs, reference, radius, peak, prior);
    if rule.leads(peak, valid) {
        let solution = solution?;
        rule.solution(&solution, valid)?;
        return Ok(solution);
    }
    let (d_col, d_row) = peak.second_at;
    let rival = refine(patch, runs, reference, radius, &Peak { d_col, d_row, ..*peak }, prior);
    let winner = match (solution, rival) {
        (Ok(solution), Ok(rival)) => {
            if rule.contest(&solution, &rival)? {
                solution
            } else {
                rival
            }
        }
        // A place that cannot even be refined is no rival, and no match.
        (Ok(solution), Err(_)) => solution,
        (Err(_), Ok(rival)) => rival,
        (Err(error), Err(_)) => return Err(error.into()),
    };
    rule.solution(&winner, valid)?;
    Ok(winner)
}
