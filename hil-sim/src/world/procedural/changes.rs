//! What has happened to the fields: each parcel that changed looks otherwise and lies where it did.

use super::layout::Layout;
use super::parcels::{Parcel, Use};
use super::streams;
use crate::noise::pixels::{stream, uniform, unit};
use crate::scenario::{Changes, Season};

/// Grey of a flooded field: that of the painted river where it is deep.
const FLOOD: f64 = 52.0;
/// Grey about which fields are mirrored: between those of dark and bright crops.
const MIDDLE: f64 = 122.0;

/// Changes the parcels that trees and houses have already been placed on.
pub(super) fn make(changes: &Changes, seed: u64, layout: &mut Layout) {
    if *changes == Changes::default() {
        return;
    }
    let mut rng = stream(seed, streams::CHANGES);
    for parcel in layout.parcels_mut() {
        // Drawn for every parcel, so that one fraction leaves the others' choice.
        let [ploughed, flooded, inverted] = [(); 3].map(|()| unit(&mut rng));
        let [tone, rows] = [uniform(&mut rng, -1.0, 1.0), uniform(&mut rng, 0.5, 1.3)];
        if matches!(parcel.kind, Use::Wood | Use::Yard | Use::Orchard) {
            turn(parcel, changes.season);
            continue;
        }
        if ploughed < changes.ploughed_fraction {
            plough(parcel, tone, rows);
        }
        turn(parcel, changes.season);
        if inverted < changes.inverted_fraction {
            (parcel.gain, parcel.offset) = (-parcel.gain, 2.0 * MIDDLE - parcel.offset);
        }
        if flooded < changes.flooded_fraction {
            (parcel.gain, parcel.offset) = (0.0, FLOOD);
        }
    }
}

/// A bare field becomes a crop and any other one bare, with its rows turned and another grain; what the soil does to its greys stays.
fn plough(parcel: &mut Parcel, tone: f64, rows: f64) {
    parcel.kind = if parcel.kind == Use::Ploughed { Use::Stubble } else { Use::Ploughed };
    let looks = parcel.kind.looks();
    parcel.along = [-parcel.along[1], parcel.along[0]];
    parcel.tone = looks.tone + looks.spread * tone;
    (parcel.grain, parcel.other_grain) = (looks.grain, true);
    parcel.row_contrast = looks.row_contrast * rows;
    parcel.row_period_m = looks.row_period_m * rows.max(0.85);
}

fn turn(parcel: &mut Parcel, season: Season) {
    [parcel.gain, parcel.offset] = match parcel.kind {
        Use::Ploughed | Use::Stubble => season.bare,
        Use::Cereal | Use::RowCrop => season.crops,
        Use::Meadow | Use::Orchard | Use::Yard => season.meadow,
        Use::Wood => season.trees,
    };
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fields before and after, in pairs.
    fn changed(changes: Changes) -> Vec<[Parcel; 2]> {
        let (mut before, mut after) = (Layout::new(1), Layout::new(1));
        make(&Changes::default(), 1, &mut before);
        make(&changes, 1, &mut after);
        let pairs = before.parcels().all().iter().zip(after.parcels().all());
        let is_field = |parcel: &Parcel| !matches!(parcel.kind, Use::Wood | Use::Yard | Use::Orchard);
        pairs.filter(|(before, _)| is_field(before)).map(|(before, after)| [before.clone(), after.clone()]).collect()
    }

    fn share(fields: &[[Parcel; 2]], is: impl Fn(&Parcel, &Parcel) -> bool) -> f64 {
        fields.iter().filter(|[before, after]| is(before, after)).count() as f64 / fields.len() as f64
    }

    #[test]
    fn each_change_takes_its_share_of_the_fields() {
        let untouched = |before: &Parcel, after: &Parcel| {
            (before.kind, before.along, before.tone, before.gain, before.offset)
                == (after.kind, after.along, after.tone, after.gain, after.offset)
        };
        assert_eq!(share(&changed(Changes::default()), untouched), 1.0);
        let ploughed = changed(Changes { ploughed_fraction: 0.6, ..Changes::default() });
        let turned = |before: &Parcel, after: &Parcel| {
            let square = before.along[0] * after.along[0] + before.along[1] * after.along[1] == 0.0;
            square && after.other_grain && before.tone != after.tone
        };
        let flooded = changed(Changes { flooded_fraction: 0.3, ..Changes::default() });
        let inverted = changed(Changes { inverted_fraction: 0.5, ..Changes::default() });
        for (fields, wanted, is) in [
            (&ploughed, 0.6, &turned as &dyn Fn(&Parcel, &Parcel) -> bool),
            (&flooded, 0.3, &|_: &Parcel, after: &Parcel| (after.gain, after.offset) == (0.0, FLOOD)),
            (&inverted, 0.5, &|_: &Parcel, after: &Parcel| (after.gain, after.offset) == (-1.0, 2.0 * MIDDLE)),
        ] {
            // Three standard errors of some hundreds of fields.
            let sigma = (wanted * (1.0 - wanted) / fields.len() as f64).sqrt();
            let found = share(fields, is);
            assert!((found - wanted).abs() < 3.0 * sigma, "{found} of {} fields, {wanted}", fields.len());
            assert!((found + share(fields, untouched) - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn the_season_turns_each_kind_by_its_own_gain() {
        let season = Season { bare: [0.5, 1.0], crops: [2.0, 3.0], meadow: [0.25, -5.0], trees: [1.5, 0.0] };
        let mut layout = Layout::new(1);
        make(&Changes { season, ..Changes::default() }, 1, &mut layout);
        for parcel in layout.parcels().all() {
            let wanted = match parcel.kind {
                Use::Ploughed | Use::Stubble => season.bare,
                Use::Cereal | Use::RowCrop => season.crops,
                Use::Wood => season.trees,
                Use::Meadow | Use::Orchard | Use::Yard => season.meadow,
            };
            assert_eq!([parcel.gain, parcel.offset], wanted, "{:?}", parcel.kind);
        }
    }
}
