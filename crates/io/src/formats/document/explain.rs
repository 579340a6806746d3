//! Explanations of errors of the TOML parser and of serde, as diagnostics.

use std::ops::Range;

use toml::de::{DeTable, DeValue};

use super::{Document, covers};
use crate::formats::diagnostic::{Diagnostic, nearest};

/// Keys of earlier versions, and their replacements.
const GONE: [(&str, &str); 4] = [
    ("target.discrepancy", "chances and expected values always have what trials say that the model lacks"),
    ("search.robust", "textures are chosen by the chance that a sample is on target, which counts how samples scatter"),
    ("search.max_evaluations", "every texture within the bounds is tabulated; max_seconds limits the time"),
    ("tolerances.draws", "what is expected of samples is computed without draws"),
];

impl Document {
    /// Explains an `error` of the parser or of serde.
    pub(super) fn explain(&self, error: &toml::de::Error) -> Diagnostic {
        let span = error.span().unwrap_or(0..0);
        let message = error.message();
        let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
        if message.starts_with("unknown field") && !quoted.is_empty() {
            let written = quoted[0];
            let mut refused = self.refuse(self.value_span(&span, written), "is not a known key");
            refused.value = None;
            let gone = GONE.iter().find(|(key, _)| refused.key.as_deref() == Some(key));
            if let Some((_, instead)) = gone {
                refused.reason = "is no longer a key".to_owned();
                return refused.expected(format!("no such line: {instead}"));
            }
            refused.suggestion = nearest(written, quoted[1..].iter().copied()).map(Into::into);
            return refused.expected(format!("one of {}", quoted[1..].join(", ")));
        }
        // Errors of records name their key first.
        if let Some((key, message)) = message.strip_prefix('`').and_then(|message| message.split_once("`: ")) {
            return self.explain_value(self.value_span(&span, key), message);
        }
        if message.starts_with("missing field") && !quoted.is_empty() {
            return self.missing(span, quoted[0]);
        }
        if message.starts_with("duplicate key") {
            return self.duplicate(span);
        }
        self.explain_value(span, message)
    }

    /// Explains why the value at `span` was refused, by serde's `message`.
    fn explain_value(&self, span: Range<usize>, message: &str) -> Diagnostic {
        if let Some(value) = decimal_comma(self.line_text(span.start)) {
            return Diagnostic {
                file: Some(self.path.as_path().into()),
                line: Some(self.line(span.start)),
                reason: "has a decimal comma".to_owned(),
                value: Some(value.clone().into()),
                ..Diagnostic::default()
            }
            .expected(format!("a decimal point: {}", value.replace(',', ".")));
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
        let is_listed = self.line_text(span.start).trim_start().starts_with("[[");
        let mut refused = self.refuse(span, "");
        if is_listed && said.ends_with("expected a table") {
            let key = refused.key.clone().unwrap_or_default();
            refused.value = None;
            "stands in double brackets, as one of a list".clone_into(&mut refused.reason);
            return refused.expected(format!("one table, [{key}]"));
        }
        if let Some((what, expected)) = said.rsplit_once(", expected ") {
            what.clone_into(&mut refused.reason);
            refused = refused.expected(expected);
        } else {
            refused.reason = said;
        }
        if refused.reason.starts_with("invalid type") {
            "has the wrong type".clone_into(&mut refused.reason);
        } else if refused.value.is_some() && refused.reason.starts_with("invalid value") {
            "is out of range".clone_into(&mut refused.reason);
        } else {
            refused.value = None;
        }
        refused
    }

    /// Refuses a key or table heading that occurs for the second time at `span`, and names the first occurrence.
    fn duplicate(&self, span: Range<usize>) -> Diagnostic {
        let name = self.text.get(span.clone()).unwrap_or_default().trim_matches(['"', '\'']).to_owned();
        let is_heading = self.line_text(span.start).trim_start().starts_with('[');
        // The second heading replaces the first in the parsed document.
        let line_start = self.text[..span.start].rfind('\n').map_or(0, |end| end + 1);
        let text = if is_heading { &self.text[..line_start] } else { &*self.text };
        let (table, _) = DeTable::parse_recoverable(text);
        let mut found = Vec::new();
        namesakes(text, table.get_ref(), (&name, &span), &mut Vec::new(), &mut found);
        let first = found.into_iter().max_by_key(|(_, place)| place.start);
        let key = first.as_ref().map_or_else(|| name.clone(), |(path, _)| path.clone());
        let outer = key.rsplit_once('.').map(|(outer, _)| outer);
        let what = match (is_heading, outer) {
            (true, _) => format!("the table [{key}]"),
            (false, Some(outer)) => format!("the key {name} of the table [{outer}]"),
            (false, None) => format!("the key {name}, outside of all tables,"),
        };
        let before = first
            .map_or_else(String::new, |(_, place)| format!("; the first stands in line {}", self.line(place.start)));
        Diagnostic {
            file: Some(self.path.as_path().into()),
            line: Some(self.line(span.start)),
            key: Some(key.into()),
            reason: format!("{what} occurs a second time{before}"),
            ..Diagnostic::default()
        }
        .expected(if is_heading { "one table with all of its keys" } else { "one line with this key" })
    }
}

/// Replaces `code` where it occurs as a separate word.
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

/// Keys called `name` before `second` in the tables that can hold `second`, with their dotted paths. Inline tables are
/// skipped unless they hold `second`.
fn namesakes(
    text: &str,
    table: &DeTable<'_>,
    (name, second): (&str, &Range<usize>),
    path: &mut Vec<String>,
    found: &mut Vec<(String, Range<usize>)>,
) {
    for (key, value) in table {
        path.push(key.get_ref().to_string());
        if key.get_ref() == name && key.span().start < second.start {
            found.push((path.join("."), key.span()));
        }
        let elements = match value.get_ref() {
            DeValue::Array(array) => array.iter().collect(),
            _ => vec![value],
        };
        for element in elements {
            if let DeValue::Table(inner) = element.get_ref()
                && (!text[element.span()].starts_with('{') || covers(&element.span(), second))
            {
                namesakes(text, inner, (name, second), path, found);
            }
        }
        path.pop();
    }
}

/// Number with a decimal comma in a line such as `key = 2,7`.
fn decimal_comma(line: &str) -> Option<String> {
    let (_, value) = line.split_once('=')?;
    let value = value.split('#').next().unwrap_or_default();
    let (whole, decimals) = value.trim().split_once(',')?;
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    (is_digits(whole.trim_start_matches(['-', '+'])) && is_digits(decimals)).then(|| format!("{whole},{decimals}"))
}
