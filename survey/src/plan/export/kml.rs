//! `plan.kml`: area, strips and photos for a virtual globe (KML 2.2).
//!
//! Altitudes are absolute, which KML takes to be above mean sea level (EGM96); those of the plan are above the elevation model's height
//! datum, less the geoid's where one is given.

use super::Outputs;
use crate::error::InputError;
use crate::plan::flown::Leg;
use maud::{Markup, PreEscaped, html};
use std::fmt::Write;

impl Outputs<'_> {
    /// The file's text.
    pub(super) fn kml(&self) -> Result<String, InputError> {
        let ring = self.border()?;
        let strips = self.legs().enumerate().map(|(strip, leg)| {
            let way = leg.way([leg.from_m(), leg.to_m()]).into_iter().map(|[along_m, _]| self.globe(&leg, along_m));
            let text = way.collect::<Result<Vec<String>, InputError>>()?.join(" ");
            let photos = leg.strip.along_m.len();
            Ok(placemark(
                &format!("strip {strip}"),
                "#strip",
                &format!("{photos} photos"),
                &html! {
                    LineString { altitudeMode { "absolute" } coordinates { (text) } }
                },
            ))
        });
        let photos = self.legs().enumerate().flat_map(|(strip, leg)| {
            leg.strip.along_m.iter().enumerate().map(move |(number, along_m)| {
                let text = self.globe(&leg, *along_m)?;
                Ok(placemark(
                    &format!("{strip}/{number}"),
                    "#photo",
                    "",
                    &html! {
                        Point { altitudeMode { "absolute" } coordinates { (text) } }
                    },
                ))
            })
        });
        let strips: Vec<Markup> = strips.collect::<Result<_, InputError>>()?;
        let photos: Vec<Markup> = photos.collect::<Result<_, InputError>>()?;
        let kml = html! {
            (PreEscaped("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"))
            kml xmlns="http://www.opengis.net/kml/2.2" {
                Document {
                    name { "Flight plan over " (self.dem_name()) }
                    description {
                        (self.file.photo_count) " photos. Altitudes are "
                        @if self.geoid.is_some() { "above mean sea level" } @else { "above the height datum of the elevation model" }
                        ". Strips and photos are numbered as in plan.json."
                    }
                    Style id="area" { LineStyle { color { "ff1d1d1b" } width { "2" } } PolyStyle { fill { "0" } } }
                    Style id="strip" { LineStyle { color { "ff8c5a1f" } width { "2" } } }
                    Style id="photo" { IconStyle { scale { "0.4" } } LabelStyle { scale { "0" } } }
                    Folder {
                        name { "area" }
                        (placemark("area", "#area", "", &html! {
                            Polygon { outerBoundaryIs { LinearRing { coordinates { (ring.trim_end()) } } } }
                        }))
                    }
                    Folder { name { "strips" } @for strip in &strips { (strip) } }
                    Folder { name { "photos" } @for photo in &photos { (photo) } }
                }
            }
        };
        Ok(format!("{}\n", kml.into_string()))
    }

    /// The area's border, closed.
    fn border(&self) -> Result<String, InputError> {
        let mut area = self.area();
        area.extend(area.first().copied());
        let mut ring = String::new();
        for corner in area {
            let [lon, lat] = self.known(corner)?;
            // Writing to a string cannot fail.
            let _ = write!(ring, "{lon},{lat} ");
        }
        Ok(ring)
    }

    /// Longitude, latitude and altitude of a place on a strip.
    fn globe(&self, leg: &Leg<'_>, along_m: f64) -> Result<String, InputError> {
        let layout = &self.planned.layout;
        let [lon, lat] = self.known(layout.axes.point([along_m, leg.strip.across_m]))?;
        let up_m = self.above_sea_m(layout.view.up_m(leg.strip.course.rise_m(along_m)), [lon, lat])?;
        Ok(format!("{lon},{lat},{up_m:.2}"))
    }

    /// The elevation model without the folders it lies in.
    #[must_use]
    pub fn dem_name(&self) -> String {
        let path = std::path::Path::new(&self.file.dem);
        path.file_name().map_or_else(|| self.file.dem.clone(), |name| name.to_string_lossy().into_owned())
    }
}

/// A thing with its name; line feeds between them keep the lines short.
fn placemark(name: &str, style: &str, description: &str, geometry: &Markup) -> Markup {
    html! {
        (PreEscaped("\n"))
        Placemark {
            name { (name) }
            @if !description.is_empty() { description { (description) } }
            styleUrl { (style) }
            (geometry)
        }
    }
}
