//! Two bounds for a Cortex-M7, of instruction counts.
//!
//! *Floor*: two instructions a cycle, and 15 more for every VDIV, which blocks. Nothing can be faster.
//!
//! *Serial estimate*: one instruction at a time, and every result waited for as if the next instruction used it. The
//! latencies are those of LLVM's scheduling model of the core (load 3, multiplication and packed arithmetic 2, floating
//! point 3, fused multiply-add 6), of measurements for divisions (16 cycles and one of margin for VDIV and VSQRT), and of the
//! architecture for SDIV and UDIV (12 at most). To them come 1 cycle a taken branch, 8 a branch that goes another way
//! than it did the last time, 4 a misaligned load, 2 a store of less than a word.
//!
//! It is an estimate: interrupts, DMA on the same buses and instruction fetch are outside it, and memory answers at once
//! but for the external one, whose lines are counted apart. On CoreMark, the one published figure that could be set
//! against it, it gave 2.5 times the cycles of silicon (integer code; ST AN4667: 5.01 CoreMark/MHz). Double precision, which
//! the firmware has in libm alone, is priced by the same scheduling model: 4, 7, 11 and 30 cycles.

use crate::decode::{CLASSES, Class, Instruction};

/// Cycles of an instruction of each class under the serial estimate, in the classes' order.
const SERIAL: [u64; CLASSES] = [1, 2, 2, 12, 3, 1, 2, 1, 1, 1, 3, 3, 6, 17, 17, 3, 3, 2, 4];
/// What an addition, a product, one with accumulation and a division or root take longer in double precision.
const DOUBLE: [(Class, u64); 5] =
    [(Class::FloatAdd, 1), (Class::FloatMul, 4), (Class::FloatFma, 5), (Class::FloatDiv, 14), (Class::FloatSqrt, 14)];
const TAKEN: u64 = 1;
const FLIP: u64 = 8;
const MISALIGNED_LOAD: u64 = 4;
const NARROW_STORE: u64 = 2;
/// What a VDIV adds to the floor.
const VDIV_FLOOR: u64 = 15;

/// What was executed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Instructions by class.
    pub classes: [u64; CLASSES],
    /// Registers moved by multiple loads and stores.
    pub registers: u64,
    /// Stores of less than a word.
    pub narrow_stores: u64,
    /// Cycles that double precision takes longer than single.
    pub double_cycles: u64,
    /// Branches taken.
    pub taken: u64,
    /// Branches that went another way than the last time, or went for the first time.
    pub flips: u64,
    /// Loads off their size's boundary.
    pub misaligned_loads: u64,
    /// Lines of external memory fetched.
    pub lines: u64,
}

impl Counts {
    /// Adds an instruction that is executed.
    pub fn add(&mut self, instruction: &Instruction) {
        self.classes[instruction.class as usize] += 1;
        self.registers += u64::from(instruction.registers);
        self.narrow_stores += u64::from(instruction.is_narrow_store);
        if instruction.is_double {
            let longer = DOUBLE.iter().find(|(class, _)| *class == instruction.class).map_or(0, |(_, cycles)| *cycles);
            self.double_cycles += longer;
        }
    }

    /// Adds `times` as much as `other` has.
    pub fn add_times(&mut self, other: &Counts, times: u64) {
        for (mine, theirs) in self.classes.iter_mut().zip(other.classes) {
            *mine += theirs * times;
        }
        self.registers += other.registers * times;
        self.narrow_stores += other.narrow_stores * times;
        self.double_cycles += other.double_cycles * times;
        self.taken += other.taken * times;
        self.flips += other.flips * times;
        self.misaligned_loads += other.misaligned_loads * times;
        self.lines += other.lines * times;
    }

    /// Instructions.
    pub fn instructions(&self) -> u64 {
        self.classes.iter().sum()
    }

    /// Cycles below which nothing can be.
    pub fn floor(&self) -> u64 {
        self.instructions().div_ceil(2) + VDIV_FLOOR * self.classes[Class::FloatDiv as usize]
    }

    /// Cycles of the serial estimate, without the external memory's.
    pub fn serial(&self) -> u64 {
        let classes: u64 = self.classes.iter().zip(SERIAL).map(|(count, cycles)| count * cycles).sum();
        classes
            + self.registers
            + TAKEN * self.taken
            + FLIP * self.flips
            + MISALIGNED_LOAD * self.misaligned_loads
            + NARROW_STORE * self.narrow_stores
            + self.double_cycles
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;
    use crate::decode::decode;

    /// The cycles of one instruction.
    fn serial(first: u16, second: u16) -> u64 {
        let mut counts = Counts::default();
        counts.add(&decode(first, second));
        counts.serial()
    }

    #[test]
    fn latencies_are_those_of_the_model() {
        let cycles = [
            ((0x3001, 0), 1),          // adds
            ((0x6848, 0), 3),          // ldr
            ((0xfb01, 0x3002), 2),     // mla
            ((0xee30, 0x0a81), 3),     // vadd.f32
            ((0xeea0, 0x0a81), 6),     // vfma.f32
            ((0xee80, 0x0a81), 17),    // vdiv.f32
            ((0xeeb1, 0x0ae0), 17),    // vsqrt.f32
            ((0xee30, 0x0b01), 4),     // vadd.f64
            ((0xee20, 0x0b01), 7),     // vmul.f64
            ((0xeea0, 0x0b01), 11),    // vfma.f64
            ((0xee80, 0x0b01), 31),    // vdiv.f64
            ((0xeeb1, 0x0bc1), 31),    // vsqrt.f64
            ((0xeeb0, 0x0b41), 3),     // vmov.f64
            ((0xfb91, 0xf0f2), 12),    // sdiv
            ((0xe898, 0x000f), 1 + 4), // ldmia of four
            ((0x7048, 0), 2 + 2),      // strb
            ((0x9001, 0), 2),          // str
        ];
        for ((first, second), expected) in cycles {
            assert_eq!(serial(first, second), expected, "{first:04x} {second:04x}");
        }
    }

    #[test]
    fn events_cost_what_the_model_says() {
        let counts = Counts { taken: 1, flips: 10, misaligned_loads: 100, lines: 1000, ..Counts::default() };
        assert_eq!(counts.serial(), 1 + 80 + 400);
    }

    #[test]
    fn the_floor_is_half_the_instructions_and_the_divisions() {
        let mut counts = Counts::default();
        for _ in 0..5 {
            counts.add(&decode(0x3001, 0));
        }
        assert_eq!(counts.floor(), 3);
        counts.add(&decode(0xee80, 0x0a81));
        assert_eq!(counts.floor(), 3 + 15);
        let mut twice = Counts::default();
        twice.add_times(&counts, 2);
        assert_eq!((twice.instructions(), twice.floor()), (12, 6 + 30));
    }
}
