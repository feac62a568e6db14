use super::{Dem, Frame};
use crate::error::InputError;
use crate::raster::Raster;
use std::path::{Path, PathBuf};
#[derive(Debug)]
pub struct DemFile {
    path: PathBuf,
    r: Raster,
}
impl DemFile {
    pub fn open(path: &Path) -> Result<Self, InputError> {
        Ok(Self { path: path.into(), r: Raster::read(path)? })
    }
    pub fn path(&self) -> &Path {
        &self.path
    }
    pub fn size(&self) -> (usize, usize) {
        (self.r.cols, self.r.rows)
    }
    pub fn epsg(&self) -> Option<u32> {
        self.r.crs
    }
    pub fn bounds(&self) -> [f64; 4] {
        let (x0, y1) = self.r.geo.world_from_pixel(0.0, 0.0);
        let (x1, y0) = self.r.geo.world_from_pixel((self.r.cols - 1) as f64, (self.r.rows - 1) as f64);
        [x0, y0, x1, y1]
    }
    pub fn window(&self, frame: &Frame, _: [f64; 4], _: &mut dyn FnMut(u64, u64)) -> Result<Dem, InputError> {
        let [x0, y0, x1, y1] = self.bounds();
        let ([w, s], [e, n]) = (frame.metres([x0, y0]), frame.metres([x1, y1]));
        let (c, r) = self.size();
        Ok(Dem {
            cols: c,
            rows: r,
            west_m: w,
            south_m: s,
            step_m: [(e - w) / (c - 1) as f64, (n - s) / (r - 1) as f64],
            heights: (0..c * r).map(|k| self.r.sample(k % c, r - 1 - k / c, 0).map_or(f64::NAN, f64::from)).collect(),
        })
    }
}
