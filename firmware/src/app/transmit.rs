//! The outbox, message by message, onto the link.
//!
//! A message is encoded in a statement before the one that waits for the link: so it is gone by then, and the task's memory
//! need not hold it.

use super::{App, FrameOut, Out};
use crate::board::{PerformanceCounters, Timer, Writer};
use crate::wire::outgoing::{self, CHUNK, Encoder};
use crate::wire::telemetry::{Health, InstantReport, MotionReport, StampHealth, Telemetry};
use plumbline_core::motion::image_motion;
use plumbline_core::stamp::Stamper;
use plumbline_core::tilt::Attitude;
use plumbline_core::units::{Micros, Radians};

/// Transmits for ever.
pub async fn transmit(
    app: &App<'_>,
    writer: &mut impl Writer,
    timer: &impl Timer,
    performance: &impl PerformanceCounters,
) -> ! {
    let mut encoder = Encoder::new();
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
            Out::Beat => {
                let bytes = encoder.encode(&outgoing::heartbeat());
                writer.write(bytes).await;
                let bytes = encoder.encode(&outgoing::timesync_request(nanoseconds(timer)));
                writer.write(bytes).await;
                let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Health(health(app, timer, performance))));
                writer.write(bytes).await;
                if let Some(report) = app.plan_report() {
                    let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Plan(report)));
                    writer.write(bytes).await;
                }
            }
            Out::Servo(follow_up) => {
                let bytes = encoder.encode(&outgoing::servo(follow_up));
                writer.write(bytes).await;
            }
            Out::Photo(report) => {
                let bytes = encoder.encode(&outgoing::tunnel(&Telemetry::Photo(report)));
                writer.write(bytes).await;
            }
            Out::Text(severity, line) => {
                let bytes = encoder.encode(&outgoing::status_text(severity, line.0));
                writer.write(bytes).await;
            }
            Out::TimesyncAnswer(theirs) => {
                let bytes = encoder.encode(&outgoing::timesync_answer(nanoseconds(timer), theirs));
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
        }
    }
}

/// Our clock as TIMESYNC wants it; never 0, which would make an answer look like a request.
fn nanoseconds(timer: &impl Timer) -> i64 {
    (timer.now().0 as i64 * 1000).max(1)
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

/// A frame's messages: the fix first, since somebody waits for it.
async fn frame_out(
    app: &App<'_>,
    frame: &FrameOut,
    encoder: &mut Encoder,
    writer: &mut impl Writer,
    timer: &impl Timer,
) {
    if let Some(situation) = &frame.situation {
        let mid = situation.mid_exposure_at;
        if let Some(fix) = &frame.fix {
            let now = app.instant(timer.now()).unwrap_or(mid);
            let bytes = encoder.encode(&outgoing::position_sensor(fix, mid, now));
            writer.write(bytes).await;
        }
        let captured = app.pipeline.with(|pipeline| {
            let georeference = pipeline.tile().georeference();
            let predicted = georeference.geographic(situation.prediction.local);
            let heading = Radians(situation.attitude.heading.0 + georeference.convergence.0).wrapped();
            (frame.fix.map_or(predicted, |fix| fix.position), Attitude { heading, ..situation.attitude })
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
    encoder: &mut Encoder,
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
    encoder: &mut Encoder,
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
