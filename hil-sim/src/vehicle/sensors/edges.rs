//! The edges on the shutter's line, and what goes wrong with them.
//!
//! Polarity: the rising edge opens. Each true edge is lost with the share of `lost_edge_percent`, and with that of
//! `extra_edge_percent` another fault is put beside it, one of three in turn by lot: a bounce (the line goes back and
//! comes again within the hold-off), a short pulse, or one lone edge, the latter two anywhere in the frame's interval.

use super::shutter::{Exposure, exposures};
use crate::noise::{normal, stream, uniform};
use crate::scenario::{EdgeSource, Scenario, Vehicle};
use rand_chacha::ChaCha12Rng;
use std::collections::VecDeque;

/// Longest hold-off, microseconds.
const HOLD_OFF_MAX_US: u32 = 100;

/// An edge as it reaches the capture timer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineEdge {
    /// When, microseconds of the autopilot's clock.
    pub at_us: f64,
    /// Whether the line goes up, which it does when the shutter opens.
    pub rising: bool,
}

impl LineEdge {
    /// The first whole microsecond at which the board can know of it.
    #[must_use]
    pub fn seen_us(&self) -> u64 {
        self.at_us.ceil().max(0.0) as u64
    }
}

/// How long the firmware takes edges for bounces, by its configuration: a quarter of the shortest exposure, at most 100 us.
#[must_use]
pub fn hold_off_us(vehicle: &Vehicle) -> u32 {
    let [least_us, _] = vehicle.exposures_us();
    (least_us / 4).min(HOLD_OFF_MAX_US)
}

/// All edges of a flight without a plan, in the order of time.
#[must_use]
pub fn line_edges(scenario: &Scenario) -> Vec<LineEdge> {
    let mut line = ShutterLine::new(scenario);
    let mut edges: Vec<_> = exposures(scenario).flat_map(|exposure| line.edges(scenario, &exposure)).collect();
    edges.sort_by(|a, b| a.at_us.total_cmp(&b.at_us));
    edges
}

/// The shutter's line: makes edges of exposures.
#[derive(Debug)]
pub struct ShutterLine {
    jitter: ChaCha12Rng,
    fate: ChaCha12Rng,
}

impl ShutterLine {
    /// The scenario's.
    #[must_use]
    pub fn new(scenario: &Scenario) -> Self {
        ShutterLine { jitter: stream(scenario.run.seed, "edge.jitter"), fate: stream(scenario.run.seed, "edge.fate") }
    }

    /// The edges of an exposure among those that are still to come, in the order of time.
    pub fn add_edges(&mut self, scenario: &Scenario, exposure: &Exposure, to_come: &mut VecDeque<LineEdge>) {
        to_come.extend(self.edges(scenario, exposure));
        to_come.make_contiguous().sort_by(|a, b| a.at_us.total_cmp(&b.at_us));
    }

    /// The edges of an exposure, in no order.
    fn edges(&mut self, scenario: &Scenario, exposure: &Exposure) -> Vec<LineEdge> {
        let (shutter, faults) = (&scenario.vehicle.shutter, &scenario.faults.shutter);
        let mut edges = Vec::new();
        let sides =
            [(exposure.open_us, shutter.open_delay_us, true), (exposure.close_us, shutter.close_delay_us, false)];
        for (t_us, delay_us, rising) in sides {
            let late_us = f64::from(delay_us) + shutter.edge_jitter_us * normal(&mut self.jitter);
            let edge = LineEdge { at_us: (t_us as f64 + late_us).max(0.0), rising };
            // All are drawn for every edge, so that one fault more or less moves no other.
            let (lost, extra) = (uniform(&mut self.fate), uniform(&mut self.fate));
            if lost * 100.0 >= faults.lost_edge_percent {
                edges.push(edge);
            }
            fault(scenario, &edge, extra * 100.0 < faults.extra_edge_percent, &mut self.fate, &mut edges);
        }
        edges.retain(|edge| match shutter.edges {
            EdgeSource::Both => true,
            EdgeSource::One => edge.rising,
            EdgeSource::None => false,
        });
        edges
    }
}

/// Puts an extra edge, or two, beside `edge` where `happens` says so; its draws are made in any case.
fn fault(scenario: &Scenario, edge: &LineEdge, happens: bool, rng: &mut ChaCha12Rng, edges: &mut Vec<LineEdge>) {
    let [kind, place, length, side] = [(); 4].map(|()| uniform(rng));
    if !happens {
        return;
    }
    let hold_off_us = f64::from(hold_off_us(&scenario.vehicle));
    let anywhere_us = edge.at_us + (place - 0.5) * scenario.run.frame_interval_us() as f64;
    let mut put = |at_us: f64, rising: bool| edges.push(LineEdge { at_us: at_us.max(0.0), rising });
    if kind < 1.0 / 3.0 {
        put(edge.at_us + 0.4 * place * hold_off_us, !edge.rising);
        put(edge.at_us + (0.4 * place + 0.4 * length) * hold_off_us, edge.rising);
    } else if kind < 2.0 / 3.0 {
        put(anywhere_us, true);
        put(anywhere_us + 0.8 * length * hold_off_us, false);
    } else {
        put(anywhere_us, side < 0.5);
    }
}

/// Whether each frame of the flight is lost on its way to the board.
pub fn lost_frames(scenario: &Scenario) -> impl Iterator<Item = bool> + use<> {
    let mut rng = stream(scenario.run.seed, "frame.lost");
    let share = scenario.faults.shutter.lost_frame_percent;
    (0..scenario.run.frames).map(move |_| uniform(&mut rng) * 100.0 < share)
}
