//! The loops on any machine.

/// Copies as many bytes as both have.
#[inline(always)]
pub(crate) fn copy(from: &[u8], to: &mut [u8]) {
    let length = from.len().min(to.len());
    to[..length].copy_from_slice(&from[..length]);
}

/// Fills with one value.
#[inline(always)]
pub(crate) fn fill(value: u8, to: &mut [u8]) {
    to.fill(value);
}
