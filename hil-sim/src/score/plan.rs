//! Results of a plan: its photos as they were taken beside the photos that were planned.
//!
//! Overlap, intersection and its noise are the planner's own ([`plumbline_survey::plan`]); here they get the poses at which
//! the photos were really taken, and those that the navigation believed.

mod sight;

use crate::camera::render::Station;
use crate::run::{Flight, FrameRecord};
use crate::setup::Setup;
use crate::setup::planned::Planned;
use plumbline_firmware::wire::telemetry::PlanReport;
use plumbline_survey::dem::Dem;
use plumbline_survey::plan::area::Area;
use plumbline_survey::plan::axes::Axes;
use plumbline_survey::plan::cells::{Cells, Known, Summary};
use plumbline_survey::plan::course::Course;
use plumbline_survey::plan::intersect::Sigmas;
use plumbline_survey::plan::lines::{Layout, Overlaps, Strip, View};
use plumbline_survey::plan::sight::Ray;
use plumbline_survey::plan::simulate::Simulation;
use plumbline_survey::plan::terrain::Terrain;
use serde::Serialize;
use sight::{Taken, see};

/// Cells that coverage and accuracy are looked at on, about.
const CELLS_MOST: usize = 10_000;
/// Monte Carlo rounds.
const ROUNDS: u64 = 8;

/// A plan as it was flown: `plan` of `report.json`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Flown {
    /// Photos of the plan.
    pub photos: u32,
    /// Those that were exposed.
    pub exposed: u32,
    /// Those that were missed, by reason.
    pub missed: Missed,
    /// Exposures whose frame the firmware called by their photo's number.
    pub named: usize,
    /// Along and across the strip, from the planned place to the true one at mid-exposure, absolute, metres.
    pub position_error_m: Option<[Error; 2]>,
    /// Smallest overlaps.
    pub overlap: Three<Pair>,
    /// Share of the area that two photos of one strip see.
    pub coverage: Three<f64>,
    /// Root mean squares of ground points, from the covariance: planned, and with the rays of the photos as taken.
    pub accuracy_m: Accuracies,
    /// Root mean squares of ground points, from simulated noise: planned, and with the rays of the photos as taken.
    pub simulated_m: Accuracies,
}

/// Photos that were not taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Missed {
    /// Passed by before they could be exposed.
    pub passed: u32,
    /// The vehicle was too far off the line.
    pub off_line: u32,
    /// Too soon after the one before.
    pub too_soon: u32,
    /// Committed to when the shutter would have had to be open already.
    pub late: u32,
    /// The flight did not come to them.
    pub not_reached: u32,
}

impl Missed {
    /// All of them.
    pub fn sum(&self) -> u32 {
        self.passed + self.off_line + self.too_soon + self.late + self.not_reached
    }
}

/// Mean and largest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Error {
    /// Mean.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// As planned, with the true poses, and with those of the navigation; `None` where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Three<T> {
    /// What the plan promised.
    pub planned: Option<T>,
    /// By the poses at which the photos were really taken.
    pub achieved: Option<T>,
    /// By the poses that the firmware reported for their stamps.
    pub reported: Option<T>,
}

/// Along the strips and between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Along.
    pub forward: Option<f64>,
    /// Between.
    pub side: Option<f64>,
}

/// Horizontal and height.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Accuracies {
    /// What the plan promised.
    pub planned: Option<[f64; 2]>,
    /// With the photos as they were taken.
    pub achieved: Option<[f64; 2]>,
}

/// Results of the flight's plan; nothing without one.
pub fn flown(setup: &Setup, flight: &Flight) -> Option<Flown> {
    let planned = setup.plan.as_ref()?;
    let file = &planned.file;
    let PlanReport { passed, off_line, too_soon, .. } = flight.plan.unwrap_or_default();
    let missed = Missed { passed, off_line, too_soon, late: flight.late, not_reached: 0 };
    let photos = planned.photos.len() as u32;
    let exposed = flight.frames.iter().filter(|record| record.photo.is_some()).count() as u32;
    let not_reached = photos.saturating_sub(exposed + missed.sum());
    let is_named = |record: &&FrameRecord| {
        let committed = record.photo.map(|photo| photo.photo);
        committed.is_some() && flight.photos.get(&record.exposure.frame).copied() == committed
    };
    let block = Block::new(setup, planned);
    let truly = taken(planned, flight, |record| Some(setup.station(&record.truth)));
    let believed = taken(planned, flight, |record| reported(setup, record));
    let (achieved, reported) =
        (block.as_ref().map(|b| b.evaluate(setup, &truly)), block.as_ref().map(|b| b.evaluate(setup, &believed)));
    let promised = file.accuracy.as_ref();
    Some(Flown {
        photos,
        exposed,
        missed: Missed { not_reached, ..missed },
        named: flight.frames.iter().filter(is_named).count(),
        position_error_m: position_error(planned, flight),
        overlap: Three {
            planned: Some(Pair { forward: file.overlap_min.forward, side: file.overlap_min.side }),
            achieved: achieved.as_ref().map(|photos| photos.overlap),
            reported: reported.as_ref().map(|photos| photos.overlap),
        },
        coverage: Three {
            planned: promised.filter(|a| a.cells > 0).map(|a| 1.0 - a.gaps as f64 / a.cells as f64),
            achieved: achieved.as_ref().and_then(|photos| photos.coverage),
            reported: reported.as_ref().and_then(|photos| photos.coverage),
        },
        accuracy_m: Accuracies {
            planned: promised.map(|a| [a.plan_m, a.height_m]),
            achieved: achieved.as_ref().and_then(|photos| photos.accuracy_m),
        },
        simulated_m: Accuracies {
            planned: promised.map(|a| [a.simulated_plan_m, a.simulated_height_m]),
            achieved: achieved.as_ref().and_then(|photos| photos.simulated_m),
        },
    })
}

/// The photos that were taken, strip by strip in the order of their numbers, with the station that `of` gives each.
fn taken(planned: &Planned, flight: &Flight, of: impl Fn(&FrameRecord) -> Option<Station>) -> Vec<Taken> {
    let photo = |record: &FrameRecord| {
        let number = record.photo?.photo as usize;
        let strip = planned.photos.get(number)?.strip;
        Some(Taken { strip, photo: 0, station: of(record)? })
    };
    let mut taken: Vec<Taken> = flight.frames.iter().filter_map(photo).collect();
    for of_strip in taken.chunk_by_mut(|a, b| a.strip == b.strip) {
        of_strip.iter_mut().enumerate().for_each(|(number, photo)| photo.photo = number);
    }
    taken
}

/// The pose that the firmware reported of a frame; its height is above the ground there.
fn reported(setup: &Setup, record: &FrameRecord) -> Option<Station> {
    let report = record.report?;
    let (predicted, used) = (report.predicted?, report.situation?);
    let [height_m, heading_rad, pitch_rad, roll_rad, follow_up_rad] =
        [used.height_m, used.heading_rad, used.pitch_rad, used.roll_rad, used.follow_up_rad].map(f64::from);
    let east_m = setup.tile_centre[0] + f64::from(predicted.east_m);
    let north_m = setup.tile_centre[1] + f64::from(predicted.north_m);
    let up_m = setup.ground.height(east_m, north_m) + height_m;
    let boresight_rad = setup.payload.mount.boresight_rad;
    Some(Station { east_m, north_m, up_m, heading_rad, pitch_rad, roll_rad, follow_up_rad, boresight_rad })
}

/// Along and across the strip.
fn position_error(planned: &Planned, flight: &Flight) -> Option<[Error; 2]> {
    let off = |record: &FrameRecord| {
        let photo = planned.photos.get(record.photo?.photo as usize)?;
        let (sin, cos) = planned.lines.get(photo.strip)?.course_rad.sin_cos();
        let (east, north) = (record.truth.east_m - photo.place_m[0], record.truth.north_m - photo.place_m[1]);
        Some([(east * sin + north * cos).abs(), (east * cos - north * sin).abs()])
    };
    let off: Vec<[f64; 2]> = flight.frames.iter().filter_map(off).collect();
    let error = |axis: usize| Error {
        mean: off.iter().map(|off| off[axis]).sum::<f64>() / off.len() as f64,
        max: off.iter().map(|off| off[axis]).fold(0.0, f64::max),
    };
    (!off.is_empty()).then(|| [error(0), error(1)])
}

/// The ground that was to be covered, and how photos of it are evaluated.
struct Block {
    dem: Dem,
    axes: Axes,
    corners: Vec<[f64; 2]>,
    view: View,
    sigmas: Sigmas,
    lines: Vec<usize>,
    /// Whether the plan follows the ground: then each photo's height counts.
    is_following: bool,
    seed: u64,
}

/// Overlap, coverage and accuracy of a set of photos.
struct Evaluation {
    overlap: Pair,
    coverage: Option<f64>,
    accuracy_m: Option<[f64; 2]>,
    simulated_m: Option<[f64; 2]>,
}

impl Block {
    /// `None` where there is no terrain to evaluate on.
    fn new(setup: &Setup, planned: &Planned) -> Option<Self> {
        let (file, surface) = (&planned.file, setup.ground.surface_grid()?);
        let bounds = surface.bounds();
        let dem = Dem::from_fn(
            (surface.cols, surface.rows),
            [bounds.west_m, bounds.south_m],
            [surface.step_m; 2],
            |east, north| setup.ground.height(east, north),
        );
        let half = [file.camera.fov_v_deg, file.camera.fov_h_deg].map(|fov| (0.5 * fov.to_radians()).tan());
        let pixels = [file.camera.rows, file.camera.cols].map(f64::from);
        let corners = file.area.iter().map(|corner| planned.place.grid(*corner).ok());
        Some(Block {
            dem,
            axes: Axes::new(planned.lines.first()?.course_rad.to_degrees()),
            corners: corners.collect::<Option<_>>()?,
            view: View {
                height_m: file.height_m,
                base_height_m: file.base_height_m,
                footprint_m: half.map(|half| 2.0 * half * file.height_m),
            },
            sigmas: Sigmas {
                image: [0, 1].map(|axis| file.noise.image_px * 2.0 * half[axis] / pixels[axis]),
                position_m: file.noise.position_m,
                attitude_rad: file.noise.attitude_deg.to_radians(),
            },
            lines: file.strips.iter().map(|strip| strip.line).collect(),
            is_following: file.follow.is_some(),
            seed: setup.scenario.run.seed,
        })
    }

    fn evaluate(&self, setup: &Setup, taken: &[Taken]) -> Evaluation {
        let terrain = Terrain::new(&self.dem);
        let nothing = Evaluation {
            overlap: Pair { forward: None, side: None },
            coverage: None,
            accuracy_m: None,
            simulated_m: None,
        };
        let Ok(area) = Area::new(&self.corners) else { return nothing };
        let cells = Cells::new(&terrain, &area, CELLS_MOST);
        let seen = see(setup, &self.axes, &cells, taken);
        let known: Vec<Known> = seen.iter().map(|rays| Known::of(rays, &self.sigmas)).collect();
        let summary = Summary::new(&known);
        let covered = known.iter().filter(|cell| !cell.is_gap()).count();
        Evaluation {
            overlap: self.overlap(&terrain, &area, taken),
            coverage: (!known.is_empty()).then(|| covered as f64 / known.len() as f64),
            accuracy_m: summary.map(|summary| summary.rms_m),
            simulated_m: self.simulated(&seen, taken),
        }
    }

    fn simulated(&self, seen: &[Vec<Ray>], taken: &[Taken]) -> Option<[f64; 2]> {
        let mut strips: Vec<Strip> = self
            .lines
            .iter()
            .map(|&line| Strip { line, across_m: 0.0, along_m: Vec::new(), course: Course::default() })
            .collect();
        for photo in taken {
            strips[photo.strip].along_m.push(0.0);
        }
        let (mut count, mut squares) = (0.0, [0.0; 2]);
        for round in 0..ROUNDS {
            let simulation = Simulation::new(&strips, &self.sigmas, self.seed, round);
            for (point, rays) in seen.iter().enumerate() {
                if let Some([along, across, up]) = simulation.intersected(rays, point as u64) {
                    count += 1.0;
                    squares = [squares[0] + along * along + across * across, squares[1] + up * up];
                }
            }
        }
        (count > 0.0).then(|| squares.map(|sum| (sum / count).sqrt()))
    }

    /// Smallest overlaps of successive photos of a strip and of neighbouring lines, each photo standing where its axis meets
    /// the base plane, or that of its own height: that is what its tilt does to a footprint but for its shape.
    fn overlap(&self, terrain: &Terrain<'_>, area: &Area, taken: &[Taken]) -> Pair {
        let layout = Layout {
            terrain,
            axes: self.axes,
            area: area.mapped(|corner| self.axes.of(corner)),
            view: self.view,
            overlaps: Overlaps { forward: 0.0, side: 0.0 },
            follow: None,
        };
        let smallest = |a: Option<f64>, b: f64| Some(a.map_or(b, |a| a.min(b)));
        let (mut forward, mut side) = (None, None);
        // Of each line: places along and across, and heights above the plan's level one.
        let mut lines: Vec<(usize, Vec<[f64; 3]>)> = Vec::new();
        for of_strip in taken.chunk_by(|a, b| a.strip == b.strip) {
            let mut places: Vec<[f64; 3]> = of_strip.iter().map(|photo| self.stands(photo)).collect();
            places.sort_by(|a, b| a[0].total_cmp(&b[0]));
            let course = self.course(&places);
            for pair in places.windows(2) {
                let across = 0.5 * (pair[0][1] + pair[1][1]);
                let base = pair[1][0] - pair[0][0];
                forward = smallest(forward, layout.forward_overlap_on(&course, across, pair[0][0], base));
            }
            let line = self.lines[of_strip[0].strip];
            match lines.iter_mut().find(|(number, _)| *number == line) {
                Some((_, all)) => all.extend(places),
                None => lines.push((line, places)),
            }
        }
        lines.sort_by_key(|(number, _)| *number);
        lines.iter_mut().for_each(|(_, places)| places.sort_by(|a, b| a[0].total_cmp(&b[0])));
        for pair in lines.windows(2) {
            let [(_, one), (_, other)] = pair else { continue };
            let widest = other.iter().filter_map(|there| {
                let beside = one.iter().min_by(|a, b| (a[0] - there[0]).abs().total_cmp(&(b[0] - there[0]).abs()))?;
                Some((there[1].min(beside[1]), (there[1] - beside[1]).abs()))
            });
            if let Some((across, distance)) = widest.max_by(|a, b| a.1.total_cmp(&b.1)) {
                let courses = [self.course(one), self.course(other)];
                side = smallest(side, layout.side_overlap_on(courses.each_ref(), across, distance));
            }
        }
        Pair { forward, side }
    }

    /// Where a photo stands: along, across, and its height above the plan's level one.
    fn stands(&self, photo: &Taken) -> [f64; 3] {
        let station = &photo.station;
        let down = station.axes().down;
        let rise = if self.is_following { station.up_m - self.view.up_m(0.0) } else { 0.0 };
        let run = (station.up_m - rise - self.view.base_height_m) / -down[2];
        let [along, across] = self.axes.of([station.east_m + run * down[0], station.north_m + run * down[1]]);
        [along, across, rise]
    }

    /// The heights of photos from place to place, in ascending order.
    fn course(&self, places: &[[f64; 3]]) -> Course {
        let mut points: Vec<[f64; 2]> = places.iter().map(|place| [place[0], place[2]]).collect();
        points.dedup_by(|b, a| b[0] <= a[0]);
        if self.is_following { Course::through(points) } else { Course::default() }
    }
}
