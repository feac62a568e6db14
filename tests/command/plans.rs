//! Plans of the command, held against the terrain by other means: golden values, rays cast over the elevation model, made-up
//! measurements. Nothing of the planner is used but its command and the files that it writes.

mod cast;
mod golden;
mod measured;
mod overlaps;
mod planned;
mod terrain;
