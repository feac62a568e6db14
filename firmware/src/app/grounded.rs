//! What a vehicle does whose stores were refused: it says so, and nothing else.
//!
//! Instead of the application's tasks two run: [`drain`] reads the link and drops it, [`report`] sends once a second a
//! heartbeat of state CRITICAL, and every five seconds the reason as STATUSTEXT, and what else the board has to report. No
//! frame is read and no servo is moved.

use super::Line;
use crate::board::{Reader, Timer, Writer};
use crate::shared::Shared;
use crate::wire::outgoing::{self, COMPONENT, Encoder, SYSTEM};
use crate::wire::signing::Signing;
use mavlink::dialects::common::MavSeverity;
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

/// Tells for ever: the reason in two parts, as [`BootError::words`](crate::boot::BootError::words) has it, and the board's
/// own notices; signed where there is a key.
pub async fn report(
    reason: [&'static str; 2],
    notices: &[(MavSeverity, Line)],
    signing: Option<Signing>,
    writer: &mut impl Writer,
    timer: &mut impl Timer,
) -> ! {
    let signing = signing.map(Shared::new);
    let mut encoder = Encoder::new((SYSTEM, COMPONENT), signing.as_ref());
    let mut at = timer.now();
    let mut count = 0u32;
    loop {
        signing.iter().for_each(|signing| {
            signing.with(|signing| signing.advance(timer.now()));
        });
        let bytes = encoder.encode(&outgoing::grounded_heartbeat());
        writer.write(bytes).await;
        if count.is_multiple_of(REASON_EVERY) {
            let [what, why] = reason;
            let line = Line::of(["no fixes: ", what, why]);
            let bytes = encoder.encode(&outgoing::status_text(MavSeverity::MAV_SEVERITY_CRITICAL, line.0));
            writer.write(bytes).await;
            for (severity, line) in notices {
                let bytes = encoder.encode(&outgoing::status_text(*severity, line.0));
                writer.write(bytes).await;
            }
        }
        count = count.wrapping_add(1);
        at = Ticks(at.0.wrapping_add(SECOND_TICKS));
        timer.until(at).await;
    }
}
