//! `new`: a commented file to start from.

use std::path::Path;

use crate::args::{NewArgs, TemplateName};
use crate::output::write_file;
use crate::{CliError, Console, exit_code};
use slipgrid_formats::Diagnostic;
use slipgrid_report::Outputs;

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
            crate::output::write(&files, path)?;
        }
    }
    let (command, file) = match args.template {
        TemplateName::Scene => ("simulate", path.to_owned()),
        TemplateName::Design => ("optimize", path.to_owned()),
        TemplateName::Calibration => ("calibrate", path.join("calibration.toml")),
    };
    console.answer(&format!("{}\n", path.display()))?;
    console.note(&format!("next: slipgrid {command} {}", quoted(&file.to_string_lossy())));
    Ok(exit_code::DONE)
}

/// `path` as a shell takes it for one word: quoted if it holds anything that a shell would read otherwise.
fn quoted(path: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "/._-+,:@%".contains(letter);
    if cfg!(windows) {
        // Names there hold no double quotes.
        return if path.contains(' ') { format!("\"{path}\"") } else { path.to_owned() };
    }
    if path.chars().all(plain) { path.to_owned() } else { format!("'{}'", path.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(not(windows))]
    fn paths_are_one_word_of_a_shell() {
        for (path, word) in [
            ("my-material/calibration.toml", "my-material/calibration.toml"),
            ("polym\u{e8}re.toml", "polym\u{e8}re.toml"),
            ("my material.toml", "'my material.toml'"),
            ("Anna's (2).toml", r"'Anna'\''s (2).toml'"),
            ("a$b.toml", "'a$b.toml'"),
        ] {
            assert_eq!(quoted(path), word);
        }
    }
}
