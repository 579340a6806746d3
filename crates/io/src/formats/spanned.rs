//! Values with their positions in a file.

use std::borrow::Cow;
use std::ops::Range;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// A value with its position in a TOML file, in bytes.
#[derive(Clone, Debug, Default)]
pub struct Spanned<T> {
    span: Range<usize>,
    value: T,
}

impl<T> Spanned<T> {
    /// Creates a `value` that stands at `span`.
    pub const fn new(span: Range<usize>, value: T) -> Self {
        Self { span, value }
    }

    /// Position of the value, in bytes.
    pub const fn span(&self) -> Range<usize> {
        self.span.start..self.span.end
    }

    /// Reference to the value.
    pub const fn get_ref(&self) -> &T {
        &self.value
    }

    /// Returns the value without its position.
    pub fn into_inner(self) -> T {
        self.value
    }
}

/// A value without a position, for files to be written.
impl<T> From<T> for Spanned<T> {
    fn from(value: T) -> Self {
        Self::new(0..0, value)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Spanned<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let read = toml::Spanned::deserialize(deserializer)?;
        Ok(Self { span: read.span(), value: read.into_inner() })
    }
}

impl<T: Serialize> Serialize for Spanned<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        self.value.serialize(serializer)
    }
}

/// The schema of the value.
impl<T: JsonSchema> JsonSchema for Spanned<T> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        T::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        generator.subschema_for::<T>()
    }
}
