//! The loops word by word: unlike the library's they are not calls.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

#[cfg(doc)]
use super::portable;
use core::arch::asm;

/// [`portable::copy`].
#[inline(always)]
pub(crate) fn copy(from: &[u8], to: &mut [u8]) {
    let length = from.len().min(to.len());
    let (from, to) = (&from[..length], &mut to[..length]);
    let words = length & !3;
    if words > 0 {
        // SAFETY: each turn reads and writes four bytes, as long as both have them.
        unsafe {
            asm!(
                "2:",
                "ldr {word}, [{from}], #4",
                "subs {n}, #4",
                "str {word}, [{to}], #4",
                "bne 2b",
                from = inout(reg) from.as_ptr() => _,
                to = inout(reg) to.as_mut_ptr() => _,
                n = inout(reg) words => _,
                word = out(reg) _,
                options(nostack),
            );
        }
    }
    if words > 0 && length > words {
        // SAFETY: both have four bytes before their ends.
        unsafe {
            let last = from.as_ptr().add(length - 4).cast::<u32>().read_unaligned();
            to.as_mut_ptr().add(length - 4).cast::<u32>().write_unaligned(last);
        }
        return;
    }
    let mut at = words;
    while at < length {
        // Volatile, lest the compiler makes a call of it again.
        // SAFETY: `at` is below the length of both.
        unsafe { to.as_mut_ptr().add(at).write_volatile(*from.as_ptr().add(at)) };
        at += 1;
    }
}

/// [`portable::fill`].
#[inline(always)]
pub(crate) fn fill(value: u8, to: &mut [u8]) {
    let words = to.len() & !3;
    if words > 0 {
        let word = value as u32 * 0x0101_0101;
        // SAFETY: each turn writes four bytes, as long as there are so many; what is left lies in the last four.
        unsafe {
            asm!(
                "2:",
                "subs {n}, #4",
                "str {word}, [{to}], #4",
                "bne 2b",
                to = inout(reg) to.as_mut_ptr() => _,
                n = inout(reg) words => _,
                word = in(reg) word,
                options(nostack),
            );
            to.as_mut_ptr().add(to.len() - 4).cast::<u32>().write_unaligned(word);
        }
        return;
    }
    for at in 0..to.len() {
        // Volatile, lest the compiler makes a call of it again.
        // SAFETY: `at` is below the length.
        unsafe { to.as_mut_ptr().add(at).write_volatile(value) };
    }
}
