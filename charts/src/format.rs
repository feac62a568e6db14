//! Numbers for people: fixed digits, a narrow space before the unit, a dash for what is not there.

/// What stands where no number is.
pub const NONE: &str = "–";
/// What stands where the link cannot measure.
pub const NOT_MEASURED: &str = "not measured on this link";
/// Narrow and unbreakable.
const SPACE: char = '\u{202f}';

/// A number of `digits` decimals and its unit.
pub fn number(value: f64, digits: usize, unit: &str) -> String {
    if !value.is_finite() {
        return NONE.to_owned();
    }
    let digits = format!("{value:.digits$}");
    // What rounds to nothing has no sign.
    let is_nothing = digits.trim_start_matches('-').chars().all(|digit| matches!(digit, '0' | '.'));
    let mut text = digits.replace('-', if is_nothing { "" } else { "−" });
    if !unit.is_empty() {
        // Signs of angles stand close.
        text.extend(Some(SPACE).filter(|_| !["°", "′", "″"].contains(&unit)));
        text.push_str(unit);
    }
    text
}

/// A sentence whose negative numbers have a minus for their hyphen.
pub fn minus(text: &str) -> String {
    let mut before = ' ';
    let mut after = text.chars().skip(1);
    let mut turned = |sign: char| {
        let is_number = after.next().is_some_and(|next| next.is_ascii_digit());
        let is_sign = sign == '-' && is_number && !before.is_alphanumeric();
        before = sign;
        if is_sign { '−' } else { sign }
    };
    text.chars().map(&mut turned).collect()
}

/// A number as it was given: with six digits that count at most, and none that says nothing.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return number(value, 0, "");
    }
    let digits = 5 - value.abs().log10().floor() as i32;
    let text = format!("{value:.*}", digits.clamp(0, 15) as usize);
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    text.replace('-', "−")
}

/// A number that may be missing; [`NONE`] where it is.
pub fn maybe(value: Option<f64>, digits: usize, unit: &str) -> String {
    value.map_or_else(|| NONE.to_owned(), |value| number(value, digits, unit))
}

/// A share of 1, as percent.
pub fn percent(share: f64) -> String {
    number(100.0 * share, 1, "%")
}

/// A whole number in groups of three.
pub fn whole(value: u64) -> String {
    let digits = value.to_string();
    let mut text = String::with_capacity(digits.len() + digits.len() / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(SPACE);
        }
        text.push(digit);
    }
    text
}

/// Bytes, in KB of 1024 and as they are.
pub fn bytes(value: u64) -> String {
    format!("{} ({} bytes)", number(value as f64 / 1024.0, 1, "KB"), whole(value))
}

/// The next smaller number of 1, 2, 5 times a power of ten; 1 where there is none.
pub fn nice(value: f64) -> f64 {
    if !(value.is_finite() && value > 0.0) {
        return 1.0;
    }
    let exponent = value.log10().floor() as i32;
    let lead = value / 10f64.powi(exponent);
    let digit = if lead >= 5.0 {
        5.0
    } else if lead >= 2.0 {
        2.0
    } else {
        1.0
    };
    // Divided, since tenths as powers are not the shortest numbers.
    if exponent < 0 { digit / 10f64.powi(-exponent) } else { digit * 10f64.powi(exponent) }
}

/// Decimals of a nice number.
pub fn decimals(value: f64) -> usize {
    (-value.log10().floor()).max(0.0) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_groups_units_and_a_true_minus() {
        assert_eq!(whole(0), "0");
        assert_eq!(whole(999), "999");
        assert_eq!(whole(1_234_567), "1\u{202f}234\u{202f}567");
        assert_eq!(number(-0.256, 2, "m"), "−0.26\u{202f}m");
        assert_eq!(number(-1.5, 1, "°"), "−1.5°");
        assert_eq!([number(-0.04, 1, ""), number(-0.2, 0, ""), number(-0.06, 1, "")], ["0.0", "0", "−0.1"]);
        assert_eq!(
            minus("phi is -0.13 (-2 m), 3-4 of a north-east 2e-4"),
            "phi is −0.13 (−2 m), 3-4 of a north-east 2e-4"
        );
        assert_eq!(number(f64::NAN, 2, "m"), NONE);
        let shown =
            [46.826_448_892_741_08, 7.300_000_000_000_001, 100.0 * 0.07, -0.000_012_5, 1e6, 0.0, 99.999_999].map(short);
        assert_eq!(shown, ["46.8264", "7.3", "7", "−0.0000125", "1000000", "0", "100"]);
        assert_eq!(maybe(None, 1, "px"), NONE);
        assert_eq!(percent(0.5), "50.0\u{202f}%");
    }

    #[test]
    fn scales_are_one_two_or_five() {
        assert_eq!([nice(1.0), nice(4.99), nice(730.0), nice(0.03)], [1.0, 2.0, 500.0, 0.02]);
        assert_eq!([nice(f64::INFINITY), nice(0.0), nice(f64::NAN)], [1.0; 3]);
        assert_eq!([decimals(0.02), decimals(0.5), decimals(1.0), decimals(50.0)], [2, 1, 0, 0]);
    }
}
