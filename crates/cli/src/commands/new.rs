//! `new`: writes a commented template file.

use std::path::Path;

use crate::args::{NewArgs, TemplateName};
use crate::output::{Place, ResultFolder, add, quoted, write_file};
use crate::{CliError, Console};
use slipgrid_io::formats::Diagnostic;
use slipgrid_report::Outputs;

const SCENE: &str = include_str!("../templates/scene.toml");
const DESIGN: &str = include_str!("../templates/design.toml");
const CALIBRATION: &str = include_str!("../templates/calibration.toml");
const FLAT: &str = include_str!("../templates/flat.csv");

/// Writes the requested template; never replaces an existing file.
pub fn run(args: &NewArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let (usual, command, text) = match args.template {
        TemplateName::Scene => ("scene.toml", "simulate", SCENE),
        TemplateName::Design => ("design.toml", "optimize", DESIGN),
        TemplateName::Calibration => ("calibration", "calibrate", CALIBRATION),
    };
    let path = args.path.as_deref().unwrap_or(Path::new(usual));
    if path.exists() || path.is_symlink() {
        let refused = Diagnostic::flag("new", path.display().to_string(), "exists already");
        return Err(refused.expected("a name that is free").into());
    }
    let file = if args.template == TemplateName::Calibration {
        let mut files = Outputs::default();
        files.add("calibration.toml", text);
        files.add("flat.csv", FLAT);
        add(&files, &ResultFolder::open(Place { flag: "new", path }, &[], &[])?)?;
        path.join("calibration.toml")
    } else {
        write_file(path, text.as_bytes())?;
        path.to_owned()
    };
    console.answer(&format!("{}\n", path.display()))?;
    console.note(&format!("next: slipgrid {command} {}", quoted(&file)));
    Ok(())
}
