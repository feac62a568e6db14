//! `plumbline motion`: how far image points move during an exposure, and where the centroids of their tracks lie.

use super::exterior::{Triple, triple};
use super::{finite, positive};
use crate::outcome::Failure::Input;
use crate::outcome::{Failure, Outcome};
use plumbline_sim::oracle::motion::{Exterior, Photo};
use plumbline_survey::camera_file::no_pixel_mm;
use plumbline_survey::error::InputError;
use serde::Serialize;
use std::fmt::Write;

#[derive(Debug, clap::Args)]
pub struct Args {
    /// Principal distance, mm
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    focal_mm: f64,
    /// Residual angles where the shutter opens: phi, omega, kappa (paper 000: about flight direction, right, up)
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "P,O,K", default_value = "0,0,0")]
    angles_deg: Triple,
    /// Their rates
    #[arg(long, value_parser = triple, allow_hyphen_values = true, value_name = "P,O,K", default_value = "0,0,0")]
    rates_deg_s: Triple,
    /// Speed along y, metres a second
    #[arg(long, value_parser = finite, allow_negative_numbers = true)]
    speed_m_s: f64,
    /// Height above the level ground, metres
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    height_m: f64,
    /// Exposure
    #[arg(long, value_parser = positive, allow_negative_numbers = true)]
    exposure_ms: f64,
    /// Pixel; with it the lengths of the motion are printed in pixels as well
    #[arg(long, value_parser = pixel, allow_negative_numbers = true)]
    pixel_mm: Option<f64>,
    /// Print one JSON document
    #[arg(long)]
    json: bool,
    /// Image points X,Y where the shutter opens, mm across and along the flight
    #[arg(last = true, required = true, value_parser = super::exterior::point, value_name = "X,Y")]
    points: Vec<[f64; 2]>,
}

/// The side of a pixel, mm.
fn pixel(text: &str) -> Result<f64, String> {
    let side_mm = positive(text)?;
    no_pixel_mm(side_mm, "--pixel-mm ").map_or(Ok(side_mm), |wanted| Err(format!("must be {wanted}")))
}

#[derive(Serialize)]
struct Document {
    points: Vec<Point>,
}

/// Motion of one point.
#[derive(Serialize)]
struct Point {
    x_mm: f64,
    y_mm: f64,
    /// The ground point seen there, relative to the point plumb below the station where the shutter opens.
    ground_m: [f64; 3],
    /// Eq. 9 and 10.
    exact_mm: [f64; 2],
    /// Corrected eq. 21.
    first_order_mm: [f64; 2],
    /// Where the centroid of the track lies on the image plane.
    centroid_mm: [f64; 2],
    /// Where the point is at mid-exposure.
    mid_exposure_mm: [f64; 2],
    /// Length of the exact motion.
    exact_px: Option<f64>,
    /// Length of the first-order one.
    first_order_px: Option<f64>,
}

pub fn run(args: &Args) -> Result<Outcome, Failure> {
    let points = args.points.iter().map(|&at| point(args, at)).collect::<Result<Vec<_>, _>>()?;
    let document = Document { points };
    Outcome::new(args.json, &document, || text_of(&document.points))
}

fn text_of(points: &[Point]) -> String {
    let heading = "      x mm       y mm     exact um (x, y)          eq. 21 um (x, y)         centroid mm (x, y)";
    let has_px = points.iter().any(|p| p.exact_px.is_some());
    let mut text =
        if has_px { format!("{heading:<99} {:>10} {:>10}\n", "exact px", "eq. 21 px") } else { format!("{heading}\n") };
    for p in points {
        let ([ex, ey], [fx, fy]) = (p.exact_mm.map(|mm| 1e3 * mm), p.first_order_mm.map(|mm| 1e3 * mm));
        let [cx, cy] = p.centroid_mm;
        // Writing to a string cannot fail.
        let _ = write!(
            text,
            "{:>10.4} {:>10.4} {ex:>11.6} {ey:>11.6}  {fx:>11.6} {fy:>11.6}  {cx:>13.8} {cy:>13.8}",
            p.x_mm, p.y_mm
        );
        if let (Some(exact), Some(first_order)) = (p.exact_px, p.first_order_px) {
            let _ = write!(text, " {exact:>10.6} {first_order:>10.6}");
        }
        text.push('\n');
    }
    text
}

fn point(args: &Args, at: [f64; 2]) -> Result<Point, Failure> {
    let photo = Photo {
        opening: Exterior { station_m: [0.0, 0.0, args.height_m], angles_rad: args.angles_deg.radians() },
        rates_rad_s: args.rates_deg_s.rates(),
        speed_m_s: args.speed_m_s,
        focal: args.focal_mm,
    };
    let exposure_s = 1e-3 * args.exposure_ms;
    let lost = |why: &str| Input(InputError::new(format!("point {},{}: {why}", at[0], at[1])));
    let ground_m = photo.opening.ground(photo.focal, at, 0.0).ok_or_else(|| lost("it sees no ground"))?;
    let leaves = || lost("its ground point leaves the picture during the exposure");
    let length = |[x, y]: [f64; 2]| args.pixel_mm.map(|pixel| x.hypot(y) / pixel);
    let exact_mm = photo.exact(ground_m, exposure_s).ok_or_else(leaves)?;
    let first_order_mm = photo.first_order(at, args.height_m, exposure_s);
    let point = Point {
        x_mm: at[0],
        y_mm: at[1],
        ground_m,
        exact_mm,
        first_order_mm,
        centroid_mm: photo.centroid(ground_m, exposure_s).ok_or_else(leaves)?,
        mid_exposure_mm: photo.at(0.5 * exposure_s).image(photo.focal, ground_m).ok_or_else(leaves)?,
        exact_px: length(exact_mm),
        first_order_px: length(first_order_mm),
    };
    let numbers = [point.exact_mm, point.first_order_mm, point.centroid_mm, point.mid_exposure_mm];
    if numbers.as_flattened().iter().chain(&ground_m).all(|number| number.is_finite()) {
        Ok(point)
    } else {
        Err(lost("its motion is beyond the range of numbers"))
    }
}
