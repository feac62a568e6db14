//! A bound of the curvature of a patch's lines in the frame: what decides how long a stretch of one may be followed as a
//! parabola.

use super::scanline::ScanlineMap;
use crate::homography::FrameFromPatch;

/// Pieces of a line at whose ends the map is evaluated. Chosen between 3, the fewest that have a third difference, and the
/// cells of a line.
const PIECES: usize = 8;
/// Largest error of a parabola through both ends and the middle of a stretch, over its third difference: 1/(72 √3). The
/// third difference over a stretch of L cells is L³ x''' itself.
const PER_THIRD: f32 = 1.0 / 124.7;

/// The largest differences along a patch's lines.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurvatureBound {
    /// Cells of a piece.
    piece: f32,
    /// Second and third differences from piece to piece, frame pixels.
    second: f32,
    third: f32,
}

impl CurvatureBound {
    /// Of a patch in a frame of `size` (cols, rows). Differences are taken along the borders and the middle, where a
    /// homography has its extremes, and doubled where a lens distortion or a rolling shutter
    /// may peak in between.
    #[inline(never)]
    pub(super) fn new(map: &FrameFromPatch<'_>, size: (f32, f32)) -> Self {
        let (cols, rows) = map.size();
        let piece = cols as f32 / PIECES as f32;
        let (mut second, mut third) = (0.0f32, 0.0f32);
        let mut is_steep = false;
        // The borders and the middle first; where they pass the horizon, what lies between them as well.
        for eighth in [0u8, 4, 8, 1, 2, 3, 5, 6, 7] {
            if eighth == 1 && !is_steep {
                break;
            }
            let row = eighth as f32 * 0.125 * rows as f32 - 0.5;
            let scanline = ScanlineMap::along(map, row);
            let mut last: [Option<(f32, f32)>; 3] = [None; 3];
            for end in 0..=PIECES as u16 {
                let now = scanline.position(end as f32 * piece - 0.5);
                is_steep |= now.is_none();
                if let ([Some(a), Some(b), Some(c)], Some(d)) = (last, now) {
                    // What lies wholly off the frame is never read.
                    let is_off = |a: f32, d: f32, limit: f32| (a < 0.0 && d < 0.0) || (a > limit && d > limit);
                    if !is_off(a.0, d.0, size.0) && !is_off(a.1, d.1, size.1) {
                        for (a, b, c, d) in [(a.0, b.0, c.0, d.0), (a.1, b.1, c.1, d.1)] {
                            second = larger(larger(second, a - 2.0 * b + c), b - 2.0 * c + d);
                            third = larger(third, d - a - 3.0 * (c - b));
                        }
                    }
                }
                last = [last[1], last[2], now];
            }
        }
        let doubled = if map.is_nonlinear() { 2.0 } else { 1.0 };
        CurvatureBound { piece, second: doubled * second, third: doubled * third }
    }

    /// How far a parabola through both ends and the middle of `cells` is off at most, frame pixels.
    pub(super) fn parabola_error(&self, cells: f32) -> f32 {
        let pieces = cells / self.piece;
        PER_THIRD * self.third * pieces * pieces * pieces
    }

    /// Second derivative by cells, frame pixels.
    pub(super) fn second(&self) -> f32 {
        self.second / (self.piece * self.piece)
    }
}

/// The larger in size. A call of the library's own is dearer than the comparison.
#[inline(always)]
fn larger(most: f32, difference: f32) -> f32 {
    let size = difference.abs();
    if size > most { size } else { most }
}
