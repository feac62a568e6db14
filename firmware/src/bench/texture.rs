//! Pictures from seeds, by integers and single precision alone: the same bytes on every machine.

/// Fills a picture of `cols` columns with a gradient, checks of 32 grey levels and 16 pixels, and 5 bits of white noise:
/// no two pixels alike, so nothing can be skipped, and what a resampler does wrong shows.
pub fn checks(pixels: &mut [u8], cols: usize, seed: u32) {
    for (row, line) in pixels.chunks_mut(cols).enumerate() {
        for (col, pixel) in line.iter_mut().enumerate() {
            let gradient = (col + row) / 8 % 160;
            let check = (((col / 16) ^ (row / 16)) & 1) * 32;
            let noise = hash(col as u32, row as u32, seed) >> 27;
            *pixel = (gradient + check) as u8 + noise as u8;
        }
    }
}

/// Periods of the noise, pixels, and the grey levels each of them spans.
const OCTAVES: [(u32, f32); 5] = [(32, 60.0), (16, 50.0), (8, 40.0), (4, 35.0), (2, 30.0)];

/// Fills a picture of `cols` columns with ground: smooth noise of five octaves, as much contrast in the small as in the
/// large.
pub fn ground(pixels: &mut [u8], cols: usize, seed: u32) {
    for (row, line) in pixels.chunks_mut(cols).enumerate() {
        for (col, pixel) in line.iter_mut().enumerate() {
            let octave = |(n, (period, span)): (usize, &(u32, f32))| {
                span * smooth((col as u32, row as u32), *period, seed.wrapping_add(n as u32))
            };
            *pixel = (20.0 + OCTAVES.iter().enumerate().map(octave).sum::<f32>()) as u8;
        }
    }
}

/// Noise between 0 and 1 that is smooth over a `period`: values at the corners of a lattice, blended.
fn smooth((col, row): (u32, u32), period: u32, seed: u32) -> f32 {
    let ease = |at: u32| {
        let t = (at % period) as f32 / period as f32;
        t * t * (3.0 - 2.0 * t)
    };
    let corner = |east: u32, south: u32| (hash(col / period + east, row / period + south, seed) >> 16) as f32 / 65535.0;
    let blend = |from: f32, to: f32, t: f32| from + t * (to - from);
    let (across, along) = (ease(col), ease(row));
    blend(blend(corner(0, 0), corner(1, 0), across), blend(corner(0, 1), corner(1, 1), across), along)
}

/// 32 bits that look as if they had nothing to do with their arguments.
pub fn hash(col: u32, row: u32, seed: u32) -> u32 {
    let mut bits = col.wrapping_mul(0x9e37_79b1) ^ row.wrapping_mul(0x85eb_ca77) ^ seed.wrapping_mul(0xc2b2_ae3d);
    bits = (bits ^ (bits >> 15)).wrapping_mul(0x2c1b_3c6d);
    bits = (bits ^ (bits >> 12)).wrapping_mul(0x297a_2d39);
    bits ^ (bits >> 15)
}

#[cfg(test)]
mod tests {
    use super::{checks, ground};

    #[test]
    fn pictures_use_their_range_and_repeat() {
        for fill in [checks, ground] {
            let (mut first, mut second) = ([0u8; 64 * 64], [0u8; 64 * 64]);
            fill(&mut first, 64, 1);
            fill(&mut second, 64, 1);
            assert_eq!(first, second);
            fill(&mut second, 64, 2);
            assert_ne!(first, second);
            let (min, max) = (first.iter().min().copied(), first.iter().max().copied());
            assert!(max.zip(min).is_some_and(|(max, min)| max - min > 60), "{min:?} {max:?}");
        }
    }
}
