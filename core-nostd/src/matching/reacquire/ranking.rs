//! Scores of shifts between reduced pictures, and the candidates among them.

use super::boxes;
use super::sizes::{BOX_MAX, Sizes, Span, smallest_factor};
use crate::image::{Run, View};
use crate::matching::MatchError;
use crate::matching::kernels::correlation::dot4_rows;
use crate::matching::local_maximum::{LocalMaximum, highest};

/// Number of local maxima that are searched in full resolution.
pub(super) const CANDIDATES: usize = 6;
/// Boxes of the patch that rank the shifts, about: with more, every second row or fewer. Between half and one and a
/// half times as many, true ground under noise as strong as its high-pass image was among the candidates every time in
/// 400.
pub(super) const RANKING: usize = 120;

/// The shift at a local maximum of the coarse scores.
pub(super) type Candidate = (i16, i16);

/// The highest local maxima of the reduced pictures' correlation. Not inlined, so that its stack is free for the fine
/// search.
#[inline(never)]
pub(super) fn coarse<'s>(
    patch: &View<'_>,
    runs: &[Run],
    tile: &View<'_>,
    at: (i32, i32),
    span: &Span,
    bytes: &mut [u8],
    buffer: &'s mut [Candidate; CANDIDATES],
) -> Result<&'s [Candidate], MatchError> {
    let sizes = (smallest_factor(patch.size())..=BOX_MAX).map(|factor| Sizes::new(factor, patch.size(), span));
    let sizes = { sizes }.find(|sizes| sizes.working_bytes(patch.size()) <= bytes.len()).ok_or(MatchError::Capacity)?;
    let (own, rest) = bytes.split_at_mut_checked(sizes.bytes()[0]).ok_or(MatchError::Capacity)?;
    let valid = boxes::patch_into(patch, runs, &sizes, own, rest).ok_or(MatchError::Featureless)?;
    let corner = (at.0 + span.cols.0 as i32, at.1 + span.rows.0 as i32);
    let stride = ((valid + RANKING / 2) / RANKING).max(1);
    let (_, scores) = ranked(own, tile, corner, &sizes, stride, rest)?;
    let mut maxima = [LocalMaximum::default(); CANDIDATES];
    let maxima = highest(scores, sizes.shifts, |&score| f32::from_le_bytes(score), &mut maxima);
    let shift = |first: i16, boxes: u16| first + sizes.factor as i16 * boxes as i16;
    for (candidate, maximum) in buffer.iter_mut().zip(maxima) {
        *candidate = (shift(span.cols.0, maximum.col), shift(span.rows.0, maximum.row));
    }
    Ok(buffer.get(..maxima.len()).unwrap_or(&[]))
}

/// Scores of all shifts of the patch's boxes from `corner` of the tile on, over every `stride`th row of boxes, and the
/// reference's high-pass image that they were computed from.
pub(super) fn ranked<'b>(
    own: &[u8],
    tile: &View<'_>,
    corner: (i32, i32),
    sizes: &Sizes,
    stride: usize,
    buffer: &'b mut [u8],
) -> Result<(&'b [u8], &'b [[u8; 4]]), MatchError> {
    let [_, other, rest] = sizes.bytes();
    let (other, buffer) = buffer.split_at_mut_checked(other).ok_or(MatchError::Capacity)?;
    let buffer = buffer.get_mut(..rest).ok_or(MatchError::Capacity)?;
    boxes::reference_into(tile, corner, sizes, buffer, other).ok_or(MatchError::OutsideReference)?;
    let words = buffer.as_chunks_mut::<4>().0;
    let (energies, scores) = words.split_at_mut_checked(sizes.other.0).ok_or(MatchError::Capacity)?;
    let scores = scores.get_mut(..sizes.shifts.0 * sizes.shifts.1).ok_or(MatchError::Capacity)?;
    correlate(own, other, sizes, stride, scores);
    normalise(other, sizes, energies, scores);
    Ok((other, scores))
}

/// Products of both high-pass images at every shift, over every `stride`th row of the patch.
fn correlate(own: &[u8], other: &[u8], sizes: &Sizes, stride: usize, scores: &mut [[u8; 4]]) {
    let strides = sizes.strides();
    for (line, scores) in scores.chunks_exact_mut(sizes.shifts.0.max(1)).enumerate() {
        for (at, scores) in (0..).step_by(4).zip(scores.chunks_mut(4)) {
            let others = other.get(line * strides.1 + at..).unwrap_or(&[]);
            let sums = dot4_rows(own, others, strides, stride);
            for (score, sum) in scores.iter_mut().zip(sums) {
                *score = sum.to_le_bytes();
            }
        }
    }
}

/// Turns products into scores: their squares, with their signs, over the reference's energy under the patch's
/// rectangle.
fn normalise(other: &[u8], sizes: &Sizes, energies: &mut [[u8; 4]], scores: &mut [[u8; 4]]) {
    let stride = sizes.strides().1;
    let (cols, rows) = sizes.own;
    let line = |row: usize| other.get(row * stride..row * stride + sizes.other.0).unwrap_or(&[]);
    energies.fill([0; 4]);
    for row in 0..rows {
        add_squares(energies, line(row), 1);
    }
    for (row, scores) in scores.chunks_exact_mut(sizes.shifts.0.max(1)).enumerate() {
        let mut energy: i32 = energies.iter().take(cols).map(|&energy| i32::from_le_bytes(energy)).sum();
        let entering = energies.iter().skip(cols).map(|&energy| i32::from_le_bytes(energy)).chain([0]);
        for ((score, leaving), entering) in scores.iter_mut().zip(energies.iter()).zip(entering) {
            let product = i32::from_le_bytes(*score) as f32;
            let ranked = if energy > 0 { product * product.abs() / energy as f32 } else { 0.0 };
            *score = ranked.to_le_bytes();
            energy += entering - i32::from_le_bytes(*leaving);
        }
        if row + 1 < sizes.shifts.1 {
            add_squares(energies, line(row), -1);
            add_squares(energies, line(row + rows), 1);
        }
    }
}

fn add_squares(energies: &mut [[u8; 4]], values: &[u8], sign: i32) {
    for (energy, &value) in energies.iter_mut().zip(values) {
        let value = value as i8 as i32;
        *energy = (i32::from_le_bytes(*energy) + sign * value * value).to_le_bytes();
    }
}
