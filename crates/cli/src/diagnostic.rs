//! Refused input: which file, line and key, what stood there, why not, and what would be accepted.

use std::fmt;
use std::path::Path;

/// Why an input was refused.
#[derive(Clone, Debug, Default, PartialEq, thiserror::Error)]
pub struct Diagnostic {
    /// The file, as the user named it; `None` for the command line.
    pub file: Option<Box<Path>>,
    /// Line in the file, from 1.
    pub line: Option<u32>,
    /// Key, with the tables it stands in: `bounds.width_um`; a flag on the command line.
    pub key: Option<Box<str>>,
    /// What stood there.
    pub value: Option<Box<str>>,
    /// Why it was refused.
    pub reason: String,
    /// What would be accepted.
    pub expected: Option<String>,
    /// A guess at what was meant.
    pub suggestion: Option<Box<str>>,
}

impl Diagnostic {
    /// A refused file as a whole.
    #[must_use]
    pub fn file(path: &Path, reason: impl Into<String>) -> Self {
        Self { file: Some(path.into()), reason: reason.into(), ..Self::default() }
    }

    /// A refused flag of the command line.
    #[must_use]
    pub fn flag(flag: &str, value: impl Into<Box<str>>, reason: impl Into<String>) -> Self {
        Self { key: Some(flag.into()), value: Some(value.into()), reason: reason.into(), ..Self::default() }
    }

    /// The same, with what would be accepted.
    #[must_use]
    pub fn expected(mut self, expected: impl Into<String>) -> Self {
        self.expected = Some(expected.into());
        self
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", file.display())?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
            }
            f.write_str(" ")?;
        }
        if let Some(key) = &self.key {
            write!(f, "{key}: ")?;
        }
        if let Some(value) = &self.value {
            write!(f, "{value} ")?;
        }
        f.write_str(&self.reason)?;
        if let Some(expected) = &self.expected {
            write!(f, "; expected {expected}")?;
        }
        if let Some(suggestion) = &self.suggestion {
            write!(f, " (did you mean `{suggestion}`?)")?;
        }
        Ok(())
    }
}

/// The candidate that `name` most resembles, if any comes close.
#[must_use]
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // A quarter of the letters may be wrong, and at least two: `widht_um`, `spacing_mm`.
    let most = (name.chars().count() / 4).max(2);
    candidates
        .into_iter()
        .map(|candidate| {
            // A key that differs only in its unit is meant before any other.
            let same_quantity = stem(name).is_some_and(|quantity| stem(candidate) == Some(quantity));
            (if same_quantity { 0 } else { edit_distance(name, candidate) }, candidate)
        })
        .filter(|&(distance, _)| distance <= most)
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// The key without its last word, which is the unit: `width` of `width_um`.
fn stem(key: &str) -> Option<&str> {
    key.rsplit_once('_').map(|(quantity, _)| quantity)
}

/// Edit distance with substitution, insertion and deletion (Wagner and Fischer, J. ACM 21, 168).
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &other) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(letter != other);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_known_exactly() {
        for (a, b, distance) in [("kitten", "sitting", 3), ("", "abc", 3), ("abc", "", 3), ("flaw", "lawn", 2)] {
            assert_eq!(edit_distance(a, b), distance, "{a} {b}");
        }
    }

    #[test]
    fn a_wrong_unit_or_a_slip_of_the_pen_finds_its_key() {
        let keys = ["width_um", "spacing_um", "depth_um", "planform"];
        for (written, meant) in [
            ("widht_um", Some("width_um")),
            ("width_mm", Some("width_um")),
            ("depth_m", Some("depth_um")),
            ("plan_form", Some("planform")),
            ("humidity_pct", None),
        ] {
            assert_eq!(nearest(written, keys), meant, "{written}");
        }
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
            suggestion: None,
        };
        assert_eq!(
            refused.to_string(),
            "designs/x.toml:14: bounds.width_um: [400, 40] falls; expected [smallest, largest]"
        );
    }
}
