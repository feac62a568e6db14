//! What happens by the clock: heartbeat and time request once a second; requests to the autopilot, patience and tidying of
//! stamps ten times.

use super::{App, Out};
use crate::board::Timer;
use crate::journal::{Event, Gate};
use plumbline_core::units::Ticks;

const INTERVAL_TICKS: u32 = 100_000;
const BEATS_PER_SECOND: u32 = 10;

/// Beats for ever. A frame that waits for a pose that never comes checks its patience on each beat.
pub async fn beat(app: &App<'_>, timer: &mut impl Timer) -> ! {
    app.gate(Gate::Beat).await;
    let mut now = timer.now();
    let mut at = now;
    let mut count = 0u32;
    loop {
        app.event(Event::Beat(now));
        app.advance_stamps(now);
        let place = count % BEATS_PER_SECOND;
        app.ask_autopilot(now, place);
        if place == 0 {
            app.outbox.put(Out::Beat);
        }
        app.stamper.with(|stamper| stamper.keep(now));
        app.fresh.signal(());
        count = count.wrapping_add(1);
        at = Ticks(at.0.wrapping_add(INTERVAL_TICKS));
        timer.until(at).await;
        now = timer.now();
    }
}
