//! Reference systems against PROJ and its EPSG dataset, another implementation with its own list of definitions.
//!
//! The points lie where the real data lies and at the edges of zones, on both hemispheres. How they were made, and
//! by which datum transformation, is in the head of `crs_pyproj.csv` and in `crs_pyproj.py` beside it.

use std::error::Error;

use plumbline_survey::Crs;

const VECTORS: &str = include_str!("crs_pyproj.csv");

/// Both sides drop the height at the datum shift, and the shift is turned back to first order: rotation squared times the
/// Earth's radius, (5.3 / 206265)^2 * 6.4e6 m = 4 mm for MGI, 1 cm for all systems in the list. Measured: 5.3 mm at most.
const PLACE_M: f64 = 0.02;

/// Both sides measure on some 200 m of grid that are good to a micrometre or so. Measured: 7e-9. The least of the convergences
/// is 2.5e-4 rad, so that a flipped sign shows.
const ALONG_MERIDIAN: f64 = 1e-7;

/// PROJ's own factors belong to the meridian of the system's own datum. That one is turned against the WGS 84 meridian by the
/// shift's rotation about the vertical (up to 8 seconds of arc here, 4e-5 rad) and by the difference of longitude times
/// the sine of the latitude (up to 5 seconds, 2.5e-5 rad).
const OWN_CONVERGENCE_RAD: f64 = 6.5e-5;

/// They also belong to its own ellipsoid, up to 200 m off where it was fitted locally (200 / 6.4e6), with a scale of
/// its own (up to 2e-5).
const OWN_SCALE: f64 = 5e-5;

const M_PER_DEG: f64 = 111_320.0;

struct Vector<'a> {
    place: &'a str,
    crs: Crs,
    lat_deg: f64,
    lon_deg: f64,
    x: f64,
    y: f64,
    convergence_rad: f64,
    point_scale: Option<f64>,
    own_convergence_rad: f64,
    own_scale: Option<f64>,
}

fn vectors() -> Result<Vec<Vector<'static>>, Box<dyn Error>> {
    let lines = VECTORS.lines().filter(|line| !line.starts_with('#')).skip(1);
    lines
        .map(|line| {
            let fields: Vec<&str> = line.split(',').collect();
            let [epsg, place, lat, lon, x, y, convergence, scale, own_convergence, own_scale, ..] = fields[..] else {
                return Err(format!("short line: {line}").into());
            };
            Ok(Vector {
                place,
                crs: Crs::from_epsg(epsg.parse()?)?,
                lat_deg: lat.parse()?,
                lon_deg: lon.parse()?,
                x: x.parse()?,
                y: y.parse()?,
                convergence_rad: convergence.parse()?,
                point_scale: optional(scale)?,
                own_convergence_rad: own_convergence.parse()?,
                own_scale: optional(own_scale)?,
            })
        })
        .collect()
}

fn optional(field: &str) -> Result<Option<f64>, Box<dyn Error>> {
    Ok(if field.is_empty() { None } else { Some(field.parse()?) })
}

#[test]
fn points_agree_with_proj_in_both_directions() -> Result<(), Box<dyn Error>> {
    let (mut worst_to_m, mut worst_from_m) = (0.0_f64, 0.0_f64);
    let vectors = vectors()?;
    assert!(vectors.len() >= 20);
    for v in &vectors {
        let (lat_deg, lon_deg) = v.crs.to_wgs84(v.x, v.y)?;
        let east_m = (lon_deg - v.lon_deg) * v.lat_deg.to_radians().cos() * M_PER_DEG;
        let to_m = east_m.hypot((lat_deg - v.lat_deg) * M_PER_DEG);

        let (x, y) = v.crs.from_wgs84(v.lat_deg, v.lon_deg)?;
        let unit_m = if v.crs.is_geographic() { M_PER_DEG } else { 1.0 };
        let from_m = (x - v.x).hypot(y - v.y) * unit_m;

        assert!(to_m < PLACE_M, "{:?} {}: to WGS 84 off by {to_m} m", v.crs, v.place);
        assert!(from_m < PLACE_M, "{:?} {}: from WGS 84 off by {from_m} m", v.crs, v.place);
        worst_to_m = worst_to_m.max(to_m);
        worst_from_m = worst_from_m.max(from_m);
    }
    println!("{} points, worst {worst_to_m:.4} m to WGS 84, {worst_from_m:.4} m from it", vectors.len());
    Ok(())
}

#[test]
fn convergence_and_scale_agree_with_proj() -> Result<(), Box<dyn Error>> {
    let mut worst = [0.0_f64; 4];
    for v in vectors()? {
        let convergence_rad = v.crs.convergence_rad(v.x, v.y)?;
        let mut off =
            [(convergence_rad - v.convergence_rad).abs(), (convergence_rad - v.own_convergence_rad).abs(), 0.0, 0.0];
        match (v.point_scale, v.own_scale) {
            (Some(scale), Some(own_scale)) => {
                let found = v.crs.point_scale(v.x, v.y)?;
                off[2] = (found / scale - 1.0).abs();
                off[3] = (found / own_scale - 1.0).abs();
            }
            _ => assert!(v.crs.point_scale(v.x, v.y).is_err()),
        }
        let limits = [ALONG_MERIDIAN, OWN_CONVERGENCE_RAD, ALONG_MERIDIAN, OWN_SCALE];
        assert!(off.iter().zip(limits).all(|(off, limit)| *off < limit), "{:?} {}: {off:?}", v.crs, v.place);
        for (worst, off) in worst.iter_mut().zip(off) {
            *worst = worst.max(off);
        }
    }
    let worst = worst.map(|off| format!("{off:.1e}")).join(", ");
    println!("worst convergence (rad), own convergence, scale, own scale: {worst}");
    Ok(())
}

/// The sign by its meaning, apart from PROJ: a step of 100 m to grid north from a point with positive convergence must
/// lead off to the east of true north by that angle.
#[test]
fn convergence_is_clockwise_from_true_to_grid_north() -> Result<(), Box<dyn Error>> {
    for v in vectors()?.iter().filter(|v| !v.crs.is_geographic()) {
        let (lat0, lon0) = v.crs.to_wgs84(v.x, v.y)?;
        let (lat1, lon1) = v.crs.to_wgs84(v.x, v.y + 100.0)?;
        // Metres a radian of latitude and of longitude on the ellipsoid.
        let sin2 = lat0.to_radians().sin().powi(2);
        let w2 = 1.0 - 0.006_694_38 * sin2;
        let north = (lat1 - lat0) * (1.0 - 0.006_694_38) / w2;
        let east = (lon1 - lon0) * lat0.to_radians().cos();
        let true_heading_of_grid_north = east.atan2(north);
        let off = (true_heading_of_grid_north - v.crs.convergence_rad(v.x, v.y)?).abs();
        // 100 m further on the meridian leans differently: 100 m * tan(latitude) / R, 3e-5 at 60 degrees, half of it on
        // average.
        assert!(off < 2e-5, "{:?} {}: {off} rad", v.crs, v.place);
    }
    Ok(())
}
