//! The card's and the interface's words: SD Physical Layer Simplified Specification 4.7 and 4.10.1; RM0433, 55.10.

/// CMD12: ends a transfer of several blocks.
pub const STOP: u8 = 12;
/// CMD13: the card's status.
pub const STATUS: u8 = 13;
/// CMD16: bytes of a block.
pub const SET_BLOCK_LENGTH: u8 = 16;
/// CMD25: blocks follow until [`STOP`].
pub const WRITE_BLOCKS: u8 = 25;

/// What ICR clears: every flag of STAR that stays; bits 0 to 11 and 21 to 28.
pub const ALL_FLAGS: u32 = 0x1fe0_0fff;

/// What the interface's status says of a command or a transfer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Not ended yet.
    Running,
    /// Well.
    Done,
    /// A checksum was wrong.
    Checksum,
    /// Nothing came in time.
    Late,
    /// The DMA brought too little.
    Starved,
}

/// Of a command with an answer, by STAR: CCRCFAIL, CTIMEOUT, CMDREND.
pub fn command_outcome(star: u32) -> Outcome {
    match star {
        _ if star & 1 << 0 != 0 => Outcome::Checksum,
        _ if star & 1 << 2 != 0 => Outcome::Late,
        _ if star & 1 << 6 != 0 => Outcome::Done,
        _ => Outcome::Running,
    }
}

/// Of blocks that are written, by STAR: DCRCFAIL, DTIMEOUT, TXUNDERR or IDMATE, DATAEND. A fault goes before the end.
pub fn data_outcome(star: u32) -> Outcome {
    match star {
        _ if star & 1 << 1 != 0 => Outcome::Checksum,
        _ if star & 1 << 3 != 0 => Outcome::Late,
        _ if star & (1 << 4 | 1 << 27) != 0 => Outcome::Starved,
        _ if star & 1 << 8 != 0 => Outcome::Done,
        _ => Outcome::Running,
    }
}

/// Whether the card, by its status, has room for data and is in its state "transfer": no longer programming.
pub fn is_ready(status: u32) -> bool {
    const READY_FOR_DATA: u32 = 1 << 8;
    const TRANSFER: u32 = 4;
    status & READY_FOR_DATA != 0 && status >> 9 & 0xf == TRANSFER
}

#[cfg(test)]
mod tests {
    use super::{ALL_FLAGS, Outcome, command_outcome, data_outcome, is_ready};

    #[test]
    fn a_card_is_ready_in_transfer_with_room_alone() {
        // As a card answers when idle between transfers; then by state: stand-by, receiving, programming.
        assert!(is_ready(0x0000_0900));
        assert!(
            [0x0000_0800, 0x0000_0700, 0x0000_0d00, 0x0000_0f00, 0x0000_0e00, 0, u32::MAX]
                .iter()
                .all(|s| !is_ready(*s))
        );
    }

    #[test]
    fn a_fault_goes_before_the_end() {
        assert_eq!((command_outcome(0), data_outcome(0)), (Outcome::Running, Outcome::Running));
        assert_eq!((command_outcome(0x40), data_outcome(0x100)), (Outcome::Done, Outcome::Done));
        assert_eq!((command_outcome(0x41), data_outcome(0x102)), (Outcome::Checksum, Outcome::Checksum));
        assert_eq!((command_outcome(0x44), data_outcome(0x108)), (Outcome::Late, Outcome::Late));
        assert_eq!((data_outcome(0x110), data_outcome(0x0800_0100)), (Outcome::Starved, Outcome::Starved));
        // Neither takes the other's end for its own.
        assert_eq!((command_outcome(0x100), data_outcome(0x40)), (Outcome::Running, Outcome::Running));
    }

    #[test]
    fn every_flag_that_is_looked_at_is_cleared() {
        for flag in [0, 1, 2, 3, 4, 6, 8, 27] {
            assert_ne!(ALL_FLAGS & 1 << flag, 0, "{flag}");
        }
    }
}
