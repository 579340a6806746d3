//! What is explored: a design file as it is, or a material with bounds that a laser has.

use std::path::Path;

use crate::design::Design;
use crate::diagnostic::Diagnostic;
use crate::document::Document;
use crate::file_kind::FileKind;
use crate::source::Source;

/// What is asked of a material alone.
const OF_A_MATERIAL: &str = "[target]\nquantity = \"ratio\"\npressure_mpa = [0.65, 1.3, 1.95, 2.6]\ngoal = \"lowest\"\n\
    [bounds]\nwidth_um = [20.0, 400.0]\nspacing_um = [40.0, 1000.0]\ndepth_um = [2.0, 50.0]\n[pattern]\nplanform = \"groove\"\n\
    [specimen]\nshape = \"disc\"\ndiameter_mm = 10.0\n";

/// The design of the file at `path`; of a material or a calibration grooves of it.
///
/// # Errors
/// [`Diagnostic`] for a file that is refused, and for a material that needs more than a name.
pub fn explored(source: &Source, path: &Path) -> Result<Design, Diagnostic> {
    let read = Document::read_any(source, path, FileKind::Design)?;
    if !matches!(read.kind(), Some(FileKind::Material | FileKind::Calibration)) {
        read.require(FileKind::Design)?;
        return Design::from_document(read);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let text = format!("name = {:?}\nmaterial = {name:?}\n{OF_A_MATERIAL}", read.stem());
    let within = Document::within(source, path.with_file_name("explored.toml"), text);
    Design::from_document(within).map_err(|refused| refused.expected("a design file that says so"))
}
