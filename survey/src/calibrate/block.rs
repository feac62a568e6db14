//! The block file: a camera's design, start values, and what is known beforehand, as JSON.
//!
//! Needed: `f_px` (one number, or one a head), `heads_d_m` (centres, a row a head), `head_start_rad` (phi, omega, kappa, a
//! row a head; the first head's are kept), `station_start` (phi, omega, kappa, X, Y, Z, a row a station), `point_start`
//! (X, Y, Z, a row a point), `fixed_points` (indices of known points). Everything is counted from 0.
//!
//! Optional:
//! * `sigma_px`: standard deviation of an image coordinate, one or one a head; 1 unless given.
//! * `pixel_mm`, `cols`, `rows` (of a head's frame), `virtual_cols`, `virtual_rows`, `virtual_f_px`: for the camera file.
//! * `heads_interior`: a table a head with any of xp, yp (px), k1, k2, k3, p1, p2.
//! * `interior_free`: which of c, xp, yp, k1, k2, k3, p1, p2 each head estimates; `interior_sigma`: a table of what is known
//!   of them beforehand.
//! * `heads_d_sigma_m`: lever arms are unknowns, known to so much (one, three, or three a head).
//! * `head_sync_sigma_s`: heads after the first have a time offset, known to be 0 to so much; needs `station_rates` (as
//!   `station_start`, a second).
//! * `station_priors`: tables of `station` and `position_m` with `sigma_m`, `angles_rad` with `sigma_rad`, or `values` with a
//!   6 x 6 `covariance`, over phi, omega, kappa, X, Y, Z. `fixed_stations`: indices of known ones.
//! * `point_priors`: tables of `point`, `sigma_m` and `position_m` (the start unless given).
//! * `huber_sigmas`: residuals count by their length beyond so many standard deviations.

mod keys;
mod priors;

use super::fields::Field;
use crate::adjust::rig::{Head, LENS, Observation, Point, Rig, Station, TIME};
use crate::adjust::{INTERIOR_NAMES, Interior, Loss};
use crate::camera_file::heads::{HEADS_MAX, VIRTUAL_SIDE_MAX_PX};
use crate::camera_file::{SIDE_MAX_PX, no_pixel_mm};
use crate::error::{InputError, counted};
use crate::io::json;
use crate::io::table::text_of;
use std::path::Path;

use keys::check_keys;
pub use priors::{PointPrior, StationPrior};
use priors::{point_priors, station_priors};

/// Frame sizes that the camera file needs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sizes {
    /// Side of a pixel, mm.
    pub pixel_mm: Option<f64>,
    /// Columns and rows of a head's frame.
    pub head: Option<[u32; 2]>,
    /// Columns and rows of the virtual image.
    pub virtual_image: Option<[u32; 2]>,
    /// Principal distance of the virtual image, pixels.
    pub virtual_f_px: Option<f64>,
}

/// A block, checked key by key.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Start values, and which are unknown.
    pub heads: Vec<Head>,
    /// Start values.
    pub stations: Vec<Station>,
    /// Start values, or known.
    pub points: Vec<Point>,
    /// Standard deviation of an image coordinate of each head, pixels.
    pub sigma_px: Vec<f64>,
    /// What is known of each head's numbers: (head, number, value, sigma).
    pub head_priors: Vec<(usize, usize, f64, f64)>,
    /// What is known of stations.
    pub station_priors: Vec<StationPrior>,
    /// What is known of points.
    pub point_priors: Vec<PointPrior>,
    /// How large residuals count.
    pub loss: Loss,
    /// For the camera file.
    pub sizes: Sizes,
}

impl Block {
    /// Reads a block file.
    ///
    /// # Errors
    /// The file cannot be read; otherwise as [`Self::parse`].
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        Self::parse(&text, &name)
    }

    /// Reads a block's text; `name` is what errors call it.
    ///
    /// # Errors
    /// The text is no JSON object, or a key is missing, of the wrong shape, not finite, out of its range, or names what is
    /// not there; or a key that means nothing.
    pub fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        let value = json::value(text).map_err(|error| {
            let what = if error.is_data() { ":" } else { " is not JSON:" };
            InputError::new(format!("{name}{what} {error}"))
        })?;
        let file = Field { at: format!("{name}:"), value: &value };
        let Some(object) = value.as_object() else { return Err(file.wrong("an object")) };
        check_keys(object, name)?;
        let mut heads = heads(&file)?;
        let stations = stations(&file)?;
        let points = points(&file)?;
        let mut head_priors = Vec::new();
        interior_unknowns(&file, &mut heads, &mut head_priors)?;
        lever_arm_unknowns(&file, &mut heads, &mut head_priors)?;
        time_unknowns(&file, &mut heads, &mut head_priors)?;
        let sigma_px = match file.key("sigma_px") {
            None => vec![1.0; heads.len()],
            Some(field) if field.value.is_number() => vec![field.positive()?; heads.len()],
            Some(field) => one_a_head(&field, heads.len())?.iter().map(Field::positive).collect::<Result<_, _>>()?,
        };
        let loss = match file.key("huber_sigmas") {
            None => Loss::Squares,
            Some(field) => Loss::Huber(field.positive()?),
        };
        Ok(Block {
            station_priors: station_priors(&file, &stations)?,
            point_priors: point_priors(&file, &points)?,
            sizes: sizes(&file)?,
            heads,
            stations,
            points,
            sigma_px,
            head_priors,
            loss,
        })
    }

    /// The block with its observations as an adjustment.
    #[must_use]
    pub fn rig(&self, observations: &[Observation]) -> Rig {
        let mut rig = Rig::new(
            self.stations.clone(),
            self.heads.clone(),
            self.points.clone(),
            observations.to_vec(),
            self.sigma_px.clone(),
        );
        for head in 0..self.heads.len() {
            let of = self.head_priors.iter().filter(|prior| prior.0 == head);
            let known: Vec<_> = of.map(|&(_, number, value, sigma)| (number, value, sigma)).collect();
            if !known.is_empty() {
                rig.expect_head(head, &known);
            }
        }
        for prior in &self.station_priors {
            rig.expect_station(prior.station, prior.target, prior.rows.clone());
        }
        for prior in &self.point_priors {
            let row = |k: usize| {
                let mut row = vec![0.0; 3];
                row[k] = 1.0 / prior.sigma_m[k];
                row
            };
            rig.expect_point(prior.point, prior.position_m, (0..3).map(row).collect());
        }
        rig
    }
}

fn one_a_head<'a>(field: &Field<'a>, heads: usize) -> Result<Vec<Field<'a>>, InputError> {
    let list = field.list()?;
    if list.len() == heads {
        return Ok(list);
    }
    Err(InputError::new(format!("{} has {} entries, but there are {heads} heads", field.at, list.len())))
}

fn heads(file: &Field<'_>) -> Result<Vec<Head>, InputError> {
    let angles = file.needed("head_start_rad")?;
    let list = angles.list()?;
    if !(1..=HEADS_MAX).contains(&list.len()) {
        return Err(InputError::new(format!(
            "{} has {}, not one a head, of 1 to {HEADS_MAX}",
            angles.at,
            counted(list.len(), "row")
        )));
    }
    let centres = one_a_head(&file.needed("heads_d_m")?, list.len())?;
    let f = file.needed("f_px")?;
    let f_px: Vec<f64> = if f.value.is_array() {
        one_a_head(&f, list.len())?.iter().map(Field::positive).collect::<Result<_, _>>()?
    } else {
        vec![f.positive()?; list.len()]
    };
    let mut heads = Vec::new();
    for (index, (angles, centre)) in list.iter().zip(&centres).enumerate() {
        heads.push(Head::new(angles.radians()?, centre.numbers()?, Interior::ideal(f_px[index]), index == 0));
    }
    if let Some(field) = file.key("heads_interior") {
        for (head, table) in heads.iter_mut().zip(one_a_head(&field, list.len())?) {
            let Some(object) = table.value.as_object() else { return Err(table.wrong("a table")) };
            for key in object.keys() {
                let index = interior_index(key, &table)?;
                head.values[index] = table.needed(key)?.number()?;
            }
        }
    }
    Ok(heads)
}

/// Place of an interior orientation's number among a head's.
fn interior_index(key: &str, field: &Field<'_>) -> Result<usize, InputError> {
    INTERIOR_NAMES.iter().position(|name| *name == key).map(|index| LENS + index).ok_or_else(|| {
        InputError::new(format!("{} has \"{key}\", which is none of {}", field.at, INTERIOR_NAMES.join(", ")))
    })
}

fn stations(file: &Field<'_>) -> Result<Vec<Station>, InputError> {
    let list = file.needed("station_start")?.list()?;
    let mut stations = Vec::new();
    for row in &list {
        stations.push(Station { values: row.numbers()?, rates: [0.0; 6], is_free: true });
    }
    if let Some(field) = file.key("station_rates") {
        let rows = field.list()?;
        if rows.len() != stations.len() {
            let sentence = format!(
                "{} has {}, but there are {}",
                field.at,
                counted(rows.len(), "row"),
                counted(stations.len(), "station")
            );
            return Err(InputError::new(sentence));
        }
        for (station, row) in stations.iter_mut().zip(&rows) {
            station.rates = row.numbers()?;
        }
    }
    for index in indices(file, "fixed_stations", stations.len(), "station")? {
        stations[index].is_free = false;
    }
    Ok(stations)
}

fn points(file: &Field<'_>) -> Result<Vec<Point>, InputError> {
    let list = file.needed("point_start")?.list()?;
    let mut points = Vec::new();
    for row in &list {
        points.push(Point { position_m: row.numbers()?, is_free: true });
    }
    file.needed("fixed_points")?;
    for index in indices(file, "fixed_points", points.len(), "point")? {
        points[index].is_free = false;
    }
    Ok(points)
}

/// Indices under a key, none twice.
fn indices(file: &Field<'_>, key: &str, count: usize, what: &str) -> Result<Vec<usize>, InputError> {
    let Some(field) = file.key(key) else { return Ok(Vec::new()) };
    let (mut indices, mut is_named) = (Vec::new(), vec![false; count]);
    for item in field.list()? {
        let index = item.index(count, what)?;
        if std::mem::replace(&mut is_named[index], true) {
            return Err(InputError::new(format!("{} names {what} {index} a second time", item.at)));
        }
        indices.push(index);
    }
    Ok(indices)
}

type HeadPriors = Vec<(usize, usize, f64, f64)>;

/// Makes a head's number an unknown.
fn free(head: &mut Head, number: usize) {
    if let Err(index) = head.free.binary_search(&number) {
        head.free.insert(index, number);
    }
}

fn interior_unknowns(file: &Field<'_>, heads: &mut [Head], priors: &mut HeadPriors) -> Result<(), InputError> {
    let mut numbers = Vec::new();
    if let Some(field) = file.key("interior_free") {
        for item in field.list()? {
            let name = item.value.as_str().ok_or_else(|| item.wrong("a name"))?;
            numbers.push(interior_index(name, &item)?);
        }
    }
    let mut sigmas = Vec::new();
    if let Some(field) = file.key("interior_sigma") {
        let Some(object) = field.value.as_object() else { return Err(field.wrong("a table")) };
        for key in object.keys() {
            let index = interior_index(key, &field)?;
            if !numbers.contains(&index) {
                return Err(InputError::new(format!("{} has {key}, which interior_free does not name", field.at)));
            }
            sigmas.push((index, field.needed(key)?.positive()?));
        }
    }
    for (index, head) in heads.iter_mut().enumerate() {
        numbers.iter().for_each(|number| free(head, *number));
        priors.extend(sigmas.iter().map(|(number, sigma)| (index, *number, head.values[*number], *sigma)));
    }
    Ok(())
}

fn lever_arm_unknowns(file: &Field<'_>, heads: &mut [Head], priors: &mut HeadPriors) -> Result<(), InputError> {
    let Some(field) = file.key("heads_d_sigma_m") else { return Ok(()) };
    let is_one = field.value.is_number() || field.list()?.first().is_some_and(|first| first.value.is_number());
    let sigmas: Vec<[f64; 3]> = if is_one {
        vec![field.sigmas()?; heads.len()]
    } else {
        one_a_head(&field, heads.len())?.iter().map(Field::sigmas).collect::<Result<_, _>>()?
    };
    for (index, (head, sigma)) in heads.iter_mut().zip(sigmas).enumerate() {
        for (k, sigma) in sigma.into_iter().enumerate() {
            free(head, 3 + k);
            priors.push((index, 3 + k, head.values[3 + k], sigma));
        }
    }
    Ok(())
}

fn time_unknowns(file: &Field<'_>, heads: &mut [Head], priors: &mut HeadPriors) -> Result<(), InputError> {
    let Some(field) = file.key("head_sync_sigma_s") else { return Ok(()) };
    if file.key("station_rates").is_none() {
        let sentence = format!("{} needs station_rates: without motion a time offset moves nothing", field.at);
        return Err(InputError::new(sentence));
    }
    let sigma = field.positive()?;
    for (index, head) in heads.iter_mut().enumerate().skip(1) {
        free(head, TIME);
        priors.push((index, TIME, 0.0, sigma));
    }
    Ok(())
}

fn sizes(file: &Field<'_>) -> Result<Sizes, InputError> {
    let pair = |cols: &str, rows: &str, most: u32| -> Result<Option<[u32; 2]>, InputError> {
        let side = |field: &Field<'_>| {
            let side = field.value.as_u64().and_then(|side| u32::try_from(side).ok());
            side.filter(|side| (1..=most).contains(side)).ok_or_else(|| field.wrong(&format!("1 to {most} pixels")))
        };
        match (file.key(cols), file.key(rows)) {
            (Some(cols), Some(rows)) => Ok(Some([side(&cols)?, side(&rows)?])),
            (None, None) => Ok(None),
            (Some(one), None) | (None, Some(one)) => {
                Err(InputError::new(format!("{} stands alone: {cols} and {rows} belong together", one.at)))
            }
        }
    };
    let positive = |key: &str| file.key(key).map(|field| field.positive()).transpose();
    let side_mm = |field: &Field<'_>| {
        field
            .positive()
            .and_then(|mm| no_pixel_mm(mm, "pixel_mm = ").map_or(Ok(mm), |wanted| Err(field.wrong(&wanted))))
    };
    Ok(Sizes {
        pixel_mm: file.key("pixel_mm").map(|field| side_mm(&field)).transpose()?,
        head: pair("cols", "rows", SIDE_MAX_PX)?,
        virtual_image: pair("virtual_cols", "virtual_rows", VIRTUAL_SIDE_MAX_PX)?,
        virtual_f_px: positive("virtual_f_px")?,
    })
}
