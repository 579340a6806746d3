//! Text files: read, checked, written and edited. Every form of the page shows the content of one file.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use axum::Json;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use slipgrid_io::disk::{disk, hexadecimal, put};
use slipgrid_io::formats::Document;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;
use slipgrid_io::formats::diagnostic::Diagnostic;
use slipgrid_io::formats::file_kind::FileKind;
use slipgrid_io::formats::run::Overrides;
use slipgrid_io::formats::scene::SceneInput;
use toml_edit::DocumentMut;

use crate::Shared;
use crate::error::{Answer, Refused, aside};
use crate::folder::{At, kind_of_text};
use crate::places::inside;

mod edits;

pub use edits::{Edit, apply_all};

/// Maximum number of bytes of a text.
const MAX_BYTES: u64 = 2 << 20;

/// Converts a message about a text, as on the command line, to JSON for the page.
pub fn message(diagnostic: &Diagnostic) -> Value {
    json!({
        "file": diagnostic.file.as_deref().map(|path| path.display().to_string()),
        "line": diagnostic.line,
        "key": diagnostic.key,
        "message": diagnostic.to_string(),
        "expected": diagnostic.expected,
        "suggestion": diagnostic.suggestion,
    })
}

/// A message as JSON without file, line and key.
fn remark(words: String) -> Value {
    message(&Diagnostic { reason: words, ..Diagnostic::default() })
}

/// Values of a TOML text; `None` if it does not parse.
fn values(text: &str) -> Option<Value> {
    serde_json::to_value(toml::from_str::<toml::Table>(text).ok()?).ok()
}

fn digest(text: &str) -> String {
    hexadecimal(&Sha256::digest(text))
}

/// Checks a text as the command that reads it does; returns errors and warnings as JSON.
fn checked(path: &Path, text: &str) -> Value {
    let is_toml = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"));
    if !is_toml {
        return json!({ "errors": [], "warnings": [] });
    }
    // A text that does not parse has the kind of the file before.
    let kind = FileKind::of(text).or_else(|| FileKind::of(&std::fs::read_to_string(path).ok()?));
    let document = || Document::within(&disk(), path, text.to_owned());
    let read: Result<Vec<Value>, Diagnostic> = match kind {
        Some(FileKind::Design) => Design::from_document(document()).map(|read| read.told.iter().map(message).collect()),
        Some(FileKind::Calibration) => Calibration::from_document(&document())
            .map(|read| read.stated.notes.into_iter().chain(read.stated.doubts).map(remark).collect()),
        Some(FileKind::Scene) => SceneInput::from_document(document(), Overrides::default()).map(|_| Vec::new()),
        _ => match toml::from_str::<toml::Table>(text) {
            Ok(_) => Ok(Vec::new()),
            Err(error) => {
                let before = &text[..error.span().map_or(0, |span| span.start.min(text.len()))];
                let line = u32::try_from(before.matches('\n').count() + 1).ok();
                Err(Diagnostic { line, ..Diagnostic::file(path, error.message().to_owned()) })
            }
        },
    };
    let (errors, warnings) = match read {
        Ok(warnings) => (Vec::new(), warnings),
        Err(error) => (vec![message(&error)], Vec::new()),
    };
    json!({ "errors": errors, "warnings": warnings })
}

/// Describes the text `text` of the file `path` as JSON for the page: kind, digest, values, and result of the check.
fn told(at: &str, path: &Path, text: &str) -> Value {
    let (kind, check) = (kind_of_text(text), checked(path, text));
    json!({ "path": at, "kind": kind, "text": text, "digest": digest(text), "values": values(text), "check": check })
}

fn loaded(path: &Path) -> Result<String, Refused> {
    let metadata = std::fs::metadata(path).map_err(|error| Refused::system(path, &error))?;
    if !metadata.is_file() || metadata.len() > MAX_BYTES {
        return Err(Refused::bad(format!("{} is no text of at most {} MiB", path.display(), MAX_BYTES >> 20)));
    }
    let bytes = std::fs::read(path).map_err(|error| Refused::system(path, &error))?;
    String::from_utf8(bytes).map_err(|_| Refused::bad(format!("{} is no UTF-8 text", path.display())))
}

/// Reads and checks a text.
pub async fn read(Query(at): Query<At>) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        Ok(told(&at.path, &path, &loaded(&path)?))
    })
    .await
}

/// A text to write: it replaces the text with the digest `digest`; without a digest it becomes a new file.
#[derive(Deserialize)]
pub struct Written {
    text: String,
    digest: Option<String>,
}

/// Returns the text of a file that still has the digest `known`, or `None` for a new file; refuses a file that changed
/// since the page read it.
fn require_unchanged(path: &Path, known: Option<&str>) -> Result<Option<String>, Refused> {
    let text = match loaded(path) {
        Ok(text) => Some(text),
        Err(Refused(StatusCode::NOT_FOUND, _)) => None,
        Err(refused) => return Err(refused),
    };
    let changed = |what: &str| Err(Refused::conflict(format!("{} {what}", path.display())));
    match (&text, known) {
        (Some(_), None) => changed("exists already"),
        (None, Some(_)) => changed("was removed by another program"),
        (Some(now), Some(known)) if digest(now) != known => changed("was changed by another program: load it again"),
        _ => Ok(text),
    }
}

/// Values of a TOML text without trials that wait to be measured, from which nothing is computed but what to cut next.
fn computed_from(text: &str) -> Option<toml::Table> {
    let mut table: toml::Table = text.parse().ok()?;
    let is_measured = |trial: &toml::Value| ["measurements", "traces"].iter().any(|key| trial.get(key).is_some());
    if let Some(toml::Value::Array(trials)) = table.get_mut("trial") {
        trials.retain(is_measured);
        if trials.is_empty() {
            table.remove("trial");
        }
    }
    Some(table)
}

/// Writes `text` in the place of `before`. A file keeps its time where nothing that is computed changes, so that
/// results stay newer; open pages are told, because a text of the same length is then not seen as changed.
fn save(shared: &Shared, at: &str, path: &Path, text: &str, before: Option<&str>) -> Result<Value, Refused> {
    if text.len() as u64 > MAX_BYTES {
        return Err(Refused::bad(format!("the text has more than {} MiB", MAX_BYTES >> 20)));
    }
    let equal = before.and_then(computed_from).is_some_and(|before| Some(before) == computed_from(text));
    let time = std::fs::metadata(path).and_then(|metadata| metadata.modified()).ok().filter(|_| equal);
    put(path, text.as_bytes()).map_err(|error| Refused::system(path, &error))?;
    if let Some(time) = time {
        let _ = File::options().write(true).open(path).and_then(|file| file.set_modified(time));
        shared.jobs.tell("folder", || json!({}));
    }
    Ok(told(at, path, text))
}

/// Replaces a text that has not changed since it was read.
pub async fn write(
    State(shared): State<Arc<Shared>>,
    Query(at): Query<At>,
    Json(written): Json<Written>,
) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        let before = require_unchanged(&path, written.digest.as_deref())?;
        save(&shared, &at.path, &path, &written.text, before.as_deref())
    })
    .await
}

/// Edits of the text with the digest `digest`.
#[derive(Deserialize)]
pub struct Edits {
    digest: String,
    edits: Vec<Edit>,
}

/// Sets values of a TOML text, and keeps its comments.
pub async fn edit(State(shared): State<Arc<Shared>>, Query(at): Query<At>, Json(edits): Json<Edits>) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        let text = require_unchanged(&path, Some(&edits.digest))?.unwrap_or_default();
        let mut document: DocumentMut = text
            .parse()
            .map_err(|error| Refused::bad(format!("{} cannot be edited by a form: {error}", path.display())))?;
        apply_all(&edits.edits, &mut document)?;
        save(&shared, &at.path, &path, &document.to_string(), Some(&text))
    })
    .await
}

/// A text to check, which is not written.
#[derive(Deserialize)]
pub struct Draft {
    text: String,
}

/// Checks a text without writing it.
pub async fn check(Query(at): Query<At>, Json(draft): Json<Draft>) -> Answer<Value> {
    aside(move || {
        let path = inside(&at.path)?;
        Ok(json!({ "check": checked(&path, &draft.text), "values": values(&draft.text) }))
    })
    .await
}

/// Kind of file in the query of a request.
#[derive(Deserialize)]
pub struct OfKind {
    kind: String,
}

/// Schemas of the files that have forms, completed by the names and ranges that the readers accept.
const SCHEMAS: [(&str, &str); 5] = [
    ("calibration", include_str!("../schemas/calibration-1.json")),
    ("campaign", include_str!("../schemas/campaign-1.json")),
    ("design", include_str!("../schemas/design-1.json")),
    ("material", include_str!("../schemas/material-1.json")),
    ("scene", include_str!("../schemas/scene-1.json")),
];

/// JSON schema of a kind of file.
pub async fn schema(Query(of): Query<OfKind>) -> Result<Response, Refused> {
    let found = SCHEMAS.into_iter().find(|(kind, _)| *kind == of.kind);
    let expected = || Refused::bad(format!("{:?}: expected {}", of.kind, SCHEMAS.map(|(kind, _)| kind).join(", ")));
    found.map(|(_, schema)| ([(CONTENT_TYPE, "application/json")], schema).into_response()).ok_or_else(expected)
}
