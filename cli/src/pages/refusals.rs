//! Why frames have no fix, for people: what each reason means and what helps.

use maud::{Markup, html};

/// Below this share of fixes a page says first why frames have none. Chosen: a flight of good sensors over land has nine of ten.
pub const FEW: f64 = 0.75;

/// A reason as `fixes.csv` has it, and what it means and what helps.
const REASONS: [(&str, &str); 32] = [
    (
        "no_clock",
        "The board has not yet compared its clock with the autopilot’s: it takes a second or two of TIMESYNC or pulses.",
    ),
    ("bad_exposure", "The shutter’s edges make no exposure: check the line and its polarity."),
    ("busy", "The frame before was still being worked on: take frames further apart."),
    ("overrun", "Rows were overwritten before they were read: the camera is faster than the board."),
    ("bad_frame", "The frame has another size than the camera file says, or ended early."),
    (
        "frame_too_large",
        "The frame cannot be reduced into this build’s memory: a smaller one, or a coarser resolution.",
    ),
    ("no_attitude", "No attitude around mid-exposure: does the autopilot stream it?"),
    ("attitude_gap", "Attitudes too far apart around mid-exposure: ask the autopilot for a higher rate."),
    ("no_follow_up", "No angle of the camera’s servo around mid-exposure."),
    (
        "no_range",
        "The height above the ground is not known: neither a valid range nor an altitude over an elevation model.",
    ),
    ("tilt", "The camera looks too near the horizon; it is fixed again once it looks down."),
    ("no_position", "No position recent enough to search around."),
    ("outside_reference", "The search leaves the reference tile: make a larger one, or fly within it."),
    (
        "no_footprint",
        "Nothing of the patch lies in the frame, or it is too small: check height, field of view and resolution.",
    ),
    ("featureless", "Water, fog, snow or a dark frame: there is nothing to match."),
    ("few_pixels", "Too little of the patch is seen: the camera is tilted far or the frame is cut off."),
    (
        "on_border",
        "The best place lies on the border of the search: position or height is off further than it says. A wider search, or larger sigmas.",
    ),
    (
        "low_score",
        "Picture and reference do not agree well enough: another season or year, clouds, or a wrong height, heading or field of view.",
    ),
    (
        "ambiguous",
        "A second place is almost as good: ground that repeats, or too small a patch. Higher up, or a coarser resolution, shows more.",
    ),
    ("imprecise", "The place is too uncertain between the pixels: little texture, or too much blur."),
    ("edges_contradict", "The shutter’s edges contradict each other or the frame’s arrival."),
    ("no_exposure", "An edge is missing, and no exposure time is known that could stand for it."),
    (
        "uncertain_clock",
        "The clock has run free too long, is contradicted, or made a step after the frame was stamped: check pulses and TIMESYNC.",
    ),
    ("frame_backwards", "The frame did not arrive after the one before."),
    (
        "attitude_stuck",
        "The attitude is the same to the last bit several times in a row: the sensor or its driver hangs.",
    ),
    ("too_fast", "The camera moves too fast for its rolling shutter."),
    ("capacity", "A buffer of this build is too small for what the frame needs."),
    (
        "unconfirmed",
        "It was found far from where it was expected, and waits for the next frames to find it there, too.",
    ),
    (
        "contradicted",
        "It does not lie where the matches before have put the vehicle, or attitude, heading or height are off. Where it lasts, check those.",
    ),
    ("repeated", "The picture is the one before, to the last bit: the camera hangs."),
    (
        "undecided",
        "Only the greys agree, and the frames so far have not decided that it is this place: it takes three pieces of ground. Fly on.",
    ),
    ("lost", "The frame did not reach the board, or what it said of it was lost on the way."),
];

/// A reason in a sentence, with what helps; nothing of one that is not known.
pub fn explained(why: &str) -> &'static str {
    REASONS.iter().find(|(name, _)| *name == why).map_or("", |(_, text)| text)
}

/// Every reason with what helps, closed until somebody opens it: a page has no other file to point to.
pub fn every() -> Markup {
    html! {
        details class="every" {
            summary { "Every reason for no fix, and what helps" }
            table { tbody { @for (name, text) in REASONS { tr { th { (name.replace('_', " ")) } td { (text) } } } } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{REASONS, every, explained};
    use plumbline_core::pipeline::Refusal;

    #[test]
    fn every_reason_is_explained() {
        let known = (1..=u8::MAX).filter_map(Refusal::from_code);
        assert_eq!(known.filter(|refusal| explained(refusal.name()).is_empty()).collect::<Vec<_>>(), []);
    }

    #[test]
    fn a_page_has_all_of_them() {
        let page = every().into_string();
        assert_eq!(page.matches("<tr>").count(), REASONS.len());
        assert!(page.contains("<th>no follow up</th>"), "{page}");
    }

    /// The page of refusals has a row for each code of the firmware, and for what the simulator says of a frame that is lost.
    #[test]
    fn every_reason_is_on_its_page() {
        let page = include_str!("../../../docs/refusals.md");
        let rows: Vec<&str> = page.lines().filter(|line| line.contains("| `")).collect();
        let known: Vec<Refusal> = (1..=u8::MAX).filter_map(Refusal::from_code).collect();
        for refusal in &known {
            let row = format!("| {} | `{}` | ", refusal.code(), refusal.name());
            assert_eq!(rows.iter().filter(|line| line.starts_with(&row)).count(), 1, "{row}");
        }
        assert!(page.contains("| | `lost` | "));
        assert_eq!(rows.len(), known.len() + 1, "no row of a reason that there is not");
    }
}
