//! A plan's file read, every value of it checked once: its numbers one by one in `numbers.rs`, here what belongs together.

use super::{PlanFile, VERSION, numbers};
use crate::camera_file::CameraFile;
use crate::error::InputError;
use crate::io::table::text_of;
use std::path::Path;

/// Which of the files that people have of a plan is read.
const MEANT: &str = "plan.json, which `plumbline plan` writes, is meant";

impl PlanFile {
    /// Least and greatest ground sample distance straight below the strips where the ground is followed; `None` where one height is flown.
    #[must_use]
    pub fn gsd_range_m(&self) -> Option<[f64; 2]> {
        let follow = self.follow?;
        Some([follow.above_ground_min_m, follow.above_ground_max_m].map(|above_m| self.gsd_m * above_m / self.height_m))
    }

    /// The ground sample distance for people, in metres with the unit as it is written: from least to greatest where the ground is followed.
    #[must_use]
    pub fn gsd_text(&self, unit: &str) -> String {
        match self.gsd_range_m() {
            Some([least, most]) => format!("{least:.3} to {most:.3}{unit}"),
            None => format!("{:.3}{unit}", self.gsd_m),
        }
    }

    /// Reads and checks a plan.
    ///
    /// # Errors
    /// The file cannot be read, is no plan of this version, or has a value that no plan can have; the sentence names it.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (text, name) = text_of(path).map_err(|error| match path.exists() {
            true => InputError::new(format!("{error}; {MEANT}")),
            false => error,
        })?;
        let refuse = |why: String| InputError::new(format!("{name}: {why}"));
        let value: serde_json::Value = serde_json::from_str(&text).map_err(|error| {
            let other = other_form(&text).map(|form| refuse(format!("it is {form}; {MEANT}")));
            other.unwrap_or_else(|| refuse(format!("it is no JSON: {error}; {MEANT}")))
        })?;
        if value.get("fileType").is_some_and(|kind| kind == "Plan") {
            return Err(refuse(format!("it is the mission for a ground station; {MEANT}")));
        }
        if value.get("type").is_some_and(|kind| kind == "FeatureCollection" || kind == "Feature") {
            return Err(refuse(format!("it is GeoJSON; {MEANT}")));
        }
        match value.get("version").and_then(serde_json::Value::as_u64) {
            Some(version) if version == u64::from(VERSION) => {}
            Some(version) => return Err(refuse(format!("plan version {version} is not read, only {VERSION} is"))),
            None => return Err(refuse(format!("it has no version, so it is no plan; {MEANT}"))),
        }
        numbers::check(&value).map_err(refuse)?;
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
        if let Some([lat, lon]) = self.origin_deg
            && !is_on_earth(lat, lon)
        {
            return Err(format!("origin_deg {lat}, {lon} is no latitude and longitude"));
        }
        Ok(())
    }

    /// Strips, photos, area: how many, and where on Earth.
    fn check_strips(&self) -> Result<(), String> {
        let photos = || self.strips.iter().flat_map(|strip| &strip.photos);
        if let Some(empty) = self.strips.iter().position(|strip| strip.photos.is_empty()) {
            return Err(format!("strips[{empty}] has no photos"));
        }
        if self.strips.is_empty() {
            return Err("strips is empty".to_owned());
        }
        if photos().count() != self.photo_count {
            return Err(format!("photo_count is {}, but the strips have {}", self.photo_count, photos().count()));
        }
        if let Some(wrong) = self.strips.iter().position(|strip| strip.line >= self.strips.len()) {
            return Err(format!("strips[{wrong}].line is {}, more than there are strips", self.strips[wrong].line));
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
                Err(format!("photo {number} of all has no latitude and longitude of a point on Earth"))
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

/// What other programs know a flight by, told by its first words.
fn other_form(text: &str) -> Option<&'static str> {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    if text.starts_with("QGC WPL") {
        return Some("a list of waypoints for a ground station");
    }
    let is_markup = text.starts_with('<');
    let named = [("<kml", "KML"), ("<gpx", "GPX"), ("<html", "a page")];
    named.into_iter().find(|(tag, _)| is_markup && text.contains(tag)).map(|(_, form)| form)
}

fn is_on_earth(lat: f64, lon: f64) -> bool {
    (-90.0..=90.0).contains(&lat) && (-180.0..=180.0).contains(&lon)
}
