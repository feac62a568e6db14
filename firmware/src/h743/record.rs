//! What is known of the last fault, in memory that outlives a reset, and what is concluded from it at the next start.
//!
//! The words lie at the start of the backup SRAM. They are written once, by the handler of the fault, and closed by a
//! CRC: memory that was never written, or half, is no record.

use core::fmt::{self, Display};

/// Why the program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Reason {
    /// A panic.
    Panic = 1,
    /// A fault of no finer kind, or one within a handler.
    HardFault = 2,
    /// An access that the MPU forbids.
    Memory = 3,
    /// An access that the bus refused.
    Bus = 4,
    /// An instruction that is none.
    Usage = 5,
    /// A non-maskable interrupt: the crystal failed.
    NonMaskable = 6,
    /// The stack ran out of its bank.
    Stack = 7,
    /// The watchdog was not fed.
    Watchdog = 8,
    /// An interrupt without a handler.
    Interrupt = 9,
}

impl Reason {
    /// The reason with this number.
    pub fn from_code(code: u32) -> Option<Reason> {
        use Reason as R;
        let all =
            [R::Panic, R::HardFault, R::Memory, R::Bus, R::Usage, R::NonMaskable, R::Stack, R::Watchdog, R::Interrupt];
        all.into_iter().find(|reason| *reason as u32 == code)
    }

    /// The finest reason that the core's fault status holds: CFSR and MMFAR of ARMv7-M. `guard` is the region
    /// below the stack.
    pub fn of_fault(cfsr: u32, mmfar: u32, guard: core::ops::Range<u32>) -> Reason {
        // MSTKERR and MLSPERR: registers could not be pushed. MMARVALID: the address counts.
        let pushing = cfsr & (1 << 4 | 1 << 5) != 0;
        let is_guard = cfsr & 1 << 7 != 0 && guard.contains(&mmfar);
        match cfsr {
            _ if pushing || is_guard => Reason::Stack,
            _ if cfsr & 0xff != 0 => Reason::Memory,
            _ if cfsr & 0xff00 != 0 => Reason::Bus,
            _ if cfsr & 0xffff_0000 != 0 => Reason::Usage,
            _ => Reason::HardFault,
        }
    }
}

/// The record of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Record {
    /// Why.
    pub reason: Reason,
    /// Faults in a row, this one included: without [`GOOD_S`] of good running between them.
    pub in_a_row: u32,
    /// Where: the program counter; of a panic the line of the source.
    pub pc: u32,
    /// Whence: the link register; of a panic a hash of the source file's name.
    pub lr: u32,
    /// Configurable fault status.
    pub cfsr: u32,
    /// Hard fault status.
    pub hfsr: u32,
    /// Address that the MPU refused.
    pub mmfar: u32,
    /// Address that the bus refused.
    pub bfar: u32,
    /// Reading of the capture timer.
    pub tick: u32,
    /// [`firmware`] of the image.
    pub firmware: u32,
}

/// Words of an encoded record.
pub const WORDS: usize = 12;
const MAGIC: u32 = 0x504c_4652;
const CRC: crc::Crc<u32, crc::NoTable> = crc::Crc::<u32, crc::NoTable>::new(&crc::CRC_32_ISO_HDLC);

/// Good running after which faults are no longer in a row, seconds.
pub const GOOD_S: u32 = 60;
/// More faults in a row than this lead into the safe state.
pub const FAULTS_MAX: u32 = 3;
/// How long the safe state lasts, seconds: no exposures, no fixes; the link is up and reports why.
pub const SAFE_S: u32 = 30;

impl Record {
    /// As it is stored.
    pub fn encode(&self) -> [u32; WORDS] {
        let mut words = [
            MAGIC,
            self.reason as u32,
            self.in_a_row,
            self.pc,
            self.lr,
            self.cfsr,
            self.hfsr,
            self.mmfar,
            self.bfar,
            self.tick,
            self.firmware,
            0,
        ];
        words[WORDS - 1] = checksum(&words);
        words
    }

    /// The record in `words`, if they hold one.
    pub fn decode(words: &[u32; WORDS]) -> Option<Record> {
        if words[0] != MAGIC || words[WORDS - 1] != checksum(words) {
            return None;
        }
        let [_, reason, in_a_row, pc, lr, cfsr, hfsr, mmfar, bfar, tick, firmware, _] = *words;
        let reason = Reason::from_code(reason)?;
        Some(Record { reason, in_a_row, pc, lr, cfsr, hfsr, mmfar, bfar, tick, firmware })
    }

    /// Whether the next start is into the safe state.
    pub fn is_safe_state(&self) -> bool {
        self.in_a_row > FAULTS_MAX
    }
}

/// One line for the link: at most 50 characters, as STATUSTEXT holds.
impl Display for Record {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = match self.reason {
            Reason::Panic => return write!(f, "fault: panic line {} file {:08x} x{}", self.pc, self.lr, self.in_a_row),
            Reason::HardFault => "hard",
            Reason::Memory => "memory",
            Reason::Bus => "bus",
            Reason::Usage => "usage",
            Reason::NonMaskable => "nmi",
            Reason::Stack => "stack",
            Reason::Watchdog => "watchdog",
            Reason::Interrupt => "interrupt",
        };
        write!(f, "fault: {name} pc {:08x} lr {:08x} x{}", self.pc, self.lr, self.in_a_row)
    }
}

fn checksum(words: &[u32; WORDS]) -> u32 {
    let mut digest = CRC.digest();
    for word in &words[..WORDS - 1] {
        digest.update(&word.to_le_bytes());
    }
    digest.finalize()
}

/// A number for a name: of a source file, of a version.
pub fn hash(name: &str) -> u32 {
    CRC.checksum(name.as_bytes())
}

/// The number of this firmware's version.
pub fn firmware() -> u32 {
    hash(env!("CARGO_PKG_VERSION"))
}

#[cfg(test)]
mod tests {
    extern crate std;

    use super::*;
    use std::string::ToString;

    fn record() -> Record {
        Record {
            reason: Reason::Bus,
            in_a_row: 2,
            pc: 0x0804_1234,
            lr: 0x0804_4321,
            cfsr: 0x8200,
            hfsr: 0x4000_0000,
            mmfar: 1,
            bfar: 2,
            tick: 3,
            firmware: firmware(),
        }
    }

    #[test]
    fn a_record_comes_back_and_a_damaged_one_does_not() {
        let words = record().encode();
        assert_eq!(Record::decode(&words), Some(record()));
        for n in 0..WORDS {
            for bit in 0..32 {
                let mut damaged = words;
                damaged[n] ^= 1 << bit;
                assert_eq!(Record::decode(&damaged), None, "word {n}, bit {bit}");
            }
        }
        assert_eq!(Record::decode(&[0; WORDS]), None);
        assert_eq!(Record::decode(&[u32::MAX; WORDS]), None);
    }

    #[test]
    fn the_fault_status_tells_the_kind() {
        let guard = 0x1fff_8000..0x2000_0000;
        let of = |cfsr, mmfar| Reason::of_fault(cfsr, mmfar, guard.clone());
        assert_eq!(of(0x82, 0x1fff_fff8), Reason::Stack);
        assert_eq!(of(0x82, 0x0000_0000), Reason::Memory);
        // The address is stale where it is not said to be valid.
        assert_eq!(of(0x02, 0x1fff_fff8), Reason::Memory);
        assert_eq!(of(0x10, 0), Reason::Stack);
        assert_eq!(of(0x0400, 0), Reason::Bus);
        assert_eq!(of(0x0200_0000, 0), Reason::Usage);
        assert_eq!(of(0, 0), Reason::HardFault);
    }

    #[test]
    fn the_safe_state_comes_after_the_fourth_fault_in_a_row() {
        let at = |in_a_row| Record { in_a_row, ..record() }.is_safe_state();
        assert!(!at(3) && at(4));
    }

    #[test]
    fn every_line_fits_a_status_text() {
        for code in 1..=9 {
            let reason = Reason::from_code(code).unwrap();
            let line = Record { reason, in_a_row: 9999, pc: u32::MAX, lr: u32::MAX, ..record() }.to_string();
            assert!(line.len() <= 50 && line.starts_with("fault: "), "{line}");
        }
        assert_eq!(Reason::from_code(10), None);
    }
}
