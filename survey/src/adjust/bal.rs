//! Problems in the format of Bundle Adjustment in the Large (Agarwal and others, 2010).
//!
//! A camera has nine numbers: rotation (angle times axis), translation, f, k1, k2. A point X is seen at
//!
//! ```text
//! P = R X + t      p = -(P.x, P.y) / P.z      f (1 + k1 |p|^2 + k2 |p|^4) p
//! ```
//!
//! in pixels from the middle, y up. Nothing holds the block in place, so the adjustment is damped throughout.

use super::model::{At, Link, Model, Row, Structure};
use crate::error::InputError;
use crate::io::table::text_of;
use nalgebra::{Matrix3, Vector3};
use std::path::Path;

/// Numbers of a camera.
const CAMERA: usize = 9;
/// Square of an angle below which its rotation is taken as a series.
const SMALL: f64 = 1e-12;

/// A problem: observations and start values.
#[derive(Clone, Debug)]
pub struct Bal {
    /// Number of cameras.
    pub cameras: usize,
    /// Camera, point, image point in pixels.
    seen: Vec<(usize, usize, [f64; 2])>,
    start: Vec<f64>,
    structure: Structure,
}

/// Reads the numbers of a file one after the other.
struct Numbers<'a> {
    name: &'a str,
    words: std::iter::Enumerate<std::str::SplitAsciiWhitespace<'a>>,
}

impl<'a> Numbers<'a> {
    fn word(&mut self, what: &str) -> Result<(usize, &'a str), InputError> {
        let name = self.name;
        self.words.next().ok_or_else(|| InputError::new(format!("{name} ends before {what}: the file is cut short")))
    }

    fn count(&mut self, what: &str) -> Result<usize, InputError> {
        let name = self.name;
        let (index, word) = self.word(what)?;
        word.parse().map_err(|_| InputError::new(format!("{name}, number {}: \"{word}\" is no {what}", index + 1)))
    }

    fn value(&mut self, what: &str) -> Result<f64, InputError> {
        let name = self.name;
        let (index, word) = self.word(what)?;
        word.parse().ok().filter(|value: &f64| value.is_finite()).ok_or_else(|| {
            InputError::new(format!("{name}, number {}: \"{word}\" is no finite number for {what}", index + 1))
        })
    }

    fn index(&mut self, what: &str, count: usize, observation: usize) -> Result<usize, InputError> {
        let index = self.count(&format!("{what} of observation {observation}"))?;
        if index < count {
            return Ok(index);
        }
        let name = self.name;
        Err(InputError::new(format!("{name}: observation {observation} names {what} {index}, but there are {count}")))
    }
}

impl Bal {
    /// Reads a problem.
    ///
    /// # Errors
    /// The file cannot be read, is cut short, goes on after its end, holds what is no finite number, names a camera or
    /// point it does not have, or a point that nobody sees.
    pub fn read(path: &Path) -> Result<Self, InputError> {
        let (text, name) = text_of(path)?;
        Self::parse(&text, &name)
    }

    /// Reads a problem's text; `name` is what errors call it.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(text: &str, name: &str) -> Result<Self, InputError> {
        let refuse = |sentence: String| Err(InputError::new(format!("{name}: {sentence}")));
        let mut numbers = Numbers { name, words: text.split_ascii_whitespace().enumerate() };
        let cameras = numbers.count("number of cameras")?;
        let points = numbers.count("number of points")?;
        let observations = numbers.count("number of observations")?;
        // What the header says is believed as far as the text can hold it.
        let words = text.len() / 2 + 1;
        if cameras == 0 || points == 0 || observations == 0 {
            return refuse("no cameras, points or observations".to_owned());
        }
        if cameras > words || points > words || observations > words {
            let said = format!("{cameras} cameras, {points} points and {observations} observations");
            return refuse(format!("{said} are more than the file holds: it is cut short"));
        }
        let mut seen = Vec::with_capacity(observations);
        for observation in 0..observations {
            let camera = numbers.index("camera", cameras, observation)?;
            let point = numbers.index("point", points, observation)?;
            let x = numbers.value(&format!("x of observation {observation}"))?;
            seen.push((camera, point, [x, numbers.value(&format!("y of observation {observation}"))?]));
        }
        let mut start = Vec::with_capacity(CAMERA * cameras + 3 * points);
        for k in 0..CAMERA * cameras {
            start.push(numbers.value(&format!("parameter {} of camera {}", k % CAMERA, k / CAMERA))?);
        }
        for k in 0..3 * points {
            start.push(numbers.value(&format!("coordinate {} of point {}", k % 3, k / 3))?);
        }
        if let Some((index, word)) = numbers.words.next() {
            return refuse(format!("number {}, \"{word}\", stands after the last point", index + 1));
        }
        let (mut by_camera, mut by_point) = (vec![0_u32; cameras], vec![0_u32; points]);
        for (camera, point, _) in &seen {
            by_camera[*camera] += 1;
            by_point[*point] += 1;
        }
        if let Some(point) = by_point.iter().position(|count| *count < 2) {
            return refuse(format!("point {point} is seen {}, a point needs two rays", times(by_point[point])));
        }
        if let Some(camera) = by_camera.iter().position(|count| *count == 0) {
            return refuse(format!("camera {camera} sees nothing"));
        }
        let links = seen
            .iter()
            .map(|(camera, point, _)| Link { station: Some(*camera as u32), head: None, point: Some(*point as u32) })
            .collect();
        let structure = Structure { sizes: vec![CAMERA; cameras], points, links, priors: Vec::new() };
        Ok(Bal { cameras, seen, start, structure })
    }

    /// Start values: cameras, then points.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        self.start.clone()
    }

    /// Number of observations.
    #[must_use]
    pub fn observations(&self) -> usize {
        self.seen.len()
    }
}

fn times(count: u32) -> String {
    match count {
        0 => "never".to_owned(),
        1 => "once".to_owned(),
        _ => format!("{count} times"),
    }
}

/// A camera at some values.
#[derive(Clone, Debug)]
struct Camera {
    rotation: Matrix3<f64>,
    /// Derivative of a rotated vector by the rotation's numbers: -R \[X\] of this.
    right: Matrix3<f64>,
    translation: Vector3<f64>,
    lens: [f64; 3],
}

impl Camera {
    fn new(values: &[f64]) -> Self {
        let w = Vector3::new(values[0], values[1], values[2]);
        let (cross, squared) = (w.cross_matrix(), w.norm_squared());
        let angle = squared.sqrt();
        // (sin a)/a, (1 - cos a)/a^2, (a - sin a)/a^3
        let (a, b, c) = if squared < SMALL {
            (1.0 - squared / 6.0, 0.5 - squared / 24.0, 1.0 / 6.0 - squared / 120.0)
        } else {
            (angle.sin() / angle, (1.0 - angle.cos()) / squared, (angle - angle.sin()) / (squared * angle))
        };
        let twice = cross * cross;
        Camera {
            rotation: Matrix3::identity() + cross * a + twice * b,
            right: Matrix3::identity() - cross * b + twice * c,
            translation: Vector3::new(values[3], values[4], values[5]),
            lens: [values[6], values[7], values[8]],
        }
    }
}

/// A problem at some values of its unknowns.
#[derive(Debug)]
pub struct BalAt<'a> {
    bal: &'a Bal,
    x: &'a [f64],
    cameras: Vec<Camera>,
}

impl BalAt<'_> {
    fn of(&self, observation: usize) -> (&Camera, Vector3<f64>, [f64; 2]) {
        let (camera, point, seen) = self.bal.seen[observation];
        let at = CAMERA * self.bal.cameras + 3 * point;
        (&self.cameras[camera], Vector3::new(self.x[at], self.x[at + 1], self.x[at + 2]), seen)
    }
}

impl Model for Bal {
    type At<'a> = BalAt<'a>;

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn at<'a>(&'a self, x: &'a [f64]) -> BalAt<'a> {
        BalAt { bal: self, x, cameras: x[..CAMERA * self.cameras].chunks(CAMERA).map(Camera::new).collect() }
    }
}

impl At for BalAt<'_> {
    fn residual(&self, observation: usize) -> Option<[f64; 2]> {
        let (camera, point, seen) = self.of(observation);
        let p = camera.rotation * point + camera.translation;
        let (x, y) = (-p.x / p.z, -p.y / p.z);
        let [f, k1, k2] = camera.lens;
        let r2 = x * x + y * y;
        let factor = f * (1.0 + r2 * (k1 + r2 * k2));
        Some([factor * x - seen[0], factor * y - seen[1]])
    }

    fn linearise(&self, observation: usize, row: &mut Row) -> bool {
        let (camera, point, seen) = self.of(observation);
        let rotated = camera.rotation * point;
        let p = rotated + camera.translation;
        let tangents = [-p.x / p.z, -p.y / p.z];
        let [x, y] = tangents;
        let [f, k1, k2] = camera.lens;
        let r2 = x * x + y * y;
        let radial = 1.0 + r2 * (k1 + r2 * k2);
        let slope = 2.0 * (k1 + 2.0 * r2 * k2);
        row.residual = [f * radial * x - seen[0], f * radial * y - seen[1]];
        let by_tangent =
            [[f * (radial + x * x * slope), f * x * y * slope], [f * x * y * slope, f * (radial + y * y * slope)]];
        let by_rotation = camera.rotation * point.cross_matrix() * camera.right;
        for e in 0..2 {
            let [a, b] = by_tangent[e];
            let by_p = Vector3::new(-a, -b, -(a * x + b * y)) / p.z;
            let rotation = -by_rotation.tr_mul(&by_p);
            let point = camera.rotation.tr_mul(&by_p);
            for k in 0..3 {
                row.station[e][k] = rotation[k];
                row.station[e][3 + k] = by_p[k];
                row.point[e][k] = point[k];
            }
            row.station[e][6] = radial * tangents[e];
            row.station[e][7] = f * r2 * tangents[e];
            row.station[e][8] = f * r2 * r2 * tangents[e];
        }
        true
    }
}
