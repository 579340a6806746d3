//! Errors of refused keys of records. A record is read without file positions; the reader of the file finds the line by
//! the key.

use std::fmt;

use crate::units::Quantity;

/// Key of a record, with the reason why its value was refused.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyError {
    /// Name of the key.
    pub key: &'static str,
    /// Reason of the refusal.
    pub refusal: Refusal,
}

/// Reason why a value was refused.
#[derive(Clone, Debug, PartialEq)]
pub enum Refusal {
    /// The number is outside the range of its quantity.
    OutOfRange {
        /// Number in the unit of the key.
        value: f64,
        /// Quantity of the key, with its unit and range.
        quantity: Quantity,
    },
    /// The name is not known.
    UnknownName {
        /// Name that was given.
        name: String,
        /// Known names.
        known: Vec<&'static str>,
    },
    /// The key is absent, but other keys need it.
    Missing,
    /// The value contradicts a rule.
    Rule {
        /// Reason, as the end of a sentence that begins with key and value.
        reason: String,
        /// Accepted values in words, if known.
        expected: Option<String>,
    },
}

impl KeyError {
    /// Creates the refusal of `key` for `reason`, with the `expected` values in words.
    pub fn rule(key: &'static str, reason: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { key, refusal: Refusal::Rule { reason: reason.into(), expected: Some(expected.into()) } }
    }

    /// Creates the refusal of `key` from `error`, with which the conversion of its value failed
    /// ([`Refusal::from_error`]).
    pub fn from_error(key: &'static str, error: &dyn fmt::Display) -> Self {
        Self { key, refusal: Refusal::from_error(error) }
    }

    /// Converts the number `value` of `key` to SI units.
    ///
    /// # Errors
    /// Error of [`Refusal::number`].
    pub fn number(key: &'static str, value: f64, quantity: Quantity) -> Result<f64, Self> {
        Refusal::number(value, quantity).map_err(|refusal| Self { key, refusal })
    }

    /// Selects the element of `all` that has the name `name`, the value of `key`; `name_of` gives the name of an
    /// element.
    ///
    /// # Errors
    /// Error of [`Refusal::choice`].
    pub fn choice<T: Copy>(
        key: &'static str,
        name: &str,
        all: &[T],
        name_of: impl Fn(T) -> &'static str,
    ) -> Result<T, Self> {
        Refusal::choice(name, all, name_of).map_err(|refusal| Self { key, refusal })
    }
}

impl Refusal {
    /// Creates a refusal from the message of `error`, in which the accepted values follow after ": expected ".
    pub fn from_error(error: &dyn fmt::Display) -> Self {
        let words = error.to_string();
        match words.split_once(": expected ") {
            Some((reason, expected)) => Self::Rule { reason: reason.to_owned(), expected: Some(expected.to_owned()) },
            None => Self::Rule { reason: words, expected: None },
        }
    }

    /// Converts the number `value` to SI units.
    ///
    /// # Errors
    /// [`Refusal::OutOfRange`] if `value` is not finite or outside the range of `quantity`.
    pub fn number(value: f64, quantity: Quantity) -> Result<f64, Self> {
        if quantity.accepts(value) { Ok(quantity.to_si(value)) } else { Err(Self::OutOfRange { value, quantity }) }
    }

    /// Selects the element of `all` whose name, as `name_of` gives it, is `name`.
    ///
    /// # Errors
    /// [`Refusal::UnknownName`] if no element has this name.
    pub fn choice<T: Copy>(name: &str, all: &[T], name_of: impl Fn(T) -> &'static str) -> Result<T, Self> {
        let found = all.iter().copied().find(|one| name_of(*one) == name);
        let known = || all.iter().map(|one| name_of(*one)).collect();
        found.ok_or_else(|| Self::UnknownName { name: name.to_owned(), known: known() })
    }

    /// Accepted values in words; `None` if unknown.
    pub fn expected(&self) -> Option<String> {
        match self {
            Self::OutOfRange { quantity, .. } => Some(quantity.to_string()),
            Self::UnknownName { known, .. } => Some(alternatives(known)),
            Self::Missing => None,
            Self::Rule { expected, .. } => expected.clone(),
        }
    }
}

/// Lists accepted `names` in quotes: `"left" or "right"`.
pub fn alternatives(names: &[&str]) -> String {
    names.iter().map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(" or ")
}

impl fmt::Display for Refusal {
    /// Writes the reason, as the end of a sentence that begins with key and value.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { .. } => f.write_str("is out of range"),
            Self::UnknownName { .. } => f.write_str("is not known"),
            Self::Missing => f.write_str("is missing"),
            Self::Rule { reason, .. } => f.write_str(reason),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::units::LENGTH_UM;

    #[test]
    fn refusals_say_what_is_wrong_and_what_is_accepted() {
        assert_eq!(KeyError::number("width_um", 130.0, LENGTH_UM), Ok(130e-6));
        let refused = KeyError::number("width_um", -1.0, LENGTH_UM).unwrap_err();
        assert_eq!((refused.key, refused.refusal.to_string()), ("width_um", "is out of range".to_owned()));
        assert_eq!(refused.refusal.expected(), Some(LENGTH_UM.to_string()));
        let choose = |name: &str| KeyError::choice("side", name, &[0, 1], |side| ["left", "right"][side]);
        assert_eq!(choose("right"), Ok(1));
        assert_eq!(choose("top").unwrap_err().refusal.expected().unwrap(), "\"left\" or \"right\"");
        let rule = KeyError::rule("depth_um", "is deeper than the layer", "a depth below 100 um");
        assert_eq!(rule.refusal.to_string(), "is deeper than the layer");
        assert_eq!(rule.refusal.expected().unwrap(), "a depth below 100 um");
        let error = KeyError::from_error("angle_deg", &"an angle of 100 degrees: expected 0 to 90");
        assert_eq!(error, KeyError::rule("angle_deg", "an angle of 100 degrees", "0 to 90"));
    }
}
