//! Charts, pictures and the HTML shell that the pages of the command and the figures of the papers share.
//!
//! A crate of its own, since both the command and the papers draw: it stands below both. [`page`] is the shell, [`plot`] a
//! plot inside a page, [`map`] one of the ground, [`panels`] curves below each other as one SVG file, [`png`] pictures in a
//! page, [`mod@format`] numbers.

pub mod format;
pub mod map;
pub mod page;
pub mod panels;
pub mod plot;
pub mod png;
