//! The simulator's line on UART 0, for an image that is fed by nothing else.

use super::{stack, time_driver, uart};
use crate::board;
use crate::serial::front_end::LineFrontEnd;
use crate::serial::wires::{Port, Wires};

/// Both ends of the line.
#[derive(Clone, Copy, Debug)]
pub struct Uart;

impl board::Reader for Uart {
    async fn read(&mut self, buffer: &mut [u8]) -> usize {
        uart::read(buffer).await
    }
}

impl board::Writer for Uart {
    async fn write(&mut self, bytes: &[u8]) {
        uart::write(bytes);
    }
}

/// Instructions, and the wires' overruns.
#[derive(Clone, Copy)]
#[allow(missing_debug_implementations, reason = "holds wires")]
pub struct LineCounters(pub &'static Wires);

impl board::PerformanceCounters for LineCounters {
    fn counted<R>(&self, work: impl FnOnce() -> R) -> (R, u32) {
        time_driver::measured(work)
    }

    fn overruns(&self) -> u32 {
        self.0.overruns()
    }

    fn memory(&self) -> (u32, u32) {
        (stack::static_bytes(), stack::high_water_bytes())
    }
}

/// The board behind the line.
#[derive(Clone, Copy, Debug)]
pub struct OnLine;

impl board::Board for OnLine {
    type FrontEnd = LineFrontEnd;
    type Reader = Port;
    type Writer = Port;
    type Timer = Port;
    type Counters = LineCounters;
}

/// Boots anew; memory stays as it is.
pub fn reboot() -> ! {
    cortex_m::peripheral::SCB::sys_reset()
}
