//! The progress bar of every command: on standard error, with the time that is left, and only where a person sees it.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over `count` times `what`.
pub fn bar(count: u64, what: &'static str) -> ProgressBar {
    styled(ProgressBar::new(count), "{msg} {pos} of {len} {wide_bar} {eta} left").with_message(what)
}

/// For work whose end cannot be foreseen: what it is at.
pub fn spinner() -> ProgressBar {
    styled(ProgressBar::new_spinner(), "{spinner} {msg} {elapsed}")
}

fn styled(bar: ProgressBar, template: &str) -> ProgressBar {
    match ProgressStyle::with_template(template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}
