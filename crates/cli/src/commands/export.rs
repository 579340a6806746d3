//! `export`: writes the design of a result in other formats.

use std::path::Path;

use crate::args::ExportArgs;
use crate::output::{Place, ResultFolder, add};
use crate::{CliError, Console};
use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::records::SCHEMA;
use slipgrid_design::{StoredDesign, StoredError};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::file_kind::FileKind;
use slipgrid_io::formats::source::read_text;
use slipgrid_io::formats::stored_pattern::{stored_pattern, stored_specimen};
use slipgrid_report::{DrawingInput, Outputs, draw_with};

/// Name of the result file in its folder.
const RESULT: &str = "result.json";

/// Patterns of the names of files that this command may write.
const FILES: [&str; 6] = ["pattern.*", "process.toml", "corners.csv", "hatch.csv", "height-map.png", "removed.stl"];

/// Writes the design in the requested formats.
pub fn run(args: &ExportArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    // A folder written by `optimize` stands for the result in it.
    let inside = args.result.join(RESULT);
    let result = if inside.is_file() { &inside } else { &args.result };
    let folder = args.output.as_deref().or(result.parent()).unwrap_or(Path::new("."));
    let out = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let place = ResultFolder::open(Place::output(out), &FILES, std::slice::from_ref(result))?;
    let stored = read(result, args.sample)?;
    let refuse = |reason: String| Diagnostic::file(result, reason);
    let pattern = stored_pattern(result, &stored.design)?;
    let outline = stored_specimen(result, &stored.specimen)?;
    let mut input = DrawingInput { pattern, outline, about: stored.about };
    input.about.made_by.schema = slipgrid_design::results::SCHEMA;
    let pixel_um = args.pixel_um.filter(|&pixel_um| LENGTH_UM.accepts(pixel_um));
    if let Some(refused) = args.pixel_um.filter(|_| pixel_um.is_none()) {
        let refused = Diagnostic::flag("--pixel-um", refused.to_string(), "is out of range");
        return Err(refused.expected(LENGTH_UM.to_string()).into());
    }
    // A pattern that the laser cannot make is not drawn.
    input.about.laser.check(&pattern).map_err(|error| refuse(error.to_string()))?;
    let mut outputs = Outputs::default();
    let unwritten =
        draw_with(&input, &args.format, pixel_um, &mut outputs).map_err(|error| refuse(error.to_string()))?;
    let said = unwritten.iter().map(|one| format!("\n  {one}")).collect::<String>();
    let of = unwritten.len() + outputs.names().len();
    let said = format!("{}: {} of {of} formats cannot be written:{said}", result.display(), unwritten.len());
    if outputs.names().is_empty() {
        return Err(CliError::Inputs(said));
    }
    add(&outputs, &place)?;
    for name in outputs.names() {
        console.answer(&format!("{}\n", folder.join(name).display()))?;
    }
    if unwritten.is_empty() { Ok(()) } else { Err(CliError::Other(said)) }
}

fn read(path: &Path, sample: Option<usize>) -> Result<StoredDesign, Diagnostic> {
    if path.is_dir() {
        return Err(Diagnostic::file(path, "is a folder without result.json").expected(FileKind::Result.expected()));
    }
    let text = read_text(&disk(), path, FileKind::Result.expected())?;
    FileKind::Result.require(path, &text)?;
    let stored = StoredDesign::read(&text, sample).map_err(|error| {
        let refused = Diagnostic::file(path, error.to_string());
        let line = match &error {
            StoredError::Optimize(error) | StoredError::Next(error) => u32::try_from(error.line()).ok(),
            StoredError::Another(_) => return refused.expected(FileKind::Result.expected()),
            _ => None,
        };
        Diagnostic { line: line.filter(|&line| line > 0), ..refused }
    })?;
    let schema = stored.about.made_by.schema;
    if schema > SCHEMA {
        let refused = Diagnostic::file(path, format!("has schema {schema}, of a later slipgrid"));
        return Err(refused.expected(format!("a schema up to {SCHEMA}")));
    }
    Ok(stored)
}
