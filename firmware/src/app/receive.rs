//! Bytes in, samples out.

use super::{App, Out};
use crate::board::{Reader, Timer};
use crate::journal::Event;
use crate::wire::decoder::Decoder;
use crate::wire::incoming::{Incoming, Unusable, incoming};
use crate::wire::outgoing::{COMPONENT, SYSTEM};
use plumbline_core::pipeline::{FollowUpMode, Instants, SampleError};
use plumbline_core::tilt::{Attitude, follow_up_command};
use plumbline_core::units::{Micros, Radians, Ticks};

/// Least distance of two servo commands, microseconds: 50 Hz.
const SERVO_INTERVAL_US: u32 = 20_000;
/// A clock that is corrected by more than this has begun anew.
const JUMP_US: u32 = 500_000;
/// How long attitudes stamped in milliseconds are ignored after one stamped in microseconds.
const FINE_PREFERRED_US: u32 = 1_000_000;

/// Receives for ever.
pub async fn receive(app: &App<'_>, reader: &mut impl Reader, timer: &impl Timer) -> ! {
    let mut decoder = Decoder::new();
    let mut state = State::default();
    loop {
        let free = decoder.free();
        let count = reader.read(free).await;
        // One reading of the timer for all that these bytes complete.
        let now = timer.now();
        app.event(Event::Bytes(now, free.get(..count).unwrap_or(&[])));
        decoder.filled(count);
        while let Some(packet) = decoder.next() {
            match incoming(&packet, (SYSTEM, COMPONENT)) {
                Ok(message) => state.take(app, message, now),
                Err(Unusable::Invalid) => app.count(|c| c.invalid += 1),
                Err(Unusable::NotOurs) => {}
            }
        }
        app.link.set(decoder.counters());
    }
}

/// When the last of each was.
#[derive(Default)]
struct State {
    fine: Option<Micros>,
    servo: Option<Micros>,
}

impl State {
    fn take(&mut self, app: &App<'_>, message: Incoming, now: Ticks) {
        let arrived_at = app.instant(now);
        let instants = |sampled_at| Instants { sampled_at, arrived_at };
        let result = match message {
            Incoming::Attitude(at, attitude) => {
                self.fine = Some(at);
                Some(self.attitude(app, instants(at), attitude))
            }
            Incoming::CoarseAttitude(at, attitude) => {
                // Unsigned: after the autopilot has booted anew its stamps lie far before the last.
                if self.fine.is_some_and(|fine| at.since(fine).unsigned_abs() < FINE_PREFERRED_US) {
                    return;
                }
                Some(self.attitude(app, instants(at), attitude))
            }
            Incoming::FollowUp(at, angle) => app.pipeline.with(|p| p.streams.follow_up(instants(at), angle)),
            Incoming::Slant(at, slant) => app.pipeline.with(|p| p.streams.slant(instants(at), slant)),
            Incoming::Position(sample) => {
                let taken = app.pipeline.with(|p| p.position(sample, arrived_at));
                app.look_for_exposure(now);
                taken
            }
            Incoming::Timesync { sent_ns, theirs } => {
                let sent = Ticks((sent_ns / 1000) as u32);
                app.stamper.with(|stamper| stamper.clock.on_timesync(sent, theirs, now));
                // A clock that jumps is another one: the autopilot has booted anew.
                let has_jumped = |(before, after): (Micros, Micros)| after.since(before).unsigned_abs() > JUMP_US;
                if arrived_at.zip(app.instant(now)).is_some_and(has_jumped) {
                    app.pipeline.with(|p| p.streams.clear());
                    *self = State::default();
                }
                Some(Ok(()))
            }
            Incoming::Armed(is_armed) => {
                app.armed.set(Some(is_armed));
                Some(Ok(()))
            }
            Incoming::TimesyncRequest { theirs_ns } => {
                app.outbox.put(Out::TimesyncAnswer(theirs_ns));
                Some(Ok(()))
            }
        };
        match result {
            Some(Ok(())) => app.fresh.signal(()),
            Some(Err(SampleError::Backwards)) => app.count(|c| c.backwards += 1),
            Some(Err(SampleError::Invalid)) | None => app.count(|c| c.invalid += 1),
        }
    }

    /// Headings arrive relative to true north and are kept relative to the tile's grid north. Every attitude may move
    /// the servo: its command depends on nothing else.
    fn attitude(&mut self, app: &App<'_>, instants: Instants, attitude: Attitude) -> Result<(), SampleError> {
        let taken = app.pipeline.with(|pipeline| {
            let convergence = pipeline.tile().georeference().convergence;
            let heading = Radians(attitude.heading.0 - convergence.0).wrapped();
            let attitude = Attitude { heading, ..attitude };
            pipeline.streams.attitude(instants, attitude).map(|()| (attitude, pipeline.settings().follow_up))
        });
        let (attitude, follow_up) = taken.unwrap_or(Err(SampleError::Invalid))?;
        let at = instants.sampled_at;
        let due = self.servo.is_none_or(|last| at.since(last).unsigned_abs() >= SERVO_INTERVAL_US);
        if due && follow_up != FollowUpMode::Fixed {
            self.servo = Some(at);
            let command = follow_up_command(attitude);
            app.servo.set(Some(command));
            app.outbox.put(Out::Servo(command));
        }
        Ok(())
    }
}
