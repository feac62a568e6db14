//! Residuals of a rig and their derivatives.

use super::super::lens::Interior;
use super::super::model::{At, Model, Row, Structure};
use super::sight::{Sight, in_front, lens};
use super::{HEAD, LENS, Observation, Rig, Station, TIME};
use nalgebra::Vector3;

/// A rig at some values of its unknowns.
#[derive(Debug)]
pub struct RigAt<'a> {
    rig: &'a Rig,
    x: &'a [f64],
    /// A station's with each head.
    sights: Vec<Sight>,
    lenses: Vec<Interior>,
}

impl Model for Rig {
    type At<'a> = RigAt<'a>;

    fn structure(&self) -> &Structure {
        &self.structure
    }

    fn at<'a>(&'a self, x: &'a [f64]) -> RigAt<'a> {
        let heads: Vec<[f64; HEAD]> = (0..self.heads.len()).map(|head| self.head(x, head)).collect();
        let mut sights = Vec::with_capacity(self.stations.len() * heads.len());
        for (index, station) in self.stations.iter().enumerate() {
            let station = Station { values: self.station(x, index), ..*station };
            sights.extend(heads.iter().map(|head| Sight::new(head, &station)));
        }
        RigAt { rig: self, x, sights, lenses: heads.iter().map(|head| Interior(lens(head))).collect() }
    }
}

impl RigAt<'_> {
    fn sight(&self, seen: &Observation) -> &Sight {
        &self.sights[seen.station * self.rig.heads.len() + seen.head]
    }

    /// Of the prediction: what the residual is to be multiplied by is 1 / sigma.
    fn weight(&self, seen: &Observation) -> f64 {
        1.0 / self.rig.sigma_px[seen.head]
    }
}

impl At for RigAt<'_> {
    fn residual(&self, observation: usize) -> Option<[f64; 2]> {
        let seen = &self.rig.observations[observation];
        let u = self.sight(seen).u(self.rig.point(self.x, seen.point));
        let weight = self.weight(seen);
        in_front(&u).then(|| {
            let image = self.lenses[seen.head].image([-u.x / u.z, -u.y / u.z]);
            [0, 1].map(|k| (image[k] - seen.image_px[k]) * weight)
        })
    }

    fn linearise(&self, observation: usize, row: &mut Row) -> bool {
        let seen = &self.rig.observations[observation];
        let sight = self.sight(seen);
        let from_centre = Vector3::from(self.rig.point(self.x, seen.point)) - sight.centre;
        let q = sight.to_platform * from_centre - sight.d;
        let u = sight.to_head * q;
        if !in_front(&u) {
            return false;
        }
        let tangents = [-u.x / u.z, -u.y / u.z];
        let imaged = self.lenses[seen.head].imaged(tangents);
        let weight = self.weight(seen);
        row.residual = [0, 1].map(|k| (imaged.point_px[k] - seen.image_px[k]) * weight);

        // Derivatives of u: by the point, by the station's angles, by the head's.
        let by_point = sight.to_head * sight.to_platform;
        let by_angle = sight.by_angle.map(|matrix| sight.to_head * (matrix * from_centre));
        let by_mount = sight.by_mount.map(|matrix| matrix * q);
        let by_time = by_angle[0] * sight.rates[0] + by_angle[1] * sight.rates[1] + by_angle[2] * sight.rates[2]
            - by_point * Vector3::new(sight.rates[3], sight.rates[4], sight.rates[5]);
        let free = &self.rig.heads[seen.head].free;
        for e in 0..2 {
            // Of the image point by u: lens times perspective.
            let [a, b] = imaged.by_tangent[e];
            let by_u = Vector3::new(-a, -b, -(a * tangents[0] + b * tangents[1])) * (weight / u.z);
            let point = by_point.tr_mul(&by_u);
            row.point[e] = point.into();
            for k in 0..3 {
                row.station[e][k] = by_u.dot(&by_angle[k]);
                row.station[e][3 + k] = -point[k];
            }
            for (value, number) in row.head[e].iter_mut().zip(free) {
                *value = match *number {
                    k @ 0..3 => by_u.dot(&by_mount[k]),
                    k @ 3..6 => -by_u.dot(&sight.to_head.column(k - 3)),
                    TIME => by_u.dot(&by_time),
                    k => weight * imaged.by_interior[e][k - LENS],
                };
            }
        }
        true
    }
}
