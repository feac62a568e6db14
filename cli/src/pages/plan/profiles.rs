//! Profiles along the strips: terrain, flying height, height above the terrain and ground sample distance.

use super::Page;
use maud::{Markup, PreEscaped, html};
use plumbline_charts::format::{maybe, number, whole};
use plumbline_charts::panels::{FITTED, LEFT_OUT, MEASURED, Mark, Panel, svg};
use plumbline_survey::plan::flown::Leg;

/// Strips that have a profile at most: some 20 KB each.
const STRIPS_MAX: usize = 24;
/// Points of a profile at most: more than a screen shows of it.
const POINTS_MAX: f64 = 300.0;

/// A strip as it is flown.
struct Profile<'p> {
    /// Its place in the order of flight, from 1.
    number: usize,
    leg: Leg<'p>,
    /// From the first exposure in the direction of flight, and the terrain there; not finite where it is not known.
    ground: Vec<(f64, f64)>,
    /// The flying height over the same places.
    flown: Vec<(f64, f64)>,
    /// Least height above it.
    clearance_m: Option<f64>,
}

impl Page<'_> {
    pub(super) fn profiles(&self) -> Markup {
        let all: Vec<Profile<'_>> =
            self.outputs.legs().enumerate().map(|(index, leg)| self.profile(index, leg)).collect();
        let of_least =
            self.outputs.planned.checks.nearest.filter(|nearest| !nearest.is_turn).map(|nearest| nearest.strip - 1);
        let below = (0..all.len())
            .filter(|index| all[*index].clearance_m.is_some())
            .min_by(|a, b| all[*a].clearance_m.unwrap_or(f64::MAX).total_cmp(&all[*b].clearance_m.unwrap_or(f64::MAX)));
        let lowest = of_least.filter(|strip| *strip < all.len()).or(below);
        let every = all.len().div_ceil(STRIPS_MAX).max(1);
        let shown = all.iter().enumerate().filter(|(index, _)| index % every == 0 || Some(*index) == lowest);
        html! {
            section {
                h2 { "Along the strips" }
                p class="note" {
                    "In the direction of flight, from each strip’s first photo: the terrain under it, the height that is flown, the height above the terrain and the "
                    "ground sample distance there, straight below. Dots are photos, the red line the least clearance asked for. Strips are numbered in the order of flight"
                    @if every > 1 { "; one of " (every) " is shown, and the one that comes nearest to the terrain" }
                    "; that one is open."
                }
                @for (index, profile) in shown {
                    details open[Some(index) == lowest] {
                        summary {
                            b { "Strip " (profile.number) } ", " (whole(profile.leg.strip.along_m.len() as u64))
                            @if profile.leg.strip.along_m.len() == 1 { " photo, " } @else { " photos, " }
                            (maybe(profile.clearance_m, 0, "m")) " above the terrain at least"
                        }
                        (self.picture(profile))
                    }
                }
            }
        }
    }

    fn profile<'p>(&self, index: usize, leg: Leg<'p>) -> Profile<'p> {
        let layout = &self.outputs.planned.layout;
        let (from_m, to_m) = (leg.from_m(), leg.to_m());
        let [step_x, step_y] = layout.terrain.dem().step_m;
        let count = ((to_m - from_m).abs() / step_x.min(step_y)).ceil().clamp(1.0, POINTS_MAX);
        let (mut ground, mut flown) = (Vec::new(), Vec::new());
        for k in 0..=count as usize {
            let along_m = from_m + (to_m - from_m) * k as f64 / count;
            let [x, y] = layout.axes.point([along_m, leg.strip.across_m]);
            let at = (along_m - from_m).abs();
            ground.push((at, layout.terrain.dem().height(x, y).unwrap_or(f64::NAN)));
            flown.push((at, layout.view.up_m(leg.strip.course.rise_m(along_m))));
        }
        let above = ground.iter().zip(&flown).map(|(ground, flown)| flown.1 - ground.1);
        let clearance_m = above.filter(|above| above.is_finite()).reduce(f64::min);
        Profile { number: index + 1, leg, ground, flown, clearance_m }
    }

    /// The ground of the least clearance, if it is beside this strip: as far along it as it lies, at its ends where it lies beyond them.
    fn nearest_on(&self, profile: &Profile<'_>) -> Vec<(f64, f64)> {
        let planned = &self.outputs.planned;
        let of_strip = planned.checks.nearest.filter(|nearest| !nearest.is_turn && nearest.strip == profile.number);
        let (from_m, to_m) = (profile.leg.from_m(), profile.leg.to_m());
        let at = |[along_m, _]: [f64; 2]| (along_m.clamp(from_m.min(to_m), from_m.max(to_m)) - from_m).abs();
        of_strip
            .map(|nearest| (at(planned.layout.axes.of([nearest.x, nearest.y])), nearest.ground_m))
            .into_iter()
            .collect()
    }

    fn picture(&self, profile: &Profile<'_>) -> Markup {
        let file = self.outputs.file;
        let heights =
            || profile.ground.iter().zip(&profile.flown).map(|(ground, flown)| (ground.0, flown.1 - ground.1));
        let above: Vec<(f64, f64)> = heights().collect();
        let gsd: Vec<(f64, f64)> = heights().map(|(at, above)| (at, file.gsd_m * above / file.height_m)).collect();
        let (from_m, view) = (profile.leg.from_m(), &self.outputs.planned.layout.view);
        let ups_m = profile.leg.strip.along_m.iter().zip(view.ups_m(profile.leg.strip));
        let photos = ups_m.map(|(along_m, up_m)| ((along_m - from_m).abs(), up_m)).collect();
        let nearest = self.nearest_on(profile);
        let end = profile.ground.last().map_or(1.0, |last| last.0.max(1.0));
        let line = |points: Vec<(f64, f64)>, colour| (Mark::Line(points), colour);
        let lowest = profile.ground.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
        // Filled where all of it is known.
        let filled = profile.ground.iter().all(|point| point.1.is_finite());
        let terrain = if filled {
            (Mark::Band(profile.ground.iter().map(|(at, ground)| (*at, lowest, *ground)).collect()), MEASURED)
        } else {
            line(profile.ground.clone(), MEASURED)
        };
        let panels = [
            Panel {
                caption: if nearest.is_empty() {
                    "Terrain (grey) and flying height (blue) above the height datum".into()
                } else {
                    "Terrain (grey) and flying height (blue) above the height datum; red: the ground beside it that the flight comes nearest to".into()
                },
                y_text: "height (m)".into(),
                share: 2,
                marks: vec![
                    terrain,
                    line(profile.ground.clone(), MEASURED),
                    line(profile.flown.clone(), FITTED),
                    (Mark::Dots(photos), FITTED),
                    (Mark::Dots(nearest), LEFT_OUT),
                ],
            },
            Panel {
                caption: "Height above the terrain".into(),
                y_text: "(m)".into(),
                share: 1,
                marks: vec![line(above, FITTED), (Mark::Level(file.checks.clearance_wanted_m), LEFT_OUT)],
            },
            Panel {
                caption: "Ground sample distance".into(),
                y_text: "(m)".into(),
                share: 1,
                marks: vec![line(gsd, FITTED)],
            },
        ];
        match svg(0.0..end, "along the strip (m)", &panels) {
            // Inside HTML no namespace is needed.
            Ok(text) => {
                html! { figure class="profile" role="img" aria-label=(format!("Profile of strip {}", profile.number)) { (PreEscaped(text.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1))) } }
            }
            Err(why) => html! { p class="note" { (why) ", " (number(end, 0, "m")) } },
        }
    }
}
