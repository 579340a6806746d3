//! Serde adapters for numbers that are in SI units in memory and in other units in files.
//!
//! `#[serde(rename = "length_um", with = "LengthUm")] length_m: f64` reads and writes micrometres. Ranges are checked by
//! readers, which know the lines of a file.

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use super::{HUMIDITY_PCT, LENGTH_UM, Quantity, SPEED_MM_S, STEP_NS};

/// Serde adapter for a number, or an optional number, whose unit in files is not the SI unit.
pub trait InFiles {
    /// Quantity with the unit of files.
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

/// Metres in memory, micrometres in files.
pub struct LengthUm;
/// Seconds in memory, nanoseconds in files.
pub struct StepNs;
/// Metres per second in memory, millimetres per second in files.
pub struct SpeedMmS;
/// Fractions from 0 to 1 in memory, per cent in files.
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

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Run {
        #[serde(rename = "length_um", with = "LengthUm")]
        length_m: f64,
        #[serde(rename = "step_ns", with = "StepNs", default)]
        step_s: Option<f64>,
        #[serde(rename = "speed_mm_s", with = "SpeedMmS")]
        speed_m_s: f64,
        #[serde(rename = "humidity_pct", with = "HumidityPct")]
        humidity: f64,
    }

    #[test]
    fn numbers_of_files_are_read_in_si_units_and_written_as_they_were() {
        let file = json!({"length_um": 0.3, "step_ns": 6.7, "speed_mm_s": 2.3, "humidity_pct": 29.0});
        let run: Run = serde_json::from_value(file.clone()).unwrap();
        assert_eq!(run, Run { length_m: 0.3 / 1e6, step_s: Some(6.7 / 1e9), speed_m_s: 2.3 / 1e3, humidity: 0.29 });
        assert_eq!(serde_json::to_value(&run).unwrap(), file);
        let without = json!({"length_um": 1e7, "speed_mm_s": 1e5, "humidity_pct": 100.0});
        let run: Run = serde_json::from_value(without).unwrap();
        assert_eq!(run.step_s, None);
        // The ends of the ranges stay within them.
        assert!(LENGTH_UM.accepts(LENGTH_UM.from_si(run.length_m)) && HUMIDITY_PCT.accepts(HUMIDITY_PCT.from_si(1.0)));
        assert!(SPEED_MM_S.accepts(SPEED_MM_S.from_si(run.speed_m_s)));
    }
}
