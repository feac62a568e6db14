//! The high-pass filter: each pixel less the mean of the 5 x 5 around it.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(in crate::matching) use armv7em::high_pass;
#[cfg(not(feature = "dsp"))]
pub(in crate::matching) use portable::high_pass;

/// Columns and rows of the surroundings of a pixel.
pub(crate) const SIDE: usize = 5;
/// Pixels of a row that [`high_pass`] makes at most: a strip's five rows and its output fit half a kilobyte of stack.
pub(crate) const STRIP: usize = 64;
/// Bytes of a row that it reads for them.
pub(crate) const WIDTH: usize = STRIP + 8;

#[cfg(test)]
mod tests {
    use super::{SIDE, WIDTH, high_pass};

    #[test]
    fn what_the_mean_around_leaves() {
        let rows: [[u8; WIDTH]; SIDE] = core::array::from_fn(|row| {
            core::array::from_fn(|col| ((row * 97 + col * 57) as u8).wrapping_mul(col as u8 | 1))
        });
        for first in [0, 3] {
            let mut out = [[0; 4]; 5];
            high_pass(&rows, 3, first, &mut out);
            for (i, &filtered) in out.as_flattened().iter().enumerate() {
                let at = 4 * first + i;
                let mean = rows.iter().flat_map(|row| &row[at..at + 5]).map(|&p| p as f32).sum::<f32>() / 25.0;
                let exact = 6.25 * (rows[3][at + 2] as f32 - mean);
                assert!((filtered as i8 as f32 - exact.clamp(-128.0, 127.0)).abs() <= 0.501, "{exact} at {at}");
            }
        }
    }
}
