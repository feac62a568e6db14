//! A plan made ready to fly: [`place`] (its coordinates on the grid that is flown over), [`terrain`] (its elevation model
//! there), [`camera`] (what of it the board can hold), [`store`] (what lies in flash).

pub mod camera;
pub mod place;
pub mod store;
pub mod terrain;

use crate::vehicle::motion::{Line, Manner, PlannedTrack};
use place::Place;
use plumbline_core::exposure::Limits;
use plumbline_survey::error::InputError;
use plumbline_survey::plan::PlanFile;
use plumbline_survey::plan::file::Photo;
use std::path::Path;

/// Share of a frame's width on the base plane that an exposure may be off its line. Side overlaps are planned in steps of
/// five hundredths, and with a margin of the same size for what tilts do.
const ACROSS_SHARE: f64 = 0.1;
/// Share of the plan's least time between exposures that the board insists on: positions are uncertain, so exposures come
/// a little early or late.
const INTERVAL_SHARE: f64 = 0.95;
/// A photo as it is planned, in the order of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedPhoto {
    /// Number of its strip, in the order of flight.
    pub strip: usize,
    /// Grid east, north, and height above the height datum.
    pub place_m: [f64; 3],
}

/// A plan on the grid that is flown over.
#[derive(Debug)]
pub struct Planned {
    /// As it was read.
    pub file: PlanFile,
    /// From its coordinates to the grid's.
    pub place: Place,
    /// Its photos in the order of flight.
    pub photos: Vec<PlannedPhoto>,
    /// Its strips as they are flown.
    pub lines: Vec<Line>,
    /// What was decided for this flight, a sentence each.
    pub notes: Vec<String>,
}

impl Planned {
    /// Reads a plan and puts it onto its grid.
    ///
    /// # Errors
    /// One sentence for a file that is none, and for places that no grid has.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let file = PlanFile::read(path)?;
        let place = Place::of(&file).map_err(|error| InputError::new(format!("{}: {error}", path.display())))?;
        let danger = file.checks.unsafe_because();
        let danger = danger.map(|danger| format!("{}: the plan's checks failed: {danger}", path.display()));
        let mut planned = Planned {
            notes: danger.into_iter().chain(place.note()).collect(),
            photos: Vec::new(),
            lines: Vec::new(),
            file,
            place,
        };
        for (strip, of_file) in planned.file.strips.iter().enumerate() {
            let course_rad = of_file.heading_deg.to_radians() - planned.place.convergence_rad;
            let along = |point: &[f64; 3]| point[0] * course_rad.sin() + point[1] * course_rad.cos();
            let on_grid = |photos: &[Photo]| {
                let point = |photo: &Photo| {
                    let [east_m, north_m] = planned.place.grid([photo.x, photo.y])?;
                    Ok([east_m, north_m, photo.z])
                };
                let mut points = photos.iter().map(point).collect::<Result<Vec<[f64; 3]>, InputError>>()?;
                // They stand from the strip's low end, whichever way it is flown.
                if points.first().map(along) > points.last().map(along) {
                    points.reverse();
                }
                Ok::<_, InputError>(points)
            };
            let (points, way) = (on_grid(&of_file.photos)?, on_grid(&of_file.way)?);
            planned.lines.extend(line(&points, &way, course_rad));
            planned.photos.extend(points.into_iter().map(|place_m| PlannedPhoto { strip, place_m }));
        }
        Ok(planned)
    }

    /// The track along the strips. `deviation_m`: one sigma off it, east and north each, and up.
    pub fn track(&self, deviation_m: [f64; 2], seed: u64) -> PlannedTrack {
        let speed_m_s = self.file.speed_m_s;
        let radius_m = self.file.checks.turn_radius_m.max(1.0);
        PlannedTrack::new(&self.lines, &Manner { speed_m_s, radius_m, deviation_m }, seed)
    }

    /// What the board insists on.
    pub fn limits(&self) -> Limits {
        limits(&self.file)
    }
}

/// What a board that flies a plan insists on.
pub fn limits(file: &PlanFile) -> Limits {
    let swath_m = file.gsd_m * f64::from(file.camera.cols);
    Limits {
        interval_us: (INTERVAL_SHARE * file.min_interval_s * 1e6).clamp(0.0, 6e8) as u32,
        across_m: (ACROSS_SHARE * swath_m).clamp(0.0, 1e4) as f32,
    }
}

/// The line over a strip's points: through the first and the last; a single point has the strip's own course. Its height is that of its way
/// points, of a strip without any the photos'.
fn line(points: &[[f64; 3]], way: &[[f64; 3]], course_rad: f64) -> Option<Line> {
    let (first, last) = (points.first()?, points.last()?);
    let (east, north) = (last[0] - first[0], last[1] - first[1]);
    let course_rad = if east.hypot(north) > 0.0 { east.atan2(north) } else { course_rad };
    let up_m = points.iter().map(|point| point[2]).sum::<f64>() / points.len() as f64;
    let (sin, cos) = course_rad.sin_cos();
    let on_way = |point: &[f64; 3]| [(point[0] - first[0]) * sin + (point[1] - first[1]) * cos, point[2]];
    let mut heights: Vec<[f64; 2]> = way.iter().map(on_way).collect();
    heights.dedup_by(|b, a| b[0] <= a[0]);
    if heights.is_empty() {
        heights.push([0.0, up_m]);
    }
    Some(Line { ends_m: [[first[0], first[1]], [last[0], last[1]]], course_rad, heights })
}
