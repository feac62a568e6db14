//! Rules of the source code that no compiler checks: dependencies between modules go one way, files and functions stay
//! short, documents lead where they say.
//!
//! `cargo test -p plumbline-structure` reads the sources of every crate.

pub mod circles;
#[cfg(test)]
mod documents;
pub mod modules;
pub mod sizes;
pub mod workspace;

#[cfg(test)]
mod tests;
