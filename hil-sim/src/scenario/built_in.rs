//! The scenarios that are part of the program.

/// What plans are flown with.
pub const SURVEY: &str = include_str!("../../scenarios/survey.toml");

/// What live flights are flown with, unless a scenario says otherwise.
pub const LIVE: &str = include_str!("../../scenarios/live.toml");

/// Built-in scenarios: name and text. The last ones are flights over hard ground.
pub const BUILT_IN: [(&str, &str); 27] = [
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
    ("parcels", include_str!("../../scenarios/parcels.toml")),
    ("stripes", include_str!("../../scenarios/stripes.toml")),
    ("shadows", include_str!("../../scenarios/shadows.toml")),
    ("clouds", include_str!("../../scenarios/clouds.toml")),
    ("overcast", include_str!("../../scenarios/overcast.toml")),
    ("low_contrast", include_str!("../../scenarios/low_contrast.toml")),
    ("inverted", include_str!("../../scenarios/inverted.toml")),
    ("seasons", include_str!("../../scenarios/seasons.toml")),
    ("ploughed", include_str!("../../scenarios/ploughed.toml")),
    ("flooded", include_str!("../../scenarios/flooded.toml")),
    ("shore", include_str!("../../scenarios/shore.toml")),
    ("shifted", include_str!("../../scenarios/shifted.toml")),
    ("wrong_tile", include_str!("../../scenarios/wrong_tile.toml")),
    ("outside", include_str!("../../scenarios/outside.toml")),
];
