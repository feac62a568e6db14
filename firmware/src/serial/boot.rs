//! The application, made of what was uploaded.

use super::stores::Uploaded;
use crate::app::App;
use crate::mission::{Mission, MissionError};
use plumbline_core::budget::FRAME_MEMORY_BYTES;
use plumbline_core::pipeline::{Buffers, Pipeline};
use plumbline_core::stamp::Stamper;

/// What an application works in.
#[derive(Debug)]
pub struct Memory {
    /// The pipeline's.
    pub buffers: &'static mut Buffers,
    /// What is kept of a frame: [`FRAME_MEMORY_BYTES`].
    pub frame: &'static mut [u8],
}

const _: () = assert!(FRAME_MEMORY_BYTES > 0);

/// Reads the stores. The one place here that knows what is in them.
///
/// # Errors
/// Why it cannot fly with them.
pub fn application(uploaded: Uploaded, memory: Memory) -> Result<App<'static>, &'static str> {
    let mission = Mission::decode(uploaded.mission).map_err(reason)?;
    let settings = mission.settings().map_err(reason)?;
    let stamper = Stamper::new(&mission.stamp_settings().map_err(reason)?);
    let tile = mission.tile(uploaded.tile).map_err(reason)?;
    let pipeline = Pipeline::new(settings, tile, memory.buffers, memory.frame)
        .map_err(|_| "settings that do not fit this build")?;
    Ok(App::new(pipeline, stamper, mission.send_patches))
}

fn reason(error: MissionError) -> &'static str {
    match error {
        MissionError::Encoding => "no mission of this version, or a damaged one",
        MissionError::Camera => "figures that cannot be a camera's",
        MissionError::Settings => "settings that do not fit each other",
        MissionError::Tile => "a tile that does not fit its georeference",
    }
}
