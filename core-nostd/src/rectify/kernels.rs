//! The inner loops of the rectifier: border integrals and means of the area average, readings of the bilinear one.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(super) use armv7em::{blend_along, blend_steeply, border_integrals, cell_means};
#[cfg(not(feature = "dsp"))]
pub(super) use portable::{blend_along, blend_steeply, border_integrals, cell_means};

/// Subtracted from both halves of a word of blended rows, so that they have a sign: 127.5 grey levels in 1/256. The half
/// level rounds to nearest.
const MIDDLE: u32 = 0x7f80_7f80;

/// Bilinear reading of four pixels, `[top left, top right, bottom left, bottom right]` from the lowest byte up, rounded
/// to the nearest grey level. `right` in 1/256, `down` in 1/65536, both up to 1.
#[inline(always)]
pub(super) fn blend(four: u32, right: u32, down: u32) -> u8 {
    // Both rows at once, in the halves of a word; a negative top takes 1/256 grey from the bottom.
    let (lefts, rights) = (four & 0x00ff_00ff, (four >> 8) & 0x00ff_00ff);
    let rows = rights.wrapping_sub(lefts).wrapping_mul(right).wrapping_add((lefts << 8).wrapping_sub(MIDDLE));
    let difference = (rows as i16 as i32 - (rows >> 16) as i16 as i32) as u32;
    ((rows << 16).wrapping_sub(difference.wrapping_mul(down)) >> 24) as u8 ^ 0x80
}
