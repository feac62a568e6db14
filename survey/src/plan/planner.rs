//! A whole plan: from terrain, area and camera to strips, what they achieve and what they cost.

use super::axes::Axes;
use super::base_height::base_height_m;
use super::cells::{Cells, Known, Summary};
use super::checks::Turns;
use super::combinations::{Progress, base_min_m, nothing_left};
use super::constant::Constant;
use super::file::{Checks, Combination, Limit};
use super::lines::{Layout, Overlaps, Strip, View};
use super::overlap::Achieved;
use super::request::Request;
use super::sight::Photos;
use super::terrain::Terrain;
use crate::error::InputError;

/// Cells that a plan's accuracy is looked at on, about.
const CELLS_MOST: usize = 40_000;
/// Cells that each combination is looked at on, about.
const CELLS_OF_A_COMBINATION: usize = 2_500;
/// How often noise is drawn for a plan.
const ROUNDS: u64 = 8;
/// Overlaps at which headings are compared when overlaps are yet to be chosen: the least of the combinations.
pub const LEAST: Overlaps = Overlaps { forward: 0.6, side: 0.3 };
/// Headings that are compared lie this far apart.
const HEADING_STEP_DEG: f64 = 15.0;
/// Sides of the area whose headings are compared.
const SIDES_MOST: usize = 12;
/// Overlap that is missing by rounding alone.
const ROUNDING: f64 = 1e-9;

/// What was planned.
#[derive(Debug)]
pub struct Planned<'r> {
    /// Terrain, axes, area along the axes, view and overlaps.
    pub layout: Layout<'r>,
    /// The strips, line by line, each from its low end.
    pub strips: Vec<Strip>,
    /// Smallest overlaps.
    pub achieved: Achieved,
    /// Shortest base.
    pub base_min_m: f64,
    /// The area's cells.
    pub cells: Cells,
    /// What the photos know of each.
    pub known: Vec<Known>,
    /// Predicted accuracy and gaps; `None` where no cell is determined.
    pub summary: Option<Summary>,
    /// Accuracy from simulated noise, horizontal and height.
    pub simulated_m: Option<[f64; 2]>,
    /// The cheapest constant bases; `None` where all have too many photos.
    pub constant: Option<Constant>,
    /// What was looked at to choose the overlaps; empty where they were given.
    pub combinations: Vec<Combination>,
    /// Clearance, blur, time.
    pub checks: Checks,
}

impl Request {
    /// The view from the flying height.
    ///
    /// # Errors
    /// The model has an unknown height under the area.
    fn view(&self, terrain: &Terrain<'_>) -> Result<View, InputError> {
        let base_height_m = base_height_m(terrain.dem(), &self.area)?;
        let footprint_m = self.half_tangent.map(|tangent| 2.0 * tangent * self.height_m);
        Ok(View { height_m: self.height_m, base_height_m, footprint_m })
    }

    /// Strips of a heading over the area.
    fn layout<'r>(&self, terrain: &'r Terrain<'r>, view: View, heading_deg: f64, overlaps: Overlaps) -> Layout<'r> {
        let axes = Axes::new(heading_deg);
        let area = self.area.mapped(|corner| axes.of(corner));
        Layout { terrain, axes, area, view, overlaps, follow: self.follow }
    }

    /// Plans.
    ///
    /// # Errors
    /// One sentence: heights unknown under the area, terrain at or above the flying height, no combination of overlaps left,
    /// exposures that follow each other too fast, too many photos.
    pub fn plan<'r>(&self, terrain: &'r Terrain<'r>, progress: Progress<'_>) -> Result<Planned<'r>, InputError> {
        let view = self.view(terrain)?;
        let layout = |heading_deg: f64, overlaps: Overlaps| self.layout(terrain, view, heading_deg, overlaps);
        let heading_deg = match self.heading_deg {
            Some(heading_deg) => heading_deg,
            None => self.heading(&|heading_deg| layout(heading_deg, self.overlaps.unwrap_or(LEAST)))?,
        };
        let mut layout = layout(heading_deg, self.overlaps.unwrap_or(LEAST));
        let mut combinations = Vec::new();
        if self.overlaps.is_none() {
            let cells = Cells::new(terrain, &self.area, CELLS_OF_A_COMBINATION);
            combinations = layout.combinations(&cells, &self.sigmas, &self.limits, progress)?;
        }
        let cells = Cells::new(terrain, &self.area, CELLS_MOST);
        if cells.inside.is_empty() {
            return Err(InputError::new(
                "the area is too thin or too small to be planned for: no cell of it can be looked at",
            ));
        }
        let (strips, known) = loop {
            let chosen = combinations.iter().position(|combination| combination.ruled_out.is_none());
            if let Some(chosen) = chosen.map(|chosen| &combinations[chosen]) {
                layout.overlaps = Overlaps { forward: chosen.forward, side: chosen.side };
            } else if self.overlaps.is_none() {
                return Err(InputError::new(nothing_left(&combinations)));
            }
            let strips = layout.variable()?;
            let known = cells.known(&Photos::new(&strips, terrain, layout.axes, &view), &self.sigmas);
            match chosen.map(|chosen| &mut combinations[chosen]) {
                // A gap that the coarser cells had missed.
                Some(chosen) if known.iter().any(Known::is_gap) => chosen.ruled_out = Some(Limit::Gap),
                chosen => {
                    chosen.into_iter().for_each(|chosen| chosen.chosen = true);
                    break (strips, known);
                }
            }
        };
        let base_min_m = base_min_m(&strips);
        self.is_slow_enough(base_min_m)?;
        let photos = Photos::new(&strips, terrain, layout.axes, &view);
        let simulated_m = cells.simulated(&photos, &self.sigmas, self.seed, ROUNDS);
        let checks = Checks::new(&layout, &strips, self)?;
        Ok(Planned {
            achieved: to_rounding(layout.achieved(&strips), &layout.overlaps),
            constant: layout.level().constant().ok(),
            base_min_m,
            summary: Summary::new(&known),
            simulated_m,
            layout,
            strips,
            cells,
            known,
            combinations,
            checks,
        })
    }

    /// The heading of the shortest flight: steps all around and the area's longest sides are compared, the first of equals
    /// wins. One from which the terrain cannot be flown over is none.
    fn heading<'r>(&self, layout: &dyn Fn(f64) -> Layout<'r>) -> Result<f64, InputError> {
        let corners = self.area.corners();
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let mut sides: Vec<[f64; 2]> = sides.map(|(a, b)| [b[0] - a[0], b[1] - a[1]]).collect();
        sides.sort_by(|a, b| b[0].hypot(b[1]).total_cmp(&a[0].hypot(a[1])));
        let along_sides = sides.iter().take(SIDES_MOST).map(|[x, y]| x.atan2(*y).to_degrees().rem_euclid(180.0));
        let around = (0..(180.0 / HEADING_STEP_DEG) as u32).map(|k| 90.0 + f64::from(k) * HEADING_STEP_DEG);
        let mut best: Result<(f64, f64), InputError> = Err(InputError::new("there is no heading to fly"));
        for heading_deg in around.chain(along_sides) {
            let layout = layout(heading_deg);
            let length_m = layout.variable().map(|strips| Turns::new(self.limits.speed_m_s).length_m(&strips));
            match (length_m, &best) {
                (Ok(length_m), Ok((least_m, _))) if length_m >= least_m - 1e-6 => {}
                (Ok(length_m), _) => best = Ok((length_m, layout.axes.heading_deg())),
                (Err(why), Err(_)) => best = Err(why),
                (Err(_), Ok(_)) => {}
            }
        }
        best.map(|(_, heading_deg)| heading_deg)
    }

    /// Whether exposures leave the time that they need.
    ///
    /// # Errors
    /// One sentence where they do not.
    fn is_slow_enough(&self, base_min_m: f64) -> Result<(), InputError> {
        let interval_s = base_min_m / self.limits.speed_m_s;
        if interval_s < self.limits.min_interval_s {
            return Err(InputError::new(format!(
                "at {} m/s the shortest base of {base_min_m:.1} m leaves {interval_s:.3} s between exposures, less than the {} s that they need",
                self.limits.speed_m_s, self.limits.min_interval_s
            )));
        }
        Ok(())
    }
}

/// Overlaps that fall short of the wish by rounding alone are the wish.
fn to_rounding(achieved: Achieved, wanted: &Overlaps) -> Achieved {
    let mend = |least: Option<f64>, wanted: f64| {
        least.map(|least| if least < wanted && least > wanted - ROUNDING { wanted } else { least })
    };
    Achieved { forward: mend(achieved.forward, wanted.forward), side: mend(achieved.side, wanted.side) }
}
