//! Where pictures lie, and so where a match does.

use plumbline_sim::camera::still_match::Place;
use plumbline_survey::crs::System;
use plumbline_survey::error::InputError;
use plumbline_survey::io::raster::{GeoTransform, Placed, check_metres};
use plumbline_survey::io::shell::quoted;
use serde::Serialize;
use std::path::Path;

/// Share by which the pixels of patch and reference may differ: what a scale is taken to be off, one sigma.
const SCALE_TOLERANCE: f64 = 0.005;

/// A match on the ground.
#[derive(Clone, Debug, Serialize)]
pub struct OnGround {
    /// Where the patch's centre lies, on the reference's grid.
    pub east_m: f64,
    pub north_m: f64,
    /// One sigma of each.
    pub sigma_east_m: f64,
    pub sigma_north_m: f64,
    /// How far that is from where the patch's own georeference has it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_east_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub offset_north_m: Option<f64>,
    /// The grid's EPSG code, where it has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub epsg: Option<u32>,
    /// The grid's system as PROJ spells it, where it has no such code.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crs: Option<String>,
}

/// Where the reference lies, in metres, and where the patch's centre is by its own georeference.
#[derive(Clone, Copy, Debug)]
pub struct Georeference {
    geo: GeoTransform,
    system: Option<System>,
    claimed: Option<(f64, f64)>,
}

impl Georeference {
    /// Of the files; `None` where the reference has none, or none in metres. `patch_size`: (cols, rows).
    ///
    /// # Errors
    /// Both have one, and their grids, or the sizes of their pixels, are not the same.
    pub fn read(patch: &Path, reference: &Path, patch_size: (usize, usize)) -> Result<Option<Self>, InputError> {
        let Some(Placed { geo, crs: system, size, .. }) = placed(reference) else { return Ok(None) };
        if let Some(Err(why)) = system.map(|system| check_metres(reference, &geo, system, size)) {
            eprintln!("plumbline: no metres are given: {why}");
            return Ok(None);
        }
        let claimed = match placed(patch) {
            None => None,
            Some(own) => {
                agree((patch, &own), (reference, &geo, system))?;
                Some(own.geo.world_from_pixel(0.5 * (patch_size.0 as f64 - 1.0), 0.5 * (patch_size.1 as f64 - 1.0)))
            }
        };
        Ok(Some(Georeference { geo, system, claimed }))
    }

    /// Metres of a pixel of the reference, the smaller side.
    pub fn pixel_m(&self) -> f64 {
        self.geo.step_x.min(self.geo.step_y)
    }

    /// The pixel of the reference at which the patch's centre lies by its own georeference.
    pub fn near(&self) -> Option<(f64, f64)> {
        self.claimed.map(|(east, north)| self.geo.pixel_from_world(east, north))
    }

    /// Where a match in a reference of (cols, rows) lies.
    pub fn on_ground(&self, place: &Place, (cols, rows): (usize, usize)) -> OnGround {
        let (col, row) =
            (0.5 * (cols as f64 - 1.0) + f64::from(place.d_col), 0.5 * (rows as f64 - 1.0) + f64::from(place.d_row));
        let (east_m, north_m) = self.geo.world_from_pixel(col, row);
        OnGround {
            east_m,
            north_m,
            sigma_east_m: f64::from(place.sigma_col) * self.geo.step_x,
            sigma_north_m: f64::from(place.sigma_row) * self.geo.step_y,
            offset_east_m: self.claimed.map(|(east, _)| east_m - east),
            offset_north_m: self.claimed.map(|(_, north)| north_m - north),
            epsg: self.system.and_then(System::code),
            crs: self.system.filter(|system| system.code().is_none()).map(System::for_gdal),
        }
    }
}

/// The place of a picture; one that is not known is told, and the pixels count all the same.
fn placed(path: &Path) -> Option<Placed> {
    Placed::read(path).unwrap_or_else(|why| {
        eprintln!("plumbline: no metres are given: {why}");
        None
    })
}

fn agree(
    (patch, own): (&Path, &Placed),
    (reference, geo, system): (&Path, &GeoTransform, Option<System>),
) -> Result<(), InputError> {
    let (name, other) = (patch.display(), reference.display());
    if let (Some(one), Some(wanted)) = (own.crs, system)
        && one != wanted
    {
        return Err(InputError::new(format!(
            "{name} is on {one}, {other} on {wanted}: gdalwarp -t_srs {} -tr {} {} {name} OUT.tif",
            quoted(&wanted.for_gdal()),
            geo.step_x,
            geo.step_y
        )));
    }
    let is_alike = |one: f64, other: f64| (one / other - 1.0).abs() <= SCALE_TOLERANCE;
    if is_alike(own.geo.step_x, geo.step_x) && is_alike(own.geo.step_y, geo.step_y) {
        return Ok(());
    }
    Err(InputError::new(format!(
        "a pixel of {name} is {} x {}, of {other} {} x {}: gdalwarp -tr {} {} -r average {name} OUT.tif",
        own.geo.step_x, own.geo.step_y, geo.step_x, geo.step_y, geo.step_x, geo.step_y
    )))
}
