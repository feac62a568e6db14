//! The MPU's regions, as words for its registers. ARMv7-M; cacheable or not by RM0433 and AN4838.
//!
//! RAM that a DMA writes is not cached, rather than cached and cleaned: the rows of the ring are read once, by MDMA, which
//! passes by the cache anyhow, and the links' buffers are a few bytes at a time. So nothing has to be remembered when a
//! buffer is touched. Flash keeps the architecture's default, cached; DTCM and ITCM are never cached.

/// A region: RBAR without its number, and RASR.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// First address, a multiple of the size.
    pub base: u32,
    /// Bytes, a power of two.
    pub size: u32,
    /// What may be done there.
    pub access: Access,
}

/// What may be done in a region.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// Nothing: every access faults.
    None,
    /// Data that a DMA shares: read and written, not cached, not executed.
    Shared,
    /// Code: read and executed.
    Code,
    /// Data of the core alone: read and written, not executed.
    Data,
}

/// All regions, later ones over earlier ones. Everywhere else the default map holds.
///
/// The first is what the stack runs into when it overflows. Code is not written, ITCM included, so neither is address 0; of flash
/// the last sector alone is.
pub const REGIONS: [Region; 8] = [
    GUARD,
    Region { base: 0x0000_0000, size: 0x0001_0000, access: Access::Code },
    Region { base: 0x2000_0000, size: 0x0002_0000, access: Access::Data },
    Region { base: 0x2400_0000, size: 0x0008_0000, access: Access::Shared },
    Region { base: 0x3000_0000, size: 0x0008_0000, access: Access::Shared },
    Region { base: 0x3800_0000, size: 0x0100_0000, access: Access::Shared },
    Region { base: 0x0800_0000, size: 0x0020_0000, access: Access::Code },
    STAMPS,
];

/// The last 32 KiB below DTCM, reserved by the chip.
pub const GUARD: Region = Region { base: 0x1fff_8000, size: 0x8000, access: Access::None };

/// The last sector of flash, STAMPS of memory.x: how far the time in signatures is reserved, which the board writes itself.
pub const STAMPS: Region = Region { base: 0x081e_0000, size: 0x2_0000, access: Access::Shared };

impl Region {
    /// Addresses.
    pub const fn range(&self) -> core::ops::Range<u32> {
        self.base..self.base + self.size
    }

    /// RBAR with VALID and the region's number.
    pub const fn rbar(&self, number: u8) -> u32 {
        self.base | 1 << 4 | number as u32 & 0xf
    }

    /// RASR: execute never, access permission, TEX S C B, size, enable.
    pub const fn rasr(&self) -> u32 {
        let (never, permission, tex, s, c, b) = match self.access {
            Access::None => (1, 0b000, 0b000, 0, 0, 0),
            Access::Shared => (1, 0b011, 0b001, 1, 0, 0),
            // Write-through, as the default map has flash.
            Access::Code => (0, 0b110, 0b000, 0, 1, 0),
            Access::Data => (1, 0b011, 0b001, 0, 1, 1),
        };
        let size = self.size.trailing_zeros() - 1;
        never << 28 | permission << 24 | tex << 19 | s << 18 | c << 17 | b << 16 | size << 1 | 1
    }
}

#[cfg(test)]
mod tests {
    use super::{Access, GUARD, REGIONS};

    #[test]
    fn regions_are_what_the_unit_can_hold() {
        assert!(REGIONS.len() <= 16);
        for region in REGIONS {
            assert!(region.size.is_power_of_two() && region.size >= 32);
            assert_eq!(region.base % region.size, 0, "{region:x?}");
        }
    }

    #[test]
    fn words_are_those_of_the_architecture() {
        // By hand, from ARMv7-M B3.5.8 and B3.5.9.
        assert_eq!((GUARD.rbar(0), GUARD.rasr()), (0x1fff_8010, 0x1000_001d));
        assert_eq!((REGIONS[3].rbar(3), REGIONS[3].rasr()), (0x2400_0013, 0x130c_0025));
        assert_eq!(REGIONS[1].rasr(), 0x0602_001f);
        assert_eq!(REGIONS[2].rasr(), 0x130b_0021);
    }

    #[test]
    fn the_guard_ends_where_the_stack_does_and_nothing_else_lies_in_it() {
        assert_eq!(GUARD.range().end, 0x2000_0000);
        for other in REGIONS.iter().skip(1) {
            let (a, b) = (other.range(), GUARD.range());
            assert!(a.end <= b.start || b.end <= a.start, "{other:x?}");
        }
    }

    #[test]
    fn no_ram_but_itcm_is_executed() {
        for region in REGIONS {
            let is_ram = (0x2000_0000..0x4000_0000).contains(&region.base);
            assert!(!is_ram || matches!(region.access, Access::Shared | Access::Data), "{region:x?}");
        }
    }
}
