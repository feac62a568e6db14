//! MAVLink 2, checked at the door.
//!
//! [`decoder`] cuts the byte stream into messages whose checksum holds and counts everything else; [`incoming`] turns
//! messages into samples in the core's axes and units, [`order`] those that a ground station commands us by; [`outgoing`] is
//! what we send, [`fix_message`] the fixes among it; [`signature`] and [`signing`] tell who may have sent them; [`telemetry`]
//! is our own content inside TUNNEL messages. Nothing here panics on any input: bit errors, cut messages and unknown ids are
//! counted.

pub mod boot_time;
pub mod command;
pub mod decoder;
pub mod extensions;
pub mod fix_message;
pub mod incoming;
pub mod order;
pub mod outgoing;
pub mod signature;
pub mod signing;
pub mod telemetry;
