//! What a boresight that is not the believed one does to a fix.
//!
//! The patch's pixel in the direction r from the believed camera, r = (east, north, -1) in tangents, is filled with what the
//! frame shows along B0' M' r. M is the ground from the camera's mount (heading, pitch, roll, follow-up angle), B0 the mount
//! from the camera as the board is configured. The picture was taken along M B B0' M' r with the true B, so this pixel shows
//! the ground where that ray meets it. The matching moves the patch as a whole: the fix is off by the height times the mean
//! of the rays' displacements in tangents, over the part of the patch that the frame fills. The nadir's ray alone, r = (0,
//! 0,
//! -1), is not enough: a tilt by d moves a point at the tangent u by d (1 + u²), in a camera of 60 degrees 11 % more in the mean.
//!
//! Axes: mount and camera right, forward, up; ground east, north, up, level.

use crate::adjust::rotation;
use crate::camera_file::CameraFile;
use nalgebra::{Matrix2x3, Matrix3, Vector2, Vector3};

/// Rays along each side of a patch: their mean square differs from the integral's by 1/12².
const SIDE: usize = 12;
/// A ray must point below the horizon by so much of its length.
const DOWN_MIN: f64 = 1e-3;

/// A fix with an independent position and the pose of its exposure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sighting {
    /// The fix, east and north, metres.
    pub fix_m: [f64; 2],
    /// One sigma of each, metres, above 0.
    pub sigma_m: [f64; 2],
    /// The independent position of the same point, metres.
    pub position_m: [f64; 2],
    /// The camera's height above the ground, metres, above 0.
    pub height_m: f64,
    /// Heading clockwise from grid north, pitch nose up, roll right wing down; radians.
    pub attitude_rad: [f64; 3],
    /// Pitch and roll that the frame was rectified with, where the board had learnt of an error of the attitude's.
    pub rectified_rad: Option<[f64; 2]>,
    /// Turn of the camera's mount against the vehicle, counter-clockwise from above, radians; 0 without a servo.
    pub follow_up_rad: f64,
}

/// What a frame covers, in tangents: the patch's half sides by eq. 4 of paper 003, and the frame's borders. Lens distortion
/// moves the borders little and is left out; so is the board's largest patch, which cuts what is seen from high above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Half sides of the patch, east and north.
    pub(super) patch: [f64; 2],
    /// Half sides of the frame, across and along.
    frame: [f64; 2],
    /// The frame's middle from the camera's axis.
    centre: [f64; 2],
}

impl Footprint {
    /// The footprint of a camera without heads.
    #[must_use]
    pub fn new(camera: &CameraFile) -> Self {
        let half = [camera.fov_h_deg, camera.fov_v_deg].map(|fov_deg| (0.5 * fov_deg.to_radians()).tan());
        // A positive offset moves what is seen straight ahead towards the last column, and the frame's middle the other way.
        let per_px = [2.0 * half[0] / f64::from(camera.cols), 2.0 * half[1] / f64::from(camera.rows)];
        Footprint {
            patch: half,
            frame: half,
            centre: [-camera.offset_m_px * per_px[0], -camera.offset_n_px * per_px[1]],
        }
    }

    fn holds(&self, camera_ray: &Vector3<f64>) -> bool {
        let at = [camera_ray.x / -camera_ray.z, camera_ray.y / -camera_ray.z];
        camera_ray.z < 0.0 && (0..2).all(|k| (at[k] - self.centre[k]).abs() <= self.frame[k])
    }
}

/// Ground from mount: the vehicle turned by heading, pitch and roll, each about its own axis as the turns before have left
/// it, then the mount by the follow-up angle.
fn ground_from_mount([heading, pitch, roll]: [f64; 3], follow_up: f64) -> Matrix3<f64> {
    // Kappa turns as the follow-up angle does, against the heading; phi against the roll.
    rotation::matrix([0.0, 0.0, -heading])
        * rotation::matrix([0.0, pitch, 0.0])
        * rotation::matrix([-roll, 0.0, follow_up])
}

/// The rays of one patch.
#[derive(Clone, Debug)]
pub(super) struct Rays {
    ground_from_mount: Matrix3<f64>,
    /// Each on the ground's axes as the board believes it, in tangents, and on the camera's axes.
    rays: Vec<(Vector2<f64>, Vector3<f64>)>,
}

impl Rays {
    /// Those of `sighting` with the configured boresight; `None` where the frame shows nothing around the nadir.
    pub(super) fn new(sighting: &Sighting, footprint: &Footprint, configured_rad: [f64; 3]) -> Option<Self> {
        let ground_from_mount = ground_from_mount(sighting.attitude_rad, sighting.follow_up_rad);
        let [heading, pitch, roll] = sighting.attitude_rad;
        let [pitch, roll] = sighting.rectified_rad.unwrap_or([pitch, roll]);
        let believed = self::ground_from_mount([heading, pitch, roll], sighting.follow_up_rad);
        let camera_from_ground = (believed * rotation::matrix(configured_rad)).transpose();
        let middle = |i: usize| (2 * i + 1) as f64 / SIDE as f64 - 1.0;
        let ray = |index: usize| {
            let at = Vector2::new(middle(index % SIDE) * footprint.patch[0], middle(index / SIDE) * footprint.patch[1]);
            let camera_ray = camera_from_ground * Vector3::new(at.x, at.y, -1.0);
            footprint.holds(&camera_ray).then_some((at, camera_ray))
        };
        let rays: Vec<_> = (0..SIDE * SIDE).filter_map(ray).collect();
        (!rays.is_empty()).then_some(Rays { ground_from_mount, rays })
    }

    /// Mean displacement, east and north in tangents, with a camera that really is mounted by `angles_rad`, and its
    /// derivatives by phi, omega and kappa; `None` where a ray misses the ground.
    pub(super) fn displacement(&self, angles_rad: [f64; 3]) -> Option<(Vector2<f64>, Matrix2x3<f64>)> {
        let (rotation, derivatives) = rotation::with_derivatives(angles_rad);
        let ground_from_camera = self.ground_from_mount * rotation;
        let derivatives = derivatives.map(|derivative| self.ground_from_mount * derivative);
        let (mut sum, mut by) = (Vector2::zeros(), Matrix2x3::zeros());
        for (believed, camera_ray) in &self.rays {
            let ray = ground_from_camera * camera_ray;
            if ray.z > -DOWN_MIN * ray.norm() {
                return None;
            }
            let met = ray.xy() / -ray.z;
            sum += met - believed;
            for (k, derivative) in derivatives.iter().enumerate() {
                let moved = derivative * camera_ray;
                let mut column = by.column_mut(k);
                column += (moved.xy() + met * moved.z) / -ray.z;
            }
        }
        let count = self.rays.len() as f64;
        Some((sum / count, by / count))
    }
}
