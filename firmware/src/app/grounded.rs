//! What a vehicle does whose stores were refused: it says so, and nothing else.
//!
//! Instead of the application's tasks two run: [`drain`] reads the link and drops it, [`tell`] sends once a second a
//! heartbeat of state CRITICAL, and every five seconds the reason as STATUSTEXT. No frame is looked at and no servo is
//! moved.

use crate::board::{Reader, Timer, Writer};
use crate::boot::BootError;
use crate::wire::outgoing::{self, Encoder};
use plumbline_core::units::Ticks;

const SECOND_TICKS: u32 = 1_000_000;
/// Seconds from one telling of the reason to the next.
const REASON_EVERY: u32 = 5;

/// Reads and drops for ever.
pub async fn drain(reader: &mut impl Reader) -> ! {
    let mut buffer = [0; 64];
    loop {
        reader.read(&mut buffer).await;
    }
}

/// Tells for ever.
pub async fn tell(reason: BootError, writer: &mut impl Writer, timer: &mut impl Timer) -> ! {
    let mut encoder = Encoder::new();
    let mut at = timer.now();
    let mut count = 0u32;
    loop {
        writer.write(encoder.encode(&outgoing::grounded_heartbeat())).await;
        if count.is_multiple_of(REASON_EVERY) {
            let [store, why] = reason.words();
            writer.write(encoder.encode(&outgoing::critical(["no fixes: ", store, why]))).await;
        }
        count = count.wrapping_add(1);
        at = Ticks(at.0.wrapping_add(SECOND_TICKS));
        timer.until(at).await;
    }
}
