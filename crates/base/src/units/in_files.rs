//! Serde forms of numbers in SI units, which files have in units of their own.
//!
//! `#[serde(rename = "length_um", with = "LengthUm")] length_m: f64` reads and writes micrometres. Ranges are checked by
//! readers, which know the lines of a file.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{HUMIDITY_PCT, LENGTH_UM, Quantity, SPEED_MM_S, STEP_NS};

/// Unit of a number or of an optional number in files.
pub trait InFiles {
    /// Quantity with the unit.
    const QUANTITY: Quantity;

    /// Reads a number and converts it to SI units.
    ///
    /// # Errors
    /// Errors of `deserializer`.
    fn deserialize<'de, T: From<f64>, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
        f64::deserialize(deserializer).map(|number| T::from(Self::QUANTITY.to_si(number)))
    }

    /// Writes `si` in the unit of files.
    ///
    /// # Errors
    /// Errors of `serializer`.
    fn serialize<T: Copy + Into<Option<f64>>, S: Serializer>(si: &T, serializer: S) -> Result<S::Ok, S::Error> {
        let si: Option<f64> = (*si).into();
        si.map(|si| Self::QUANTITY.from_si(si)).serialize(serializer)
    }
}

/// Micrometres for metres.
pub struct LengthUm;
/// Nanoseconds for seconds.
pub struct StepNs;
/// Millimetres per second for metres per second.
pub struct SpeedMmS;
/// Per cent for shares from 0 to 1.
pub struct HumidityPct;

impl InFiles for LengthUm {
    const QUANTITY: Quantity = LENGTH_UM;
}

impl InFiles for StepNs {
    const QUANTITY: Quantity = STEP_NS;
}

impl InFiles for SpeedMmS {
    const QUANTITY: Quantity = SPEED_MM_S;
}

impl InFiles for HumidityPct {
    const QUANTITY: Quantity = HUMIDITY_PCT;
}
