//! Files of the folder that the studio works in: list, kinds, upload, download, and changes.

use std::collections::HashMap;
use std::fs;
use std::io::{Cursor, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use axum::body::Bytes;
use axum::extract::{Query, State};
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::http::{HeaderValue, StatusCode};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use slipgrid_design::results::VERSION;
use slipgrid_io::disk::put;
use slipgrid_io::formats::file_kind::{FileKind, TableKind};

use crate::Shared;
use crate::error::{Answer, Refused, aside};
use crate::jobs::locked;
use crate::places::{inside, with_slashes};

/// Maximum number of bytes of an uploaded file: a map of 4096 x 4096 points as text has 200 MB.
pub const MAX_UPLOAD: usize = 512 << 20;
/// Maximum number of files that are listed.
const MAX_FILES: usize = 5000;
/// Maximum depth of nested folders that are listed.
const MAX_DEPTH: usize = 6;
/// Maximum size, in bytes, of a TOML or JSON file whose kind is found by its content.
const MAX_TEXT: u64 = 2 << 20;
/// Interval at which the folder is checked for changes.
const WATCH_INTERVAL: Duration = Duration::from_secs(1);
/// Names of folders that are not listed, because they hold builds and packages, not data.
const SKIPPED: [&str; 3] = ["target", "node_modules", "__pycache__"];

/// Path in the query of a request.
#[derive(Deserialize)]
pub struct At {
    pub path: String,
}

/// A file of the folder.
#[derive(Debug, PartialEq, Serialize)]
pub struct Listed {
    path: String,
    bytes: u64,
    modified_ms: u64,
    kind: &'static str,
}

/// Kinds of files by path, with the size and time of change for which they were found.
pub type Kinds = HashMap<PathBuf, ((u64, u64), &'static str)>;

/// Lists the files of the folder.
pub async fn list(State(shared): State<Arc<Shared>>) -> Answer<Value> {
    aside(move || {
        let root = Path::new(".").canonicalize().map_err(|error| Refused::system(Path::new("."), &error))?;
        let root = root.display().to_string();
        let files = files_below(Path::new(""), &mut locked(&shared.kinds));
        Ok(json!({ "root": root, "version": VERSION, "files_at": shared.files_at, "files": files }))
    })
    .await
}

/// Files below a folder, sorted by path, without hidden files and links. Only files that changed since `kinds` were found
/// are opened.
fn files_below(folder: &Path, kinds: &mut Kinds) -> Vec<Listed> {
    let mut files = Vec::new();
    add_files(folder, 0, (&mut files, kinds));
    files.sort_by(|a: &Listed, b| a.path.cmp(&b.path));
    files
}

fn add_files(folder: &Path, depth: usize, (files, kinds): (&mut Vec<Listed>, &mut Kinds)) {
    let opened = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    for entry in fs::read_dir(opened).into_iter().flatten().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let Ok(kind) = entry.file_type() else { continue };
        if name.starts_with('.') || files.len() >= MAX_FILES {
            continue;
        }
        let path = folder.join(&name);
        if kind.is_dir() && depth < MAX_DEPTH && !SKIPPED.contains(&&name[..]) {
            add_files(&path, depth + 1, (files, kinds));
        } else if let Some(metadata) = entry.metadata().ok().filter(|_| kind.is_file()) {
            let own @ (bytes, modified_ms) = (metadata.len(), metadata.modified().map_or(0, milliseconds));
            let known = kinds.get(&path).filter(|(of, _)| *of == own).map(|(_, kind)| *kind);
            let kind = known.unwrap_or_else(|| kind_of(&path, bytes));
            files.push(Listed { path: with_slashes(&path), bytes, modified_ms, kind });
            kinds.insert(path, (own, kind));
        }
    }
}

fn milliseconds(time: SystemTime) -> u64 {
    time.duration_since(UNIX_EPOCH).map_or(0, |since| u64::try_from(since.as_millis()).unwrap_or(u64::MAX))
}

/// Extension of a path in lower case; empty without one.
fn extension_of(path: &Path) -> String {
    path.extension().map(|extension| extension.to_string_lossy().to_lowercase()).unwrap_or_default()
}

/// Kind of a file by its name and, for settings and results, by its content.
fn kind_of(path: &Path, bytes: u64) -> &'static str {
    match &extension_of(path)[..] {
        "toml" | "json" if bytes <= MAX_TEXT => fs::read_to_string(path).map_or("other", |text| kind_of_text(&text)),
        "csv" | "txt" | "dat" | "tsv" | "asc" if is_map(path) => "map",
        "csv" | "txt" | "dat" | "tsv" | "asc" => "table",
        "sur" | "sdf" | "x3p" | "gsf" | "npy" | "xyz" => "map",
        "html" => "page",
        "dxf" | "svg" => "drawing",
        _ => "other",
    }
}

/// Whether a text begins as an altitude map does.
fn is_map(path: &Path) -> bool {
    let mut start = Vec::new();
    // One byte more tells a start from a whole text.
    let read =
        fs::File::open(path).and_then(|file| file.take(TableKind::START_BYTES as u64 + 1).read_to_end(&mut start));
    read.is_ok() && TableKind::of(&String::from_utf8_lossy(&start)) == Some(TableKind::AltitudeMap)
}

/// Kind of a settings file or result by its content.
pub fn kind_of_text(text: &str) -> &'static str {
    match FileKind::of(text) {
        Some(FileKind::Calibration) => "calibration",
        Some(FileKind::Design) => "design",
        Some(FileKind::Material) => "material",
        Some(FileKind::Scene) => "scene",
        Some(FileKind::Campaign) => "campaign",
        Some(FileKind::Result) => "result",
        None => "other",
    }
}

/// Writes a new file. If a file with other content exists, it is kept and the request refused.
pub async fn upload(Query(at): Query<At>, bytes: Bytes) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        match fs::read(&path) {
            Ok(known) if known == bytes[..] => {}
            Ok(_) => {
                return Err(Refused::conflict(format!("{} exists with other content: rename one of the two", at.path)));
            }
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
                put(&path, &bytes).map_err(|error| Refused::system(&path, &error))?;
            }
            Err(error) => return Err(Refused::system(&path, &error)),
        }
        Ok(json!({ "path": with_slashes(&path), "kind": kind_of(&path, bytes.len() as u64) }))
    })
    .await
}

/// Query of a file's address: with `download` the browser saves the file instead of showing it.
#[derive(Deserialize)]
pub struct FileOptions {
    download: Option<String>,
}

/// Answers with the content of a file.
pub async fn file(
    axum::extract::Path((_, text)): axum::extract::Path<(String, String)>,
    Query(options): Query<FileOptions>,
) -> Result<Response, Refused> {
    let path = inside(&text)?;
    let read = tokio::task::spawn_blocking(move || {
        let bytes = fs::read(&path).map_err(|error| Refused::system(&path, &error))?;
        Ok::<_, Refused>((path, bytes))
    });
    let (path, bytes) = read.await??;
    let content_type = match &extension_of(&path)[..] {
        "html" => "text/html; charset=utf-8",
        "svg" => "image/svg+xml",
        "png" => "image/png",
        "json" => "application/json",
        "csv" | "toml" | "txt" | "md" => "text/plain; charset=utf-8",
        _ => "application/octet-stream",
    };
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(with_type(bytes, content_type, options.download.is_some().then_some(&name[..])))
}

/// Answer with `bytes` of a type, to be saved as `name` if given.
fn with_type(bytes: Vec<u8>, content_type: &'static str, name: Option<&str>) -> Response {
    let mut response = ([(CONTENT_TYPE, content_type)], bytes).into_response();
    if let Some(name) = name {
        // Letters beyond ASCII, quotes and control characters are not allowed in the plain form of the header.
        let plain: String =
            name.chars().map(|c| if c.is_ascii_alphanumeric() || "._-".contains(c) { c } else { '_' }).collect();
        if let Ok(value) = HeaderValue::from_str(&format!("attachment; filename=\"{plain}\"")) {
            response.headers_mut().insert(CONTENT_DISPOSITION, value);
        }
    }
    response
}

/// Answers with all files of a folder as one zip archive.
pub async fn zipped(Query(at): Query<At>) -> Result<Response, Refused> {
    let folder = inside(&at.path)?;
    let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let archive = tokio::task::spawn_blocking(move || archive(&folder)).await??;
    Ok(with_type(archive, "application/zip", Some(&format!("{name}.zip"))))
}

fn archive(folder: &Path) -> Result<Vec<u8>, Refused> {
    let files = files_below(folder, &mut Kinds::new());
    if files.is_empty() {
        return Err(Refused(StatusCode::NOT_FOUND, format!("{} has no files", folder.display())));
    }
    let failed = |reason: String| Refused(StatusCode::INTERNAL_SERVER_ERROR, reason);
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for file in files {
        let path = PathBuf::from(&file.path);
        let name = with_slashes(path.strip_prefix(folder).unwrap_or(&path));
        let bytes = fs::read(&path).map_err(|error| Refused::system(&path, &error))?;
        zip.start_file(name, zip::write::SimpleFileOptions::default()).map_err(|error| failed(error.to_string()))?;
        zip.write_all(&bytes).map_err(|error| failed(error.to_string()))?;
    }
    Ok(zip.finish().map_err(|error| failed(error.to_string()))?.into_inner())
}

/// Sends the event `folder` to open pages whenever files of the folder change, and notes when files with an old time
/// came; does not return.
pub async fn watch(shared: Arc<Shared>) {
    let mut known: Option<Vec<Listed>> = None;
    loop {
        tokio::time::sleep(WATCH_INTERVAL).await;
        // A folder that nobody looks at is not read.
        if !shared.jobs.is_watched() {
            continue;
        }
        let own = Arc::clone(&shared);
        let look = move || files_below(Path::new(""), &mut locked(&own.kinds));
        let Ok(now) = tokio::task::spawn_blocking(look).await else { continue };
        if known.as_ref() == Some(&now) {
            continue;
        }
        if let Some(before) = &known {
            let times: HashMap<&str, u64> = before.iter().map(|file| (&file.path[..], file.modified_ms)).collect();
            let here = SystemTime::now();
            let old_ms = milliseconds(here - 2 * WATCH_INTERVAL);
            let is_old = |of: &&Listed| of.modified_ms < old_ms && times.get(&of.path[..]) != Some(&of.modified_ms);
            locked(&shared.came).extend(now.iter().filter(is_old).map(|file| (file.path.clone(), here)));
        }
        // Also at the first look: a file may have changed since a page read the folder.
        shared.jobs.tell("folder", || json!({}));
        known = Some(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_files_that_changed_are_opened() {
        let folder = std::env::temp_dir().join(format!("slipgrid-kinds-{}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let path = folder.join("a.json");
        fs::write(&path, "{}").unwrap();
        let mut kinds = Kinds::new();
        let kind = |kinds: &mut Kinds| files_below(&folder, kinds)[0].kind;
        assert_eq!(kind(&mut kinds), "other");
        kinds.get_mut(&path).unwrap().1 = "known";
        assert_eq!(kind(&mut kinds), "known");
        fs::write(&path, "{ }").unwrap();
        assert_eq!(kind(&mut kinds), "other");
        fs::remove_dir_all(&folder).unwrap();
    }
}
