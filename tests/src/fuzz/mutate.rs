//! Mutations that find mistakes in readers of bytes: bits, lengths, borders, repetitions, and pieces of other inputs.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::Rng;

/// Longest input, bytes.
const LONGEST: usize = 8192;
/// Bytes that stand at a border of something, or mean something to a reader here: MAVLink's start, COBS's end.
const BORDERS: [u8; 9] = [0x00, 0x01, 0x0a, 0x7f, 0x80, 0xfd, 0xfe, 0xff, b'P'];
/// Numbers at a border, as four bytes.
const NUMBERS: [u32; 10] = [0, 1, 0x7f, 0xff, 0x100, 0x7fff, 0xffff, 0x1_0000, 0x7fff_ffff, u32::MAX];

/// One of `seeds`, mutated one to eight times; one in sixteen is noise.
pub fn mutated(seeds: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let seed = |random: &mut ChaCha8Rng| seeds.get(below(random, seeds.len())).cloned().unwrap_or_default();
    if below(random, 16) == 0 {
        let mut noise = vec![0; below(random, 300)];
        random.fill_bytes(&mut noise);
        return noise;
    }
    let mut input = seed(random);
    for _ in 0..1 + below(random, 8) {
        let other = if below(random, 8) == 0 { seed(random) } else { Vec::new() };
        mutate(&mut input, &other, random);
    }
    input.truncate(LONGEST);
    input
}

fn mutate(input: &mut Vec<u8>, other: &[u8], random: &mut ChaCha8Rng) {
    let at = below(random, input.len());
    let longest = if below(random, 4) == 0 { 300 } else { 8 };
    let length = 1 + below(random, longest);
    let end = (at + length).min(input.len());
    match below(random, 10) {
        0 | 1 => input.iter_mut().skip(at).take(1).for_each(|byte| *byte ^= 1 << below(random, 8)),
        2 => input.iter_mut().skip(at).take(1).for_each(|byte| *byte = random.next_u32() as u8),
        3 => input.iter_mut().skip(at).take(1).for_each(|byte| *byte = BORDERS[below(random, BORDERS.len())]),
        4 => {
            let number = NUMBERS[below(random, NUMBERS.len())].to_le_bytes();
            let bytes = 1 << below(random, 3);
            input.iter_mut().skip(at).zip(number).take(bytes).for_each(|(byte, number)| *byte = number);
        }
        5 => drop(input.drain(at..end)),
        6 => {
            let piece: Vec<u8> = input.get(at..end).unwrap_or(&[]).to_vec();
            let to = below(random, input.len() + 1);
            input.splice(to..to, piece);
        }
        7 => {
            let noise: Vec<u8> = (0..length.min(32)).map(|_| random.next_u32() as u8).collect();
            input.splice(at..at, noise);
        }
        8 => input.truncate(at),
        _ => {
            let from = below(random, other.len());
            let piece = other.get(from..).unwrap_or(&[]);
            input.splice(at..end, piece.iter().take(length).copied());
        }
    }
}

/// A whole number below `count`; 0 where there is none.
fn below(random: &mut ChaCha8Rng, count: usize) -> usize {
    ((u64::from(random.next_u32()) * count as u64) >> 32) as usize
}
