//! The golden block, finite differences, and what the solver owes whatever the model.

use super::bal::Bal;
use super::rig::{HEAD, Head, LENS, Observation, Point, Station, TIME, project};
use super::*;

/// A small block with everything that can be unknown: three stations, two heads, terrain.
fn small(free: &[usize]) -> Rig {
    let rates = [0.02, -0.03, 0.05, 40.0, 30.0, -1.0];
    let station = |k: f64| Station {
        values: [0.02 * k, -0.03, 1.5 + 0.3 * k, 150.0 * k, 20.0 * k, 700.0 - 5.0 * k],
        rates,
        is_free: true,
    };
    let stations: Vec<Station> = (0..3).map(|k| station(f64::from(k))).collect();
    let lens = Interior([6900.0, 3.0, -4.0, -0.02, 0.01, -0.003, 4e-4, -3e-4]);
    let mut heads = vec![
        Head::new([-0.38, 0.31, 0.01], [-0.045, 0.06, 0.01], lens, true),
        Head::new([0.38, 0.3, -0.02], [0.045, 0.06, -0.01], lens, false),
    ];
    heads[1].values[TIME] = 1e-3;
    heads[1].free = free.to_vec();
    let mut points = Vec::new();
    for k in 0..60 {
        let (east, north) = (f64::from(k % 10) * 150.0 - 500.0, f64::from(k / 10) * 200.0 - 500.0);
        let up = 50.0 * (0.01 * east).sin();
        points.push(Point { position_m: [east, north, up], is_free: k % 7 != 0 });
    }
    let mut observations = Vec::new();
    for (station, at) in stations.iter().enumerate() {
        for (head, of) in heads.iter().enumerate() {
            for (point, on) in points.iter().enumerate() {
                let Some(image_px) = project(&of.values, at, on.position_m) else { continue };
                if image_px.iter().all(|v| v.abs() < 3600.0) {
                    observations.push(Observation { station, head, point, image_px });
                }
            }
        }
    }
    // Only what two stations see.
    let seen_by = |point: usize| {
        let mut stations: Vec<usize> =
            observations.iter().filter(|seen| seen.point == point).map(|seen: &Observation| seen.station).collect();
        stations.dedup();
        stations.len()
    };
    let kept: Vec<usize> = (0..points.len()).filter(|point| seen_by(*point) > 1).collect();
    let observations = observations
        .iter()
        .filter_map(|seen| Some(Observation { point: kept.binary_search(&seen.point).ok()?, ..*seen }))
        .collect();
    let points = kept.iter().map(|point| points[*point]).collect();
    Rig::new(stations, heads, points, observations, vec![0.5, 0.5])
}

/// Derivatives of every observation by every unknown, by a step for each that moves the image by some tenths of a pixel.
fn check_derivatives<M: Model>(model: &M, x: &[f64], step_of: &dyn Fn(usize) -> f64) {
    let structure = model.structure();
    let mut start = vec![0];
    structure.sizes.iter().for_each(|size| start.push(start[start.len() - 1] + size));
    let at = model.at(x);
    let mut row = Row::zero();
    let mut compared = 0;
    for (observation, link) in structure.links.iter().enumerate().step_by(7) {
        assert!(at.linearise(observation, &mut row));
        let of_block =
            |block: Option<u32>| block.map_or(0..0, |block| start[block as usize]..start[block as usize + 1]);
        let of_point = link.point.map_or(0..0, |point| {
            let from = structure.reduced() + 3 * point as usize;
            from..from + 3
        });
        for (unknowns, part) in [
            (of_block(link.station), row.station.each_ref().map(|row| &row[..])),
            (of_block(link.head), row.head.each_ref().map(|row| &row[..])),
            (of_point, row.point.each_ref().map(|row| &row[..])),
        ] {
            for (k, unknown) in unknowns.enumerate() {
                let step = step_of(unknown);
                let moved = |by: f64| {
                    let mut x = x.to_vec();
                    x[unknown] += by;
                    model.at(&x).residual(observation).expect("in front")
                };
                let (up, down) = (moved(step), moved(-step));
                for e in 0..2 {
                    let difference = (up[e] - down[e]) / (2.0 * step);
                    let scale = difference.abs().max(1e-3 / step);
                    assert!(
                        (part[e][k] - difference).abs() < 1e-4 * scale,
                        "{observation} {unknown}: {} {difference}",
                        part[e][k]
                    );
                    compared += 1;
                }
            }
        }
    }
    assert!(compared > 500, "{compared}");
}

#[test]
fn a_rigs_derivatives_are_the_differences() {
    let free: Vec<usize> = (0..HEAD).collect();
    let rig = small(&free);
    let steps = |unknown: usize| {
        let name = rig.name(unknown);
        match name.split(' ').next().unwrap_or_default() {
            "phi" | "omega" | "kappa" => 1e-5,
            "k1" | "k2" | "k3" | "p1" | "p2" => 1e-4,
            "dt" => 1e-3,
            _ => 1e-2,
        }
    };
    check_derivatives(&rig, &rig.start(), &steps);
}

#[test]
fn a_rig_without_noise_closes() {
    let rig = small(&[0, 1, 2]);
    let truth = rig.start();
    // Angles off by some arc minutes, positions by metres.
    let moved: Vec<f64> = truth
        .iter()
        .enumerate()
        .map(|(k, x)| x + if x.abs() < 4.0 { 1e-3 } else { 2.0 } * ((k * 7 % 5) as f64 - 2.0))
        .collect();
    let adjustment = Adjustment::new(&rig, Loss::Squares).expect("laid out");
    let solution = adjustment.solve(moved, &Options::default(), &mut |_, _| {}).expect("solved");
    let head = rig.head(&solution.x, 1);
    for (ours, truth) in head.iter().zip(rig.heads[1].values).take(3) {
        let arcsec = (ours - truth).to_degrees() * 3600.0;
        assert!(arcsec.abs() < 1e-7, "{arcsec}");
    }
    assert!(solution.cost_end < 1e-15 && solution.iterations < 10, "{solution:?}");
}

/// The rows of the whole design matrix, the observations' (two each) and the priors'.
fn design(rig: &Rig, x: &[f64]) -> [Vec<nalgebra::DVector<f64>>; 2] {
    let structure = rig.structure();
    let mut start = vec![0];
    structure.sizes.iter().for_each(|size| start.push(start[start.len() - 1] + size));
    let of_point = |point: usize| structure.reduced() + 3 * point;
    let zero = || nalgebra::DVector::<f64>::zeros(structure.unknowns());
    let at = rig.at(x);
    let mut row = Row::zero();
    let mut observations = Vec::new();
    for (observation, link) in structure.links.iter().enumerate() {
        assert!(at.linearise(observation, &mut row));
        for e in 0..2 {
            let mut a = zero();
            if let Some(block) = link.station {
                (0..6).for_each(|k| a[start[block as usize] + k] = row.station[e][k]);
            }
            if let Some(block) = link.head {
                (0..4).for_each(|k| a[start[block as usize] + k] = row.head[e][k]);
            }
            if let Some(point) = link.point {
                (0..3).for_each(|k| a[of_point(point as usize) + k] = row.point[e][k]);
            }
            observations.push(a);
        }
    }
    let mut priors = Vec::new();
    for prior in &structure.priors {
        let at = match prior.place {
            Place::Block(block) => start[block],
            Place::Point(point) => of_point(point),
        };
        for row in &prior.rows {
            let mut a = zero();
            row.iter().enumerate().for_each(|(k, value)| a[at + k] = *value);
            priors.push(a);
        }
    }
    [observations, priors]
}

/// Q of the reduced system and the redundancies against the dense inverse of the whole normal matrix.
#[test]
fn cofactors_are_those_of_the_whole_normal_matrix() {
    let mut rig = small(&[0, 1, 2, LENS]);
    rig.expect_head(1, &[(LENS, 6900.0, 0.5), (3, 0.0, 1.0)]);
    let mut rows = vec![vec![0.0; 6]; 2];
    (rows[0][3], rows[1][2], rows[1][4]) = (10.0, 3e3, 1.0);
    rig.expect_station(0, rig.stations[0].values, rows);
    rig.expect_point(1, rig.points[1].position_m, vec![vec![0.0, 0.5, 2.0]]);
    let x = rig.start();
    let (reduced, unknowns) = (rig.structure().reduced(), rig.structure().unknowns());
    let [observations, priors] = design(&rig, &x);
    let mut normal = nalgebra::DMatrix::<f64>::zeros(unknowns, unknowns);
    observations.iter().chain(&priors).for_each(|a| normal += a * a.transpose());
    let inverse = normal.cholesky().expect("determined").inverse();
    let adjustment = Adjustment::new(&rig, Loss::Squares).expect("laid out");
    let cofactors = adjustment.cofactors(&x).expect("determined");
    let check = |value: f64, (i, j): (usize, usize)| {
        let scale = (inverse[(i, i)] * inverse[(j, j)]).sqrt();
        assert!((value - inverse[(i, j)]).abs() < 1e-7 * scale, "{i} {j}: {value} {}", inverse[(i, j)]);
    };
    for (i, row) in cofactors.of(&(0..reduced).collect::<Vec<_>>()).iter().enumerate() {
        row.iter().enumerate().for_each(|(j, value)| check(*value, (i, j)));
    }
    let (redundancies, points) = cofactors.redundancies().expect("determined");
    for (k, a) in observations.iter().enumerate() {
        let (found, expected) = (redundancies[k / 2][k % 2], 1.0 - (a.transpose() * &inverse * a)[0]);
        assert!((found - expected).abs() < 1e-7, "{k}: {found} {expected}");
    }
    for (point, own) in points.iter().enumerate() {
        let at = reduced + 3 * point;
        (0..9).for_each(|k| check(own[k / 3][k % 3], (at + k / 3, at + k % 3)));
    }
    // The redundancies of all equations, priors' with them, are equations less unknowns: here the priors' are left over.
    let sum: f64 = redundancies.iter().flatten().sum();
    let total = (rig.structure().equations() - unknowns) as f64;
    assert!(total - sum > 0.0 && total - sum < rig.structure().priors.len() as f64 + 2.0, "{sum} {total}");
}

#[test]
fn what_nothing_determines_is_named() {
    // Two heads' common focal length and height over a block without terrain would be weak; a head that sees nothing of
    // its own time is singular: without rates the time offset moves nothing.
    let rig = small(&[0, 1, 2, TIME]);
    let stations = rig.stations.iter().map(|station| Station { rates: [0.0; 6], ..*station }).collect();
    let rig = Rig::new(stations, rig.heads.clone(), rig.points.clone(), rig.observations.clone(), vec![0.5; 2]);
    let adjustment = Adjustment::new(&rig, Loss::Squares).expect("laid out");
    let error = adjustment.solve(rig.start(), &Options::default(), &mut |_, _| {}).err();
    let error = error.or_else(|| adjustment.cofactors(&rig.start()).err());
    let Some(SolveError::Singular { along }) = error else { panic!("{error:?}") };
    assert_eq!(rig.name(along[0].0), "dt of head 1");
}

#[test]
fn hubers_loss_bends_where_it_should() {
    let loss = Loss::Huber(2.0);
    assert_eq!(loss.of([1.0, 0.0]), 0.5);
    assert_eq!(loss.of([2.0, 0.0]), 2.0);
    assert_eq!(loss.of([0.0, 5.0]), 2.0 * (5.0 - 1.0));
    assert_eq!(loss.weight(4.0), 0.5);
    assert_eq!(loss.weight(1.0), 1.0);
}

fn bal_text() -> String {
    let mut text = String::from("2 9 18\n");
    for camera in 0..2 {
        for point in 0..9 {
            let (x, y) = (f64::from(point % 3) * 100.0 - 90.0, f64::from(point / 3) * 80.0 - 85.0);
            text.push_str(&format!("{camera} {point} {} {}\n", x + 30.0 * f64::from(camera), y));
        }
    }
    for camera in 0..2 {
        text.push_str(&format!(
            "0.01 -0.02 {} {} 0.1 -0.2 500 -0.01 0.002\n",
            0.03 * f64::from(camera),
            -0.6 * f64::from(camera)
        ));
    }
    for point in 0..9 {
        let (x, y) = (f64::from(point % 3) * 2.0 - 2.0, f64::from(point / 3) * 1.7 - 1.7);
        text.push_str(&format!("{x} {y} {}\n", -10.0 - 0.3 * f64::from(point % 4)));
    }
    text
}

#[test]
fn derivatives_of_the_large_problems_are_the_differences() {
    // Many observations of few points: the check takes every seventh.
    let mut text = bal_text();
    let seen: Vec<String> = text.lines().skip(1).take(18).map(str::to_owned).collect();
    let repeated = seen.join("\n") + "\n";
    text = text.replacen("2 9 18\n", &format!("2 9 {}\n{}", 18 * 21, repeated.repeat(20)), 1);
    let bal = Bal::parse(&text, "text").expect("a problem");
    check_derivatives(&bal, &bal.start(), &|unknown| match unknown {
        0..18 if unknown % 9 < 3 => 1e-5,
        0..18 if unknown % 9 == 6 => 1e-1,
        0..18 if unknown % 9 > 6 => 1e-3,
        _ => 1e-4,
    });
}

#[test]
fn a_large_problem_that_is_none_is_refused() {
    let text = bal_text();
    let refused = |text: &str| Bal::parse(text, "p.txt").expect_err("refused").to_string();
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    for cut in [0, 1, 2, 3, 4, 30, 80, words.len() - 1] {
        let sentence = refused(&words[..cut].join(" "));
        assert!(sentence.contains("cut short"), "{cut}: {sentence}");
    }
    assert!(refused(&(text.clone() + " 1.0")).contains("after the last point"));
    assert!(refused(&text.replacen("0 0 ", "0 9 ", 1)).contains("names point 9"));
    assert!(refused(&text.replacen("0 0 ", "2 0 ", 1)).contains("names camera 2"));
    assert!(refused(&text.replacen("0 0 -90", "0 0 NaN", 1)).contains("no finite number"));
    assert!(refused(&text.replacen("1 0 ", "1 1 ", 1)).contains("point 0 is seen once"));
}
