//! The card's and the interface's words: SD Physical Layer Simplified Specification; the chip's reference manual, RM0433.

/// Commands by their numbers, and their arguments.
pub mod command {
    /// Back to the beginning.
    pub const IDLE: u8 = 0;
    /// The card's identification.
    pub const ALL_IDENTIFY: u8 = 2;
    /// Draws an address.
    pub const ADDRESS: u8 = 3;
    /// Behind [`APPLICATION`]: how many data lines.
    pub const WIDTH: u8 = 6;
    /// Into the state "transfer".
    pub const SELECT: u8 = 7;
    /// Supply, and whether the card is of version 2 or later.
    pub const CONDITION: u8 = 8;
    /// The card's description, CSD.
    pub const DESCRIBE: u8 = 9;
    /// Ends a transfer.
    pub const STOP: u8 = 12;
    /// The card's status.
    pub const STATUS: u8 = 13;
    /// Bytes of a block, of cards that count bytes.
    pub const SET_BLOCK_LENGTH: u8 = 16;
    /// Blocks come until [`STOP`].
    pub const READ_BLOCKS: u8 = 18;
    /// Blocks follow until [`STOP`].
    pub const WRITE_BLOCKS: u8 = 25;
    /// Behind [`APPLICATION`]: powers up, answers with the operating conditions, OCR.
    pub const POWER_UP: u8 = 41;
    /// The next command is of the application's.
    pub const APPLICATION: u8 = 55;

    /// 2.7 to 3.6 V, and a pattern that comes back.
    pub const CONDITION_WORD: u32 = 0x1aa;
    /// Cards that count blocks are welcome; 3.2 to 3.3 V.
    pub const POWER_UP_WORD: u32 = 1 << 30 | 1 << 20;
    /// Of OCR: powered up.
    pub const POWERED: u32 = 1 << 31;
    /// Of OCR: counts blocks.
    pub const COUNTS_BLOCKS: u32 = 1 << 30;
    /// For [`WIDTH`].
    pub const FOUR_LINES: u32 = 2;
}

/// What ICR clears: every flag of STAR that stays; bits 0 to 11 and 21 to 28.
pub const ALL_FLAGS: u32 = 0x1fe0_0fff;

/// Why a card does not do what it should.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A checksum was wrong.
    Checksum,
    /// Nothing came in time.
    Late,
    /// The DMA was too slow, or could not.
    Starved,
    /// Not such a card.
    Foreign,
}

/// What comes back from a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Nothing.
    None,
    /// 48 bits.
    Short,
    /// 48 bits without a checksum.
    Unchecked,
    /// 136 bits.
    Long,
}

impl Answer {
    /// Of a command.
    pub fn of(number: u8) -> Answer {
        match number {
            command::IDLE => Answer::None,
            command::POWER_UP => Answer::Unchecked,
            command::ALL_IDENTIFY | command::DESCRIBE => Answer::Long,
            _ => Answer::Short,
        }
    }

    /// WAITRESP.
    pub fn wait(self) -> u8 {
        match self {
            Answer::None => 0,
            Answer::Short => 1,
            Answer::Unchecked => 2,
            Answer::Long => 3,
        }
    }
}

/// How a command ended, if it has, by STAR: CCRCFAIL, CTIMEOUT, CMDREND, CMDSENT.
pub fn command_outcome(answer: Answer, star: u32) -> Option<Result<(), Fault>> {
    let end = if answer == Answer::None { 1 << 7 } else { 1 << 6 };
    match star {
        _ if star & 1 << 2 != 0 => Some(Err(Fault::Late)),
        _ if star & 1 << 0 != 0 && answer != Answer::Unchecked => Some(Err(Fault::Checksum)),
        _ if star & (end | 1 << 0) != 0 => Some(Ok(())),
        _ => None,
    }
}

/// How a transfer ended, if it has, by STAR: DCRCFAIL, DTIMEOUT, TXUNDERR or RXOVERR or IDMATE, DATAEND. A fault goes before
/// the end.
pub fn data_outcome(star: u32) -> Option<Result<(), Fault>> {
    match star {
        _ if star & 1 << 1 != 0 => Some(Err(Fault::Checksum)),
        _ if star & 1 << 3 != 0 => Some(Err(Fault::Late)),
        _ if star & (1 << 4 | 1 << 5 | 1 << 27) != 0 => Some(Err(Fault::Starved)),
        _ if star & 1 << 8 != 0 => Some(Ok(())),
        _ => None,
    }
}

/// Whether the card, by its status, is ready for data and is in its state "transfer": no longer programming.
pub fn is_ready(status: u32) -> bool {
    const READY_FOR_DATA: u32 = 1 << 8;
    const TRANSFER: u32 = 4;
    status & READY_FOR_DATA != 0 && status >> 9 & 0xf == TRANSFER
}

/// What there is to know of a card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Identity {
    /// Its address, in the upper half, as commands want it.
    pub address: u32,
    /// Blocks of 512 bytes.
    pub blocks: u32,
    counts_blocks: bool,
}

impl Identity {
    /// From its operating conditions and its description, the upper word first.
    pub fn new(ocr: u32, address: u32, description: [u32; 4]) -> Identity {
        let [first, second, third, _] = description;
        let blocks = if first >> 30 == 0 {
            // Version 1: C_SIZE, C_SIZE_MULT, READ_BL_LEN.
            let size = (second & 0x3ff) << 2 | third >> 30;
            let power = (third >> 15 & 7) + 2 + (second >> 16 & 0xf).saturating_sub(9);
            (size + 1) << power
        } else {
            // Version 2: C_SIZE in units of 512 KiB.
            (((second & 0x3f) << 16 | third >> 16) + 1).saturating_mul(1024)
        };
        Identity { address, blocks, counts_blocks: ocr & command::COUNTS_BLOCKS != 0 }
    }

    /// A block's address, as commands want it.
    pub fn address(&self, index: u32) -> u32 {
        if self.counts_blocks { index } else { index.saturating_mul(512) }
    }
}

#[cfg(test)]
mod tests {
    use super::{ALL_FLAGS, Answer, Fault, Identity, command_outcome, data_outcome, is_ready};

    #[test]
    fn a_card_is_ready_in_transfer_and_for_data_alone() {
        // As a card answers when idle between transfers; then not ready for data, stand-by, receiving, programming.
        assert!(is_ready(0x0000_0900));
        let others = [0x0000_0800, 0x0000_0700, 0x0000_0d00, 0x0000_0f00, 0x0000_0e00, 0, u32::MAX];
        assert!(others.iter().all(|status| !is_ready(*status)));
    }

    #[test]
    fn a_fault_goes_before_the_end() {
        let short = |star| command_outcome(Answer::Short, star);
        assert_eq!((short(0), data_outcome(0)), (None, None));
        assert_eq!((short(0x40), data_outcome(0x100)), (Some(Ok(())), Some(Ok(()))));
        assert_eq!((short(0x41), data_outcome(0x102)), (Some(Err(Fault::Checksum)), Some(Err(Fault::Checksum))));
        assert_eq!((short(0x44), data_outcome(0x108)), (Some(Err(Fault::Late)), Some(Err(Fault::Late))));
        for star in [0x110, 0x120, 0x0800_0100] {
            assert_eq!(data_outcome(star), Some(Err(Fault::Starved)), "{star:x}");
        }
        // None takes another's end for its own.
        assert_eq!((short(0x100), short(0x80), data_outcome(0x40)), (None, None, None));
        assert_eq!(command_outcome(Answer::None, 0x40), None);
        assert_eq!(command_outcome(Answer::None, 0x80), Some(Ok(())));
        // Operating conditions come with ones where a checksum would be.
        assert_eq!(command_outcome(Answer::Unchecked, 0x01), Some(Ok(())));
    }

    #[test]
    fn every_flag_that_is_looked_at_is_cleared() {
        for flag in [0, 1, 2, 3, 4, 5, 6, 7, 8, 27] {
            assert_ne!(ALL_FLAGS & 1 << flag, 0, "{flag}");
        }
    }

    #[test]
    fn sizes_are_those_of_real_cards() {
        // Descriptions as Linux shows them (/sys/block/mmcblk0/device/csd), bytes there 15931539456 and 1967128576.
        let large = Identity::new(0xc0ff_8000, 0xaaaa_0000, [0x400e_0032, 0x5b59_0000, 0x76b2_7f80, 0x0a40_4013]);
        assert_eq!((large.blocks, large.address(7)), ((0x76b2 + 1) * 1024, 7));
        // Version 1 by hand: C_SIZE 3751, C_SIZE_MULT 7, READ_BL_LEN 10: 3752 * 512 KiB * 1 KiB.
        let (size, mult, len) = (3751u32, 7u32, 10u32);
        let words = [0x002e_0032, 0x5b50_0000 | len << 16 | size >> 2, (size & 3) << 30 | mult << 15, 0];
        let small = Identity::new(0x80ff_8000, 0x0001_0000, words);
        assert_eq!((u64::from(small.blocks) * 512, small.address(7)), (3752 * 512 * 1024, 3584));
    }
}
