//! A shutter, a timer with a crystal of its own, pulses and frames, in double precision and apart from the simulator's.

use plumbline_core::stamp::{
    ClockSettings, Edge, KnownExposure, Polarity, ShutterSettings, Stamp, StampSettings, StampSource, Stamper, Wired,
};
use plumbline_core::units::{Micros, Ticks};
use plumbline_tests::seeded::Random;

/// The autopilot's clock when the board starts.
pub const BOOT_US: f64 = 61e6;

/// One frame's stamp against the truth.
#[derive(Clone, Copy, Debug)]
pub struct Flown {
    pub error_us: f64,
    pub sigma_us: f64,
    pub source: StampSource,
    /// True length of its exposure.
    pub length_us: f64,
}

pub fn rms(flown: &[Flown]) -> f64 {
    (flown.iter().map(|f| f.error_us * f.error_us).sum::<f64>() / flown.len() as f64).sqrt()
}

pub fn nees(flown: &[Flown]) -> f64 {
    flown.iter().map(|f| (f.error_us / f.sigma_us).powi(2)).sum::<f64>() / flown.len() as f64
}

/// What a flight is like. Sigmas in microseconds are told to the core, faults are not.
#[derive(Clone, Copy, Debug)]
pub struct World {
    pub settings: StampSettings,
    pub drift_ppm: f64,
    /// No pulse from this second on.
    pub pulses_until_s: u32,
    /// Whether TIMESYNC goes on after its first exchange.
    pub timesync: bool,
    /// Shares.
    pub lost_edges: f64,
    pub extra_edges: f64,
    pub lost_frames: f64,
}

pub const SETTINGS: StampSettings = StampSettings {
    exposure: None,
    shutter: ShutterSettings {
        wired: Wired::Both,
        opens_on: Polarity::Falling,
        open_delay_us: 35,
        close_delay_us: 20,
        hold_off_us: 100,
        edge_sigma_us: 1.0,
        exposure: Some(KnownExposure { us: 5000, sigma_us: 20.0 }),
        readout_us: 800,
        arrival_sigma_us: 40.0,
    },
    clock: ClockSettings {
        pulse_sigma_us: 0.5,
        rate_sigma_ppm: 30.0,
        rate_walk_ppm: 0.02,
        timesync_sigma_us: 100.0,
        sigma_max_us: 5000.0,
    },
};

impl Default for World {
    fn default() -> Self {
        World {
            settings: SETTINGS,
            drift_ppm: 20.0,
            pulses_until_s: u32::MAX,
            timesync: true,
            lost_edges: 0.02,
            extra_edges: 0.02,
            lost_frames: 0.02,
        }
    }
}

impl World {
    fn wired(wired: Wired) -> Self {
        let mut world = World::default();
        world.settings.shutter.wired = wired;
        world.settings.shutter.exposure = Some(KnownExposure { us: 5000, sigma_us: 120.0 });
        world
    }

    pub fn opening() -> Self {
        World::wired(Wired::Opening)
    }

    pub fn closing() -> Self {
        World::wired(Wired::Closing)
    }

    pub fn arrival() -> Self {
        World::wired(Wired::None)
    }

    /// The stamps of a flight of `frames` frames, four a second, from the fourth second on. The timer wraps in it.
    pub fn fly(&self, seed: u64, frames: u32) -> Vec<Flown> {
        let mut random = Random::new(seed);
        let instants: Vec<f64> =
            (0..frames).map(|frame| 4e6 + 250e3 * f64::from(frame) + 5e3 * random.uniform()).collect();
        self.run(&mut random, &instants)
    }

    /// The stamp of one frame, `at_s` seconds into a flight of its own.
    pub fn one_at(&self, seed: u64, at_s: f64) -> Vec<Flown> {
        let mut random = Random::new(seed);
        let at_us = (at_s + random.uniform()) * 1e6;
        self.run(&mut random, &[at_us])
    }

    fn run(&self, random: &mut Random, opens: &[f64]) -> Vec<Flown> {
        assert_eq!(self.settings.check(), Ok(()));
        let shutter = &self.settings.shutter;
        let end_us = opens.last().map_or(0.0, |open| open + 1e6);
        let timer = Timer::new(random, self.drift_ppm, self.settings.clock.rate_walk_ppm.into(), end_us);
        let mut events = Vec::new();
        let known = shutter.exposure.expect("told");
        for &open in opens {
            let length = f64::from(known.us) + f64::from(known.sigma_us) * random.normal();
            for (moved, opens) in [(open, true), (open + length, false)] {
                let late = f64::from(shutter.delay_us(opens)) + f64::from(shutter.edge_sigma_us) * random.normal();
                if random.uniform() >= self.lost_edges {
                    events.push((moved + late, Event::Edge(opens)));
                }
                if random.uniform() < self.extra_edges {
                    fault(random, moved + late, opens, &mut events);
                }
            }
            let off = f64::from(shutter.arrival_sigma_us) * random.normal().clamp(-4.0, 4.0);
            if random.uniform() >= self.lost_frames {
                events.push((open + length + f64::from(shutter.readout_us) + off, Event::Frame { open, length }));
            }
        }
        for second in 1..(end_us * 1e-6) as u32 {
            if second < self.pulses_until_s {
                let jitter = f64::from(self.settings.clock.pulse_sigma_us) * random.normal();
                events.push((f64::from(second) * 1e6 + jitter, Event::Pulse));
            }
            if self.timesync {
                // Up to 10 ms longer than the quickest, either way.
                let ways = [(); 2].map(|()| 1500.0 + 10_000.0 * random.uniform() * random.uniform());
                events.push((f64::from(second) * 1e6 + 300_000.0, Event::Timesync(ways)));
            }
        }
        events.push((300.0, Event::Timesync([1500.0; 2])));
        events.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.deliver(&timer, &events)
    }

    fn deliver(&self, timer: &Timer, events: &[(f64, Event)]) -> Vec<Flown> {
        let opens_rising = self.settings.shutter.opens_on == Polarity::Rising;
        let mut stamper = Stamper::new(&self.settings);
        let mut flown = Vec::new();
        for &(at_us, event) in events {
            let tick = timer.latch(at_us);
            stamper.keep(tick);
            match event {
                Event::Edge(opens) => {
                    let polarity = if opens == opens_rising { Polarity::Rising } else { Polarity::Falling };
                    // Bounces are refused.
                    let _ = stamper.on_edge(Edge { at: tick, polarity });
                }
                Event::Pulse => stamper.clock.on_pulse(tick),
                Event::Timesync([there, back]) => {
                    let theirs = Micros((BOOT_US + at_us + there) as u64);
                    stamper.clock.on_timesync(tick, theirs, timer.latch(at_us + there + back));
                }
                Event::Frame { open, length } => {
                    if let Ok(stamp) = stamper.frame(tick) {
                        flown.push(against(&stamp, open, length));
                    }
                }
            }
        }
        flown
    }
}

fn against(stamp: &Stamp, open: f64, length: f64) -> Flown {
    let error_us = stamp.mid.0 as f64 - (BOOT_US + open + 0.5 * length);
    assert!(stamp.open <= stamp.mid && stamp.mid <= stamp.close, "{stamp:?}");
    Flown { error_us, sigma_us: stamp.sigma_us.into(), source: stamp.source, length_us: length }
}

#[derive(Clone, Copy, Debug)]
enum Event {
    /// Whether it opens.
    Edge(bool),
    Pulse,
    /// How long each way takes.
    Timesync([f64; 2]),
    Frame {
        open: f64,
        length: f64,
    },
}

/// A bounce of two more edges, a stray short pulse or one stray edge.
fn fault(random: &mut Random, at: f64, opens: bool, events: &mut Vec<(f64, Event)>) {
    let anywhere = at + random.between(-125e3, 125e3);
    match random.below(3) {
        0 => {
            let first = random.between(3.0, 40.0);
            events.push((at + first, Event::Edge(!opens)));
            events.push((at + first + random.between(3.0, 40.0), Event::Edge(opens)));
        }
        1 => {
            events.push((anywhere, Event::Edge(true)));
            events.push((anywhere + random.between(3.0, 80.0), Event::Edge(false)));
        }
        _ => events.push((anywhere, Event::Edge(random.uniform() < 0.5))),
    }
}

/// The capture timer: its phase at every step of its rate's walk.
struct Timer {
    start: u32,
    drift_ppm: f64,
    steps: Vec<(f64, f64)>,
}

const STEP_US: f64 = 50_000.0;

impl Timer {
    fn new(random: &mut Random, drift_ppm: f64, walk_ppm: f64, end_us: f64) -> Self {
        let (mut gained, mut rate) = (0.0, 0.0);
        let count = (end_us / STEP_US) as usize + 2;
        let steps = (0..count).map(|_| {
            let here = (gained, rate);
            gained += rate * STEP_US * 1e-6;
            rate += walk_ppm * (STEP_US * 1e-6).sqrt() * random.normal();
            here
        });
        let steps = steps.collect();
        // Somewhere in the flight it wraps.
        let start = 0u32.wrapping_sub((random.uniform() * end_us) as u32);
        Timer { start, drift_ppm, steps }
    }

    fn latch(&self, at_us: f64) -> Ticks {
        let step = (at_us / STEP_US) as usize;
        let (gained, rate) = self.steps[step.min(self.steps.len() - 1)];
        let walked = gained + rate * (at_us - step as f64 * STEP_US) * 1e-6;
        Ticks(self.start.wrapping_add((at_us * (1.0 + 1e-6 * self.drift_ppm) + walked).floor() as i64 as u32))
    }
}
