//! The plan store: a plan as it lies in the flash of a board.

use super::{Planned, limits};
use plumbline_core::exposure::Limits;
use plumbline_firmware::boot::BootError;
use plumbline_firmware::stores::plan::{before, entry, read};
use plumbline_survey::error::InputError;
use plumbline_survey::plan::PlanFile;
use plumbline_survey::plan::file::StripFile;

/// A strip as the store has it: its direction from true north, radians, and its photos in the order of flight, latitude and
/// longitude on WGS 84 in degrees.
type Strip = (f64, Vec<(f64, f64)>);

/// The store of a plan that is flown on a grid.
///
/// # Errors
/// A place that the grid cannot convert.
pub fn of_flight(planned: &Planned) -> Result<Vec<u8>, InputError> {
    let crs = &planned.place.crs;
    let mut strips: Vec<Strip> = Vec::new();
    for (number, line) in planned.lines.iter().enumerate() {
        let [east, north] = line.ends_m[0];
        let course_rad = line.course_rad + crs.convergence_rad(east, north)?;
        let photos = planned.photos.iter().filter(|photo| photo.strip == number);
        let places = photos.map(|photo| crs.to_wgs84(photo.place_m[0], photo.place_m[1]));
        strips.push((course_rad, places.collect::<Result<_, _>>()?));
    }
    store(planned.limits(), &strips)
}

/// The store of a plan file that knows its place on Earth. Its headings are taken for true ones: they tell a strip's direction,
/// and its course only where it has a single photo, for which a grid's convergence does not matter.
///
/// # Errors
/// A plan without latitudes and longitudes, or of more than a board takes.
pub fn of_file(file: &PlanFile) -> Result<Vec<u8>, InputError> {
    let strip = |strip: &StripFile| -> Option<Strip> {
        let mut places: Vec<_> = strip.photos.iter().map(|photo| photo.lat.zip(photo.lon)).collect::<Option<_>>()?;
        let course_rad = strip.heading_deg.to_radians();
        let (first, last) = (*places.first()?, *places.last()?);
        let shrink = first.0.to_radians().cos();
        let along = (last.0 - first.0) * course_rad.cos() + (last.1 - first.1) * shrink * course_rad.sin();
        if along < 0.0 {
            places.reverse();
        }
        Some((course_rad, places))
    };
    let strips: Option<Vec<Strip>> = file.strips.iter().map(strip).collect();
    let strips = strips.ok_or_else(|| {
        InputError::new(
            "the plan names no place on Earth; it needs an elevation model with a reference system, or --origin",
        )
    })?;
    store(limits(file), &strips)
}

fn store(limits: Limits, strips: &[Strip]) -> Result<Vec<u8>, InputError> {
    let (mut of_strips, mut of_photos, mut count) = (Vec::new(), Vec::new(), 0u32);
    for (course_rad, places) in strips {
        let course = crate::vehicle::servo::wrapped(*course_rad) as f32;
        of_strips.extend(entry(count, course.to_bits()));
        for (lat_deg, lon_deg) in places {
            let e7 = |degrees: f64| (degrees * 1e7).round() as i32 as u32;
            of_photos.extend(entry(e7(*lat_deg), e7(*lon_deg)));
            count += 1;
        }
    }
    let mut bytes = before(limits, &of_strips, &of_photos).to_vec();
    bytes.extend(of_strips);
    bytes.extend(of_photos);
    match read(&bytes) {
        Ok(_) => Ok(bytes),
        Err(error) => Err(InputError::new(format!("the firmware would refuse it: {}", BootError::Plan(error)))),
    }
}
