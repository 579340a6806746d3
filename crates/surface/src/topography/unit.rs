use std::str::FromStr;

/// A unit of length, as named in files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LengthUnit {
    /// Metre, `m`.
    Metre,
    /// Centimetre, `cm`.
    Centimetre,
    /// Millimetre, `mm`.
    Millimetre,
    /// Micrometre, `um` (also with the micro sign or the Greek letter).
    Micrometre,
    /// Nanometre, `nm`.
    Nanometre,
    /// Picometre, `pm`.
    Picometre,
}

/// Names of the accepted units, as a literal for `concat!`.
macro_rules! unit_names {
    () => {
        "m, cm, mm, um, nm, pm"
    };
}
pub(crate) use unit_names;

slipgrid_base::names!(LengthUnit {
    Metre = "m",
    Centimetre = "cm",
    Millimetre = "mm",
    Micrometre = "um",
    Nanometre = "nm",
    Picometre = "pm",
});

impl LengthUnit {
    /// Accepted names of units, for messages.
    pub const NAMES: &'static str = unit_names!();

    /// Number of these units in a metre: a power of ten and therefore exact.
    pub const fn per_metre(self) -> f64 {
        [1.0, 1e2, 1e3, 1e6, 1e9, 1e12][self as usize]
    }

    /// Converts `value` from this unit to metres, correctly rounded.
    pub fn to_metres(self, value: f64) -> f64 {
        value / self.per_metre()
    }
}

/// A name that is not a unit of length.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("\"{name}\" is no unit of length: expected one of {names}", names = LengthUnit::NAMES)]
pub struct UnknownUnit {
    /// The name given.
    pub name: String,
}

impl FromStr for LengthUnit {
    type Err = UnknownUnit;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        // The micro sign U+00B5 and the Greek mu U+03BC look alike; files use both.
        let plain = name.trim().replace(['\u{b5}', '\u{3bc}'], "u");
        Self::ALL
            .into_iter()
            .find(|unit| unit.name() == plain)
            .ok_or_else(|| UnknownUnit { name: name.chars().take(40).collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back_and_so_do_both_mus() {
        for unit in LengthUnit::ALL {
            assert_eq!(unit.name().parse::<LengthUnit>().unwrap(), unit);
        }
        for micro in ["\u{b5}m", "\u{3bc}m", " um "] {
            assert_eq!(micro.parse::<LengthUnit>().unwrap(), LengthUnit::Micrometre);
        }
        assert!("inch".parse::<LengthUnit>().unwrap_err().to_string().contains("one of m, cm"));
        assert!("".parse::<LengthUnit>().is_err());
    }
}
