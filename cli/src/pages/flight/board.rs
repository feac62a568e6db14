//! What the board spent, refused and counted.

use super::Report;
use crate::pages::refusals::{every, explained};
use maud::{Markup, html};
use plumbline_charts::format::{NOT_MEASURED, bytes, number, percent, whole};
use plumbline_firmware::wire::telemetry::STAGES;
use plumbline_sim::score::Stages;

/// The firmware's stages in a reader's words.
const TITLES: [&str; STAGES.len()] =
    ["Reduce: rows as they arrive", "Stamp: mid-exposure", "Pose at mid-exposure", "Rectify", "Match", "Fix"];

impl Report<'_> {
    pub(super) fn board(&self) -> Markup {
        let summary = self.summary;
        let (count, rms_rad) = self.flight.servo;
        let ram = summary.ram_bytes.map_or_else(|| NOT_MEASURED.to_owned(), bytes);
        let servo = if count == 0 {
            "no commands".to_owned()
        } else {
            format!("{}° rms in {} commands", number(rms_rad.to_degrees(), 2, ""), whole(count as u64))
        };
        html! {
            section class="two" {
                div {
                    h2 { "On board" }
                    (self.stages())
                    table {
                        tbody {
                            tr { th { "Memory" small { "Static and the stack’s high-water mark." } } td class="n" { (ram) } }
                            tr {
                                th { "Follow-up servo command" small { "Off the exact angle when the command arrived, its travel over the link included." } }
                                td class="n" { (servo) }
                            }
                            tr { th { "Rows lost to overruns" } td class="n" { (whole(summary.overruns.into())) } }
                            tr { th { "Frames lost while another was at work" } td class="n" { (whole(self.flight.health.frames_lost.into())) } }
                            tr { th { "Patches cut short on the link" } td class="n" { (whole(self.flight.health.patches_cut.into())) } }
                        }
                    }
                    (self.refusals())
                }
                div {
                    h2 { "Link" }
                    (self.link())
                    (self.line())
                }
            }
        }
    }

    /// What each stage costs, as bars.
    fn stages(&self) -> Markup {
        let Some((_, _, Stages(stages), name)) = self.summary.cost() else {
            return html! { p class="note" { "Instructions a frame: " (NOT_MEASURED) "." } };
        };
        let title = if name == "cycles" { "Cycles a frame, mean" } else { "Instructions a frame, mean" };
        let sum = stages.iter().sum::<f64>().max(1.0);
        html! {
            table class="bars" {
                thead { tr { th { (title) } th class="r" { "Count" } th class="r" { "Share" } } }
                tbody {
                    @for (name, count) in TITLES.iter().zip(stages) {
                        tr {
                            th { (name) div class="bar" style=(format!("width:{:.1}%", 100.0 * count / sum)) {} }
                            td class="n" { (whole(count.round() as u64)) }
                            td class="n" { (percent(count / sum)) }
                        }
                    }
                }
            }
        }
    }

    fn refusals(&self) -> Markup {
        let summary = self.summary;
        html! {
            table {
                thead { tr { th { "Frames without a fix, by reason" } th class="r" { "Frames" } th class="r" { "Share" } } }
                tbody {
                    @for (reason, &count) in &summary.refused {
                        tr {
                            th { (reason.replace('_', " ")) small { (explained(reason)) } }
                            td class="n" { (count) }
                            td class="n" { (percent(count as f64 / summary.frames.max(1) as f64)) }
                        }
                    }
                    @if summary.refused.is_empty() { tr { th { "none" } td class="n" { "0" } td class="n" { (percent(0.0)) } } }
                }
            }
            @if !summary.refused.is_empty() { (every()) }
        }
    }

    /// What the line did, where the link is one.
    fn line(&self) -> Markup {
        let Some(trouble) = &self.summary.link_faults else { return html! {} };
        let rows = [
            ("Requests sent again", trouble.resends),
            ("Waits without an answer", trouble.timeouts),
            ("Messages damaged", trouble.bad_checksum),
            ("Answers that came again", trouble.stale),
            ("Line plugged in anew", trouble.reconnects),
            ("Board booted anew", trouble.reboots),
            ("Frames lost to that", trouble.frames_abandoned),
        ];
        html! {
            table {
                thead { tr { th { "Serial line" } th class="r" { "Count" } } }
                tbody { @for (name, count) in rows { tr { th { (name) } td class="n" { (whole(count)) } } } }
            }
        }
    }

    fn link(&self) -> Markup {
        let (link, faults) = (&self.summary.link_health, &self.flight.faults);
        let rows: [(&str, u64); 11] = [
            ("Messages sent to the firmware", faults.messages),
            ("… cut on the way", faults.cut),
            ("… with flipped bits", faults.damaged),
            ("Unknown messages injected", faults.unknown),
            ("Good messages received on board", link.messages.into()),
            ("Failed checksums", link.bad_checksum.into()),
            ("Unknown message ids", link.unknown_id.into()),
            ("Bytes that belonged to no message", link.skipped_bytes.into()),
            ("Samples whose stamp ran backwards", link.backwards.into()),
            ("Samples out of range", link.invalid.into()),
            ("Messages received from the firmware", self.flight.messages.values().sum()),
        ];
        html! {
            table {
                thead { tr { th { "Messages and samples" } th class="r" { "Count" } } }
                tbody { @for (name, count) in rows { tr { th { (name) } td class="n" { (whole(count)) } } } }
            }
        }
    }
}
