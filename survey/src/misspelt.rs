//! What a misspelt name was meant to be.

use strsim::osa_distance;

/// Letters of a name that may be wrong, at most, and letters of which one may be: chosen. More make another word, and of a
/// short one two are half of it.
const WRONG_MAX: usize = 2;
const LETTERS_A_WRONG_ONE: usize = 3;

/// The known name that is nearest to what was typed, if it is near at all: letters that are missing, too many, others or swapped
/// with the next count as wrong; case, blanks, hyphens and underscores do not count.
pub fn meant<'k>(typed: &str, known: impl IntoIterator<Item = &'k str>) -> Option<&'k str> {
    let plain = |name: &str| name.to_lowercase().replace(['_', '-', ' '], "");
    let typed = plain(typed);
    let off = |name: &'k str| {
        let plain = plain(name);
        let most = (plain.chars().count() / LETTERS_A_WRONG_ONE).min(WRONG_MAX);
        let wrong = osa_distance(&typed, &plain);
        (wrong <= most).then_some((wrong, name))
    };
    known.into_iter().filter_map(off).min_by_key(|(wrong, _)| *wrong).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::meant;

    const KNOWN: [&str; 5] = ["naip", "closed_loop", "cols", "shore", "seasons"];

    #[test]
    fn a_name_with_a_letter_or_two_wrong_is_known() {
        for (typed, name) in [
            ("naib", "naip"),
            ("niap", "naip"),
            ("Closed-lop", "closed_loop"),
            ("closde lop", "closed_loop"),
            ("season", "seasons"),
        ] {
            assert_eq!(meant(typed, KNOWN), Some(name), "{typed}");
        }
    }

    #[test]
    fn another_word_is_not() {
        // Of "shore" two letters of five are other ones, of "naip" two of four.
        for typed in ["", "storm", "colour", "map", "clsd_lp"] {
            assert_eq!(meant(typed, KNOWN), None, "{typed}");
        }
        assert_eq!(meant("naip", []), None);
    }
}
