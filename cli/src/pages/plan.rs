//! `report.html` of a plan: where to fly, what it gives and what it rests on, on one page that needs nothing but itself.
//!
//! Everything on it is computed from the plan. Style and plots are those of a flight's [page](super::flight). The same plan
//! gives the same bytes. However large the plan, the page stays small: the relief has at most some 600,000 pixels, the cells
//! are as many as the planner looks at, many lines are thinned out, and many photos are shown by their density.

mod accuracy;
mod combinations;
mod density;
mod head;
mod map;
mod nearest;
mod notes;
mod profiles;
mod relief;
mod tables;

use map::Map;
use maud::html;
use plumbline_survey::plan::export::Outputs;

/// What the page's sections share.
struct Page<'a> {
    outputs: &'a Outputs<'a>,
    /// What is probably not meant.
    questions: &'a [String],
    map: Map,
}

/// The page; `questions`: what is probably not meant.
pub fn page(outputs: &Outputs<'_>, questions: &[String]) -> String {
    let page = Page { outputs, questions, map: Map::new(outputs) };
    let body = html! {
        (page.head())
        (page.plan())
        (page.profiles())
        (page.coverage())
        (page.overlaps())
        (page.combinations())
        (page.constant())
        (page.checks())
        (page.noise())
        (page.files())
        (page.notes())
    };
    plumbline_charts::page::page("Plumbline flight plan", &body)
}
