//! The predicted accuracy against made-up measurements of the same block: noise of image, positions and attitudes, exact
//! projection through turned cameras, and a least-squares intersection whose derivatives are differences.

use super::planned::{HALF, plan, scratch};
use super::terrain::Terrain;
use rand_chacha::ChaCha12Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Image noise as a tangent, position in metres, attitude in radians: 2 um of 50 mm, the paper's.
const NOISE: [f64; 3] = [0.002 / 50.0, 0.015, 1e-4];
const POINTS: usize = 1500;
const ROUNDS: usize = 20;

/// Tangents at which a camera at `station`, turned by small angles about its three axes, sees a point.
fn project(station: [f64; 3], turns: [f64; 3], point: [f64; 3]) -> [f64; 2] {
    let mut sight = [0, 1, 2].map(|axis| point[axis] - station[axis]);
    for (axis, angle) in turns.into_iter().enumerate() {
        let (sin, cos) = angle.sin_cos();
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        (sight[i], sight[j]) = (cos * sight[i] + sin * sight[j], cos * sight[j] - sin * sight[i]);
    }
    [sight[0] / -sight[2], sight[1] / -sight[2]]
}

/// Sums of a symmetric 3 x 3 system, solved by elimination.
fn solve(mut a: [[f64; 4]; 3]) -> [f64; 3] {
    for k in 0..3 {
        for row in k + 1..3 {
            let (factor, pivot) = (a[row][k] / a[k][k], a[k]);
            a[row].iter_mut().zip(pivot).for_each(|(value, pivot)| *value -= factor * pivot);
        }
    }
    let mut x = [0.0; 3];
    for k in (0..3).rev() {
        x[k] = (a[k][3] - (k + 1..3).map(|col| a[k][col] * x[col]).sum::<f64>()) / a[k][k];
    }
    x
}

/// Inverse of the covariance of a ray's two tangents, its derivatives taken by differences.
fn weight(station: [f64; 3], point: [f64; 3]) -> [[f64; 2]; 2] {
    let mut covariance = [[NOISE[0] * NOISE[0], 0.0], [0.0, NOISE[0] * NOISE[0]]];
    let at = project(station, [0.0; 3], point);
    let mut add = |moved: [f64; 2], step: f64, sigma: f64| {
        let rate = [0, 1].map(|k| (moved[k] - at[k]) / step * sigma);
        for (row, line) in covariance.iter_mut().enumerate() {
            for (col, value) in line.iter_mut().enumerate() {
                *value += rate[row] * rate[col];
            }
        }
    };
    for axis in 0..3 {
        let mut moved = station;
        moved[axis] += 0.01;
        add(project(moved, [0.0; 3], point), 0.01, NOISE[1]);
        let mut turns = [0.0; 3];
        turns[axis] = 1e-5;
        add(project(station, turns, point), 1e-5, NOISE[2]);
    }
    let [[a, b], [_, d]] = covariance;
    let determinant = a * d - b * b;
    [[d / determinant, -b / determinant], [-b / determinant, a / determinant]]
}

/// A ray: its station, the tangents measured, their weight.
type Measured = ([f64; 3], [f64; 2], [[f64; 2]; 2]);

/// Least squares, from a start some metres off.
fn intersect(rays: &[Measured], start: [f64; 3]) -> [f64; 3] {
    let mut point = start;
    for _ in 0..4 {
        let mut system = [[0.0; 4]; 3];
        for (station, seen, w) in rays {
            let at = project(*station, [0.0; 3], point);
            let rates: [[f64; 2]; 3] = std::array::from_fn(|axis| {
                let mut moved = point;
                moved[axis] += 0.01;
                let there = project(*station, [0.0; 3], moved);
                [0, 1].map(|k| (there[k] - at[k]) / 0.01)
            });
            for row in 0..3 {
                let left = [0, 1].map(|k| rates[row][0] * w[0][k] + rates[row][1] * w[1][k]);
                for col in 0..3 {
                    system[row][col] += left[0] * rates[col][0] + left[1] * rates[col][1];
                }
                system[row][3] += left[0] * (seen[0] - at[0]) + left[1] * (seen[1] - at[1]);
            }
        }
        let step = solve(system);
        point = [0, 1, 2].map(|axis| point[axis] + step[axis]);
    }
    point
}

fn check(name: &str, options: &str) {
    let folder = scratch(name);
    let terrain = Terrain::portable(&folder);
    let [x0, y0, x1, y1] = [500.0, 500.0, 6300.0, 1900.0];
    let plan = plan(&folder, &terrain, &format!("--area {x0},{y0},{x1},{y1} --height-m 555 --speed-m-s 55 {options}"));
    let stations: Vec<[f64; 3]> =
        plan.strips.iter().flat_map(|(_, photos)| photos).map(|[x, y]| [*x, *y, plan.altitude]).collect();
    let mut rng = ChaCha12Rng::seed_from_u64(7);
    let mut uniform = move || (rng.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
    let mut sums = [0.0; 3];
    for _ in 0..POINTS {
        let (x, y) = (x0 + (x1 - x0) * uniform(), y0 + (y1 - y0) * uniform());
        let point = [x, y, terrain.height(x, y).expect("inside")];
        // Along is x here, and nothing on these waves hides anything from 555 m.
        let sees = |station: &&[f64; 3]| {
            let [a, b] = project(**station, [0.0; 3], point);
            a.abs() <= HALF[0] && b.abs() <= HALF[1]
        };
        let seen_from: Vec<[f64; 3]> = stations.iter().filter(sees).copied().collect();
        assert!(seen_from.len() >= 2);
        for _ in 0..ROUNDS {
            let mut normal = || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (std::f64::consts::TAU * uniform()).cos();
            let rays: Vec<_> = seen_from
                .iter()
                .map(|station| {
                    let real = station.map(|value| value + NOISE[1] * normal());
                    let turns = [0; 3].map(|_| NOISE[2] * normal());
                    let seen = project(real, turns, point).map(|tangent| tangent + NOISE[0] * normal());
                    (*station, seen, weight(*station, point))
                })
                .collect();
            let found = intersect(&rays, [x + 3.0, y - 2.0, point[2] + 5.0]);
            let off = [0, 1, 2].map(|axis| found[axis] - point[axis]);
            sums = [sums[0] + 1.0, sums[1] + off[0] * off[0] + off[1] * off[1], sums[2] + off[2] * off[2]];
        }
    }
    let accuracy = &plan.json["accuracy"];
    for (k, key) in [(1, "plan_m"), (2, "height_m")] {
        let predicted = accuracy[key].as_f64().expect("a number");
        let ratio = predicted / (sums[k] / sums[0]).sqrt();
        println!("{name}: {key} {predicted:.4}, over made-up {ratio:.4}");
        assert!((0.95..1.05).contains(&ratio), "{key} {predicted}: {ratio}");
    }
}

#[test]
fn predicted_accuracy_is_what_made_up_measurements_come_to() {
    check("measured-60", "--overlap 60/30");
    check("measured-80", "--overlap 80/60");
}
