//! Single instructions.

use super::inputs::Inputs;
use super::{Outcome, same};
use crate::arch::{armv7em, portable};

#[inline]
pub(super) fn opaque(inputs: &mut Inputs) -> Outcome {
    let left = inputs.word() as usize;
    same(&[portable::opaque(left) as u32], &[armv7em::opaque(left) as u32])
}

#[inline]
pub(super) fn sqrt(inputs: &mut Inputs) -> Outcome {
    let value = f32::from_bits(inputs.four());
    // A NaN's sign and payload are nobody's business.
    let bits = |root: f32| if root.is_nan() { u32::MAX } else { root.to_bits() };
    same(&[bits(portable::sqrt(value))], &[bits(armv7em::sqrt(value))])
}

#[inline]
pub(super) fn add_bytes(inputs: &mut Inputs) -> Outcome {
    let (word, sum) = (inputs.four(), inputs.word());
    same(&[portable::add_bytes(word, sum)], &[armv7em::add_bytes(word, sum)])
}

#[inline]
pub(super) fn clamp_bytes(inputs: &mut Inputs) -> Outcome {
    let (word, limit) = (inputs.four(), 1 + inputs.below(127) as u8);
    same(&[portable::clamp_bytes(word, limit)], &[armv7em::clamp_bytes(word, limit)])
}

#[inline]
pub(super) fn difference(inputs: &mut Inputs) -> Outcome {
    let (a, b) = (inputs.four(), inputs.word());
    same(&[portable::difference(a, b)], &[armv7em::difference(a, b)])
}

#[inline]
pub(super) fn dot(inputs: &mut Inputs) -> Outcome {
    let (a, b, sum) = (inputs.four(), inputs.four(), inputs.word() as i32);
    same(&[portable::dot(a, b, sum)], &[armv7em::dot(a, b, sum)])
}
