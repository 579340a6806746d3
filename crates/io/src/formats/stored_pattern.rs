//! Reads the design of a result.json back as a pattern.

use std::path::Path;

use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::results::PatternReport;
use slipgrid_model::pattern::{Arrangement, Pattern, PatternError, Planform, Polygon, Texture};

use crate::formats::diagnostic::Diagnostic;

/// Pattern of the `design` in the result at `path`.
///
/// # Errors
/// [`Diagnostic`] at the key whose value gives no valid pattern.
pub fn stored_pattern(path: &Path, design: &PatternReport) -> Result<Pattern, Diagnostic> {
    let refuse = |key: &str, error: PatternError| Diagnostic {
        key: Some(format!("design.{key}").into()),
        ..Diagnostic::file(path, error.to_string())
    };
    let length = |key: &str, value: f64| {
        if LENGTH_UM.accepts(value) {
            return Ok(LENGTH_UM.to_si(value));
        }
        let key = Some(format!("design.{key}").into());
        let value = Some(value.to_string().into());
        Err(Diagnostic { key, value, ..Diagnostic::file(path, "is out of range") }.expected(LENGTH_UM.to_string()))
    };
    let planform: Planform = design.planform.parse().map_err(|error| refuse("planform", error))?;
    let mut texture = Texture::new(planform);
    if let Some(length_um) = design.length_um {
        let length_m = length("length_um", length_um)?;
        texture = texture.with_length_m(length_m).map_err(|error| refuse("length_um", error))?;
    }
    if let Some(vertices_um) = &design.vertices_um {
        let refused =
            |reason: String| Diagnostic { key: Some("design.vertices_um".into()), ..Diagnostic::file(path, reason) };
        let outline = Polygon::new(vertices_um).map_err(|error| refused(error.to_string()))?;
        texture = texture.with_outline(outline).map_err(|error| refuse("vertices_um", error))?;
    }
    if let Some(spacing_um) = design.spacing_across_um {
        let spacing_m = length("spacing_across_um", spacing_um)?;
        texture = texture.with_spacing_across_m(spacing_m).map_err(|error| refuse("spacing_across_um", error))?;
    }
    if let Some(name) = &design.arrangement {
        let arrangement: Result<Arrangement, PatternError> = name.parse();
        texture = arrangement
            .and_then(|arrangement| texture.with_arrangement(arrangement))
            .map_err(|error| refuse("arrangement", error))?;
    }
    if let Some(angle_deg) = design.angle_deg {
        texture = texture.with_groove_angle_deg(angle_deg).map_err(|error| refuse("angle_deg", error))?;
    }
    if let Some(angle_deg) = design.crossing_angle_deg {
        texture = texture.with_crossing_angle_deg(angle_deg).map_err(|error| refuse("crossing_angle_deg", error))?;
    }
    if let Some(angle_deg) = design.sliding_angle_deg {
        texture = texture.with_sliding_angle_deg(angle_deg).map_err(|error| refuse("sliding_angle_deg", error))?;
    }
    if let Some(rim) = &design.rim {
        texture = texture.with_rim(rim.rim().map_err(|(key, error)| refuse(key, error))?);
    }
    let (width_m, spacing_m, depth_m) = (
        length("width_um", design.width_um)?,
        length("spacing_um", design.spacing_um)?,
        length("depth_um", design.depth_um)?,
    );
    Pattern::new(texture, width_m, spacing_m, depth_m).map_err(|error| Diagnostic::file(path, error.to_string()))
}
