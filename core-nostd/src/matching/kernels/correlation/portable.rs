//! The sums on any machine.

/// Σ p r and Σ r² of `length` signed bytes at two places at once: p of `own`, r of `others` from each of `at`
/// on. `own` has zeros behind them up to a multiple of four. 0 where any of them is too short; at most 2^16 bytes.
#[inline(always)]
pub(crate) fn dots_and_energies(own: &[u8], others: &[u8], at: [usize; 2], length: usize) -> [(i32, i32); 2] {
    let padded = length.next_multiple_of(4);
    let last = others.len().wrapping_sub(padded);
    if length == 0 || own.len() < padded || others.len() < padded || at[0] > last || at[1] > last {
        return [(0, 0); 2];
    }
    at.map(|at| dot_and_energy(&own[..length], &others[at..at + length]))
}

/// Σ p, Σ r, Σ p², Σ r² and Σ p r of bytes, p of `own` and r of `others`, over as many as both have. At most 2^16 bytes.
#[inline(always)]
pub(crate) fn moments(own: &[u8], others: &[u8]) -> [u32; 5] {
    let mut sums = [0; 5];
    add_moments(own, others, &mut sums);
    sums
}

/// Adds [`moments`] to `sums`.
#[inline(always)]
pub(super) fn add_moments(own: &[u8], others: &[u8], sums: &mut [u32; 5]) {
    for (&p, &r) in own.iter().zip(others) {
        let (p, r) = (p as u32, r as u32);
        for (sum, add) in sums.iter_mut().zip([p, r, p * p, r * r, p * r]) {
            *sum = sum.wrapping_add(add);
        }
    }
}

/// Σ `own[i] others[i + k]` for k = 0 to 3, both as signed bytes, over every `every`th row of `own`, rows of `strides.0`
/// bytes, at the same rows of `others`, `strides.1` bytes apart; others beyond the end count as 0. At most 2^16 bytes of
/// `own`.
#[inline(always)]
pub(crate) fn dot4_rows(own: &[u8], others: &[u8], strides: (usize, usize), every: usize) -> [i32; 4] {
    let (own_stride, other_stride) = (strides.0.max(1), strides.1);
    let every = every.max(1);
    let mut sums = [0; 4];
    for (row, own) in own.chunks_exact(own_stride).enumerate().step_by(every) {
        let others = others.get(row * other_stride..).unwrap_or(&[]);
        let at = |i: usize| others.get(i).map_or(0, |&r| r as i8 as i32);
        for (i, &p) in own.iter().enumerate() {
            for (k, sum) in sums.iter_mut().enumerate() {
                *sum += p as i8 as i32 * at(i + k);
            }
        }
    }
    sums
}

/// Σ `own[i] others[i]` and Σ `others[i]²`, both as signed bytes, over as many as both have. At most 2^16 bytes.
#[inline(always)]
pub(crate) fn dot_and_energy(own: &[u8], others: &[u8]) -> (i32, i32) {
    let mut sums = (0, 0);
    add_dot_and_energy(own, others, &mut sums);
    sums
}

/// Adds [`dot_and_energy`] to `dot` and `energy`.
#[inline(always)]
pub(super) fn add_dot_and_energy(own: &[u8], others: &[u8], (dot, energy): &mut (i32, i32)) {
    for (&p, &r) in own.iter().zip(others) {
        let (p, r) = (p as i8 as i32, r as i8 as i32);
        *dot += p * r;
        *energy += r * r;
    }
}
