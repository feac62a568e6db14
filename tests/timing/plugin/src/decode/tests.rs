//! Encodings as the GNU assembler makes them.

use super::Class::{
    Alu, Branch, Div, Dsp, FloatAdd, FloatDiv, FloatFma, FloatLoad, FloatMove, FloatMul, FloatSqrt, FloatStore, It,
    Load, LoadMultiple, Mul, Other, Store, StoreMultiple,
};
use super::{Class, Marker, NAMES, decode, is_wide};

/// Halves, class, registers moved at once.
#[rustfmt::skip]
const KNOWN: &[(u16, u16, Class, u32)] = &[
    (0x3001, 0x0000, Alu, 0), // adds r0, #1
    (0x4802, 0x0000, Load, 0), // ldr r0, [pc, #8]
    (0x6848, 0x0000, Load, 0), // ldr r0, [r1, #4]
    (0x7808, 0x0000, Load, 0), // ldrb r0, [r1, #0]
    (0x5e88, 0x0000, Load, 0), // ldrsh r0, [r1, r2]
    (0x9001, 0x0000, Store, 0), // str r0, [sp, #4]
    (0x7048, 0x0000, Store, 0), // strb r0, [r1, #1]
    (0x8048, 0x0000, Store, 0), // strh r0, [r1, #2]
    (0x5488, 0x0000, Store, 0), // strb r0, [r1, r2]
    (0xb530, 0x0000, StoreMultiple, 3), // push {r4, r5, lr}
    (0xbd30, 0x0000, LoadMultiple, 3), // pop {r4, r5, pc}
    (0xe7fe, 0x0000, Branch, 0), // b.n label
    (0xd0fe, 0x0000, Branch, 0), // beq.n label
    (0xb100, 0x0000, Branch, 0), // cbz r0, label
    (0x4770, 0x0000, Branch, 0), // bx lr
    (0x4348, 0x0000, Mul, 0), // muls r0, r1
    (0xbf08, 0x0000, It, 0), // it eq
    (0x3001, 0x0000, Alu, 0), // addeq r0, #1
    (0xbf00, 0x0000, Alu, 0), // nop
    (0xc806, 0x0000, LoadMultiple, 2), // ldmia r0!, {r1, r2}
    (0xbeab, 0x0000, Other, 0), // bkpt 0x00ab
    (0xf8d1, 0x0064, Load, 0), // ldr.w r0, [r1, #100]
    (0xf811, 0x8b01, Load, 0), // ldrb.w r8, [r1], #1
    (0xf801, 0x8b01, Store, 0), // strb.w r8, [r1], #1
    (0xf8a1, 0x8002, Store, 0), // strh.w r8, [r1, #2]
    (0xf841, 0x8022, Store, 0), // str.w r8, [r1, r2, lsl #2]
    (0xf911, 0x8002, Load, 0), // ldrsb.w r8, [r1, r2]
    (0xe9d2, 0x0100, LoadMultiple, 2), // ldrd r0, r1, [r2]
    (0xe9c2, 0x0100, StoreMultiple, 2), // strd r0, r1, [r2]
    (0xe898, 0x000f, LoadMultiple, 4), // ldmia.w r8, {r0, r1, r2, r3}
    (0xe92d, 0x41f0, StoreMultiple, 6), // stmdb sp!, {r4, r5, r6, r7, r8, lr}
    (0xe8df, 0xf000, Branch, 0), // tbb [pc, r0]
    (0xe851, 0x0f00, LoadMultiple, 2), // ldrex r0, [r1]
    (0xeb01, 0x00c2, Alu, 0), // add.w r0, r1, r2, lsl #3
    (0xf241, 0x2034, Alu, 0), // movw r0, #4660
    (0xf2c1, 0x2034, Alu, 0), // movt r0, #4660
    (0xf3c1, 0x00c3, Dsp, 0), // ubfx r0, r1, #3, #4
    (0xf361, 0x00c6, Dsp, 0), // bfi r0, r1, #3, #4
    (0xf381, 0x0008, Dsp, 0), // usat r0, #8, r1
    (0xf301, 0x0007, Dsp, 0), // ssat r0, #8, r1
    (0xf3a1, 0x0008, Dsp, 0), // usat16 r0, #8, r1
    (0xfb01, 0xf002, Mul, 0), // mul.w r0, r1, r2
    (0xfb01, 0x3002, Mul, 0), // mla r0, r1, r2, r3
    (0xfb01, 0x3012, Mul, 0), // mls r0, r1, r2, r3
    (0xfb11, 0xf002, Dsp, 0), // smulbb r0, r1, r2
    (0xfb21, 0x3002, Dsp, 0), // smlad r0, r1, r2, r3
    (0xfb71, 0x3002, Dsp, 0), // usada8 r0, r1, r2, r3
    (0xfb51, 0x3002, Dsp, 0), // smmla r0, r1, r2, r3
    (0xfba2, 0x0103, Mul, 0), // umull r0, r1, r2, r3
    (0xfbc2, 0x0103, Mul, 0), // smlal r0, r1, r2, r3
    (0xfbc2, 0x01c3, Mul, 0), // smlald r0, r1, r2, r3
    (0xfbe2, 0x0163, Mul, 0), // umaal r0, r1, r2, r3
    (0xfb91, 0xf0f2, Div, 0), // sdiv r0, r1, r2
    (0xfbb1, 0xf0f2, Div, 0), // udiv r0, r1, r2
    (0xfa81, 0xf042, Dsp, 0), // uadd8 r0, r1, r2
    (0xfa3f, 0xf081, Dsp, 0), // uxtb16 r0, r1
    (0xfa5f, 0xf889, Dsp, 0), // uxtb.w r8, r9
    (0xfa51, 0xf082, Dsp, 0), // uxtab r0, r1, r2
    (0xfaa1, 0xf082, Dsp, 0), // sel r0, r1, r2
    (0xfab1, 0xf081, Dsp, 0), // clz r0, r1
    (0xfa99, 0xf889, Dsp, 0), // rev.w r8, r9
    (0xfa01, 0xf002, Alu, 0), // lsl.w r0, r1, r2
    (0xf7ff, 0xfffe, Branch, 0), // bl label
    (0xf7ff, 0xbffe, Branch, 0), // b.w label
    (0xf43f, 0xaffe, Branch, 0), // beq.w label
    (0xf3af, 0x80f1, Other, 0), // dbg #1
    (0xf3af, 0x80f2, Other, 0), // dbg #2
    (0xf3ef, 0x8000, Other, 0), // mrs r0, CPSR
    (0xf3bf, 0x8f5f, Other, 0), // dmb sy
    (0xf3af, 0x8000, Other, 0), // nop.w
    (0xed90, 0x0a00, FloatLoad, 0), // vldr s0, [r0]
    (0xed80, 0x0a00, FloatStore, 0), // vstr s0, [r0]
    (0xed90, 0x0b00, FloatLoad, 0), // vldr d0, [r0]
    (0xecb0, 0x0a04, LoadMultiple, 4), // vldmia r0!, {s0-s3}
    (0xed2d, 0x8b04, StoreMultiple, 4), // vpush {d8-d9}
    (0xee00, 0x0a10, FloatMove, 0), // vmov s0, r0
    (0xee10, 0x0a10, FloatMove, 0), // vmov r0, s0
    (0xec41, 0x0b10, FloatMove, 0), // vmov d0, r0, r1
    (0xeef1, 0xfa10, FloatMove, 0), // vmrs APSR_nzcv, fpscr
    (0xeeb7, 0x0a00, FloatMove, 0), // vmov.f32 s0, #112
    (0xeeb0, 0x0a60, FloatMove, 0), // vmov.f32 s0, s1
    (0xeeb0, 0x0ae0, FloatMove, 0), // vabs.f32 s0, s1
    (0xeeb1, 0x0a60, FloatMove, 0), // vneg.f32 s0, s1
    (0xeeb1, 0x0ae0, FloatSqrt, 0), // vsqrt.f32 s0, s1
    (0xee30, 0x0a81, FloatAdd, 0), // vadd.f32 s0, s1, s2
    (0xee30, 0x0ac1, FloatAdd, 0), // vsub.f32 s0, s1, s2
    (0xee20, 0x0a81, FloatMul, 0), // vmul.f32 s0, s1, s2
    (0xee20, 0x0ac1, FloatMul, 0), // vnmul.f32 s0, s1, s2
    (0xee00, 0x0a81, FloatFma, 0), // vmla.f32 s0, s1, s2
    (0xee00, 0x0ac1, FloatFma, 0), // vmls.f32 s0, s1, s2
    (0xee10, 0x0a81, FloatFma, 0), // vnmls.f32 s0, s1, s2
    (0xeea0, 0x0a81, FloatFma, 0), // vfma.f32 s0, s1, s2
    (0xeea0, 0x0ac1, FloatFma, 0), // vfms.f32 s0, s1, s2
    (0xee90, 0x0a81, FloatFma, 0), // vfnms.f32 s0, s1, s2
    (0xee80, 0x0a81, FloatDiv, 0), // vdiv.f32 s0, s1, s2
    (0xeeb4, 0x0a60, FloatAdd, 0), // vcmp.f32 s0, s1
    (0xeeb5, 0x0a40, FloatAdd, 0), // vcmp.f32 s0, #0.0
    (0xeebd, 0x0ae0, FloatAdd, 0), // vcvt.s32.f32 s0, s1
    (0xeeb8, 0x0a60, FloatAdd, 0), // vcvt.f32.u32 s0, s1
    (0xeeb7, 0x0ae0, FloatAdd, 0), // vcvt.f64.f32 d0, s1
    (0xeebe, 0x0ac8, FloatAdd, 0), // vcvt.s32.f32 s0, s0, #16
    (0xeeb6, 0x0ae0, FloatAdd, 0), // vrintz.f32 s0, s1
    (0xfe20, 0x0a81, FloatAdd, 0), // vselge.f32 s0, s1, s2
    (0xfe80, 0x0a81, FloatAdd, 0), // vmaxnm.f32 s0, s1, s2
    (0xfebf, 0x0ae0, FloatAdd, 0), // vcvtm.s32.f32 s0, s1
    (0xfeb8, 0x0a60, FloatAdd, 0), // vrinta.f32 s0, s1
    (0xee31, 0x0b02, FloatAdd, 0), // vadd.f64 d0, d1, d2
    (0xee81, 0x0b02, FloatDiv, 0), // vdiv.f64 d0, d1, d2
    (0xf821, 0x0e01, Store, 0), // strht r0, [r1, #1]
    (0xf890, 0xf000, Load, 0), // pld [r0]
    (0xf8b1, 0x0008, Load, 0), // ldrh.w r0, [r1, #8]
];

#[test]
fn known_encodings_have_their_class() {
    for &(first, second, class, registers) in KNOWN {
        let instruction = decode(first, second);
        assert_eq!((instruction.class, instruction.registers), (class, registers), "{first:04x} {second:04x}");
    }
}

#[test]
fn the_length_follows_from_the_first_half() {
    // None of the wide ones above has a second half of zero.
    for &(first, second, ..) in KNOWN {
        assert_eq!(is_wide(first), second != 0, "{first:04x}");
        assert_eq!(decode(first, second).bytes, if second == 0 { 2 } else { 4 });
    }
}

#[test]
fn bytes_and_halves_are_narrow_stores_and_words_are_not() {
    for (first, second) in [(0x7048, 0), (0x8048, 0), (0x5488, 0), (0x5288, 0), (0xf801, 0x8b01), (0xf8a1, 0x8002)] {
        assert!(decode(first, second).is_narrow_store, "{first:04x}");
    }
    // str, str by register, ldrb, ldrh by register, str.w, ldrb.w, strd, vstr.
    let others = [(0x9001, 0), (0x5088, 0), (0x7808, 0), (0x5a88, 0), (0xf841, 0x8022), (0xf811, 0x8b01)];
    for (first, second) in others.into_iter().chain([(0xe9c2, 0x0100), (0xed80, 0x0a00)]) {
        assert!(!decode(first, second).is_narrow_store, "{first:04x}");
    }
}

#[test]
fn only_the_two_markers_mark() {
    assert_eq!(decode(0xf3af, 0x80f1).marker, Some(Marker::Begin));
    assert_eq!(decode(0xf3af, 0x80f2).marker, Some(Marker::End));
    assert_eq!(decode(0xf3af, 0x80f3).marker, None);
    assert!(KNOWN.iter().filter(|known| known.0 != 0xf3af).all(|known| decode(known.0, known.1).marker.is_none()));
}

#[test]
fn every_class_occurs_and_has_a_name() {
    for (class, name) in NAMES.iter().enumerate() {
        assert!(KNOWN.iter().any(|known| known.2 as usize == class), "{name}");
    }
}
