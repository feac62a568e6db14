//! Words of flash that the board writes itself: a sector of bank 2, the last one, while its code runs from bank 1.
//!
//! A word is written in some 0.2 ms (DS12110), during which reads of bank 2 (the reference) wait and code and interrupts do not;
//! nothing is erased. Nothing of this has run on silicon.

use crate::stores::bounds::{Area, WORD};
use cortex_m::asm::{dsb, isb};
use cortex_m::peripheral::SCB;
use embassy_stm32::pac;

// First address and end of the sector; memory.x says where it is.
unsafe extern "C" {
    static _stamps: u8;
    static _stamps_end: u8;
}

/// Bank 2, as the chip's description counts.
const BANK: usize = 1;
/// What opens the bank's control register, RM0433 4.9.3.
const KEYS: [u32; 2] = [0x4567_0123, 0xcdef_89ab];
/// Readings of the status until a write is given up: some milliseconds.
const PATIENCE: u32 = 1_000_000;
/// CCR.BFHFNMIGN of the core: loads at a negative priority ignore bus faults, ARMv7-M B3.2.8.
const IGNORE_BUS_FAULTS: u32 = 1 << 8;
/// The bus fault's part of CFSR, cleared by writing ones.
const BUS_FAULT_STATUS: u32 = 0xff00;

/// The sector. There is one user of it.
#[derive(Clone, Copy, Debug)]
pub struct Sector;

impl Sector {
    fn address(index: usize) -> usize {
        (&raw const _stamps).addr() + index * WORD
    }
}

impl Area for Sector {
    fn words(&self) -> usize {
        ((&raw const _stamps_end).addr() - (&raw const _stamps).addr()) / WORD
    }

    /// A word whose check bits fail twice is a bus fault on this chip (RM0433 4.3.11): it is read where such are ignored.
    fn read(&self, index: usize) -> Option<[u8; WORD]> {
        if index >= self.words() {
            return None;
        }
        let bank = pac::FLASH.bank(BANK);
        cortex_m::interrupt::free(|_| {
            bank.ccr().write(|w| w.set_clr_dbeccerr(true));
            // SAFETY: raises the priority to -1 and takes it back; between are loads of words that exist, whose faults are
            // ignored, and registers of the core. No other code runs meanwhile.
            let words: [u32; WORD / 4] = unsafe {
                let scb = &*SCB::PTR;
                scb.ccr.modify(|value| value | IGNORE_BUS_FAULTS);
                core::arch::asm!("cpsid f", "dsb", "isb", options(nostack, preserves_flags));
                let address = Self::address(index) as *const u32;
                let words = core::array::from_fn(|n| address.add(n).read_volatile());
                core::arch::asm!("dsb", "isb", "cpsie f", options(nostack, preserves_flags));
                scb.ccr.modify(|value| value & !IGNORE_BUS_FAULTS);
                scb.cfsr.write(BUS_FAULT_STATUS);
                words
            };
            let is_readable = !bank.sr().read().dbeccerr();
            bank.ccr().write(|w| w.set_clr_dbeccerr(true));
            let mut bytes = [0; WORD];
            bytes.iter_mut().zip(words.map(u32::to_le_bytes).as_flattened()).for_each(|(to, from)| *to = *from);
            is_readable.then_some(bytes)
        })
    }

    fn write(&mut self, index: usize, word: &[u8; WORD]) {
        if index >= self.words() {
            return;
        }
        let bank = pac::FLASH.bank(BANK);
        let is_busy = || bank.sr().read().bsy() || bank.sr().read().qw();
        let wait = || (0..PATIENCE).any(|_| !is_busy());
        if !wait() {
            return;
        }
        for key in KEYS.into_iter().filter(|_| bank.cr().read().lock()) {
            bank.keyr().write_value(key);
        }
        bank.cr().modify(|w| {
            w.set_pg(true);
            w.set_psize(2);
        });
        dsb();
        isb();
        let (words, _) = word.as_chunks::<4>();
        cortex_m::interrupt::free(|_| {
            for (n, word) in words.iter().enumerate() {
                // SAFETY: a word of the sector, which nothing but this code knows; the MPU allows it to be written.
                unsafe { (Self::address(index) as *mut u32).add(n).write_volatile(u32::from_le_bytes(*word)) };
            }
            dsb();
        });
        wait();
        bank.cr().modify(|w| w.set_pg(false));
        // What went wrong is found by reading; the flags would keep the next word from being written.
        bank.ccr().write(|w| {
            w.set_clr_eop(true);
            w.set_clr_wrperr(true);
            w.set_clr_pgserr(true);
            w.set_clr_strberr(true);
            w.set_clr_incerr(true);
            w.set_clr_operr(true);
        });
        bank.cr().modify(|w| w.set_lock(true));
    }
}
