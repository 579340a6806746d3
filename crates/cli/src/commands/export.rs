//! `export`: a result's design in other formats.

use std::path::Path;

use slipgrid_pattern::{Pattern, Planform};

use super::drawings::{DrawingInput, draw};
use super::optimize::StoredDesign;
use crate::args::ExportArgs;
use crate::diagnostic::Diagnostic;
use crate::output::{Outputs, check_folder};
use crate::units::LENGTH_UM;
use crate::{CliError, Console, exit_code};

/// Writes the design again.
pub fn run(args: &ExportArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let folder = args.output.as_deref().or(args.result.parent()).unwrap_or(Path::new("."));
    check_folder(folder)?;
    let stored = read(&args.result)?;
    let refuse = |reason: String| Diagnostic::file(&args.result, reason);
    let length = |key: &str, value: f64| {
        if LENGTH_UM.accepts(value) {
            return Ok(LENGTH_UM.to_si(value));
        }
        let key = Some(format!("design.{key}").into());
        Err(Diagnostic { key, value: Some(value.to_string().into()), ..refuse("is out of range".into()) }
            .expected(LENGTH_UM.to_string()))
    };
    let design = &stored.design;
    let planform: Planform = design.planform.parse().map_err(|error: slipgrid_pattern::PatternError| Diagnostic {
        key: Some("design.planform".into()),
        ..refuse(error.to_string())
    })?;
    let pattern = Pattern::new(
        planform,
        length("width_um", design.width_um)?,
        length("spacing_um", design.spacing_um)?,
        length("depth_um", design.depth_um)?,
    )
    .map_err(|error| refuse(error.to_string()))?;
    let input = DrawingInput {
        name: &stored.name,
        version: &stored.version,
        seed: stored.seed,
        pattern,
        outline: stored.specimen.outline(),
        laser: stored.laser,
        material: &stored.material,
    };
    let mut outputs = Outputs::default();
    draw(&input, &args.format, &mut outputs).map_err(|error| refuse(error.to_string()))?;
    outputs.write(if folder.as_os_str().is_empty() { Path::new(".") } else { folder })?;
    for name in outputs.names() {
        writeln!(console.out, "{}", folder.join(name).display())?;
    }
    Ok(exit_code::DONE)
}

fn read(path: &Path) -> Result<StoredDesign, Diagnostic> {
    let text =
        std::fs::read_to_string(path).map_err(|error| Diagnostic::file(path, format!("cannot be read: {error}")))?;
    serde_json::from_str(&text).map_err(|error| {
        let refused = Diagnostic::file(path, format!("is not a result of `slipgrid optimize`: {error}"));
        Diagnostic { line: u32::try_from(error.line()).ok().filter(|&line| line > 0), ..refused }
    })
}
