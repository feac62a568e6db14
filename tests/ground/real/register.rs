//! Where one rectified frame lies relative to another, by the core's matcher alone.

use super::ground::Ground;
use plumbline_core::image::{Run, View};
use plumbline_core::matching::acceptance::AcceptRule;
use plumbline_core::matching::correlation::{Located, locate};
use plumbline_core::matching::search::working_bytes;
use plumbline_core::matching::{MatchError, Prior, grey_correlation};
use plumbline_sim::camera::still::runs_of;
use plumbline_survey::io::picture::Picture;

/// What the gimbal's yaw and the barometer's height leave of turn and scale between two frames, one sigma: a degree and
/// a percent.
const PRIOR: Prior = Prior { turn_rad: 0.0175, scale: 0.01 };
/// Pixels that are kept from the borders of the other frame, beyond the search: what details and gradients look at.
const BORDER: i32 = 4;

/// A rectangle around the middle of the overlap, metres: its centre east and north of there, and half its sides.
#[derive(Clone, Copy, Debug)]
pub struct Part {
    pub centre_m: [f64; 2],
    pub half_m: [f64; 2],
}

impl Part {
    /// All of the overlap.
    pub const WHOLE: Part = Part { centre_m: [0.0; 2], half_m: [38.0; 2] };
}

/// A registration of two frames.
#[derive(Clone, Copy, Debug)]
pub struct Registered {
    /// Nadir of the second frame minus that of the first, metres east and north.
    pub offset_m: [f64; 2],
    /// Its standard deviations as the core states them, metres east and north; infinite without a sub-pixel solution.
    pub sigma_m: [f64; 2],
    /// What the core found.
    pub located: Located,
}

/// The patch out of the first frame and the window of the second, cut so that `expected_m` is a shift of nearly 0.
struct Pair {
    patch: Picture,
    runs: Vec<Run>,
    reference: Picture,
    /// Offset that a shift of 0 stands for, pixels (col, row).
    zero: [i32; 2],
}

impl Pair {
    /// Cuts around the middle between both nadirs, so that a turn between the frames shifts what is measured equally
    /// for both directions of matching. Patch pixels count where both frames are valid at every shift of the search.
    fn cut(a: &Ground, b: &Ground, expected_m: [f64; 2], part: &Part, radius: i32) -> Self {
        let px = |[east, north]: [f64; 2]| [east / a.resolution_m, -north / a.resolution_m];
        let (expected, centre) = (px(expected_m), px(part.centre_m));
        let half = part.half_m.map(|half| (half / a.resolution_m).round() as i32);
        let zero = expected.map(|p| p.round() as i32);
        let in_a = [0, 1].map(|axis| (0.5 * expected[axis] + centre[axis]).round() as i32);
        let in_b = [0, 1].map(|axis| in_a[axis] - zero[axis]);
        let reach = radius + BORDER;
        let counts = |col: i32, row: i32| {
            let corner = |(dc, dr)| b.is_valid(in_b[0] + col + dc * reach, in_b[1] + row + dr * reach);
            a.is_valid(in_a[0] + col, in_a[1] + row) && [(-1, -1), (-1, 1), (1, -1), (1, 1)].into_iter().all(corner)
        };
        let patch = cut(half, |col, row| a.grey(in_a[0] + col, in_a[1] + row));
        let mask = cut(half, |col, row| u8::from(counts(col, row)));
        let reference = cut(half.map(|half| half + radius), |col, row| b.grey(in_b[0] + col, in_b[1] + row));
        Pair { patch, runs: runs_of(&mask), reference, zero }
    }
}

/// Picture of 2 `half` + 1 pixels a side, of the greys at (col, row) from its middle.
fn cut(half: [i32; 2], grey: impl Fn(i32, i32) -> u8) -> Picture {
    let pixels = (-half[1]..=half[1]).flat_map(|row| (-half[0]..=half[0]).map(move |col| (col, row)));
    let pixels = pixels.map(|(col, row)| grey(col, row)).collect();
    Picture { cols: 2 * half[0] as usize + 1, rows: 2 * half[1] as usize + 1, pixels }
}

fn view(picture: &Picture) -> View<'_> {
    View::new(&picture.pixels, (picture.cols as u16, picture.rows as u16)).expect("the sizes fit")
}

/// Looks for the overlap's `part` as `a` shows it in `b`, within ±`radius` pixels of the offset `expected_m`.
pub fn register(
    a: &Ground,
    b: &Ground,
    expected_m: [f64; 2],
    part: &Part,
    radius: u16,
) -> Result<Registered, MatchError> {
    let pair = Pair::cut(a, b, expected_m, part, i32::from(radius));
    let side = 2 * usize::from(radius) + 1;
    let (mut bytes, mut scores) =
        (vec![0; working_bytes((pair.reference.cols as u16, pair.reference.rows as u16))], vec![0; side * side]);
    let rule = (PRIOR, &AcceptRule::default());
    let (patch, reference) = (view(&pair.patch), view(&pair.reference));
    let located = locate(&patch, &pair.runs, &reference, radius, rule, (&mut bytes, &mut scores))?;
    let shift = <[f32; 2]>::from(located.shift()).map(f64::from);
    let sigma = |axis| located.refined.map_or(f64::INFINITY, |s| f64::from(s.covariance()[(axis, axis)]).sqrt());
    let offset = [0, 1].map(|axis| f64::from(pair.zero[axis]) - shift[axis]);
    Ok(Registered {
        offset_m: [offset[0] * a.resolution_m, -offset[1] * a.resolution_m],
        sigma_m: [sigma(0) * a.resolution_m, sigma(1) * a.resolution_m],
        located,
    })
}

/// Correlation of the greys of both frames over their overlap when they are laid `offset_m` apart.
pub fn likeness(a: &Ground, b: &Ground, offset_m: [f64; 2]) -> f32 {
    let pair = Pair::cut(a, b, offset_m, &Part::WHOLE, 0);
    grey_correlation(&view(&pair.patch), &pair.runs, &view(&pair.reference), 0, (0, 0))
}
