//! Whether observations can determine a block, found out before any equation is solved.

use super::axes;
use super::block::Block;
use super::observations::Observations;
use crate::adjust::rig::{Rig, project};
use crate::adjust::{At, Model, Place, Row, rotation};
use crate::error::InputError;
use nalgebra::{DMatrix, Vector3};

/// What a similarity has: translations, rotations, scale.
const FAMILIES: [(&str, usize); 3] = [("position", 3), ("orientation", 3), ("scale", 1)];
/// Least part of the equations that a similarity must touch: below it is rounding.
const TOUCHED_MIN: f64 = 1e-14;
/// By how much a station is turned to see what a rotation does to its angles, rad.
const TURN_RAD: f64 = 1e-6;

/// Checks a block with its observations.
///
/// # Errors
/// A point, station or head that is not seen often enough, fewer equations than unknowns, start values that put a point
/// behind the head that saw it, a block or a part of it that nothing holds in place.
pub fn check(block: &Block, observations: &Observations, rig: &Rig) -> Result<(), InputError> {
    let refuse = |sentence: String| Err(InputError::new(format!("{}: {sentence}", observations.name)));
    let (mut has_prior, mut is_held) = (vec![false; block.points.len()], vec![false; block.stations.len()]);
    block.point_priors.iter().for_each(|prior| has_prior[prior.point] = true);
    block.station_priors.iter().for_each(|prior| is_held[prior.station] = true);
    let (mut of_point, mut of_station, mut of_head) =
        (vec![0; block.points.len()], vec![0; block.stations.len()], vec![0; block.heads.len()]);
    for seen in &observations.seen {
        of_point[seen.point] += 1;
        of_station[seen.station] += 1;
        of_head[seen.head] += 1;
    }
    let has_free_angle = block.heads.iter().any(|head| head.free.first().is_some_and(|number| *number < 3));
    if of_head[0] == 0 && has_free_angle {
        return refuse("head 0 sees nothing, and the others' angles are against it".to_owned());
    }
    for (head, &count) in of_head.iter().enumerate() {
        if count == 0 && !block.heads[head].free.is_empty() {
            return refuse(format!("head {head} sees nothing"));
        }
    }
    for (station, &count) in of_station.iter().enumerate() {
        if block.stations[station].is_free && count < 3 && !is_held[station] {
            let seen = if count == 1 { "1 observation".to_owned() } else { format!("{count} observations") };
            return refuse(format!("station {station} has {seen}; six unknowns need three at least"));
        }
    }
    for (point, &count) in of_point.iter().enumerate() {
        if block.points[point].is_free && count < 2 && !has_prior[point] {
            let how = if count == 0 { "never".to_owned() } else { format!("once ({})", line_of(observations, point)) };
            return refuse(format!("point {point} is seen {how}; an unknown point needs two rays"));
        }
    }
    let (equations, unknowns) = (rig.structure().equations(), rig.structure().unknowns());
    if equations <= unknowns {
        return refuse(format!(
            "too few observations: {} of them and {} priors give {equations} equations for {unknowns} unknowns, and as many \
             leave nothing to judge by",
            observations.seen.len(),
            equations - 2 * observations.seen.len()
        ));
    }
    for (seen, line) in observations.seen.iter().zip(&observations.lines) {
        let station = &block.stations[seen.station];
        if project(&block.heads[seen.head].values, station, block.points[seen.point].position_m).is_none() {
            return Err(InputError::new(format!(
                "{}, line {line}: by the start values point {} lies behind head {} of station {}",
                observations.name, seen.point, seen.head, seen.station
            )));
        }
    }
    axes::check(block, observations)?;
    check_datum(rig, &observations.name)
}

fn line_of(observations: &Observations, point: usize) -> String {
    let index = observations.seen.iter().position(|seen| seen.point == point);
    index.map_or_else(String::new, |index| format!("line {}", observations.lines[index]))
}

/// Refuses a block, or a part that shares no unknown point with the rest, that could move as a whole.
fn check_datum(rig: &Rig, name: &str) -> Result<(), InputError> {
    let parts = parts(rig);
    for part in &parts {
        let free = defects(rig, part);
        if free.iter().all(|count| *count == 0) {
            continue;
        }
        let missing: Vec<String> = FAMILIES
            .iter()
            .zip(free)
            .filter(|(_, count)| *count > 0)
            .map(
                |((family, all), count)| {
                    if *all == 1 { (*family).to_owned() } else { format!("{family} ({count} of {all})") }
                },
            )
            .collect();
        let which = if parts.len() == 1 {
            "the block".to_owned()
        } else {
            let all = parts.len();
            format!(
                "the block falls apart into {all} parts that share no unknown point, and the one with stations {}",
                listed(part)
            )
        };
        return Err(InputError::new(format!(
            "{name}: {which} is not held in its {}: it needs fixed_points, point_priors, fixed_stations or station_priors",
            missing.join(" and ")
        )));
    }
    Ok(())
}

fn listed(stations: &[usize]) -> String {
    let shown: Vec<String> = stations.iter().take(8).map(usize::to_string).collect();
    let more = if stations.len() > 8 { format!(" and {} more", stations.len() - 8) } else { String::new() };
    shown.join(", ") + &more
}

/// Unknown stations that hang together by unknown points.
fn parts(rig: &Rig) -> Vec<Vec<usize>> {
    let mut leader: Vec<usize> = (0..rig.stations.len() + rig.points.len()).collect();
    fn find(leader: &mut [usize], mut of: usize) -> usize {
        while leader[of] != of {
            leader[of] = leader[leader[of]];
            of = leader[of];
        }
        of
    }
    for seen in &rig.observations {
        if rig.points[seen.point].is_free && rig.stations[seen.station].is_free {
            let (a, b) = (find(&mut leader, seen.station), find(&mut leader, rig.stations.len() + seen.point));
            leader[b.max(a)] = b.min(a);
        }
    }
    let mut parts: Vec<(usize, Vec<usize>)> = Vec::new();
    for station in (0..rig.stations.len()).filter(|station| rig.stations[*station].is_free) {
        let of = find(&mut leader, station);
        match parts.iter_mut().find(|(leader, _)| *leader == of) {
            Some((_, stations)) => stations.push(station),
            None => parts.push((of, vec![station])),
        }
    }
    parts.into_iter().map(|(_, stations)| stations).collect()
}

/// How many directions of each family nothing holds.
fn defects(rig: &Rig, part: &[usize]) -> [usize; 3] {
    let x = rig.start();
    let generators = generators(rig, &x, part);
    let (normal, weight) = normal_along(rig, &x, &generators);
    let scale = |k: usize| if weight[k] > 0.0 { 1.0 / weight[k].sqrt() } else { 0.0 };
    let mut free = [0; 3];
    let (mut taken, mut before) = (0, 0);
    for (family, (_, count)) in FAMILIES.iter().enumerate() {
        taken += count;
        // What moves no unknown is no freedom: a station over known points alone has no scale.
        let moving: Vec<usize> = (0..taken).filter(|k| generators[*k].iter().any(|value| *value != 0.0)).collect();
        let part = DMatrix::from_fn(moving.len(), moving.len(), |i, j| {
            normal[(moving[i], moving[j])] * scale(moving[i]) * scale(moving[j])
        });
        let null = if moving.is_empty() {
            0
        } else {
            part.symmetric_eigenvalues().iter().filter(|value| **value < TOUCHED_MIN).count()
        };
        free[family] = null.saturating_sub(before);
        before = null;
    }
    free
}

/// The normal matrix of the equations along the generators, and for each generator the sum of squares of what its unknowns
/// do to the equations one by one, which a freedom cancels.
fn normal_along(rig: &Rig, x: &[f64], generators: &[Vec<f64>; 7]) -> (DMatrix<f64>, [f64; 7]) {
    let mut normal = DMatrix::<f64>::zeros(7, 7);
    let mut weight = [0.0; 7];
    let mut add = |row: &[(usize, f64)]| {
        let mut along = [0.0; 7];
        for &(unknown, value) in row {
            for k in 0..7 {
                let part = value * generators[k][unknown];
                along[k] += part;
                weight[k] += part * part;
            }
        }
        for i in 0..7 {
            (0..7).for_each(|j| normal[(i, j)] += along[i] * along[j]);
        }
    };
    let at = rig.at(x);
    let mut row = Row::zero();
    for (observation, seen) in rig.observations.iter().enumerate() {
        if !at.linearise(observation, &mut row) {
            continue;
        }
        for e in 0..2 {
            let mut entries: Vec<(usize, f64)> = Vec::new();
            if let Some(first) = rig.station_unknown(seen.station) {
                entries.extend((0..6).map(|k| (first + k, row.station[e][k])));
            }
            if let Some(first) = rig.point_unknown(seen.point) {
                entries.extend((0..3).map(|k| (first + k, row.point[e][k])));
            }
            add(&entries);
        }
    }
    for prior in &rig.structure().priors {
        let first = match prior.place {
            Place::Block(block) => rig.structure().sizes[..block].iter().sum::<usize>(),
            Place::Point(point) => rig.structure().reduced() + 3 * point,
        };
        for row in &prior.rows {
            add(&row.iter().enumerate().map(|(k, value)| (first + k, *value)).collect::<Vec<_>>());
        }
    }
    (normal, weight)
}

/// What a small similarity of a part does to the unknowns: three translations, three rotations about the part's middle and
/// a scale.
fn generators(rig: &Rig, x: &[f64], part: &[usize]) -> [Vec<f64>; 7] {
    let mut generators: [Vec<f64>; 7] = std::array::from_fn(|_| vec![0.0; x.len()]);
    let centres: Vec<Vector3<f64>> =
        part.iter().map(|station| Vector3::from_row_slice(&rig.station(x, *station)[3..])).collect();
    let middle = centres.iter().sum::<Vector3<f64>>() / part.len().max(1) as f64;
    let mut move_position = |first: usize, position: Vector3<f64>| {
        let from_middle = position - middle;
        for k in 0..3 {
            let axis = Vector3::from_fn(|row, _| f64::from(u8::from(row == k)));
            let turned = axis.cross(&from_middle);
            generators[k][first + k] = 1.0;
            (0..3).for_each(|row| generators[3 + k][first + row] = turned[row]);
            generators[6][first + k] = from_middle[k];
        }
    };
    let mut points: Vec<usize> = Vec::new();
    for seen in rig.observations.iter().filter(|seen| part.binary_search(&seen.station).is_ok()) {
        points.push(seen.point);
    }
    points.sort_unstable();
    points.dedup();
    for point in points {
        if let Some(first) = rig.point_unknown(point) {
            move_position(first, Vector3::from(rig.point(x, point)));
        }
    }
    for (station, centre) in part.iter().zip(&centres) {
        if let Some(first) = rig.station_unknown(*station) {
            move_position(first + 3, *centre);
        }
    }
    for &station in part {
        let Some(first) = rig.station_unknown(station) else { continue };
        let values = rig.station(x, station);
        let angles = [values[0], values[1], values[2]];
        for k in 0..3 {
            let axis = Vector3::from_fn(|row, _| f64::from(u8::from(row == k)));
            let turned = |by: f64| {
                let turn = nalgebra::Rotation3::new(axis * by).into_inner();
                rotation::angles_rad(&(turn * rotation::matrix(angles)))
            };
            let (ahead, back) = (turned(TURN_RAD), turned(-TURN_RAD));
            for row in 0..3 {
                let turn = ahead[row] - back[row];
                let turn = turn - std::f64::consts::TAU * (turn / std::f64::consts::TAU).round();
                generators[3 + k][first + row] = turn / (2.0 * TURN_RAD);
            }
        }
    }
    generators
}
