//! What is asked on the truth's connection in flight, and what passes between firmware and autopilot.

use super::{Flying, taken};
use crate::live::LiveError;
use crate::live::messages::Said;

/// Between two TIMESYNC requests, seconds: some 20 a second, and no multiple of a simulator's steps.
const SYNC_S: f64 = 0.047;
/// Between two heartbeats of ours, seconds.
const BEAT_S: f64 = 1.0;
/// Requests without an answer that are remembered.
const ASKED_MAX: usize = 64;

impl Flying<'_> {
    /// Asks for the time and says that we are there, each when it is due.
    pub(super) fn talk(&mut self, wall_s: f64) -> Result<(), LiveError> {
        if wall_s >= self.next_beat_s {
            self.next_beat_s = wall_s + BEAT_S;
            let beat = self.speaker.heartbeat();
            self.truth_end.send(&beat)?;
        }
        if wall_s >= self.next_sync_s {
            self.next_sync_s = wall_s + SYNC_S;
            let stamp = (wall_s * 1e9) as i64;
            let request = self.speaker.timesync(stamp);
            self.remember(0, stamp, wall_s);
            self.truth_end.send(&request)?;
        }
        Ok(())
    }

    /// Notes a TIMESYNC request, ours (0) or the firmware's (1).
    fn remember(&mut self, whose: usize, stamp: i64, wall_s: f64) {
        let asked = &mut self.asked[whose];
        asked.push_back((stamp, wall_s));
        if asked.len() > ASKED_MAX {
            asked.pop_front();
        }
    }

    /// Takes what the firmware sent that concerns us: its questions for the time, and what its servo is to do.
    pub(super) fn heard_from_firmware(&mut self) {
        let wall_s = self.wall_s(std::time::Instant::now());
        for stamp in std::mem::take(&mut self.station.timesync) {
            self.remember(1, stamp, wall_s);
        }
        for angle in std::mem::take(&mut self.station.servo) {
            self.commands.push((self.now_us, angle));
        }
        std::mem::take(&mut self.station.exposures).into_iter().for_each(|command| self.exposures.command(command));
        self.station.due.clear();
        self.station.commands.clear();
    }

    /// Looks at what the autopilot tells the firmware. The answers to the firmware's own questions are compared with the
    /// relation: what it is off by is what the firmware cannot know. Attitudes are timed.
    pub(super) fn overheard(&mut self, bytes: &[u8], wall_s: f64) {
        let mut said = Vec::new();
        self.listeners[1].take(bytes, &mut said);
        for said in said {
            let stamp = match &said {
                Said::Attitude(time_boot_ms, _) => Some((0, f64::from(*time_boot_ms) * 1000.0)),
                Said::GimbalAttitude(stamp_us) => Some((1, *stamp_us as f64)),
                _ => None,
            };
            if let Some(((kind, stamp_us), arrived_us)) = stamp.zip(self.clock.at(wall_s)) {
                self.attitudes[kind].push([stamp_us, arrived_us]);
            }
            let Said::Timesync { sent_ns, theirs_us } = said else { continue };
            let Some(sent_s) = taken(&mut self.asked[1], sent_ns) else { continue };
            let Some(ours_us) = self.clock.at(0.5 * (sent_s + wall_s)) else { continue };
            self.exchanges.push((1e6 * (wall_s - sent_s), ours_us - theirs_us));
        }
    }
}
