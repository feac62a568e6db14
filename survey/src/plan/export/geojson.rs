//! `plan.geojson`: area, strips, photos and footprints for geographic information systems (RFC 7946).
//!
//! Longitude and latitude in WGS 84, the only coordinates that RFC 7946 knows. Where the place is not known the features are
//! unlocated (their geometry is null) and have their local metres in the member `local_geometry` of their properties. Strips
//! and photos are numbered as in `plan.json`: from 0, strips in the order of flight, photos from a strip's low end.

use super::{Outputs, counter_clockwise};
use crate::error::InputError;
use crate::plan::flown::Leg;
use crate::plan::footprint::Sight;
use rayon::prelude::*;
use serde_json::{Value, json};

/// What is said of coordinates on Earth.
const NOTE: &str = "Longitude and latitude in WGS 84. Heights are metres above the elevation model's height datum, not above the \
                    ellipsoid. Footprints: the rays of the frame's corners to the terrain, to the base plane where the \
                    elevation model ends.";
/// The note where nobody knows the place.
const NOTE_LOCAL: &str = "The elevation model has no reference system: nobody knows longitude and latitude, and the features have no \
     geometry. local_geometry in their properties is in its local metres. Heights are metres above its height datum. Footprints: \
     the rays of the frame's corners to the terrain, to the base plane where the elevation model ends.";

impl Outputs<'_> {
    /// The file's text, a feature a line.
    pub(super) fn geojson(&self) -> Result<String, InputError> {
        let legs: Vec<Leg<'_>> = self.legs().collect();
        let sight = Sight::new(&self.planned.layout);
        let mut features = vec![self.feature(
            json!({ "type": "Polygon", "coordinates": [self.ring(self.area())?] }),
            json!({
                "kind": "area",
            }),
        )];
        for (strip, (leg, file)) in legs.iter().zip(&self.file.strips).enumerate() {
            let way = leg.way([leg.from_m(), leg.to_m()]).into_iter().map(|[along_m, _]| self.photo(leg, along_m));
            features.push(self.feature(
                json!({ "type": "LineString", "coordinates": way.collect::<Result<Vec<_>, InputError>>()? }),
                json!({
                    "kind": "strip",
                    "strip": strip,
                    "line": file.line,
                    "heading_deg": file.heading_deg,
                    "photos": file.photos.len(),
                }),
            ));
        }
        let photos: Vec<(usize, usize, &Leg<'_>, f64)> = legs
            .iter()
            .enumerate()
            .flat_map(|(strip, leg)| {
                leg.strip.along_m.iter().enumerate().map(move |(number, along_m)| (strip, number, leg, *along_m))
            })
            .collect();
        for (strip, number, leg, along_m) in &photos {
            features.push(self.feature(
                json!({ "type": "Point", "coordinates": self.photo(leg, *along_m)? }),
                json!({ "kind": "photo", "strip": strip, "number": number }),
            ));
        }
        let footprints = photos.par_iter().map(|(strip, number, leg, along_m)| {
            let corners = sight.corners(leg.strip, *along_m);
            Ok(self.feature(
                json!({ "type": "Polygon", "coordinates": [self.ring(corners.to_vec())?] }),
                json!({ "kind": "footprint", "strip": strip, "number": number }),
            ))
        });
        features.extend(footprints.collect::<Result<Vec<String>, InputError>>()?);
        let note = if self.place.is_known() { NOTE } else { NOTE_LOCAL };
        Ok(format!(
            "{{\"type\":\"FeatureCollection\",\"note\":{},\"features\":[\n{}\n]}}\n",
            json!(note),
            features.join(",\n")
        ))
    }

    fn feature(&self, geometry: Value, mut properties: Value) -> String {
        if self.place.is_known() {
            return json!({ "type": "Feature", "geometry": geometry, "properties": properties }).to_string();
        }
        properties["local_geometry"] = geometry;
        json!({ "type": "Feature", "geometry": null, "properties": properties }).to_string()
    }

    /// A closed ring, counter-clockwise.
    fn ring(&self, corners: Vec<[f64; 2]>) -> Result<Vec<[f64; 2]>, InputError> {
        let places = corners.into_iter().map(|corner| self.position(corner));
        let mut ring = counter_clockwise(places.collect::<Result<_, InputError>>()?);
        ring.extend(ring.first().copied());
        Ok(ring)
    }

    fn photo(&self, leg: &Leg<'_>, along_m: f64) -> Result<[f64; 3], InputError> {
        let layout = &self.planned.layout;
        let [x, y] = self.position(layout.axes.point([along_m, leg.strip.across_m]))?;
        Ok([x, y, millimetres(layout.view.up_m(leg.strip.course.rise_m(along_m)))])
    }

    /// Longitude and latitude, or local metres.
    fn position(&self, metres: [f64; 2]) -> Result<[f64; 2], InputError> {
        Ok(self.lon_lat(metres)?.unwrap_or(metres.map(millimetres)))
    }
}

fn millimetres(metres: f64) -> f64 {
    (metres * 1000.0).round() / 1000.0
}
