//! Paths that stay inside the folder.

use std::path::{Component, Path, PathBuf};

use axum::http::StatusCode;

use crate::error::Refused;

/// Longest path of a request, in bytes.
const MAX_BYTES: usize = 1000;

/// Parses the path of a file inside the current folder; the file need not exist.
///
/// # Errors
/// [`Refused`] for a path that leaves the folder, by itself or through a link, and for hidden files.
pub fn inside(text: &str) -> Result<PathBuf, Refused> {
    let refused = |reason: &str| Err(Refused(StatusCode::FORBIDDEN, format!("{text:?} {reason}")));
    if text.is_empty() || text.len() > MAX_BYTES || text.contains(['\0', '\\']) {
        return refused("is no path inside the folder");
    }
    let mut path = PathBuf::new();
    for part in Path::new(text).components() {
        match part {
            Component::CurDir => {}
            Component::Normal(name) if name.to_string_lossy().starts_with('.') => return refused("is hidden"),
            // A name with a colon is a drive or a stream of Windows.
            Component::Normal(name) if cfg!(windows) && name.to_string_lossy().contains(':') => {
                return refused("is no path inside the folder");
            }
            Component::Normal(name) => path.push(name),
            Component::ParentDir | Component::RootDir | Component::Prefix(_) => {
                return refused("leaves the folder");
            }
        }
    }
    let root = Path::new(".").canonicalize().map_err(|error| Refused::system(Path::new("."), &error))?;
    // A link inside the folder may point outside.
    let existing = path.ancestors().find(|above| above.symlink_metadata().is_ok());
    match existing.map(Path::canonicalize) {
        Some(Ok(real)) if !real.starts_with(&root) => refused("leaves the folder"),
        Some(Err(error)) => Err(Refused::system(&path, &error)),
        _ => Ok(path),
    }
}

/// Formats a path with slashes on all systems.
pub fn with_slashes(path: &Path) -> String {
    let parts = path.components().filter(|part| !matches!(part, Component::CurDir));
    parts.map(|part| part.as_os_str().to_string_lossy()).collect::<Vec<_>>().join("/")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_stay_inside() {
        for text in ["a.toml", "src/lib.rs", "./src/new/file.toml"] {
            assert!(inside(text).is_ok(), "{text}");
        }
        for text in
            ["", "/etc/passwd", "../Cargo.toml", "src/../../x", ".git/config", "a/.hidden", "a\0b", "..\\x", "a\\b"]
        {
            let refused = inside(text).map_err(|refused| refused.0);
            assert_eq!(refused, Err(StatusCode::FORBIDDEN), "{text}");
        }
        assert_eq!(with_slashes(&inside("./src/lib.rs").unwrap_or_default()), "src/lib.rs");
    }
}
