//! Words and numbers of a page.

use slipgrid_design::results::{self, ABOUT_MATERIAL, fixed};

/// Beginnings of doubts that name the source of the doubt.
const PREFIXES: [&str; 2] = [ABOUT_MATERIAL, "laser: "];
/// Maximum number of characters of a name at the beginning of a doubt.
const LONGEST_NAME: usize = 24;

/// Returns a finite value; `None` for infinities, NaN and `None`.
pub fn known(value: impl Into<Option<f64>>) -> Option<f64> {
    value.into().filter(|value| value.is_finite())
}

/// Formats words as a sentence, or as several sentences if semicolons outside brackets separate them. A key or file
/// name at the beginning keeps its case.
pub fn sentence(words: &str) -> String {
    let mut depth = 0_usize;
    let mut parts = vec![String::new()];
    for letter in words.chars() {
        depth = match letter {
            '(' | '[' => depth + 1,
            ')' | ']' => depth.saturating_sub(1),
            _ => depth,
        };
        match parts.last_mut() {
            Some(part) if letter != ';' || depth > 0 => part.push(letter),
            _ => parts.push(String::new()),
        }
    }
    let parts = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    let parts: Vec<String> = parts.map(capitalized).collect();
    parts.join(" ")
}

/// Formats words as one sentence, with a capital letter and a full stop.
fn capitalized(words: &str) -> String {
    let words = words.strip_suffix('.').unwrap_or(words);
    let first = words.split_whitespace().next().unwrap_or_default().trim_end_matches([':', ',', ';', '.']);
    if first.contains(['_', '.', '/', '`', '[']) {
        return format!("{words}.");
    }
    let mut letters = words.chars();
    let first = letters.next().map_or_else(String::new, |letter| letter.to_uppercase().collect());
    format!("{first}{}.", letters.as_str())
}

/// Formats a number with `digits` decimals, or as a dash if it is unknown.
pub fn number(value: impl Into<Option<f64>>, digits: usize) -> String {
    fixed(value.into(), digits)
}

/// Formats a number with the fewest digits that read back as the same number, for example 50, or as a dash if it is
/// unknown.
pub fn plain(value: impl Into<Option<f64>>) -> String {
    known(value).map_or_else(|| "-".to_owned(), |value| value.to_string())
}

/// Replaces the unit um by µm after a number, a closing bracket or "in". Names of keys, which end in `_um`, and other
/// words stay unchanged.
pub fn micrometres(words: &str) -> String {
    let is_of_word = |c: char| c.is_alphanumeric() || c == '_';
    let mut parts = words.split(" um");
    let mut text = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let is_unit = text.ends_with(|c: char| c.is_ascii_digit() || ")]".contains(c)) || text.ends_with(" in");
        text += if is_unit && !part.starts_with(is_of_word) { " µm" } else { " um" };
        text += part;
    }
    text
}

/// First words of a doubt, without the source of the doubt and without the explanation.
pub(super) fn brief(doubt: &str) -> &str {
    let doubt = PREFIXES.iter().find_map(|prefix| doubt.strip_prefix(prefix)).unwrap_or(doubt);
    let first = doubt.split("; ").next().unwrap_or(doubt);
    // A short beginning before a colon is a name, such as the name of a key; a long one is the doubt itself.
    match first.split_once(": ") {
        Some((words, _)) if words.chars().count() > LONGEST_NAME => words,
        _ => first,
    }
}

/// Formats a length in micrometres, to a tenth of a nanometre.
pub fn length_um(value: f64) -> String {
    plain((value * 1e4).round() / 1e4)
}

/// Formats a share from 0 to 1 in per cent, without the sign %, or as a dash if it is unknown.
pub fn percent(share: impl Into<Option<f64>>, digits: usize) -> String {
    number(share.into().map(|share| 100.0 * share), digits)
}

/// Formats a number, with ± and the error if the error is known, or as a dash if the number is unknown.
pub fn with_error(value: impl Into<Option<f64>>, error: impl Into<Option<f64>>, digits: usize) -> String {
    results::with_error(value, error, digits).replace("+-", "±")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_begin_with_a_capital_but_names_of_keys_and_files_stay_as_they_are() {
        assert_eq!(sentence("rows are left out"), "Rows are left out.");
        assert_eq!(sentence("Rows are left out."), "Rows are left out.");
        assert_eq!(sentence("one (a; b) two; three; mu_d rises"), "One (a; b) two. Three. mu_d rises.");
        for named in
            ["dynamic_mean: fitted", "traces.csv: 3 rows", "static_mean 2: not determined", "[learned] is used"]
        {
            assert_eq!(sentence(named), format!("{named}."));
        }
    }

    #[test]
    fn badges_have_the_first_words_of_a_doubt() {
        for (doubt, words) in [
            ("the material is doubtful: flat friction rises (5.6 errors); check E", "flat friction rises (5.6 errors)"),
            ("at 2.6 MPa outside the measured range: the nearest was taken", "at 2.6 MPa outside the measured range"),
            ("laser: 2 bursts make 6.8 um, not 5.2 um: lower the fluence", "2 bursts make 6.8 um, not 5.2 um"),
            ("spikes: 5 points stand alone", "spikes: 5 points stand alone"),
        ] {
            assert_eq!(brief(doubt), words);
        }
    }

    #[test]
    fn micrometres_are_written_with_their_sign_but_keys_stay() {
        assert_eq!(micrometres("10 um (3 um), width_um, 2 umbrellas"), "10 µm (3 µm), width_um, 2 umbrellas");
    }
}
