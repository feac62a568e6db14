//! How a camera file has the camera mounted, and the lever arm as it really is, in f64 and apart from the core's.

use super::motion::TrueState;
use crate::camera::core_camera;
use crate::camera::heads::{from_platform, turned};
use crate::camera::render::Station;
use crate::scenario::{self, FollowUpMode, Mount, Scenario};
use plumbline_survey::camera_file::{CameraFile, Distortion};
use plumbline_survey::error::InputError;

/// Where the camera's mount is in `state`, and where the follow-up axis has it look: the camera's own station less its
/// boresight.
#[must_use]
pub fn axis_station(state: &TrueState) -> Station {
    Station {
        east_m: state.east_m,
        north_m: state.north_m,
        up_m: state.up_m,
        heading_rad: state.heading_rad,
        pitch_rad: state.pitch_rad,
        roll_rad: state.roll_rad,
        follow_up_rad: state.follow_up_rad,
        boresight_rad: [0.0; 3],
    }
}

/// Where the antenna is, grid east, north and up, of a vehicle whose camera is in `state`: back by a head's arm, which turns
/// with the follow-up axis, and by the lever arm, which does not.
#[must_use]
pub fn antenna(state: &TrueState, mount: &Mount) -> [f64; 3] {
    let axis = axis_station(state);
    let body = Station { follow_up_rad: 0.0, ..axis };
    let camera = [state.east_m, state.north_m, state.up_m];
    [(axis, mount.head_arm_m), (body, mount.lever_arm_m)].into_iter().fold(camera, |place, (station, arm)| {
        let (axes, [forward_m, right_m, down_m]) = (station.axes(), arm);
        std::array::from_fn(|i| {
            place[i] - forward_m * axes.forward[i] - right_m * axes.right[i] - down_m * axes.down[i]
        })
    })
}

/// The lever arm in the configuration store. A board knows arms along the vehicle's axes alone: a head's is among them where the camera
/// is fixed, and left out, some centimetres, where a servo turns it.
#[must_use]
pub fn configured_arm(scenario: &Scenario) -> [f64; 3] {
    let Mount { lever_arm_m, head_arm_m, .. } = scenario.mount;
    let is_fixed = scenario.follow_up.mode == FollowUpMode::Fixed;
    std::array::from_fn(|i| lever_arm_m[i] + if is_fixed { head_arm_m[i] } else { 0.0 })
}

/// `mount` with what a camera file says of the platform, and the camera that flies, turned and placed as the file has it:
/// head `head`, counted from 1, or the file's only camera.
///
/// # Errors
/// What is wrong, to stand behind the file's name: several heads and none named, a head that is not there, a boresight or an
/// arm that is given twice.
pub fn of_file(file: &CameraFile, head: Option<u8>, mount: &Mount) -> Result<(CameraFile, Mount), String> {
    let mut mount = *mount;
    if let Some(angles_deg) = file.boresight {
        if mount.boresight_deg != [0.0; 3] {
            return Err("it has a boresight, and so has [mount]".to_owned());
        }
        mount.boresight_deg = turned(angles_deg, [0.0; 3]).map(f64::to_degrees);
    }
    if let Some([right, forward, up]) = file.lever_arms {
        if mount.lever_arm_m != [0.0; 3] {
            return Err("it has a lever arm, and so has [mount]".to_owned());
        }
        mount.lever_arm_m = [forward, right, -up];
    }
    let count = file.heads.len();
    let number = match (head, count) {
        (None, 0) => return Ok((file.clone(), mount)),
        (None, 1) => 1,
        (None, _) => {
            return Err(format!("it has {count} heads, and head (of `mission`, --head) does not say which one flies"));
        }
        (Some(head), _) => usize::from(head),
    };
    let flying = number.checked_sub(1).and_then(|index| file.heads.get(index));
    let flying = flying.ok_or_else(|| format!("head {number} is none of its {count} heads"))?;
    let boresight_rad = mount.boresight_deg.map(f64::to_radians);
    mount.head_arm_m = from_platform(flying.d_m, boresight_rad);
    let of_head = |platform_rad| turned(flying.rotation_deg, platform_rad).map(f64::to_degrees);
    mount.true_boresight_deg = mount.true_boresight_deg.map(|_| of_head(mount.true_boresight_rad()));
    mount.boresight_deg = of_head(boresight_rad);
    Ok((flying.camera(), mount))
}

/// The scenario's camera; a camera file's, or that of the head that flies, replaces it in the scenario too, and its mount.
///
/// # Errors
/// One sentence for a camera file that cannot be used.
pub fn camera_of(scenario: &mut Scenario) -> Result<CameraFile, InputError> {
    if let Some(path) = &scenario.camera_file {
        let whole = CameraFile::read(path)?;
        let mounted = of_file(&whole, scenario.head, &scenario.mount);
        let (file, mount) = mounted.map_err(|why| InputError::new(format!("{}: {why}", path.display())))?;
        core_camera(&file).map_err(|error| InputError::new(format!("{}: {error}", path.display())))?;
        scenario.camera = scenario::Camera {
            cols: file.cols as u16,
            rows: file.rows as u16,
            fov_h_deg: file.fov_h_deg,
            fov_v_deg: file.fov_v_deg,
            offset_m_px: file.offset_m_px,
            offset_n_px: file.offset_n_px,
            distortion: file.distortion.map(|d| scenario::Distortion {
                k1: d.k1,
                k2: d.k2,
                k3: d.k3,
                p1: d.p1,
                p2: d.p2,
            }),
        };
        scenario.check(&path.display().to_string()).map_err(|error| InputError::new(error.to_string()))?;
        // A head leans more than a boresight may.
        scenario.mount = mount;
        return Ok(file);
    }
    let camera = &scenario.camera;
    Ok(CameraFile {
        offset_m_px: camera.offset_m_px,
        offset_n_px: camera.offset_n_px,
        distortion: camera.distortion.map(|d| Distortion { k1: d.k1, k2: d.k2, k3: d.k3, p1: d.p1, p2: d.p2 }),
        ..CameraFile::new((camera.cols.into(), camera.rows.into()), (camera.fov_h_deg, camera.fov_v_deg))
    })
}
