//! The tilt that a picture's perspective shows, for pictures rotated exactly, in `f64`.

use super::{PATCH, PRIOR, RADIUS, matched, reference_size, view};
use plumbline_core::image::Run;
use plumbline_core::matching::Prior;
use plumbline_core::matching::perspective::{Curvature, curvature};
use plumbline_tests::seeded::Random;
use plumbline_tests::textures::{Ground, Picture, Placement, all_valid, footprint};

/// Heights above ground in pixels at which patches of 34 and 64 pixels are the footprint of a camera of 60 degrees.
const CAMERAS: [((u16, u16), f64); 2] = [(PATCH, 30.0), ((64, 64), 55.0)];

/// What is rectified to (x, y) from the nadir lies where the ray (x, y, -H), rotated about both horizontal axes, meets the
/// ground: the nadir itself at H tan of the tilt.
fn meets(height: f64, [tilt_x, tilt_y]: [f64; 2], (x, y): (f64, f64)) -> (f64, f64) {
    let ((s, c), (t, d)) = (tilt_x.sin_cos(), tilt_y.sin_cos());
    let (x, z) = (c * x + s * height, s * x - c * height);
    let (y, z) = (d * y - t * z, t * y + d * z);
    (x * height / -z, y * height / -z)
}

/// The patch of a camera so high with such an error of its attitude, whose nadir lies at `at` on the ground.
fn tilted(
    (size, height): ((u16, u16), f64),
    ground: &Ground,
    nadir: (i16, i16),
    (at, tilt_rad, noise): ((f64, f64), [f64; 2], f64),
    random: &mut Random,
) -> Picture {
    let middle = |side: u16| 0.5 * (f64::from(side) - 1.0);
    let greys = (0..size.1).flat_map(|row| (0..size.0).map(move |col| (col, row))).map(|(col, row)| {
        let own = (f64::from(col) - middle(size.0), f64::from(row) - middle(size.1));
        let from = (own.0 - f64::from(nadir.0), own.1 - f64::from(nadir.1));
        let (x, y) = meets(height, tilt_rad, from);
        let grey = ground.at((at.0 + x + f64::from(nadir.0), at.1 + y + f64::from(nadir.1)));
        (grey + noise * random.normal()).round().clamp(0.0, 255.0) as u8
    });
    Picture { pixels: greys.collect(), size }
}

/// What the picture shows, and where its match without that puts the nadir, pixels from the middle of the reference.
fn shown(
    patch: &Picture,
    runs: &[Run],
    reference: &Picture,
    nadir: (i16, i16),
    prior: Prior,
) -> Option<(Curvature, [f64; 2])> {
    let (peak, solution) = matched(patch, runs, reference, prior);
    let found = ((peak.d_col, peak.d_row), &solution);
    let mut bytes = vec![0; patch.pixels.len()];
    let curvature = curvature((&view(patch), runs), (&view(reference), RADIUS), found, nadir, prior, &mut bytes)?;
    let ((col, row), (turn, scale)) = ((f64::from(nadir.0), f64::from(nadir.1)), solution.turn_and_scale);
    let (turn, scale) = (f64::from(turn), f64::from(scale));
    let by = [scale * col - turn * row, scale * row + turn * col];
    Some((curvature, [f64::from(solution.d_col) + by[0], f64::from(solution.d_row) + by[1]]))
}

/// Two numbers and their covariance.
type Off = ([f64; 2], [[f64; 2]; 2]);

/// Squared error over the covariance.
fn nees(([x, y], c): &Off) -> f64 {
    let determinant = c[0][0] * c[1][1] - c[0][1] * c[1][0];
    (x * x * c[1][1] - 2.0 * x * y * c[0][1] + y * y * c[0][0]) / determinant
}

/// The tilt that a picture shows less the true one, along columns and rows, radians, and the nadir corrected for it less the true one,
/// pixels; `None` where it shows none. The picture lies around the nadir or beside it, and is whole or not.
fn off(number: u64, camera: ((u16, u16), f64), tilt_rad: [f64; 2], random: &mut Random) -> Option<(Off, Off)> {
    let (size, height) = camera;
    let ground = Ground::new(100 + number, 40.0, 5.0);
    let nadir = if number.is_multiple_of(3) { (0, 0) } else { (random.between(-12.0, 12.0) as i16, 9) };
    // The search reaches the match: the tilt moves the nadir by up to six pixels.
    let at = (random.between(-2.0, 2.0), random.between(-2.0, 2.0));
    let patch = tilted(camera, &ground, nadir, (at, tilt_rad, 3.0), random);
    let reference = ground.picture(reference_size(size), Placement::default(), 3.0, random);
    let runs = if number.is_multiple_of(2) { all_valid(size) } else { footprint(size) };
    let (found, nadir_px) = shown(&patch, &runs, &reference, nadir, PRIOR)?;
    // The displacement of the nadir over the height is the tangent of the tilt.
    let off = [0, 1].map(|axis| f64::from(found.per_px[axis]) * height - tilt_rad[axis].tan());
    let covariance = found.covariance().map(|c| f64::from(c) * height * height).into();
    let (by, resected) = found.resected(height as f32);
    let nadir_off = [nadir_px[0] + f64::from(by.x) - at.0, nadir_px[1] + f64::from(by.y) - at.1];
    Some(((off, covariance), (nadir_off, resected.map(f64::from).into())))
}

/// Tilts of up to two degrees: errors as their covariance says, which tells two degrees from none in one picture. So the nadir is
/// known without the attitude.
#[test]
fn perspective_shows_the_tilt_with_its_covariance() {
    let mut random = Random::new(71);
    for (camera, sigma_max_deg) in CAMERAS.into_iter().zip([0.5, 0.2]) {
        let (mut squares, mut sigmas, count) = ([0.0; 2], Vec::new(), 60);
        for number in 0..count {
            let tilt_rad = [(); 2].map(|()| random.between(-0.035, 0.035));
            let Some((tilt, nadir)) = off(number, camera, tilt_rad, &mut random) else { continue };
            squares[0] += nees(&tilt);
            squares[1] += nees(&nadir);
            sigmas.push(tilt.1[0][0].max(tilt.1[1][1]).sqrt().to_degrees());
        }
        sigmas.sort_by(f64::total_cmp);
        let (found, median_deg) = (sigmas.len(), sigmas[sigmas.len() / 2]);
        assert!(found as f64 >= 0.95 * count as f64, "{found} of {count}");
        for squares in squares {
            let nees = squares / found as f64;
            assert!((0.2..3.0).contains(&nees), "{nees}");
        }
        assert!(median_deg < sigma_max_deg, "{median_deg}");
    }
}

/// The displacements are of first order in the tilt: of six degrees up to a fifth is missing.
#[test]
fn a_large_tilt_is_shown_to_a_fifth() {
    let mut random = Random::new(72);
    for camera in CAMERAS {
        for number in 0..40 {
            let direction = random.between(0.0, std::f64::consts::TAU);
            let tilt_rad = [0.1 * direction.cos(), 0.1 * direction.sin()];
            let Some((([x, y], c), _)) = off(number, camera, tilt_rad, &mut random) else { continue };
            let sigma = c[0][0].max(c[1][1]).sqrt();
            assert!(
                x.hypot(y) < 0.02 + 0.01 && x.hypot(y) < 4.0 * sigma,
                "{tilt_rad:?}: off by {x}, {y}, sigma {sigma}"
            );
        }
    }
}
