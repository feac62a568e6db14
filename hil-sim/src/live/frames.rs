//! Exposures on the autopilot's clock, and the thread that makes their pictures.

use crate::camera::render::Rendered;
use crate::noise::{stream, uniform};
use crate::run::picture;
use crate::scenario::Scenario;
use crate::setup::Setup;
use crate::vehicle::motion::{Recorded, TrueState, recorded};
use crate::vehicle::mount::antenna;
use crate::vehicle::sensors::{Exposure, LineEdge, Shutter, ShutterLine};
use plumbline_firmware::wire::telemetry::ExposureReport;
use rand_chacha::ChaCha12Rng;
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender};

/// Exposures under way at most, from the shutter to the delivery. Chosen: one that waits for its truth, one that is rendered.
const UNDER_WAY_MAX: usize = 2;

/// The camera's shutter, which opens at intervals of the autopilot's clock.
#[derive(Debug)]
pub struct Exposures {
    shutter: Shutter,
    line: ShutterLine,
    late: ChaCha12Rng,
    interval_us: f64,
    jitter_us: f64,
    /// When the next interval begins, and when within it the shutter opens; nothing before the flight.
    next: Option<(f64, u64)>,
    count: u32,
    /// Edges still to come.
    edges: VecDeque<LineEdge>,
    /// Not made, since too many were under way or the clock had gone past them.
    pub dropped: u32,
}

impl Exposures {
    /// The scenario's.
    pub fn new(scenario: &Scenario) -> Self {
        Exposures {
            shutter: Shutter::new(scenario),
            line: ShutterLine::new(scenario),
            late: stream(scenario.run.seed, "shutter"),
            interval_us: scenario.run.frame_interval_us() as f64,
            jitter_us: f64::from(scenario.run.frame_jitter_us),
            next: None,
            count: 0,
            edges: VecDeque::new(),
            dropped: 0,
        }
    }

    /// Takes a command of the firmware.
    pub fn command(&mut self, command: ExposureReport) {
        self.shutter.command(command);
    }

    /// Made so far.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Begins at `now_us`.
    pub fn begin(&mut self, now_us: f64) {
        if self.next.is_none() {
            self.next = Some(self.within(now_us));
        }
    }

    /// Whether it has begun.
    pub fn has_begun(&self) -> bool {
        self.next.is_some()
    }

    fn within(&mut self, begin_us: f64) -> (f64, u64) {
        (begin_us, (begin_us + self.jitter_us * uniform(&mut self.late)).max(0.0) as u64)
    }

    /// The exposure whose shutter has opened by `now_us`, while `under_way` others are on their way to the board.
    pub fn opened(&mut self, scenario: &Scenario, now_us: f64, under_way: usize) -> Option<Exposure> {
        loop {
            let (begin_us, open_us) = self.next.filter(|(_, open_us)| *open_us as f64 <= now_us)?;
            self.next = Some(self.within(begin_us + self.interval_us));
            // One that is whole intervals old belongs to a clock that stood still for us.
            if under_way >= UNDER_WAY_MAX || now_us - open_us as f64 > self.interval_us {
                self.dropped += 1;
                continue;
            }
            let exposure = self.shutter.expose(self.count, open_us);
            self.count += 1;
            self.line.add_edges(scenario, &exposure, &mut self.edges);
            return Some(exposure);
        }
    }

    /// The next edge that the board has seen by `now_us`.
    pub fn edge(&mut self, now_us: f64) -> Option<LineEdge> {
        self.edges.pop_front_if(|edge| edge.seen_us() as f64 <= now_us)
    }
}

/// Where the camera is on a vehicle in `state`, whose antenna's place it says: as far from the antenna as [`antenna`] has it.
pub fn camera_of(state: &TrueState, setup: &Setup) -> TrueState {
    let [east_m, north_m, up_m] = antenna(state, &setup.payload.mount);
    TrueState {
        east_m: 2.0 * state.east_m - east_m,
        north_m: 2.0 * state.north_m - north_m,
        up_m: 2.0 * state.up_m - up_m,
        ..*state
    }
}

/// What a picture is made of.
#[derive(Clone, Debug)]
pub struct Job {
    /// Its exposure.
    pub exposure: Exposure,
    /// The antenna's truth around it.
    pub samples: Vec<Recorded>,
    /// The camera against the body.
    pub follow_up_rad: f64,
}

impl Job {
    /// The camera at an instant of the exposure.
    pub fn state(&self, at_us: f64, setup: &Setup) -> Option<TrueState> {
        let state = recorded(&self.samples, at_us)?;
        Some(camera_of(&TrueState { follow_up_rad: self.follow_up_rad, ..state }, setup))
    }

    /// The instants that its rows are taken at: the first and the last.
    pub fn span_us(exposure: &Exposure, setup: &Setup) -> [f64; 2] {
        let half_us = 0.5 * (exposure.close_us - exposure.open_us) as f64;
        let rows_us = 0.5 * setup.scenario.vehicle.rolling_shutter_us() as f64;
        let mid_us = exposure.mid_exact_us();
        [mid_us - half_us - rows_us - 1.0, mid_us + half_us + rows_us + 1.0]
    }
}

/// A picture, and where it was really taken.
#[derive(Clone, Debug)]
pub struct Made {
    /// Its exposure.
    pub exposure: Exposure,
    /// The camera at mid-exposure.
    pub truth: TrueState,
    /// The picture.
    pub rendered: Rendered,
}

/// Makes pictures until no more jobs come.
pub fn make(setup: &Setup, jobs: &Receiver<Job>, made: &Sender<Made>) {
    while let Ok(job) = jobs.recv() {
        let Some(truth) = job.state(job.exposure.mid_us() as f64, setup) else { continue };
        // The samples cover the exposure; what is rounded beyond them is mid-exposure.
        let state = |at_us: u64| job.state(at_us as f64, setup).unwrap_or(truth);
        let rendered = picture(setup, &job.exposure, &state);
        if made.send(Made { exposure: job.exposure, truth, rendered }).is_err() {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All that is opened up to `to_us` in steps of 2 ms.
    fn opened(exposures: &mut Exposures, [from_us, to_us]: [f64; 2], under_way: usize) -> Vec<Exposure> {
        let scenario = Scenario::default();
        let mut found = Vec::new();
        let mut now_us = from_us;
        while now_us < to_us {
            found.extend(exposures.opened(&scenario, now_us, under_way));
            now_us += 2000.0;
        }
        found
    }

    #[test]
    fn exposures_come_at_intervals_with_their_edges() {
        let mut exposures = Exposures::new(&Scenario::default());
        assert!(opened(&mut exposures, [0.0, 1e6], 0).is_empty() && !exposures.has_begun());
        exposures.begin(7e6);
        let found = opened(&mut exposures, [7e6, 9.9e6], 0);
        assert_eq!((found.len(), exposures.count(), exposures.dropped), (12, 12, 0));
        for (index, exposure) in found.iter().enumerate() {
            let late_us = exposure.open_us as f64 - 7e6 - 250_000.0 * index as f64;
            assert!(exposure.frame == index as u32 && (0.0..5000.0).contains(&late_us), "{exposure:?}");
        }
        let edges: Vec<LineEdge> = std::iter::from_fn(|| exposures.edge(9.9e6)).collect();
        assert!(edges.len() == 24 && edges.is_sorted_by(|a, b| a.at_us <= b.at_us));
        assert!((edges[0].at_us - found[0].open_us as f64).abs() < 10.0 && edges[0].rising && !edges[1].rising);
    }

    #[test]
    fn what_cannot_be_made_in_time_is_dropped_and_counted() {
        let mut exposures = Exposures::new(&Scenario::default());
        exposures.begin(0.0);
        assert!(opened(&mut exposures, [0.0, 0.9e6], UNDER_WAY_MAX).is_empty());
        assert_eq!((exposures.dropped, exposures.count()), (4, 0));
        // The clock jumps by three seconds: what lies before is not made up for.
        let found = opened(&mut exposures, [4e6, 4.6e6], 0);
        assert_eq!((found.len(), found[0].frame), (4, 0));
        assert!(found[0].open_us >= 3_750_000 && exposures.dropped == 15, "{found:?} {}", exposures.dropped);
    }
}
