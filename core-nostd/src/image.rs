//! Image primitives: a grey picture or a window of one, and the runs of its valid pixels.

/// A horizontal run of valid pixels of a patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Run {
    /// Row of the patch.
    pub row: u16,
    /// First valid column.
    pub start: u16,
    /// One past the last valid column.
    pub end: u16,
}

/// A grey picture, or a window of one: pixels that somebody else owns.
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

    /// Picture of `size` whose rows begin `stride` bytes apart. Rows that `pixels` lack read as empty.
    pub(crate) fn with_stride(pixels: &'a [u8], size: (u16, u16), stride: usize) -> Self {
        View { pixels, size, stride }
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

    /// (cols, rows).
    pub fn size(&self) -> (u16, u16) {
        self.size
    }

    /// Bytes from one row to the next.
    #[inline]
    pub(crate) fn stride(&self) -> usize {
        self.stride
    }

    /// `length` pixels of `row` from `col` on; `None` outside the view.
    #[inline]
    pub fn run(&self, row: usize, col: usize, length: usize) -> Option<&'a [u8]> {
        if row >= self.size.1 as usize || col.checked_add(length).is_none_or(|end| end > self.size.0 as usize) {
            return None;
        }
        self.pixels.get(row * self.stride + col..row * self.stride + col + length)
    }

    /// The pixels of `row` from `col` on, then those of the rows behind it and whatever follows; empty outside.
    #[inline]
    pub(crate) fn from(&self, row: usize, col: usize) -> &'a [u8] {
        self.pixels.get(row * self.stride + col..).unwrap_or(&[])
    }
}
