//! Input of `explore`: a design file, or a material or calibration, to which a default design is added.

use std::path::Path;

use crate::formats::design::Design;
use crate::formats::file_kind::FileKind;
use crate::formats::plausible::checked;
use crate::formats::source::Source;
use crate::formats::{Diagnostic, Document};
use slipgrid_base::units::{HUMIDITY_PCT, SPEED_MM_S};

/// Design for a material without a design file, as TOML without name, material and condition.
const OF_A_MATERIAL: &str = "[target]\nquantity = \"ratio\"\npressure_mpa = [0.65, 1.3, 1.95, 2.6]\ngoal = \"lowest\"\n\
    [bounds]\nwidth_um = [20.0, 400.0]\nspacing_um = [40.0, 1000.0]\ndepth_um = [2.0, 50.0]\n[pattern]\nplanform = \"groove\"\n\
    [specimen]\nshape = \"disc\"\ndiameter_mm = 10.0\n";

/// Reads the design to explore from the file at `path`. For a material or a calibration, returns a default design of
/// grooves at `condition`, a speed in mm/s and a relative humidity in per cent, if given.
///
/// # Errors
/// [`Diagnostic`] if a file is refused, if a material needs a condition, or if a condition is given with a design.
pub fn explored(source: &Source, path: &Path, condition: Option<[f64; 2]>) -> Result<Design, Diagnostic> {
    if let Some([speed_mm_s, humidity_pct]) = condition {
        checked("--speed-mm-s", speed_mm_s, SPEED_MM_S)?;
        checked("--humidity-pct", humidity_pct, HUMIDITY_PCT)?;
    }
    let read = Document::read_any(source, path, FileKind::Design)?;
    if !matches!(read.kind(), Some(FileKind::Material | FileKind::Calibration)) {
        read.require(FileKind::Design)?;
        let design = Design::from_document(read)?;
        if condition.is_none() {
            return Ok(design);
        }
        let reason = if design.task.ranges.is_empty() {
            "is a design without a condition, and --speed-mm-s and --humidity-pct are of a material alone"
        } else {
            "names its own speed and humidity"
        };
        return Err(Diagnostic::file(path, reason).expected("no --speed-mm-s and no --humidity-pct with a design"));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let at = condition.map_or_else(String::new, |[speed_mm_s, humidity_pct]| {
        format!("condition = {{ speed_mm_s = {speed_mm_s}, humidity_pct = {humidity_pct} }}\n")
    });
    let text = format!("name = {:?}\nmaterial = {name:?}\n{at}{OF_A_MATERIAL}", read.stem());
    let within = Document::within(source, path.with_file_name("explored.toml"), text);
    let made_up = within.path().to_owned();
    let mut design = Design::from_document(within).map_err(|refused| refused.of_material(&made_up, path))?;
    design.told = design.told.into_iter().map(|told| told.of_material(&made_up, path)).collect();
    design.stands_for = Some(path.to_owned());
    Ok(design)
}
