//! The loops of least-squares matching.

use super::inputs::{Aligned, Inputs};
use super::{Outcome, same};
use crate::matching::kernels::least_squares::{Pair, Weighing, armv7em, portable};
use crate::packed::pack;

/// Pairs of any numbers, with weights as they occur, 0 to 64.
#[inline]
fn pairs<const N: usize>(inputs: &mut Inputs) -> [Pair; N] {
    core::array::from_fn(|_| {
        let [x, y, p, we, e] = [(); 5].map(|()| inputs.four());
        Pair { x, y, p, w: pack(inputs.below(65) as i32, inputs.below(65) as i32), we, e }
    })
}

#[inline]
pub(super) fn sums(inputs: &mut Inputs) -> Outcome {
    let pairs = pairs::<32>(inputs);
    let pairs = &pairs[..inputs.length()];
    same(&portable::weighed_products(pairs), &armv7em::weighed_products(pairs))?;
    same(&portable::weighed_sums(pairs), &armv7em::weighed_sums(pairs))
}

#[inline]
pub(super) fn weigh_rows(inputs: &mut Inputs) -> Outcome {
    let pixels: Aligned<256> = inputs.bytes();
    let at = inputs.below(4);
    let count = inputs.length();
    // From rows that overlap to such that are just there, and beyond.
    let stride = inputs.below(86 - 4 * count / 3);
    // At most 256 in all.
    let weights = [(); 4].map(|()| inputs.below(65) as u32);
    let (mut expected, mut found) = ([[0x5555_5555u32; 2]; 32], [[0x5555_5555u32; 2]; 32]);
    let made = portable::weigh_rows(&pixels.0[at..], stride, weights, &mut expected[..count]);
    let found_made = armv7em::weigh_rows(&pixels.0[at..], stride, weights, &mut found[..count]);
    same(expected.as_flattened(), found.as_flattened())?;
    same(&[u32::from(made.is_some())], &[u32::from(found_made.is_some())])
}

#[inline]
pub(super) fn weigh_residuals(inputs: &mut Inputs) -> Outcome {
    let fours = [pairs::<2>(inputs); 8].map(|_| pairs::<2>(inputs));
    let columns: [[u32; 2]; 9] = core::array::from_fn(|_| [inputs.four(), inputs.four()]);
    let weights: Aligned<256> = inputs.bytes();
    // The greys' weights are at most 256 in all; gain, rest and bins are of the size that gives residuals of some grey levels.
    let across = [(); 2].map(|()| pack(inputs.below(65) as i32, inputs.below(65) as i32));
    let (gain, rest) = (inputs.around_zero(1 << 17), inputs.around_zero(1 << 24));
    let weighing = Weighing { across, gain, rest, bins: inputs.below(1 << 16) as i32, weights: &weights.0 };
    let count = inputs.length() % 9;
    let (mut expected, mut found) = (fours, fours);
    portable::weigh_residuals(&mut expected[..count], &columns, &weighing);
    armv7em::weigh_residuals(&mut found[..count], &columns, &weighing);
    let words = |fours: &[[Pair; 2]; 8]| -> [[u32; 6]; 16] {
        core::array::from_fn(|i| {
            let Pair { x, y, p, w, we, e } = fours[i / 2][i % 2];
            [x, y, p, w, we, e]
        })
    };
    same(words(&expected).as_flattened(), words(&found).as_flattened())
}
