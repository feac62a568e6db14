//! What happens when the program cannot go on: the record is written, and the chip restarts.
//!
//! Every fault enters by one piece of assembly, which takes a stack of its own before it pushes anything: after an
//! overflow there is none.

use crate::h743::record::{Reason, Record, WORDS, firmware, hash};
use crate::h743::regions::GUARD;
use core::panic::PanicInfo;
use core::sync::atomic::AtomicU32;
use cortex_m::peripheral::{SCB, SYST};
use embassy_stm32::pac;

/// The record of the last fault, and the mode to start in. Kept over a reset.
#[unsafe(link_section = ".backup")]
static mut RECORD: [u32; WORDS] = [0; WORDS];
#[unsafe(link_section = ".backup")]
static mut MODE: [u32; 2] = [0; 2];

/// Word that asks for the simulator's mode, followed by its complement.
const SIMULATOR: u32 = 0x5349_4d31;

/// Lets the backup SRAM be written. It is off after a reset.
pub fn open_backup() {
    pac::PWR.cr1().modify(|w| w.set_dbp(true));
    pac::RCC.ahb4enr().modify(|w| w.set_bkpsramen(true));
    cortex_m::asm::dsb();
}

fn words() -> [u32; WORDS] {
    // SAFETY: volatile reads of words of our own; they may hold anything, which the CRC finds out.
    core::array::from_fn(|n| unsafe { (&raw const RECORD).cast::<u32>().add(n).read_volatile() })
}

fn store(words: &[u32; WORDS]) {
    for (n, word) in words.iter().enumerate() {
        // SAFETY: inside the array; nobody holds a reference to it.
        unsafe { (&raw mut RECORD).cast::<u32>().add(n).write_volatile(*word) };
    }
    cortex_m::asm::dsb();
}

/// The record of the last fault, if there is one.
pub fn last() -> Option<Record> {
    Record::decode(&words())
}

/// Good running: faults to come are not in a row with the last.
pub fn forgive() {
    if let Some(record) = last() {
        store(&Record { in_a_row: 0, ..record }.encode());
    }
}

/// Notes a reset by the watchdog, which no handler saw.
pub fn note_watchdog() {
    let in_a_row = last().map_or(0, |record| record.in_a_row).saturating_add(1);
    let reason = Reason::Watchdog;
    let empty = Record { reason, in_a_row, pc: 0, lr: 0, cfsr: 0, hfsr: 0, mmfar: 0, bfar: 0, tick: 0, firmware: 0 };
    store(&Record { firmware: firmware(), ..empty }.encode());
}

/// Whether the last run asked for the simulator's mode; the wish is taken back.
pub fn take_simulator_wish() -> bool {
    let mode = &raw mut MODE;
    // SAFETY: volatile accesses to words of our own, which may hold anything.
    let [word, complement] = unsafe { mode.read_volatile() };
    // SAFETY: as above.
    unsafe { mode.write_volatile([0; 2]) };
    word == SIMULATOR && complement == !SIMULATOR
}

/// Boots since the backup SRAM was last without power; from then any number on.
#[unsafe(link_section = ".backup.boots")]
static mut BOOTS: u32 = 0;

/// This boot's number, for who wants to tell boots apart. To be called once.
pub fn boots() -> u32 {
    let address = &raw mut BOOTS;
    // SAFETY: volatile accesses to a word of our own, which may hold anything.
    unsafe {
        let boots = address.read_volatile().wrapping_add(1);
        address.write_volatile(boots);
        boots
    }
}

/// The reset counter of the fixes. A word: the memory's own checksums are of words.
#[unsafe(link_section = ".backup.resets")]
static RESETS: AtomicU32 = AtomicU32::new(0);

/// Where the reset counter of the fixes is kept over a start. It may hold anything.
pub fn resets() -> &'static AtomicU32 {
    &RESETS
}

/// Restarts into the simulator's mode.
pub fn restart_as_simulator() -> ! {
    // SAFETY: a volatile write to words of our own.
    unsafe { (&raw mut MODE).write_volatile([SIMULATOR, !SIMULATOR]) };
    cortex_m::asm::dsb();
    SCB::sys_reset()
}

fn end(reason: Reason, pc: u32, lr: u32) -> ! {
    open_backup();
    // SAFETY: reads of status registers, which have no effect.
    let (cfsr, hfsr, mmfar, bfar) = unsafe {
        let scb = &*SCB::PTR;
        (scb.cfsr.read(), scb.hfsr.read(), scb.mmfar.read(), scb.bfar.read())
    };
    let in_a_row = last().map_or(0, |record| record.in_a_row).saturating_add(1);
    let tick = pac::TIM2.cnt().read();
    store(&Record { reason, in_a_row, pc, lr, cfsr, hfsr, mmfar, bfar, tick, firmware: firmware() }.encode());
    SCB::sys_reset()
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    cortex_m::interrupt::disable();
    let (line, file) = info.location().map_or((0, 0), |location| (location.line(), hash(location.file())));
    end(Reason::Panic, line, file)
}

/// Stack of the handlers of faults.
#[allow(dead_code, reason = "used by the assembly below")]
#[repr(align(8))]
struct Stack([u8; 1024]);

#[unsafe(no_mangle)]
static mut FAULT_STACK: Stack = Stack([0; 1024]);

// Every fault and NMI: r0 = the stack pointer with the registers the core pushed, r1 = IPSR; then a stack of our own.
core::arch::global_asm!(
    ".section .text.fault_entry,\"ax\",%progbits",
    ".syntax unified",
    ".thumb",
    ".global NonMaskableInt, HardFault, MemoryManagement, BusFault, UsageFault",
    ".type HardFault, %function",
    ".type NonMaskableInt, %function",
    ".type MemoryManagement, %function",
    ".type BusFault, %function",
    ".type UsageFault, %function",
    ".thumb_func",
    "NonMaskableInt:",
    ".thumb_func",
    "HardFault:",
    ".thumb_func",
    "MemoryManagement:",
    ".thumb_func",
    "BusFault:",
    ".thumb_func",
    "UsageFault:",
    "mrs r0, msp",
    "mrs r1, ipsr",
    "ldr r2, =FAULT_STACK + 1024",
    "msr msp, r2",
    "b {entry}",
    ".pool",
    entry = sym fault_entry,
);

/// Exception numbers, ARMv7-M B1.5.2.
const NMI: u32 = 2;

extern "C" fn fault_entry(frame: u32, exception: u32) -> ! {
    // Offsets of LR and PC in what the core pushes. After an overflow the frame lies below DTCM and is not read.
    let is_ram = (0x2000_0000..0x2002_0000 - 32).contains(&frame) && frame.is_multiple_of(4);
    let word = |offset: u32| {
        // SAFETY: inside DTCM, aligned.
        if is_ram { unsafe { ((frame + offset) as *const u32).read_volatile() } } else { 0 }
    };
    // SAFETY: reads of status registers.
    let (cfsr, mmfar) = unsafe { ((*SCB::PTR).cfsr.read(), (*SCB::PTR).mmfar.read()) };
    let reason = match exception {
        NMI => Reason::NonMaskable,
        _ if !is_ram => Reason::Stack,
        _ => Reason::of_fault(cfsr, mmfar, GUARD.range()),
    };
    end(reason, word(24), word(20))
}

#[cortex_m_rt::exception]
unsafe fn DefaultHandler(number: i16) -> ! {
    end(Reason::Interrupt, number as u32, 0)
}

/// Enables the memory, bus and usage fault handlers. Division by zero stays untrapped and gives 0.
pub fn enable(scb: &mut SCB, syst: &mut SYST) {
    use cortex_m::peripheral::scb::Exception;
    // What a bootloader may have left running.
    syst.disable_interrupt();
    syst.disable_counter();
    for exception in [Exception::MemoryManagement, Exception::BusFault, Exception::UsageFault] {
        scb.enable(exception);
    }
}
