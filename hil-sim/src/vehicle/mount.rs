//! How a camera file has the camera mounted, and the lever arm as it really is, in f64 and apart from the core's.

use super::motion::TrueState;
use crate::camera::core_camera;
use crate::camera::heads::{from_platform, turned};
use crate::camera::render::Station;
use crate::scenario::vehicle::Mount;
use crate::scenario::{Boresight, Camera, FollowUpMode, Mounting, Payload, Scenario, Vehicle};
use plumbline_survey::camera_file::CameraFile;
use plumbline_survey::error::InputError;
use std::path::Path;

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
pub fn antenna(state: &TrueState, mount: &Mounting) -> [f64; 3] {
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

/// Where the camera is of a vehicle whose antenna is in `state`: [`antenna`] backwards.
#[must_use]
pub fn camera_of_antenna(state: &TrueState, mount: &Mounting) -> [f64; 3] {
    let there = [state.east_m, state.north_m, state.up_m];
    // Both arms are the same from wherever they begin.
    let back = antenna(state, mount);
    std::array::from_fn(|axis| 2.0 * there[axis] - back[axis])
}

/// The lever arm in the configuration store. A board knows arms along the vehicle's axes alone: a head's is among them where
/// the camera is fixed, and left out, some centimetres, where a servo turns it.
#[must_use]
pub fn configured_arm(mount: &Mounting, mode: FollowUpMode) -> [f64; 3] {
    let Mounting { lever_arm_m, head_arm_m, .. } = mount;
    let is_fixed = mode == FollowUpMode::Fixed;
    std::array::from_fn(|i| lever_arm_m[i] + if is_fixed { head_arm_m[i] } else { 0.0 })
}

/// What the vehicle of `scenario` carries: its camera file read, the head that flies chosen.
///
/// # Errors
/// One sentence for a camera file that cannot be used.
pub fn payload_of(scenario: &Scenario) -> Result<Payload, InputError> {
    let truly = scenario.world.mount.true_boresight;
    match &scenario.camera {
        Camera::Keys(frame) => {
            let mount = mounting(&scenario.vehicle, truly, &frame.file()).map_err(InputError::new)?;
            Ok(Payload { camera: frame.file(), mount })
        }
        Camera::File(path) => payload_of_file(&scenario.vehicle, truly, path),
    }
}

/// The camera of the file `path`, as a vehicle carries it.
///
/// # Errors
/// One sentence for a file that cannot be used.
pub fn payload_of_file(vehicle: &Vehicle, truly: Option<Boresight>, path: &Path) -> Result<Payload, InputError> {
    let of_file = |why: String| InputError::new(format!("{}: {why}", path.display()));
    let file = CameraFile::read(path)?;
    let mount = mounting(vehicle, truly, &file).map_err(of_file)?;
    let payload = of_head(file, vehicle.head, mount).map_err(of_file)?;
    core_camera(&payload.camera).map_err(|error| of_file(error.to_string()))?;
    vehicle.check_camera(&payload.camera).map_err(of_file)?;
    Ok(payload)
}

/// How the camera of `file` is mounted: as the file says, or as the scenario does; `truly`: its boresight as it really is.
///
/// # Errors
/// The message, before which the caller puts the file's name: a boresight or an arm that is given twice.
fn mounting(vehicle: &Vehicle, truly: Option<Boresight>, file: &CameraFile) -> Result<Mounting, String> {
    let Mount { mut lever_arm_m, boresight } = vehicle.mount;
    if file.boresight.is_some() && !boresight.is_none() {
        return Err("the boresight is given both here and in [mount]; give it once".to_owned());
    }
    if let Some([right, forward, up]) = file.lever_arms {
        if lever_arm_m != [0.0; 3] {
            return Err("the lever arm is given both here and in [mount]; give it once".to_owned());
        }
        lever_arm_m = [forward, right, -up];
    }
    let configured_deg = file.boresight.unwrap_or(boresight.angles_deg());
    let turn = |angles_deg: [f64; 3]| if angles_deg == [0.0; 3] { [0.0; 3] } else { turned(angles_deg, [0.0; 3]) };
    Ok(Mounting {
        lever_arm_m,
        head_arm_m: [0.0; 3],
        boresight_rad: turn(configured_deg),
        true_boresight_rad: turn(truly.map_or(configured_deg, |truly| truly.angles_deg())),
    })
}

/// The camera that flies, turned and placed as its file has it: head `head`, counted from 1, or the file's only camera.
///
/// # Errors
/// The message, before which the caller puts the file's name: several heads and none named, a head that is not there.
fn of_head(file: CameraFile, head: Option<u8>, mount: Mounting) -> Result<Payload, String> {
    let count = file.heads.len();
    let number = match (head, count) {
        (None, 0) => return Ok(Payload { camera: file, mount }),
        (None, 1) => 1,
        (None, _) => {
            return Err(format!(
                "it has {count} heads, and head (of `configuration`, --head) does not say which one flies"
            ));
        }
        (Some(head), _) => usize::from(head),
    };
    let flying = number.checked_sub(1).and_then(|index| file.heads.get(index));
    let flying = flying.ok_or_else(|| format!("head = {number}, but the file has {count} heads"))?;
    let mount = Mounting {
        head_arm_m: from_platform(flying.d_m, mount.boresight_rad),
        boresight_rad: turned(flying.rotation_deg, mount.boresight_rad),
        true_boresight_rad: turned(flying.rotation_deg, mount.true_boresight_rad),
        ..mount
    };
    Ok(Payload { camera: flying.camera(), mount })
}
