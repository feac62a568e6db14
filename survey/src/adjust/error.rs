//! Why an adjustment has no solution.

/// Observations, points and unknowns are counted from 0, as the model has them.
#[derive(Clone, Debug, PartialEq)]
#[expect(missing_docs, reason = "what the fields are is said with their variant")]
pub enum SolveError {
    /// At the start values a point lies behind the camera that saw it.
    Behind { observation: usize },
    /// A point's rays are parallel to rounding.
    Parallel { point: usize },
    /// The equations have no single solution: the unknowns along which they have none, largest first, with their parts.
    Singular { along: Vec<(usize, f64)> },
    /// The steps did not come to an end; costs are half the sums of squares.
    NotConverged { iterations: usize, cost_start: f64, cost: f64 },
    /// No step lowers the cost any more although one should.
    Stuck { iterations: usize, cost_start: f64, cost: f64 },
    /// A residual or derivative is not a number.
    NotFinite,
    /// There is no memory for the equations.
    TooLarge,
}
