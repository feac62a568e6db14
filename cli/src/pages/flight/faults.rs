//! What each timed fault did to the fixes.

use super::Report;
use maud::{Markup, html};
use plumbline_charts::format::maybe;

impl Report<'_> {
    /// Nothing of a flight without faults.
    pub(super) fn faults(&self) -> Markup {
        let faults = &self.summary.faults;
        if faults.is_empty() {
            return html! {};
        }
        html! {
            section {
                h2 { "Faults" }
                p class="note" { "Frames by the middle of their exposure, in seconds of the simulated time. A wrong fix is off by more than 3 px, or by more than 5 of its own sigmas and 1.5 px." }
                div class="scroll" { table {
                    thead { tr {
                        th { "Fault" } th class="r" { "Frames" } th class="r" { "Fixes" } th class="r" { "Wrong" }
                        th class="r" { "Fixes in the 10 s after" } th class="r" { "Wrong" } th class="r" { "First fix after" }
                    } }
                    tbody { @for fault in faults { tr {
                        th { (fault.spec) }
                        @for count in [fault.frames, fault.accepted, fault.wrong] { td class="n" { (count) } }
                        td class="n" { (fault.accepted_after) " of " (fault.frames_after) }
                        td class="n" { (fault.wrong_after) }
                        td class="n" { (maybe(fault.recovery_s, 2, "s")) }
                    } } }
                } }
            }
        }
    }
}
