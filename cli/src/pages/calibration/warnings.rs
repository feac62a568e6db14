//! What the reader has to know of the block before believing the page.

use super::Page;
use maud::{Markup, html};

impl Page<'_> {
    pub(super) fn warnings(&self) -> Markup {
        let mut warnings: Vec<String> = self.seams.assumed.clone();
        if self.before.designed.is_none() {
            warnings.push(
                "With the heads as designed the adjustment does not come to an end: “before” shows the start values."
                    .into(),
            );
        }
        html! {
            @if !warnings.is_empty() {
                div class="warnings" role="note" {
                    h2 { (warnings.len()) @if warnings.len() == 1 { " warning" } @else { " warnings" } }
                    ul { @for warning in warnings { li { (warning) } } }
                }
            }
        }
    }
}
