//! The camera that flies and how it sits: what a scenario says, with its camera file read.

use plumbline_survey::camera_file::CameraFile;

/// What a vehicle carries.
#[derive(Debug, Clone, PartialEq)]
pub struct Payload {
    /// The camera, or the head that flies of a camera with several.
    pub camera: CameraFile,
    /// How it sits.
    pub mount: Mounting,
}

/// How a camera sits in its vehicle. A boresight is the turn (heading, pitch, roll) of the camera against where the follow-up
/// axis has it look, radians, as the firmware takes it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Mounting {
    /// From the antenna to the camera, or to the virtual projection centre of a combined one: forward, right, down.
    pub lever_arm_m: [f64; 3],
    /// From the virtual projection centre to the head that flies, along the axes of the mount, which turn with the
    /// follow-up axis: forward, right, down.
    pub head_arm_m: [f64; 3],
    /// As the firmware is configured.
    pub boresight_rad: [f64; 3],
    /// As it really is.
    pub true_boresight_rad: [f64; 3],
}
