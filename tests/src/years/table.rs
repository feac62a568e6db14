//! What many trials come to: coverage, what was wrong of the accepted, and whether stated risks and variances are true.

use super::{Answer, Outcome};

/// A place that is further off than this is wrong, pixels.
pub const WRONG_PX: f64 = 3.0;
/// One within this is right; years are half a pixel apart.
pub const RIGHT_PX: f64 = 1.5;

impl Answer {
    fn off_px(&self) -> f64 {
        self.off[0].hypot(self.off[1])
    }

    /// Squared error over the covariance that is stated.
    fn squared(&self) -> f64 {
        let ([col, row], [of_col, of_row], both) = (self.off, self.variance, self.covariance);
        let determinant = of_col * of_row - both * both;
        (col * col * of_row - 2.0 * col * row * both + row * row * of_col) / determinant
    }

    fn is_wrong(&self) -> bool {
        self.off_px() > WRONG_PX
    }
}

/// Squared errors over their covariance that one in 100 and one in 270,000 normal errors of two axes pass.
const BEYOND: [f64; 2] = [9.21, 25.0];

/// The largest share of all answers that can be taken, surest first, with at most such a share of wrong ones among them: the threshold is
/// chosen in hindsight.
pub fn coverage(answers: &[Answer], wrong_share: f64) -> f64 {
    let mut sorted: Vec<&Answer> = answers.iter().collect();
    sorted.sort_by(|a, b| b.confidence.total_cmp(&a.confidence));
    let (mut wrong, mut best) = (0, 0);
    for (taken, answer) in (1..).zip(sorted) {
        wrong += usize::from(answer.is_wrong());
        if wrong as f64 <= wrong_share * f64::from(taken) {
            best = taken;
        }
    }
    f64::from(best) / answers.len().max(1) as f64
}

/// One line for a matcher: how many are right, coverage at two shares of wrong ones, what its own decision accepts, how much of that is wrong,
/// the mean of the squared errors over the covariances that are stated (2 where they are true), and how many are far out.
pub fn line(name: &str, answers: &[Answer]) -> String {
    let count = answers.len().max(1) as f64;
    let right = answers.iter().filter(|answer| answer.off_px() <= RIGHT_PX).count() as f64 / count;
    let accepted: Vec<&Answer> = answers.iter().filter(|answer| answer.accepted).collect();
    let wrong = accepted.iter().filter(|answer| answer.is_wrong()).count();
    let good: Vec<f64> = accepted.iter().filter(|answer| !answer.is_wrong()).map(|answer| answer.squared()).collect();
    let share =
        |of: &dyn Fn(f64) -> f64| good.iter().map(|&squared| of(squared)).sum::<f64>() / good.len().max(1) as f64;
    let nees = share(&|squared| squared);
    let [far, beyond] = BEYOND.map(|limit| share(&|squared| f64::from(u8::from(squared > limit))));
    format!(
        "{name:18} {:7} {right:6.3} {:7.3} {:7.3} {:8.3} {wrong:6} {nees:7.2} {far:7.4} {beyond:8.1e}",
        answers.len(),
        coverage(answers, 1e-3),
        coverage(answers, 1e-2),
        accepted.len() as f64 / count,
    )
}

/// The head of [`line()`].
pub const HEAD: &str = "matcher             trials  right  at1e-3  at1e-2 accepted  wrong    NEES   >9.21      >25";

/// Stated risks against what happened, in half decades: their mean, how many were wrong, of how many.
pub fn reliability(stated: impl Iterator<Item = (f64, bool)>) -> Vec<(f64, usize, usize)> {
    let mut bins = vec![(0.0, 0, 0); 11];
    for (risk, is_wrong) in stated {
        let bin = ((risk.log10() + 5.0) * 2.0).floor().clamp(0.0, 10.0) as usize;
        bins[bin].0 += risk;
        bins[bin].1 += usize::from(is_wrong);
        bins[bin].2 += 1;
    }
    bins.into_iter().filter(|bin| bin.2 > 0).map(|(sum, wrong, count)| (sum / count as f64, wrong, count)).collect()
}

/// What patches' directions state, and whether they were wrong.
pub fn stated(outcomes: &[Outcome]) -> impl Iterator<Item = (f64, bool)> {
    outcomes.iter().filter_map(|outcome| Some((outcome.directions.risk?, outcome.directions.is_wrong())))
}

/// Lines of a [`reliability`] with their head.
pub fn reliability_lines(bins: &[(f64, usize, usize)]) -> Vec<String> {
    let line = |&(mean, wrong, count): &(f64, usize, usize)| {
        format!("{mean:11.1e} {wrong:6} {count:7} {:9.1e}", wrong as f64 / count as f64)
    };
    let head = "stated risk  wrong      of  observed".to_owned();
    [String::new(), head].into_iter().chain(bins.iter().map(line)).collect()
}

#[cfg(test)]
mod tests {
    use super::{Answer, coverage};

    #[test]
    fn coverage_takes_the_surest_first() {
        let answer = |confidence: f64, off: f64| Answer {
            off: [off, 0.0],
            variance: [1.0; 2],
            covariance: 0.0,
            confidence,
            risk: None,
            accepted: true,
        };
        let answers = [answer(1.0, 0.0), answer(4.0, 0.0), answer(3.0, 0.0), answer(2.0, 9.0)];
        assert_eq!(coverage(&answers, 0.0), 0.5);
        assert_eq!(coverage(&answers, 0.25), 1.0);
        assert_eq!(coverage(&answers, 0.24), 0.5);
    }
}
