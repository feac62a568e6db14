//! Attitudes by other conventions than the table's, each with what makes the table's of it.

use std::f64::consts::{FRAC_PI_2, PI};

/// One of them.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// The columns, and what they would be.
    pub what: &'static str,
    /// Heading, pitch and roll of the table's convention, of those as they are written, radians.
    pub read: fn([f64; 3]) -> [f64; 3],
    /// What makes them, as awk's statement; $H, $P and $R stand for the fields.
    pub awk: &'static str,
    /// Name of the file that it is written to.
    pub made: &'static str,
}

/// Those that are in use: a camera that is mounted with another side forward, headings of other axes, pitch and roll of other axes.
pub const EVERY: [Reading; 9] = [
    Reading {
        what: "heading_deg: were it 180 degrees more, as of a camera that is mounted with another side forward",
        read: |[h, p, r]| [h + PI, p, r],
        awk: "$H = ($H + 180) % 360",
        made: "turned.csv",
    },
    Reading {
        what: "heading_deg: were it 90 degrees more, as of a camera that is mounted with another side forward",
        read: |[h, p, r]| [h + FRAC_PI_2, p, r],
        awk: "$H = ($H + 90) % 360",
        made: "turned.csv",
    },
    Reading {
        what: "heading_deg: were it 270 degrees more, as of a camera that is mounted with another side forward",
        read: |[h, p, r]| [h - FRAC_PI_2, p, r],
        awk: "$H = ($H + 270) % 360",
        made: "turned.csv",
    },
    Reading {
        what: "heading_deg: were it counted from north to the left (to the right is positive)",
        read: |[h, p, r]| [-h, p, r],
        awk: "$H = (720 - $H) % 360",
        made: "turned.csv",
    },
    Reading {
        what: "heading_deg: were it counted from east to the left (from north to the right is meant)",
        read: |[h, p, r]| [FRAC_PI_2 - h, p, r],
        awk: "$H = (810 - $H) % 360",
        made: "turned.csv",
    },
    Reading {
        what: "pitch_deg and roll_deg: were they of the other sign (nose up and right wing down are positive)",
        read: |[h, p, r]| [h, -p, -r],
        awk: "$P = -$P; $R = -$R",
        made: "signs.csv",
    },
    Reading {
        what: "pitch_deg: were it of the other sign (nose up is positive)",
        read: |[h, p, r]| [h, -p, r],
        awk: "$P = -$P",
        made: "signs.csv",
    },
    Reading {
        what: "roll_deg: were it of the other sign (right wing down is positive)",
        read: |[h, p, r]| [h, p, -r],
        awk: "$R = -$R",
        made: "signs.csv",
    },
    Reading {
        what: "pitch_deg and roll_deg: were they swapped",
        read: |[h, p, r]| [h, r, p],
        awk: "t = $P; $P = $R; $R = t",
        made: "swapped.csv",
    },
];
