//! The paper's Table 5 of this block: what its points are worth, and how many there are of everything.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::{NONE, number, whole};

/// Errors of the check points of the paper's other flight, plan and height, metres (4.3; the table itself is lost).
const PAPER_M: [f64; 2] = [0.088, 0.106];

impl Page<'_> {
    /// Table 5.
    pub(super) fn points(&self) -> Markup {
        html! {
            table {
                thead { tr { th { "5 · Unknown points, sigma" } th class="r" { "Median" } th class="r" { "Worst" } th class="r" { "Point" } } }
                tbody { @for (k, axis) in ["East", "North", "Up"].iter().enumerate() { (self.point_row(axis, k)) } }
            }
            p class="note" {
                "Formal, from the adjustment itself: a block has no check points, whose errors hold what the model lacks too. The paper’s are "
                (number(PAPER_M[0], 3, "m")) " in plan and " (number(PAPER_M[1], 3, "m")) " in height, at check points of another flight."
            }
        }
    }

    /// What the block has.
    pub(super) fn counts(&self) -> Markup {
        let block = self.block;
        let known = block.points.iter().filter(|point| !point.is_free).count();
        let mut images: Vec<_> = self.observations.seen.iter().map(|seen| (seen.station, seen.head)).collect();
        images.sort_unstable();
        images.dedup();
        let rays = self.observations.seen.len() as f64 / block.points.len().max(1) as f64;
        let unknown = block.stations.iter().filter(|station| station.is_free).count();
        let row = |name: &str, value: String| html! { tr { th { (name) } td class="n" { (value) } } };
        let count = |name: &str, count: usize| row(name, whole(count as u64));
        html! {
            table {
                thead { tr { th { "What it has" } th class="r" { "Count" } } }
                tbody {
                    (count("Stations", block.stations.len()))
                    (count("… unknown", unknown))
                    (count("… with position or attitude known to a sigma", block.station_priors.len()))
                    (count("Images of single heads", images.len()))
                    (count("Points", block.points.len()))
                    (count("… known exactly", known))
                    (count("… known to a sigma", block.point_priors.len()))
                    (row("Rays of a point, mean", number(rays, 1, "")))
                }
            }
        }
    }

    fn point_row(&self, axis: &str, k: usize) -> Markup {
        let all = self.calibration.point_sigmas_m.iter().zip(&self.block.points).enumerate();
        let mut sigmas: Vec<(f64, usize)> =
            all.filter(|(_, (_, point))| point.is_free).map(|(index, (sigma, _))| (sigma[k], index)).collect();
        sigmas.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (median, worst) = (sigmas.get(sigmas.len() / 2), sigmas.last());
        let metres = |of: Option<&(f64, usize)>| of.map_or_else(|| NONE.to_owned(), |of| number(of.0, 3, "m"));
        html! {
            tr {
                th { (axis) }
                td class="n" { (metres(median)) }
                td class="n" { (metres(worst)) }
                td class="n" { (worst.map_or_else(|| NONE.to_owned(), |of| of.1.to_string())) }
            }
        }
    }
}
