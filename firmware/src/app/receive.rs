//! Bytes in, samples out.

use super::autopilot::{Autopilot, Kind};
use super::{App, Armed, Out};
use crate::board::{Reader, Timer};
use crate::journal::Event;
use crate::wire::boot_time::BootTime;
use crate::wire::decoder::{Decoder, Packet};
use crate::wire::incoming::{Gnss, Incoming, Unusable, incoming};
use crate::wire::signing::Verdict;
use plumbline_core::pipeline::{Arrival, FollowUpMode, Instants, SampleError};
use plumbline_core::tilt::{Attitude, approximate_follow_up_command, follow_up_command};
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
        app.advance_stamps(now);
        decoder.filled(count);
        let mut number = 0u8;
        while let Some(packet) = decoder.next() {
            let verdict = judge(app, &packet, number);
            number = number.wrapping_add(1);
            if verdict != Verdict::Taken {
                continue;
            }
            match incoming(&packet, &app.speakers) {
                Ok(message) => state.take(app, message, now),
                Err(Unusable::Invalid) => app.count(|c| c.invalid += 1),
                Err(Unusable::Foreign) => app.count(|c| c.foreign += 1),
                Err(Unusable::NotOurs) => {}
            }
        }
        app.link.set(decoder.counters());
    }
}

/// A position of satellite navigation, which frames do not wait for.
fn satellites(app: &App<'_>, gnss: &Gnss, now: Ticks) {
    let map_sigma_m = app.autopilot.with(|autopilot| autopilot.fixes.map_sigma_m());
    let (Some((place, sigma_m)), Some(map_sigma_m), Some(arrival)) = (gnss.place, map_sigma_m, app.arrival(now)) else {
        return;
    };
    let sampled_at = gnss.at.unwrapped(arrival.at);
    let at = Instants { sampled_at, stamp_sigma_us: gnss.at.sigma_us(), arrival: Some(arrival) };
    if let Some(Err(why)) = app.pipeline.with(|pipeline| pipeline.satellites(at, place, [sigma_m, map_sigma_m])) {
        app.not_taken(why);
    }
}

/// What is to be done with the packet that is this one, from 0, of those that a read completed. Without a key all are taken; a
/// replay, which has none, is told by its log.
fn judge(app: &App<'_>, packet: &Packet<'_>, number: u8) -> Verdict {
    let own = match &app.signing {
        // Used within another use it would tell nothing, and what is not known to be good is not taken.
        Some(signing) => signing.with(|signing| signing.judge(packet)).unwrap_or(Verdict::Wrong),
        None => Verdict::Taken,
    };
    app.journal.verdict(number, own)
}

impl App<'_> {
    /// Counts a sample that was not taken.
    fn not_taken(&self, why: SampleError) {
        self.count(|c| match why {
            SampleError::Backwards => c.backwards += 1,
            SampleError::Invalid => c.invalid += 1,
            SampleError::Future => c.future += 1,
        });
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
        app.autopilot.with(|autopilot| autopilot.heard(&message, now));
        match message {
            Incoming::Timesync { sent_ns, theirs } => self.timesync(app, sent_ns, theirs, now),
            Incoming::TimesyncRequest { theirs_ns } => app.outbox.put(Out::TimesyncAnswer(theirs_ns)),
            Incoming::Heartbeat(heartbeat) => {
                let is_armed = heartbeat.is_armed;
                // With a key nothing comes this far that is not signed.
                app.armed.set(Some(Armed { is_armed, is_signed: app.signing.is_some() }));
                app.was_armed.set(app.was_armed.get() || is_armed);
            }
            Incoming::Gnss(gnss) => satellites(app, &gnss, now),
            Incoming::Origin(_) | Incoming::Acknowledged(..) | Incoming::Parameter(_) => {}
            Incoming::Ordered(order, by) => app.ordered(order, by),
            sample => {
                // Without a clock nobody knows which wrap of its counter a stamp belongs to, and no frame has a stamp.
                let Some(arrival) = app.arrival(now) else { return };
                match self.sample(app, sample, arrival, now) {
                    Ok(()) => {
                        app.look_for_exposure(now);
                        app.fresh.signal(());
                    }
                    Err(why) => app.not_taken(why),
                }
            }
        }
    }

    /// An answer to a request of ours; anybody else's says nothing of our clock.
    fn timesync(&mut self, app: &App<'_>, sent_ns: i64, theirs: Micros, now: Ticks) {
        if app.autopilot.with(|autopilot| autopilot.answers(sent_ns)) != Some(true) {
            app.count(|c| c.foreign += 1);
            return;
        }
        let before = app.instant(now);
        let sent = Ticks((sent_ns / 1000) as u32);
        app.stamper.with(|stamper| stamper.clock.on_timesync(sent, theirs, now));
        // A clock that jumps is another one: the autopilot has booted anew.
        let has_jumped = |(before, after): (Micros, Micros)| after.since(before).unsigned_abs() > JUMP_US;
        if before.zip(app.instant(now)).is_some_and(has_jumped) {
            app.pipeline.with(|p| p.streams.clear());
            app.autopilot.with(Autopilot::has_rebooted);
            *self = State::default();
        }
        app.fresh.signal(());
    }

    fn sample(&mut self, app: &App<'_>, message: Incoming, arrival: Arrival, now: Ticks) -> Result<(), SampleError> {
        let instants = |stamp: BootTime| Instants {
            sampled_at: stamp.unwrapped(arrival.at),
            stamp_sigma_us: stamp.sigma_us(),
            arrival: Some(arrival),
        };
        let taken = match message {
            Incoming::Attitude(stamp, attitude) => {
                let at = instants(stamp);
                // Unsigned: after the autopilot has booted anew its stamps lie far before the last.
                let has_finer = |fine: Micros| at.sampled_at.since(fine).unsigned_abs() < FINE_PREFERRED_US;
                if let BootTime::Millis(_) = stamp
                    && self.fine.is_some_and(has_finer)
                {
                    return Ok(());
                }
                self.attitude(app, at, attitude)?;
                if let BootTime::Micros(_) = stamp {
                    self.fine = Some(at.sampled_at);
                }
                app.autopilot.with(|autopilot| autopilot.taken(Kind::Attitude, now));
                return Ok(());
            }
            Incoming::FollowUp(stamp, angle) => app.pipeline.with(|p| p.streams.follow_up(instants(stamp), angle)),
            Incoming::Slant(stamp, slant) => app.pipeline.with(|p| p.streams.slant(instants(stamp), slant)),
            Incoming::Position(..) if app.autopilot.with(|autopilot| autopilot.is_at_start()) == Some(true) => {
                Some(Ok(()))
            }
            Incoming::Position(stamp, sample) => {
                let taken = app.pipeline.with(|p| p.position(instants(stamp), sample).map(|()| p.is_on_the_map()));
                if let Some(Ok(true)) = taken {
                    app.autopilot.with(|autopilot| autopilot.taken(Kind::Position, now));
                }
                taken.map(|taken| taken.map(|_| ()))
            }
            Incoming::Down(stamp, down_m) => {
                let at = instants(stamp).sampled_at;
                app.autopilot.with(|autopilot| autopilot.fixes.down(at, down_m));
                Some(Ok(()))
            }
            _ => Some(Ok(())),
        };
        taken.unwrap_or(Err(SampleError::Invalid))
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
            // Where the axis is not read, the rectification takes it to be where the command has it.
            let command = match follow_up {
                FollowUpMode::Measured => approximate_follow_up_command(attitude),
                _ => follow_up_command(attitude),
            };
            app.servo.set(Some(command));
            app.outbox.put(Out::Servo(command));
        }
        Ok(())
    }
}
