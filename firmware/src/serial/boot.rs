//! The application, made of what was uploaded.

use super::stores::Uploaded;
use crate::app::App;
use crate::boot::{self, BootError};
use crate::journal::NoJournal;
use plumbline_core::pipeline::Memory;

/// Reads the stores. The one place here that knows what is in them.
///
/// # Errors
/// Why it cannot fly with them, in two parts.
pub fn application(uploaded: Uploaded, memory: Memory<'static>) -> Result<App<'static>, [&'static str; 2]> {
    let flight = boot::read(uploaded.configuration, uploaded.tile, uploaded.plan);
    let signing = boot::signing(uploaded.key, 0).map_err(BootError::words)?;
    flight.and_then(|flight| flight.app(memory, signing, &NoJournal)).map_err(BootError::words)
}
