//! The loops by packed instructions.
#![allow(unsafe_code, reason = "instructions that only assembly can name")]

#[cfg(doc)]
use super::portable;
use super::{MIDDLE, blend};
use crate::arch::opaque;
use crate::rectify::nodes::Node;
use crate::rectify::stretch::{Frame, Stretch};
use crate::rectify::table::Table;
use core::arch::asm;

/// The instructions between two nodes in different rows of boxes, `x`, `f` not below `t`, `n`; the result is in `f`.
macro_rules! from_row_to_row {
    () => {
        concat!(
            "strd {t}, {n}, [sp, #16]\n",
            "sub {t}, {t}, {x}\n",
            "sub {slope}, {n}, {f}\n",
            "lsl {t}, {t}, #15\n",
            // Q15 of a box a row.
            "sdiv {slope}, {t}, {slope}\n",
            "rsb {n}, {u}, {n}, asr #8\n",
            "ubfx {f}, {f}, #0, #8\n",
            "lsl {x}, {x}, #8\n",
            "rsb {f}, {f}, #256\n",
            "mul {t}, {slope}, {f}\n",
            "add {t}, {x}, {t}, asr #8\n",
            "asr {u}, {t}, #16\n",
            "ubfx {t}, {t}, #9, #7\n",
            "ldr {u}, [{row}, {u}, lsl #1]\n",
            "mla {t}, {t}, {k}, {one}\n",
            "smuad {u}, {u}, {t}\n",
            "subs {n}, {n}, #1\n",
            "beq 8f\n",
            // Whole rows, at their middles.
            "add {t}, {f}, #128\n",
            "mov {whole}, #0\n",
            "mul {t}, {slope}, {t}\n",
            "mul {f}, {u}, {f}\n",
            "add {x}, {x}, {t}, asr #7\n",
            "2:\n",
            "asr {u}, {x}, #16\n",
            "add {row}, {row}, {stride}\n",
            "ubfx {t}, {x}, #9, #7\n",
            "ldr {u}, [{row}, {u}, lsl #1]\n",
            "mla {t}, {t}, {k}, {one}\n",
            "add {x}, {x}, {slope}, lsl #1\n",
            "subs {n}, {n}, #1\n",
            "smlad {whole}, {u}, {t}, {whole}\n",
            "bne 2b\n",
            "add {f}, {f}, {whole}, lsl #8\n",
            "b 3f\n",
            "8:\n",
            "mul {f}, {u}, {f}\n",
            // The last piece, from its end.
            "3:\n",
            "ldrd {t}, {n}, [sp, #16]\n",
            "add {row}, {row}, {stride}\n",
            "ubfx {n}, {n}, #0, #8\n",
            "lsl {t}, {t}, #8\n",
            "mul {u}, {slope}, {n}\n",
            "sub {t}, {t}, {u}, asr #8\n",
            "asr {u}, {t}, #16\n",
            "ubfx {t}, {t}, #9, #7\n",
            "ldr {u}, [{row}, {u}, lsl #1]\n",
            "mla {t}, {t}, {k}, {one}\n",
            "smuad {u}, {u}, {t}\n",
            "mla {f}, {u}, {n}, {f}",
        )
    };
}

/// [`portable::border_integrals`].
#[inline(always)]
pub(crate) fn border_integrals(
    table: &Table<'_>,
    nodes: &mut [Node],
    first: usize,
    (is_left, further): (bool, isize),
    count: usize,
) -> bool {
    let is_there = |first: usize| nodes.get(first..first + count).is_some();
    if !is_there(first) || !first.checked_add_signed(further).is_some_and(is_there) {
        return false;
    }
    // SAFETY: both ends of each border are in `nodes`. `Lines::nodes` makes them and returns only those that lie in the
    // table, `Table::new` has checked that the table has all its sums, and `area::integrate` that ends are near enough.
    unsafe {
        let first = nodes.as_mut_ptr().add(first);
        integrate_borders(table.start(), first, (usize::from(is_left), further), count);
    }
    true
}

/// `table`: its first byte, and bytes from one row to the next.
///
/// # Safety
/// All these nodes lie in one object and in the table: 0 ≤ x < boxes of a row, 0 ≤ y < rows, and `table` holds them all. No
/// two lie 256 boxes apart along a row. `which` is 0 or 1.
// All that is read lies between the nodes: the slope is rounded to 0, t is at most dy, and what is rounded down at the
// end are whole 2⁻¹⁶, of which both x are some. Products stay below 2^31: dx is below 2^16, and slope · t at most 2^15 dx.
#[inline(never)]
unsafe fn integrate_borders(
    (sums, stride): (*const u8, usize),
    first: *mut Node,
    (which, further): (usize, isize),
    count: usize,
) {
    if count > 0 {
        // SAFETY: reads nodes and, as the caller promises and for the reasons above, sums of the table; writes integrals of the
        // same nodes. The stack pointer is put back.
        unsafe {
            asm!(
                "sub sp, sp, #24",
                "strd {row}, {u}, [sp]",
                "strd {x}, {n}, [sp, #8]",
                "1:",
                "ldrd {row}, {u}, [sp]",
                "ldrd {x}, {f}, [{node}]",
                "add {u}, {node}, {u}",
                "ldrd {t}, {n}, [{u}]",
                "asr {u}, {f}, #8",
                "cmp {u}, {n}, asr #8",
                "bgt 6f",
                "mla {row}, {u}, {stride}, {row}",
                "beq 4f",
                from_row_to_row!(),
                "5:",
                "ldrd {t}, {u}, [sp, #8]",
                "str {f}, [{node}, {t}]",
                "add {node}, {node}, #16",
                "cmp {node}, {u}",
                "bne 1b",
                "b 9f",
                // Within one row, in any direction.
                "4:",
                "sub {f}, {n}, {f}",
                "add {t}, {t}, {x}",
                "lsl {t}, {t}, #7",
                "asr {u}, {t}, #16",
                "ubfx {t}, {t}, #9, #7",
                "ldr {u}, [{row}, {u}, lsl #1]",
                "mla {t}, {t}, {k}, {one}",
                "smuad {u}, {u}, {t}",
                "mul {f}, {u}, {f}",
                "b 5b",
                // Upwards: the same way downwards, and its negative.
                "6:",
                "asr {u}, {n}, #8",
                "mla {row}, {u}, {stride}, {row}",
                "mov {slope}, {x}",
                "mov {x}, {t}",
                "mov {t}, {slope}",
                "mov {slope}, {f}",
                "mov {f}, {n}",
                "mov {n}, {slope}",
                from_row_to_row!(),
                "rsb {f}, {f}, #0",
                "b 5b",
                "9:",
                "add sp, sp, #24",
                node = inout(reg) first => _,
                row = inout(reg) sums.wrapping_add(2) => _,
                n = inout(reg) first.wrapping_add(count) => _,
                u = inout(reg) 16 * further => _,
                stride = in(reg) stride,
                k = in(reg) 0xffff,
                one = in(reg) 128,
                x = inout(reg) 8 + 4 * which => _,
                f = out(reg) _,
                t = out(reg) _,
                slope = out(reg) _,
                whole = out(reg) _,
            );
        }
    }
}

/// [`portable::cell_means`].
pub(crate) fn cell_means(upper: &[Node], lower: &[Node], shift: u32, means: &mut [u8]) -> u32 {
    if upper.len() <= means.len() || lower.len() <= means.len() {
        return u32::MAX;
    }
    let mut areas = 0;
    if !means.is_empty() {
        // SAFETY: reads one node more than `means` holds from both lines, as was checked, and fills `means`.
        unsafe {
            asm!(
                "2:",
                // The diagonals, and half their product.
                "ldrd {a}, {b}, [{upper}]",
                "ldrd {c}, {d}, [{lower}, #16]",
                "sub {c}, {c}, {a}",
                "sub {d}, {d}, {b}",
                "ldrd {a}, {b}, [{lower}]",
                "ldrd {e}, {f}, [{upper}, #16]!",
                "sub {a}, {a}, {e}",
                "sub {b}, {b}, {f}",
                "mul {e}, {c}, {b}",
                "mls {e}, {d}, {a}, {e}",
                "ldrd {a}, {b}, [{upper}, #-8]",
                "ldr {c}, [{upper}, #12]",
                "ldr {d}, [{lower}, #8]",
                "asr {e}, {e}, #2",
                "orr {e}, {e}, #1",
                "sub {a}, {a}, {b}",
                "sub {c}, {c}, {d}",
                "add {a}, {a}, {c}",
                "orr {areas}, {areas}, {e}",
                "lsl {a}, {a}, {shift}",
                "add {a}, {a}, {e}, lsl #7",
                "add {lower}, {lower}, #16",
                "add {a}, {a}, {e}, lsr #1",
                "sdiv {a}, {a}, {e}",
                "usat {a}, #8, {a}",
                "subs {n}, {n}, #1",
                "strb {a}, [{means}], #1",
                "bne 2b",
                upper = inout(reg) upper.as_ptr() => _,
                lower = inout(reg) lower.as_ptr() => _,
                means = inout(reg) means.as_mut_ptr() => _,
                n = inout(reg) means.len() => _,
                areas = inout(reg) areas,
                shift = in(reg) shift,
                a = out(reg) _,
                b = out(reg) _,
                c = out(reg) _,
                d = out(reg) _,
                e = out(reg) _,
                f = out(reg) _,
                options(nostack),
            );
        }
    }
    areas
}

/// [`portable::blend_along`], four readings a turn.
///
/// 20.75 instructions a reading: weights are the positions' own bits, both rows are blended at once, and four results
/// are stored as a word.
#[inline(always)]
pub(crate) fn blend_along(frame: &Frame<'_>, stretch: &Stretch, out: &mut [[u8; 4]]) {
    let (pixels, stride) = frame.start();
    let ([x, y], [dx, dy], growth) = stretch.parts();
    if !out.is_empty() {
        // One reading, its byte on top of the result: r0, r1 the position, r2, r3 the step, r4 one in both halves, r5 the
        // stride, r8 the first pixel, r10 what makes rows signed; r6, r7 and lr are scratch.
        macro_rules! reading {
            ($result:literal) => {
                concat!(
                    "smlatb lr, r1, r5, r8\n",
                    "add lr, lr, r0, lsr #16\n",
                    "ldrh r6, [lr, r5]\n",
                    "ldrh lr, [lr]\n",
                    "ubfx r7, r0, #8, #8\n",
                    "add r0, r0, r2, asr #8\n",
                    "orr lr, lr, r6, lsl #16\n",
                    "uxtb16 r6, lr, ror #8\n",
                    "uxtb16 lr, lr\n",
                    "sub r6, r6, lr\n",
                    "add lr, r10, lr, lsl #8\n",
                    "mla lr, r6, r7, lr\n",
                    "uxth r7, r1\n",
                    "add r1, r1, r3, asr #8\n",
                    "smusd r6, lr, r4\n",
                    "lsl lr, lr, #16\n",
                    "mls ",
                    $result,
                    ", r6, r7, lr"
                )
            };
        }
        // SAFETY: `Draft::checked` has found that the four pixels of every position are the frame's; each turn writes one
        // word of `out`, as long as there is one. What is pushed is popped; r6 and r7 are the compiler's own again before
        // the end.
        unsafe {
            asm!(
                "push {{r6, r7, r11, r12, lr}}",
                "2:",
                reading!("r11"),
                reading!("r12"),
                "ldrd r6, r7, [sp, #12]",
                "add r2, r2, r6",
                "add r3, r3, r7",
                reading!("lr"),
                "pkhtb r11, lr, r11, asr #16",
                reading!("lr"),
                "pkhtb r12, lr, r12, asr #16",
                "ldrd r6, r7, [sp, #12]",
                "add r2, r2, r6",
                "add r3, r3, r7",
                "and r12, r12, #0xff00ff00",
                "uxtab16 r12, r12, r11, ror #8",
                "ldr lr, [sp, #8]",
                "eor r12, r12, #0x80808080",
                "str r12, [r9], #4",
                "cmp r9, lr",
                "bne 2b",
                "pop {{r6, r7, r11, r12, lr}}",
                inout("r0") x => _,
                inout("r1") y => _,
                inout("r2") dx => _,
                inout("r3") dy => _,
                in("r4") 0x0001_0001,
                in("r5") stride as u32,
                in("r8") pixels,
                inout("r9") out.as_mut_ptr() => _,
                in("r10") MIDDLE.wrapping_neg(),
                inout("r11") out.as_mut_ptr_range().end => _,
                inout("r12") growth[0] => _,
                inout("lr") growth[1] => _,
            );
        }
    }
}

/// [`portable::blend_steeply`].
#[inline(never)]
pub(crate) fn blend_steeply(frame: &Frame<'_>, stretch: &Stretch, out: &mut [u8]) {
    let (pixels, stride) = frame.start();
    let ([mut x, mut y], [mut dx, mut dy], growth) = stretch.parts();
    let mut out = out.iter_mut();
    let mut left = out.len();
    while left > 0 {
        // SAFETY: `Draft::checked` has found that the four pixels of every position are the frame's.
        let blended = unsafe { blend_at(pixels, stride, x, y) };
        if let Some(pixel) = out.next() {
            *pixel = blended;
        }
        (x, y) = (x.wrapping_add(dx >> 8), y.wrapping_add(dy >> 8));
        (dx, dy) = (dx.wrapping_add(growth[0]), dy.wrapping_add(growth[1]));
        left = opaque(left - 1);
    }
}

/// One reading at (`x`, `y`), Q16.
///
/// # Safety
/// The position has a column and a row that are not negative, and its four pixels belong to the frame.
#[inline(always)]
unsafe fn blend_at(pixels: *const u8, stride: u16, x: i32, y: i32) -> u8 {
    // SAFETY: as the caller says.
    let (top, bottom) = unsafe {
        let first = pixels.add((y >> 16) as usize * stride as usize + (x >> 16) as usize);
        (first.cast::<u16>().read_unaligned(), first.add(stride as usize).cast::<u16>().read_unaligned())
    };
    blend(u16::from_le(top) as u32 | (u16::from_le(bottom) as u32) << 16, (x as u32 >> 8) & 0xff, y as u32 & 0xffff)
}
