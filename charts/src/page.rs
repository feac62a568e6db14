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

/// What a person reads on a terminal, as a sentence on a page: it ends with a mark, but behind the name of a file, where it would be taken along, and no option is
/// torn at the hyphens before it.
pub fn said(text: &str) -> Markup {
    let is_file = text.rsplit(' ').next().is_some_and(|word| word.contains('.'));
    let end = if is_file || text.ends_with(['?', '!']) { "" } else { "." };
    html! {
        @for (index, word) in text.split(' ').enumerate() {
            @if index > 0 { " " }
            @if word.contains("--") { span class="option" { (word) } } @else { (word) }
        }
        (end)
    }
}

#[cfg(test)]
mod tests {
    use super::said;

    #[test]
    fn a_sentence_ends_and_keeps_its_options_whole() {
        let asked = said("a lower --speed-m-s tells it").into_string();
        assert_eq!(asked, "a lower <span class=\"option\">--speed-m-s</span> tells it.");
        assert_eq!(said("tr a b > made.csv").into_string(), "tr a b &gt; made.csv");
        assert_eq!(said("1 < 2: is that meant?").into_string(), "1 &lt; 2: is that meant?");
    }
}
