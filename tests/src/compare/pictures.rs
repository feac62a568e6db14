//! What the frames show.

use super::{Failure, Grey};
use plumbline_firmware::bench::texture;
use plumbline_survey::io::data::shared_data;
use plumbline_survey::io::picture::{Picture, read_grey};
use std::f64::consts::TAU;
use std::path::Path;

/// Side of the cases' frames, pixels.
pub const SIDE: u16 = 512;
/// Side of the made-up ground, pixels.
const LAND_SIDE: usize = 1667;
/// Of textures.
const SEED: u32 = 1;
/// The orthophoto, in the folder of the real data.
const VIENNA: &str = "images/vienna_ortho_2023_30cm.tif";
/// Waves of the smooth picture: length in pixels, direction in radians, height in grey levels. The shortest spans eight
/// cells of the coarsest case.
const WAVES: [(f64, f64, f64); 3] = [(120.0, 0.3, 50.0), (170.0, 1.7, 40.0), (260.0, 2.9, 30.0)];

/// The prototypes' texture: gradient, checks of 32 grey levels, five bits of white noise.
pub fn prototype() -> Grey {
    let mut pixels = vec![0; usize::from(SIDE) * usize::from(SIDE)];
    texture::checks(&mut pixels, SIDE.into(), SEED);
    Grey { pixels, size: (SIDE, SIDE) }
}

/// Made-up ground, as large as the orthophoto.
pub fn land() -> Picture {
    let mut pixels = vec![0; LAND_SIDE * LAND_SIDE];
    texture::ground(&mut pixels, LAND_SIDE, SEED);
    Picture { cols: LAND_SIDE, rows: LAND_SIDE, pixels }
}

/// The orthophoto of Vienna, 0.3 m a pixel. `Ok(None)` without the real data.
///
/// # Errors
/// A sentence on a file that is there and is no such picture.
pub fn vienna() -> Result<Option<Picture>, Failure> {
    let Some(path) = shared_data().map(|data| data.join(VIENNA)).filter(|path| path.exists()) else {
        return Ok(None);
    };
    let picture = read_grey(&path).map_err(|error| error.to_string())?;
    let side = usize::from(SIDE);
    if picture.cols < side || picture.rows < side {
        return Err(format!("{} has fewer than {SIDE} x {SIDE} pixels", path.display()));
    }
    Ok(Some(picture))
}

/// The middle of a picture, as if a camera had taken it.
pub fn middle(picture: &Picture) -> Grey {
    let side = usize::from(SIDE);
    let (left, top) = ((picture.cols - side) / 2, (picture.rows - side) / 2);
    let rows = picture.pixels.chunks_exact(picture.cols).skip(top).take(side);
    let pixels = rows.flat_map(|row| row[left..left + side].iter().copied()).collect();
    Grey { pixels, size: (SIDE, SIDE) }
}

/// A picture without detail: three waves of 120 px and more, rounded. On it all kernels must agree, and do not if they
/// disagree about where a pixel's centre lies.
pub fn smooth((cols, rows): (u16, u16)) -> Grey {
    let grey = |row: u16, col: u16| {
        let wave = |&(length, direction, height): &(f64, f64, f64)| {
            height
                * (TAU / length * (f64::from(col) * f64::cos(direction) + f64::from(row) * f64::sin(direction))).sin()
        };
        (128.0 + WAVES.iter().map(wave).sum::<f64>()).round().clamp(0.0, 255.0) as u8
    };
    Grey { pixels: (0..rows).flat_map(|row| (0..cols).map(move |col| grey(row, col))).collect(), size: (cols, rows) }
}

/// Any picture as a frame.
///
/// # Errors
/// A sentence where it cannot be read, or is too large for a camera.
pub fn file(path: &Path) -> Result<Grey, Failure> {
    let picture = read_grey(path).map_err(|error| error.to_string())?;
    match (u16::try_from(picture.cols), u16::try_from(picture.rows)) {
        (Ok(cols), Ok(rows)) => Ok(Grey { pixels: picture.pixels, size: (cols, rows) }),
        _ => Err(format!("{} is larger than any camera's frame", path.display())),
    }
}
