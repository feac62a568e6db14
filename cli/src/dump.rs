//! A frame's pictures: what the camera delivered, what the firmware made of it, and what it was matched with; and the frames as
//! `plumbline evaluate` takes them.
//!
//! The firmware sends its patch but no mask. The mask is made again by the core, from the frame and from the situation
//! that the firmware reported bit by bit; it is used only where it belongs to a patch of the same size.

use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::image::View;
use plumbline_core::navigation::Navigation;
use plumbline_core::pipeline::{Buffers, FollowUpMode, Memory, Pipeline, Situation};
use plumbline_core::tile::Local;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Metres, Micros, Radians};
use plumbline_firmware::wire::telemetry::{FrameReport, PositionReport, SituationReport};
use plumbline_sim::run::{Flight, FrameRecord};
use plumbline_sim::score::frames;
use plumbline_sim::setup::Setup;
use plumbline_survey::error::InputError;
use plumbline_survey::io::output::write_file;
use plumbline_survey::io::picture::{Picture, write_grey_png};
use std::path::Path;

/// The pictures of a frame that was kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Views {
    /// The camera's frame, row 0 forward.
    pub frame: Picture,
    /// What was made of it; `None` where the frame was refused before.
    pub rectified: Option<Rectified>,
}

/// What a frame was rectified to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Rectified {
    /// The firmware's patch, row 0 north, 0 where invalid.
    pub patch: Picture,
    /// 255 valid, 0 not.
    pub mask: Picture,
    /// The reference around the match, or around the prediction where nothing was matched, to the nearest whole pixel
    /// and of the patch's size; `None` where that leaves the tile.
    pub reference: Option<Picture>,
}

/// The pictures of `record`; `None` when its frame was not kept.
pub fn views(setup: &Setup, record: &FrameRecord) -> Option<Views> {
    let camera = &setup.payload.camera;
    let pixels = record.frame.clone()?;
    let frame = Picture { cols: camera.cols as usize, rows: camera.rows as usize, pixels };
    let rectified = rectified(setup, record, &frame);
    Some(Views { frame, rectified })
}

fn rectified(setup: &Setup, record: &FrameRecord, frame: &Picture) -> Option<Rectified> {
    let report = record.report.as_ref()?;
    let received = record.patch.as_ref()?;
    let (cols, rows) = (usize::from(received.size.0), usize::from(received.size.1));
    let patch = Picture { cols, rows, pixels: received.pixels.clone() };
    let (_, mask) = rectified_again(setup, report, frame)?;
    ((mask.cols, mask.rows) == (cols, rows)).then(|| Rectified {
        reference: reference(setup, report, received.size),
        patch,
        mask,
    })
}

/// Patch and mask by the core, as on board.
fn rectified_again(setup: &Setup, report: &FrameReport, frame: &Picture) -> Option<(Picture, Picture)> {
    let configuration = &setup.flash.configuration;
    let settings = configuration.settings().ok()?;
    let SituationReport { height_m, heading_rad, pitch_rad, roll_rad, follow_up_rad } = report.situation?;
    let attitude = Attitude { heading: Radians(heading_rad), pitch: Radians(pitch_rad), roll: Radians(roll_rad) };
    let follow_up = (Radians(follow_up_rad), settings.follow_up == FollowUpMode::Followed);
    let (mut buffers, mut navigation) = (Box::<Buffers>::default(), Navigation::default());
    let mut frame_memory = vec![0; FRAME_MEMORY_BYTES];
    let memory = Memory { buffers: &mut buffers, navigation: &mut navigation, frame: &mut frame_memory };
    let tile = setup.flash.head.tile(&setup.flash.tile, &setup.flash.posts).ok()?;
    // The board takes the plane a moment earlier, metres away, and under the footprint's middle.
    let half_m = 0.5 * settings.camera.patch_size(height_m, tile.resolution().0).0 * tile.resolution().0;
    let plane = report
        .predicted
        .and_then(|PositionReport { east_m, north_m }| tile.elevation()?.plane(Local { east_m, north_m }, half_m));
    let slope = plane.map_or([0.0; 2], |plane| plane.slope);
    let mut pipeline = Pipeline::new(settings, tile, memory).ok()?;
    // The reduction follows from the range; the one at mid-exposure stands for the newest one then.
    pipeline.streams.slant(Micros(0), Metres(height_m / attitude.cos_tilt())).ok()?;
    pipeline.begin_frame().ok()?;
    pipeline.rows(&frame.pixels).ok()?;
    pipeline
        .rectify(&Situation {
            mount: settings.mount,
            slope,
            ..Situation::exact(Micros(report.mid_exposure_us), attitude, follow_up, height_m)
        })
        .ok()?;
    let (pixels, size, runs) = pipeline.patch();
    let patch = Picture { cols: size.0.into(), rows: size.1.into(), pixels: pixels.to_vec() };
    let mut mask = Picture { pixels: vec![0; pixels.len()], ..patch };
    for run in runs {
        let row = usize::from(run.row) * mask.cols;
        mask.pixels.get_mut(row + usize::from(run.start)..row + usize::from(run.end))?.fill(255);
    }
    Some((patch, mask))
}

/// Where the upper left pixel of a patch of that size lies in the tile by the board's prediction, (column, row).
pub fn predicted_corner(setup: &Setup, report: &FrameReport, size: (u16, u16)) -> Option<[f32; 2]> {
    let head = &setup.flash.head;
    let PositionReport { east_m, north_m } = report.predicted?;
    let middle = |side: u16| 0.5 * (f32::from(side) - 1.0);
    Some([
        middle(head.size.0) + east_m / head.resolution_m - middle(size.0),
        middle(head.size.1) - north_m / head.resolution_m - middle(size.1),
    ])
}

/// The tile's pixels under the patch where it was matched.
fn reference(setup: &Setup, report: &FrameReport, size: (u16, u16)) -> Option<Picture> {
    let [col, row] = predicted_corner(setup, report, size)?;
    let [d_col, d_row] = report.matched.map_or([0.0; 2], |matched| [matched.d_col, matched.d_row]);
    let at = ((col + d_col).round() as i32, (row + d_row).round() as i32);
    let window = View::new(&setup.flash.tile, setup.flash.head.size)?.window(at.0, at.1, size)?;
    let (cols, rows) = (usize::from(size.0), usize::from(size.1));
    let pixels = (0..rows).filter_map(|row| window.run(row, 0, cols)).flatten().copied().collect();
    Some(Picture { cols, rows, pixels })
}

/// The pictures of a frame, by the first part of their names.
const KINDS: [&str; 4] = ["frame", "patch", "mask", "reference"];

/// The frames for `plumbline evaluate`.
pub const EVALUATED: &str = "flown_frames.csv";

/// Writes `frame_0000.png`, `patch_0000.png`, `mask_0000.png` and `reference_0000.png` for the first `count` frames, and
/// [`EVALUATED`] if there are any. A refused frame has no patch. What an earlier flight left in the folder is removed first, as it
/// would be taken for this one's.
///
/// # Errors
/// A picture that cannot be written or removed.
pub fn write(folder: &Path, setup: &Setup, flight: &Flight, count: u32) -> Result<(), InputError> {
    remove_pictures(folder)?;
    if count > 0 {
        let name = |record: &FrameRecord| name_of("frame", record);
        let kept = flight.frames.iter().take(count as usize).filter(|record| record.frame.is_some());
        write_file(&folder.join(EVALUATED), frames::csv(setup, kept, name).as_bytes())?;
    }
    for record in flight.frames.iter().take(count as usize) {
        let Some(views) = views(setup, record) else { continue };
        let rectified = views.rectified.as_ref();
        let pictures = [
            Some(&views.frame),
            rectified.map(|r| &r.patch),
            rectified.map(|r| &r.mask),
            rectified.and_then(|r| r.reference.as_ref()),
        ];
        for (kind, picture) in KINDS.into_iter().zip(pictures) {
            let path = folder.join(name_of(kind, record));
            picture.map_or(Ok(()), |picture| write_grey_png(&path, picture))?;
        }
    }
    Ok(())
}

fn name_of(kind: &str, record: &FrameRecord) -> String {
    format!("{kind}_{:04}.png", record.exposure.frame)
}

/// Removes the pictures of an earlier flight, and its table of them.
fn remove_pictures(folder: &Path) -> Result<(), InputError> {
    let refuse = |path: &Path, error| InputError::new(format!("cannot remove {}: {error}", path.display()));
    for entry in std::fs::read_dir(folder).map_err(|error| refuse(folder, error))?.flatten() {
        if entry.file_name().to_str().is_some_and(|name| is_picture(name) || name == EVALUATED) {
            std::fs::remove_file(entry.path()).map_err(|error| refuse(&entry.path(), error))?;
        }
    }
    Ok(())
}

/// Whether a name is that of a picture of a frame: `frame_0000.png`.
fn is_picture(name: &str) -> bool {
    let parts = name.strip_suffix(".png").and_then(|name| name.split_once('_'));
    parts.is_some_and(|(kind, frame)| {
        KINDS.contains(&kind) && frame.len() >= 4 && frame.bytes().all(|byte| byte.is_ascii_digit())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_pictures_of_frames_are_known_by_their_names() {
        for name in ["frame_0000.png", "patch_0123.png", "mask_12345.png", "reference_0001.png"] {
            assert!(is_picture(name), "{name}");
        }
        for name in
            ["frame_0000.jpg", "frame_00.png", "frame_000a.png", "photo_0000.png", "frame.png", "frames_0000.png"]
        {
            assert!(!is_picture(name), "{name}");
        }
    }

    use crate::pages::flight::tests::flown;

    /// The core's patch equals the firmware's in every pixel: so its mask is the firmware's mask.
    #[test]
    fn the_patch_made_again_is_the_one_sent() {
        let flown = flown();
        let mut compared = 0;
        for record in &flown.flight.frames {
            let Some(views) = views(&flown.setup, record) else { continue };
            let Some(rectified) = views.rectified else { continue };
            let report = record.report.as_ref().expect("a patch has a report");
            let (again, mask) = rectified_again(&flown.setup, report, &views.frame).expect("rectified");
            assert!(again == rectified.patch, "frame {}", record.exposure.frame);
            assert!(mask == rectified.mask);
            let outside = rectified.patch.pixels.iter().zip(&mask.pixels).filter(|&(_, &valid)| valid == 0);
            assert!(outside.map(|(&pixel, _)| pixel).all(|pixel| pixel == 0));
            compared += 1;
        }
        assert!(compared >= 4, "{compared} frames compared");
    }

    /// The reference lies where the firmware matched: over the valid pixels it has the correlation that the firmware
    /// found there, to the rounding of its single precision, and less when it is shifted.
    #[test]
    fn the_reference_lies_under_the_patch() {
        let flown = flown();
        let mut compared = 0;
        for record in &flown.flight.frames {
            let Some(rectified) = views(&flown.setup, record).and_then(|views| views.rectified) else { continue };
            let Some(matched) = record.report.and_then(|r| r.matched) else { continue };
            // The firmware's score is that of the whole-pixel peak.
            if (matched.d_col - matched.peak_col).abs() >= 0.5 || (matched.d_row - matched.peak_row).abs() >= 0.5 {
                continue;
            }
            let reference = rectified.reference.as_ref().expect("a match lies in the tile");
            let here = correlation(&rectified, reference, 0);
            let score = matched.correlation;
            assert!((here - f64::from(score)).abs() < 1e-3, "frame {}: {here}, not {score}", record.exposure.frame);
            assert!(correlation(&rectified, reference, 1) < here, "frame {}", record.exposure.frame);
            compared += 1;
        }
        assert!(compared >= 3, "{compared} frames compared");
    }

    /// Over the valid pixels, the reference read `shift` pixels on.
    fn correlation(rectified: &Rectified, reference: &Picture, shift: usize) -> f64 {
        let pairs: Vec<[f64; 2]> = (rectified.patch.pixels.iter().zip(&rectified.mask.pixels))
            .zip(reference.pixels.iter().skip(shift))
            .filter(|&((_, &valid), _)| valid != 0)
            .map(|((&patch, _), &reference)| [f64::from(patch), f64::from(reference)])
            .collect();
        let mean = |axis: usize| pairs.iter().map(|pair| pair[axis]).sum::<f64>() / pairs.len() as f64;
        let means = [mean(0), mean(1)];
        let product = |a: usize, b: usize| pairs.iter().map(|p| (p[a] - means[a]) * (p[b] - means[b])).sum::<f64>();
        product(0, 1) / (product(0, 0) * product(1, 1)).sqrt()
    }
}
