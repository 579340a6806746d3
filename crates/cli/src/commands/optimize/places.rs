//! Where results and kept answers of a design go.

use std::path::{Path, PathBuf};

/// out/NAME for designs/NAME.toml; out/design where NAME has nothing but dots.
#[must_use]
pub fn default_folder(design: &Path) -> PathBuf {
    let stem = design.file_name().map(Path::new).and_then(Path::file_stem);
    let named = stem.filter(|stem| !stem.to_string_lossy().trim_start_matches('.').is_empty());
    let named = named.filter(|stem| !stem.eq_ignore_ascii_case(".toml"));
    PathBuf::from("out").join(named.unwrap_or_else(|| "design".as_ref()))
}

/// The study's file, beside the folder of results: out/NAME.study.jsonl.
#[must_use]
pub fn study_path(folder: &Path) -> PathBuf {
    beside(folder, ".study.jsonl")
}

fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.file_name().map_or_else(|| "design".into(), std::ffi::OsStr::to_os_string);
    name.push(ending);
    match folder.file_name() {
        Some(_) => folder.with_file_name(name),
        // `.` and `..` have no name to put another beside.
        None => folder.join(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
            assert_eq!(default_folder(Path::new(design)), Path::new(folder), "{design}");
        }
        assert_eq!(study_path(Path::new("out/a")), Path::new("out/a.study.jsonl"));
        assert_eq!(study_path(Path::new("..")), Path::new("../design.study.jsonl"));
    }
}
