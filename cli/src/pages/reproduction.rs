//! `report.html` of a reproduced paper: its figures beside ours, why they differ where they do, and the pictures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use maud::{Markup, html};
use plumbline_charts::format::minus;
use plumbline_papers::Row;

/// A picture by the name of its file, and the file.
pub type Figure = (&'static str, Vec<u8>);

/// The page. `head` says what of, with a full stop; `decimals` are those of the numbers at most.
pub fn page(paper: &str, head: &str, rows: &[Row], decimals: usize, figures: &[Figure]) -> String {
    let controls = rows.iter().filter(|row| is_control(row)).count();
    let differ = rows.iter().filter(|row| row.difference.is_some()).count() - controls;
    let body = html! {
        header {
            p class="kicker" { "Plumbline " (env!("CARGO_PKG_VERSION")) " · reproduction" }
            h1 { "Paper " (paper) }
            p class="note" { (head) }
            p class="verdict" {
                (rows.len()) " figures by this project’s own code beside the paper’s: "
                @if differ == 0 { span class="good" { "none differs." } }
                @else { span class="warn" { (differ) @if differ == 1 { " differs" } @else { " differ" } } ", with the reason below." }
                @if controls > 0 { " " (controls) @if controls == 1 { " is a control," } @else { " are controls," } " computed otherwise on purpose." }
            }
        }
        @for table in rows.chunk_by(|a, b| a.table == b.table) { (section(table, decimals)) }
        @if !figures.is_empty() {
            section {
                h2 { "Pictures" }
                @let (drawn, others): (Vec<_>, Vec<_>) = figures.iter().partition(|(name, _)| name.ends_with(".svg"));
                // Plots have small print, and take the page's width.
                @for figure in drawn { (picture(figure, Some("profile"))) }
                @if !others.is_empty() { div class="two" { @for figure in others { (picture(figure, None)) } } }
            }
        }
    };
    plumbline_charts::page::page(&format!("Plumbline: paper {paper}"), &body)
}

/// A table of the paper. What is said of a row holds of those below it that say the same.
fn section(rows: &[Row], decimals: usize) -> Markup {
    let above = |index: usize| index.checked_sub(1).and_then(|above| rows[above].difference.as_ref());
    html! {
        section {
            h2 { (rows.first().map_or("", |row| row.table)) }
            table class="wide" {
                thead { tr { th { "Quantity" } th class="r" { "Paper" } th class="r" { "Ours" } } }
                tbody { @for (index, row) in rows.iter().enumerate() {
                    tr {
                        th { (row.quantity) @if let Some(why) = &row.difference {
                            small { @if !is_control(row) { b class="warn" { "differs: " } } @if above(index) == Some(why) { "as above" } @else { (minus(why)) } }
                        } }
                        @for shown in row.shown(decimals) { td class="n" { (minus(&shown)) } }
                    }
                } }
            }
        }
    }
}

/// Whether a figure is computed otherwise on purpose, to show what that does.
fn is_control(row: &Row) -> bool {
    row.difference.as_ref().is_some_and(|why| why.starts_with("a control"))
}

fn picture((name, bytes): &Figure, class: Option<&str>) -> Markup {
    let kind = if name.ends_with(".svg") { "svg+xml" } else { "png" };
    html! {
        figure class=[class] {
            img class="sheet" src=(format!("data:image/{kind};base64,{}", STANDARD.encode(bytes))) alt=(name);
            figcaption class="hash" { (name) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_says_why_once() {
        let row = |quantity: &str, difference: Option<&str>| Row {
            decimals: None,
            table: "Table 9",
            quantity: quantity.to_owned(),
            paper: Some(1.5),
            ours: None,
            difference: difference.map(str::to_owned),
        };
        let rows = [
            row("a, m", None),
            row("b, m", Some("another wind")),
            row("c, m", Some("another wind")),
            row("d, m", Some("a control: no wind")),
        ];
        let page = page("009", "Of nothing.", &rows, 3, &[("figure_1.svg", b"<svg/>".to_vec())]);
        assert_eq!((page.matches("another wind").count(), page.matches("as above").count()), (1, 1));
        assert!(
            page.contains("4 figures")
                && page.contains("2 differ<")
                && page.contains("1 is a control")
                && page.contains(r#"<figure class="profile"><img class="sheet" src="data:image/svg+xml;base64,"#)
        );
    }
}
