//! A combined camera over the simulator's ground: its heads' frames by casting rays, stitched, beside the one frame that an
//! ideal camera of the virtual image would have taken.

use super::{Mismatch, Mosaic, Seam, against, mismatches, pairs, stitch};
use crate::camera::heads::{Rig, station_of};
use crate::camera::render::{Renderer, Station};
use crate::camera::render_camera;
use crate::world::Ground;
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::error::InputError;
use plumbline_survey::io::picture::{Bands, Picture};

/// Rays along each side of a pixel.
const SAMPLES: usize = 2;

/// The results.
#[derive(Clone, Debug)]
pub struct Simulated {
    /// The heads' frames.
    pub frames: Vec<Bands>,
    /// The virtual image made of them.
    pub mosaic: Mosaic,
    /// What an ideal camera sees from the virtual projection centre.
    pub ideal: Picture,
    /// Root mean square of the grey differences of both, over all pixels that a head sees.
    pub grey_rms_dn: f64,
    /// Mismatch of each pair of heads that overlap.
    pub seams: Vec<Mismatch>,
    /// Shifts between the mosaic and the ideal picture all over the image.
    pub off: Mismatch,
}

/// Renders what `truth`'s heads see from `station`, noise of `noise_dn` from `seed`, and stitches it by what `known` says of
/// them, for a plane `height_m` below or far away. Both files have the same virtual camera; where they are one, the
/// calibration is exact.
///
/// # Errors
/// As [`Rig::new`] and [`stitch`].
pub fn simulate(
    ground: &Ground,
    station: &Station,
    (truth, known): (&CameraFile, &CameraFile),
    height_m: Option<f64>,
    (noise_dn, seed): (f64, u64),
) -> Result<Simulated, InputError> {
    let picture = |file: &CameraFile, station: &Station, noise_dn: f64, index: u64| {
        let pixels = Renderer::new(render_camera(file), SAMPLES).render(ground, station, noise_dn, seed, index).pixels;
        Picture { cols: file.cols as usize, rows: file.rows as usize, pixels }
    };
    let frames: Vec<Bands> = (0..)
        .zip(&truth.heads)
        .map(|(index, head)| Bands(vec![picture(&head.camera(), &station_of(station, head), noise_dn, index)]))
        .collect();
    let ideal = picture(known, station, 0.0, 0);
    let rig = Rig::new(known, height_m)?;
    let mosaic = stitch(&rig, &frames, Seam::Feather, &|| ())?;
    let seams = mismatches(&rig, &frames, &pairs(&rig), &|| ())?;
    let seen = mosaic.samples.iter().zip(&ideal.pixels).filter(|(grey, _)| **grey > 0);
    let (sum, count) = seen.fold((0.0, 0.0), |(sum, count), (&ours, &ideal)| {
        (sum + (f64::from(ours) - f64::from(ideal)).powi(2), count + 1.0)
    });
    let image = Picture { cols: mosaic.size.0, rows: mosaic.size.1, pixels: mosaic.samples.clone() };
    let off = against(&rig, &image, &ideal);
    Ok(Simulated { frames, mosaic, ideal, grey_rms_dn: (sum / count).sqrt(), seams, off })
}
