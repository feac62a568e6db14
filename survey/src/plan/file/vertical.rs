//! What the heights of a plan are above.

use crate::crs::System;
use crate::dem::{DemFile, Geoid};
use crate::error::InputError;
use crate::io::raster::{HeightDatum, vertical_unit_m};
use crate::io::shell::names;
use serde::{Deserialize, Serialize};

/// What all z of a plan are above, and how the altitudes of its mission came of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Vertical {
    /// Who says it.
    pub datum: Datum,
    /// EPSG code of the vertical system, where one is known.
    pub epsg: Option<u32>,
    /// The grid of geoid heights that were subtracted in the mission and in KML, as it was named.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geoid: Option<String>,
    /// The geoid's height above the ellipsoid at the plan, least and greatest, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub geoid_height_m: Option<[f64; 2]>,
}

/// Who says what heights are above.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Datum {
    /// The elevation model or the one who plans: mean sea level, by a vertical system.
    Stated,
    /// Nobody: mean sea level is assumed.
    Assumed,
    /// The one who plans, by a geoid: the ellipsoid.
    Ellipsoid,
}

impl Vertical {
    /// Of a model that says as much of its heights, with the system and the geoid that were given for it.
    ///
    /// # Errors
    /// One sentence where they contradict each other, or the system is none of heights in metres above the sea.
    pub fn new(model: HeightDatum, epsg: Option<u16>, geoid: Option<&Geoid>) -> Result<Self, InputError> {
        let refuse = |why: String| Err(InputError::new(why));
        if let (Some(given), HeightDatum::System(Some(said))) = (epsg, model)
            && u32::from(given) != said
        {
            return refuse(format!(
                "--vertical-epsg {given}, and the elevation model says that its heights are in EPSG:{said}"
            ));
        }
        match epsg.map(|epsg| (epsg, vertical_unit_m(epsg))) {
            None | Some((_, Ok(1.0))) => {}
            Some((epsg, Ok(unit_m))) => {
                return refuse(format!(
                    "--vertical-epsg {epsg} is of heights in units of {unit_m} m, and a unit stands in the elevation model's own file: \
                     gdal_edit.py -units ft MODEL says feet"
                ));
            }
            Some((epsg, Err(why))) => return refuse(format!("--vertical-epsg {epsg}: {why}")),
        }
        if let Some(geoid) = geoid {
            if epsg.is_some() || matches!(model, HeightDatum::System(_)) {
                let who = if epsg.is_some() { "--vertical-epsg" } else { "the elevation model" };
                return refuse(format!(
                    "--geoid is for heights above the ellipsoid, and {who} says that they are above mean sea level already"
                ));
            }
            let name = Some(geoid.name().to_owned());
            return Ok(Vertical {
                datum: Datum::Ellipsoid,
                epsg: None,
                geoid: name,
                geoid_height_m: Some(geoid.range_m()),
            });
        }
        let stated = |epsg| Vertical { datum: Datum::Stated, epsg, geoid: None, geoid_height_m: None };
        Ok(match (epsg, model) {
            (Some(epsg), _) => stated(Some(u32::from(epsg))),
            (None, HeightDatum::System(said)) => stated(said),
            (None, _) => Vertical { datum: Datum::Assumed, ..stated(None) },
        })
    }
}

/// An autopilot flies at heights above the sea: over heights above an ellipsoid it would fly too low or too high by the geoid's undulation.
/// `or`: what mends that besides another model.
///
/// # Errors
/// The model says that its heights are above an ellipsoid.
pub fn above_the_sea(file: &DemFile, or: &str) -> Result<(), InputError> {
    if file.height_datum() != HeightDatum::Ellipsoid {
        return Ok(());
    }
    let path = file.path();
    let (from, to) = match file.system().map(System::epsg).transpose()? {
        Some(4326 | 4979) => ("-s_srs EPSG:4979 ".to_owned(), "EPSG:4326+3855".to_owned()),
        Some(epsg) => (String::new(), format!("EPSG:{epsg}+3855")),
        None => (String::new(), "EPSG:CODE+3855".to_owned()),
    };
    Err(InputError::new(format!(
        "{}: its heights are above an ellipsoid, and an autopilot's are above the sea, up to 107 m apart: with PROJ's grid of the geoid EGM2008 \
         gdalwarp {from}-t_srs {to} {} makes heights above the sea{or}",
        path.display(),
        names(path, "sea")
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_heights_are_above_is_stated_once() {
        let new = |model, epsg| Vertical::new(model, epsg, None);
        let (unsaid, named) = (HeightDatum::Unsaid, HeightDatum::System(Some(5773)));
        assert_eq!(new(unsaid, None).map(|vertical| vertical.datum), Ok(Datum::Assumed));
        for (model, epsg, code) in [
            (named, None, Some(5773)),
            (named, Some(5773), Some(5773)),
            (HeightDatum::System(None), None, None),
            (unsaid, Some(3855), Some(3855)),
        ] {
            let vertical = new(model, epsg).expect("stated");
            assert_eq!((vertical.datum, vertical.epsg), (Datum::Stated, code), "{model:?} {epsg:?}");
        }
        // Another one, US survey feet, depths, an ellipsoid, and none at all.
        for (epsg, says) in [
            (3855, "EPSG:5773"),
            (6360, "feet"),
            (5706, "depths"),
            (4979, "--geoid"),
            (5030, "--geoid"),
            (0, "no vertical"),
        ] {
            let model = if epsg == 3855 { named } else { unsaid };
            let error = new(model, Some(epsg)).expect_err("refused").to_string();
            assert!(error.contains(says) && error.contains("--vertical-epsg"), "{epsg}: {error}");
        }
    }
}
