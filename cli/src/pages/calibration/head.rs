//! Title, verdict and the figures that matter.

use super::{Page, rms};
use maud::{Markup, html};
use plumbline_charts::format::{NONE, number, whole};
use plumbline_charts::page::key;
use plumbline_survey::adjust::Loss;
use plumbline_survey::calibrate::OUTLIER_SIGMAS;

impl Page<'_> {
    pub(super) fn head(&self) -> Markup {
        let calibration = self.calibration;
        let (equations, unknowns) = calibration.size;
        let seams = self.seams.rms_and_max(None);
        let seams = seams.map_or_else(|| NONE.to_owned(), |(rms, max)| format!("{rms:.3} / {}", number(max, 3, "px")));
        let gain =
            self.gain().map_or_else(|| NONE.to_owned(), |(from, to)| format!("{from:.2} → {}", number(to, 2, "px")));
        let count = |count: usize| whole(count as u64);
        html! {
            header {
                p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · calibration report" }
                h1 { "Camera of " (calibration.heads.len()) @if calibration.heads.len() == 1 { " head" } @else { " heads" } }
                p class="note" {
                    (count(self.observations.seen.len())) " observations of " (count(calibration.points.len())) " points from "
                    (count(calibration.stations.len())) " stations. Heads are counted from 1, stations and points from 0, as in the observations."
                }
                p class="verdict" { (self.verdict()) }
                @if !calibration.outliers.is_empty() {
                    p class="verdict bad" {
                        (calibration.outliers.len()) " of the observations are off by more than " (OUTLIER_SIGMAS)
                        " of their residuals’ standard deviations; the worst are listed below."
                    }
                }
                div class="keys" {
                    (key(&number(calibration.sigma0_px, 3, "px"), "sigma0, standard deviation of an image coordinate"))
                    (key(&count(calibration.iterations), "iterations"))
                    (key(&format!("{} / {}", count(equations), count(unknowns)), "equations / unknowns"))
                    (key(&count(calibration.outliers.len()), &format!("outliers beyond {OUTLIER_SIGMAS} sigmas")))
                    (key(&seams, "predicted seams, RMS / largest"))
                    (key(&gain, "residuals before → after, RMS"))
                }
            }
        }
    }

    /// One line: what an image coordinate is worth against what was assumed, and what the heads gained.
    fn verdict(&self) -> String {
        let calibration = self.calibration;
        let (equations, unknowns) = calibration.size;
        // sigma0 squared is chi squared over its degrees of freedom.
        let reach = 1.96 / (2.0 * (equations - unknowns) as f64).sqrt();
        let against = match calibration.sigma0 {
            found if found > 1.0 + reach => "worse than assumed: the noise is larger, or the model lacks something",
            found if found < 1.0 - reach => "better than assumed",
            _ => "as assumed",
        };
        let sigmas = &self.block.sigma_px;
        let assumed = sigmas.iter().sum::<f64>() / sigmas.len() as f64;
        let shrunk = self.gain().map_or_else(String::new, |(before, after)| {
            let (before, after) = (number(before, 2, "px"), number(after, 2, "px"));
            format!(" Calibration brings the residuals from {before} down to {after} RMS.")
        });
        let robust = match self.block.loss {
            Loss::Squares => String::new(),
            Loss::Huber(limit) => format!(" Residuals beyond {limit} sigmas count by their length."),
        };
        format!(
            "An image coordinate was weighted as good to {} (a priori) and proves to be good to {} (a posteriori), {against}. All standard \
             deviations on this page are scaled by what was found.{robust}{shrunk}",
            number(assumed, 2, "px"),
            number(calibration.sigma0_px, 2, "px"),
        )
    }

    /// Root mean square of all residuals before and after; `None` where nothing of the heads was unknown.
    fn gain(&self) -> Option<(f64, f64)> {
        let after = rms(self.calibration.residuals.iter().map(|residual| &residual.v_px))?;
        let before = rms(self.before.shown().iter().flatten())?;
        (!self.calibration.unknowns.is_empty()).then_some((before, after))
    }
}
