//! What each risk and covariance is made of, and what happened, a line a patch, for whoever fits or judges them.

use super::{Outcome, Trial};
use std::fmt::Write;

/// The head of [`lines()`].
pub const HEAD: &str = "ground,reference,col,row,side,radius,score,lead,curvature,steadiness,holds,on_border,risk,accepted,off_px,\
     off_col,off_row,var_col,var_row,cov,parts_col,parts_row,parts_cov,agreement,quarters,scatter_col,scatter_row\n";

/// Lines of the patches of one pair, `pair` being the places of ground and reference among the files.
pub fn lines(trial: &Trial, pair: (usize, usize), outcomes: &[Outcome]) -> String {
    outcomes.iter().fold(String::new(), |mut text, Outcome { at: [col, row], directions, found, odds, .. }| {
        let (evidence, parts, solution) = (&found.peak.evidence, &found.peak.covariance, &found.solution);
        let odds = odds.unwrap_or_default();
        let off_px = directions.off[0].hypot(directions.off[1]);
        let is = u8::from;
        // To a string this cannot fail.
        let _ = writeln!(
            text,
            "{},{},{col:.2},{row:.2},{},{},{},{},{},{},{},{},{},{},{off_px:.3},\
             {:.4},{:.4},{},{},{},{},{},{},{},{},{},{}",
            pair.0,
            pair.1,
            trial.side,
            trial.radius,
            evidence.score,
            evidence.lead,
            evidence.curvature,
            evidence.steadiness,
            is(found.holds),
            is(found.peak.on_border),
            found.risk,
            is(directions.accepted),
            directions.off[0],
            directions.off[1],
            directions.variance[0],
            directions.variance[1],
            directions.covariance,
            parts[(0, 0)],
            parts[(1, 1)],
            parts[(0, 1)],
            solution.agreement,
            odds.count,
            odds.scatter[(0, 0)],
            odds.scatter[(1, 1)],
        );
        text
    })
}
