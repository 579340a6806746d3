//! The files that a laser takes, from a design to bytes.

use slipgrid_export::{
    ExportError, Heading, Laser, Layout, MaterialNote, Outline, ProcessInput, ProcessSheet, csv, dxf, svg,
};
use slipgrid_pattern::Pattern;

use crate::args::ExportFormat;
use crate::output::Outputs;
use crate::report::simulation::MaterialReport;

/// What the files say beside the pattern.
pub struct DrawingInput<'a> {
    /// Name of the design.
    pub name: &'a str,
    /// Version that made it.
    pub version: &'a str,
    /// Seed that made it.
    pub seed: u64,
    /// The pattern.
    pub pattern: Pattern,
    /// The specimen.
    pub outline: Outline,
    /// The laser.
    pub laser: Laser,
    /// The material.
    pub material: &'a MaterialReport,
}

/// Adds the pattern's files in `formats` to `outputs`.
///
/// # Errors
/// [`ExportError`] if no cavity fits on the specimen, or far too many.
pub fn draw(input: &DrawingInput<'_>, formats: &[ExportFormat], outputs: &mut Outputs) -> Result<(), ExportError> {
    let layout = Layout::new(input.pattern, input.outline)?;
    let mut notes = Vec::new();
    if input.material.synthetic_surface {
        notes.push("the area law behind this design rests on a synthetic surface");
    }
    let heading = Heading { name: input.name, version: input.version, notes: &notes };
    for format in formats {
        match format {
            ExportFormat::Dxf => outputs.add("pattern.dxf", dxf(&layout, &heading)),
            ExportFormat::Svg => outputs.add("pattern.svg", svg(&layout, &heading)),
            ExportFormat::Csv => {
                outputs.add("pattern.csv", csv(&layout, input.laser.bursts(input.pattern.depth_m())));
            }
            ExportFormat::Process => {
                let sheet = ProcessSheet::new(
                    &layout,
                    ProcessInput {
                        name: input.name.to_owned(),
                        version: input.version.to_owned(),
                        seed: input.seed,
                        laser: input.laser,
                        tolerances: None,
                        material: MaterialNote {
                            name: input.material.name.clone(),
                            source: input.material.source.clone(),
                            synthetic_surface: input.material.synthetic_surface,
                        },
                    },
                )?;
                outputs.add("process.toml", sheet.to_toml()?);
            }
        }
    }
    Ok(())
}
