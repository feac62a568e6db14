//! Pictures reduced by boxes of pixels, and their high-pass images.

use super::sizes::Sizes;
use crate::image::{Run, View};
use crate::matching::high_pass::{ClippingThreshold, clip, filter};

/// Stride of the rows that set the clipping threshold of a reference: a third of a few thousand values is enough for a
/// median.
const CLIPPING_STRIDE: usize = 3;

/// The clipped high-pass image of the boxes of a tile from `corner` on, rows with the stride of [`Sizes::strides`].
/// `grey`: space for the boxes. `None` if they leave the tile, or the space does not suffice.
pub(super) fn reference_into(
    tile: &View<'_>,
    corner: (i32, i32),
    sizes: &Sizes,
    grey: &mut [u8],
    out: &mut [u8],
) -> Option<()> {
    let (cols, rows) = sizes.other;
    let corner = (usize::try_from(corner.0).ok()?, usize::try_from(corner.1).ok()?);
    let grey = grey.get_mut(..cols * rows)?;
    reduce(tile, corner, sizes.factor, (cols, rows), grey)?;
    filter_into(grey, (cols, rows), sizes.strides().1, out)?;
    let mut threshold = ClippingThreshold::new();
    for line in out.chunks_exact(sizes.strides().1.max(1)).take(rows).step_by(CLIPPING_STRIDE) {
        threshold.add(line.get(..cols).unwrap_or(&[]));
    }
    clip(threshold.value(), out);
    Some(())
}

/// The clipped high-pass image of the patch's boxes, rows padded with zeros, and zeros for boxes that are not wholly
/// valid; returns the number of valid ones. `None` without texture, or with too little space.
pub(super) fn patch_into(
    patch: &View<'_>,
    runs: &[Run],
    sizes: &Sizes,
    out: &mut [u8],
    buffer: &mut [u8],
) -> Option<usize> {
    let (width, height) = (patch.size().0 as usize, patch.size().1 as usize);
    let Sizes { factor, own: (cols, rows), .. } = *sizes;
    let (filled, buffer) = buffer.split_at_mut_checked(width * height)?;
    let (grey, counts) = buffer.get_mut(..2 * cols * rows)?.split_at_mut_checked(cols * rows)?;
    fill(patch, runs, filled)?;
    count(runs, factor, cols, counts);
    reduce(&View::new(filled, patch.size())?, (0, 0), factor, (cols, rows), grey)?;
    let stride = sizes.strides().0;
    filter_into(grey, (cols, rows), stride, out)?;
    let mut threshold = ClippingThreshold::new();
    let mut valid = 0;
    let whole = (factor * factor) as u8;
    // Rows are addressed by index: two zipped iterators of chunks would divide by a length that might be 0.
    for (row, counts) in counts.chunks_exact(cols.max(1)).enumerate() {
        let line = out.get_mut(row * stride..row * stride + cols).unwrap_or(&mut []);
        for (value, &count) in line.iter_mut().zip(counts) {
            if count == whole {
                threshold.add(core::slice::from_ref(value));
                valid += 1;
            } else {
                *value = 0;
            }
        }
    }
    clip(threshold.value(), out);
    out.iter().any(|&value| value != 0).then_some(valid)
}

/// The patch with its gaps filled: invalid pixels repeat the outermost valid one of their row, rows without a run the
/// nearest row.
fn fill(patch: &View<'_>, runs: &[Run], filled: &mut [u8]) -> Option<()> {
    let (width, height) = (patch.size().0 as usize, patch.size().1 as usize);
    let first = runs.first()?.row as usize;
    let mut done = 0;
    for run in runs {
        let (row, start, end) = (run.row as usize, run.start as usize, run.end as usize);
        let pixels = patch.run(row, start, end - start)?;
        let (Some(&left), Some(&right)) = (pixels.first(), pixels.last()) else { continue };
        // Rows without a run repeat the row before.
        while done < row && done > first {
            copy_line(filled, width, done - 1, done);
            done += 1;
        }
        let line = filled.get_mut(row * width..(row + 1) * width)?;
        let (before, line) = line.split_at_mut_checked(start)?;
        if done <= row {
            before.fill(left);
        }
        done = row + 1;
        let (line, behind) = line.split_at_mut_checked(pixels.len())?;
        line.iter_mut().zip(pixels).for_each(|(to, &from)| *to = from);
        behind.fill(right);
    }
    for row in (0..first.min(height)).rev() {
        copy_line(filled, width, row + 1, row);
    }
    for row in done.max(1)..height {
        copy_line(filled, width, row - 1, row);
    }
    Some(())
}

/// Counts the valid pixels of each box, `cols` boxes a row.
fn count(runs: &[Run], factor: usize, cols: usize, counts: &mut [u8]) {
    counts.fill(0);
    for run in runs {
        let (start, end) = (run.start as usize, run.end as usize);
        let Some(counts) = counts.chunks_exact_mut(cols.max(1)).nth(run.row as usize / factor.max(1)) else { continue };
        for (col, count) in counts.iter_mut().enumerate() {
            let (from, to) = ((col * factor).max(start), (col * factor + factor).min(end));
            *count = count.saturating_add(to.saturating_sub(from) as u8);
        }
    }
}

/// Copies a line of a picture onto a neighbour of it.
fn copy_line(picture: &mut [u8], width: usize, from: usize, to: usize) {
    let upper = from.min(to) * width;
    let both = picture.get_mut(upper..upper + 2 * width).and_then(|both| both.split_at_mut_checked(width));
    let Some((upper, lower)) = both else { return };
    let (from, to) = if from < to { (upper, lower) } else { (lower, upper) };
    to.iter_mut().zip(from).for_each(|(to, from)| *to = *from);
}

/// Means of `cols` x `rows` boxes of a picture from `corner` on, rounded to nearest. `None` if they leave it.
fn reduce(
    picture: &View<'_>,
    corner: (usize, usize),
    factor: usize,
    (cols, rows): (usize, usize),
    out: &mut [u8],
) -> Option<()> {
    for (row, line) in (0..rows).zip(out.chunks_exact_mut(cols.max(1))) {
        let at = |n: usize| picture.run(corner.1 + row * factor + n, corner.0, cols * factor);
        match factor {
            1 => line.iter_mut().zip(at(0)?).for_each(|(to, &from)| *to = from),
            2 => {
                let (above, below) = (at(0)?.as_chunks::<2>().0, at(1)?.as_chunks::<2>().0);
                for ((grey, a), b) in line.iter_mut().zip(above).zip(below) {
                    let sum = a[0] as u32 + a[1] as u32 + b[0] as u32 + b[1] as u32;
                    *grey = ((sum + 2) >> 2) as u8;
                }
            }
            3 => {
                let [a, b, c] = [at(0)?.as_chunks::<3>().0, at(1)?.as_chunks::<3>().0, at(2)?.as_chunks::<3>().0];
                for (((grey, a), b), c) in line.iter_mut().zip(a).zip(b).zip(c) {
                    let sum: u32 = a.iter().chain(b).chain(c).map(|&grey| grey as u32).sum();
                    // A ninth, exact for every sum of nine bytes.
                    *grey = (((sum + 4) * 7282) >> 16) as u8;
                }
            }
            _ => {
                for (col, grey) in line.iter_mut().enumerate() {
                    let mut sum = 0;
                    for n in 0..factor {
                        sum += at(n)?.iter().skip(col * factor).take(factor).map(|&grey| grey as u32).sum::<u32>();
                    }
                    let area = (factor * factor).max(1) as u32;
                    *grey = ((sum + area / 2) / area) as u8;
                }
            }
        }
    }
    Some(())
}

/// The high-pass image of a picture without invalid pixels, not clipped yet, rows `stride` apart, padded with zeros.
/// `None` if it does not fit.
fn filter_into(grey: &[u8], (cols, rows): (usize, usize), stride: usize, out: &mut [u8]) -> Option<()> {
    let (cols, rows) = (u16::try_from(cols).ok()?, u16::try_from(rows).ok()?);
    let picture = View::new(grey, (cols, rows))?;
    out.get(..stride * rows as usize)?;
    out.fill(0);
    let lines = (0..rows).map(|row| Run { row, start: 0, end: cols });
    filter(&picture, lines, |piece, values| {
        let at = piece.row as usize * stride + piece.start as usize;
        if let Some(target) = out.get_mut(at..at + values.len()) {
            target.copy_from_slice(values);
        }
    });
    Some(())
}
