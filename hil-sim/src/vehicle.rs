//! The vehicle: how it moves ([`motion`]), its camera's [`servo`] and [`mount`], its [`sensors`] and its [`autopilot`].

pub mod autopilot;
pub mod motion;
pub mod mount;
pub mod sensors;
pub mod servo;
pub mod signing;
