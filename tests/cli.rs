//! The command `plumbline` as users run it: what it accepts, what it refuses and how, and what it leaves behind.
//!
//! The promises are those of the command's contract: exit 0 = done, 2 = bad input, 1 = the work failed; one sentence on
//! stderr that names what and where; one JSON document alone on stdout; never a panic, nothing half-written.

#[path = "cli/bad_cameras.rs"]
mod bad_cameras;
#[path = "cli/bad_flights.rs"]
mod bad_flights;
#[path = "cli/bad_options.rs"]
mod bad_options;
#[path = "cli/bad_outputs.rs"]
mod bad_outputs;
#[path = "cli/bad_pictures.rs"]
mod bad_pictures;
#[path = "cli/bad_samples.rs"]
mod bad_samples;
#[path = "cli/boresight.rs"]
mod boresight;
#[path = "cli/calibrate.rs"]
mod calibrate;
#[path = "cli/command.rs"]
mod command;
#[path = "cli/flights.rs"]
mod flights;
#[path = "cli/folder.rs"]
mod folder;
#[path = "cli/lines.rs"]
mod lines;
#[path = "cli/map.rs"]
mod map;
#[path = "cli/matching.rs"]
mod matching;
#[path = "cli/motion.rs"]
mod motion;
#[path = "cli/pictures.rs"]
mod pictures;
#[path = "cli/pipes.rs"]
mod pipes;
#[path = "cli/plan.rs"]
mod plan;
#[path = "cli/rectify.rs"]
mod rectify;
#[path = "cli/refusals.rs"]
mod refusals;
#[path = "cli/reproduced.rs"]
mod reproduced;
#[path = "golden/seeded.rs"]
mod seeded;
#[path = "cli/smooth.rs"]
mod smooth;
#[path = "cli/stitch.rs"]
mod stitch;
#[path = "cli/stores.rs"]
mod stores;
#[path = "golden/textures.rs"]
#[allow(dead_code, reason = "other targets turn, stretch and mask these textures")]
mod textures;
#[path = "golden/smooth/track.rs"]
#[allow(dead_code, reason = "another target judges by the truth")]
mod track;
#[path = "golden/vectors.rs"]
mod vectors;
