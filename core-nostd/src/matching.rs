//! Where a rectified patch lies in the reference.
//!
//! [`search`]: masked normalised cross-correlation over whole-pixel shifts, [`refine`]: least-squares matching around
//! the peak to hundredths of a pixel with its covariance, [`judge`]: whether the result deserves to become a fix.

pub mod judge;
pub mod refine;
pub mod search;

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
        let fits = |at: i32, length: u16, limit: u16| at >= 0 && at + length as i32 <= limit as i32;
        if size.0 == 0 || size.1 == 0 || !fits(col, size.0, self.size.0) || !fits(row, size.1, self.size.1) {
            return None;
        }
        let first = row as usize * self.stride + col as usize;
        Some(View { pixels: self.pixels.get(first..)?, size, stride: self.stride })
    }

    /// (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// `length` pixels of `row` from `col` on; `None` outside the view.
    #[inline]
    pub fn run(&self, row: usize, col: usize, length: usize) -> Option<&'a [u8]> {
        if row >= self.size.1 as usize || col + length > self.size.0 as usize {
            return None;
        }
        self.pixels.get(row * self.stride + col..row * self.stride + col + length)
    }
}
