//! The scenarios that are part of the program.

/// What plans are flown with.
pub const SURVEY: &str = include_str!("../../scenarios/survey.toml");

/// What live flights are flown with, unless a scenario says otherwise.
pub const LIVE: &str = include_str!("../../scenarios/live.toml");

/// Built-in scenarios: name and text.
pub const BUILT_IN: [(&str, &str); 13] = [
    ("default", include_str!("../../scenarios/default.toml")),
    ("nadir", include_str!("../../scenarios/nadir.toml")),
    ("edges", include_str!("../../scenarios/edges.toml")),
    ("pulses", include_str!("../../scenarios/pulses.toml")),
    ("rolling", include_str!("../../scenarios/rolling.toml")),
    ("honest", include_str!("../../scenarios/honest.toml")),
    ("barrel", include_str!("../../scenarios/barrel.toml")),
    ("faults", include_str!("../../scenarios/faults.toml")),
    ("naip", include_str!("../../scenarios/naip.toml")),
    ("survey", SURVEY),
    ("live", LIVE),
    ("closed_loop", include_str!("../../scenarios/closed_loop.toml")),
    ("vienna", include_str!("../../scenarios/vienna.toml")),
];
