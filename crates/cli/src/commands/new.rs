//! `new`: a commented file to start from.

use std::path::Path;

use crate::args::{NewArgs, TemplateName};
use crate::diagnostic::Diagnostic;
use crate::output::{Outputs, write_file};
use crate::{CliError, Console, exit_code};

const SCENE: &str = include_str!("../templates/scene.toml");
const DESIGN: &str = include_str!("../templates/design.toml");
const CALIBRATION: &str = include_str!("../templates/calibration.toml");
const FLAT: &str = include_str!("../templates/flat.csv");

/// Writes the template; nothing that exists is replaced.
pub fn run(args: &NewArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let usual = match args.template {
        TemplateName::Scene => "scene.toml",
        TemplateName::Design => "design.toml",
        TemplateName::Calibration => "calibration",
    };
    let path = args.path.as_deref().unwrap_or(Path::new(usual));
    if path.exists() {
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
            files.write(path)?;
        }
    }
    let next = match args.template {
        TemplateName::Scene => format!("slipgrid simulate {}", path.display()),
        TemplateName::Design => format!("slipgrid optimize {}", path.display()),
        TemplateName::Calibration => format!("slipgrid calibrate {}", path.join("calibration.toml").display()),
    };
    writeln!(console.out, "{}", path.display())?;
    console.note(&format!("next: {next}"));
    Ok(exit_code::DONE)
}
