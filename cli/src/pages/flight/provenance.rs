//! Where the numbers come from.

use super::Report;
use super::head::link_name;
use maud::{Markup, html};

impl Report<'_> {
    pub(super) fn provenance(&self) -> Markup {
        let summary = self.summary;
        let (title, firmware) = match (&summary.firmware_sha256, &summary.board) {
            (None, Some(board)) => ("Board and version of its firmware", board.as_str()),
            (image, _) => ("Firmware, SHA-256", image.as_deref().unwrap_or("no image: linked into the simulator")),
        };
        html! {
            footer {
                h2 { "Measured and modelled" }
                p {
                    b { "Measured: " }
                    "the errors, refusals and counts are what the firmware’s own code answered, message by message, held against a truth that it never sees."
                }
                p {
                    b { "Modelled: " }
                    "ground, light, camera, motion, sensors, servo and link are the simulator’s, so the errors are as good as these models; an emulator counts instructions exactly and says nothing about time."
                }
                table {
                    tbody {
                        tr { th { "Plumbline" } td class="t" { (env!("CARGO_PKG_VERSION")) } }
                        tr { th { "Layout of report.json" } td class="t" { (summary.schema) } }
                        tr { th { "Link" } td class="t" { (link_name(&summary.link)) } }
                        tr { th { (title) } td class="t hash" { (firmware) } }
                        tr { th { "Seed of every random number" } td class="t" { (summary.seed) } }
                    }
                }
            }
        }
    }
}
