//! The vehicle: how it moves ([`motion`]), its camera's [`servo`] and [`mount`], its [`sensors`] and its [`autopilot`]; and where its
//! fixes keep it, the [`plane`], its [`inertial`] navigation and both in a loop ([`aloft`]).

pub mod aloft;
pub mod autopilot;
pub mod inertial;
pub mod motion;
pub mod mount;
pub mod plane;
pub mod sensors;
pub mod servo;
pub mod signing;
