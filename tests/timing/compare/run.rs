//! All of it, in rounds that take turns: what slows the machine for a while slows both.

use super::cases::{Case, Limits};
use super::ours::{Kernel, Way};
use super::score::{Score, score, shift_px};
use super::theirs::{Answer, Script, Task};
use super::view::{Ground, Pose, View};
use super::{Failure, Grey};
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
    /// Shortest time, seconds.
    pub seconds: f64,
}

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
    /// Whether it is the picture without detail.
    pub is_smooth: bool,
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
    let seconds = |case: &Case| if case.is_smooth { 0.0 } else { SECONDS };
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
        let row = |kernel: &str, is_ours: bool, pixels: &[u8], seconds: f64| Row {
            kernel: kernel.to_owned(),
            is_ours,
            score: score(pixels, &exact, &counted),
            shift_px: case.is_smooth.then(|| shift_px(pixels, &exact, &counted, view)).flatten(),
            seconds,
        };
        let core = patches.iter().map(|(timed, patch)| row(timed.way.name(), true, &patch.pixels, timed.seconds));
        let theirs = answer.kernels.iter().zip(&answer.patches[i]).zip(&their_seconds[i]);
        let rows = core.chain(theirs.map(|((name, pixels), least)| row(name, false, pixels, *least))).collect();
        outcomes.push(Outcome {
            picture: case.picture,
            frame: case.frame.size,
            ground: case.ground,
            pose: *pose,
            limits: case.limits,
            is_smooth: case.is_smooth,
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

/// Ours and theirs in turn; OpenCV's last answer, and its shortest times.
fn rounds(
    ours: &mut [Vec<Timed<'_>>],
    tasks: &[Task<'_>],
    script: &Script,
) -> Result<(Answer, Vec<Vec<f64>>), Failure> {
    let mut their_seconds: Vec<Vec<f64>> = Vec::new();
    let mut answer = None;
    for _ in 0..ROUNDS {
        for (kernels, task) in ours.iter_mut().zip(tasks) {
            for timed in kernels {
                timed.seconds = timed.seconds.min(shortest(&mut timed.kernel, task.frame, task.seconds)?);
            }
        }
        let next = script.run(tasks)?;
        their_seconds.resize(tasks.len(), vec![f64::INFINITY; next.kernels.len()]);
        for (least, next) in their_seconds.iter_mut().flatten().zip(next.seconds.iter().flatten()) {
            *least = least.min(*next);
        }
        answer = Some(next);
    }
    Ok((answer.ok_or("no rounds")?, their_seconds))
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
