//! All of it, in rounds that take turns: what slows the machine for a while slows both.

use super::case::{Case, Limits, Purpose};
use super::ours::{Kernel, Way};
use super::score::{Score, score, shift_px};
use super::theirs::{Answer, Script, Task};
use super::view::{Ground, Pose, View};
use super::{Failure, Grey};
use plumbline_sim::camera::still::runs_of;
use plumbline_survey::io::picture::Picture;
use std::hint::black_box;
use std::time::Instant;

/// Rounds, and how long each kernel is repeated in each of them, seconds.
const ROUNDS: usize = 3;
/// See [`ROUNDS`].
const SECONDS: f64 = 0.05;

/// One kernel on one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Its name.
    pub kernel: String,
    /// Whether it is the core's.
    pub is_ours: bool,
    /// Against the exact average.
    pub score: Score,
    /// Shift against it, frame pixels: on the smooth picture only.
    pub shift_px: Option<f64>,
    /// Distance of its match from the truth, cells: for matching only.
    pub match_px: Option<f64>,
    /// Shortest time, seconds.
    pub seconds: f64,
}

/// The exact area average itself, as the last row where there is matching.
pub const EXACT: &str = "exact area average";

/// All kernels on one view.
#[derive(Clone, Debug, PartialEq)]
pub struct Outcome {
    /// What the frame shows.
    pub picture: &'static str,
    /// Its size, (cols, rows).
    pub frame: (u16, u16),
    /// Camera, height, cells.
    pub ground: Ground,
    /// Attitude.
    pub pose: Pose,
    /// What it must reach.
    pub limits: Option<Limits>,
    /// What it is there for.
    pub purpose: Purpose,
    /// The core's kernels, then OpenCV's, of which the first is the rival.
    pub rows: Vec<Row>,
}

/// The whole run.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// OpenCV's version.
    pub version: String,
    /// Whether OpenCV's warp with INTER_AREA is its INTER_LINEAR.
    pub area_is_linear: bool,
    /// View by view.
    pub outcomes: Vec<Outcome>,
}

impl Outcome {
    /// OpenCV's warp to full size with INTER_AREA behind it.
    pub fn rival(&self) -> Option<&Row> {
        self.rows.iter().find(|row| !row.is_ours)
    }

    /// What flies; where it cannot, the first of the core's.
    pub fn ours(&self) -> Option<&Row> {
        self.rows.iter().find(|row| row.is_ours)
    }

    /// A row's time over the rival's.
    pub fn time_ratio(&self, row: &Row) -> f64 {
        self.rival().map_or(f64::NAN, |rival| row.seconds / rival.seconds)
    }
}

/// Runs all cases. The exact averages are left in the script's folder.
///
/// # Errors
/// A sentence where a kernel refuses or the script fails.
pub fn run(cases: &[Case], script: &Script) -> Result<Comparison, Failure> {
    let mut views = Vec::new();
    for case in cases {
        for &pose in &case.poses {
            views.push((case, pose, View::new(case.frame.size, case.ground, pose)?));
        }
    }
    let seconds = |case: &Case| if case.purpose == Purpose::Timed { SECONDS } else { 0.0 };
    let tasks: Vec<Task<'_>> =
        views.iter().map(|(case, _, view)| Task { frame: &case.frame, view, seconds: seconds(case) }).collect();
    let mut ours: Vec<Vec<Timed<'_>>> = views.iter().map(|(_, _, view)| Timed::all(view)).collect();
    let (answer, their_seconds) = rounds(&mut ours, &tasks, script)?;

    let mut outcomes = Vec::new();
    for (i, (case, pose, view)) in views.iter().enumerate() {
        let exact = view.exact(&case.frame);
        script.keep(&format!("exact-{i}.f64"), &exact)?;
        let patches: Vec<_> = ours[i].iter().map(|timed| (timed, timed.kernel.patch())).collect();
        // The same cells for all: those that every one of the core's kernels gives.
        let counted: Vec<bool> = (0..exact.len()).map(|n| patches.iter().all(|(_, p)| p.is_valid[n])).collect();
        let runs = runs_of(&mask(&counted, &exact, case.ground.cells));
        let is_smooth = case.purpose == Purpose::Smooth;
        let row = |kernel: &str, is_ours: bool, pixels: &[u8], seconds: f64| Row {
            kernel: kernel.to_owned(),
            is_ours,
            score: score(pixels, &exact, &counted),
            shift_px: is_smooth.then(|| shift_px(pixels, &exact, &counted, view)).flatten(),
            match_px: case.reference.as_ref().map(|r| r.error_px(pixels, &runs, case.ground.cells)),
            seconds,
        };
        let core = patches.iter().map(|(timed, patch)| row(&timed.way.name(), true, &patch.pixels, timed.seconds));
        let theirs = answer.kernels.iter().zip(&answer.patches[i]).zip(&their_seconds[i]);
        let theirs = theirs.map(|((name, pixels), least)| row(name, false, pixels, *least));
        let mut rows: Vec<Row> = core.chain(theirs).collect();
        if case.purpose == Purpose::Matched {
            let rounded: Vec<u8> = exact.iter().map(|value| value.unwrap_or(0.0).round() as u8).collect();
            rows.push(row(EXACT, false, &rounded, f64::NAN));
        }
        outcomes.push(Outcome {
            picture: case.picture,
            frame: case.frame.size,
            ground: case.ground,
            pose: *pose,
            limits: case.limits,
            purpose: case.purpose,
            rows,
        });
    }
    Ok(Comparison { version: answer.version, area_is_linear: answer.area_is_linear, outcomes })
}

/// One of the core's kernels and its shortest time so far, seconds.
#[derive(Debug)]
struct Timed<'a> {
    way: Way,
    kernel: Kernel<'a>,
    seconds: f64,
}

impl<'a> Timed<'a> {
    /// All that suit a view, the one that flies first.
    fn all(view: &'a View) -> Vec<Self> {
        let ways = Way::ALL.into_iter().filter(|way| way.suits(view));
        ways.map(|way| Timed { way, kernel: Kernel::new(way, view), seconds: f64::INFINITY }).collect()
    }
}

/// Ours and theirs in turn; OpenCV's first answer, and its shortest times.
fn rounds(
    ours: &mut [Vec<Timed<'_>>],
    tasks: &[Task<'_>],
    script: &Script,
) -> Result<(Answer, Vec<Vec<f64>>), Failure> {
    let mut least: Vec<Vec<f64>> = Vec::new();
    let mut answer = None;
    for round in 0..ROUNDS {
        // What is not timed is done once.
        let at_work: Vec<usize> = (0..tasks.len()).filter(|&i| round == 0 || tasks[i].seconds > 0.0).collect();
        for &i in &at_work {
            for timed in &mut ours[i] {
                timed.seconds = timed.seconds.min(shortest(&mut timed.kernel, tasks[i].frame, tasks[i].seconds)?);
            }
        }
        let next = script.run(&at_work.iter().map(|&i| tasks[i]).collect::<Vec<_>>())?;
        least.resize(tasks.len(), vec![f64::INFINITY; next.kernels.len()]);
        for (&i, next) in at_work.iter().zip(&next.seconds) {
            least[i].iter_mut().zip(next).for_each(|(least, next)| *least = least.min(*next));
        }
        // The first round has every patch.
        answer.get_or_insert(next);
    }
    Ok((answer.ok_or("no rounds")?, least))
}

/// The cells that are compared, 255 each.
fn mask(counted: &[bool], exact: &[Option<f64>], (cols, rows): (u16, u16)) -> Picture {
    let is_compared = counted.iter().zip(exact).map(|(&counted, exact)| counted && exact.is_some());
    let pixels = is_compared.map(|is_compared| if is_compared { 255 } else { 0 }).collect();
    Picture { cols: cols.into(), rows: rows.into(), pixels }
}

/// Shortest time from a frame's first row to its patch, repeated for so long.
fn shortest(kernel: &mut Kernel<'_>, frame: &Grey, seconds: f64) -> Result<f64, Failure> {
    kernel.rectify(frame)?;
    let (mut least, begin) = (f64::INFINITY, Instant::now());
    loop {
        let before = Instant::now();
        kernel.rectify(black_box(frame))?;
        least = least.min(before.elapsed().as_secs_f64());
        if begin.elapsed().as_secs_f64() >= seconds {
            return Ok(least);
        }
    }
}
