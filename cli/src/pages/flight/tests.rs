//! A page of a real flight, in this process.

use super::*;
use plumbline_firmware::serial::message::Counts;
use plumbline_sim::link::inproc::InProcess;
use plumbline_sim::link::{Account, LinkTrouble};
use plumbline_sim::run::{Keep, fly};
use plumbline_sim::scenario::Scenario;
use plumbline_sim::score::unrectified::Unrectified;
use plumbline_sim::score::{self, Linked};
use std::sync::OnceLock;

/// A flight of six frames over the default scene, all pictures kept.
pub(crate) struct Flown {
    pub(crate) setup: Setup,
    pub(crate) flight: Flight,
    pub(crate) scored: Vec<Scored>,
    pub(crate) summary: Summary,
}

impl Flown {
    fn new() -> Self {
        let scenario = Scenario::of_frames(6);
        let setup = Setup::prepare(scenario).expect("the default scene");
        let mut link = InProcess::new(&setup.flash).expect("a firmware");
        let mut unrectified = Unrectified::default();
        let flight = fly(&setup, &mut link, Keep { first: 6, ..Keep::default() }, &mut unrectified).expect("a flight");
        let scored = score::score(&setup, &flight, &unrectified);
        let linked = Linked { name: "inproc".to_owned(), firmware_sha256: None, account: Account::default() };
        let summary = score::summarise(&setup, &flight, &scored, &linked);
        Flown { setup, flight, scored, summary }
    }

    pub(crate) fn report(&self) -> Report<'_> {
        Report { setup: &self.setup, flight: &self.flight, scored: &self.scored, summary: &self.summary }
    }

    fn html(&self) -> String {
        self.report().html().expect("a page")
    }
}

/// One flight for all tests.
pub(crate) fn flown() -> &'static Flown {
    static FLOWN: OnceLock<Flown> = OnceLock::new();
    FLOWN.get_or_init(Flown::new)
}

/// What stands between `open` and the next `<`, for every `open` of the page.
fn contents<'p>(page: &'p str, open: &str) -> Vec<&'p str> {
    page.split(open).skip(1).map(|rest| rest.split('<').next().unwrap_or("")).collect()
}

/// The number cells, whatever else their class says.
fn number_cells(page: &str) -> Vec<&str> {
    contents(page, "<td class=\"n").into_iter().map(|cell| cell.split_once('>').map_or("", |(_, text)| text)).collect()
}

#[test]
fn the_page_needs_nothing_but_itself_and_no_number_is_missing() {
    let flown = flown();
    let page = flown.html();
    for outside in ["http://", "https://", "src=\"/", "<script src", "<link", "@import", "url("] {
        assert!(!page.contains(outside), "{outside}");
    }
    assert!(page.contains("name=\"viewport\""));
    let sources = contents(&page, "src=\"");
    assert_eq!(sources.len(), 24, "six frames of four pictures");
    assert!(sources.iter().all(|source| source.starts_with("data:image/png;base64,")));
    // Track, errors, their histogram, the board's own position, and a score surface a frame.
    assert_eq!(page.matches("<svg ").count(), 4 + 6);
    assert_eq!(page.matches("</svg>").count(), 4 + 6);

    let cells = number_cells(&page);
    assert!(cells.len() > 30, "{}", cells.len());
    assert!(cells.iter().all(|cell| !cell.trim().is_empty()), "{cells:?}");
    // What pictures are written in may hold any letters.
    let words: String = page.split("base64,").map(|part| part.split_once('"').map_or(part, |(_, rest)| rest)).collect();
    assert!(!words.contains("NaN") && !words.contains("inf "));
    // In this process there is nothing to count instructions with, and the page says so.
    assert!(page.contains(plumbline_charts::format::NOT_MEASURED));
    let mean = flown.summary.matching_error_px.rectified_mean.expect("accepted frames");
    assert!(page.contains(&plumbline_charts::format::number(mean, 2, "px")));
}

#[test]
fn a_flight_without_a_single_fix_has_a_page_too() {
    let setup = &flown().setup;
    let mut flight = flown().flight.clone();
    for record in &mut flight.frames {
        (record.report, record.patch) = (None, None);
    }
    let scored = score::score(setup, &flight, &Unrectified::default());
    let linked =
        Linked { name: "qemu".to_owned(), firmware_sha256: Some("ab".repeat(32)), account: Account::default() };
    let summary = score::summarise(setup, &flight, &scored, &linked);
    let page = Report { setup, flight: &flight, scored: &scored, summary: &summary }.html().expect("a page");
    assert!(page.contains("None of the 6 frames became a fix."));
    assert!(page.contains("refused: lost") && page.contains(&"ab".repeat(32)));
    assert!(number_cells(&page).iter().all(|cell| !cell.trim().is_empty()));
}

/// Cycles stand under their own name, instructions nowhere, and the line's trouble is reported.
#[test]
fn a_board_that_counts_cycles() {
    let setup = &flown().setup;
    let mut flight = flown().flight.clone();
    for report in flight.frames.iter_mut().filter_map(|record| record.report.as_mut()) {
        report.instructions = [1000, 200, 30, 4, 0, 0];
    }
    let scored = score::score(setup, &flight, &Unrectified::default());
    let trouble = LinkTrouble { resends: 4711, ..LinkTrouble::default() };
    let account = Account {
        counts: Counts::Cycles,
        core_clock_hz: Some(480_000_000),
        board: Some("some board 1.0".to_owned()),
        trouble: Some(trouble),
        ..Account::default()
    };
    let linked = Linked { name: "serial".to_owned(), firmware_sha256: None, account };
    let summary = score::summarise(setup, &flight, &scored, &linked);
    assert_eq!((summary.cycles_per_frame.mean, summary.cycles_per_frame.max), (Some(1234.0), Some(1234)));
    assert_eq!((summary.instructions_per_frame.mean, summary.instructions_by_stage), (None, None));
    assert_eq!((summary.core_clock_hz, summary.link_faults), (Some(480_000_000), Some(trouble)));
    let page = Report { setup, flight: &flight, scored: &scored, summary: &summary }.html().expect("a page");
    for text in ["234 cycles a frame", "Cycles a frame, mean", "4\u{202f}711", "some board 1.0", "over a serial line"] {
        assert!(page.contains(text), "{text}");
    }
    assert!(!page.contains("Instructions a frame"));
}

#[test]
fn a_wrong_fix_is_called_one() {
    let flown = flown();
    let mut scored = flown.scored.clone();
    let called = |scored: &[Scored]| {
        let report = Report { setup: &flown.setup, flight: &flown.flight, scored, summary: &flown.summary };
        let page = report.html().expect("a page");
        (page.contains("Wrong fixes: 1,"), page.contains("accepted, but wrong"))
    };
    assert_eq!(called(&scored), (false, false));
    let place = scored.iter().position(|scored| scored.accepted).expect("an accepted frame");
    let resolution_m = flown.setup.scenario.vehicle.resolution_m;
    // Two pixels are wrong of a fix that claims to be better, as `wrong_fixes` counts them.
    for (sigmas, is_wrong) in [(4.0, false), (6.0, true)] {
        let (error_m, nees) = (Some([0.0, -2.0 * resolution_m]), Some(sigmas * sigmas));
        scored[place] = Scored { error_px: Some([0.0, 2.0]), error_m, nees, ..scored[place] };
        assert_eq!(called(&scored), (is_wrong, is_wrong), "{sigmas} sigmas");
    }
}

#[test]
fn the_same_flight_gives_the_same_bytes() {
    assert!(flown().html() == Flown::new().html());
}
