//! TOML files with their text, so that every diagnostic can name a line.

mod explain;
mod tables_only;

use std::ops::Range;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;

use crate::formats::spanned::Spanned;
use serde::de::DeserializeOwned;
use toml::de::{DeTable, DeValue};

use self::tables_only::TablesOnly;
use super::file_kind::FileKind;
use crate::formats::diagnostic::{Diagnostic, nearest};
use crate::formats::plausible;
use crate::formats::source::{Entry, NoFiles, Source, read_text};
use slipgrid_base::key_error::{KeyError, Refusal};
use slipgrid_base::units::{
    DENSITY_G_CM3, HUMIDITY_PCT, LENGTH_MM, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, Quantity, SPEED_MM_S,
};
use slipgrid_design::results::SCHEMA;

/// Maximum number of characters of a refused value in a message.
const LONGEST_VALUE: usize = 60;

/// A TOML file in memory.
#[derive(Clone, Debug)]
pub struct Document {
    source: Source,
    path: PathBuf,
    text: String,
    /// Expected kind of file; `None` if unknown.
    kind: Option<FileKind>,
}

/// `path` with `name/..` left out.
fn without_detours(path: &Path) -> PathBuf {
    let mut plain = PathBuf::new();
    for part in path.components() {
        match (part, plain.components().next_back()) {
            (Component::ParentDir, Some(Component::Normal(_))) => drop(plain.pop()),
            _ => plain.push(part),
        }
    }
    plain
}

impl Document {
    /// Reads the file at `path` of `source`, which is expected to be a `kind`.
    ///
    /// # Errors
    /// [`Diagnostic`] if `path` is a folder, cannot be read, is not UTF-8, or seems to be another kind of file.
    pub fn read(source: &Source, path: &Path, kind: FileKind) -> Result<Self, Diagnostic> {
        let document = Self::read_any(source, path, kind)?;
        document.require(kind)?;
        Ok(document.as_kind(kind))
    }

    /// Whether the document is known to be intended as a `kind`.
    pub fn is_meant_as(&self, kind: FileKind) -> bool {
        self.kind == Some(kind)
    }

    /// Marks the document as intended as a `kind`, so that messages about missing keys list the needs of such a file.
    #[must_use]
    pub fn as_kind(mut self, kind: FileKind) -> Self {
        self.kind = Some(kind);
        self
    }

    /// Refuses the document if it seems to be of another kind than `kind`.
    ///
    /// # Errors
    /// [`Diagnostic`] that names the apparent kind.
    pub fn require(&self, kind: FileKind) -> Result<(), Diagnostic> {
        kind.require(&self.path, &self.text)
    }

    /// Reads the file at `path`, whatever its kind; `kind` is the expected kind in error messages.
    ///
    /// # Errors
    /// [`Diagnostic`] if `path` is a folder, cannot be read or is not UTF-8.
    pub fn read_any(source: &Source, path: &Path, kind: FileKind) -> Result<Self, Diagnostic> {
        if source.entry(path).is_ok_and(|entry| entry == Entry::Folder) {
            return Err(kind.refuse_folder(source, path));
        }
        let text = read_text(source, path, kind.expected())?;
        Ok(Self { source: Arc::clone(source), path: path.to_owned(), text, kind: None })
    }

    /// Source from which the files named in the document are read.
    pub const fn source(&self) -> &Source {
        &self.source
    }

    /// Apparent kind of the document, from its tables; `None` if unclear.
    pub fn kind(&self) -> Option<FileKind> {
        FileKind::of(&self.text)
    }

    /// Creates a document from text that names no other file; `path` names the document in messages.
    pub fn new(path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self::within(&(Arc::new(NoFiles) as Source), path, text)
    }

    /// Creates a document from text; `path` names the document in messages, and files named in the text are read from
    /// `source`.
    pub fn within(source: &Source, path: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { source: Arc::clone(source), path: path.into(), text: text.into(), kind: None }
    }

    /// Text of the document.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The file's path, as the user named it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Resolves a path written in the document, which is relative to the folder of the document; without detours such as
    /// `designs/..`, as messages name it.
    pub fn resolve(&self, relative: &str) -> PathBuf {
        let path = self.path.parent().map_or_else(|| PathBuf::from(relative), |folder| folder.join(relative));
        let plain = without_detours(&path);
        let folder = |path: &Path| {
            let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            self.source.canonical(folder)
        };
        // Behind a link `..` is another folder.
        if plain != path && folder(&plain) == folder(&path) { plain } else { path }
    }

    /// File name without extension, for default output names.
    pub fn stem(&self) -> String {
        self.path.file_stem().map_or_else(|| "result".to_owned(), |stem| stem.to_string_lossy().into_owned())
    }

    /// Parses the document as a `T`.
    ///
    /// # Errors
    /// [`Diagnostic`] for bad TOML, unknown and missing keys, and values of a wrong type.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T, Diagnostic> {
        let read = toml::Deserializer::parse(&self.text).and_then(|reader| T::deserialize(TablesOnly(reader)));
        read.map_err(|error| self.explain(&error))
    }

    /// Creates a diagnostic for the value at `span`, in bytes, with its line and key.
    pub fn refuse(&self, span: Range<usize>, reason: impl Into<String>) -> Diagnostic {
        Diagnostic {
            line: Some(self.line(span.start)),
            key: self.key_at(&span),
            value: self.value_at(span),
            ..Diagnostic::file(&self.path, reason)
        }
    }

    /// Creates a diagnostic for the value of `key` in the outermost table `table`, or, if the file does not state it, for
    /// the key with its default value `default`.
    pub(crate) fn refuse_or_default(
        &self,
        (table, key): (&str, &str),
        default: Option<String>,
        reason: impl Into<String>,
    ) -> Diagnostic {
        match self.place(table, key) {
            Some(place) => self.refuse(place, reason),
            None => Diagnostic {
                key: Some(format!("{table}.{key}").into()),
                value: default.map(|default| format!("{default} (the default)").into()),
                ..Diagnostic::file(&self.path, reason)
            },
        }
    }

    /// Span of the value of `key` in the outermost table `table`; `None` if the file does not state it.
    pub(crate) fn place(&self, table: &str, key: &str) -> Option<Range<usize>> {
        match DeTable::parse(&self.text).ok()?.get_ref().get(table)?.get_ref() {
            DeValue::Table(table) => Some(table.get(key)?.span()),
            _ => None,
        }
    }

    /// Creates a diagnostic that `key` is missing in the table at the span `table`.
    pub fn missing(&self, table: Range<usize>, key: &str) -> Diagnostic {
        // The document as a whole has no key.
        let outer = Some(&table).filter(|span| !span.is_empty() && **span != (0..self.text.len()));
        let outer = outer.and_then(|span| self.key_at(span));
        if outer.is_none() && DeTable::parse(&self.text).is_ok_and(|table| table.get_ref().is_empty()) {
            let expected = match (self.kind, needed_value(key)) {
                (Some(kind), _) => format!("{}, such as `{}` writes", kind.expected(), kind.written_by()),
                (None, Some(value)) => format!("a file with the key {key}: {value}"),
                (None, None) => format!("a file with the key {key}"),
            };
            return Diagnostic::file(&self.path, "holds no keys").expected(expected);
        }
        let kind = self.kind.filter(|_| outer.is_none());
        let needed = kind.and_then(|kind| {
            let (keys, by) = (kind.needed_table(key)?, kind.written_by());
            Some(format!("a table [{key}] with {keys}, as `{by}` writes one"))
        });
        // A table below the one that lacks it may have lost the first part of its heading.
        let stray = outer.as_ref().and_then(|outer| {
            let line = self.line(DeTable::parse(&self.text).ok()?.get_ref().get_key_value(key)?.0.span().start);
            let is_below = line > self.line(table.start);
            is_below.then(|| format!("[{outer}.{key}] in place of [{key}] in line {line}"))
        });
        Diagnostic {
            line: Some(self.line(table.start)),
            key: Some(outer.map_or_else(|| key.into(), |outer| format!("{outer}.{key}").into())),
            expected: stray.or(needed).or_else(|| needed_value(key)).map(Into::into),
            ..Diagnostic::file(&self.path, "is missing")
        }
    }

    /// Refuses a file of a later schema than this version supports.
    ///
    /// # Errors
    /// [`Diagnostic`] at the key if `schema` is 0 or above the supported version.
    pub fn check_schema(&self, schema: Option<&Spanned<u32>>) -> Result<(), Diagnostic> {
        let Some(schema) = schema.filter(|schema| !(1..=SCHEMA).contains(schema.get_ref())) else { return Ok(()) };
        let reason = if *schema.get_ref() == 0 { "is no schema" } else { "is the schema of a later slipgrid" };
        Err(self.refuse(schema.span(), reason).expected(format!("a schema up to {SCHEMA}, or none")))
    }

    /// Converts a number of the file to SI units.
    ///
    /// # Errors
    /// [`Diagnostic`] if the number is not finite or is outside the range of `quantity`.
    pub fn number(&self, value: &Spanned<f64>, quantity: Quantity) -> Result<f64, Diagnostic> {
        Refusal::number(*value.get_ref(), quantity).map_err(|refusal| self.refuse_value(value.span(), &refusal))
    }

    /// Creates a diagnostic for `error`, which concerns a key of the table at the span `table`.
    pub fn refuse_key(&self, table: &Range<usize>, error: &KeyError) -> Diagnostic {
        match &error.refusal {
            Refusal::Missing => self.missing(table.clone(), error.key),
            refusal => self.refuse_value(self.value_span(table, error.key), refusal),
        }
    }

    /// Creates a diagnostic for the value at `span`, or for a number of the list at `span`.
    fn refuse_value(&self, span: Range<usize>, refusal: &Refusal) -> Diagnostic {
        let is_list = self.text.get(span.clone()).is_some_and(|text| text.starts_with('['));
        let mut refused = self.refuse(span, refusal.to_string());
        refused.expected = refusal.expected().map(Into::into);
        if let Refusal::OutOfRange { value, quantity } = refusal {
            if is_list {
                refused.value = Some(value.to_string().into());
            }
            if let Some(slip) = plausible::slip(*quantity, *value) {
                refused.expected = Some(format!("{quantity}; {slip}").into());
            }
        }
        if let Refusal::UnknownName { name, known } = refusal {
            refused.suggestion = nearest(name, known.iter().copied()).map(Into::into);
        }
        refused
    }

    /// Span of the value of `key` in the table at the span `table`; `table` itself if it does not have the key.
    pub(crate) fn value_span(&self, table: &Range<usize>, key: &str) -> Range<usize> {
        let root = DeTable::parse(&self.text).ok();
        let found = root.as_ref().and_then(|root| {
            // The document as a whole has no position.
            let held = if table.is_empty() { Some(root.get_ref()) } else { table_at(root.get_ref(), table) };
            Some(held?.get(key)?.span())
        });
        found.unwrap_or_else(|| table.clone())
    }

    /// Converts an optional number of the file to SI units; `None` stays `None`.
    ///
    /// # Errors
    /// Errors of [`Document::number`].
    pub fn optional(&self, value: Option<&Spanned<f64>>, quantity: Quantity) -> Result<Option<f64>, Diagnostic> {
        value.map(|value| self.number(value, quantity)).transpose()
    }

    /// Converts a list of at least one number to SI units.
    ///
    /// # Errors
    /// [`Diagnostic`] if the list is empty or a number is refused.
    pub fn numbers(&self, values: &Spanned<Vec<Spanned<f64>>>, quantity: Quantity) -> Result<Vec<f64>, Diagnostic> {
        if values.get_ref().is_empty() {
            return Err(self.refuse(values.span(), "is empty").expected("at least one number"));
        }
        values.get_ref().iter().map(|value| self.number(value, quantity)).collect()
    }

    /// Selects the element of `all` that `value` names.
    ///
    /// # Errors
    /// [`Diagnostic`] that lists the accepted names.
    pub fn choice<T: Copy>(
        &self,
        value: &Spanned<String>,
        all: &[T],
        name: impl Fn(T) -> &'static str,
    ) -> Result<T, Diagnostic> {
        Refusal::choice(value.get_ref(), all, name).map_err(|refusal| self.refuse_value(value.span(), &refusal))
    }

    /// Line that contains the byte at the offset `byte`, counted from 1.
    fn line(&self, byte: usize) -> u32 {
        let before = self.text.as_bytes().iter().take(byte);
        before.filter(|&&letter| letter == b'\n').fold(1, |line, _| line + 1)
    }

    /// Text at `span` joined to one line and shortened; `None` for tables.
    fn value_at(&self, span: Range<usize>) -> Option<Box<str>> {
        let text = self.text.get(span)?;
        if text.is_empty() || text.starts_with('{') || (text.starts_with('[') && !text.contains(['.', ',', '1'])) {
            return None;
        }
        let joined = text.split_whitespace().collect::<Vec<_>>().join(" ");
        Some(if joined.chars().count() > LONGEST_VALUE {
            joined.chars().take(LONGEST_VALUE).chain("...".chars()).collect()
        } else {
            joined.into()
        })
    }

    /// Dotted key of the value at `span`; `None` if no key leads to the span.
    fn key_at(&self, span: &Range<usize>) -> Option<Box<str>> {
        let table = DeTable::parse(&self.text).ok()?;
        let mut path = Vec::new();
        find_in_table(table.get_ref(), span, &mut path).then(|| path.join(".").into())
    }

    /// Text of the line that contains the byte at the offset `byte`.
    fn line_text(&self, byte: usize) -> &str {
        self.text.lines().nth(self.line(byte) as usize - 1).unwrap_or_default()
    }
}

/// Description of the values that the required `key` takes, with an example; `None` if the key differs between files.
fn needed_value(key: &str) -> Option<String> {
    let number = |quantity: Quantity, example: &str| Some(format!("{quantity}, such as {key} = {example}"));
    match key {
        "speed_mm_s" => number(SPEED_MM_S, "5.0"),
        "humidity_pct" => number(HUMIDITY_PCT, "50.0"),
        "pressure_mpa" => Some(format!("{PRESSURE_MPA}, or a list of such numbers, such as {key} = [0.5, 2.0]")),
        "youngs_modulus_gpa" => number(MODULUS_GPA, "2.7"),
        "density_g_cm3" => number(DENSITY_G_CM3, "1.4"),
        "diameter_mm" | "outer_diameter_mm" | "length_mm" | "width_mm" => number(LENGTH_MM, "10.0"),
        "inner_diameter_mm" => number(LENGTH_MM, "4.0"),
        "width_um" | "spacing_um" => number(LENGTH_UM, "130.0"),
        "length_um" => number(LENGTH_UM, "260.0"),
        "vertices_um" => Some(format!("corners, such as {key} = [[0, 0], [9, 0], [4, 6]]")),
        "shape" => Some(format!("\"disc\", \"rectangle\" or \"ring\", such as {key} = \"disc\"")),
        "depth_um" => number(LENGTH_UM, "5.0"),
        "name" | "source" => Some(format!("a text, such as {key} = \"...\"")),
        "base" => Some(format!("the path of a scene or a design, such as {key} = \"scene.toml\"")),
        "material" => Some(format!("the path of a file, such as {key} = \"material.toml\", or a table [{key}]")),
        _ => None,
    }
}

/// Appends the keys that lead to `span` within `table` to `path`; returns false if no value in `table` covers the span.
fn find_in_table(table: &DeTable<'_>, span: &Range<usize>, path: &mut Vec<String>) -> bool {
    for (key, value) in table {
        path.push(key.get_ref().to_string());
        if find_in_value(value, span, path) || covers(&key.span(), span) {
            return true;
        }
        path.pop();
    }
    false
}

/// Finds the inner table of `table` whose span is `span`; `None` if there is none.
fn table_at<'t, 'a>(table: &'t DeTable<'a>, span: &Range<usize>) -> Option<&'t DeTable<'a>> {
    fn of_value<'t, 'a>(value: &'t toml::Spanned<DeValue<'a>>, span: &Range<usize>) -> Option<&'t DeTable<'a>> {
        match value.get_ref() {
            DeValue::Table(own) if value.span() == *span => Some(own),
            DeValue::Table(own) => table_at(own, span),
            DeValue::Array(list) => list.iter().find_map(|element| of_value(element, span)),
            _ => None,
        }
    }
    table.iter().find_map(|(_, value)| of_value(value, span))
}

fn find_in_value(value: &toml::Spanned<DeValue<'_>>, span: &Range<usize>, path: &mut Vec<String>) -> bool {
    match value.get_ref() {
        DeValue::Table(table) if find_in_table(table, span, path) => true,
        DeValue::Array(array) => {
            // Elements of an array of tables have their own keys; numbers use the key of the array.
            array
                .iter()
                .any(|element| matches!(element.get_ref(), DeValue::Table(_)) && find_in_value(element, span, path))
                || covers(&value.span(), span)
        }
        _ => covers(&value.span(), span),
    }
}

fn covers(outer: &Range<usize>, inner: &Range<usize>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end && outer.start < outer.end
}

#[cfg(test)]
mod tests;
