use super::{Fault, KINDS, What};
use crate::scenario::Scenario;
use std::path::Path;

fn fault(text: &str) -> Fault {
    text.parse().unwrap_or_else(|why| panic!("{text}: {why}"))
}

fn scenario(text: &str) -> Result<Scenario, String> {
    Scenario::parse(text, "a.toml", Path::new(""), None).map_err(|error| error.to_string())
}

#[test]
fn a_word_says_what_a_table_says() {
    let table = "[[fault]]\nunit = \"range\"\ntype = \"scale\"\nvalue = 1.1\nfrom_s = 30\nto_s = 60\n";
    let read = scenario(table).expect("sound");
    assert_eq!(read.faults.timed.all(), [fault("range.scale=1.1@30..60")]);
    let expected = Fault { what: What::RangeScale, value: 1.1, from_s: 30.0, to_s: Some(60.0) };
    assert_eq!(fault("range.scale=1.1@30..60"), expected);
    assert_eq!(fault("range.off"), Fault { what: What::RangeOff, value: 0.0, from_s: 0.0, to_s: None });
    assert_eq!(fault("range.off@2.5.."), Fault { what: What::RangeOff, value: 0.0, from_s: 2.5, to_s: None });
    let whole = scenario("fault = [{ unit = \"range\", type = \"off\" }]").expect("sound");
    assert_eq!(whole.faults.timed.all(), [fault("range.off")]);
}

#[test]
fn every_kind_reads_what_it_writes() {
    for kind in KINDS {
        assert_eq!(kind.what.kind(), Some(kind), "two rows for one fault");
        let value = kind.value.map(|value| format!("={}", value.high)).unwrap_or_default();
        let word = format!("{}.{}{value}@1..2.5", kind.unit, kind.name);
        assert_eq!(fault(&word).to_string(), word);
    }
}

#[test]
fn the_end_is_excluded() {
    let fault = fault("range.off@1..2");
    let at = [999_999, 1_000_000, 1_999_999, 2_000_000].map(|at_us| fault.is_at(at_us));
    assert_eq!(at, [false, true, true, false]);
}

#[test]
fn what_is_wrong_is_named_in_one_sentence() {
    for (word, names) in [
        ("rnge.scale=1", ["\"rnge\"", "position, gnss, range, attitude"].as_slice()),
        ("range.slow=1", &["range", "\"slow\"", "off, stuck, bias [m], scale [times], steps [m]"]),
        ("range.scale", &["range.scale", "times", "0", "100"]),
        ("range.scale=101", &["range.scale = 101", "0 and 100"]),
        ("range.scale=nan", &["\"nan\"", "UNIT.TYPE[=VALUE][@FROM..[TO]]"]),
        ("range.scale=much", &["\"much\""]),
        ("range.off=1", &["range.off = 1", "no value"]),
        ("range", &["UNIT.TYPE"]),
        ("range.off@3", &["@3", "@FROM..TO"]),
        ("range.off@3..3", &["range.off@3..3", "end after"]),
        ("range.off@-1..3", &["range.off@-1..3", "not between 0"]),
        ("range.off@soon..3", &["\"soon\""]),
    ] {
        let why = word.parse::<Fault>().expect_err(word);
        assert!(!why.contains('\n'), "{why}");
        names.iter().for_each(|name| assert!(why.contains(name), "{word}: {why:?} without {name:?}"));
    }
    for (table, names) in [
        ("[[fault]]\nunit = \"range\"", ["missing field `type`"].as_slice()),
        ("\n[[fault]]\nunit = \"range\"\ntype = \"loud\"", &["a.toml, line", "\"loud\"", "stuck"]),
        ("[[fault]]\nunit = \"range\"\ntype = \"off\"\nsince_s = 3", &["line 4", "since_s"]),
        ("[[fault]]\nunit = \"gnss\"\ntype = \"off\"", &["gnss.off@0..", "needs [navigation]"]),
        ("[[fault]]\nunit = \"encoder\"\ntype = \"off\"", &["encoder.off@0..", "follow_up.mode"]),
    ] {
        let why = scenario(table).expect_err(table);
        assert!(!why.contains('\n'), "{why}");
        names.iter().for_each(|name| assert!(why.contains(name), "{table}: {why:?} without {name:?}"));
    }
}
