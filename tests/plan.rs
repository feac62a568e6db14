//! Plans of the command, held against the terrain by other means: golden values, rays cast over the elevation model, made-up
//! measurements. Nothing of the planner is used but its command and the files that it writes.

#[path = "plan/cast.rs"]
mod cast;
#[path = "cli/command.rs"]
mod command;
#[path = "plan/golden.rs"]
mod golden;
#[path = "plan/measured.rs"]
mod measured;
#[path = "plan/overlaps.rs"]
mod overlaps;
#[path = "plan/planned.rs"]
mod planned;
#[path = "plan/terrain.rs"]
mod terrain;
