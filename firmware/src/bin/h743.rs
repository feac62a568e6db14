//! The application on the flight computer, linked to the start of flash: for a debug probe.
#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(not(target_os = "none"))]
fn main() {}

#[cfg(target_os = "none")]
#[cortex_m_rt::entry]
fn main() -> ! {
    plumbline_firmware::h743::chip::start()
}
