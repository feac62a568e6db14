//! Sums of products of two pictures.

pub(crate) mod portable;
#[cfg(feature = "dsp")]
pub(crate) mod armv7em;

#[cfg(feature = "dsp")]
pub(in crate::matching) use armv7em::{dot_and_energy, dot4_rows, dots_and_energies, moments};
#[cfg(not(feature = "dsp"))]
pub(in crate::matching) use portable::{dot_and_energy, dot4_rows, dots_and_energies, moments};

#[cfg(test)]
mod tests {
    use super::{dot_and_energy, dot4_rows, dots_and_energies, moments};
    use heapless::Vec;

    #[test]
    fn rows_are_multiplied_at_four_shifts() {
        let bytes: Vec<u8, 256> = (0..256u32).map(|i| (i * 91 + i * i * 13) as u8).collect();
        for (strides, rows, every) in
            [((8, 12), 5, 1), ((8, 19), 5, 2), ((4, 7), 7, 3), ((7, 9), 4, 1), ((8, 40), 6, 1)]
        {
            let own = &bytes[..strides.0 * rows];
            let others = &bytes[3..];
            let product = |k: usize| -> i32 {
                let pixels = (0..rows).step_by(every).flat_map(|row| (0..strides.0).map(move |col| (row, col)));
                let other = |at: usize| others.get(at).map_or(0, |&r| r as i8 as i32);
                pixels.map(|(r, c)| own[r * strides.0 + c] as i8 as i32 * other(r * strides.1 + c + k)).sum()
            };
            let expected = [0, 1, 2, 3].map(product);
            assert_eq!(dot4_rows(own, others, strides, every), expected, "{strides:?}, every {every}");
        }
    }

    #[test]
    fn products_are_of_signed_bytes() {
        let bytes = |values: [i8; 8]| values.map(|value| value as u8);
        let (own, others) = (bytes([1, -2, 3, 127, 0, 0, 0, 0]), bytes([4, 5, -6, -127, 7, 8, -9, 10]));
        assert_eq!(dot_and_energy(&own[..3], &others), (4 - 10 - 18, 16 + 25 + 36));
    }

    #[test]
    fn padding_has_no_energy() {
        let others: [u8; 12] = core::array::from_fn(|i| (50 * i + 90) as u8);
        for length in 1..=8 {
            let own: [u8; 8] = core::array::from_fn(|i| if i < length { (i * 77 + 13) as u8 } else { 0 });
            let expected = [0, 3].map(|at| dot_and_energy(&own[..length], &others[at..]));
            assert_eq!(dots_and_energies(&own, &others, [0, 3], length), expected);
        }
        assert_eq!(dots_and_energies(&[1; 8], &[1; 8], [0, 1], 6), [(0, 0); 2], "too short");
    }

    #[test]
    fn moments_are_of_unsigned_bytes() {
        assert_eq!(moments(&[200, 1, 2, 3, 4], &[255, 1, 1, 1, 250]), [210, 508, 40030, 127528, 52006]);
    }
}
