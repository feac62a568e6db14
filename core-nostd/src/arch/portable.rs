//! What the instructions compute, on any machine.

use crate::packed::{high, low, pack};

/// `left` itself. The Armv7E-M version hides from the compiler that it is, so that a loop which counts it down is not
/// unrolled.
#[inline(always)]
pub(crate) fn opaque(left: usize) -> usize {
    left
}

/// Square root, correctly rounded.
#[inline(always)]
pub(crate) fn sqrt(value: f32) -> f32 {
    libm::sqrtf(value)
}

/// `sum` plus the four bytes of `word`, modulo 2^32.
#[inline(always)]
pub(crate) fn add_bytes(word: u32, sum: u32) -> u32 {
    word.to_le_bytes().iter().fold(sum, |sum, &byte| sum.wrapping_add(byte as u32))
}

/// Limits each of four signed bytes to ±`limit`, 1 to 127.
#[inline(always)]
pub(crate) fn clamp_bytes(word: u32, limit: u8) -> u32 {
    let limit = limit as i8;
    u32::from_le_bytes(word.to_le_bytes().map(|byte| (byte as i8).clamp(-limit, limit) as u8))
}

/// The differences of both halves, modulo 2^16.
#[inline(always)]
pub(crate) fn difference(a: u32, b: u32) -> u32 {
    pack(low(a) - low(b), high(a) - high(b))
}

/// `sum` plus the products of both halves, modulo 2^32.
#[inline(always)]
pub(crate) fn dot(a: u32, b: u32, sum: i32) -> i32 {
    sum.wrapping_add(low(a) * low(b)).wrapping_add(high(a) * high(b))
}
