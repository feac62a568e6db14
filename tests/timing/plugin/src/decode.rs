//! Thumb-2 encodings of Armv7E-M with FPv5, sorted by what they cost.
//!
//! The length comes from the encoding alone: QEMU 7.2 reports a 32-bit instruction across a border of 1 KiB as 16 bits.

/// What an instruction costs on a Cortex-M7 follows from its class.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Class {
    /// Moves, logic, additions, shifts.
    Alu,
    /// 32 and 64-bit multiplications, with or without accumulation.
    Mul,
    /// Packed and saturating arithmetic, 16-bit products, extensions, bit fields.
    Dsp,
    /// Integer divisions.
    Div,
    /// Loads of one register.
    Load,
    /// Loads of several registers.
    LoadMultiple,
    /// Stores of one register.
    Store,
    /// Stores of several registers.
    StoreMultiple,
    /// Branches, calls, table branches.
    Branch,
    /// If-then.
    It,
    /// Floating-point additions, comparisons, conversions, roundings, selections.
    FloatAdd,
    /// Floating-point products.
    FloatMul,
    /// Products with accumulation, fused or not.
    FloatFma,
    /// Floating-point divisions.
    FloatDiv,
    /// Square roots.
    FloatSqrt,
    /// Moves to, from and between floating-point registers.
    FloatMove,
    /// Floating-point loads of one register.
    FloatLoad,
    /// Floating-point stores of one register.
    FloatStore,
    /// Barriers, system registers, breakpoints and everything unknown.
    Other,
}

/// Number of classes.
pub const CLASSES: usize = Class::Other as usize + 1;

/// Their names, in order.
pub const NAMES: [&str; CLASSES] = [
    "alu", "mul", "dsp", "div", "ldr", "ldm", "str", "stm", "branch", "it", "vadd", "vmul", "vfma", "vdiv", "vsqrt",
    "vmov", "vldr", "vstr", "other",
];

/// The two ends of a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// `DBG #1`.
    Begin,
    /// `DBG #2`.
    End,
}

/// An instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// What it is.
    pub class: Class,
    /// Bytes: 2 or 4.
    pub bytes: u32,
    /// Registers that a multiple load or store moves, else 0.
    pub registers: u32,
    /// Whether it stores less than a word.
    pub is_narrow_store: bool,
    /// Whether it computes in double precision.
    pub is_double: bool,
    /// Whether it is no instruction of the program but an end of a region.
    pub marker: Option<Marker>,
}

/// Whether the instruction that begins with `first` has a second half.
pub fn is_wide(first: u16) -> bool {
    first >> 11 >= 0x1d
}

/// Decodes an instruction; `second` counts where [`is_wide`] holds.
pub fn decode(first: u16, second: u16) -> Instruction {
    if is_wide(first) {
        let (class, registers) = wide(first, second);
        let is_narrow_store = first & 0xfe10 == 0xf800 && first & 0x60 != 0x40;
        let marker = match (first, second) {
            (0xf3af, 0x80f1) => Some(Marker::Begin),
            (0xf3af, 0x80f2) => Some(Marker::End),
            _ => None,
        };
        // Coprocessor 11 is the double-precision half of 10.
        let is_double = first & 0xee00 == 0xee00 && second & 0x0f00 == 0x0b00 && class != Class::FloatMove;
        Instruction { class, bytes: 4, registers, is_narrow_store, is_double, marker }
    } else {
        let (class, registers) = narrow(first);
        let by_register = first & 0xf000 == 0x5000 && matches!(first >> 9 & 7, 1 | 2);
        let is_narrow_store = by_register || first & 0xf800 == 0x7000 || first & 0xf800 == 0x8000;
        Instruction { class, bytes: 2, registers, is_narrow_store, is_double: false, marker: None }
    }
}

fn narrow(first: u16) -> (Class, u32) {
    let loads = first & 0x0800 != 0;
    let one = |load, store| (if loads { load } else { store }, 0);
    match first >> 12 {
        0x4 if first & 0xffc0 == 0x4340 => (Class::Mul, 0),
        0x4 if first & 0xff00 == 0x4700 => (Class::Branch, 0),
        0x4 if loads => (Class::Load, 0),
        // The opcode of register offsets has three bits: 0 to 2 store.
        0x5 if first >> 9 & 7 < 3 => (Class::Store, 0),
        0x5 => (Class::Load, 0),
        0x6..=0x9 => one(Class::Load, Class::Store),
        0xb if first & 0xff00 == 0xbf00 => (if first & 0xf == 0 { Class::Alu } else { Class::It }, 0),
        0xb if first & 0xf500 == 0xb100 => (Class::Branch, 0),
        0xb if first & 0xff00 == 0xbe00 => (Class::Other, 0),
        0xb if first & 0xfe00 == 0xb400 => (Class::StoreMultiple, (first & 0x1ff).count_ones()),
        0xb if first & 0xfe00 == 0xbc00 => (Class::LoadMultiple, (first & 0x1ff).count_ones()),
        0xc => (one(Class::LoadMultiple, Class::StoreMultiple).0, (first & 0xff).count_ones()),
        0xd if first & 0x0f00 >= 0x0e00 => (Class::Other, 0),
        0xd | 0xe => (Class::Branch, 0),
        _ => (Class::Alu, 0),
    }
}

fn wide(first: u16, second: u16) -> (Class, u32) {
    let loads = first & 0x10 != 0;
    let one = |load, store| (if loads { load } else { store }, 0);
    let several = |count| (if loads { Class::LoadMultiple } else { Class::StoreMultiple }, count);
    if first & 0xfe40 == 0xe800 {
        return several(second.count_ones());
    }
    if first & 0xfe40 == 0xe840 {
        let is_table_branch = first & 0xfff0 == 0xe8d0 && second & 0xffe0 == 0xf000;
        return if is_table_branch { (Class::Branch, 0) } else { several(2) };
    }
    if first & 0xec00 == 0xec00 {
        return coprocessor(first, second);
    }
    if first & 0xf800 == 0xf000 {
        return (branch_or_immediate(first, second), 0);
    }
    match first & 0xff80 {
        0xf800..=0xf980 => one(Class::Load, Class::Store),
        0xfa00 if second & 0x80 == 0 => (Class::Alu, 0),
        0xfa00 | 0xfa80 => (Class::Dsp, 0),
        0xfb00 => (if first & 0x70 == 0 { Class::Mul } else { Class::Dsp }, 0),
        0xfb80 => (if first & 0x50 == 0x10 { Class::Div } else { Class::Mul }, 0),
        0xea00..=0xeb80 => (Class::Alu, 0),
        _ => (Class::Other, 0),
    }
}

fn branch_or_immediate(first: u16, second: u16) -> Class {
    let is_system = first & 0x0380 == 0x0380 && second & 0x5000 == 0;
    match (second & 0x8000 != 0, is_system) {
        (true, true) => Class::Other,
        (true, false) => Class::Branch,
        // Saturation and bit fields, which share the shifter's second cycle.
        _ if matches!(first & 0xff90, 0xf300 | 0xf380) => Class::Dsp,
        _ => Class::Alu,
    }
}

/// Coprocessors 10 and 11, which are the floating-point unit.
fn coprocessor(first: u16, second: u16) -> (Class, u32) {
    let loads = first & 0x10 != 0;
    if !matches!(second >> 8 & 0xf, 10 | 11) {
        return (Class::Other, 0);
    }
    match first & 0xff00 {
        // VSEL, VMAXNM, VCVTA and the like.
        0xfe00 => (Class::FloatAdd, 0),
        0xee00 if second & 0x10 != 0 => (Class::FloatMove, 0),
        0xee00 => (float_arithmetic(first, second), 0),
        _ if first & 0xffe0 == 0xec40 => (Class::FloatMove, 0),
        _ if first & 0xff20 == 0xed00 => (if loads { Class::FloatLoad } else { Class::FloatStore }, 0),
        _ => (if loads { Class::LoadMultiple } else { Class::StoreMultiple }, u32::from(second & 0xff)),
    }
}

fn float_arithmetic(first: u16, second: u16) -> Class {
    match first >> 4 & 0xb {
        0x0 | 0x1 | 0x9 | 0xa => Class::FloatFma,
        0x2 => Class::FloatMul,
        0x3 => Class::FloatAdd,
        0x8 if second & 0x40 == 0 => Class::FloatDiv,
        // VMOV of a constant.
        0xb if second & 0x40 == 0 => Class::FloatMove,
        0xb => match (first & 0xf, second >> 6 & 3) {
            (1, 3) => Class::FloatSqrt,
            (0 | 1, _) => Class::FloatMove,
            _ => Class::FloatAdd,
        },
        _ => Class::Other,
    }
}

#[cfg(test)]
mod tests;
