//! Against the reference's table of interpolants.

use super::*;

/// Where the reference's noise is another: its standard deviation over 8 seeds of 301 samples is 0.144 / √(2 2400) of
/// itself, 1.4 %; two of these apart, and curves of few parameters scatter more. The limit is the 3 % that were asked for.
const MARGIN: f64 = 0.03;

fn golden(table: &str) -> serde_json::Value {
    let text = include_str!("../../../tests/vectors/golden_001.json");
    let mut all: serde_json::Value = serde_json::from_str(text).unwrap();
    all[table].take()
}

#[test]
fn the_table_of_interpolants() {
    let table = golden("S_interpolants");
    assert_eq!(table.as_array().unwrap().len(), PERIODS_S.len());
    for (row, period_s) in table.as_array().unwrap().iter().zip(PERIODS_S) {
        let of = |key: &str| row[key].as_f64().unwrap();
        assert_eq!(of("T"), period_s);
        let ours = mean_of(|seed| position(period_s, seed)).unwrap();
        for (name, ours) in [("d2", ours.d2.rms), ("d3", ours.d3.rms)] {
            assert!(ours < (1.0 + MARGIN) * of(name), "{name} at {period_s} s: {ours} for {}", of(name));
        }
        for (name, ours) in [
            ("linear", ours.linear),
            ("quadratic", ours.quadratic),
            ("spline", ours.spline),
            ("sigma0", ours.d2.sigma0),
            ("without_freedom", ours.d2.plain_m),
        ] {
            assert!((ours / of(name) - 1.0).abs() < MARGIN, "{name} at {period_s} s: {ours} for {}", of(name));
        }
    }
}

#[test]
fn attitudes() {
    let row = golden("S_attitude");
    let ours = mean_of(attitude).unwrap();
    let of = |name: &str| 1e-3 * row[name].as_f64().unwrap();
    for (name, ours) in [("linear", ours.linear), ("quadratic", ours.quadratic), ("spline", ours.spline)] {
        assert!((ours / of(name) - 1.0).abs() < MARGIN, "{name}: {ours} for {}", of(name));
    }
    // The reference names neither phases nor length.
    for (name, ours) in [("d2", ours.d2.rms), ("d3", ours.d3.rms)] {
        assert!(ours < (1.0 + MARGIN) * of(name) && ours > 0.9 * of(name), "{name}: {ours} for {}", of(name));
    }
}

#[test]
fn rows_say_what_does_not_reproduce() {
    let reproduction = reproduction().unwrap();
    let with = |word: &str| reproduction.rows.iter().find(|row| row.quantity.contains(word)).unwrap();
    let sigma = with("sqrt(V'V / (n - tr H)), T");
    assert!(sigma.difference.as_ref().unwrap().contains("degrees of freedom") && sigma.ours.unwrap() > 0.14);
    let plain = with("alpha = 1.82");
    assert!(plain.difference.is_none() && (plain.ours.unwrap() - 0.11).abs() < 0.005, "{plain:?}");
    assert!((with("lever arm").ours.unwrap() - 1.240_967).abs() < 1e-6);
    // Every figure of the paper is met or has its reason.
    for row in &reproduction.rows {
        let met = row.paper.zip(row.ours).is_none_or(|(paper, ours)| (paper - ours).abs() < 0.005);
        assert!(met || row.difference.is_some(), "{row:?}");
    }
}

#[test]
fn four_figures() {
    let pictures = figures::pictures().unwrap();
    assert_eq!(
        pictures.iter().map(|picture| picture.0).collect::<Vec<_>>(),
        ["figure_1", "figure_2", "figure_3", "figure_4"]
    );
    assert!(pictures.iter().all(|(_, text)| text.contains("Figure ") && text.ends_with("</svg>\n")));
}
