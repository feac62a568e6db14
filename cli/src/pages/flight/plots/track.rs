//! Where the vehicle was to fly, where it was, where it was believed to be, and where the fixes say it was, over the reference.

use crate::pages::flight::Report;
use crate::pages::tile;
use maud::{Markup, html};
use plotters::element::{Circle, Polygon, Rectangle, Text};
use plotters::series::LineSeries;
use plotters::style::{Color, IntoFont};
use plumbline_charts::map::Map;
use plumbline_charts::plot::{Chart, Drawn, ESTIMATED, FONT, INK, PAPER, PlotError, RECTIFIED, REFUSED, UNRECTIFIED};
use plumbline_sim::run::FrameRecord;
use plumbline_sim::score::kept::{Kept, Navigated};
use plumbline_sim::setup::Setup;

/// Margin around the track, as a share of its larger side. Chosen: keeps a ring on the outermost frame inside the picture.
const MARGIN: f64 = 0.08;
/// Narrowest picture, metres: a hovering vehicle stays a point.
const SIDE_MIN_M: f64 = 20.0;
/// Most points of a line: more than the picture has pixels.
const POINTS_MAX: usize = 2000;
/// Arrows along the track, and their length as a share of half the map's side.
const ARROWS: usize = 5;
const ARROW: f64 = 0.06;
/// Most planned photos that are drawn as rings.
const PHOTOS_MAX: usize = 400;

/// (East, north) of the tile's centre, metres.
type Place = (f64, f64);

/// A place of the grid.
pub(in crate::pages::flight) fn local(setup: &Setup, [east_m, north_m]: [f64; 2]) -> Place {
    let [east, north] = setup.tile_centre;
    (east_m - east, north_m - north)
}

/// The lines of the map.
struct Lines {
    /// The legs that were to be flown, or the planned photos; empty where the scenario alone moves the vehicle.
    planned: Vec<Place>,
    truth: Vec<Place>,
    /// Where the vehicle was believed to be, in pieces without a gap.
    estimated: Vec<Vec<Place>>,
    fixes: Vec<Place>,
    refused: Vec<Place>,
    /// Where satellite navigation was lost.
    lost: Option<Place>,
}

impl Report<'_> {
    pub(in crate::pages::flight) fn track(&self) -> Result<Markup, PlotError> {
        let lines = self.lines();
        let estimated = lines.estimated.iter().flatten();
        let map = Map::around(
            lines.truth.iter().chain(&lines.fixes).chain(&lines.planned).chain(estimated),
            MARGIN,
            SIDE_MIN_M,
        );
        let svg = map.plot_over(
            "Track over the reference: planned, true and estimated, with the fixes; north over east, metres",
            |at| tile::grey(self.setup, at),
            |chart| lines.draw(&map, chart),
        )?;
        let whose = if self.kept_track().is_some() { "the autopilot" } else { "the board’s filter" };
        Ok(html! {
            figure {
                div id="track" class="dots" { (svg) }
                figcaption {
                    b { "Track over the reference. " }
                    @if !lines.planned.is_empty() { span class="key line k-paper" {} "planned, " }
                    span class="key line k-raw" {} "true, arrows in the direction of flight, "
                    @if !lines.estimated.is_empty() { span class="key line k-good" {} "as " (whose) " estimates it, " }
                    span class="key dot k-ours" {} "fixes, "
                    span class="key ring k-bad" {} "frames refused, where they truly were"
                    @if lines.lost.is_some() { ", " span class="key dot k-bad" {} "where satellite navigation was lost" }
                    ". Metres from the tile’s centre, grid north up."
                }
            }
        })
    }

    fn kept_track(&self) -> Option<&Kept> {
        self.summary.navigation.as_ref().and_then(Navigated::kept)
    }

    fn lines(&self) -> Lines {
        let local = |place| local(self.setup, place);
        let drawn = self.drawn();
        let records = || drawn.iter().map(|index| &self.flight.frames[*index]);
        let at = |record: &FrameRecord| local([record.truth.east_m, record.truth.north_m]);
        let fix = |record: &FrameRecord| record.report.and_then(|report| report.fix);
        let fixes = records().filter_map(fix).map(|fix| (f64::from(fix.east_m), f64::from(fix.north_m))).collect();
        let refused = records().filter(|record| fix(record).is_none()).map(at).collect();
        if let Some(kept) = self.kept_track() {
            let track = &kept.track;
            let moments = || track.moments.iter().step_by(track.moments.len().div_ceil(POINTS_MAX).max(1));
            let of = |place: [f64; 3]| local([place[0], place[1]]);
            let lost = kept.gnss_lost_s.and_then(|lost_s| moments().find(|moment| moment.at_s >= lost_s));
            return Lines {
                planned: track.waypoints.iter().chain(track.waypoints.first()).map(|point| local(*point)).collect(),
                truth: moments().map(|moment| of(moment.truth_m)).collect(),
                estimated: vec![moments().map(|moment| of(moment.believed_m)).collect()],
                fixes,
                refused,
                lost: lost.map(|moment| of(moment.truth_m)),
            };
        }
        let photos = self.setup.plan.iter().flat_map(|plan| &plan.photos);
        let places: Vec<Option<Place>> = records()
            .map(|record| {
                let place = record.instant?.place?;
                Some((f64::from(place.east_m), f64::from(place.north_m)))
            })
            .collect();
        let runs = places.split(Option::is_none).filter(|run| !run.is_empty());
        Lines {
            planned: photos.map(|photo| local([photo.place_m[0], photo.place_m[1]])).collect(),
            truth: records().map(at).collect(),
            estimated: runs.map(|run| run.iter().flatten().copied().collect()).collect(),
            fixes,
            refused,
            lost: None,
        }
    }
}

impl Lines {
    /// Back to front.
    fn draw(&self, map: &Map, chart: &mut Chart<'_, '_>) -> Drawn {
        chart.draw_series(LineSeries::new(self.planned.iter().copied(), PAPER.stroke_width(3)))?;
        if self.planned.len() <= PHOTOS_MAX {
            chart.draw_series(self.planned.iter().map(|&at| Circle::new(at, 9, PAPER.stroke_width(2))))?;
        }
        chart.draw_series(LineSeries::new(self.truth.iter().copied(), UNRECTIFIED.stroke_width(7)))?;
        for run in &self.estimated {
            chart.draw_series(LineSeries::new(run.iter().copied(), ESTIMATED.stroke_width(3)))?;
        }
        chart.draw_series(self.fixes.iter().map(|&at| Circle::new(at, 6, RECTIFIED.filled())))?;
        chart.draw_series(self.refused.iter().map(|&at| Circle::new(at, 8, REFUSED.stroke_width(3))))?;
        chart.draw_series(self.lost.iter().map(|&at| Circle::new(at, 12, REFUSED.filled())))?;
        let arrows = arrows(&self.truth, map.metres(ARROW));
        chart.draw_series(arrows.into_iter().map(|corners| Polygon::new(corners, INK.filled())))?;
        self.draw_ends(map, chart)?;
        map.north_arrow(chart, 0.9, 0.72..0.93)?;
        chart.draw_series([label("N", map.at(0.8, 0.92))])?;
        Ok(())
    }

    /// A ring at the start, a square at the end, each with its name.
    fn draw_ends(&self, map: &Map, chart: &mut Chart<'_, '_>) -> Drawn {
        let (Some(&start), Some(&end)) = (self.truth.first(), self.truth.last()) else { return Ok(()) };
        let (side, aside) = (map.metres(0.022), map.metres(0.04));
        chart.draw_series([Circle::new(start, 15, INK.stroke_width(5))])?;
        let corners = [(end.0 - side, end.1 - side), (end.0 + side, end.1 + side)];
        chart.draw_series([Rectangle::new(corners, INK.stroke_width(5))])?;
        // Names that lie on each other go apart.
        let are_close = (start.0 - end.0).hypot(start.1 - end.1) < map.metres(0.3);
        let (above, below) = (map.metres(0.09), if are_close { -map.metres(0.04) } else { map.metres(0.09) });
        // What begins near the right border is written to the left.
        let (right, _) = map.at(0.75, 0.0);
        let beside = |at: Place, up: f64, width: f64| {
            let east = if at.0 > right { at.0 - map.metres(width) } else { at.0 + aside };
            (east, at.1 + up)
        };
        chart.draw_series([label("start", beside(start, above, 0.22)), label("end", beside(end, below, 0.17))])?;
        Ok(())
    }
}

fn label(text: &'static str, at: Place) -> Text<'static, Place, &'static str> {
    Text::new(text, at, ("sans-serif", FONT).into_font().color(&INK))
}

/// Triangles at even distances along a line, each `length` long, its tip ahead; none of a line that goes nowhere.
fn arrows(line: &[Place], length: f64) -> Vec<Vec<Place>> {
    let step = |pair: &[Place]| (pair[1].0 - pair[0].0).hypot(pair[1].1 - pair[0].1);
    let total: f64 = line.windows(2).map(step).sum();
    let mut found = Vec::new();
    if total < 2.0 * length {
        return found;
    }
    let (mut gone, apart) = (0.0, total / ARROWS as f64);
    for pair in line.windows(2) {
        let long = step(pair);
        while found.len() < ARROWS && gone + long >= (found.len() as f64 + 0.5) * apart && long > 0.0 {
            let share = ((found.len() as f64 + 0.5) * apart - gone) / long;
            let [right, up] = [(pair[1].0 - pair[0].0) / long, (pair[1].1 - pair[0].1) / long];
            let (x, y) = (pair[0].0 + share * long * right, pair[0].1 + share * long * up);
            let corner = |ahead: f64, aside: f64| {
                (x + length * (ahead * right - aside * up), y + length * (ahead * up + aside * right))
            };
            found.push(vec![corner(0.5, 0.0), corner(-0.5, 0.4), corner(-0.5, -0.4)]);
        }
        gone += long;
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_stand_at_even_distances_and_point_ahead() {
        // Ten metres east, then ten north.
        let line = [(0.0, 0.0), (5.0, 0.0), (10.0, 0.0), (10.0, 10.0)];
        let found = arrows(&line, 1.0);
        assert_eq!(found.len(), ARROWS);
        let tips: Vec<Place> = found.iter().map(|corners| corners[0]).collect();
        let near = |a: Place, b: Place| (a.0 - b.0).abs() < 1e-9 && (a.1 - b.1).abs() < 1e-9;
        // The third stands in the corner and points along the leg that ends there.
        let wanted = [(2.5, 0.0), (6.5, 0.0), (10.5, 0.0), (10.0, 4.5), (10.0, 8.5)];
        assert!(tips.iter().zip(wanted).all(|(tip, wanted)| near(*tip, wanted)), "{tips:?}");
        assert!(arrows(&[(1.0, 1.0), (1.0, 1.0)], 1.0).is_empty() && arrows(&[], 1.0).is_empty());
    }
}
