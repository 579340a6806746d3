//! Converts errors of the TOML parser and of serde to diagnostics.

use std::ops::Range;

use super::Document;
use crate::formats::diagnostic::{Diagnostic, nearest};
use slipgrid_base::key_error::alternatives;

impl Document {
    /// Converts an `error` of the TOML parser or of serde to a diagnostic.
    pub(super) fn explain(&self, error: &toml::de::Error) -> Diagnostic {
        let span = error.span().unwrap_or(0..0);
        let message = error.message();
        if let Some((written, known)) = unknown(message, "field") {
            let mut refused = self.refuse(self.value_span(&span, written), "is not a known key");
            refused.value = None;
            refused.suggestion = nearest(written, known.iter().copied()).map(Into::into);
            // In a design file, these keys limit the search and stand beside [laser].
            if known.contains(&"ablation") && ["depth_per_burst_um", "min_land_um"].contains(&written) {
                refused.suggestion = None;
                return refused.expected(format!("{written} in [limits]"));
            }
            return refused.expected(format!("one of {}", known.join(", ")));
        }
        if let Some((written, known)) = unknown(message, "variant") {
            let mut refused = self.refuse(span, "is not known");
            refused.suggestion = nearest(written, known.iter().copied()).map(Into::into);
            return refused.expected(alternatives(&known));
        }
        // Errors of records name their key first.
        if let Some((key, message)) = message.strip_prefix('`').and_then(|message| message.split_once("`: ")) {
            return self.explain_value(self.value_span(&span, key), message);
        }
        if let Some(key) = message.strip_prefix("missing field `") {
            return self.missing(span, key.trim_end_matches('`'));
        }
        if message.starts_with("duplicate key") {
            return self.duplicate(span);
        }
        self.explain_value(span, message)
    }

    /// Converts `message`, in which serde says why the value at `span` was refused, to a diagnostic.
    fn explain_value(&self, span: Range<usize>, message: &str) -> Diagnostic {
        if let Some(value) = decimal_comma(self.line_text(span.start)) {
            let expected = format!("a decimal point: {}", value.replace(',', "."));
            let refused = self.refuse(span, "has a decimal comma").expected(expected);
            return Diagnostic { key: None, value: Some(value.into()), ..refused };
        }
        let plain = [
            ("floating point ", ""),
            ("f64", "a number"),
            ("u64", "a whole number not below zero"),
            ("u32", "a whole number not below zero"),
            ("usize", "a whole number not below zero"),
            ("boolean", "true or false"),
            ("a boolean", "true or false"),
            ("sequence", "list"),
            ("map", "table"),
        ];
        let said = plain.iter().fold(message.to_owned(), |said, (code, word)| replace_word(&said, code, word));
        // Names of the program's own types mean nothing to the user.
        let said = said.find("expected struct ").map_or(said.clone(), |at| format!("{}expected a table", &said[..at]));
        let line = self.line_text(span.start).trim_start();
        let (is_heading, is_listed) = (line.starts_with('['), line.starts_with("[["));
        let mut refused = self.refuse(span, "");
        // A reader takes the table that a list holds for the first key of the table it expects.
        if is_listed && (said.ends_with("expected a table") || said.starts_with("invalid type: table")) {
            let expected = format!("one table, [{}]", refused.key.as_deref().unwrap_or_default());
            let reason = "stands in double brackets, as one of a list".to_owned();
            return Diagnostic { value: None, reason, ..refused }.expected(expected);
        }
        if is_heading && said == "invalid type: table, expected a list" {
            let expected = format!("double brackets, [[{}]]", refused.key.as_deref().unwrap_or_default());
            let reason = "stands in single brackets, and is one of a list".to_owned();
            return Diagnostic { value: None, reason, ..refused }.expected(expected);
        }
        if let Some((what, expected)) = said.rsplit_once(", expected ") {
            what.clone_into(&mut refused.reason);
            refused = refused.expected(expected);
        } else {
            refused.reason = said;
        }
        let is_list = refused.reason.starts_with("invalid length") && refused.expected.as_deref() == Some("a table");
        if is_list || refused.reason.starts_with("invalid type") {
            "has the wrong type".clone_into(&mut refused.reason);
        } else if refused.value.is_some() && refused.reason.starts_with("invalid value") {
            "is out of range".clone_into(&mut refused.reason);
        } else {
            refused.value = None;
        }
        refused
    }

    /// Refuses a key or table heading that occurs for the second time at `span`.
    fn duplicate(&self, span: Range<usize>) -> Diagnostic {
        let is_heading = self.line_text(span.start).trim_start().starts_with('[');
        let expected = if is_heading {
            "one table with all of its keys, or a list of tables, [[NAME]]"
        } else {
            "one line with this key in its table"
        };
        let key = self.text.get(span.clone()).unwrap_or_default().trim_matches(['"', '\'']).into();
        let refused = self.refuse(span, "occurs a second time").expected(expected);
        Diagnostic { key: Some(key), value: None, ..refused }
    }
}

/// Extracts the name that serde refused in `message` as an unknown `kind`, and the known names; `None` for other
/// messages. The refused name may contain any character.
fn unknown<'a>(message: &'a str, kind: &str) -> Option<(&'a str, Vec<&'a str>)> {
    let (written, known) =
        message.strip_prefix("unknown ")?.strip_prefix(kind)?.strip_prefix(" `")?.rsplit_once("`, expected ")?;
    Some((written, known.split('`').skip(1).step_by(2).collect()))
}

/// Replaces `code` by `word` wherever `code` is a separate word of `text`.
pub(super) fn replace_word(text: &str, code: &str, word: &str) -> String {
    let alphanumeric = |letter: Option<char>| letter.is_some_and(|letter| letter.is_alphanumeric() || letter == '_');
    let mut replaced = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(code) {
        let (before, after) = (&rest[..at], &rest[at + code.len()..]);
        let inside = alphanumeric(before.chars().next_back().or_else(|| replaced.chars().next_back()))
            || (!code.ends_with(' ') && alphanumeric(after.chars().next()));
        replaced.push_str(before);
        replaced.push_str(if inside { code } else { word });
        rest = after;
    }
    replaced + rest
}

/// Number with a decimal comma in a line such as `key = 2,7`; `None` for other lines.
fn decimal_comma(line: &str) -> Option<String> {
    let (_, value) = line.split_once('=')?;
    let value = value.split('#').next().unwrap_or_default();
    let (whole, decimals) = value.trim().split_once(',')?;
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (is_digits(whole.trim_start_matches(['-', '+'])) && is_digits(decimals)).then(|| format!("{whole},{decimals}"))
}
