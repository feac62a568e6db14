//! Shares of the patch's parts in the scores of a few shifts.

use super::evidence::PARTS;
use super::images::{ALL, Images};
use crate::image::Run;
use crate::matching::kernels::correlation::dots_and_energies;
use crate::math::sqrt;

/// Parts along each axis.
const ACROSS: usize = 3;
const _: () = assert!(ACROSS * ACROSS == PARTS);
/// Columns are cut at word boundaries.
const WORD: usize = 4;

/// The score of each of the `shifts` as nine addends, one of each part of the patch, three by three. An even number of shifts.
#[inline(never)]
pub(super) fn parts<const N: usize>(images: &Images<'_>, shifts: &[(u16, u16); N]) -> [[f32; PARTS]; N] {
    let (reference, (cols, rows)) = (&images.reference, images.patch.size());
    let stride = reference.stride();
    let offsets = shifts.map(|(col, row)| row as usize * stride + col as usize);
    let mut products = [[0i32; PARTS]; N];
    let mut energies = [0i64; N];
    let bounds = [cols as usize / ACROSS, 2 * cols as usize / ACROSS, cols as usize];
    images.patch.each(ALL, |channel, piece, own| {
        let Run { row, start, end } = piece;
        let band = ACROSS * (row as usize * ACROSS / rows.max(1) as usize).min(ACROSS - 1);
        let base = (row as usize + images.first_row(channel)) * stride + start as usize;
        let length = (end - start) as usize;
        let mut from = 0;
        for (part, bound) in (band..).zip(bounds) {
            let cut = bound.saturating_sub(start as usize).next_multiple_of(WORD);
            let to = if part == band + ACROSS - 1 { length } else { cut.min(length) };
            let Some(own) = own.get(from..to.next_multiple_of(WORD)).filter(|_| to > from) else { continue };
            for ((offsets, products), energies) in { offsets.as_chunks::<2>().0.iter() }
                .zip(products.as_chunks_mut::<2>().0)
                .zip(energies.as_chunks_mut::<2>().0)
            {
                let at = offsets.map(|offset| base + from + offset);
                let sums = dots_and_energies(own, reference.from(0, 0), at, to - from);
                for (((product, energy), products), energies) in sums.into_iter().zip(products).zip(energies) {
                    if let Some(sum) = products.get_mut(part) {
                        *sum += product;
                    }
                    *energies += energy as i64;
                }
            }
            from = to;
        }
    });
    let mut shares = [[0.0; PARTS]; N];
    for ((shares, products), energy) in shares.iter_mut().zip(products).zip(energies) {
        let per = 1.0 / (sqrt(images.energy.max(1) as f32) * sqrt(energy.max(1) as f32));
        *shares = products.map(|product| product as f32 * per);
    }
    shares
}
