//! Rules of the documents: short front pages, links and paths that lead somewhere, no page that the book lacks.

use crate::workspace::{relative, root};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every Markdown file of the repository, relative to its root.
fn pages() -> Vec<PathBuf> {
    let mut found = Vec::new();
    collect(&root(), &mut found);
    found.sort();
    found
}

fn collect(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let (path, name) = (entry.path(), entry.file_name());
        if path.is_dir() && !name.to_string_lossy().starts_with('.') && name != "target" {
            collect(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.extend(relative(&path));
        }
    }
}

fn text(page: &Path) -> String {
    fs::read_to_string(root().join(page)).unwrap_or_else(|error| panic!("{}: {error}", page.display()))
}

/// The lines that are prose: neither in a fence nor indented as code.
fn prose(text: &str) -> impl Iterator<Item = &str> {
    let mut is_fenced = false;
    text.lines().filter(move |line| {
        let is_fence = line.trim_start().starts_with("```");
        is_fenced ^= is_fence;
        !is_fenced && !is_fence && !line.starts_with("    ")
    })
}

/// What links and pictures of a page lead to.
fn links(text: &str) -> Vec<String> {
    let joined = prose(text).collect::<Vec<_>>().join("\n");
    joined.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(target, _)| target.to_owned()).collect()
}

/// The names by which a page's headings are linked, as GitHub and mdBook make them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = prose(text).filter(|line| line.starts_with('#'));
    let slug = |heading: &str| -> String {
        let kept = heading.trim_start_matches('#').trim().chars();
        let kept = kept.filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'));
        kept.collect::<String>().to_lowercase().replace(' ', "-")
    };
    headings.map(slug).collect()
}

#[test]
fn the_front_pages_are_short() {
    for (page, most) in [("README.md", 120), ("ARCHITECTURE.md", 150)] {
        let lines = text(Path::new(page)).lines().count();
        assert!(lines <= most, "{page} has {lines} lines, of {most}");
    }
}

#[test]
fn links_lead_somewhere() {
    let mut broken = Vec::new();
    for page in pages() {
        let text = text(&page);
        for link in links(&text).iter().filter(|link| !link.contains("://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let file = if file.is_empty() { page.clone() } else { page.with_file_name("").join(file) };
            let is_there = root().join(&file).exists();
            if !is_there || !(anchor.is_empty() || anchors(&self::text(&file)).contains(anchor)) {
                broken.push(format!("{}: {link}", page.display()));
            }
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// Words in backticks that begin with a folder of the repository are paths in it.
#[test]
fn paths_are_there() {
    let folders: BTreeSet<String> = fs::read_dir(root())
        .expect("the root is readable")
        .flatten()
        .filter(|entry| entry.path().is_dir())
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .filter(|name| name != "target")
        .collect();
    let mut missing = Vec::new();
    // The changelog tells of what was, too.
    for page in pages().into_iter().filter(|page| page != Path::new("CHANGELOG.md")) {
        let joined = prose(&text(&page)).collect::<Vec<_>>().join("\n");
        for word in joined.split('`').skip(1).step_by(2) {
            let is_path = word.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c));
            let is_ours = word.split_once('/').is_some_and(|(folder, _)| folders.contains(folder));
            if is_path && is_ours && !root().join(word).exists() {
                missing.push(format!("{}: {word}", page.display()));
            }
        }
    }
    assert!(missing.is_empty(), "{missing:#?}");
}

#[test]
fn the_book_has_every_page() {
    let book = Path::new("docs/SUMMARY.md");
    let listed: BTreeSet<PathBuf> = links(&text(book)).iter().map(|link| Path::new("docs").join(link)).collect();
    let there: BTreeSet<PathBuf> =
        pages().into_iter().filter(|page| page.starts_with("docs") && page != book).collect();
    assert_eq!(listed, there);
}

/// The table of kernels has the counts of the budget's.
#[test]
fn kernels_cost_what_the_budget_says() {
    let budget = fs::read_to_string(root().join("tests/expected/budget.json")).expect("the budget's table is there");
    let counts: serde_json::Value = serde_json::from_str(&budget).expect("the budget's table is JSON");
    let kernels = text(Path::new("docs/kernels.md"));
    for (kernel, workload) in [
        ("one reading a cell", "one reading, 512x512 to 64x64"),
        ("boxes of 4 x 4, as on board", "rectify 512x512 to 64x64"),
        ("boxes of 2 x 2", "boxes of 2x2, 512x512 to 64x64"),
        ("boxes of 8 x 8", "boxes of 8x8, 512x512 to 64x64"),
        ("frame not reduced", "boxes of 1x1, 512x512 to 64x64"),
    ] {
        let count = counts["instructions"][workload].as_f64().expect(workload);
        let row = format!("| {kernel} | this core | {:.2} |", count / (512.0 * 512.0));
        assert!(kernels.contains(&row), "no {row}: cargo xtask compare --front docs");
    }
}
