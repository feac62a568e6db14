//! Paper 004: its two tests on terrain of the kind that it flew over, and what its rules leave undone.
//!
//! The paper's terrain is not to be had; both tests are flown over a real model of hills in Tennessee ([`setting`]), at the
//! paper's scales and overlaps. [`slips`] are the paper's own rules, held against the terrain.

pub mod setting;
pub mod slips;

use super::Row;
use plumbline_survey::error::InputError;
use plumbline_survey::plan::cells::Cells;
use plumbline_survey::plan::combinations::{COUNT, Limits};
use plumbline_survey::plan::file::Limit;
use plumbline_survey::plan::lines::{Overlaps, Strip, line_count, photo_count};
use plumbline_survey::plan::sight::Photos;
use plumbline_survey::plan::terrain::Terrain;
use serde::Serialize;
use setting::{TEST_1, TEST_2, Test};

/// Cells of an area, about.
const CELLS: usize = 10_000;
/// What made-up noise comes from, and how often it is made up.
const SEED: u64 = 1;
const ROUNDS: u64 = 8;
/// Overlaps of the paper's variable plans.
const VARIABLE: Overlaps = Overlaps { forward: 0.6, side: 0.3 };

const GROUND: &str = "the paper's terrain and area are not given; ours is another of the same kind and size";
const ACCURACY_1: &str = "at the paper's noise (2 um, 0.015 m, 1e-4 rad) the intersection of all rays is 3 to 6 times better; the \
     paper's ratio of the two plans, 1.18 and 1.34, is too flat for random noise alone (ours 1.5 and more), so something \
     systematic is in its figures";
const ACCURACY_2: &str = "the paper's two figures look swapped, as a base of half the height cannot give heights better than \
     places; swapped, its plan figure is near ours and its height figure is not";

/// Everything that was reproduced.
#[derive(Clone, Debug, Serialize)]
pub struct Reproduction {
    /// Number of the paper.
    pub paper: &'static str,
    /// Seed of the made-up noise.
    pub seed: u64,
    /// Whether the real terrain was there.
    pub has_terrain: bool,
    /// The rows, table by table.
    pub rows: Vec<Row>,
}

impl Reproduction {
    /// All rows; those that need the real terrain are left out where it is missing.
    ///
    /// # Errors
    /// The terrain's file is broken.
    pub fn new() -> Result<Self, InputError> {
        let mut rows = setting::equations();
        let hills = setting::hills()?;
        if let Some(hills) = &hills {
            rows.extend(Tested::new(&TEST_1, hills)?.rows_1());
            rows.extend(Tested::new(&TEST_2, &setting::mountains(hills))?.rows_2());
            rows.push(windows(hills)?);
        }
        Ok(Reproduction { paper: "004", seed: SEED, has_terrain: hills.is_some(), rows })
    }
}

/// A plan, and how well it determines the ground.
struct Case {
    lines: usize,
    photos: usize,
    /// Horizontal and height, from made-up noise.
    accuracy_m: [f64; 2],
}

/// A test of the paper on our terrain.
struct Tested {
    /// The plan that was flown, with constant bases and without a guarantee.
    flown: Case,
    variable: Case,
    /// The cheapest constant bases that guarantee what the variable ones do.
    guaranteed: [usize; 2],
    one_pass: slips::Fallen,
    mean: slips::Fallen,
    /// Combinations ruled out by gaps, interval and accuracy; the chosen overlaps.
    choice: Option<([usize; 3], Option<Overlaps>)>,
}

impl Tested {
    fn new(test: &Test, dem: &plumbline_survey::dem::Dem) -> Result<Self, InputError> {
        let terrain = Terrain::new(dem);
        let layout = test.layout(&terrain, VARIABLE)?;
        let cells = Cells::new(&terrain, &test.area(), CELLS);
        let case = |strips: Vec<Strip>| {
            let photos = Photos::new(&strips, &terrain, layout.axes, &layout.view);
            let simulated = cells.simulated(&photos, &test.sigmas(), SEED, ROUNDS);
            Case {
                lines: line_count(&strips),
                photos: photo_count(&strips),
                accuracy_m: simulated.unwrap_or([f64::NAN; 2]),
            }
        };
        let variable = layout.variable()?;
        let constant = layout.constant()?;
        let choice = test.limits.map(|accuracy_m| {
            let limits = Limits { accuracy_m: Some(accuracy_m), ..setting::LIMITS };
            let combinations = layout.combinations(&cells, &test.sigmas(), &limits, &|_, _| ())?;
            let count = |limit| combinations.iter().filter(|c| c.ruled_out == Some(limit)).count();
            let chosen = combinations.iter().find(|c| c.ruled_out.is_none());
            let chosen = chosen.map(|c| Overlaps { forward: c.forward, side: c.side });
            Ok::<_, InputError>(([Limit::Gap, Limit::Interval, Limit::Accuracy].map(count), chosen))
        });
        Ok(Tested {
            flown: case(test.level(test.flown)?),
            one_pass: slips::one_pass(&layout),
            mean: slips::mean_height(&layout),
            variable: case(variable),
            guaranteed: [line_count(&constant.strips), photo_count(&constant.strips)],
            choice: choice.transpose()?,
        })
    }

    fn rows_1(&self) -> Vec<Row> {
        let table = "Test 1 (f 50 mm, H 555 m)";
        let mut rows = plan_rows(table, "80/60 constant, flown", &self.flown, [6.0, 176.0, 0.175, 0.201], ACCURACY_1);
        rows.extend(plan_rows(table, "60/30 variable", &self.variable, [5.0, 75.0, 0.207, 0.270], ACCURACY_1));
        rows.extend(self.guarantee_rows(table));
        if let Some((ruled_out, chosen)) = &self.choice {
            let limits =
                ["gaps in the coverage", "an interval below 2.5 s at 55 m/s", "0.5 m in plan, 0.4 m in height"];
            for (limit, count) in limits.iter().zip(ruled_out) {
                rows.push(own(table, format!("of {COUNT} combinations ruled out by {limit}"), *count as f64));
            }
            let chosen = |of: &dyn Fn(&Overlaps) -> f64| chosen.as_ref().map_or(f64::NAN, |chosen| 100.0 * of(chosen));
            rows.push(row(table, "chosen forward overlap, %".into(), 60.0, chosen(&|c| c.forward), None));
            rows.push(row(table, "chosen side overlap, %".into(), 30.0, chosen(&|c| c.side), None));
        }
        rows
    }

    fn rows_2(&self) -> Vec<Row> {
        let table = "Test 2 (f 47 mm, H 3150 m)";
        let mut rows =
            plan_rows(table, "68.8/30 constant, flown", &self.flown, [15.0, 694.0, 1.559, 0.272], ACCURACY_2);
        rows.extend(plan_rows(table, "60/30 variable", &self.variable, [15.0, 668.0, 1.571, 0.360], ACCURACY_2));
        rows.extend(self.guarantee_rows(table));
        rows
    }

    /// What the paper does not say: constant bases that keep the promise, and its own rules.
    fn guarantee_rows(&self, table: &'static str) -> Vec<Row> {
        let [lines, photos] = self.guaranteed;
        let mut rows = vec![
            own(table, "lines of the cheapest constant bases that guarantee 60/30".into(), lines as f64),
            own(table, "photos of them".into(), photos as f64),
            own(table, "photos that variable bases save".into(), photos as f64 - self.variable.photos as f64),
        ];
        let rules = [("the zone of the nominal base", &self.one_pass), ("the mean height of the zone", &self.mean)];
        for (rule, fallen) in rules {
            rows.push(own(table, format!("by {rule}: bases"), fallen.bases as f64));
            rows.push(own(table, format!("by {rule}: bases below 60 % on the ground"), fallen.below as f64));
            rows.push(own(table, format!("by {rule}: least overlap, %"), 100.0 * fallen.least));
        }
        rows
    }
}

/// Lines, photos, accuracy of a plan beside the paper's.
fn plan_rows(table: &'static str, name: &str, case: &Case, paper: [f64; 4], accuracy: &str) -> Vec<Row> {
    let counts = [("lines", case.lines), ("photos", case.photos)].into_iter().zip(paper);
    let counts = counts.map(|((what, ours), paper)| {
        let differs = (ours as f64 - paper).abs() > 0.5;
        row(table, format!("{name}: {what}"), paper, ours as f64, differs.then_some(GROUND))
    });
    let accuracies = [("plan", 0), ("height", 1)].map(|(what, axis)| {
        row(table, format!("{name}: {what}, m"), paper[2 + axis], case.accuracy_m[axis], Some(accuracy))
    });
    counts.chain(accuracies).collect()
}

/// The saving of test 1 depends on where its window lies: the middle one of many.
fn windows(hills: &plumbline_survey::dem::Dem) -> Result<Row, InputError> {
    let mut saved = setting::windows(hills, VARIABLE)?;
    saved.sort_by(f64::total_cmp);
    let middle = saved.get(saved.len() / 2).copied().unwrap_or(f64::NAN);
    let part = |share: f64| saved.get((share * saved.len() as f64) as usize).copied().unwrap_or(f64::NAN);
    let quantity = format!(
        "photos saved, %, middle of {} windows of 100 to 250 m of relief (tenth part from {:.0}, to {:.0})",
        saved.len(),
        part(0.1),
        part(0.9)
    );
    Ok(own("Test 1 elsewhere", quantity, middle))
}

fn row(table: &'static str, quantity: String, paper: f64, ours: f64, difference: Option<&str>) -> Row {
    Row {
        decimals: None,
        table,
        quantity,
        paper: Some(paper),
        ours: Some(ours),
        difference: difference.map(str::to_owned),
    }
}

/// A row of which the paper says nothing.
fn own(table: &'static str, quantity: String, ours: f64) -> Row {
    Row { decimals: None, table, quantity, paper: None, ours: Some(ours), difference: None }
}
