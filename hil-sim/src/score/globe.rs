//! `fixes.geojson`, `tile.tif` and `track.kml`: a flight's fixes and its reference for a geographic information system, and its track for
//! a virtual globe.
//!
//! The first and the last have WGS 84 longitudes and latitudes (RFC 7946, KML 2.2). Altitudes are those of the ground's height datum, which KML takes to be
//! mean sea level.

use super::fixes::probability;
use crate::run::Flight;
use crate::setup::Setup;
use crate::vehicle::mount::antenna;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::Picture;
use plumbline_survey::io::raster::{GeoTransform, grey_geotiff_bytes};
use serde_json::{Value, json};
use std::fmt::Write;

/// The reference tile as it lay in flash, a GeoTIFF on the grid that fixes are on.
///
/// # Errors
/// A reference system that no GeoTIFF can name.
pub fn tile(setup: &Setup) -> Result<Vec<u8>, InputError> {
    let (flash, step_m) = (&setup.flash, setup.scenario.vehicle.resolution_m);
    let [cols, rows] = [flash.head.size.0, flash.head.size.1].map(usize::from);
    let half_m = |count: usize| 0.5 * (count as f64 - 1.0) * step_m;
    let [east_m, north_m] = setup.tile_centre;
    let geo = GeoTransform { x0: east_m - half_m(cols), y0: north_m + half_m(rows), step_x: step_m, step_y: step_m };
    let picture = Picture { cols, rows, pixels: flash.tile.clone() };
    grey_geotiff_bytes(&picture, &geo, Some(setup.crs.system()), None)
}

/// A point a fix, with its frame, stamp, sigmas, risk, and distance from the truth.
///
/// # Errors
/// A place that the grid cannot express.
pub fn geojson(setup: &Setup, flight: &Flight) -> Result<String, InputError> {
    let mut features = Vec::new();
    for record in &flight.frames {
        let Some((report, fix)) = record.report.as_ref().and_then(|report| Some((report, report.fix?))) else {
            continue;
        };
        let place_m = [setup.tile_centre[0] + f64::from(fix.east_m), setup.tile_centre[1] + f64::from(fix.north_m)];
        let (lat_deg, lon_deg) = setup.crs.to_wgs84(place_m[0], place_m[1])?;
        let [east_m, north_m, _] = antenna(&record.truth, &setup.payload.mount);
        features.push(json!({
            "type": "Feature",
            "geometry": { "type": "Point", "coordinates": [degrees(lon_deg), degrees(lat_deg)] },
            "properties": {
                "frame": record.exposure.frame,
                "mid_exposure_us": report.mid_exposure_us,
                "sigma_east_m": f64::from(fix.variance_east_m2).sqrt(),
                "sigma_north_m": f64::from(fix.variance_north_m2).sqrt(),
                "risk": probability(report.risk),
                "error_m": (place_m[0] - east_m).hypot(place_m[1] - north_m),
            },
        }));
    }
    let collection: Value = json!({ "type": "FeatureCollection", "features": features });
    Ok(format!("{collection}\n"))
}

/// The true track at the frames, and a point a fix.
///
/// # Errors
/// As [`geojson`].
pub fn kml(setup: &Setup, flight: &Flight) -> Result<String, InputError> {
    let (mut track, mut fixes) = (String::new(), String::new());
    for record in &flight.frames {
        let [east_m, north_m, up_m] = antenna(&record.truth, &setup.payload.mount);
        let (lat_deg, lon_deg) = setup.crs.to_wgs84(east_m, north_m)?;
        // Writing to a string cannot fail.
        let _ = write!(track, "{},{},{up_m:.2} ", degrees(lon_deg), degrees(lat_deg));
        let Some(fix) = record.report.as_ref().and_then(|report| report.fix) else { continue };
        let [east_m, north_m] = [fix.east_m, fix.north_m].map(f64::from);
        let (lat_deg, lon_deg) = setup.crs.to_wgs84(setup.tile_centre[0] + east_m, setup.tile_centre[1] + north_m)?;
        let _ = writeln!(
            fixes,
            "<Placemark><name>{}</name><styleUrl>#fix</styleUrl><Point><coordinates>{},{}</coordinates></Point></Placemark>",
            record.exposure.frame,
            degrees(lon_deg),
            degrees(lat_deg)
        );
    }
    Ok(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document>\n\
         <name>Plumbline flight</name>\n\
         <Style id=\"track\"><LineStyle><color>ff859196</color><width>2</width></LineStyle></Style>\n\
         <Style id=\"fix\"><IconStyle><scale>0.4</scale></IconStyle><LabelStyle><scale>0</scale></LabelStyle></Style>\n\
         <Placemark><name>track</name><styleUrl>#track</styleUrl><LineString><altitudeMode>absolute</altitudeMode><coordinates>{}</coordinates></LineString></Placemark>\n\
         <Folder><name>fixes</name>\n{fixes}</Folder>\n</Document></kml>\n",
        track.trim_end()
    ))
}

/// To 1e-9 degrees, a tenth of a millimetre.
fn degrees(value: f64) -> f64 {
    (value * 1e9).round() / 1e9
}
