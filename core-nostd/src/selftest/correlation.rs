//! The matcher's filter and sums of products.

use super::inputs::{Aligned, Inputs};
use super::{Outcome, same};
use crate::matching::kernels::correlation::{armv7em, portable};
use crate::matching::kernels::high_pass::{self, SIDE, STRIP, WIDTH};
use crate::matching::kernels::rows;
use crate::matching::kernels::signs::{self, Digits};

/// Two pictures' bytes, and where in them this seed's length begins.
#[inline]
fn pictures(inputs: &mut Inputs) -> ([Aligned<64>; 2], [core::ops::Range<usize>; 2]) {
    let at = [inputs.below(4), inputs.below(4)];
    ([inputs.bytes(), inputs.bytes()], at.map(|at| at..at + inputs.length()))
}

#[inline]
pub(super) fn rows(inputs: &mut Inputs) -> Outcome {
    let ([from, to], [source, target]) = pictures(inputs);
    let (mut expected, mut found) = (to.0, to.0);
    rows::portable::copy(&from.0[source.clone()], &mut expected[target.clone()]);
    rows::armv7em::copy(&from.0[source], &mut found[target.clone()]);
    same(&expected, &found)?;
    let value = inputs.byte();
    rows::portable::fill(value, &mut expected[target.clone()]);
    rows::armv7em::fill(value, &mut found[target]);
    same(&expected, &found)
}

#[inline]
pub(super) fn high_pass(inputs: &mut Inputs) -> Outcome {
    let bytes: Aligned<{ SIDE * WIDTH }> = inputs.bytes();
    let mut rows = [[0; WIDTH]; SIDE];
    rows.as_flattened_mut().copy_from_slice(&bytes.0);
    let (own, first) = (inputs.below(SIDE), inputs.below(STRIP / 4 + 2));
    let (mut expected, mut found) = ([[0x55; 4]; 32], [[0x55; 4]; 32]);
    let count = inputs.length();
    high_pass::portable::high_pass(&rows, own, first, &mut expected[..count]);
    high_pass::armv7em::high_pass(&rows, own, first, &mut found[..count]);
    same(expected.as_flattened(), found.as_flattened())
}

#[inline]
pub(super) fn slide(inputs: &mut Inputs) -> Outcome {
    let others: Aligned<256> = inputs.bytes();
    let mut digits = Digits::new();
    // None to seven pieces of up to 17 words, as many as a strip has.
    for _ in 0..inputs.length() % 8 {
        for word in digits.add(4 * inputs.below(32), inputs.below(18)) {
            *word = inputs.word();
        }
    }
    // Three quarters begin at words; the others, and those that are too short, are the portable version itself.
    let at = if inputs.below(4) == 0 { inputs.below(4) } else { 0 };
    let sums = [(); 3].map(|()| (inputs.word() as i64) << 32 | inputs.word() as i64);
    let (mut expected, mut found) = (sums, sums);
    signs::portable::slide(&digits, &others.0[at..], &mut expected);
    signs::armv7em::slide(&digits, &others.0[at..], &mut found);
    same(&expected, &found)
}

#[inline]
pub(super) fn dot_and_energy(inputs: &mut Inputs) -> Outcome {
    let ([own, others], [a, b]) = pictures(inputs);
    let expected = portable::dot_and_energy(&own.0[a.clone()], &others.0[b.clone()]);
    let found = armv7em::dot_and_energy(&own.0[a], &others.0[b]);
    same(&[expected.0, expected.1], &[found.0, found.1])
}

#[inline]
pub(super) fn dots_and_energies(inputs: &mut Inputs) -> Outcome {
    let ([mut own, others], [a, _]) = pictures(inputs);
    own.0[a.end..].fill(0);
    // Some places leave too little behind them.
    let at = [inputs.below(36), inputs.below(36)];
    let expected = portable::dots_and_energies(&own.0[a.start..], &others.0, at, a.len());
    let found = armv7em::dots_and_energies(&own.0[a.start..], &others.0, at, a.len());
    same(expected.map(|(dot, energy)| [dot, energy]).as_flattened(), found.map(|(d, e)| [d, e]).as_flattened())
}

#[inline]
pub(super) fn moments(inputs: &mut Inputs) -> Outcome {
    let ([own, others], [a, b]) = pictures(inputs);
    let expected = portable::moments(&own.0[a.clone()], &others.0[b.clone()]);
    same(&expected, &armv7em::moments(&own.0[a], &others.0[b]))
}

#[inline]
pub(super) fn dot4_rows(inputs: &mut Inputs) -> Outcome {
    let (own, others): (Aligned<256>, Aligned<512>) = (inputs.bytes(), inputs.bytes());
    // Rows of others may overlap; some strides are no multiples of four, for which there is no assembly.
    let length = inputs.length();
    let strides = (if inputs.below(4) == 0 { length + 1 } else { 4 * (length / 4 + 1) }, inputs.below(48));
    let (rows, every) = (inputs.below(9), 1 + inputs.below(3));
    let own = own.0.get(..rows * strides.0).unwrap_or(&own.0);
    let others = &others.0[inputs.below(4)..];
    same(&portable::dot4_rows(own, others, strides, every), &armv7em::dot4_rows(own, others, strides, every))
}
