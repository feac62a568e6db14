//! `plumbline intersect`: the ground points of points measured in two photos, with the exterior orientation at a stamp.

use super::exterior::{Triple, pair, point, triple};
use super::{finite, positive};
use crate::outcome::Failure::Input;
use crate::outcome::{Failure, Outcome};
use plumbline_sim::oracle::motion::{Exterior, Photo, intersect};
use plumbline_survey::error::InputError;
use serde::Serialize;
use std::fmt::Write;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Principal distance, mm
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    focal_mm: f64,
    /// Projection centre of the first photo where its shutter opens, metres across, along the flight, up
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "X,Y,Z")]
    station_1_m: Triple,
    /// Projection centre of the second photo where its shutter opens
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "X,Y,Z")]
    station_2_m: Triple,
    /// Angles phi, omega, kappa of both photos where the shutter opens
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "P,O,K", default_value = "0,0,0")]
    angles_deg: Triple,
    /// Those of the second photo, where they differ
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "P,O,K")]
    angles_2_deg: Option<Triple>,
    /// Their rates in both photos
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "P,O,K", default_value = "0,0,0")]
    rates_deg_s: Triple,
    /// Those of the second photo, where they differ
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "P,O,K")]
    rates_2_deg_s: Option<Triple>,
    /// Speed along Y, metres a second
    #[arg(long, value_parser = finite, allow_negative_numbers = true, default_value = "0")]
    speed_m_s: f64,
    /// Stamp of each photo, milliseconds after its shutter opened
    #[arg(long, value_parser = point, allow_hyphen_values = true, value_name = "T1,T2", default_value = "0,0")]
    stamps_ms: [f64; 2],
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// The images of one ground point in both photos, mm
    #[arg(last = true, required = true, value_parser = pair, value_name = "X1,Y1,X2,Y2")]
    points: Vec<[f64; 4]>,
}

#[derive(Serialize)]
struct Document {
    points: Vec<Point>,
}

/// A ground point.
#[derive(Serialize)]
struct Point {
    x_m: f64,
    y_m: f64,
    z_m: f64,
    /// Root mean square of what is left in the four image coordinates.
    rms_mm: f64,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let [first, second] = args.photos()?;
    let points = args
        .points
        .iter()
        .map(|&measured| ground(args.focal_mm, [first, second], measured))
        .collect::<Result<Vec<_>, _>>()?;
    let document = Document { points };
    Outcome::new(args.json, &document, || text_of(&document.points))
}

fn text_of(points: &[Point]) -> String {
    let mut text = String::from("           X m            Y m            Z m       rms mm\n");
    for p in points {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{:>14.6} {:>14.6} {:>14.6} {:>12.3e}", p.x_m, p.y_m, p.z_m, p.rms_mm);
    }
    text
}

impl Args {
    /// Both exterior orientations at their stamps.
    fn photos(&self) -> Result<[Exterior; 2], InputError> {
        let photo = |station: Triple, angles: Triple, rates: Triple| Photo {
            opening: Exterior { station_m: station.0, angles_rad: angles.radians() },
            rates_rad_s: rates.rates(),
            speed_m_s: self.speed_m_s,
            focal: self.focal_mm,
        };
        let angles_2 = self.angles_2_deg.unwrap_or(self.angles_deg);
        let rates_2 = self.rates_2_deg_s.unwrap_or(self.rates_deg_s);
        let [t1, t2] = self.stamps_ms.map(|ms| 1e-3 * ms);
        let is_far = |(t_s, rates): (f64, Triple)| {
            let mut each = rates.rates().into_iter().chain([self.speed_m_s]);
            each.any(|rate| (rate * t_s).abs() > FAR)
        };
        if let Some(k) = [(t1, self.rates_deg_s), (t2, rates_2)].into_iter().position(is_far) {
            return Err(InputError::new(format!(
                "--stamps-ms {},{}: {} ms after its shutter opened photo {} is out of all bounds at its speed and rates",
                self.stamps_ms[0],
                self.stamps_ms[1],
                self.stamps_ms[k],
                k + 1
            )));
        }
        Ok([
            photo(self.station_1_m, self.angles_deg, self.rates_deg_s).at(t1),
            photo(self.station_2_m, angles_2, rates_2).at(t2),
        ])
    }
}

/// How far a photo may be from where its shutter opened, metres or radians: beyond it nothing is meant.
const FAR: f64 = 1e9;

/// Least angle at which two rays meet in a point.
const MEETING_MIN_RAD: f64 = 1e-4;

/// The angle between the rays from a point to two stations.
fn meeting(point: [f64; 3], stations: [[f64; 3]; 2]) -> f64 {
    let [a, b] = stations.map(|station| -> [f64; 3] { std::array::from_fn(|i| station[i] - point[i]) });
    let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot: f64 = a.iter().zip(b).map(|(a, b)| a * b).sum();
    cross.iter().map(|c| c * c).sum::<f64>().sqrt().atan2(dot)
}

fn ground(focal: f64, [first, second]: [Exterior; 2], measured: [f64; 4]) -> Result<Point, Failure> {
    let [x1, y1, x2, y2] = measured;
    let lost = |why: &str| Input(InputError::new(format!("points {x1},{y1},{x2},{y2}: {why}")));
    let ground_m = intersect(focal, [(first, [x1, y1]), (second, [x2, y2])])
        .filter(|ground| ground.iter().all(|coordinate| coordinate.is_finite()))
        .ok_or_else(|| lost("their rays are parallel, the photos have no base across them"))?;
    // A point at the end of such rays is a guess: 1e-4 rad is a pixel of 12 µm at 120 mm.
    let meeting_rad = meeting(ground_m, [first.station_m, second.station_m]);
    if meeting_rad.is_nan() || meeting_rad < MEETING_MIN_RAD {
        return Err(lost(&format!("their rays meet at {:.1e} degrees only", meeting_rad.to_degrees())));
    }
    let behind = || lost("their rays meet behind a camera");
    let [[u1, v1], [u2, v2]] =
        [first.image(focal, ground_m).ok_or_else(behind)?, second.image(focal, ground_m).ok_or_else(behind)?];
    let squares: f64 = [u1 - x1, v1 - y1, u2 - x2, v2 - y2].iter().map(|left| left * left).sum();
    let [x_m, y_m, z_m] = ground_m;
    Ok(Point { x_m, y_m, z_m, rms_mm: (0.25 * squares).sqrt() })
}
