//! Where the functions of an image branch to, read from its machine code: Thumb-2 branches whose target stands in the
//! instruction (Arm v7-M Architecture Reference Manual, A7.7.12, A7.7.18, A7.7.21).
//!
//! Calls through a register (of a task's poll function by the executor, of a waker) have no target to be read.

/// Addresses that `code`, which begins at `base`, branches to or calls, with the address of each branch.
pub fn branches(base: u32, code: &[u8]) -> Vec<(u32, u32)> {
    let half = |at: usize| Some(u32::from(u16::from_le_bytes(code.get(at..at + 2)?.try_into().ok()?)));
    let mut found = Vec::new();
    let mut at = 0;
    while let Some(first) = half(at) {
        let address = base.wrapping_add(at as u32);
        // Prefixes 0b11101, 0b11110 and 0b11111 begin an instruction of two half words.
        let offset = if first >> 11 >= 0b11101 {
            let Some(second) = half(at + 2) else { break };
            at += 4;
            wide(first, second)
        } else {
            at += 2;
            narrow(first)
        };
        // The program counter reads as four bytes ahead.
        found.extend(offset.map(|offset| (address, address.wrapping_add(4).wrapping_add_signed(offset))));
    }
    found
}

/// B of two bytes, with a condition (T1) and without (T2), and CBZ and CBNZ.
fn narrow(word: u32) -> Option<i32> {
    match word >> 12 {
        0b1101 if word >> 8 & 0xf < 0b1110 => Some(signed(word & 0xff, 8) * 2),
        0b1110 if word >> 11 == 0b11100 => Some(signed(word & 0x7ff, 11) * 2),
        0b1011 if word & 0x0500 == 0x0100 => Some(((word >> 3 & 0x1f | word >> 4 & 0x20) * 2) as i32),
        _ => None,
    }
}

/// BL (T1), B.W without a condition (T4) and with one (T3).
fn wide(first: u32, second: u32) -> Option<i32> {
    if first >> 11 != 0b11110 || second >> 15 != 1 {
        return None;
    }
    let sign = first >> 10 & 1;
    let (j1, j2) = (second >> 13 & 1, second >> 11 & 1);
    match (second >> 14 & 1, second >> 12 & 1) {
        // BL, and B.W without a condition.
        (_, 1) => {
            let (i1, i2) = (!(j1 ^ sign) & 1, !(j2 ^ sign) & 1);
            let bits = sign << 23 | i1 << 22 | i2 << 21 | (first & 0x3ff) << 11 | second & 0x7ff;
            Some(signed(bits, 24) * 2)
        }
        (0, _) if first >> 6 & 0xf < 0b1110 => {
            let bits = sign << 19 | j2 << 18 | j1 << 17 | (first & 0x3f) << 11 | second & 0x7ff;
            Some(signed(bits, 20) * 2)
        }
        _ => None,
    }
}

/// A number of `bits` bits in two's complement.
fn signed(value: u32, bits: u32) -> i32 {
    (value << (32 - bits)) as i32 >> (32 - bits)
}

#[cfg(test)]
mod tests {
    use super::branches;

    /// As GNU as assembles them for a Cortex-M7 from 0x1000 on; the targets as its listing names them.
    #[test]
    fn branches_go_where_the_assembler_says() {
        let near: [u16; 24] = [
            0xe7fe, // 1000: b.n 1000
            0xd0fd, // 1002: beq.n 1000
            0xb118, // 1004: cbz r0, 100e
            0xf000, 0xf800, // 1006: bl 100a
            0xf7ff, 0xfffe, // 100a: bl 100a
            0xf7ff, 0xbff7, // 100e: b.w 1000
            0xf43f, 0xaff5, // 1012: beq.w 1000
            0x4770, // 1016: bx lr
            0xbf00, // 1018: nop
            0xb93b, // 101a: cbnz r3, 102c
            0xbf00, 0xbf00, // 101c: nop, nop
            0xf001, 0xf9c9, // 1020: bl 23b6
            0xf041, 0x81c7, // 1024: bne.w 23b6
            0xf001, 0xb9c5, // 1028: b.w 23b6
            0xbf00, // 102c: nop
            0xdf00, // 102e: svc 0, beside the conditions
        ];
        let wanted = [
            (0x1000, 0x1000),
            (0x1002, 0x1000),
            (0x1004, 0x100e),
            (0x1006, 0x100a),
            (0x100a, 0x100a),
            (0x100e, 0x1000),
            (0x1012, 0x1000),
            (0x101a, 0x102c),
            (0x1020, 0x23b6),
            (0x1024, 0x23b6),
            (0x1028, 0x23b6),
        ];
        assert_eq!(branches(0x1000, &bytes(&near)), wanted);
        let far: [u16; 7] = [
            0xbf00, // 23b6: nop
            0xf7fe, 0xfe22, // 23b8: bl 1000
            0xf7fe, 0xbe20, // 23bc: b.w 1000
            0xf47e, 0xae1e, // 23c0: bne.w 1000
        ];
        assert_eq!(branches(0x23b6, &bytes(&far)), [(0x23b8, 0x1000), (0x23bc, 0x1000), (0x23c0, 0x1000)]);
        assert_eq!(branches(0x1000, &bytes(&near)[..9]), wanted[..3], "half an instruction at the end is none");
    }

    fn bytes(words: &[u16]) -> Vec<u8> {
        words.iter().flat_map(|word| word.to_le_bytes()).collect()
    }
}
