//! The known mistakes: each must miss a golden value.

use super::{MISS, TOLERANCE, attitude_of, attitude_with_follow_up, camera_of, radians};
use plumbline_sim::oracle::{frame_from_ground, matrix_a};
use plumbline_tests::mutants;
use plumbline_tests::vectors::{list, miss, number, rows};

/// The mutants are what they claim: they give the paper's literal figures.
#[test]
fn printed_formulas_give_the_printed_columns() {
    for row in rows("003", "B_eq3") {
        let (heading, pitch, roll, follow_up) = attitude_with_follow_up(&row);
        let (a, camera) = (matrix_a(heading, pitch, roll, follow_up), camera_of(&row));
        let at = (number(&row, "m"), number(&row, "n"));
        let (m, n) = mutants::eq3_printed(&a, camera.tangent_per_px(), at, (number(&row, "m0"), number(&row, "n0")));
        assert!(miss([m, n], list(&row, "printed")) < TOLERANCE, "{m}, {n} for {row}");
    }
    for row in rows("003", "C_eq7") {
        let (pitch, roll, k) = (radians(&row, "theta1"), radians(&row, "gamma1"), camera_of(&row).tangent_per_px().0);
        let at = (number(&row, "m"), number(&row, "n"));
        let (m, n) = mutants::eq7_printed(pitch, roll, k, at, (number(&row, "m0"), number(&row, "n0")));
        assert!(miss([m, n], list(&row, "printed")) < TOLERANCE, "{m}, {n} for {row}");
    }
}

fn assert_misses(name: &str, worst: f64) {
    println!("{name}: misses by up to {worst:.4}");
    assert!(worst > MISS, "{name} passes the golden values");
}

#[test]
fn every_mutant_misses_a_golden_value() {
    let table_b = rows("003", "B_eq3");
    for (name, matrix) in mutants::MATRICES {
        let worst = table_b.iter().map(|row| {
            let (heading, pitch, roll, follow_up) = attitude_with_follow_up(row);
            let a = matrix(heading, pitch, roll, follow_up);
            let p = frame_from_ground(&a, &camera_of(row), number(row, "m"), number(row, "n"));
            miss([p.m, p.n], list(row, "out"))
        });
        assert_misses(name, worst.fold(0.0, f64::max));
    }
    let worst = table_b.iter().map(|row| {
        let (heading, pitch, roll, follow_up) = attitude_with_follow_up(row);
        let (at, offset) = ((number(row, "m"), number(row, "n")), (number(row, "m0"), number(row, "n0")));
        let a = matrix_a(heading, pitch, roll, follow_up);
        let (m, n) = mutants::eq3_printed(&a, camera_of(row).tangent_per_px(), at, offset);
        miss([m, n], list(row, "out"))
    });
    assert_misses("eq. 3 as printed", worst.fold(0.0, f64::max));

    let table_c = rows("003", "C_eq7");
    for (name, map) in mutants::EQ7 {
        let worst = table_c.iter().map(|row| {
            let (at, offset) = ((number(row, "m"), number(row, "n")), (number(row, "m0"), number(row, "n0")));
            let k = camera_of(row).tangent_per_px().0;
            let (m, n) = map(radians(row, "theta1"), radians(row, "gamma1"), k, at, offset);
            miss([m, n], list(row, "out"))
        });
        assert_misses(name, worst.fold(0.0, f64::max));
    }

    let table_a = rows("003", "A_followup");
    for (name, follow) in mutants::FOLLOW_UPS {
        let worst = table_a.iter().map(|row| {
            let (heading, pitch, roll) = attitude_of(row);
            let [follow_up, equivalent_pitch, equivalent_roll] = follow(heading, pitch, roll).map(f64::to_degrees);
            let golden: [f64; 3] = list(row, "out");
            let turn = (follow_up - golden[0] + 180.0).rem_euclid(360.0) - 180.0;
            miss([turn, equivalent_pitch, equivalent_roll], [0.0, golden[1], golden[2]])
        });
        assert_misses(name, worst.fold(0.0, f64::max));
    }

    for (name, stamp) in mutants::STAMPS {
        let worst = rows("000", "I_mid_u32").into_iter().map(|row| {
            let [start, stop, mid] = ["start", "stop", "mid"].map(|key| number(&row, key));
            (f64::from(stamp(start as u32, stop as u32)) - mid).abs()
        });
        assert_misses(name, worst.fold(0.0, f64::max));
    }
    let worst = rows("000", "I_att").into_iter().map(|row| {
        let [a0, a1] = ["a0", "a1"].map(|key| list(&row, key));
        miss(mutants::attitude_long_way(a0, a1, number(&row, "u")), list(&row, "linear"))
    });
    assert_misses("heading the long way round", worst.fold(0.0, f64::max));
}
