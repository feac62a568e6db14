//! How far two heads put the same direction apart in the virtual image.

use super::symmetrise::mount;
use crate::adjust::Interior;
use crate::adjust::rig::{HEAD, LENS};
use nalgebra::Vector3;

/// A virtual image: principal distance and half sides, pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Virtual {
    /// Principal distance.
    pub f_px: f64,
    /// Half the columns and half the rows.
    pub half_px: [f64; 2],
    /// Half the columns and half the rows of a head's frame.
    pub head_half_px: [f64; 2],
}

/// A mismatch at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mismatch {
    /// The two heads.
    pub heads: [usize; 2],
    /// Where in the virtual image, x right and y up, pixels.
    pub at_px: [f64; 2],
    /// Where the first head shows it minus where the second does, pixels.
    pub by_px: [f64; 2],
}

impl Mismatch {
    /// Its length, pixels.
    #[must_use]
    pub fn length_px(&self) -> f64 {
        self.by_px[0].hypot(self.by_px[1])
    }
}

/// Root mean square and largest length.
#[must_use]
pub fn rms_and_max(mismatches: &[Mismatch]) -> (f64, f64) {
    let squares: f64 = mismatches.iter().map(|mismatch| mismatch.length_px().powi(2)).sum();
    let max = mismatches.iter().fold(0.0, |max: f64, mismatch| max.max(mismatch.length_px()));
    ((squares / mismatches.len().max(1) as f64).sqrt(), max)
}

/// Mismatches on a grid of `step_px` over the virtual image: every direction is imaged by the heads as they are
/// (`truth`) and put into the virtual image by the heads as they were calibrated, wherever two of them see it.
///
/// Distant ground: the centres do not enter; what they do is the parallax of section 2.2. A turn of all heads together is the
/// virtual camera's orientation and no seam.
#[must_use]
pub fn mismatches(truth: &[[f64; HEAD]], calibrated: &[[f64; HEAD]], of: &Virtual, step_px: f64) -> Vec<Mismatch> {
    let steps = of.half_px.map(|half| (half / step_px).floor() as i32);
    let mut mismatches = Vec::new();
    for row in -steps[1]..=steps[1] {
        for col in -steps[0]..=steps[0] {
            let at_px = [f64::from(col) * step_px, f64::from(row) * step_px];
            let ray = Vector3::new(at_px[0], at_px[1], -of.f_px);
            let seen: Vec<(usize, [f64; 2])> = (0..truth.len())
                .filter_map(|head| {
                    let image = image_of(&truth[head], &ray, of.head_half_px)?;
                    let back = mount(&calibrated[head]) * ray_of(&calibrated[head], image)?;
                    Some((head, [-of.f_px * back.x / back.z, -of.f_px * back.y / back.z]))
                })
                .collect();
            for (k, (first, a)) in seen.iter().enumerate() {
                for (second, b) in &seen[k + 1..] {
                    mismatches.push(Mismatch { heads: [*first, *second], at_px, by_px: [a[0] - b[0], a[1] - b[1]] });
                }
            }
        }
    }
    mismatches
}

fn interior(head: &[f64; HEAD]) -> Interior {
    Interior(std::array::from_fn(|k| head[LENS + k]))
}

/// How far beyond the frame, in half sides, a lens may bring a direction back into it.
const BEYOND: f64 = 1.5;

/// Where a head's frame shows a direction, if it does.
#[must_use]
pub fn image_of(head: &[f64; HEAD], ray: &Vector3<f64>, half_px: [f64; 2]) -> Option<[f64; 2]> {
    let u = mount(head).tr_mul(ray);
    if u.z >= 0.0 {
        return None;
    }
    // Far beyond the frame the lens' polynomial means nothing, and may fold back into it.
    let tangents = [-u.x / u.z, -u.y / u.z];
    if (0..2).any(|k| tangents[k].abs() > BEYOND * half_px[k] / head[LENS]) {
        return None;
    }
    let image = interior(head).image(tangents);
    (image[0].abs() <= half_px[0] && image[1].abs() <= half_px[1]).then_some(image)
}

/// The direction, in the head, of an image point: the lens undone by Newton's method.
#[must_use]
pub fn ray_of(head: &[f64; HEAD], image_px: [f64; 2]) -> Option<Vector3<f64>> {
    let lens = interior(head);
    let [c, xp, yp, ..] = lens.0;
    let mut tangents = [(image_px[0] - xp) / c, (image_px[1] - yp) / c];
    for _ in 0..20 {
        let imaged = lens.imaged(tangents);
        let off = [0, 1].map(|k| image_px[k] - imaged.point_px[k]);
        let [[a, b], [d, e]] = imaged.by_tangent;
        let determinant = a * e - b * d;
        let step = [(e * off[0] - b * off[1]) / determinant, (a * off[1] - d * off[0]) / determinant];
        tangents = [tangents[0] + step[0], tangents[1] + step[1]];
        if step[0].abs() + step[1].abs() < 1e-14 {
            return Some(Vector3::new(tangents[0], tangents[1], -1.0));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::adjust::rig::Head;

    fn heads() -> Vec<[f64; HEAD]> {
        [(-22.0, 18.0), (22.0, 18.0), (-22.0, -18.0), (22.0, -18.0_f64)]
            .iter()
            .map(|(phi, omega): &(f64, f64)| {
                let angles = [phi.to_radians(), omega.to_radians(), 0.0];
                Head::new(angles, [0.0; 3], Interior::ideal(6911.764706), false).values
            })
            .collect()
    }

    const VIRTUAL: Virtual = Virtual { f_px: 6911.764706, half_px: [7700.0, 5200.0], head_half_px: [3614.0, 2714.0] };

    #[test]
    fn a_turn_of_all_heads_is_no_seam() {
        let truth = heads();
        let turn = crate::adjust::rotation::matrix([1e-3, -2e-3, 3e-3]);
        let mut turned = truth.clone();
        for head in &mut turned {
            let angles = crate::adjust::rotation::angles_rad(&(turn * mount(head)));
            head[..3].copy_from_slice(&angles);
        }
        let mismatches = mismatches(&truth, &turned, &VIRTUAL, 200.0);
        assert!(mismatches.len() > 500);
        assert!(rms_and_max(&mismatches).1 < 1e-8, "{:?}", rms_and_max(&mismatches));
    }

    #[test]
    fn an_arc_second_of_one_head_is_what_the_reference_says() {
        // Reference 2.1: 1 arc second is 0.033509 px on the axis.
        let truth = heads();
        let mut off = truth.clone();
        off[1][0] += (1.0_f64 / 3600.0).to_radians();
        let (of_it, of_others): (Vec<Mismatch>, Vec<Mismatch>) =
            mismatches(&truth, &off, &VIRTUAL, 200.0).into_iter().partition(|mismatch| mismatch.heads.contains(&1));
        let (rms, max) = rms_and_max(&of_it);
        // On the plane an angle grows with the square of the ray's length, to 1 + 1.114^2 at the long side's end.
        assert!(rms > 0.0335 && max < 0.0336 * (1.0 + 1.114 * 1.114), "{rms} {max}");
        assert!(rms_and_max(&of_others).1 < 1e-6);
    }
}
