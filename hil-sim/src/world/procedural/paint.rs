//! The tone of the bare land, pixel by pixel: crops and their rows, borders, the river, the main road.

use super::layout::{Crossing, Layout};
use super::parcels::{Edge, Parcel, Spot, Use};
use super::{SIDE, local_m};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// How far to the south-east the grain of a field is taken from that got another one, pixels. Chosen: farther than the grain's largest
/// pieces.
const OTHER_GRAIN: usize = 1300;

/// Grey values of the land without trees and houses. `grain` is the fine texture, one value a pixel.
pub(super) fn paint(layout: &Layout, grain: &[f32]) -> Vec<f32> {
    let roads: Vec<Crossing> = (0..SIDE).map(|col| layout.road_at(local_m(col))).collect();
    let elsewhere =
        |row: usize, col: usize| f64::from(grain[(row + OTHER_GRAIN) % SIDE * SIDE + (col + OTHER_GRAIN) % SIDE]);
    let mut albedo = vec![0f32; SIDE * SIDE];
    albedo.par_chunks_mut(SIDE).enumerate().for_each(|(row, line)| {
        let y = -local_m(row);
        let river = layout.river_at(y);
        let at_x = layout.along_row(y);
        for (col, value) in line.iter_mut().enumerate() {
            let grain = f64::from(grain[row * SIDE + col]);
            let x = local_m(col);
            let (straight, soil) = at_x(x);
            let spot = layout.parcels().locate(straight);
            let tone = land(spot, straight, soil, if spot.parcel.other_grain { elsewhere(row, col) } else { grain });
            let tone = with_river(tone, river.beyond(x) + 1.5 * soil, soil, grain);
            *value = with_road(tone, x, &roads[col], y, soil, grain) as f32;
        }
    });
    albedo
}

/// 1 inside, 0 outside, over half a metre in between. `beyond_m` is the distance outside the border.
fn cover(beyond_m: f64) -> f64 {
    (0.5 - 2.0 * beyond_m).clamp(0.0, 1.0)
}

fn mix(under: f64, over: f64, share: f64) -> f64 {
    under + (over - under) * share
}

/// Parcel and what runs along its border.
fn land(spot: Spot<'_>, straight: [f64; 2], soil: f64, grain: f64) -> f64 {
    let mut tone = parcel_tone(&spot, straight, soil, grain);
    let verge = match spot.edge {
        Edge::Lane => 1.8,
        Edge::Track => 0.8,
        _ => 0.0,
    };
    if verge > 0.0 {
        tone = mix(tone, 112.0 + 12.0 * grain, cover(spot.beyond_m - verge - 0.3 * grain));
    }
    mix(tone, edge_tone(&spot, soil, grain), cover(spot.beyond_m))
}

/// Rough grass, a bright rim of gravel, then water, brighter where it is shallow.
fn with_river(tone: f64, beyond_bank: f64, soil: f64, grain: f64) -> f64 {
    if beyond_bank >= 14.0 {
        return tone;
    }
    let tone = mix(tone, 112.0 + 16.0 * grain, ((14.0 - beyond_bank) / 4.0).clamp(0.0, 1.0));
    let tone = mix(tone, 150.0 + 14.0 * grain, cover(beyond_bank - 1.2 - 0.8 * grain));
    let depth = (-beyond_bank / 6.0).clamp(0.0, 1.0);
    mix(tone, mix(88.0, 52.0, depth) + 9.0 * soil + 4.0 * grain, cover(beyond_bank))
}

/// Verge, shoulder, asphalt, edge lines and a dashed middle line.
fn with_road(tone: f64, x: f64, road: &Crossing, y: f64, soil: f64, grain: f64) -> f64 {
    let beside = road.beyond(y);
    if beside >= 5.0 {
        return tone;
    }
    let tone = mix(tone, 122.0 + 13.0 * grain, cover(beside - 3.0));
    let tone = mix(tone, 150.0 + 8.0 * grain, cover(beside - 0.9));
    let tone = mix(tone, 98.0 + 5.0 * grain + 3.0 * soil, cover(beside));
    let painted = |from_line: f64| 0.8 * cover(2.0 * (from_line.abs() - 0.15));
    let dash = if (x / 9.0).rem_euclid(1.0) < 0.45 { painted(road.offset(y)) } else { 0.0 };
    mix(tone, 200.0, dash.max(painted(beside + 0.5)))
}

/// Crop and rows. Near the border the rows turn and run along it, as a tractor does on the headland.
fn parcel_tone(spot: &Spot<'_>, [x, y]: [f64; 2], soil: f64, grain: f64) -> f64 {
    let parcel = spot.parcel;
    let along = x * parcel.along[0] + y * parcel.along[1];
    let across = y * parcel.along[0] - x * parcel.along[1];
    let large = parcel.area_m2 > 6_000.0;
    let headland = large && spot.beyond_m < 10.0 && parcel.row_contrast > 3.0;
    let across_rows = if headland { spot.beyond_m } else { across };
    // A wave of the row contrast keeps the rows from looking ruled.
    let rows = (TAU * across_rows / parcel.row_period_m).sin() * parcel.row_contrast * (1.0 + 0.4 * grain);
    let soil_contrast = match parcel.kind {
        Use::Ploughed => 17.0,
        Use::Stubble => 12.0,
        Use::Cereal | Use::RowCrop => 11.0,
        _ => 8.0,
    };
    let mut tone = parcel.tone + soil_contrast * soil + parcel.grain * grain + rows;
    match parcel.kind {
        Use::Cereal | Use::Stubble if !headland => tone += tramlines(parcel, across),
        Use::Orchard => {
            // Crowns on a square lattice, with the dark of the shadow to the north-west of each.
            let cell = |a: f64| (a / parcel.row_period_m).rem_euclid(1.0) - 0.5;
            let (u, v) = (cell(along) * parcel.row_period_m, cell(across) * parcel.row_period_m);
            tone = mix(tone, 78.0, cover(((u + 0.8).hypot(v - 0.8) - 1.8) * 0.7));
            tone = mix(tone, 104.0 + 22.0 * grain, cover((u.hypot(v) - 1.9 - 0.3 * grain) * 0.7));
        }
        _ => {}
    }
    tone * parcel.gain + parcel.offset
}

/// The pair of wheel tracks left open every 24 m.
fn tramlines(parcel: &Parcel, across: f64) -> f64 {
    let at = across.rem_euclid(24.0);
    let track = (at - 11.1).abs().min((at - 12.9).abs());
    let sign = if parcel.kind == Use::Cereal { 1.0 } else { -1.0 };
    sign * 22.0 * cover(track - 0.25)
}

fn edge_tone(spot: &Spot<'_>, soil: f64, grain: f64) -> f64 {
    let from_middle = spot.beyond_m + spot.edge.half_width_m();
    match spot.edge {
        Edge::Lane => 150.0 + 5.0 * grain + 4.0 * soil,
        // A pavement along the asphalt.
        Edge::Street if from_middle > 2.5 => 158.0 + 6.0 * grain,
        Edge::Street => 108.0 + 6.0 * grain + 4.0 * soil,
        // Two ruts with grass between them.
        Edge::Track if from_middle < 0.45 => 138.0 + 12.0 * grain,
        Edge::Track => 182.0 + 9.0 * grain + 6.0 * soil,
        Edge::Hedge => 84.0 + 16.0 * grain,
        Edge::Balk => 118.0 + 10.0 * grain,
        Edge::Fence => 88.0 + 12.0 * grain,
    }
}
