//! Where a rectified patch lies in the reference.
//!
//! [`search`]: masked normalised cross-correlation over whole-pixel shifts, [`refine`]: least-squares matching around
//! the peak to hundredths of a pixel with its covariance, [`judge`]: what a result must reach to become a fix, [`decide`]:
//! the three together, with the contest between two places that look alike.

pub mod decide;
mod histogram;
pub mod judge;
pub mod refine;
pub mod search;

pub use histogram::Limits;

/// A grey picture, or a window of one, as the matcher reads it.
#[derive(Clone, Copy, Debug)]
pub struct View<'a> {
    pixels: &'a [u8],
    size: (u16, u16),
    stride: usize,
}

impl<'a> View<'a> {
    /// Row-major picture of `size` (cols, rows); `None` when there are fewer pixels than that.
    pub fn new(pixels: &'a [u8], size: (u16, u16)) -> Option<Self> {
        let stride = size.0 as usize;
        (pixels.len() >= stride * size.1 as usize).then_some(View { pixels, size, stride })
    }

    /// The window of `size` whose top left pixel is (`col`, `row`); `None` when it does not lie wholly inside.
    pub fn window(&self, col: i32, row: i32, size: (u16, u16)) -> Option<View<'a>> {
        let fits = |at: i32, length: u16, limit: u16| at >= 0 && at.saturating_add(length as i32) <= limit as i32;
        if size.0 == 0 || size.1 == 0 || !fits(col, size.0, self.size.0) || !fits(row, size.1, self.size.1) {
            return None;
        }
        let first = row as usize * self.stride + col as usize;
        Some(View { pixels: self.pixels.get(first..)?, size, stride: self.stride })
    }

    /// Copies the view into `pixels`, every grey within the view's own [`Limits`]; the copy as a view. `None` when it
    /// does not fit.
    pub fn limited_into<'b>(&self, pixels: &'b mut [u8]) -> Option<View<'b>> {
        let (cols, rows) = (self.size.0 as usize, self.size.1 as usize);
        let mut histogram = histogram::Histogram::new();
        for row in 0..rows {
            histogram.add(self.run(row, 0, cols)?);
        }
        let limits = Limits::of(&histogram);
        for (row, to) in pixels.get_mut(..cols * rows)?.chunks_exact_mut(cols).enumerate() {
            for (to, &grey) in to.iter_mut().zip(self.run(row, 0, cols)?) {
                *to = limits.apply(grey);
            }
        }
        View::new(pixels, self.size)
    }

    /// The limits of the pixels in `runs`.
    pub fn limits(&self, runs: &[crate::rectify::Run]) -> Limits {
        let mut histogram = histogram::Histogram::new();
        for run in runs {
            let length = run.end.saturating_sub(run.start) as usize;
            histogram.add(self.run(run.row as usize, run.start as usize, length).unwrap_or(&[]));
        }
        Limits::of(&histogram)
    }

    /// (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// `length` pixels of `row` from `col` on; `None` outside the view.
    #[inline]
    pub fn run(&self, row: usize, col: usize, length: usize) -> Option<&'a [u8]> {
        if row >= self.size.1 as usize || col.checked_add(length).is_none_or(|end| end > self.size.0 as usize) {
            return None;
        }
        self.pixels.get(row * self.stride + col..row * self.stride + col + length)
    }
}
