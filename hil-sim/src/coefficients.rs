//! Which numbers a stated risk was made of: a digest that changes with any of them, so that whoever judges can see that they were frozen.

use plumbline_core::matching::directions::risk;
use plumbline_core::navigation::surface::{self, agreement};
use plumbline_core::pipeline;

/// The digest of the numbers behind the risk of a match by itself.
#[must_use]
pub fn of_match() -> String {
    digest(&risk::COEFFICIENTS)
}

/// Of those behind the risk of a fix in flight.
#[must_use]
pub fn of_flight() -> String {
    digest(
        &[
            &risk::COEFFICIENTS[..],
            &surface::COEFFICIENTS[..],
            &agreement::COEFFICIENTS[..],
            &pipeline::COEFFICIENTS[..],
        ]
        .concat(),
    )
}

/// FNV-1a of 64 bits over the numbers' IEEE 754 bits, lowest byte first, as 16 hexadecimal digits.
fn digest(numbers: &[f32]) -> String {
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let bytes = numbers.iter().flat_map(|number| number.to_bits().to_le_bytes());
    format!("{:016x}", bytes.fold(BASIS, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME)))
}

#[cfg(test)]
mod tests {
    use super::{digest, of_flight, of_match, risk};

    /// The vector of FNV's authors: "foobar" is 85944171f73967e8. Its first four bytes are a number, the others are taken off.
    #[test]
    fn the_digest_is_fnv_1a() {
        assert_eq!(digest(&[]), "cbf29ce484222325");
        let foob = f32::from_bits(u32::from_le_bytes(*b"foob"));
        let hash = u64::from_str_radix(&digest(&[foob]), 16).expect("hexadecimal");
        let rest = b"ar".iter().fold(hash, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3));
        assert_eq!(rest, 0x8594_4171_f739_67e8);
    }

    #[test]
    fn the_last_bit_of_any_number_changes_it() {
        let (own, numbers) = (of_match(), risk::COEFFICIENTS);
        for at in 0..numbers.len() {
            let mut other = numbers;
            other[at] = f32::from_bits(other[at].to_bits() ^ 1);
            assert_ne!(digest(&other), own, "number {at}");
        }
        assert_ne!(of_flight(), own);
    }

    /// Whoever changes what a risk is made of changes this line, too, and judges anew.
    #[test]
    fn the_numbers_of_a_match_are_frozen() {
        assert_eq!(of_match(), "23439f6d5e2e844d");
    }
}
