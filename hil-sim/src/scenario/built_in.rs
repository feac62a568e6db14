//! The scenarios that are part of the program.

/// What plans are flown with.
pub const SURVEY: &str = include_str!("../../scenarios/survey.toml");

/// Built-in scenarios: name and text.
pub const BUILT_IN: [(&str, &str); 11] = [
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
    ("vienna", include_str!("../../scenarios/vienna.toml")),
];
