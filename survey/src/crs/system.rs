//! What names a reference system: a code, or the projection that a file spells out.

use std::fmt;

use crate::error::InputError;

use super::Crs;
use super::definition::{Definition, codes};

/// Largest difference of a parameter (degrees, metres or a scale) that is still the same system: files round
/// degrees to nine decimals or so. 1e-8 degree is 1 mm on the ground.
const SAME: f64 = 1e-8;

/// A horizontal reference system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum System {
    /// By its EPSG code.
    Epsg(u32),
    /// One without a code, which a file spells out ("user-defined" in GeoTIFF's words).
    UserDefined(UserDefined),
}

/// A projection on a geographic system that has a code. Easts and norths are metres.
#[derive(Clone, Copy, Debug)]
pub struct UserDefined {
    pub(crate) base_epsg: u32,
    pub(crate) projection: Projection,
    /// In the order of [`Projection::parameters`], 0 behind the last: degrees, metres and ratios.
    values: [f64; 6],
}

/// A projection that files spell out: those of national and zone grids.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Projection {
    TransverseMercator,
    LambertConic2Sp,
}

impl Projection {
    /// The name in projection strings.
    fn name(self) -> &'static str {
        match self {
            Self::TransverseMercator => "tmerc",
            Self::LambertConic2Sp => "lcc",
        }
    }

    /// The parameters that it has to have, by their names in projection strings.
    pub fn parameters(self) -> &'static [&'static str] {
        match self {
            Self::TransverseMercator => &["lon_0", "lat_0", "x_0", "y_0", "k"],
            Self::LambertConic2Sp => &["lat_1", "lat_2", "lon_0", "lat_0", "x_0", "y_0"],
        }
    }
}

impl System {
    /// The system on the geographic system `base_epsg` with this projection, each parameter as `value` gives it: by the lowest
    /// code that the EPSG list has for it, user-defined where it has none.
    ///
    /// # Errors
    /// A parameter is missing, or nothing can be converted by them.
    pub(crate) fn spelt_out(
        base_epsg: u32,
        projection: Projection,
        value: impl Fn(&str) -> Option<f64>,
    ) -> Result<Self, String> {
        let mut values = [0.0; 6];
        for (place, name) in values.iter_mut().zip(projection.parameters()) {
            *place = value(name).ok_or_else(|| format!("its projection has no parameter {name}"))?;
        }
        // The cone is the same whichever of its two parallels is called the first.
        if projection == Projection::LambertConic2Sp && values[0] < values[1] {
            values.swap(0, 1);
        }
        let system = UserDefined { base_epsg, projection, values };
        match system.code() {
            Some(code) => Ok(Self::Epsg(code)),
            None => Crs::new(Self::UserDefined(system))
                .map(|_| Self::UserDefined(system))
                .map_err(|error| error.to_string()),
        }
    }

    /// As GDAL's commands take it: the code, or a projection string.
    #[must_use]
    pub fn for_gdal(self) -> String {
        match self {
            Self::Epsg(code) => format!("EPSG:{code}"),
            Self::UserDefined(system) => system.proj4().unwrap_or_default(),
        }
    }

    /// The EPSG code.
    ///
    /// # Errors
    /// It has none: the sentence has the command that puts a picture on a system that does.
    pub fn epsg(self) -> Result<u32, InputError> {
        match self {
            Self::Epsg(code) => Ok(code),
            Self::UserDefined(system) => Err(InputError::new(system.mends())),
        }
    }

    /// The EPSG code, `None` where it has none.
    #[must_use]
    pub fn code(self) -> Option<u32> {
        match self {
            Self::Epsg(code) => Some(code),
            Self::UserDefined(_) => None,
        }
    }
}

impl fmt::Display for System {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Epsg(code) => write!(f, "EPSG:{code}"),
            Self::UserDefined(system) => write!(f, "the user-defined system {}", system.words()),
        }
    }
}

impl PartialEq for UserDefined {
    fn eq(&self, other: &Self) -> bool {
        let is_close = |(one, other): (&f64, &f64)| (one - other).abs() < SAME;
        (self.base_epsg, self.projection) == (other.base_epsg, other.projection)
            && self.values.iter().zip(&other.values).all(is_close)
    }
}

impl UserDefined {
    /// Each parameter with its name.
    pub(crate) fn values(&self) -> impl Iterator<Item = (&'static str, f64)> {
        self.projection.parameters().iter().copied().zip(self.values)
    }

    /// Lowest EPSG code of the same system.
    fn code(&self) -> Option<u32> {
        let is_it = |known: &Definition| {
            known.base_epsg == Some(self.base_epsg)
                && known.projection == self.projection.name()
                && self
                    .values()
                    .all(|(name, value)| known.parameter(name).is_some_and(|listed| (listed - value).abs() < SAME))
        };
        codes().filter_map(|code| Definition::read(code).ok()).find(is_it).map(|known| known.epsg)
    }

    /// Projection and parameters as a projection string has them.
    fn words(&self) -> String {
        let parameters: String = self.values().map(|(name, value)| format!(" +{name}={value}")).collect();
        format!("+proj={}{parameters} on EPSG:{}", self.projection.name(), self.base_epsg)
    }

    /// The projection string, with the ellipsoid and the datum of the geographic system it stands on.
    ///
    /// # Errors
    /// That system is none that can be converted by, or a parameter is none of a place on Earth.
    pub(super) fn proj4(&self) -> Result<String, InputError> {
        let base = Definition::read(self.base_epsg)?;
        let refuse = |why: &str| InputError::new(format!("cannot use the user-defined system {}: {why}", self.words()));
        if !base.geographic {
            return Err(refuse(&format!("EPSG:{} is no geographic system", self.base_epsg)));
        }
        let is_sane = |(name, value): (&str, f64)| match name {
            "k" => value > 0.0 && value.is_finite(),
            "lon_0" => value.abs() <= 180.0,
            "x_0" | "y_0" => value.is_finite(),
            _ => value.abs() <= 90.0,
        };
        if let Some((name, value)) = self.values().find(|parameter| !is_sane(*parameter)) {
            return Err(refuse(&format!("{name} cannot be {value}")));
        }
        let on = format!("+proj={}", self.projection.name());
        let parameters: String = self.values().map(|(name, value)| format!(" +{name}={value:?}")).collect();
        Ok(base.proj4.replace("+proj=longlat", &(on + &parameters)) + " +units=m")
    }

    /// Why it has no code and the command that mends it: to the UTM zone of the central meridian.
    fn mends(&self) -> String {
        let meridian_deg = self.values().find(|(name, _)| *name == "lon_0").map_or(0.0, |(_, value)| value);
        let zone = ((meridian_deg + 180.0) / 6.0) as u8 % 60 + 1;
        format!(
            "its reference system is user-defined ({}) and has no EPSG code: gdalwarp -t_srs EPSG:326{zone:02} IN OUT.tif \
             puts it on one, EPSG:327{zone:02} south of the equator",
            self.words()
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// South Africa's Lo25 with its axes turned to east and north, as GDAL users write it.
    fn lo_25(name: &str) -> Option<f64> {
        Some(match name {
            "lon_0" => 25.0,
            "k" => 1.0,
            _ => 0.0,
        })
    }

    #[test]
    fn a_system_without_a_code_converts_by_its_parameters() {
        let system = System::spelt_out(4326, Projection::TransverseMercator, lo_25).expect("a projection");
        let crs = Crs::new(system).expect("usable");
        // pyproj 3.7.2 (PROJ 9.5.1): Transformer and Proj.get_factors of "+proj=tmerc +lat_0=0 +lon_0=25 +k=1 +datum=WGS84".
        let (x, y) = crs.from_wgs84(-33.65, 24.4).expect("a place");
        assert!((x + 55_657.571_1).hypot(y + 3_725_001.197_5) < 1e-3, "{x} {y}");
        assert!((crs.convergence_rad(x, y).expect("near").to_degrees() - 0.332_479_46).abs() < 1e-5);
        assert!((crs.point_scale(x, y).expect("near") - 1.000_038_17).abs() < 1e-7);
        let (lat_deg, lon_deg) = crs.to_wgs84(x, y).expect("and back");
        assert!((lat_deg + 33.65).abs() < 1e-9 && (lon_deg - 24.4).abs() < 1e-9);
        let said = system.epsg().expect_err("no code").to_string();
        assert!(said.contains("EPSG:32635 IN OUT.tif") && said.contains("EPSG:32735 south"), "{said}");

        let conic = |name: &str| {
            let named =
                [("lat_1", 45.0), ("lat_2", 47.0), ("lon_0", 10.0), ("lat_0", 46.0), ("x_0", 1e5), ("y_0", 2e5)];
            named.iter().find(|(known, _)| *known == name).map(|(_, value)| *value)
        };
        let system = System::spelt_out(4326, Projection::LambertConic2Sp, conic).expect("a projection");
        let (x, y) = Crs::new(system).and_then(|crs| crs.from_wgs84(46.5, 11.0)).expect("a place");
        // Of "+proj=lcc +lat_1=47 +lat_2=45 +lon_0=10 +lat_0=46 +x_0=100000 +y_0=200000 +datum=WGS84".
        assert!((x - 176_751.809_2).hypot(y - 256_052.189_7) < 1e-3, "{x} {y}");
    }

    #[test]
    fn systems_are_one_where_their_parameters_are() {
        let of = |base, moved: f64| {
            let value = |name: &str| lo_25(name).map(|value| if name == "x_0" { value + moved } else { value });
            System::spelt_out(base, Projection::TransverseMercator, value).expect("a projection")
        };
        assert_eq!(of(4326, 0.0), of(4326, 1e-9));
        assert_ne!(of(4326, 0.0), of(4326, 1e-6));
        assert_ne!(of(4326, 0.0), of(4258, 0.0));
    }

    #[test]
    fn what_is_no_place_on_earth_is_refused() {
        for (name, value) in [("lon_0", 181.0), ("lat_0", -90.1), ("k", 0.0), ("k", f64::NAN), ("x_0", f64::INFINITY)] {
            let moved = |other: &str| if other == name { Some(value) } else { lo_25(other) };
            let said = System::spelt_out(4326, Projection::TransverseMercator, moved).expect_err(name);
            assert!(said.contains(name), "{said}");
        }
        let missing = |name: &str| lo_25(name).filter(|_| name != "k");
        assert!(System::spelt_out(4326, Projection::TransverseMercator, missing).is_err());
        for base in [4267, 32633, 99_999] {
            assert!(System::spelt_out(base, Projection::TransverseMercator, lo_25).is_err(), "{base}");
        }
    }
}
