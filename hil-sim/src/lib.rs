//! The world the firmware flies in, and the judge of what it reports.
//!
//! [`scenario`] → [`stage`] ([`world`], [`flight`], [`mod@reference`]) → [`fly`] ([`sensors`], [`autopilot`], [`render`],
//! [`fault`], [`link`]) → [`station`] → [`score`]. Apart from all of it stands [`oracle`], which judges the core's
//! geometry; [`still`] and [`still_match`] run the core on single pictures, [`stitch`] on those of a camera of several [`heads`],
//! [`smoothing`] fits logs; [`panels`] draws curves; [`calibration`] is the page of a
//! calibrated camera, [`planning`] what a flight plan is handed out as.

pub mod autopilot;
pub mod calibration;
pub mod camera;
pub mod dump;
pub mod fault;
pub mod flight;
pub mod fly;
pub mod heads;
pub mod link;
pub mod mission;
pub mod mount;
pub mod oracle;
pub mod panels;
pub mod planned;
pub mod planning;
pub mod reference;
pub mod render;
pub mod replay;
pub mod report;
pub mod reproduce;
pub mod scenario;
pub mod score;
pub mod sensors;
pub mod smoothing;
pub mod stage;
pub mod station;
pub mod still;
pub mod still_match;
pub mod stitch;
pub mod tile;
pub mod world;
