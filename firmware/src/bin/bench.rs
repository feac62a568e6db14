//! What a frame costs on the emulated board. `cargo xtask budget` runs it and reads what QEMU's plugin counted between
//! the markers. On the real board with this memory map, an MPS2 with AN500, it prints the cycles of each region itself.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
mod board {
    use core::fmt::Arguments;
    use cortex_m::Peripherals;
    use cortex_m_rt::entry;
    use plumbline_core::budget::FRAME_MEMORY_BYTES;
    use plumbline_core::pipeline::Buffers;
    use plumbline_firmware::an500;
    use plumbline_firmware::bench::counter::Counter;
    use plumbline_firmware::bench::poses::Pose;
    use plumbline_firmware::bench::region::Stand;
    use plumbline_firmware::bench::{control, frame, rectify, signing, texture};
    use plumbline_firmware::shared_memory;
    use semihosting::eprintln;
    use static_cell::ConstStaticCell;

    static SPACE: ConstStaticCell<rectify::Space> = ConstStaticCell::new(rectify::Space::new());
    static BUFFERS: ConstStaticCell<Buffers> = ConstStaticCell::new(Buffers::new());

    /// Memory for the largest patch: the board's RAM above what the linker gives away, the upper half of what the flight
    /// computer has as tightly coupled memory.
    const PATCH: usize = 0x2001_0000;
    /// Memory for what is kept of a frame where a case wants more than the board has: memory behind the frame.
    const PLENTY: usize = shared_memory::ADDRESS + 0x10_0000;
    const _: () = assert!(shared_memory::FRAME + 512 * 512 <= 0x10_0000);
    const _: () = assert!(0x10_0000 + rectify::BESIDES_BYTES <= shared_memory::FRAME_MEMORY);

    struct Bench(Option<Counter>);

    impl Stand for Bench {
        fn report(&mut self, line: Arguments<'_>) {
            eprintln!("{line}");
        }

        fn cycles(&mut self) -> Option<u32> {
            self.0.as_ref().map(Counter::now)
        }
    }

    /// Memory of the board that nothing else uses.
    ///
    /// # Safety
    /// Each address is given out once, and no other object lies there.
    unsafe fn memory(address: usize, length: usize) -> &'static mut [u8] {
        // SAFETY: plain memory, valid for any byte; the caller speaks for the rest.
        unsafe { core::slice::from_raw_parts_mut(address as *mut u8, length) }
    }

    #[entry]
    fn main() -> ! {
        let counter = Peripherals::take().and_then(|mut core| Counter::start(&mut core.DCB, &mut core.DWT));
        let mut bench = Bench(counter);
        if bench.0.is_none() {
            eprintln!("bench: this processor counts no cycles");
        }
        let area = |side: u16| usize::from(side) * usize::from(side);
        // SAFETY: no simulator shares the window here, and the pieces do not overlap.
        let (frame, frame_memory, plenty, tile, patch) = unsafe {
            (
                memory(shared_memory::ADDRESS + shared_memory::FRAME, area(frame::FRAME_PX)),
                memory(shared_memory::ADDRESS + shared_memory::FRAME_MEMORY, FRAME_MEMORY_BYTES),
                memory(PLENTY, rectify::BESIDES_BYTES),
                memory(shared_memory::ADDRESS + shared_memory::TILES, area(frame::REACQUISITION.tile_px)),
                memory(PATCH, area(rectify::PATCH_PX)),
            )
        };
        let done = rectifications(&mut bench, frame, patch, [frame_memory, plenty])
            && signing::run(&mut bench)
            && control::run(&mut bench, frame);
        let buffers = BUFFERS.take();
        an500::exit(
            done && frame::CASES.iter().all(|case| frames(case, &mut bench, (frame, tile), (buffers, frame_memory))),
        )
    }

    /// `memory`: what the board has, and plenty.
    fn rectifications(bench: &mut Bench, picture: &mut [u8], patch: &mut [u8], memory: [&mut [u8]; 2]) -> bool {
        texture::checks(picture, usize::from(rectify::FRAME_PX), 1);
        let space = SPACE.take();
        let [frame_memory, plenty] = memory;
        let mut run = |case: &rectify::Case, memory: &mut [u8]| {
            let done = rectify::run(case, bench, (picture, patch, memory), space);
            if let Err(why) = done {
                eprintln!("bench: {} cannot run: {why:?}", case.name);
            }
            done.is_ok()
        };
        rectify::CASES.iter().all(|case| run(case, frame_memory))
            && rectify::BESIDES.iter().all(|case| run(case, plenty))
    }

    fn frames(
        case: &frame::Case,
        bench: &mut Bench,
        (picture, tile): (&mut [u8], &mut [u8]),
        (buffers, frame_memory): (&mut Buffers, &mut [u8]),
    ) -> bool {
        let side = usize::from(case.tile_px);
        let Some(tile) = tile.get_mut(..side * side) else { return false };
        texture::ground(tile, side, 1);
        let (mut accepted, mut poses) = (0, 0);
        for pose in Pose::all() {
            match frame::run(case, &pose, bench, (picture, tile), (&mut *buffers, &mut *frame_memory)) {
                Err(why) => {
                    eprintln!("bench: {pose} is refused: {why:?}");
                    return false;
                }
                Ok(flown) => {
                    poses += 1;
                    accepted += u32::from(flown.is_found());
                }
            }
        }
        eprintln!("bench: {}: {accepted} of {poses} frames have a fix where they were taken", case.name);
        true
    }
}
