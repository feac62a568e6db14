//! From start values to the least squares: Gauss-Newton, damped (Levenberg-Marquardt) where a step does not help.

use super::error::SolveError;
use super::loss::Loss;
use super::model::Model;
use super::normal::{Equations, Layout, Reduced};
use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Llt, SymbolicLlt};
use faer::{Mat, Side};

/// How to iterate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How large residuals count.
    pub loss: Loss,
    /// Iterations after which it is given up.
    pub iterations_max: usize,
    /// Damping of the first iteration; 0 is Gauss-Newton as long as it helps.
    pub damping: f64,
    /// It has converged when a step promises to lower the cost by less than this part of it.
    pub gain_min: f64,
}

impl Default for Options {
    fn default() -> Self {
        Options { loss: Loss::Squares, iterations_max: 50, damping: 0.0, gain_min: 1e-10 }
    }
}

/// Where the iteration ended.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The unknowns.
    pub x: Vec<f64>,
    /// Half the sum of squared residuals (less what the loss takes off) at the start.
    pub cost_start: f64,
    /// And at the end.
    pub cost_end: f64,
    /// Steps that were taken.
    pub iterations: usize,
}

/// First damping after Gauss-Newton has failed; far below it there is none again.
const DAMPING_FIRST: f64 = 1e-4;
const DAMPING_NONE: f64 = 1e-7;
/// Damping beyond which no step is left.
const DAMPING_MAX: f64 = 1e16;
/// Costs are equal when they differ by less than this part: the rounding of a sum of squares.
const ROUNDING: f64 = 1e-12;
/// Under a loss that reweights: least fall of the cost in a step, as a part of it.
const REWEIGHTED_MIN: f64 = 1e-9;
/// Squared residual of an equation, in standard deviations, that is rounding alone.
const NOTHING: f64 = 1e-22;

/// An adjustment ready to be solved: the model, and what its equations have in common from one iteration to the next.
#[derive(Debug)]
pub struct Adjustment<'a, M: Model> {
    pub(super) equations: Equations<'a, M>,
    pub(super) symbolic: SymbolicLlt<usize>,
}

impl<'a, M: Model> Adjustment<'a, M> {
    /// Lays out the equations.
    ///
    /// # Errors
    /// [`SolveError::TooLarge`].
    pub fn new(model: &'a M, loss: Loss) -> Result<Self, SolveError> {
        let layout = Layout::new(model.structure());
        let symbolic = SymbolicLlt::try_new(layout.pattern.compressed().as_ref(), Side::Lower)
            .map_err(|_| SolveError::TooLarge)?;
        Ok(Adjustment { equations: Equations { model, layout, loss }, symbolic })
    }

    /// Solves from `start`; `on_step` is called after every step with its number and the cost after it.
    ///
    /// # Errors
    /// [`SolveError`] says why there is no solution.
    pub fn solve(
        &self,
        start: Vec<f64>,
        options: &Options,
        on_step: &mut dyn FnMut(usize, f64),
    ) -> Result<Solution, SolveError> {
        let equations = &self.equations;
        let Some(cost) = equations.cost(&start) else { return Err(equations.behind(&start)) };
        let nothing = NOTHING * equations.model.structure().equations() as f64;
        let mut now =
            Iterate { x: start, cost_start: cost, cost, damping: options.damping, growth: 2.0, iterations: 0 };
        loop {
            if !now.cost.is_finite() {
                return Err(SolveError::NotFinite);
            }
            let Iterate { iterations, cost_start, cost, .. } = now;
            if iterations == options.iterations_max {
                return Err(SolveError::NotConverged { iterations, cost_start, cost });
            }
            let Some((step, gain)) = self.trial(&now.x, now.damping) else {
                if now.damping == 0.0 {
                    return Err(self.singular(&now.x));
                }
                now.damp_more()?;
                continue;
            };
            let is_last = gain <= options.gain_min * cost;
            let moved: Vec<f64> = now.x.iter().zip(&step).map(|(x, step)| x + step).collect();
            match equations.cost(&moved) {
                Some(new) if new <= cost * (1.0 + ROUNDING) + nothing => {
                    let fall = cost - new;
                    (now.x, now.cost) = (moved, new.min(cost));
                    now.iterations += 1;
                    on_step(now.iterations, now.cost);
                    // Reweighting converges by a factor a step, and promises more than it keeps.
                    let hardly_fell = equations.loss != Loss::Squares && fall <= REWEIGHTED_MIN * now.cost;
                    if is_last || hardly_fell || new <= nothing {
                        break;
                    }
                    now.damp_less(if gain > 0.0 { fall / gain } else { 1.0 }, options);
                }
                _ if is_last => break,
                _ => now.damp_more()?,
            }
        }
        Ok(Solution { x: now.x, cost_start: now.cost_start, cost_end: now.cost, iterations: now.iterations })
    }

    /// The step under some damping and the gain it promises; `None` where the equations are not positive definite.
    fn trial(&self, x: &[f64], damping: f64) -> Option<(Vec<f64>, f64)> {
        let reduced = self.equations.reduced(x, damping).ok()?;
        let factor = self.factor(&reduced)?;
        let blocks: Vec<f64> = solved(&factor, &reduced.gradient).into_iter().map(|value| -value).collect();
        let (step, gain) = self.equations.step(x, &reduced, &blocks, damping).ok()?;
        step.iter().all(|step| step.is_finite()).then_some((step, gain))
    }

    /// Cholesky's factor of the reduced equations; `None` where they are not positive definite.
    pub(super) fn factor(&self, reduced: &Reduced) -> Option<Llt<usize, f64>> {
        let matrix = self.equations.layout.pattern.matrix(&reduced.values);
        Llt::try_new_with_symbolic(self.symbolic.clone(), matrix.as_ref(), Side::Lower).ok()
    }
}

/// Where the iteration stands.
struct Iterate {
    x: Vec<f64>,
    cost_start: f64,
    cost: f64,
    damping: f64,
    /// Factor of the damping at the next step that does not help.
    growth: f64,
    /// Steps taken.
    iterations: usize,
}

impl Iterate {
    /// After a step that does not help.
    fn damp_more(&mut self) -> Result<(), SolveError> {
        self.damping = if self.damping == 0.0 { DAMPING_FIRST } else { self.damping * self.growth };
        self.growth *= 2.0;
        if self.damping > DAMPING_MAX {
            let Iterate { iterations, cost_start, cost, .. } = *self;
            return Err(SolveError::Stuck { iterations, cost_start, cost });
        }
        Ok(())
    }

    /// After a step that lowered the cost by `ratio` of what it promised: Nielsen's rule for the trust region, as in Ceres.
    fn damp_less(&mut self, ratio: f64, options: &Options) {
        self.damping *= (1.0 - (2.0 * ratio - 1.0).powi(3)).max(1.0 / 3.0);
        self.growth = 2.0;
        if options.damping == 0.0 && self.damping < DAMPING_NONE {
            self.damping = 0.0;
        }
    }
}

/// S^-1 times a vector.
pub(super) fn solved(factor: &Llt<usize, f64>, right: &[f64]) -> Vec<f64> {
    let mut solution = Mat::from_fn(right.len(), 1, |row, _| right[row]);
    factor.solve_in_place(solution.as_mut());
    (0..right.len()).map(|row| solution[(row, 0)]).collect()
}
