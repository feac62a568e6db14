//! The shell of a page that needs nothing but itself: its style stands in it, and nothing is requested.

use maud::{DOCTYPE, Markup, PreEscaped, html};

/// A page with its style and nothing from outside.
pub fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) }
                style { (PreEscaped(include_str!("style.css"))) }
            }
            body { main { (body) } }
        }
    };
    page.into_string()
}

/// A figure of the strip below the verdict: its value, and what it is.
pub fn key(value: &str, name: &str) -> Markup {
    key_as("", value, name)
}

/// As [`key`], in the colour of a verdict: `good`, `warn`, `bad`, or none.
pub fn key_as(class: &str, value: &str, name: &str) -> Markup {
    html! { div class=[(!class.is_empty()).then_some(class)] { b { (value) } span { (name) } } }
}
