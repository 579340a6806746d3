//! Specimens that share a holder, and the force that each of them bears.

use crate::formats::diagnostic::Diagnostic;
use crate::formats::spanned::Spanned;

use super::calibration_file::MeasurementsFile;
use super::document::Document;

/// Maximum number of specimens in a holder.
pub const MAX_SPECIMENS: u32 = 100;

/// Meaning of a force in a table where a holder has several specimens.
#[derive(Clone, Copy, PartialEq, Eq)]
enum ForceIs {
    PerSample,
    Total,
}

impl ForceIs {
    const ALL: [Self; 2] = [Self::PerSample, Self::Total];

    const fn name(self) -> &'static str {
        match self {
            Self::PerSample => "per_sample",
            Self::Total => "total",
        }
    }
}

/// Reads the number of specimens in a holder.
///
/// # Errors
/// [`Diagnostic`] if it is 0 or more than any holder has.
pub(crate) fn read_count(document: &Document, given: &Spanned<u64>) -> Result<u32, Diagnostic> {
    u32::try_from(*given.get_ref()).ok().filter(|count| (1..=MAX_SPECIMENS).contains(count)).ok_or_else(|| {
        document
            .refuse(given.span(), "specimens are not held")
            .expected(format!("a whole number from 1 to {MAX_SPECIMENS}"))
    })
}

/// Number of specimens that a force in the tables presses: that of the holder if forces are totals.
///
/// # Errors
/// [`Diagnostic`] if the number or the meaning of a force is refused, or one is missing beside the other.
pub(crate) fn sharing_force(document: &Document, table: Option<&Spanned<MeasurementsFile>>) -> Result<u32, Diagnostic> {
    let Some(table) = table else { return Ok(1) };
    let MeasurementsFile { samples, force_is, .. } = table.get_ref();
    let force_is = force_is.as_ref().map(|name| document.choice(name, &ForceIs::ALL, ForceIs::name)).transpose()?;
    let count = samples.as_ref().map(|given| read_count(document, given)).transpose()?;
    match (samples, count, force_is) {
        (None, _, Some(ForceIs::Total)) => {
            Err(document.missing(table.span(), "samples").expected("the specimens in the holder"))
        }
        (Some(given), Some(2..), None) => Err(document
            .refuse(given.span(), "specimens share a force, or each bears it")
            .expected("force_is = \"per_sample\" or \"total\" beside samples")),
        (_, Some(count), Some(ForceIs::Total)) => Ok(count),
        _ => Ok(1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::calibration_file::CalibrationFile;

    #[test]
    fn a_total_force_presses_all_specimens_and_several_specimens_say_which_it_is() {
        let pressed = |keys: &str| {
            let text = format!(
                "name = \"a\"\nsource = \"b\"\n[material]\nyoungs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[specimen]\nradius_mm = 5.0\n\
                 [measurements]\n{keys}\n"
            );
            let document = Document::new("c.toml", text);
            let file: CalibrationFile = document.parse().map_err(|refused: Diagnostic| refused.to_string())?;
            sharing_force(&document, file.measurements.as_ref()).map_err(|refused| refused.to_string())
        };
        assert_eq!(pressed(""), Ok(1));
        assert_eq!(pressed("samples = 3\nforce_is = \"total\""), Ok(3));
        assert_eq!(pressed("samples = 3\nforce_is = \"per_sample\""), Ok(1));
        assert_eq!(pressed("samples = 1"), Ok(1));
        for (keys, expected) in [
            (
                "samples = 3",
                "c.toml:9: measurements.samples: 3 specimens share a force, or each bears it; expected force_is",
            ),
            (
                "samples = 0",
                "c.toml:9: measurements.samples: 0 specimens are not held; expected a whole number from 1 to 100",
            ),
            (
                "force_is = \"total\"",
                "c.toml:8: measurements.samples: is missing; expected the specimens in the holder",
            ),
            (
                "samples = 2\nforce_is = \"all\"",
                "c.toml:10: measurements.force_is: \"all\" is not known; expected \"per_sample\" or \"total\"",
            ),
        ] {
            let refused = pressed(keys).unwrap_err();
            assert!(refused.starts_with(expected), "{refused}");
        }
    }
}
