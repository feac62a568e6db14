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
                @for figure in drawn { (picture(paper, figure)) }
                @if !others.is_empty() { div class="two" { @for figure in others { (picture(paper, figure)) } } }
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
            h2 { (signs(rows.first().map_or("", |row| row.table))) }
            table class="wide" {
                thead { tr { th { "Quantity" } th class="r" { "Paper" } th class="r" { "Ours" } } }
                tbody { @for (index, row) in rows.iter().enumerate() {
                    tr {
                        th { (signs(&row.quantity)) @if let Some(why) = &row.difference {
                            small { @if !is_control(row) { b class="warn" { "differs: " } } @if above(index) == Some(why) { "as above" } @else { (signs(&minus(why))) } }
                        } }
                        @for shown in row.shown(decimals) { td class="n" { @if shown == "-" { "–" } @else { (minus(&shown)) } } }
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

/// A terminal's words with the signs of a page.
fn signs(text: &str) -> String {
    let sign = |word: &str| match word {
        "um" => "µm".to_owned(),
        "um," => "µm,".to_owned(),
        "(+-" => "(±".to_owned(),
        other => other.to_owned(),
    };
    text.split(' ').map(sign).collect::<Vec<_>>().join(" ")
}

/// What the pictures are that bear no words.
const WORDLESS: [(&str, &str, &str); 4] = [
    ("003", "figure_3a.png", "The frame as it was taken, row 0 forward."),
    ("003", "figure_3b.png", "Rectified automatically, as the board does, north up."),
    ("003", "figure_3c.png", "Rectified by a polynomial."),
    ("003", "figure_3d.png", "Rectified by the collinearity equations."),
];

/// From so many units on a drawing's letters are small.
const WIDE: f64 = 700.0;
/// Least pixels of a screen that a unit of such a drawing has.
const LEAST: f64 = 0.7;

fn picture(paper: &str, (name, bytes): &Figure) -> Markup {
    let is_drawn = name.ends_with(".svg");
    let kind = if is_drawn { "svg+xml" } else { "png" };
    let what = WORDLESS.iter().find(|(of, file, _)| *of == paper && file == name).map_or("", |(_, _, what)| what);
    let wide = is_drawn.then(|| width(bytes)).flatten().filter(|width| *width >= WIDE);
    let class = if wide.is_some() { Some("drawn profile") } else { is_drawn.then_some("drawn") };
    html! {
        figure class=[class] {
            img class="sheet" style=[wide.map(|width| format!("--least:{:.0}px", LEAST * width))] src=(format!("data:image/{kind};base64,{}", STANDARD.encode(bytes))) alt=(if what.is_empty() { name } else { what });
            figcaption { @if !what.is_empty() { (what) " " } span class="hash" { (name) } }
        }
    }
}

/// Width of a drawing as it says it.
fn width(svg: &[u8]) -> Option<f64> {
    let head = String::from_utf8_lossy(&svg[..svg.len().min(HEAD_BYTES)]).into_owned();
    head.split_once("width=\"")?.1.split('"').next()?.parse().ok()
}

/// Bytes in which a drawing says its size.
const HEAD_BYTES: usize = 200;

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
        let page = page("009", "Of nothing.", &rows, 3, &[("figure_1.svg", b"<svg width=\"1200\"/>".to_vec())]);
        assert_eq!((page.matches("another wind").count(), page.matches("as above").count()), (1, 1));
        assert!(
            page.contains("4 figures")
                && page.contains("2 differ<")
                && page.contains("1 is a control")
                && page.contains(
                    r#"<figure class="drawn profile"><img class="sheet" style="--least:840px" src="data:image/svg+xml;base64,"#
                )
        );
        assert!(page.contains("<td class=\"n\">–</td>"), "a dash where there is no number");
        assert_eq!(signs("a, um, or 2 um (+- 0.1)"), "a, µm, or 2 µm (± 0.1)");
        let frame = self::page("003", "", &rows, 3, &[("figure_3b.png", Vec::new())]);
        assert!(frame.contains("Rectified automatically"), "{frame}");
    }
}
