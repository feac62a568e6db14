//! Association of edges with a frame.
//!
//! The frame decides, not the order of edges: its first row's arrival less the readout's latency is where the shutter
//! closed, within a gate of five sigmas, and the known exposure before that is where it opened. So edges without a
//! frame, frames without an edge and strays cannot shift the numbering, as they do where edges and frames are counted
//! (a shift by one frame is the complaint most often made of camera triggers).
//!
//! | edges within the gates | stamp |
//! |---|---|
//! | one pair of the right length | both edges |
//! | one edge, with no neighbour that makes another exposure | that edge and the known exposure |
//! | none; or several of a kind, which may all be strays | arrival and the known exposure |
//! | an opening and a closing one of another distance than the known exposure; a good pair elsewhere | contradiction |
//!
//! Without a known exposure both edges are required, the opening one between the closing edge before and this one.

use super::edges::Edges;
use super::settings::ShutterSettings;
use super::{EXPOSURE_MAX_US, Exposure, ROUNDING, StampError, StampSource};
use crate::math;
use crate::units::Ticks;

/// Gate of an edge, sigmas: one in two million is beyond.
const GATE_SIGMAS: f32 = 5.0;
/// Margin of a gate for rounding, ticks: up to one for each of two latches.
const GATE_SLACK: f32 = 2.0;
/// Jitter, in ticks, above which the roundings of two latches are independent: with normal jitter σ their correlation
/// falls as exp(−2 π² σ²), which is 4 % there.
const DITHER_TICKS: f32 = 0.4;

/// The edges associated with a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Association {
    /// Both edges.
    Both(Exposure),
    /// The opening one.
    Opening(Ticks),
    /// The closing one.
    Closing(Ticks),
    /// Neither: the closing of the shutter by the frame's arrival.
    Neither(Ticks),
}

impl Association {
    /// Number of edges.
    pub fn edges(self) -> u8 {
        match self {
            Association::Both(_) => 2,
            Association::Opening(_) | Association::Closing(_) => 1,
            Association::Neither(_) => 0,
        }
    }

    /// Source of a stamp by them.
    pub fn source(self) -> StampSource {
        match self {
            Association::Both(_) => StampSource::BothEdges,
            Association::Opening(_) | Association::Closing(_) => StampSource::OneEdge,
            Association::Neither(_) => StampSource::Arrival,
        }
    }

    /// The exposure, with missing edges computed from the known length.
    ///
    /// # Errors
    /// [`StampError::NoExposure`] if no length is known.
    pub fn exposure(self, settings: &ShutterSettings) -> Result<Exposure, StampError> {
        let length = || settings.exposure.map(|known| known.us).ok_or(StampError::NoExposure);
        Ok(match self {
            Association::Both(exposure) => exposure,
            Association::Opening(open) => Exposure { open, close: Ticks(open.0.wrapping_add(length()?)) },
            Association::Closing(close) | Association::Neither(close) => {
                Exposure { open: Ticks(close.0.wrapping_sub(length()?)), close }
            }
        })
    }

    /// Variance of the middle on the timer, ticks²: of both edges' mean, or of the one latch and half the exposure.
    ///
    /// Edges that jitter by less than half a tick are rounded alike, since exposures last whole microseconds: their
    /// mean is then no better than one of them.
    pub fn variance(self, settings: &ShutterSettings) -> f32 {
        let square = |sigma: f32| sigma * sigma;
        let half_exposure = 0.25 * square(settings.exposure.map_or(0.0, |known| known.sigma_us));
        match self {
            Association::Both(_) => {
                let correlation = rounding_correlation(settings.edge_sigma_us);
                0.5 * (square(settings.edge_sigma_us) + ROUNDING * (1.0 + correlation))
            }
            Association::Opening(_) | Association::Closing(_) => {
                square(settings.edge_sigma_us) + ROUNDING + half_exposure
            }
            Association::Neither(_) => square(settings.arrival_sigma_us) + ROUNDING + half_exposure,
        }
    }
}

/// Correlation of the roundings of latches of the same phase, 0 to 1, for a jitter of `sigma` ticks.
pub(super) fn rounding_correlation(sigma: f32) -> f32 {
    let share = sigma / DITHER_TICKS;
    (1.0 - share * share).max(0.0)
}

/// Five sigmas of independent variances, whole ticks.
fn gate(variance: f32) -> i32 {
    (GATE_SIGMAS * math::sqrt(variance) + GATE_SLACK) as i32
}

impl Edges {
    /// The edges of the frame whose first row arrived at `arrival`. They and all before them are removed.
    ///
    /// # Errors
    /// [`StampError::Backwards`], [`StampError::Contradiction`], [`StampError::BadExposure`] and
    /// [`StampError::NoExposure`].
    pub fn associate(&mut self, arrival: Ticks, settings: &ShutterSettings) -> Result<Association, StampError> {
        if self.arrival.is_some_and(|before| arrival.since(before) <= 0) {
            return Err(StampError::Backwards);
        }
        self.arrival = Some(arrival);
        let closes = Ticks(arrival.0.wrapping_sub(settings.readout_us));
        let found = match settings.exposure {
            Some(known) => self.with_known((known.us, known.sigma_us), closes, arrival, settings),
            None => self.with_unknown(closes, settings),
        };
        let passed = match found {
            Ok(edges) => edges.exposure(settings).map_or(closes, |exposure| exposure.close),
            Err(_) => closes,
        };
        self.drop_until(passed, settings);
        found
    }

    fn with_known(
        &self,
        (length_us, length_sigma_us): (u32, f32),
        closes: Ticks,
        arrival: Ticks,
        settings: &ShutterSettings,
    ) -> Result<Association, StampError> {
        let latch = settings.edge_sigma_us * settings.edge_sigma_us + ROUNDING;
        let length_variance = length_sigma_us * length_sigma_us;
        let arrives = settings.arrival_sigma_us * settings.arrival_sigma_us + ROUNDING;
        let near_length = gate(length_variance + 2.0 * latch);
        let near_close = gate(arrives + latch);
        let near_open = gate(arrives + latch + length_variance);

        // Pairs of the right length, here and elsewhere.
        let (mut here, mut elsewhere, mut pair) = (0u32, 0u32, None);
        for close in self.kept.iter().filter(|edge| !edge.opens) {
            let close = close.at(settings);
            for open in self.kept.iter().filter(|edge| edge.opens) {
                let open = open.at(settings);
                let off = close.since(open).wrapping_sub(length_us as i32);
                if off.unsigned_abs() > near_length as u32 {
                    continue;
                }
                if close.since(closes).unsigned_abs() <= near_close as u32 {
                    (here, pair) = (here + 1, Some(Exposure { open, close }));
                } else if close.since(arrival) <= 0 {
                    elsewhere += 1;
                }
            }
        }
        match (here, pair) {
            (1, Some(exposure)) => Ok(Association::Both(exposure)),
            (0, _) => match self.lone_edge((length_us, near_open, near_close), closes, arrival, settings)? {
                None if elsewhere > 0 => Err(StampError::Contradiction),
                lone => Ok(lone.unwrap_or(Association::Neither(closes))),
            },
            _ => Ok(Association::Neither(closes)),
        }
    }

    /// An edge that is alone within its gate; [`Association::Neither`] for several of a kind, `None` without any.
    fn lone_edge(
        &self,
        (length_us, near_open, near_close): (u32, i32, i32),
        closes: Ticks,
        arrival: Ticks,
        settings: &ShutterSettings,
    ) -> Result<Option<Association>, StampError> {
        let (mut openings, mut closings, mut single) = (0u32, 0u32, None);
        for (index, edge) in self.kept.iter().enumerate().filter(|(_, edge)| !edge.is_doubtful) {
            let at = edge.at(settings);
            let off = at.since(closes);
            if edge.opens {
                if off.wrapping_add(length_us as i32).unsigned_abs() <= near_open as u32 {
                    (openings, single) = (openings + 1, Some((index, Association::Opening(at))));
                }
            } else if off.unsigned_abs() <= near_close as u32 {
                (closings, single) = (closings + 1, Some((index, Association::Closing(at))));
            }
        }
        match (openings, closings, single) {
            (0, 0, _) => Ok(None),
            (1, 0, Some((index, found))) | (0, 1, Some((index, found)))
                if !self.makes_another_exposure(index, found, arrival, settings) =>
            {
                Ok(Some(found))
            }
            (1, 0, _) | (0, 1, _) => Err(StampError::Contradiction),
            (_, 0, _) | (0, _, _) => Ok(Some(Association::Neither(closes))),
            _ => Err(StampError::Contradiction),
        }
    }

    /// Whether the neighbour of a lone edge makes an exposure with it: then the known one is wrong, or one of them a
    /// stray.
    fn makes_another_exposure(
        &self,
        index: usize,
        found: Association,
        arrival: Ticks,
        settings: &ShutterSettings,
    ) -> bool {
        let neighbour = |index: usize, opens: bool| {
            self.kept.iter().nth(index).filter(|edge| edge.opens == opens && !edge.is_doubtful).map(|e| e.at(settings))
        };
        let length = match found {
            Association::Opening(open) => neighbour(index.wrapping_add(1), false)
                .filter(|close| close.since(arrival) <= 0)
                .map(|close| close.since(open)),
            Association::Closing(close) => {
                index.checked_sub(1).and_then(|before| neighbour(before, true)).map(|open| close.since(open))
            }
            Association::Both(_) | Association::Neither(_) => None,
        };
        length.is_some_and(|length| (0..=EXPOSURE_MAX_US).contains(&length))
    }

    fn with_unknown(&self, closes: Ticks, settings: &ShutterSettings) -> Result<Association, StampError> {
        let latch = settings.edge_sigma_us * settings.edge_sigma_us + ROUNDING;
        let arrives = settings.arrival_sigma_us * settings.arrival_sigma_us + ROUNDING;
        let near_close = gate(arrives + latch);
        let (mut since_closed, mut open, mut found) = (0u32, None, None);
        for edge in &self.kept {
            let at = edge.at(settings);
            if edge.opens {
                if !edge.is_doubtful {
                    (since_closed, open) = (since_closed + 1, Some(at));
                }
            } else {
                if at.since(closes).unsigned_abs() <= near_close as u32 {
                    if found.is_some() {
                        return Err(StampError::Contradiction);
                    }
                    found = Some((since_closed, open, at));
                }
                (since_closed, open) = (0, None);
            }
        }
        match found {
            Some((1, Some(open), close)) => {
                let exposure = Exposure { open, close };
                exposure.mid().map(|_| Association::Both(exposure)).ok_or(StampError::BadExposure)
            }
            Some((0, _, _)) | None => Err(StampError::NoExposure),
            Some(_) => Err(StampError::Contradiction),
        }
    }
}
