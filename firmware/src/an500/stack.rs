//! What RAM is in use. cortex-m-rt paints the stack's memory before `main`; what is no longer painted was used.

use cortex_m_rt::STACK_PAINT_VALUE;

unsafe extern "C" {
    static _ram_start: u8;
    static _stack_end: u32;
    static _stack_start: u32;
}

/// Bytes of `.data`, `.bss` and `.uninit`.
pub fn static_bytes() -> u32 {
    ((&raw const _stack_end).addr() - (&raw const _ram_start).addr()) as u32
}

/// Most bytes the stack has ever taken, interrupts included. All of it means that it may have overflowed.
pub fn high_water_bytes() -> u32 {
    let (end, start) = (&raw const _stack_end, &raw const _stack_start);
    let words = (start.addr() - end.addr()) / size_of::<u32>();
    // SAFETY: every word from `_stack_end` up to `_stack_start` is RAM that nothing but the stack uses; volatile, since
    // the words above the stack pointer are no object of this function.
    let painted = (0..words).take_while(|&n| unsafe { end.add(n).read_volatile() } == STACK_PAINT_VALUE).count();
    ((words - painted) * size_of::<u32>()) as u32
}

/// Bytes between the static data and the top of the stack.
pub fn room_bytes() -> u32 {
    ((&raw const _stack_start).addr() - (&raw const _stack_end).addr()) as u32
}
