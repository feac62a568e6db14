//! Files, how to fly the plan, and what it takes for granted.

use super::Page;
use maud::{Markup, html};
use plumbline_charts::format::whole;
use plumbline_survey::plan::export::ITEMS_MAX;
use plumbline_survey::plan::file::Datum;

impl Page<'_> {
    /// What that datum is: the end of a sentence, and what becomes of it for an autopilot.
    fn datum(&self) -> String {
        let Some(vertical) = &self.outputs.file.vertical else {
            return ", whatever that is.".to_owned();
        };
        match (vertical.datum, vertical.epsg) {
            (Datum::Stated, Some(epsg)) => {
                format!(", EPSG:{epsg}. plan.plan and plan.kml take that for mean sea level.")
            }
            (Datum::Stated, None) => {
                ", which it names. plan.plan and plan.kml take that for mean sea level.".to_owned()
            }
            (Datum::Assumed, _) => {
                ", which it does not name. That it is mean sea level is assumed in plan.plan and plan.kml: --vertical-epsg states it, \
                 --geoid is for heights above the ellipsoid.".to_owned()
            }
            (Datum::Ellipsoid, _) => {
                let [least, most] = vertical.geoid_height_m.unwrap_or_default();
                format!(
                    ", the ellipsoid. In plan.plan and plan.kml the heights of the geoid {} are subtracted, {least:.2} to {most:.2} m, so that \
                     altitudes are above mean sea level.",
                    vertical.geoid.as_deref().unwrap_or_default()
                )
            }
        }
    }

    pub(super) fn files(&self) -> Markup {
        let outputs = self.outputs;
        let items = outputs.mission_items();
        let row = |name: &str, what: Markup| html! { tr { th class="hash" { (name) } td { (what) } } };
        html! {
            section {
                h2 { "Files, and how to fly it" }
                pre { "plumbline fly --plan plan.json --out flight" }
                table {
                    tbody {
                        (row("plan.json", html! { "the plan, for the flight, the simulator and other programs" }))
                        @if outputs.place.is_known() {
                            (row("plan.plan", html! {
                                "mission for QGroundControl: " (whole(items as u64)) " items, "
                                @if outputs.trigger_items { "each photo a waypoint with a camera trigger" } @else if outputs.file.follow.is_some() { "the strips’ waypoints; the photos are triggered on board" } @else { "two waypoints a strip; the photos are triggered on board" }
                                @if items > ITEMS_MAX { ". " span class="bad" { "Common autopilots take " (ITEMS_MAX) " items" } }
                            }))
                            (row("plan.kml", html! { "area, strips and photos for a virtual globe" }))
                        }
                        (row("plan.geojson", html! { "area, strips, photos and footprints for geographic information systems" }))
                        (row("coverage.tif", html! { "photos a cell, most of one strip, horizontal and height standard deviation" }))
                    }
                }
                @if !outputs.place.is_known() {
                    p class="note" { "The elevation model has no reference system and no origin was given, so there is no plan for an autopilot and no KML." }
                }
            }
        }
    }

    pub(super) fn notes(&self) -> Markup {
        let file = self.outputs.file;
        html! {
            section {
                h2 { "Assumptions" }
                ul {
                    li { "Photos are "
                        @if file.tilt_deg > 0.0 { "tilted by " (plumbline_charts::format::short(file.tilt_deg)) "° at most to any side (predicted errors are those of level ones)" } @else { "level" }
                        ", turned into the strip’s heading, and taken where they are planned. There is no wind. What "
                        @if file.tilt_deg == 0.0 { "tilt (--tilt-deg), " } "drift and navigation take off the overlap has to be asked for beforehand." }
                    li { "Heights are those of the elevation model, bilinear between its posts. Trees, houses and masts are in it or not; what stands "
                        "above it lessens overlap and clearance." }
                    li { "Flying heights are above the elevation model’s height datum" (self.datum()) }
                    @match file.epsg {
                        None => li { "The grid is local metres, taken at their face value"
                            @if file.origin_deg.is_some() { " and laid on the ellipsoid at the given origin, its north true north" }
                            "." },
                        Some(_) => li { "Lengths are those of the grid: its scale is not taken off. A model in degrees is worked on in metres about the area’s "
                            "centre, where parallels away from the centre are 0.1 to 0.2 % off within 10 km." },
                    }
                    @if file.checks.strips_off_dem > 0 {
                        li { (whole(file.checks.strips_off_dem as u64)) " strips leave the elevation model: the clearance there is not known." }
                    } @else if file.checks.leaves_model {
                        li { "Ends of strips or turns leave the elevation model: the clearance there is not known." }
                    }
                    @if file.checks.photos_beyond_dem > 0 {
                        li { (whole(file.checks.photos_beyond_dem as u64)) " photos look beyond the elevation model. What is there is not known: neither "
                            "overlap nor clearance is guaranteed." }
                    }
                    @if file.follow.is_some() {
                        li { "The height changes evenly from waypoint to waypoint, as autopilots fly it between waypoints of different heights; what a gust or a "
                            "slow climb leaves comes off the clearance." }
                    }
                    li { "Turns are flown " @if file.follow.is_none() { "level " } "with 30° of bank in still air; take-off, climb, the way to the first strip and back, and landing are not checked." }
                }
            }
        }
    }
}
