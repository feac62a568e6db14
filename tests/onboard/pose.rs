//! The pose's streams, and what sensors do in the field.

mod history;
mod position;
mod smoother;
mod streams;
