//! The banks of RAM at start: code into ITCM, vectors, MPU, caches; and the buffers outside DTCM.

use crate::h743::regions::REGIONS;
use core::cell::UnsafeCell;
use core::mem::MaybeUninit;
use core::sync::atomic::{AtomicBool, Ordering};
use cortex_m::peripheral::{CPUID, MPU, SCB};

unsafe extern "C" {
    static mut __sitcm: u64;
    static mut __eitcm: u64;
    static __siitcm: u64;
    static __vector_table: u32;
    static _stack_start: u32;
    static _stack_end: u32;
    static _ram_end: u32;
}

/// Copies the hot code into ITCM.
///
/// # Safety
/// Called once, before any function that lies there.
pub unsafe fn fill_itcm() {
    let (from, to, end) = (&raw const __siitcm, &raw mut __sitcm, &raw mut __eitcm);
    let words = (end.addr() - to.addr()) / size_of::<u64>();
    // SAFETY: the linker laid out both ranges, of this length, aligned to 8 and apart; nobody else uses them yet.
    // Volatile: the first copies go to an address below 32, which must not be taken for a null pointer's neighbour.
    (0..words).for_each(|n| unsafe { to.add(n).write_volatile(from.add(n).read_volatile()) });
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
}

/// Points the core at this image's vectors. A bootloader leaves its own.
pub fn set_vectors(scb: &SCB) {
    // SAFETY: the table is whole, aligned by the linker script and there for ever.
    unsafe { scb.vtor.write((&raw const __vector_table).addr() as u32) };
    cortex_m::asm::dsb();
}

/// Sets up the MPU, then the caches.
pub fn protect(mpu: &MPU, scb: &mut SCB, cpuid: &mut CPUID) {
    // A bootloader may have left caches on, with lines of regions that change now.
    scb.disable_dcache(cpuid);
    scb.disable_icache();
    // SAFETY: the regions allow all that this image does: see their test and the map's.
    unsafe {
        mpu.ctrl.write(0);
        for (number, region) in (0u8..).zip(&REGIONS) {
            mpu.rbar.write(region.rbar(number));
            mpu.rasr.write(region.rasr());
        }
        for number in REGIONS.len() as u32..16 {
            mpu.rnr.write(number);
            mpu.rasr.write(0);
        }
        // On, over the default map, and within fault handlers too: they get a stack of their own.
        mpu.ctrl.write(1 << 0 | 1 << 1 | 1 << 2);
    }
    cortex_m::asm::dsb();
    cortex_m::asm::isb();
    scb.enable_icache();
    scb.enable_dcache(cpuid);
}

/// Bytes of static RAM in DTCM.
pub fn static_bytes() -> u32 {
    ((&raw const _ram_end).addr() - (&raw const _stack_start).addr()) as u32
}

/// Most bytes the stack has ever taken. cortex-m-rt painted its memory before `main`.
pub fn stack_bytes() -> u32 {
    let (end, start) = (&raw const _stack_end, &raw const _stack_start);
    let words = (start.addr() - end.addr()) / size_of::<u32>();
    // SAFETY: every word of the stack's memory is RAM that nothing but the stack uses; volatile, since the words above the
    // stack pointer are no object of this function.
    let is_painted = |n: &usize| unsafe { end.add(*n).read_volatile() } == cortex_m_rt::STACK_PAINT_VALUE;
    let painted = (0..words).take_while(is_painted).count();
    ((words - painted) * size_of::<u32>()) as u32
}

/// A buffer in a bank that nothing clears at start. Who takes it gets zeros, once.
#[allow(missing_debug_implementations, reason = "bytes without a meaning")]
pub struct Buffer<T>(UnsafeCell<MaybeUninit<T>>);

// SAFETY: the cell is reached by `take` and `put` alone, which hand it out once, to the only thread there is.
unsafe impl<T> Sync for Buffer<T> {}

impl<T> Buffer<T> {
    /// Memory in the section that the static names.
    pub const fn new() -> Self {
        Buffer(UnsafeCell::new(MaybeUninit::uninit()))
    }

    /// Its address, for a DMA controller's register.
    pub fn address(&'static self) -> u32 {
        self.0.get().addr() as u32
    }

    /// The buffer, zeroed; `None` when `taken` says that it is somebody's. `taken` lies in `.bss`, since the buffer's own
    /// bank holds anything at start.
    #[allow(clippy::mut_from_ref, reason = "handed out once")]
    pub fn take(&'static self, taken: &AtomicBool) -> Option<&'static mut T>
    where
        T: Zeroes,
    {
        if taken.swap(true, Ordering::AcqRel) {
            return None;
        }
        // SAFETY: taken once, so this is the only reference; zeros are a value of `T`.
        Some(unsafe {
            let memory = self.0.get();
            memory.write_bytes(0, 1);
            (*memory).assume_init_mut()
        })
    }
}

impl<T> Buffer<T> {
    /// The buffer with a value in it; `None` when `taken` says that it is somebody's.
    #[allow(clippy::mut_from_ref, reason = "handed out once")]
    #[inline(always)]
    pub fn put(&'static self, taken: &AtomicBool, value: impl FnOnce() -> T) -> Option<&'static mut T> {
        if taken.swap(true, Ordering::AcqRel) {
            return None;
        }
        // SAFETY: taken once, so this is the only reference.
        Some(unsafe { (*self.0.get()).write(value()) })
    }
}

impl<T> Default for Buffer<T> {
    fn default() -> Self {
        Buffer::new()
    }
}

/// Types of which all zeros are a value.
///
/// # Safety
/// They are.
pub unsafe trait Zeroes {}
// SAFETY: integers.
unsafe impl<const N: usize> Zeroes for [u8; N] {}
// SAFETY: integers.
unsafe impl<const N: usize> Zeroes for [u32; N] {}
// SAFETY: integers.
unsafe impl<const M: usize, const N: usize> Zeroes for [[u8; M]; N] {}
