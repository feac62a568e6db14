//! The paper's tables of this camera. 1 to 4: where the heads' centres are, and how the heads are turned; 5 is in `points`.

use super::propagate::Propagated;
use super::{ARC_SECONDS, Page};
use maud::{Markup, html};
use plumbline_charts::format::number;
use plumbline_survey::adjust::rig::HEAD;
use plumbline_survey::adjust::rotation;
use plumbline_survey::calibrate::Symmetrised;

const ANGLES: [&str; 3] = ["φ", "ω", "κ"];

impl Page<'_> {
    pub(super) fn mounts(&self) -> Markup {
        // One head has no distances, and is no virtual camera.
        let are_several = self.calibration.heads.len() > 1;
        html! {
            section {
                h2 { "The paper’s tables, of this camera" }
                div class="two" {
                    @if are_several { div { (self.distances()) } }
                    div { (self.lever_arms()) }
                    div { (self.designed()) }
                    div { (self.calibrated()) }
                    @if are_several { div { (self.symmetrised()) } }
                    div { (self.points()) }
                }
            }
        }
    }

    fn are_centres_unknown(&self) -> bool {
        self.calibration.unknowns.iter().any(|unknown| (3..6).contains(&unknown.number))
    }

    /// Table 1.
    fn distances(&self) -> Markup {
        let heads = &self.calibration.heads;
        let distance = |heads: &[[f64; HEAD]], a: usize, b: usize| {
            (3..6).map(|k| (heads[a][k] - heads[b][k]).powi(2)).sum::<f64>().sqrt()
        };
        let pairs: Vec<_> = (0..heads.len()).flat_map(|a| (a + 1..heads.len()).map(move |b| (a, b))).collect();
        let sigmas = Propagated::new(self.calibration, |heads| {
            Some(pairs.iter().map(|&(a, b)| distance(heads, a, b)).collect())
        });
        let are_unknown = self.are_centres_unknown();
        html! {
            table {
                thead { tr { th { "1 · Centres apart, heads" } th class="r" { "Distance" } @if are_unknown { th class="r" { "Sigma" } } } }
                tbody {
                    @for (k, &(a, b)) in pairs.iter().enumerate() {
                        tr {
                            th { (a + 1) " and " (b + 1) }
                            td class="n" { (number(distance(heads, a, b), 4, "m")) }
                            @if are_unknown {
                                td class="n" { (number(sigmas.as_ref().map_or(f64::NAN, |all| 1e3 * all.variance(k).sqrt()), 2, "mm")) }
                            }
                        }
                    }
                }
            }
            p class="note" {
                @if are_unknown { "Lever arms are unknowns, held by what the block knows of them: these distances come from the adjustment." }
                @else { "Constrained: the distances are those of the lever arms given in the block and exact by construction. The paper’s own Table 1 is of an adjustment without that constraint, which puts centres apart by more than they can be." }
            }
        }
    }

    /// Table 2.
    fn lever_arms(&self) -> Markup {
        let cell = |head: usize, k: usize| {
            let change_mm = 1e3 * (self.calibration.heads[head][k] - self.block.heads[head].values[k]);
            html! {
                td class="n" {
                    (number(self.calibration.heads[head][k], 4, "m"))
                    @if let Some(sigma) = self.calibration.sigma(head, k) {
                        br; small { (signed(change_mm, 2, "")) " ± " (number(1e3 * sigma, 2, "mm")) }
                    }
                }
            }
        };
        html! {
            table {
                thead { tr { th { "2 · Lever arms" } @for axis in ["right", "forward", "up"] { th class="r" { (axis) } } } }
                tbody { @for head in 0..self.calibration.heads.len() { tr { th { "Head " (head + 1) } @for k in 3..6 { (cell(head, k)) } } } }
            }
            p class="note" {
                "From the virtual projection centre, on the platform’s axes. "
                @if self.are_centres_unknown() { "Small: change against the block, and standard deviation." } @else { "Given in the block." }
            }
        }
    }

    /// Table 3.
    fn designed(&self) -> Markup {
        html! {
            table {
                thead { tr { th { "3 · Design" } @for angle in ANGLES { th class="r" { (angle) } } } }
                tbody {
                    @for (index, head) in self.block.heads.iter().enumerate() {
                        tr { th { "Head " (index + 1) } @for k in 0..3 { td class="n" { (degrees(head.values[k])) } } }
                    }
                }
            }
            p class="note" { "Start values of the block: φ about the forward, ω about the right axis, κ about the axis of the head, head to platform." }
        }
    }

    /// Table 4, as it was adjusted.
    fn calibrated(&self) -> Markup {
        let cell = |head: usize, k: usize| {
            let (value, design) = (self.calibration.heads[head][k], self.block.heads[head].values[k]);
            let sigma = self.calibration.sigma(head, k).map(|sigma| sigma * ARC_SECONDS);
            angle(value, sigma, Some(value - design))
        };
        html! {
            table {
                thead { tr { th { "4 · Calibrated" } @for angle in ANGLES { th class="r" { (angle) } } } }
                tbody { @for head in 0..self.calibration.heads.len() { tr { th { "Head " (head + 1) } @for k in 0..3 { (cell(head, k)) } } } }
            }
            p class="note" { "Before symmetrising: what is given holds its design angles. Small: standard deviation in arc seconds, then the change against the design in arc minutes." }
        }
    }

    /// Table 4, as the virtual camera sees it.
    fn symmetrised(&self) -> Markup {
        let heads = &self.symmetrised.heads;
        let propagated = Propagated::new(self.calibration, |moved| {
            let moved = Symmetrised::new(moved).heads;
            let change = |(moved, head): (&[f64; HEAD], &[f64; HEAD])| [0, 1, 2].map(|k| half_turn(moved[k] - head[k]));
            Some(moved.iter().zip(heads).flat_map(change).collect())
        });
        let propagated = propagated.filter(|_| !self.calibration.unknowns.is_empty());
        let cell = |head: usize, k: usize| {
            let sigma = propagated.as_ref().map(|all| ARC_SECONDS * all.variance(3 * head + k).sqrt());
            angle(heads[head][k], sigma, None)
        };
        let q = rotation::angles_rad(&self.symmetrised.platform_from_virtual).map(degrees);
        html! {
            table {
                thead { tr { th { "4 · Symmetrised" } @for angle in ANGLES { th class="r" { (angle) } } } }
                tbody { @for head in 0..heads.len() { tr { th { "Head " (head + 1) } @for k in 0..3 { (cell(head, k)) } } } }
            }
            p class="note" {
                "The virtual camera looks along the mean of the heads’ axes, turned against the platform by φ " (q[0]) ", ω " (q[1]) ", κ " (q[2])
                ". Small: standard deviation in arc seconds, carried on from the covariance; a head that was given has one here, since the mean moves. The camera file’s covariance is of heads 2 and up and takes the turn as given."
            }
        }
    }
}

/// A cell: degrees, with what is known of them below.
fn angle(value_rad: f64, sigma_arcsec: Option<f64>, change_rad: Option<f64>) -> Markup {
    html! {
        td class="n" {
            (degrees(value_rad)) br;
            small {
                @match sigma_arcsec { Some(sigma) => { "± " (number(sigma, 2, "")) "″" } None => "given" }
                @if let Some(change) = change_rad.filter(|_| sigma_arcsec.is_some()) { ", " (signed(change.to_degrees() * 60.0, 1, "")) "′" }
            }
        }
    }
}

fn degrees(angle_rad: f64) -> String {
    // Adding zero takes the sign off what rounds to a negative one.
    format!("{}°", number((angle_rad.to_degrees() * 1e5).round() * 1e-5 + 0.0, 5, ""))
}

fn signed(value: f64, digits: usize, unit: &str) -> String {
    format!("{}{}", if value < 0.0 { "" } else { "+" }, number(value, digits, unit))
}

/// A difference of angles within half a turn.
fn half_turn(angle_rad: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    (angle_rad + PI).rem_euclid(TAU) - PI
}
