//! Pictures for the page: reduced frames, patches without their invalid pixels, and patch over reference.

use crate::dump::Rectified;
use plumbline_charts::png::{Colour, encode, uri};
use plumbline_survey::io::picture::Picture;

/// Widest frame on the page, pixels.
const FRAME_MAX_PX: usize = 256;
/// Grey values a standard deviation of the texture is stretched to.
const CONTRAST_DN: f64 = 45.0;

/// A frame, averaged over boxes until it is no wider than the page needs.
pub fn frame(frame: &Picture) -> String {
    let factor = frame.cols.max(frame.rows).div_ceil(FRAME_MAX_PX).max(1);
    let (cols, rows) = (frame.cols / factor, frame.rows / factor);
    let mean = |col: usize, row: usize| {
        let box_row = |r: usize| {
            let from = (row * factor + r) * frame.cols + col * factor;
            frame.pixels.get(from..from + factor).unwrap_or(&[]).iter().map(|&p| u32::from(p)).sum::<u32>()
        };
        ((0..factor).map(box_row).sum::<u32>() / (factor * factor) as u32) as u8
    };
    let pixels: Vec<u8> = (0..cols * rows).map(|index| mean(index % cols, index / cols)).collect();
    uri(&encode(cols, rows, Colour::Grey, &pixels))
}

/// A patch; what the frame does not show is transparent.
pub fn patch(rectified: &Rectified) -> String {
    let patch = &rectified.patch;
    let samples: Vec<u8> =
        patch.pixels.iter().zip(&rectified.mask.pixels).flat_map(|(&grey, &valid)| [grey, valid]).collect();
    uri(&encode(patch.cols, patch.rows, Colour::GreyAlpha, &samples))
}

/// The reference around the match.
pub fn reference(reference: &Picture) -> String {
    uri(&encode(reference.cols, reference.rows, Colour::Grey, &reference.pixels))
}

/// Patch in red over the reference in cyan, both brought to one mean and contrast: grey where they agree. Outside the
/// patch the reference alone, faint.
pub fn overlay(rectified: &Rectified, reference: &Picture) -> String {
    uri(&encode(reference.cols, reference.rows, Colour::Rgb, &blend(rectified, reference)))
}

fn blend(rectified: &Rectified, reference: &Picture) -> Vec<u8> {
    let mask = &rectified.mask.pixels;
    let (red, cyan) = (stretched(&rectified.patch.pixels, mask), stretched(&reference.pixels, mask));
    let faint = |grey: u8| 160 + grey / 4;
    red.iter()
        .zip(&cyan)
        .zip(mask)
        .flat_map(|((&red, &cyan), &valid)| if valid == 0 { [faint(cyan); 3] } else { [red, cyan, cyan] })
        .collect()
}

/// To one mean and contrast over the pixels that `mask` calls valid.
fn stretched(pixels: &[u8], mask: &[u8]) -> Vec<u8> {
    let valid = || pixels.iter().zip(mask).filter(|&(_, &valid)| valid != 0).map(|(&p, _)| f64::from(p));
    let count = valid().count().max(1) as f64;
    let mean = valid().sum::<f64>() / count;
    let sigma = (valid().map(|p| (p - mean) * (p - mean)).sum::<f64>() / count).sqrt().max(1.0);
    pixels.iter().map(|&p| (128.0 + CONTRAST_DN * (f64::from(p) - mean) / sigma).clamp(0.0, 255.0) as u8).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_agrees_is_grey_and_what_does_not_has_colour() {
        let picture = |pixels: &[u8]| Picture { cols: 4, rows: 1, pixels: pixels.to_vec() };
        let rectified =
            Rectified { patch: picture(&[10, 20, 30, 0]), mask: picture(&[255, 255, 255, 0]), reference: None };
        // Twice the contrast and brighter: the same texture.
        let same = blend(&rectified, &picture(&[100, 120, 140, 90]));
        assert!(same.chunks(3).all(|rgb| rgb[0].abs_diff(rgb[1]) <= 1 && rgb[1] == rgb[2]), "{same:?}");
        let turned = blend(&rectified, &picture(&[140, 120, 100, 90]));
        assert!(turned[0] < turned[1] && turned[6] > turned[7], "{turned:?}");
    }
}
