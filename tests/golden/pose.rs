//! The pose's streams and fits against paper 001: golden values, the reference's tables, a dense solution in double
//! precision, and what sensors do in the field.

#[path = "pose/dense.rs"]
mod dense;
#[path = "pose/fit.rs"]
mod fit;
#[path = "pose/history.rs"]
mod history;
use super::mutants;
#[path = "pose/place.rs"]
mod place;
use super::seeded;
#[path = "pose/smoother.rs"]
mod smoother;
#[path = "pose/streams.rs"]
mod streams;
#[path = "pose/table.rs"]
mod table;
use super::vectors;
