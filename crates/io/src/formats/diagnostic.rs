//! Diagnostics of refused or unusual input: file, line, key, value, reason and accepted values.

use std::fmt;
use std::path::Path;

use strsim::levenshtein;

/// Reason why an input was refused, or is unusual.
#[derive(Clone, Debug, Default, PartialEq, thiserror::Error)]
pub struct Diagnostic {
    /// The file, as the user named it; `None` for the command line.
    pub file: Option<Box<Path>>,
    /// Line in the file, from 1; `None` if no single line is concerned.
    pub line: Option<u32>,
    /// Dotted key, for example `bounds.width_um`, or a flag of the command line; `None` if neither is concerned.
    pub key: Option<Box<str>>,
    /// Refused or unusual value, as the user wrote it; `None` if no single value is concerned.
    pub value: Option<Box<str>>,
    /// Reason of the refusal or the warning.
    pub reason: String,
    /// Accepted values.
    pub expected: Option<Box<str>>,
    /// Probable intended value; `None` without a guess.
    pub suggestion: Option<Box<str>>,
    /// The file does not exist.
    pub is_absent: bool,
}

impl Diagnostic {
    /// Converts a diagnostic about the `made_up` design file, which no user wrote, to one about the file `material`
    /// given by the user. Diagnostics about other files are unchanged.
    pub(crate) fn of_material(self, made_up: &Path, material: &Path) -> Self {
        if self.file.as_deref() != Some(made_up) {
            return self;
        }
        let is_of_condition = matches!(self.key.as_deref(), Some("condition" | "material"));
        let flags = || "--speed-mm-s and --humidity-pct, or a design file that says so".into();
        let expected = self.expected.or_else(|| is_of_condition.then(flags));
        let value = self.value.filter(|_| !is_of_condition);
        Diagnostic { file: Some(material.into()), line: None, key: None, value, expected, ..self }
    }

    /// Creates a diagnostic about a file as a whole.
    pub fn file(path: &Path, reason: impl Into<String>) -> Self {
        Self { file: Some(path.into()), reason: reason.into(), ..Self::default() }
    }

    /// Creates a diagnostic about a key outside a file, or a flag of the command line, without its value.
    pub fn key(key: &str, reason: impl Into<String>) -> Self {
        Self { key: Some(key.into()), reason: reason.into(), ..Self::default() }
    }

    /// Creates a diagnostic about a flag of the command line with its value.
    pub fn flag(flag: &str, value: impl Into<Box<str>>, reason: impl Into<String>) -> Self {
        Self { value: Some(value.into()), ..Self::key(flag, reason) }
    }

    /// Adds the accepted values.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into().into());
        self
    }
}

/// Maximum number of characters of a path in a message.
const LONGEST_PATH: usize = 300;
/// Maximum number of characters of a key in a message.
const LONGEST_KEY: usize = 120;
/// Maximum number of characters of a value in a message.
const LONGEST_VALUE: usize = 120;
/// Maximum number of characters of a reason, which may quote the refused value.
const LONGEST_REASON: usize = 1000;
/// Maximum number of characters of a line on a terminal.
const LONGEST_LINE: usize = 4000;

/// Makes `text` safe for a terminal: escapes control characters and characters that change the direction of writing,
/// and cuts the text after `most` characters.
pub fn printable(text: &str, most: usize) -> String {
    let turns = |letter: char| matches!(letter, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    let mut shown = String::new();
    for (place, letter) in text.chars().enumerate() {
        if place == most {
            return shown + "...";
        }
        if letter.is_control() || turns(letter) {
            shown.extend(letter.escape_default());
        } else {
            shown.push(letter);
        }
    }
    shown
}

/// Makes every line of `text` safe for a terminal.
pub fn printable_lines(text: &str) -> String {
    text.split('\n').map(|line| printable(line, LONGEST_LINE)).collect::<Vec<_>>().join("\n")
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", printable(&file.to_string_lossy(), LONGEST_PATH))?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            f.write_str(" ")?;
        }
        if let Some(key) = &self.key {
            write!(f, "{}: ", printable(key, LONGEST_KEY))?;
        }
        if let Some(value) = &self.value {
            write!(f, "{} ", printable(value, LONGEST_VALUE))?;
        }
        f.write_str(&printable(&self.reason.replace('\n', "; "), LONGEST_REASON))?;
        if let Some(expected) = &self.expected {
            write!(f, "; expected {}", printable(&expected.replace('\n', "; "), LONGEST_REASON))?;
        }
        if let Some(suggestion) = &self.suggestion {
            write!(f, " (did you mean `{}`?)", printable(suggestion, LONGEST_KEY))?;
        }
        Ok(())
    }
}

/// Candidate most similar to `name`; `None` if no candidate is similar enough.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A quarter of the letters may differ, and at least two: `widht_um`, `spacing_mm`.
    let most = (name.chars().count() / 4).max(2);
    candidates
        .into_iter()
        .map(|candidate| {
            // A key that differs only in its unit, or lacks it, is the most probable; then one that lacks more words.
            let same_quantity =
                stem(candidate).is_some_and(|quantity| quantity == name || stem(name) == Some(quantity));
            let is_begun = || candidate.strip_prefix(name).is_some_and(|rest| rest.starts_with('_'));
            let distance = if same_quantity { 0 } else { levenshtein(name, candidate) };
            (if is_begun() { distance.min(1) } else { distance }, candidate)
        })
        .filter(|&(distance, _)| distance <= most)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// Key without the unit, the last word: `width` for `width_um`; `None` for a key of one word.
fn stem(key: &str) -> Option<&str> {
    key.rsplit_once('_').map(|(quantity, _)| quantity)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_unit_or_a_slip_of_the_pen_finds_its_key() {
        let keys = ["width_um", "spacing_um", "depth_um", "planform"];
        for (written, meant) in [
            ("widht_um", Some("width_um")),
            ("width_mm", Some("width_um")),
            ("depth_m", Some("depth_um")),
            ("plan_form", Some("planform")),
            ("width", Some("width_um")),
            ("humidity_pct", None),
        ] {
            assert_eq!(nearest(written, keys), meant, "{written}");
        }
    }

    #[test]
    fn what_a_terminal_would_obey_is_escaped_and_what_is_long_is_cut() {
        assert_eq!(printable("a\u{1b}[31m\u{7}\u{202e}b\u{9b}", 99), "a\\u{1b}[31m\\u{7}\\u{202e}b\\u{9b}");
        assert_eq!(printable("polym\u{e8}re", 99), "polym\u{e8}re");
        assert_eq!(printable("abcdef", 3), "abc...");
        assert_eq!(printable("abc", 3), "abc");
        assert_eq!(printable_lines("a\r\nb\n"), "a\\r\nb\n");
        let long = "[".repeat(100_000);
        let refused = Diagnostic {
            key: Some(long.as_str().into()),
            value: Some("\u{1b}c".into()),
            ..Diagnostic::file(Path::new(&long), &long)
        };
        let message = refused.to_string();
        assert!(message.len() < 2000 && !message.contains('\u{1b}'), "{message}");
    }

    #[test]
    fn the_message_reads_from_the_file_to_what_would_be_accepted() {
        let refused = Diagnostic {
            file: Some(Path::new("designs/x.toml").into()),
            line: Some(14),
            key: Some("bounds.width_um".into()),
            value: Some("[400, 40]".into()),
            reason: "falls".into(),
            expected: Some("[smallest, largest]".into()),
            ..Diagnostic::default()
        };
        assert_eq!(
            refused.to_string(),
            "designs/x.toml:14: bounds.width_um: [400, 40] falls; expected [smallest, largest]"
        );
    }
}
