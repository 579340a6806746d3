//! The keys of a file, read from the source text of the types that read it.
//!
//! A file format is a set of structures that derive `Deserialize`. Their fields are the keys; the comments above the
//! fields describe them, and the types give the accepted kinds of values. [`Types::new`] collects the structures from
//! source files, and [`Types::table`] follows them from one to the next. An unknown type is an error, so that no key is
//! omitted.

use std::collections::BTreeMap;

/// Kind of value that a key accepts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Shape {
    /// A number.
    Number,
    /// A whole number.
    Whole,
    /// True or false.
    Flag,
    /// Text.
    Text,
    /// Anything.
    Any,
    /// A number, or a list of numbers.
    OneOrMore,
    /// A list.
    List(Box<Shape>),
    /// An element of a list of a record, or null.
    OrNull(Box<Shape>),
    /// The path of a file, or the content of the file.
    PathOr(Box<Shape>),
    /// A table, by the file and the name of its structure.
    Table(Place),
}

/// Location of a structure: the source file and the name of the structure.
pub type Place = (String, String);

/// A key of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Key {
    /// Name of the key.
    pub name: String,
    /// Kind of value that the key accepts.
    pub shape: Shape,
    /// Whether the key is required.
    pub is_required: bool,
    /// Description of the key in sentences.
    pub meaning: String,
}

/// Description and keys of a structure.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Table {
    /// Comment above the structure.
    pub meaning: String,
    /// Keys in the order of the fields.
    pub keys: Vec<Key>,
}

/// Field of a structure in the source text.
#[derive(Clone, Debug)]
struct Field {
    name: String,
    kind: String,
    has_default: bool,
    /// Whether the field is flattened: its keys belong to the enclosing structure.
    is_flattened: bool,
    comment: String,
}

/// Structure in the source text.
#[derive(Clone, Debug)]
struct Structure {
    is_public: bool,
    /// Whether every key of the structure may be absent.
    has_defaults: bool,
    comment: String,
    fields: Vec<Field>,
}

/// Structures that derive `Deserialize` in some source files.
#[derive(Clone, Debug, Default)]
pub struct Types {
    structures: BTreeMap<Place, Structure>,
    /// Whether the structures are written instead of read: unknown types then accept anything.
    is_record: bool,
}

impl Types {
    /// Collects the structures of source files, given by name and by text as `cargo fmt` formats it.
    #[must_use]
    pub fn new<'a>(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let mut structures = BTreeMap::new();
        for (file, text) in files {
            let (mut comment, mut attributes) = (String::new(), String::new());
            let mut open: Option<(String, Structure)> = None;
            for line in text.lines() {
                let line = line.trim();
                if let Some(words) = line.strip_prefix("///") {
                    comment += words;
                } else if line.starts_with("#[") {
                    attributes += line;
                } else if let Some((name, structure)) = &mut open {
                    let field = line.strip_suffix(',').and_then(|line| line.split_once(": "));
                    if let Some((field, kind)) = field {
                        structure.fields.push(Field {
                            name: field.rsplit(' ').next().unwrap_or(field).to_owned(),
                            kind: kind.to_owned(),
                            has_default: attributes.contains("default") || attributes.contains("skip_serializing_if"),
                            is_flattened: attributes.contains("flatten"),
                            comment: std::mem::take(&mut comment).trim().to_owned(),
                        });
                    } else if line == "}" {
                        structures.insert((file.to_owned(), name.clone()), structure.clone());
                        open = None;
                    }
                    attributes.clear();
                } else {
                    let head = line.strip_suffix(" {").and_then(|line| line.split_once("struct "));
                    if let Some((before, name)) = head.filter(|_| attributes.contains("Deserialize")) {
                        let comment = comment.trim().to_owned();
                        let has_defaults = attributes.contains("serde(default");
                        let structure =
                            Structure { is_public: before == "pub ", has_defaults, comment, fields: Vec::new() };
                        open = Some((name.to_owned(), structure));
                    }
                    comment.clear();
                    attributes.clear();
                }
            }
        }
        Self { structures, is_record: false }
    }

    /// Turns the types into those of records that are written: keys without a value are null, and unknown types, such
    /// as enumerations and types of other libraries, accept anything.
    #[must_use]
    pub fn records(mut self) -> Self {
        self.is_record = true;
        self
    }

    /// Whether the types are those of records that are written.
    #[must_use]
    pub const fn is_record(&self) -> bool {
        self.is_record
    }

    /// Returns the table of the structure at `place`.
    ///
    /// # Errors
    /// Message about an unknown structure, or about a field of unknown type.
    pub fn table(&self, place: &Place) -> Result<Table, String> {
        let structure = self.structures.get(place).ok_or_else(|| format!("no structure {} in {}", place.1, place.0))?;
        let mut keys = Vec::new();
        for field in &structure.fields {
            if field.is_flattened {
                if let Shape::Table(inner) = self.shape(&field.kind, &place.0)? {
                    // A key that the structure has of its own is not that of the flattened one.
                    let others = self.table(&inner)?.keys.into_iter();
                    let others = others.filter(|key| structure.fields.iter().all(|field| field.name != key.name));
                    keys.extend(others);
                }
                continue;
            }
            let (kind, is_optional) = match inside(&field.kind, "Option") {
                Some(kind) => (kind, true),
                None => (field.kind.as_str(), field.has_default || structure.has_defaults),
            };
            keys.push(Key {
                name: field.name.clone(),
                shape: self.shape(kind, &place.0)?,
                is_required: !is_optional,
                meaning: field.comment.clone(),
            });
        }
        Ok(Table { meaning: structure.comment.clone(), keys })
    }

    /// Place of the structure called `name`: in `file`, or else a public one in another file.
    fn named(&self, name: &str, file: &str) -> Option<Place> {
        let own = (file.to_owned(), name.to_owned());
        if self.structures.contains_key(&own) {
            return Some(own);
        }
        let mut public = self.structures.iter().filter(|((_, other), found)| other == name && found.is_public);
        public.next().map(|(place, _)| place.clone())
    }

    fn shape(&self, kind: &str, file: &str) -> Result<Shape, String> {
        for wrapper in ["Spanned", "Box", "Option"] {
            if let Some(kind) = inside(kind, wrapper) {
                return self.shape(kind, file);
            }
        }
        if let Some(kind) = inside(kind, "Vec") {
            let of = self.shape(kind, file)?;
            // An absent key says that nothing is there; an element of a list can only be null.
            let is_nullable = inside(kind, "Option").is_some();
            return Ok(Shape::List(Box::new(if is_nullable { Shape::OrNull(Box::new(of)) } else { of })));
        }
        if let Some(kind) = inside(kind, "PathOr") {
            return Ok(Shape::PathOr(Box::new(self.shape(kind, file)?)));
        }
        let list = |shape| Shape::List(Box::new(shape));
        Ok(match kind {
            "f64" | "Number" => Shape::Number,
            "u64" | "u32" | "u8" | "usize" => Shape::Whole,
            "bool" => Shape::Flag,
            "String" | "Cow<'static, str>" => Shape::Text,
            "Numbers" => Shape::OneOrMore,
            "NumberList" | "[f64; 2]" => list(Shape::Number),
            "Value" | "Table" | "toml::Table" | "BTreeMap<String, Spanned<Value>>" => Shape::Any,
            _ => {
                let name = kind.rsplit("::").next().unwrap_or(kind);
                match self.named(name, file) {
                    Some(place) => Shape::Table(place),
                    None if self.is_record => Shape::Any,
                    None => return Err(format!("{file}: the type {kind} is not known")),
                }
            }
        })
    }
}

/// Returns `T` if `kind` is `wrapper<T>`.
fn inside<'a>(kind: &'a str, wrapper: &str) -> Option<&'a str> {
    kind.strip_prefix(wrapper)?.strip_prefix('<')?.strip_suffix('>')
}

impl Key {
    /// Default of the key according to its description: the words before "when absent".
    #[must_use]
    pub fn default(&self) -> Option<&str> {
        let before = self.meaning.split(" when absent").next().filter(|before| before.len() < self.meaning.len())?;
        Some(before.rsplit("; ").next().unwrap_or(before))
    }

    /// Unit given by the name of the key; empty for pure numbers and for other kinds of values.
    #[must_use]
    pub fn unit(&self) -> &'static str {
        const UNITS: [(&str, &str); 19] = [
            ("_gw_cm2", "GW/cm²"),
            ("_j_cm2", "J/cm²"),
            ("_g_cm3", "g/cm³"),
            ("_mm_s", "mm/s"),
            ("_per_mm", "1/mm"),
            ("_gpa", "GPa"),
            ("_mpa", "MPa"),
            ("_pct", "%"),
            ("_deg", "°"),
            ("_um", "µm"),
            ("_mm", "mm"),
            ("_nm", "nm"),
            ("_ns", "ns"),
            ("_hz", "Hz"),
            ("seconds", "s"),
            ("_time_s", "s"),
            ("window_s", "s"),
            ("force_n", "N"),
            ("clearance_um", "µm"),
        ];
        let found = UNITS.into_iter().find(|(ending, _)| self.name.ends_with(ending));
        found.filter(|_| self.shape.is_of_numbers()).map_or("", |(_, unit)| unit)
    }
}

impl Shape {
    /// Names the kind of value in words.
    #[must_use]
    pub fn words(&self) -> String {
        match self {
            Self::Number => "number".to_owned(),
            Self::Whole => "whole number".to_owned(),
            Self::Flag => "true or false".to_owned(),
            Self::Text => "text".to_owned(),
            Self::Any => "anything".to_owned(),
            Self::OneOrMore => "number or list".to_owned(),
            Self::List(of) => match &**of {
                Self::Table(_) => "tables".to_owned(),
                Self::Number => "list of numbers".to_owned(),
                Self::Whole => "list of whole numbers".to_owned(),
                Self::Text => "list of texts".to_owned(),
                Self::OrNull(of) => format!("{}, or nulls", Self::List(of.clone()).words()),
                of => format!("list of: {}", of.words()),
            },
            Self::OrNull(of) => format!("{} or null", of.words()),
            Self::PathOr(_) => "path or table".to_owned(),
            Self::Table(_) => "table".to_owned(),
        }
    }

    /// Whether the value is a number, or a list of numbers, possibly nested.
    fn is_of_numbers(&self) -> bool {
        match self {
            Self::Number | Self::OneOrMore => true,
            Self::List(of) | Self::OrNull(of) => of.is_of_numbers(),
            _ => false,
        }
    }

    /// Place of the structure of a table, or of the tables in a list.
    #[must_use]
    pub fn table(&self) -> Option<&Place> {
        match self {
            Self::Table(place) => Some(place),
            Self::List(of) | Self::OrNull(of) | Self::PathOr(of) => of.table(),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCE: &str = "/// A thing.\n#[derive(Clone, Deserialize)]\nstruct ThingFile {\n    /// How wide it\n    /// is; 3 when absent.\n    \
                          #[serde(default)]\n    pub width_um: Option<Number>,\n    parts: Spanned<Vec<Spanned<PartFile>>>,\n}\n\
                          #[derive(Deserialize)]\npub struct PartFile {\n    /// Widths.\n    width_um: Numbers,\n}\n\
                          #[derive(Debug)]\nstruct Other {\n    x: Strange,\n}\n";

    #[test]
    fn fields_are_keys_with_their_meaning_default_and_unit() {
        let types = Types::new([("a.rs", SOURCE)]);
        let place = |name: &str| ("a.rs".to_owned(), name.to_owned());
        let table = types.table(&place("ThingFile")).unwrap();
        assert_eq!(table.meaning, "A thing.");
        let [width, parts] = &table.keys[..] else { panic!("{table:?}") };
        assert_eq!((width.default(), width.unit(), width.is_required), (Some("3"), "µm", false));
        assert_eq!(width.meaning, "How wide it is; 3 when absent.");
        assert_eq!(parts.shape.table(), Some(&place("PartFile")));
        assert!(parts.is_required && types.table(&place("PartFile")).unwrap().keys[0].meaning == "Widths.");
        assert!(types.table(&place("Other")).is_err());
    }

    #[test]
    fn a_type_that_is_not_known_is_refused() {
        let types = Types::new([("a.rs", "#[derive(Deserialize)]\nstruct A {\n    x: Strange,\n}\n")]);
        let refused = types.table(&("a.rs".to_owned(), "A".to_owned())).unwrap_err();
        assert!(refused.contains("Strange"), "{refused}");
    }
}
