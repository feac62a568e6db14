//! What the capture timer latches: the shutter's edges and the pulses per second.

use super::App;
use crate::board::Timer;
use crate::journal::Event;

/// Takes the shutter's edges for ever. Those of no use are counted where they are refused.
pub async fn edges(app: &App<'_>, timer: &mut impl Timer) -> ! {
    loop {
        let edge = timer.edge().await;
        app.event(Event::Edge(edge));
        let _ = app.stamper.with(|stamper| stamper.on_edge(edge));
    }
}

/// Takes pulses per second for ever.
pub async fn pulses(app: &App<'_>, timer: &mut impl Timer) -> ! {
    loop {
        let tick = timer.pulse().await;
        app.event(Event::Pulse(tick));
        app.stamper.with(|stamper| stamper.clock.on_pulse(tick));
    }
}
