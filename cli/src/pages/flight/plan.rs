//! A plan beside what came of it.

use super::Report;
use maud::{Markup, html};
use plotters::element::{Circle, PathElement};
use plotters::style::Color;
use plumbline_charts::format::{NONE, maybe, number};
use plumbline_charts::map::Map;
use plumbline_charts::page::key;
use plumbline_charts::plot::{PlotError, RECTIFIED, REFUSED, UNRECTIFIED};
use plumbline_sim::score::plan::{Accuracies, Flown, Pair};
use plumbline_sim::setup::planned::Planned;

/// Margin around the map, as a share of its larger side. Chosen: keeps a ring on the outermost photo inside the frame.
const MARGIN: f64 = 0.06;
/// Narrowest map, metres: a plan of one photo has no extent.
const SIDE_MIN_M: f64 = 1.0;

impl Report<'_> {
    /// Nothing without a plan.
    pub(super) fn plan(&self) -> Result<Markup, PlotError> {
        let (Some(planned), Some(flown)) = (&self.setup.plan, &self.summary.plan) else { return Ok(html! {}) };
        let map = self.map(planned)?;
        Ok(html! {
            section {
                h2 { "Plan" }
                p class="note" {
                    "The firmware decided when each photo was due. Achieved figures are those of the poses at which photos were really taken, reported ones those of its own poses at their stamps; overlap, intersection and noise are the planner’s."
                }
                (exposed(flown))
                div class="two" {
                    figure { (map) figcaption {
                        b { "Photos. " }
                        span class="key line k-raw" {} "area, "
                        span class="key ring k-bad" {} "planned, "
                        span class="key dot k-ours" {} "taken, where they truly were. "
                        "Metres from the reference tile’s centre, grid north up, equal axes."
                    } }
                    div { (figures(flown)) }
                }
                @for note in &planned.notes { p class="note" { (note) } }
            }
        })
    }

    fn map(&self, planned: &Planned) -> Result<Markup, PlotError> {
        let [east, north] = self.setup.tile_centre;
        let local = |[e, n]: [f64; 2]| (e - east, n - north);
        let points: Vec<(f64, f64)> =
            planned.photos.iter().map(|photo| local([photo.place_m[0], photo.place_m[1]])).collect();
        let records = self.flight.frames.iter().filter(|record| record.photo.is_some());
        let taken: Vec<(f64, f64)> = records.map(|record| local([record.truth.east_m, record.truth.north_m])).collect();
        let mut area: Vec<(f64, f64)> =
            planned.file.area.iter().filter_map(|corner| planned.place.grid(*corner).ok()).map(local).collect();
        area.extend(area.first().copied());
        let map = Map::around(points.iter().chain(&taken).chain(&area), MARGIN, SIDE_MIN_M);
        map.plot("Photos planned and taken: north over east, metres", |chart| {
            chart.draw_series([PathElement::new(area.clone(), UNRECTIFIED.stroke_width(4))])?;
            chart.draw_series(points.iter().map(|&at| Circle::new(at, 10, REFUSED.stroke_width(3))))?;
            chart.draw_series(taken.iter().map(|&at| Circle::new(at, 6, RECTIFIED.filled())))?;
            map.north_arrow(chart, 0.93, 0.8..0.95)
        })
    }
}

/// How many photos were exposed, why the others were not, and how far off their planned positions the vehicle was.
fn exposed(flown: &Flown) -> Markup {
    let missed = &flown.missed;
    let off = |axis: usize| {
        let error = flown.position_error_m.map(|error| error[axis]);
        error.map_or_else(
            || NONE.to_owned(),
            |e| format!("{}, at most {}", number(e.mean, 2, "m"), number(e.max, 2, "m")),
        )
    };
    html! {
        div class="keys" {
            (key(&format!("{} of {}", flown.exposed, flown.photos), "photos exposed"))
            (key(&missed.sum().to_string(), "missed"))
            (key(&off(0), "off the planned place, along"))
            (key(&off(1), "off the planned place, across"))
        }
        p {
            "Missed: " (missed.passed) " passed by, " (missed.off_line) " off the line, " (missed.too_soon)
            " too soon after the one before, " (missed.late) " committed to too late, " (missed.not_reached) " not reached."
        }
    }
}

/// Overlaps, coverage and accuracies: planned, achieved, reported.
fn figures(flown: &Flown) -> Markup {
    let percent = |share: Option<f64>| share.map(|share| 100.0 * share);
    let of = |pair: Option<Pair>, pick: fn(&Pair) -> Option<f64>| percent(pair.as_ref().and_then(pick));
    let overlap = [flown.overlap.planned, flown.overlap.achieved, flown.overlap.reported];
    let coverage = [flown.coverage.planned, flown.coverage.achieved, flown.coverage.reported];
    let accuracy =
        |of: &Accuracies, axis: usize| [of.planned, of.achieved, None].map(|pair| pair.map(|pair| pair[axis]));
    let rows: [(&str, &str, [Option<f64>; 3], usize); 7] = [
        ("Smallest forward overlap", "%", overlap.map(|pair| of(pair, |pair| pair.forward)), 1),
        ("Smallest side overlap", "%", overlap.map(|pair| of(pair, |pair| pair.side)), 1),
        ("Area seen by two photos of a strip", "%", coverage.map(percent), 1),
        ("Accuracy in plan, covariance", "m", accuracy(&flown.accuracy_m, 0), 3),
        ("Accuracy in height, covariance", "m", accuracy(&flown.accuracy_m, 1), 3),
        ("Accuracy in plan, simulated noise", "m", accuracy(&flown.simulated_m, 0), 3),
        ("Accuracy in height, simulated noise", "m", accuracy(&flown.simulated_m, 1), 3),
    ];
    html! {
        table {
            thead { tr { th {} th class="r" { "planned" } th class="r" { "achieved" } th class="r" { "reported" } } }
            tbody {
                @for (name, unit, values, digits) in rows {
                    tr {
                        th { (name) }
                        @for value in values {
                            td class="n" { (maybe(value, digits, unit)) }
                        }
                    }
                }
            }
        }
    }
}
