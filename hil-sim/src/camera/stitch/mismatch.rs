//! How well the heads of a virtual image fit together: the same ground in two of them, found by the core's own matching.
//!
//! Where two heads overlap, windows are rectified from each and the one is looked for in the other, to hundredths of a
//! pixel. What is left is what a calibration, a lens or the parallax of the heads' places has put between them. A window
//! without texture, or farther off than it is looked for, is not matched: how many there were is reported. The measurement's
//! own noise, some 0.02 px, is in the figures.

use super::{check, rectified, reduce};
use crate::camera::heads::{Rig, Tile};
use crate::camera::still::{Patch, Reduced, runs_of};
use crate::camera::still_match::align;
use plumbline_core::image::Run;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{Bands, Picture};
use rayon::prelude::*;

/// Side of a window, virtual pixels.
const WINDOW_PX: usize = 48;
/// How far it is looked for.
pub const SEARCH_PX: usize = 6;
/// A window with the search around it.
const AROUND_PX: usize = WINDOW_PX + 2 * SEARCH_PX;
/// Head pixels that the window's surroundings keep from a frame's border.
const MARGIN_PX: f64 = 2.0;
/// Most windows of a pair of heads, spread evenly over the overlap.
const WINDOWS_MAX: usize = 400;

/// Mismatch of two pictures of the same ground, virtual pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct Mismatch {
    /// The two heads, counted from 0.
    pub heads: [usize; 2],
    /// Windows that were matched.
    pub windows: usize,
    /// Windows that both show.
    pub tried: usize,
    /// Root mean square of the shifts' lengths; `None` without a window.
    pub rms_px: Option<f64>,
    /// The longest shift.
    pub max_px: Option<f64>,
}

impl Mismatch {
    /// Of the windows that both show, each with its shift if it was matched.
    fn of(heads: [usize; 2], windows: &[Option<f64>]) -> Self {
        let shifts: Vec<f64> = windows.iter().copied().flatten().collect();
        let tried = windows.len();
        let count = shifts.len();
        let rms = (shifts.iter().map(|shift| shift * shift).sum::<f64>() / count as f64).sqrt();
        let longest = shifts.iter().copied().fold(0.0, f64::max);
        Mismatch {
            heads,
            windows: count,
            tried,
            rms_px: (count > 0).then_some(rms),
            max_px: (count > 0).then_some(longest),
        }
    }
}

/// Pairs of heads with an overlap that windows fit into, and where those windows lie.
#[must_use]
pub fn pairs(rig: &Rig) -> Vec<([usize; 2], Vec<Tile>)> {
    let count = rig.views.len();
    let all = (0..count).flat_map(|first| (first + 1..count).map(move |second| [first, second]));
    let with_windows = all.map(|heads| (heads, windows(rig, |tile| heads.iter().all(|&head| sees(rig, head, tile)))));
    with_windows.filter(|(_, windows)| !windows.is_empty()).collect()
}

/// The windows of a grid over the virtual image that are `wanted`, at most [`WINDOWS_MAX`] of them.
fn windows(rig: &Rig, wanted: impl Fn(&Tile) -> bool) -> Vec<Tile> {
    let places = |side: usize| (0..(side + 1).saturating_sub(AROUND_PX)).step_by(WINDOW_PX / 2);
    let tiles = places(rig.size.1)
        .flat_map(|top| places(rig.size.0).map(move |left| Tile { corner: (left, top), size: (AROUND_PX, AROUND_PX) }));
    let all: Vec<Tile> = tiles.filter(wanted).collect();
    let kept = all.len().min(WINDOWS_MAX);
    (0..kept).map(|index| all[index * all.len() / kept]).collect()
}

/// Whether head `head` sees all of a tile: its frame is convex and so are the lens's borders, but for a fraction of the
/// margin.
fn sees(rig: &Rig, head: usize, tile: &Tile) -> bool {
    let at = |corner: usize, size: usize, part: usize| corner as f64 + 0.5 * part as f64 * (size as f64 - 1.0);
    (0..9).all(|point| {
        let (col, row) = (at(tile.corner.0, tile.size.0, point % 3), at(tile.corner.1, tile.size.1, point / 3));
        rig.inside_px(head, col, row) >= MARGIN_PX
    })
}

/// The mismatch of each of `pairs`. `progress` is called after each pair.
///
/// # Errors
/// As [`super::stitch`].
pub fn mismatches(
    rig: &Rig,
    frames: &[Bands],
    pairs: &[([usize; 2], Vec<Tile>)],
    progress: &(dyn Fn() + Sync),
) -> Result<Vec<Mismatch>, InputError> {
    check(rig, frames)?;
    let greys: Vec<Picture> = frames.iter().map(Bands::grey).collect();
    let reduced = greys.iter().enumerate().map(|(head, grey)| reduce(rig, head, std::slice::from_ref(grey)));
    let reduced = reduced.collect::<Result<Vec<_>, _>>()?.concat();
    let of_pair = |(heads, windows): &([usize; 2], Vec<Tile>)| {
        let [one, other] = *heads;
        let shifts = windows.par_iter().map(|tile| {
            let shows = |head: usize| seen_whole(rig, head, &reduced[head], tile);
            Ok(shows(one)?.zip(shows(other)?).map(|(one, other)| shift(&one, &other)))
        });
        let shifts = shifts.collect::<Result<Vec<_>, InputError>>()?;
        progress();
        Ok(Mismatch::of(*heads, &shifts.into_iter().flatten().collect::<Vec<_>>()))
    };
    pairs.iter().map(of_pair).collect()
}

/// The shifts between a virtual image and another picture of its size, such as one that a single camera took: mismatch of a
/// whole image instead of seams. Windows that touch anything black (not seen) are left out.
#[must_use]
pub fn against(rig: &Rig, image: &Picture, other: &Picture) -> Mismatch {
    let cut = |picture: &Picture, tile: &Tile| {
        let line = |row: usize| &picture.pixels[(tile.corner.1 + row) * picture.cols + tile.corner.0..][..tile.size.0];
        Picture { cols: tile.size.0, rows: tile.size.1, pixels: (0..tile.size.1).flat_map(line).copied().collect() }
    };
    let tiles = windows(rig, |tile| cut(image, tile).pixels.iter().all(|grey| *grey > 0));
    let shifts = tiles.par_iter().map(|tile| shift(&cut(image, tile), &cut(other, tile)));
    Mismatch::of([0, 0], &shifts.collect::<Vec<_>>())
}

/// A tile as a head shows it, if it shows all of it.
fn seen_whole(rig: &Rig, head: usize, reduced: &Reduced<'_>, tile: &Tile) -> Result<Option<Picture>, InputError> {
    let Patch { picture, runs } = rectified(rig, head, reduced, tile)?;
    let seen: usize = runs.iter().map(|run| usize::from(run.end - run.start)).sum();
    Ok((seen == picture.pixels.len()).then_some(picture))
}

/// How far the middle of `one` is off in `other`, pixels; `None` where it cannot be measured.
fn shift(one: &Picture, other: &Picture) -> Option<f64> {
    let line = |row: usize| &one.pixels[(row + SEARCH_PX) * one.cols + SEARCH_PX..][..WINDOW_PX];
    let pixels = (0..WINDOW_PX).flat_map(line).copied().collect();
    let window = Picture { cols: WINDOW_PX, rows: WINDOW_PX, pixels };
    let whole = runs_of(&Picture { pixels: vec![255; WINDOW_PX * WINDOW_PX], ..window });
    let place = align(&window, whole.as_slice() as &[Run], other, SEARCH_PX as u16).ok()?;
    place.accepted.then(|| f64::from(place.d_col).hypot(f64::from(place.d_row)))
}
