//! Paths of a design's results and of its study.

use std::path::{Path, PathBuf};

use slipgrid_design::Advice;

use crate::output::quoted;

/// Default folder of results: out/NAME and `suffix` for designs/NAME.toml; out/design if NAME consists of dots.
pub fn default_folder(design: &Path, suffix: &str) -> PathBuf {
    let stem = design.file_name().map(Path::new).and_then(Path::file_stem);
    let named = stem.filter(|stem| !stem.to_string_lossy().trim_start_matches('.').is_empty());
    let named = named.filter(|stem| !stem.eq_ignore_ascii_case(".toml"));
    let mut name = named.unwrap_or_else(|| "design".as_ref()).to_os_string();
    name.push(suffix);
    PathBuf::from("out").join(name)
}

/// Path of the study file, next to the folder of results: out/NAME.study.jsonl.
pub fn study_path(folder: &Path) -> PathBuf {
    let mut name = folder.file_name().map_or_else(|| "design".into(), std::ffi::OsStr::to_os_string);
    name.push(".study.jsonl");
    match folder.file_name() {
        Some(_) => folder.with_file_name(name),
        // `.` and `..` have no file name, so the file goes inside the folder.
        None => folder.join(name),
    }
}

/// Message with the paths of the report and the laser's files in `folder`, and with the next steps. `command` repeats
/// the search.
pub fn written(command: &str, calibration: Option<&Path>, folder: &Path, advice: &Advice) -> String {
    let at = |name: &str| quoted(&folder.join(name));
    let mut text = format!("\nreport  {}\n", at("report.html"));
    if *advice != Advice::DoNotTexture {
        text += &format!("laser   {}, {}\n", at("pattern.dxf"), at("process.toml"));
    }
    match advice {
        Advice::Trial => {
            // A material file has the trials of the day on which it was made.
            let without = "its calibration,\n        make the material anew: slipgrid calibrate CALIBRATION.toml -o MATERIAL.toml";
            let ledger = calibration.map_or_else(|| without.to_owned(), |path| quoted(&shortened(path)));
            text + &format!("next    cut it, measure it, add it as [[trial]] to {ledger},\n        then: {command}\n")
        }
        Advice::TrialMeetsIt { is_best: true, .. } => text + "next    make the trial's texture\n",
        Advice::TrialMeetsIt { is_best: false, .. } => {
            text + "next    make the trial's texture; to come closer, cut pattern.dxf as another trial\n"
        }
        Advice::CannotBeMet { keeps_limits: false } => text + "next    accept another limit, or widen a bound\n",
        Advice::CannotBeMet { keeps_limits: true } => {
            text + "next    accept more, widen a bound or a limit, or cut pattern.dxf, the likeliest, as a trial\n"
        }
        Advice::MeasureAgain { .. } => {
            text + &format!("next    measure both again, and their dimensions, or take one out; then: {command}\n")
        }
        Advice::Series | Advice::DoNotTexture => text,
    }
}

/// Shortens a `path` below the current folder: designs/../materials/a.toml becomes materials/a.toml.
fn shortened(path: &Path) -> PathBuf {
    let below = || Some(path.canonicalize().ok()?.strip_prefix(std::env::current_dir().ok()?).ok()?.to_owned());
    below().unwrap_or_else(|| path.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_trial_goes_on_with_its_calibration() {
        let of = |advice: &Advice| {
            written("slipgrid optimize 'a b.toml'", Some(Path::new("c.toml")), Path::new("out/a"), advice)
        };
        assert_eq!(
            of(&Advice::Trial),
            "\nreport  out/a/report.html\nlaser   out/a/pattern.dxf, out/a/process.toml\n\
             next    cut it, measure it, add it as [[trial]] to c.toml,\n        then: slipgrid optimize 'a b.toml'\n"
        );
        for (is_best, next) in
            [(false, "make the trial's texture; to come closer"), (true, "make the trial's texture\n")]
        {
            let met = Advice::TrialMeetsIt { trial: "\"cut\"".into(), another: 0.8, is_best };
            assert!(of(&met).contains(&format!("\nnext    {next}")), "{}", of(&met));
        }
        assert_eq!(of(&Advice::DoNotTexture), "\nreport  out/a/report.html\n");
        let of_file = written("slipgrid optimize a.toml", None, Path::new("out/a"), &Advice::Trial);
        assert!(
            of_file.contains("to its calibration,\n        make the material anew: slipgrid calibrate"),
            "{of_file}"
        );
    }

    #[test]
    fn results_never_go_to_the_current_folder_by_themselves() {
        for (design, folder) in [
            ("designs/ldpe.toml", "out/ldpe"),
            ("a.b.toml", "out/a.b"),
            (".toml", "out/design"),
            ("..toml", "out/design"),
            ("...toml", "out/design"),
            ("/tmp/....toml", "out/design"),
            (".hidden.toml", "out/.hidden"),
            ("..", "out/design"),
        ] {
            assert_eq!(default_folder(Path::new(design), ""), Path::new(folder), "{design}");
        }
        assert_eq!(study_path(Path::new("out/a")), Path::new("out/a.study.jsonl"));
        assert_eq!(study_path(Path::new("..")), Path::new("../design.study.jsonl"));
    }
}
