//! `new`: writes a commented template file.

use std::path::Path;

use crate::args::{NewArgs, TemplateName};
use crate::output::{Place, ResultFolder, add, quoted, write_file};
use crate::{CliError, Console, exit_code};
use slipgrid_io::formats::Diagnostic;
use slipgrid_report::Outputs;

const SCENE: &str = include_str!("../templates/scene.toml");
const DESIGN: &str = include_str!("../templates/design.toml");
const CALIBRATION: &str = include_str!("../templates/calibration.toml");
const FLAT: &str = include_str!("../templates/flat.csv");

/// Writes the requested template; never replaces an existing file.
pub fn run(args: &NewArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let usual = match args.template {
        TemplateName::Scene => "scene.toml",
        TemplateName::Design => "design.toml",
        TemplateName::Calibration => "calibration",
    };
    let path = args.path.as_deref().unwrap_or(Path::new(usual));
    if path.exists() || path.is_symlink() {
        let refused = Diagnostic::flag("new", path.display().to_string(), "exists already");
        return Err(refused.expected("a name that is free").into());
    }
    match args.template {
        TemplateName::Scene => write_file(path, SCENE.as_bytes())?,
        TemplateName::Design => write_file(path, DESIGN.as_bytes())?,
        TemplateName::Calibration => {
            let mut files = Outputs::default();
            files.add("calibration.toml", CALIBRATION);
            files.add("flat.csv", FLAT);
            add(&files, &ResultFolder::open(Place { flag: "new", path }, &[], &[])?)?;
        }
    }
    let (command, file) = match args.template {
        TemplateName::Scene => ("simulate", path.to_owned()),
        TemplateName::Design => ("optimize", path.to_owned()),
        TemplateName::Calibration => ("calibrate", path.join("calibration.toml")),
    };
    console.answer(&format!("{}\n", path.display()))?;
    console.note(&format!("next: slipgrid {command} {}", quoted(&file)));
    Ok(exit_code::DONE)
}
