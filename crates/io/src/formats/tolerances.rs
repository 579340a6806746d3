//! `[tolerances]` of a design: scatter of manufactured samples about the design.

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_design::optimize::Tolerances;

use super::document::Document;
use super::values::Number;
use crate::formats::diagnostic::Diagnostic;
use slipgrid_base::units::{CORRELATION, LENGTH_STD_UM, LENGTH_UM, RIM_HEIGHT_UM};

/// The table in the form of a design file.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TolerancesFile {
    /// Standard deviation of a sample's mean width; 0 when absent.
    width_std_um: Option<Number>,
    /// Standard deviation of a sample's mean spacing; 0 when absent.
    spacing_std_um: Option<Number>,
    /// Standard deviation of a sample's mean depth; 0 when absent.
    depth_std_um: Option<Number>,
    /// Standard deviation of the mean height of a sample's rims; 0 when absent.
    pub(crate) rim_height_std_um: Option<Number>,
    /// Correlation of width and spacing, -1 where the pitch is exact; 0 when absent.
    width_spacing_correlation: Option<Number>,
}

/// Reads the table.
///
/// `largest_m` holds the largest width, spacing and depth within the bounds.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, or if a dimension scatters by more than its largest value within the
/// bounds.
pub fn read_tolerances(
    document: &Document,
    file: &TolerancesFile,
    largest_m: [f64; 3],
) -> Result<Tolerances, Diagnostic> {
    // Draws are normal, and a draw that is not positive is repeated: Phi(-1) = 16 % of draws if a dimension scatters by
    // as much as it measures. With larger scatter more draws are repeated, and the remaining cells are many times as
    // large as any within the bounds.
    let std_m = |std: &Option<Number>, name: &str, largest_m: f64| {
        let Some(written) = std else { return Ok(0.0) };
        let std_m = document.number(written, LENGTH_STD_UM)?;
        if std_m <= largest_m {
            return Ok(std_m);
        }
        let largest_um = LENGTH_UM.from_si(largest_m);
        let reason = format!(
            "is more than the largest {name} within the bounds: of any design, more than one sample in six would be drawn with no {name} \
             at all"
        );
        Err(document.refuse(written.span(), reason).expected(format!("at most {largest_um} um")))
    };
    let std_m = [
        std_m(&file.width_std_um, "width", largest_m[0])?,
        std_m(&file.spacing_std_um, "spacing", largest_m[1])?,
        std_m(&file.depth_std_um, "depth", largest_m[2])?,
    ];
    let correlation = document.optional(file.width_spacing_correlation.as_ref(), CORRELATION)?.unwrap_or(0.0);
    let rim_height_std_m = document.optional(file.rim_height_std_um.as_ref(), RIM_HEIGHT_UM)?.unwrap_or(0.0);
    Ok(Tolerances { std_m, width_spacing_correlation: correlation, rim_height_std_m })
}
