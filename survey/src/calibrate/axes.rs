//! Whether image coordinates count as they should: x to the right and y up, from the frame's middle.

use super::block::Block;
use super::observations::Observations;
use crate::adjust::rig::{LENS, project};
use crate::error::InputError;

/// Start values that others fit so much better are not those of the axes that were written. Right axes and rough start values make
/// all of them as bad; wrong ones make residuals of half a frame, against tens of pixels.
const FITS_BETTER: f64 = 4.0;
/// A point on the border may lie half a pixel beyond the outermost one's centre, and noise beside that.
const BORDER_PX: f64 = 2.0;
/// How far beyond its frame, in parts of its side, a point may lie that was corrected for its lens: chosen, as barrel distortions
/// of wide lenses move corners by less.
const BEYOND: f64 = 0.25;
/// What to write of coordinates that count from the frame's top left corner.
const CORNER_DOWN: &str =
    "the origin is the frame's top left corner: write x_px - (cols - 1) / 2 and (rows - 1) / 2 - y_px";
const CORNER_UP: &str =
    "the origin is the frame's bottom left corner: write x_px - (cols - 1) / 2 and y_px - (rows - 1) / 2";

/// What to write of coordinates in millimetres.
const MILLIMETRES: &str = "they are millimetres: write x_px / pixel_mm and y_px / pixel_mm";
/// Tangent of the largest angle from the axis at which a lens of this model has a point, 75 degrees.
const WIDEST: f64 = 3.73;

/// Refuses a focal length that makes a fisheye of the points' places, as millimetres in the place of pixels do.
fn sees(block: &Block, observations: &Observations) -> Result<(), InputError> {
    let seen = observations.seen.iter().zip(&observations.lines);
    let beyond = |head: usize, at: [f64; 2]| at[0].hypot(at[1]) > WIDEST * block.heads[head].values[LENS];
    let Some((seen, line)) = seen.into_iter().find(|(seen, _)| beyond(seen.head, seen.image_px)) else { return Ok(()) };
    let (f_px, [x, y]) = (block.heads[seen.head].values[LENS], seen.image_px);
    let meant = focal_meant(block, observations)
        .map_or_else(String::new, |(unit, factor)| format!("; were it {unit}, f_px would be {:.0}", f_px * factor));
    Err(InputError::new(format!(
        "{}, line {line}: x_px {x} and y_px {y} are more than 75 degrees off the axis of a head whose f_px is {f_px}; it is the focal length in pixels{meant}",
        observations.name
    )))
}

/// What the focal length is in the place of pixels, and the factor that makes pixels of it, if the start values fit so.
fn focal_meant(block: &Block, observations: &Observations) -> Option<(&'static str, f64)> {
    let mm = block.sizes.pixel_mm?;
    let as_written = median_off_px(block, observations, &|at| at);
    let fits = |factor: f64| {
        let mut other = block.clone();
        other.heads.iter_mut().for_each(|head| head.values[LENS] *= factor);
        FITS_BETTER * median_off_px(&other, observations, &|at| at) < as_written
    };
    let units = [("millimetres", 1.0 / mm), ("metres", 1000.0 / mm)];
    units.into_iter().find(|(_, factor)| fits(*factor))
}

/// Refuses image coordinates that count as OpenCV's do, y down, or from a corner of the frame, and those of no such frame.
pub(super) fn check(block: &Block, observations: &Observations) -> Result<(), InputError> {
    sees(block, observations)?;
    let from_corner = is_from_corner(observations);
    let middle = |down: bool| middle_px(block, observations, down);
    type Reading = fn([f64; 2], [f64; 2]) -> [f64; 2];
    let pixel_mm = block.sizes.pixel_mm.unwrap_or(1.0);
    let readings: [(Reading, bool, [f64; 2], &str); 6] = [
        (|[x, y], _| [x, -y], true, [0.0; 2], "y_px counts downward, as OpenCV has it: write -y_px"),
        (|[x, y], [x0, y0]| [x - x0, y0 - y], from_corner, middle(true), CORNER_DOWN),
        (|[x, y], [x0, y0]| [x - x0, y - y0], from_corner, middle(false), CORNER_UP),
        (|[x, y], _| [y, x], true, [0.0; 2], "x_px and y_px are swapped"),
        (|[x, y], _| [-x, -y], true, [0.0; 2], "the frame is turned by 180 degrees: write -x_px and -y_px"),
        (|[x, y], [mm, _]| [x / mm, y / mm], block.sizes.pixel_mm.is_some(), [pixel_mm; 2], MILLIMETRES),
    ];
    let as_written = median_off_px(block, observations, &|at| at);
    for (reading, may_be, middle, meant) in readings {
        if !may_be {
            continue;
        }
        let other = median_off_px(block, observations, &|at| reading(at, middle));
        if FITS_BETTER * other < as_written {
            return Err(InputError::new(format!(
                "{}: by the start values half of the points lie {as_written:.0} px and more off, but {other:.0} px if {meant}; x_px is right and y_px up from the frame's middle",
                observations.name
            )));
        }
    }
    in_frame(block, observations)
}

/// Whether no coordinate lies left of or below the origin, as none does that is counted from a corner.
pub(super) fn is_from_corner(observations: &Observations) -> bool {
    observations.seen.iter().all(|seen| seen.image_px.iter().all(|at| *at >= -BORDER_PX))
}

/// Refuses points that lie far outside the frame that the block states.
fn in_frame(block: &Block, observations: &Observations) -> Result<(), InputError> {
    let Some([cols, rows]) = block.sizes.head else { return Ok(()) };
    let most = [cols, rows].map(|side| (0.5 + BEYOND) * f64::from(side) + BORDER_PX);
    let is_outside = |at: &[f64; 2]| (0..2).any(|k| at[k].abs() > most[k]);
    match observations.seen.iter().zip(&observations.lines).find(|(seen, _)| is_outside(&seen.image_px)) {
        Some((seen, line)) => Err(InputError::new(format!(
            "{}, line {line}: x_px {} and y_px {} lie far outside a frame of {cols} x {rows} pixels about its middle; cols and rows of the \
             block are those of a head's frame",
            observations.name, seen.image_px[0], seen.image_px[1]
        ))),
        None => Ok(()),
    }
}

/// Where the frame's middle is if coordinates are counted from a corner: as the block's size has it, or else the median of what is
/// left over where the start values have the points.
fn middle_px(block: &Block, observations: &Observations, down: bool) -> [f64; 2] {
    if let Some(size) = block.sizes.head {
        return size.map(|side| 0.5 * (f64::from(side) - 1.0));
    }
    let off = observations.seen.iter().filter_map(|seen| {
        let (station, point) = (&block.stations[seen.station], block.points[seen.point].position_m);
        let [x, y] = project(&block.heads[seen.head].values, station, point)?;
        let [at_x, at_y] = seen.image_px;
        Some([at_x - x, if down { at_y + y } else { at_y - y }])
    });
    let off: Vec<[f64; 2]> = off.collect();
    [0, 1].map(|k| median(off.iter().map(|off| off[k]).collect()))
}

fn median(mut values: Vec<f64>) -> f64 {
    let middle = values.len() / 2;
    if values.is_empty() { 0.0 } else { *values.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// The median distance of the image points, read somehow, from where the start values have them, pixels.
fn median_off_px(block: &Block, observations: &Observations, read: &dyn Fn([f64; 2]) -> [f64; 2]) -> f64 {
    let off = observations.seen.iter().filter_map(|seen| {
        let (station, point) = (&block.stations[seen.station], block.points[seen.point].position_m);
        let [x, y] = project(&block.heads[seen.head].values, station, point)?;
        let at = read(seen.image_px);
        Some((at[0] - x).hypot(at[1] - y))
    });
    median(off.collect())
}
