//! The outbox, message by message, onto the link.
//!
//! A message is encoded in a statement before the one that waits for the link: so it is gone by then, and the task's memory
//! need not hold it.

use super::autopilot::{FixMessage, from_true_north};
use super::{App, FrameOut, Out};
use crate::board::{PerformanceCounters, Timer, Writer};
use crate::journal::{Event, Gate};
use crate::wire::fix_message;
use crate::wire::outgoing::{self, CHUNK, Encoder};
use crate::wire::telemetry::{Health, InstantReport, MotionReport, StampHealth, Telemetry};
use plumbline_core::fix::Fix;
use plumbline_core::motion::image_motion;
use plumbline_core::pipeline::Situation;
use plumbline_core::stamp::Stamper;
use plumbline_core::units::{Micros, Radians, Ticks};

/// Transmits for ever.
pub async fn transmit(
    app: &App<'_>,
    writer: &mut impl Writer,
    timer: &impl Timer,
    performance: &impl PerformanceCounters,
) -> ! {
    let mut encoder = Encoder::new(app.speakers.us, app.signing.as_ref());
    let mut picture: Option<Picture> = None;
    loop {
        let Some(out) = app.outbox.take() else {
            match picture.take() {
                Some(unfinished) => picture = piece_out(app, unfinished, &mut encoder, writer).await,
                None => app.outbox.filled().await,
            }
            continue;
        };
        match out {
            Out::Beat => beat_out(app, &mut encoder, writer, timer, performance).await,
            Out::TimesyncRequest => {
                // Stamped as late as can be: how long it waited would pass for the link's asymmetry.
                app.gate(Gate::Asked).await;
                let now = timer.now();
                app.event(Event::Asked(now));
                app.asked_for_time(nanoseconds(now));
                let bytes = encoder.encode(&outgoing::timesync_request(nanoseconds(now), app.speakers.autopilot));
                writer.write(bytes).await;
            }
            Out::Frame(frame) => {
                frame_out(app, &frame, &mut encoder, writer, timer).await;
                if let Some(begun) = announce_picture(app, &frame, &mut encoder, writer).await
                    && picture.replace(begun).is_some()
                {
                    app.count(|c| c.patches_cut += 1);
                }
            }
            short => {
                let bytes = encoded(app, &short, &mut encoder, timer.now());
                writer.write(bytes).await;
            }
        }
    }
}

/// What is one message; nothing for what is several.
fn encoded<'e>(app: &App<'_>, out: &Out, encoder: &'e mut Encoder<'_>, now: Ticks) -> &'e [u8] {
    let autopilot = app.speakers.autopilot;
    match out {
        Out::Ask(ask) => encoder.encode(&ask.command(autopilot)),
        Out::Parameter(name) => encoder.encode(&outgoing::parameter_request(name, autopilot)),
        Out::Acknowledgement(acknowledgement) => encoder.encode(acknowledgement),
        Out::Origin(place, altitude_mm) => encoder.encode(&outgoing::origin(*place, *altitude_mm, autopilot.0)),
        Out::Reference => {
            let velocity = app.autopilot.with(|autopilot| autopilot.fixes.velocity_m_per_s).unwrap_or_default();
            match app.instant(now) {
                Some(now) => encoder.encode(&fix_message::reference(now, velocity)),
                None => &[],
            }
        }
        Out::Servo(follow_up) => encoder.encode(&outgoing::servo(*follow_up, app.speakers.us.0)),
        Out::Photo(report) => encoder.encode(&outgoing::tunnel(&Telemetry::Photo(*report))),
        Out::Exposure(report) => encoder.encode(&outgoing::tunnel(&Telemetry::Exposure(*report))),
        Out::Text(severity, line) => encoder.encode(&outgoing::status_text(*severity, line.0)),
        Out::TimesyncAnswer(theirs) => encoder.encode(&outgoing::timesync_answer(nanoseconds(now), *theirs, autopilot)),
        Out::Beat | Out::TimesyncRequest | Out::Frame(_) => &[],
    }
}

/// Heartbeat, health, how far a plan has been flown, and what signing has refused.
async fn beat_out(
    app: &App<'_>,
    encoder: &mut Encoder<'_>,
    writer: &mut impl Writer,
    timer: &impl Timer,
    performance: &impl PerformanceCounters,
) {
    let bytes = encoder.encode(&outgoing::heartbeat(app.is_ready.get()));
    writer.write(bytes).await;
    let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Health(health(app, timer, performance))));
    writer.write(bytes).await;
    if let Some(report) = app.plan_report() {
        let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Plan(report)));
        writer.write(bytes).await;
    }
    if let Some(refused) = app.refused() {
        let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Signing(refused.into())));
        writer.write(bytes).await;
    }
}

/// Our clock as TIMESYNC wants it; never 0, which would make an answer look like a request.
fn nanoseconds(now: Ticks) -> i64 {
    (now.0 as i64 * 1000).max(1)
}

fn health(app: &App<'_>, timer: &impl Timer, performance: &impl PerformanceCounters) -> Health {
    let (link, counters) = (app.link.get(), app.counters.get());
    let stamps = |stamper: &mut Stamper| StampHealth::new(stamper.counters(), &stamper.clock.state(timer.now()));
    Health {
        messages: link.good,
        bad_checksum: link.bad_checksum,
        unknown_id: link.unknown_id,
        incompatible: link.incompatible,
        skipped_bytes: link.skipped_bytes,
        backwards: counters.backwards,
        invalid: counters.invalid,
        foreign: counters.foreign,
        future: counters.future,
        overruns: performance.overruns(),
        frames_lost: counters.frames_lost,
        patches_cut: counters.patches_cut,
        memory: performance.memory(),
        delays_us: app.pipeline.with(|pipeline| pipeline.streams.delays_us()).unwrap_or_default(),
        stamps: app.stamper.with(stamps).unwrap_or_default(),
    }
}

/// How far the picture moved during a frame's exposure; nothing without a stamp or a pose.
fn motion(app: &App<'_>, frame: &FrameOut) -> Option<MotionReport> {
    let (stamp, situation) = (frame.instant.stamp?, frame.situation.as_ref()?);
    let exposure_us = stamp.halves_us.0.saturating_add(stamp.halves_us.1);
    let camera = app.pipeline.with(|pipeline| pipeline.settings().camera)?;
    image_motion(&camera, &situation.moving(), exposure_us).ok().map(|motion| MotionReport::new(&motion))
}

/// The message of a fix, in the form that the autopilot takes; nothing where none is due.
fn fix_out<'e>(
    app: &App<'_>,
    (fix, situation): (&Fix, &Situation),
    encoder: &'e mut Encoder<'_>,
    now: Ticks,
) -> &'e [u8] {
    let mid = situation.mid_exposure_at;
    let convergence = app.pipeline.with(|pipeline| pipeline.tile().georeference().convergence).unwrap_or(Radians(0.0));
    let attitude = from_true_north(situation.attitude, convergence);
    let message = app.autopilot.with(|autopilot| autopilot.fix_message(fix, (mid, situation.height_m), attitude));
    match message.flatten() {
        Some(FixMessage::Odometry(message)) => encoder.encode(&message),
        Some(FixMessage::VisionPosition(message)) => encoder.encode(&message),
        Some(FixMessage::GlobalPositionSensor(sent, id)) => {
            let now = app.instant(now).unwrap_or(mid);
            encoder.encode(&fix_message::global_position_sensor(&sent, now, id))
        }
        None => &[],
    }
}

/// A frame's messages: the fix first, since somebody waits for it.
async fn frame_out(
    app: &App<'_>,
    frame: &FrameOut,
    encoder: &mut Encoder<'_>,
    writer: &mut impl Writer,
    timer: &impl Timer,
) {
    if let Some(situation) = &frame.situation {
        let mid = situation.mid_exposure_at;
        if let Some(fix) = &frame.fix {
            let bytes = fix_out(app, (fix, situation), encoder, timer.now());
            writer.write(bytes).await;
        }
        let captured = app.pipeline.with(|pipeline| {
            let georeference = pipeline.tile().georeference();
            let predicted = georeference.geographic(situation.prediction.local);
            let attitude = from_true_north(situation.attitude, georeference.convergence);
            (frame.fix.map_or(predicted, |fix| fix.position), attitude)
        });
        let bytes = encoder.encode(&outgoing::camera_trigger(mid, frame.report.sequence));
        writer.write(bytes).await;
        if let Some((position, attitude)) = captured {
            let number = frame.report.sequence;
            let bytes = encoder.encode(&outgoing::image_captured(situation, attitude, position, number));
            writer.write(bytes).await;
        }
    }
    // After the fix, which does not wait for it.
    let instant = InstantReport { motion: motion(app, frame), ..frame.instant };
    let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Instant(instant)));
    writer.write(bytes).await;
    let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Frame(frame.report)));
    writer.write(bytes).await;
    let stamped = frame.instant.stamp.and_then(|stamp| app.photo(Micros(stamp.mid_us), frame.report.sequence));
    if let Some(report) = stamped {
        let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Photo(report)));
        writer.write(bytes).await;
    }
}

/// A patch that is being sent: a piece whenever nothing else waits, since all of it takes longer than a frame's interval.
struct Picture {
    /// Number of the patch.
    number: u32,
    /// The piece that comes next.
    next: u16,
    /// All pieces.
    pieces: u16,
}

/// Announces a frame's patch, where there is one to be sent.
async fn announce_picture(
    app: &App<'_>,
    frame: &FrameOut,
    encoder: &mut Encoder<'_>,
    writer: &mut impl Writer,
) -> Option<Picture> {
    let number = frame.patch.filter(|_| app.send_patches)?;
    let size = app.pipeline.with(|pipeline| pipeline.patch().1)?;
    let bytes = encoder.encode(&outgoing::picture_announcement(size));
    writer.write(bytes).await;
    let pieces = (size.0 as usize * size.1 as usize).div_ceil(CHUNK) as u16;
    Some(Picture { number, next: 0, pieces })
}

/// The next piece; what is left then. Nothing is where a newer patch has taken the buffer.
async fn piece_out(
    app: &App<'_>,
    picture: Picture,
    encoder: &mut Encoder<'_>,
    writer: &mut impl Writer,
) -> Option<Picture> {
    if app.patch.get() != picture.number {
        app.count(|c| c.patches_cut += 1);
        return None;
    }
    let number = picture.next;
    let bytes = app.pipeline.with(|pipeline| {
        let rest = pipeline.patch().0.get(number as usize * CHUNK..).unwrap_or(&[]);
        encoder.encode(&outgoing::picture_piece(number, rest.get(..CHUNK).unwrap_or(rest)))
    });
    writer.write(bytes?).await;
    let next = number + 1;
    (next < picture.pieces).then_some(Picture { next, ..picture })
}
