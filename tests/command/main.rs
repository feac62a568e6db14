//! The command `plumbline` as users run it: what it accepts, what it refuses and how, and what it leaves behind.
//!
//! The promises are those of the command's contract: exit 0 = done, 2 = bad input, 1 = the work failed; one sentence on
//! stderr that names what and where; one JSON document alone on stdout; never a panic, nothing half-written.

mod bad_cameras;
mod bad_flights;
mod bad_options;
mod bad_outputs;
mod bad_pictures;
mod bad_samples;
mod beginning;
mod boresight;
mod calibrate;
mod command;
mod elevation;
mod evaluate;
mod doubts;
mod export;
mod faults;
mod first_steps;
mod flights;
mod folder;
mod foreign;
mod kinds;
mod lines;
mod live;
mod logs;
mod map;
mod matching;
mod mistakes;
mod motion;
mod pictures;
mod pipes;
mod plan;
mod plan_follow;
mod plan_heights;
mod plan_safety;
mod plans;
mod oriented;
mod rectify;
mod relief;
mod refusals;
mod reproduced;
mod same_files;
mod smooth;
mod stitch;
mod stores;
mod tile_heights;
