//! The image of gradient directions: how the grey changes at each pixel, whichever side is the brighter.
//!
//! With the gradient (gx, gy) and m² = gx² + gy², a pixel has two values, (gx² − gy²) / (m² + e) and 2 gx gy / (m² + e): the gradient's
//! direction with its angle doubled, so that opposite gradients are equal, and a length below 1, so that no strong edge dominates. e is
//! half of the median of m². The border of two fields stays where it is when a crop ripens, a field is ploughed or the sun comes from the
//! other side, while the greys on both sides change and may even swap. Correlation of doubled angles is known from the registration of
//! remote sensing and medical images since the 1990s (normalised gradient fields, orientation correlation).
//!
//! Gradients are Sobel's, 3 x 3; both values are smoothed by 1 2 1 along both axes after the division, which makes the correlation's main
//! lobe as wide as the true shift may be off the whole pixel. Over eight years of one area (5 m a pixel, 56 pairs, patches of 65 pixels
//! within ±16) the peak is right in 91 % this way, in 87 % where the greys are smoothed before by a Gaussian of one pixel, and in 66 % with
//! the difference of a pixel to the mean of 5 x 5 around it.
//!
//! Borders are padded: the last pixel of a run is repeated, and the first and the last row.

use super::surroundings::Ring;
use crate::image::{Run, View};
use crate::matching::high_pass::piece;
use crate::matching::histogram::Histogram;
pub(super) use crate::matching::kernels::gradients::CHANNELS;
use crate::matching::kernels::gradients::{FOURS, STRIP, directions, energies, gradients, smooth};

/// e as a share of the median of m². Over the eight years a quarter, a half and 1 differ by less than a percent.
const ENERGY_SHARE: f32 = 0.5;
/// Least e: the variance of rounded greys, 1/12, times twelve along each axis (1, 2 and 1 squared, twice), and times two as a margin.
const ENERGY_MIN: f32 = 4.0;
/// Every so many rows are sampled for the median of m².
const COUNTED_ROWS: usize = 6;

/// e of a picture, from a sample of the rows of `runs`.
pub(super) fn typical_energy(view: &View<'_>, runs: impl Iterator<Item = Run> + Clone) -> u32 {
    let mut histogram = Histogram::new();
    let mut line = [[[0; 2]; CHANNELS]; FOURS];
    let mut count = 0;
    for strip in (0..view.size().0 as usize).step_by(STRIP) {
        let mut ring = Ring::new(view, runs.clone(), strip);
        for run in runs.clone() {
            count += 1;
            if count % COUNTED_ROWS != 0 {
                continue;
            }
            let Some(piece) = piece(&run, strip as u16) else { continue };
            // Index 0 is the pixel left of the strip.
            let within = piece.start as usize - strip + 1..piece.end as usize - strip + 1;
            gradients(ring.down_to(run.row as usize + 1), &mut line[..within.end.div_ceil(4).min(FOURS)]);
            for four in within.start / 4..within.end.div_ceil(4) {
                let energies = line.get(four).copied().map_or([0; 4], energies);
                let counted = energies.into_iter().zip(4 * four..).filter(|(_, at)| within.contains(at));
                counted.for_each(|(energy, _)| histogram.add(code(energy)));
            }
        }
    }
    (ENERGY_SHARE * decoded(histogram.median())).max(ENERGY_MIN) as u32
}

/// Filters `runs`, sorted by row, piece by piece of at most [`STRIP`] pixels: values of both channels, ±127 for 1, as two's complement
/// bytes. `energy`: e, of [`typical_energy`].
pub(super) fn filter(
    view: &View<'_>,
    runs: impl Iterator<Item = Run> + Clone,
    energy: u32,
    mut each: impl FnMut(Run, [&[u8]; CHANNELS]),
) {
    let Some(first) = runs.clone().next() else { return };
    for strip in (0..view.size().0 as usize).step_by(STRIP) {
        let mut ring = Ring::new(view, runs.clone(), strip);
        let mut lines = [[[[0; 2]; CHANNELS]; FOURS]; 3];
        let fours = ((view.size().0 as usize - strip).min(STRIP) + 2).div_ceil(4).min(FOURS);
        // Rows count from the padded one above the first.
        let mut next = first.row as usize;
        let mut out = [[[0; 4]; STRIP / 4]; CHANNELS];
        for run in runs.clone() {
            let row = run.row as usize;
            while next <= row + 2 {
                let line = &mut lines[next % 3][..fours];
                gradients(ring.down_to(next), line);
                directions(line, energy);
                next += 1;
            }
            let Some(piece) = piece(&run, strip as u16) else { continue };
            let (from, length) = (piece.start as usize - strip, (piece.end - piece.start) as usize);
            let words = from / 4..(from + length).div_ceil(4);
            for (channel, out) in out.iter_mut().enumerate() {
                let around = [row, row + 1, row + 2].map(|row| lines[row % 3].as_slice());
                smooth(around, channel, words.start, out.get_mut(..words.len()).unwrap_or(&mut []));
            }
            let skipped = from - 4 * words.start;
            each(piece, out.each_ref().map(|out| out.as_flattened().get(skipped..skipped + length).unwrap_or(&[])));
        }
    }
}

/// Histogram bin of m²: m² itself below 8, then eight bins an octave.
fn code(energy: u32) -> u8 {
    match energy.checked_ilog2() {
        Some(octave) if octave >= 3 => (8 * (octave - 2) + ((energy >> (octave - 3)) & 7)) as u8,
        _ => energy as u8,
    }
}

/// m² at a fractional bin.
fn decoded(bins: f32) -> f32 {
    let bin = bins as u32;
    let lower = |bin: u32| if bin < 8 { bin } else { (8 + bin % 8) << (bin / 8 - 1) } as f32;
    lower(bin) + (bins - bin as f32) * (lower(bin + 1) - lower(bin))
}

#[cfg(test)]
mod tests {
    use super::{code, decoded};

    #[test]
    fn bins_hold_what_they_say() {
        for energy in (0..100).chain([1000, 12345, 99_999, 2_080_800]) {
            let bin = code(energy) as f32;
            assert!((decoded(bin)..decoded(bin + 1.0)).contains(&(energy as f32)), "{energy} in {bin}");
        }
    }
}
