//! The application, made of what was uploaded.

use super::stores::Uploaded;
use crate::app::App;
use crate::boot::{self, BootError};
use crate::journal::NoJournal;
use plumbline_core::pipeline::Buffers;

/// What an application works in.
#[derive(Debug)]
pub struct Memory {
    /// The pipeline's.
    pub buffers: &'static mut Buffers,
    /// What is kept of a frame: [`FRAME_MEMORY_BYTES`](plumbline_core::budget::FRAME_MEMORY_BYTES).
    pub frame: &'static mut [u8],
}

/// Reads the stores. The one place here that knows what is in them.
///
/// # Errors
/// Why it cannot fly with them, in two parts.
pub fn application(uploaded: Uploaded, memory: Memory) -> Result<App<'static>, [&'static str; 2]> {
    let flight = boot::read(uploaded.configuration, uploaded.tile, uploaded.plan);
    let signing = boot::signing(uploaded.key, 0).map_err(BootError::words)?;
    flight.and_then(|flight| flight.app(memory.buffers, memory.frame, signing, &NoJournal)).map_err(BootError::words)
}
