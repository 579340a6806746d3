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

/// The design of the file at `path`; of a material or a calibration grooves of it, at the `condition` of a speed in mm/s and a relative
/// humidity in per cent where that is given.
///
/// # Errors
/// [`Diagnostic`] for a file that is refused, for a material that needs a condition, and for a design with one of its own.
pub fn explored(source: &Source, path: &Path, condition: Option<[f64; 2]>) -> Result<Design, Diagnostic> {
    let read = Document::read_any(source, path, FileKind::Design)?;
    if !matches!(read.kind(), Some(FileKind::Material | FileKind::Calibration)) {
        read.require(FileKind::Design)?;
        if condition.is_some() {
            let reason = "names its own speed and humidity";
            return Err(Diagnostic::file(path, reason).expected("no --speed-mm-s and no --humidity-pct with a design"));
        }
        return Design::from_document(read);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let at = condition.map_or_else(String::new, |[speed_mm_s, humidity_pct]| {
        format!("condition = {{ speed_mm_s = {speed_mm_s}, humidity_pct = {humidity_pct} }}\n")
    });
    let text = format!("name = {:?}\nmaterial = {name:?}\n{at}{OF_A_MATERIAL}", read.stem());
    let within = Document::within(source, path.with_file_name("explored.toml"), text);
    // Nobody wrote the design that is refused: what is said is said of the material.
    let of_material = |refused: Diagnostic| {
        let expected = "--speed-mm-s and --humidity-pct, or a design file that says so";
        Diagnostic { file: Some(path.into()), line: None, key: None, value: None, ..refused }.expected(expected)
    };
    Design::from_document(within).map_err(of_material)
}
