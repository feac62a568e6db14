//! The exact area average: what every area kernel approximates.

use super::projection::{Camera, Distortion, pixel_from_frame};
use super::remap::{Grid, Image, frame_from_patch};
use super::rotation::Matrix3;

/// Chords an edge of a cell under lens distortion; without distortion a straight edge stays straight and one is exact.
/// The sagitta falls with the square: an edge bent by 0.1 px is met to 4e-4 px.
const CHORDS_WITH_DISTORTION: usize = 16;

/// A point in the frame: (column, row), pixel centres at integers.
type Point = (f64, f64);

/// A half-plane of one coordinate that a polygon is clipped to.
#[derive(Debug, Clone, Copy)]
enum Side {
    ColAbove(f64),
    ColBelow(f64),
    RowAbove(f64),
    RowBelow(f64),
}

/// The patch, row by row: the mean of the frame over the region that each cell covers IN THE FRAME.
///
/// The frame is taken as piecewise constant, pixel (c, r) filling the square of side 1 around (c, r). Every square is
/// cut with the cell's outline and weighs by the area of the cut. Areas are areas of the frame: inside a cell the
/// ground scale varies, so this is not quite the mean over ground area. `None` where the outline leaves the frame's
/// outermost pixel borders, or lies behind the camera.
pub fn exact_area(image: &Image, a: &Matrix3, camera: &Camera, grid: &Grid) -> Vec<Option<f64>> {
    let mut patch = Vec::new();
    for row in 0..grid.rows {
        for col in 0..grid.cols {
            patch.push(outline(a, camera, grid, col, row).and_then(|polygon| mean_over(image, &polygon)));
        }
    }
    patch
}

/// The outline of a cell in the frame, `None` when a part of it lies behind the camera.
fn outline(a: &Matrix3, camera: &Camera, grid: &Grid, col: usize, row: usize) -> Option<Vec<Point>> {
    const CORNERS: [Point; 4] = [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)];
    let chords = if camera.distortion == Distortion::default() { 1 } else { CHORDS_WITH_DISTORTION };
    let mut polygon = Vec::new();
    for (i, from) in CORNERS.iter().enumerate() {
        let to = CORNERS[(i + 1) % 4];
        for chord in 0..chords {
            let t = chord as f64 / chords as f64;
            let du = from.0 + t * (to.0 - from.0);
            let dv = from.1 + t * (to.1 - from.1);
            let p = frame_from_patch(a, camera, grid, col as f64 + du, row as f64 + dv);
            if !p.in_front {
                return None;
            }
            polygon.push(pixel_from_frame(camera, p.m, p.n));
        }
    }
    Some(polygon)
}

fn mean_over(image: &Image, polygon: &[Point]) -> Option<f64> {
    let inside = |x: f64, count: usize| x >= -0.5 && x <= count as f64 - 0.5;
    if !polygon.iter().all(|p| inside(p.0, image.cols()) && inside(p.1, image.rows())) {
        return None;
    }
    let area = signed_area(polygon);
    if area == 0.0 {
        return None;
    }
    let mut sum = 0.0;
    for row in pixels(polygon.iter().map(|p| p.1), image.rows()) {
        let strip = clip(polygon, Side::RowAbove(row as f64 - 0.5));
        let strip = clip(&strip, Side::RowBelow(row as f64 + 0.5));
        for col in pixels(strip.iter().map(|p| p.0), image.cols()) {
            let piece = clip(&strip, Side::ColAbove(col as f64 - 0.5));
            let piece = clip(&piece, Side::ColBelow(col as f64 + 0.5));
            sum += signed_area(&piece) * image.get(col, row)?;
        }
    }
    Some(sum / area)
}

/// The pixels along one axis that a set of coordinates reaches, the borders included.
fn pixels(coordinates: impl Iterator<Item = f64>, count: usize) -> std::ops::Range<usize> {
    let (low, high) = coordinates.fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(x), h.max(x)));
    let first = (low + 0.5).floor().max(0.0) as usize;
    let end = ((high + 0.5).floor().max(-1.0) + 1.0) as usize;
    first..end.min(count)
}

/// Sutherland-Hodgman against one half-plane. A polygon that is not convex may keep edges that run back along the
/// border; they enclose no area.
fn clip(polygon: &[Point], side: Side) -> Vec<Point> {
    let inside_by = |p: &Point| match side {
        Side::ColAbove(x) => p.0 - x,
        Side::ColBelow(x) => x - p.0,
        Side::RowAbove(y) => p.1 - y,
        Side::RowBelow(y) => y - p.1,
    };
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (i, from) in polygon.iter().enumerate() {
        let to = &polygon[(i + 1) % polygon.len()];
        let (d_from, d_to) = (inside_by(from), inside_by(to));
        if d_from >= 0.0 {
            kept.push(*from);
        }
        if (d_from > 0.0 && d_to < 0.0) || (d_from < 0.0 && d_to > 0.0) {
            let t = d_from / (d_from - d_to);
            kept.push((from.0 + t * (to.0 - from.0), from.1 + t * (to.1 - from.1)));
        }
    }
    kept
}

/// Shoelace formula about the first vertex, so that far-off coordinates cost no digits.
fn signed_area(polygon: &[Point]) -> f64 {
    let Some(origin) = polygon.first() else { return 0.0 };
    let shifted = |p: &Point| (p.0 - origin.0, p.1 - origin.1);
    let twice: f64 = polygon
        .windows(2)
        .map(|pair| {
            let (p, q) = (shifted(&pair[0]), shifted(&pair[1]));
            p.0 * q.1 - q.0 * p.1
        })
        .sum();
    twice / 2.0
}
