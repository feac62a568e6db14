//! A plan's file read, every value of it checked once, here.

use super::{PlanFile, VERSION};
use crate::camera_file::CameraFile;
use crate::error::InputError;
use crate::io::table::text_of;
use std::path::Path;

impl PlanFile {
    /// Reads and checks a plan.
    ///
    /// # Errors
    /// The file cannot be read, is no plan of this version, or has a value that no plan can have; the sentence names it.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        let refuse = |why: String| InputError::new(format!("{name}: {why}"));
        let value: serde_json::Value =
            serde_json::from_str(&text).map_err(|error| refuse(format!("it is no JSON: {error}")))?;
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => {}
            Some(version) => return Err(refuse(format!("plan version {version} is not read, only {VERSION} is"))),
            None => return Err(refuse("it has no version, so it is no plan".to_owned())),
        }
        let plan: PlanFile =
            serde_json::from_value(value).map_err(|error| refuse(format!("it is no plan: {error}")))?;
        plan.check().map_err(refuse)?;
        Ok(plan)
    }

    /// Lines that the strips lie on.
    #[must_use]
    pub fn lines(&self) -> usize {
        self.strips.iter().map(|strip| strip.line + 1).max().unwrap_or(0)
    }

    fn check(&self) -> Result<(), String> {
        self.check_strips()?;
        self.check_flight_order()?;
        CameraFile::from(&self.camera)
            .checked_toml_string(Path::new("of the plan"))
            .map_err(|error| error.to_string())?;
        let (noise, checks) = (&self.noise, &self.checks);
        for (key, value) in [
            ("height_m", self.height_m),
            ("gsd_m", self.gsd_m),
            ("speed_m_s", self.speed_m_s),
            ("min_interval_s", self.min_interval_s),
            ("base_min_m", self.base_min_m),
            ("interval_min_s", self.interval_min_s),
            ("noise.image_px", noise.image_px),
            ("checks.exposure_s", checks.exposure_s),
            ("checks.turn_radius_m", checks.turn_radius_m),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{key} is {value}, which is not above 0"));
            }
        }
        for (key, value) in [
            ("noise.position_m", noise.position_m),
            ("noise.attitude_deg", noise.attitude_deg),
            ("checks.clearance_wanted_m", checks.clearance_wanted_m),
            ("checks.length_m", checks.length_m),
            ("checks.flight_time_s", checks.flight_time_s),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(format!("{key} is {value}, which is not 0 or more"));
            }
        }
        for (key, value) in
            [("overlap_wanted.forward", self.overlap_wanted.forward), ("overlap_wanted.side", self.overlap_wanted.side)]
        {
            if !(0.0..1.0).contains(&value) {
                return Err(format!("{key} is {value}, which is not a share from 0 to below 1"));
            }
        }
        if let Some([lat, lon]) = self.origin_deg
            && !is_on_earth(lat, lon)
        {
            return Err(format!("origin_deg {lat}, {lon} is no latitude and longitude"));
        }
        Ok(())
    }

    /// Strips, photos, area: numbers and places.
    fn check_strips(&self) -> Result<(), String> {
        let photos = || self.strips.iter().flat_map(|strip| &strip.photos);
        if let Some(empty) = self.strips.iter().position(|strip| strip.photos.is_empty()) {
            return Err(format!("strips[{empty}] has no photos"));
        }
        if self.strips.is_empty() || photos().count() != self.photo_count {
            return Err(format!("photo_count is {}, but the strips have {}", self.photo_count, photos().count()));
        }
        if let Some(wrong) = self.strips.iter().position(|strip| strip.line >= self.strips.len()) {
            return Err(format!("strips[{wrong}].line is {}, more than there are strips", self.strips[wrong].line));
        }
        let places = photos().map(|photo| [photo.x, photo.y, photo.z]);
        let corners = self.area.iter().map(|[x, y]| [*x, *y, 0.0]);
        let headings = self.strips.iter().map(|strip| [strip.heading_deg, self.strip_heading_deg, self.base_height_m]);
        if places.chain(corners).chain(headings).flatten().any(|value| !value.is_finite()) {
            return Err("a coordinate, a heading or base_height_m is not finite".to_owned());
        }
        if self.area.len() < 3 {
            return Err(format!("area has {} corners", self.area.len()));
        }
        let on_earth = photos().map(|photo| match (photo.lat, photo.lon) {
            (Some(lat), Some(lon)) => is_on_earth(lat, lon),
            (lat, lon) => lat.is_none() && lon.is_none(),
        });
        match on_earth.enumerate().find(|(_, is_there)| !is_there) {
            Some((number, _)) => {
                Err(format!("photo {number} of all has no latitude and longitude of a place on Earth"))
            }
            None => Ok(()),
        }
    }

    /// Every photo once.
    fn check_flight_order(&self) -> Result<(), String> {
        let mut order = self.flight_order.clone();
        order.sort_unstable();
        let all = self.strips.iter().enumerate();
        let all = all.flat_map(|(strip, of)| (0..of.photos.len()).map(move |photo| [strip, photo]));
        if order.is_empty() || order.into_iter().eq(all) {
            return Ok(());
        }
        Err("flight_order does not name each photo once".to_owned())
    }
}

fn is_on_earth(lat: f64, lon: f64) -> bool {
    (-90.0..=90.0).contains(&lat) && (-180.0..=180.0).contains(&lon)
}
