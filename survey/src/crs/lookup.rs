//! The EPSG code of a projected system that a file spells out instead of naming.

use super::definition::{Definition, codes};

/// Largest difference of a parameter (degrees, metres or a scale) that is still the same system: files round
/// degrees to nine decimals or so. 1e-8 degree is 1 mm on the ground.
const SAME: f64 = 1e-8;

/// Lowest EPSG code of the system that stands on the geographic system `base` and has this projection (`tmerc` or `lcc`)
/// with these parameters, both named as in projection strings; degrees, metres and ratios.
pub(crate) fn code_of(base: u32, projection: &str, parameters: &[(&str, f64)]) -> Option<u32> {
    let mut wanted = parameters.to_vec();
    // The cone is the same whichever of its two parallels is called the first.
    let parallel = |name: &str| wanted.iter().position(|(key, _)| *key == name);
    if let (Some(first), Some(second)) = (parallel("lat_1"), parallel("lat_2"))
        && wanted[first].1 < wanted[second].1
    {
        let southern = wanted[first].1;
        wanted[first].1 = wanted[second].1;
        wanted[second].1 = southern;
    }
    codes()
        .filter_map(|code| Definition::read(code).ok())
        .find(|known| {
            known.base_epsg == Some(base)
                && known.projection == projection
                && wanted
                    .iter()
                    .all(|(name, value)| known.parameter(name).is_some_and(|listed| (listed - value).abs() < SAME))
        })
        .map(|known| known.epsg)
}
