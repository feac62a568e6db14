//! What heights are above: a mission's are above the sea, and a model's above what its file or an option says.

use super::Args;
use crate::outcome::note;
use plumbline_survey::dem::{Dem, Geoid};
use plumbline_survey::error::InputError;
use plumbline_survey::plan::PlanFile;
use plumbline_survey::plan::checks::Turns;
use plumbline_survey::plan::file::Datum;
use plumbline_survey::plan::place::Place;

/// Says that nobody says it, and in which unit they are taken to be where nobody says that either: gentle hills in feet or in decimetres are
/// known by their numbers alone. `range`: those of the model, if so.
pub fn ask(plan: &PlanFile, range: Option<[f64; 2]>) {
    if plan.vertical.as_ref().is_some_and(|vertical| vertical.datum == Datum::Assumed) {
        let unit = range.map_or_else(String::new, |[low, high]| {
            format!(" nor in which unit: {low:.1} to {high:.1} are taken for metres (gdal_edit.py -units ft says otherwise in a GeoTIFF);")
        });
        let colon = if unit.is_empty() { ":" } else { "," };
        note(&format!(
            "the elevation model does not say above what its heights are{colon}{unit} plan.plan and plan.kml take them for heights above mean sea level; \
             --vertical-epsg 5773 (EGM96), 3855 (EGM2008) or another states it, and --geoid FILE is for heights above the ellipsoid"
        ));
    }
}

/// The geoid over all of the plan.
pub fn geoid(args: &Args, place: &Place, dem: &Dem) -> Result<Option<Geoid>, InputError> {
    let Some(path) = &args.geoid else { return Ok(None) };
    let [x0, y0, x1, y1] = dem.bounds();
    let far_m = 4.0 * Turns::new(args.speed_m_s()).radius_m;
    let (x, y) = ([x0 - far_m, 0.5 * (x0 + x1), x1 + far_m], [y0 - far_m, 0.5 * (y0 + y1), y1 + far_m]);
    let mut area_deg = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for place_m in x.into_iter().flat_map(|x| y.map(|y| [x, y])) {
        let Some((lat, lon)) = place.wgs84(place_m)? else {
            return Err(InputError::new(format!(
                "--geoid {}: the elevation model has no reference system, so nobody knows where on Earth it lies: --origin LAT,LON says it",
                path.display()
            )));
        };
        area_deg = [area_deg[0].min(lon), area_deg[1].min(lat), area_deg[2].max(lon), area_deg[3].max(lat)];
    }
    Geoid::over(path, area_deg).map(Some)
}
