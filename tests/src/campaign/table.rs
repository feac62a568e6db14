//! What is printed of a campaign, and its frames as CSV.

use super::flight::Flown;
use super::pooled::{AGAIN_S, Fixes, Places, TAILS};
use std::fmt::Write;

/// Reasons that are told of a case, the most frequent ones.
const REASONS: usize = 3;

/// A case's name and its flights.
pub type Named<'a> = (String, Vec<&'a Flown>);

/// Fixes of each case and of all of several; each flight with a wrong fix; what the boards' places are worth.
#[must_use]
pub fn text(cases: &[Named<'_>]) -> String {
    let all = (cases.len() > 1)
        .then(|| ("all".to_owned(), cases.iter().flat_map(|(_, flights)| flights.iter().copied()).collect()));
    let rows: Vec<Named<'_>> = cases.iter().cloned().chain(all).collect();
    let mut text = all_fixes(&rows);
    for (name, flights) in cases {
        text.extend(flights.iter().filter_map(|flown| doubtful(name, flown)));
    }
    text + &all_places(&rows)
}

/// A row of fixes for each.
fn all_fixes(rows: &[Named<'_>]) -> String {
    let [far, farther] = TAILS.map(|tail| format!("> {tail}"));
    let again = format!("again in {AGAIN_S} s");
    let head = [
        &["case", "flights", "frames", "fixes", "%", "wrong", "beyond level", "largest px", "RMS px", "sigma px"][..],
        &["NEES", &far, &farther, &again, "longest s", "most without a fix"],
    ];
    aligned(head.concat(), rows.iter().map(|(name, flights)| fixes(name, flights)))
}

/// A flight with fixes that are wrong or beyond the protection level.
fn doubtful(name: &str, flown: &Flown) -> Option<String> {
    let of = Fixes::of(&[flown]);
    let counts = format!("{} of {} fixes wrong, {} beyond the level", of.wrong, of.fixes, of.beyond);
    let flight = format!("{name} seed {}{}: {counts}, {:.2} px at most\n", flown.seed, pair(flown), of.largest_px);
    (of.wrong + of.beyond > 0).then_some(flight)
}

/// A row of places for each that states any, behind an empty line.
fn all_places(rows: &[Named<'_>]) -> String {
    let places: Vec<Vec<String>> = rows.iter().filter_map(|(name, flights)| places(name, flights)).collect();
    if places.is_empty() {
        return String::new();
    }
    let head = ["place of the filter", "RMS m", "NEES", "radius of 95 % m", "% in 95", "in 99", "in 99.9"];
    "\n".to_owned() + &aligned([&head[..], &["in the protection level"]].concat(), places.into_iter())
}

/// Its ground and reference behind its seed.
fn pair(flown: &Flown) -> String {
    if flown.pair.is_empty() { String::new() } else { format!(", {}", flown.pair) }
}

/// The row of a case's fixes.
fn fixes(name: &str, flights: &[&Flown]) -> Vec<String> {
    let of = Fixes::of(flights);
    let number =
        |value: f64, digits: usize| if value.is_finite() { format!("{value:.digits$}") } else { "-".to_owned() };
    let [ends, again] = of.again;
    let (again, longest) = match of.again_s {
        _ if ends == 0 => ("-".to_owned(), "-".to_owned()),
        seconds => {
            (format!("{again} of {ends}"), if seconds.is_finite() { format!("{seconds:.2}") } else { "never".into() })
        }
    };
    let counts = [of.flights, of.frames, of.fixes].map(|count| count.to_string());
    let share = number(100.0 * of.fixes as f64 / of.frames as f64, 1);
    let errors = [number(of.largest_px, 2), number(of.rms_px, 3), number(of.sigma_px, 3), number(of.nees, 2)];
    let tails = of.tails.map(|count| count.to_string());
    let refused =
        of.refused.iter().take(REASONS).map(|(reason, count)| format!("{reason} {count}")).collect::<Vec<_>>();
    [name.to_owned()]
        .into_iter()
        .chain(counts)
        .chain([share, of.wrong.to_string(), of.beyond.to_string()])
        .chain(errors)
        .chain(tails)
        .chain([again, longest, refused.join(", ")])
        .collect()
}

/// The row of a case's places; nothing where the boards state none.
fn places(name: &str, flights: &[&Flown]) -> Option<Vec<String>> {
    let of = Places::of(flights)?;
    let held = of.held.map(|shares| shares.map(|share| format!("{:.2}", 100.0 * share)));
    let held = held.map(|[share, low, high]| format!("{share} [{low} {high}]"));
    let errors = [format!("{:.3}", of.rms_m), format!("{:.3}", of.nees), format!("{:.2}", of.median_m)];
    Some([name.to_owned()].into_iter().chain(errors).chain(held).collect())
}

/// Rows under a head, the first column to the left, the last as it comes and the others to the right.
fn aligned(head: Vec<&str>, rows: impl Iterator<Item = Vec<String>>) -> String {
    let rows: Vec<Vec<String>> = [head.into_iter().map(str::to_owned).collect()].into_iter().chain(rows).collect();
    let wide = |column: usize| rows.iter().map(|row| row[column].len()).max().unwrap_or_default();
    let columns = rows[0].len();
    let mut text = String::new();
    for row in &rows {
        let cells = row.iter().enumerate().map(|(column, cell)| match column {
            0 => format!("{cell:wide$}", wide = wide(0)),
            _ if column + 1 == columns => cell.clone(),
            _ => format!("{cell:>wide$}", wide = wide(column)),
        });
        text += cells.collect::<Vec<_>>().join("  ").trim_end();
        text.push('\n');
    }
    text
}

/// A row a frame.
#[must_use]
pub fn csv(cases: &[Named<'_>]) -> String {
    let mut csv = "case,seed,pair,frame,time_s,fixed,off_px,sigma_px,nees,wrong,reason\n".to_owned();
    for (name, flights) in cases {
        for flown in flights {
            for (number, frame) in flown.frames.iter().enumerate() {
                let _ = write!(csv, "\"{name}\",{},\"{}\",{number},{:.6},", flown.seed, flown.pair, frame.at_s);
                let _ = match frame.fix {
                    Some(fix) => writeln!(
                        csv,
                        "1,{:.4},{:.4},{:.4},{},",
                        fix.off_px,
                        fix.sigma_px,
                        fix.nees,
                        u8::from(fix.is_wrong)
                    ),
                    None => writeln!(csv, "0,,,,,{}", frame.reason.unwrap_or_default()),
                };
            }
        }
    }
    csv
}

#[cfg(test)]
mod tests {
    use super::super::flight::{Fix, Frame};
    use super::*;

    #[test]
    fn rows_and_flights_with_wrong_fixes() {
        let fix = Fix { off_px: 4.0, sigma_px: 0.5, nees: 64.0, is_wrong: true, is_beyond: false };
        let frame = |fix, reason| Frame { at_s: 3.0, fix, reason, place: None };
        let wrong =
            Flown { seed: 8, pair: "a over b".into(), frames: vec![frame(Some(fix), None)], recovery_s: vec![None] };
        let none = Flown {
            seed: 9,
            pair: String::new(),
            frames: vec![frame(None, Some("low_score"))],
            recovery_s: Vec::new(),
        };
        let cases = [("naip".to_owned(), vec![&wrong]), ("default".to_owned(), vec![&none])];
        let text = text(&cases);
        let lines: Vec<&str> = text.lines().collect();
        let words = |line: usize| lines[line].split_whitespace().collect::<Vec<_>>();
        let row = "naip 1 1 1 100.0 1 0 4.00 4.000 0.500 64.00 1 1 0 of 1 never";
        assert_eq!(words(1).join(" "), row);
        assert_eq!(words(2).join(" "), "default 1 1 0 0.0 0 0 0.00 - - - 0 0 - - low_score 1");
        assert_eq!(words(3)[..5], ["all", "2", "2", "1", "50.0"]);
        // Numbers stand under the end of their words.
        assert_eq!(lines[0].find("flights").map(|at| &lines[1][at + 6..at + 7]), Some("1"));
        assert_eq!(lines[4..], ["naip seed 8, a over b: 1 of 1 fixes wrong, 0 beyond the level, 4.00 px at most"]);
        assert_eq!(
            csv(&cases).lines().skip(1).collect::<Vec<_>>(),
            [
                "\"naip\",8,\"a over b\",0,3.000000,1,4.0000,0.5000,64.0000,1,",
                "\"default\",9,\"\",0,3.000000,0,,,,,low_score"
            ]
        );
    }
}
