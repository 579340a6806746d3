//! `[made_from]` of a material file: the calibration from which the material was made, so that a later change of the
//! calibration is noticed.

use std::path::{Component, Path, PathBuf};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::formats::calibration::Calibration;
use crate::formats::source::{Entry, Source};
use crate::formats::{Diagnostic, Document};

/// Number of bytes of a fingerprint, written as two hexadecimal digits each. Two calibrations share a fingerprint with
/// a probability of 1 in 10^19.
const BYTES: usize = 8;

/// The calibration from which a material was made.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MadeFrom {
    /// Path of the calibration file, relative to the folder of the material file.
    calibration: String,
    /// Tables that the calibration names: of flat samples, patterned samples and trials.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    tables: Vec<String>,
    /// Fingerprint of the contents of calibration file and tables; maps and traces are not included.
    fingerprint: String,
}

impl MadeFrom {
    /// Record of the `calibration` from `path` for the material file at `output`; `None` if no relative path leads from
    /// the folder of `output` to the calibration or a table, or if a file cannot be read.
    pub fn new(calibration: &Calibration, path: &Path, output: &Path, files: &Source) -> Option<Self> {
        let folder = output.parent().unwrap_or_else(|| Path::new(""));
        let name = |file: &Path| {
            relative(folder, file).or_else(|| relative(&canonical(folder, files), &files.canonical(file)))
        };
        let tables = calibration.tables.iter();
        let fingerprint = fingerprint(std::iter::once(path).chain(tables.clone().map(AsRef::as_ref)), files)?;
        Some(Self {
            calibration: name(path)?,
            tables: tables.map(|table| name(table)).collect::<Option<_>>()?,
            fingerprint,
        })
    }

    /// Warns that the calibration of the material `document` has changed since it was fitted; `None` if the calibration
    /// has not changed or no longer exists.
    pub fn changed(&self, document: &Document) -> Option<Diagnostic> {
        let (files, path) = (document.source(), document.resolve(&self.calibration));
        files.entry(&path).ok().filter(|entry| *entry == Entry::File)?;
        let tables: Vec<_> = self.tables.iter().map(|table| document.resolve(table)).collect();
        let now = fingerprint(std::iter::once(path.as_path()).chain(tables.iter().map(AsRef::as_ref)), files);
        if now.as_ref() == Some(&self.fingerprint) {
            return None;
        }
        let (calibration, material) = (path.display(), document.path().display());
        let reason = format!(
            "was made from {calibration}, which has changed since, or a table that it names: what was added, as a trial, does not count. Run \
             slipgrid calibrate {calibration} -o {material} again"
        );
        Some(Diagnostic::file(document.path(), reason))
    }
}

/// Canonical path of a `folder` that may not exist yet, from its nearest existing parent.
fn canonical(folder: &Path, files: &Source) -> PathBuf {
    let here = |folder: &Path| if folder.as_os_str().is_empty() { Path::new(".").into() } else { folder.to_owned() };
    let there = folder.ancestors().find(|part| files.entry(&here(part)).is_ok()).unwrap_or(folder);
    let rest = folder.strip_prefix(there).unwrap_or_else(|_| Path::new(""));
    files.canonical(&here(there)).join(rest)
}

/// Fingerprint of the contents of `paths`, each preceded by its length; `None` if a file cannot be read.
fn fingerprint<'a>(paths: impl Iterator<Item = &'a Path>, files: &Source) -> Option<String> {
    let mut hash = Sha256::new();
    for path in paths {
        let bytes = files.read(path).ok()?;
        hash.update((bytes.len() as u64).to_le_bytes());
        hash.update(bytes);
    }
    Some(hash.finalize().iter().take(BYTES).map(|byte| format!("{byte:02x}")).collect())
}

/// Relative path from `folder` to `path`, computed without access to files; `None` if only one of the two is absolute,
/// if they share no folder but the root, or if `folder` leads through `..`.
fn relative(folder: &Path, path: &Path) -> Option<String> {
    if folder.is_absolute() != path.is_absolute() {
        return None;
    }
    let named = |path: &'_ Path| -> Vec<String> {
        let parts = path.components().filter(|part| !matches!(part, Component::CurDir));
        parts.map(|part| part.as_os_str().to_string_lossy().into_owned()).collect()
    };
    let (from, to) = (named(folder), named(path));
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if folder.is_absolute() && common < 2 || from[common..].iter().any(|part| part == "..") {
        return None;
    }
    let up = std::iter::repeat_n("..", from.len() - common);
    Some(up.chain(to[common..].iter().map(String::as_str)).collect::<Vec<_>>().join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_way_from_folder_to_file_names_nothing_beyond_what_they_share() {
        for (folder, path, way) in [
            ("", "my/calibration.toml", Some("my/calibration.toml")),
            ("my", "my/calibration.toml", Some("calibration.toml")),
            ("./out/m", "my/a.csv", Some("../../my/a.csv")),
            ("my", "my/../out/b.csv", Some("../out/b.csv")),
            ("../m", "a.toml", None),
            ("", "/home/x/a.toml", None),
            ("/home/x/m", "/home/x/c/a.toml", Some("../c/a.toml")),
            ("/srv/m", "/home/x/a.toml", None),
        ] {
            assert_eq!(relative(Path::new(folder), Path::new(path)).as_deref(), way, "{folder} {path}");
        }
    }
}
