//! The world the firmware flies in, and the judge of what it reports.
//!
//! Each module uses only what stands before it here: [`oracle`] (equations of the papers in f64, written apart from the core),
//! [`noise`], [`scenario`] (what is to be flown), [`world`] (ground and reference), [`camera`] (pictures of it),
//! [`vehicle`] (motion, sensors, autopilot), [`configuration`] (what lies in the board's flash), [`link`] (the firmware,
//! wherever it runs) and [`fault`] (what goes wrong on the way there), [`setup`] (a scenario made ready), [`ground_station`]
//! (what the firmware sent), [`run`] (the flight), [`live`] (the same with a real autopilot), [`score`] (what it was worth), [`replay`] (a flight again, from its log),
//! [`evaluate`] (frames of a real flight).

pub mod camera;
pub mod coefficients;
pub mod configuration;
pub mod evaluate;
pub mod fault;
pub mod ground_station;
pub mod link;
pub mod live;
pub mod noise;
pub mod oracle;
pub mod replay;
pub mod run;
pub mod scenario;
pub mod score;
pub mod setup;
pub mod vehicle;
pub mod world;
