//! Study file: results of the search's model, appended as soon as they are known.
//!
//! The first line states the inputs that the results depend on. Every other line is one design.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use slipgrid_design::results::VERSION;
use slipgrid_design::{Answer, Evaluation, EvaluationCache, Fault, LARGEST};

use crate::interruption;
use slipgrid_io::formats::Diagnostic;

/// Line of the study file: one design with the model's results, or with the reason why it has none.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Line {
    width_um: f64,
    spacing_um: f64,
    depth_um: f64,
    fidelity: String,
    block_um: f64,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    answer: Option<Answer>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    failed: Option<String>,
}

/// Fidelity of all results.
const FIDELITY: &str = "steady";

/// Cache file with the results of the search's model.
#[derive(Debug)]
pub struct StudyFile {
    path: PathBuf,
    /// Reuses the results in the file; otherwise the file is replaced at the first new result.
    resume: bool,
    writer: Mutex<Option<Writer>>,
    /// Error for which the file was refused, with the line of the file; `None` if it was not refused.
    refused: Option<Diagnostic>,
}

impl StudyFile {
    /// Opens the study at `path`. With `resume`, the results in the file are reused, except an incomplete last line;
    /// otherwise the file is replaced at the first new result.
    pub const fn new(path: PathBuf, resume: bool) -> Self {
        Self { path, resume, writer: Mutex::new(None), refused: None }
    }

    /// Error for which the file was refused, with the line of the file; `None` if it was not refused.
    pub const fn refused(&self) -> Option<&Diagnostic> {
        self.refused.as_ref()
    }

    /// Reads the results in the file, which have values at `loads` loads. `depends_on` lists the inputs of the model,
    /// which must equal those in the file.
    ///
    /// # Errors
    /// [`Diagnostic`] if the file is no study, or if its results depend on other inputs (names the difference); if a line is
    /// damaged or cannot be a result of the model (gives its number).
    fn begin(&mut self, depends_on: &Map<String, Value>, loads: usize) -> Result<Vec<Evaluation>, Diagnostic> {
        let path = &self.path;
        if path.is_dir() {
            return Err(Diagnostic::file(path, "is a folder where the study is to go").expected("no such folder"));
        }
        if !self.resume && !is_replaceable(path) {
            let refused = Diagnostic::file(path, "is no study and would be replaced by one");
            return Err(refused.expected("another folder of results, or no such file"));
        }
        let (mut known, mut whole) = (Vec::new(), None);
        if self.resume && path.exists() {
            let mut text = Vec::new();
            File::open(path)
                .and_then(|mut file| file.read_to_end(&mut text))
                .map_err(|error| Diagnostic::file(path, format!("cannot be read: {error}")))?;
            (known, whole) = read(path, &text, depends_on, loads)?;
        }
        if !known.is_empty() {
            interruption::kept(path, known.len(), interruption::ANSWERS);
        }
        let writer = Writer { path: path.clone(), answers: known.len(), header: header(depends_on), whole, file: None };
        *self.writer.get_mut().unwrap_or_else(PoisonError::into_inner) = Some(writer);
        Ok(known)
    }
}

impl EvaluationCache for StudyFile {
    fn open(&mut self, key: &Map<String, Value>, loads: usize) -> Result<Vec<Evaluation>, String> {
        self.begin(key, loads).map_err(|refused| {
            let words = refused.to_string();
            self.refused = Some(refused);
            words
        })
    }

    fn keep(&self, evaluation: &Evaluation) -> Result<(), String> {
        let [block_um, width_um, spacing_um, depth_um] = evaluation.lengths_um;
        let (answer, failed) = (evaluation.answered.clone().ok(), evaluation.answered.clone().err());
        let line = Line { width_um, spacing_um, depth_um, fidelity: FIDELITY.to_owned(), block_um, answer, failed };
        let mut writer = self.writer.lock().unwrap_or_else(PoisonError::into_inner);
        writer.as_mut().map_or(Ok(()), |writer| writer.append(&line))
    }

    fn place(&self) -> String {
        self.path.display().to_string()
    }
}

/// Appends lines, each in a single write.
#[derive(Debug)]
struct Writer {
    path: PathBuf,
    /// Number of results in the file.
    answers: usize,
    header: String,
    /// Number of bytes in the complete lines of a resumed file; `None` for a new file.
    whole: Option<u64>,
    file: Option<File>,
}

impl Writer {
    fn append(&mut self, line: &Line) -> Result<(), String> {
        let text = serde_json::to_string(line).map_err(|error| error.to_string())? + "\n";
        let failed = |error: std::io::Error| format!("{}: cannot be written: {error}", self.path.display());
        let (mut file, text) = match self.file.take() {
            Some(file) => (file, text),
            None => {
                (self.open().map_err(failed)?, if self.whole.is_none() { self.header.clone() + &text } else { text })
            }
        };
        // A single call: lines of two processes may alternate, but do not mix.
        file.write_all(text.as_bytes()).map_err(failed)?;
        self.file = Some(file);
        self.answers += 1;
        interruption::kept(&self.path, self.answers, interruption::ANSWERS);
        Ok(())
    }

    fn open(&self) -> std::io::Result<File> {
        if let Some(parent) = self.path.parent() {
            fs::create_dir_all(parent)?;
        }
        let whole = File::options().create(true).write(true).truncate(false).open(&self.path)?;
        whole.set_len(self.whole.unwrap_or(0))?;
        File::options().append(true).open(&self.path)
    }
}

/// Whether the file at `path` is a study or empty.
fn is_replaceable(path: &Path) -> bool {
    const BEGINNING: &[u8] = b"{\"depends_on\":";
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(BEGINNING.len() as u64).read_to_end(&mut head));
    read.is_err() || BEGINNING.starts_with(&head)
}

/// First line of a study file: the inputs `depends_on` of the model, and the version of the program.
fn header(depends_on: &Map<String, Value>) -> String {
    // The first key is that by which a study is recognized.
    json!({"depends_on": depends_on, "study": "slipgrid optimize", "version": VERSION}).to_string() + "\n"
}

/// Reads a study and the number of bytes in its complete lines; `None` if even the first line is incomplete.
fn read(
    path: &Path,
    text: &[u8],
    depends_on: &Map<String, Value>,
    loads: usize,
) -> Result<(Vec<Evaluation>, Option<u64>), Diagnostic> {
    let refuse = |line: usize, reason: String, expected: String| {
        Diagnostic { line: u32::try_from(line).ok(), ..Diagnostic::file(path, reason) }.expected(expected)
    };
    let (mut known, mut seen) = (Vec::new(), BTreeSet::new());
    // Text after the last line break is an incomplete line.
    let Some(end) = text.iter().rposition(|&byte| byte == b'\n') else { return Ok((known, None)) };
    for (place, line) in text[..end].split(|&byte| byte == b'\n').enumerate() {
        if place == 0 {
            let first = serde_json::from_slice(line).map_err(|_| "is no study".to_owned());
            first
                .and_then(|first| same(&first, depends_on))
                .map_err(|reason| refuse(1, reason, "a study of this design, or a run without --resume".to_owned()))?;
            continue;
        }
        let evaluation = read_line(line, loads).map_err(|fault| {
            let instead = "delete this line and its design is computed again, or run without --resume";
            refuse(place + 1, fault.reason, format!("{}: {instead}", fault.expected))
        })?;
        // The first of two results for one design counts.
        if seen.insert(evaluation.lengths_um.map(f64::to_bits)) {
            known.push(evaluation);
        }
    }
    Ok((known, Some(end as u64 + 1)))
}

/// Parses one design of a study, with its results at `loads` loads.
fn read_line(line: &[u8], loads: usize) -> Result<Evaluation, Fault> {
    let whole = || "a whole line, as the search writes it".to_owned();
    let damaged = |reason: String| Fault { reason: format!("is damaged: {reason}"), expected: whole() };
    let read: Line = serde_json::from_slice(line).map_err(|error| {
        // The error's line number must refer to the file, not to the parsed line.
        let text = error.to_string();
        damaged(text.split(" at line ").next().unwrap_or(&text).to_owned())
    })?;
    let lengths_um = [read.block_um, read.width_um, read.spacing_um, read.depth_um];
    if lengths_um.iter().any(|&length_um| !(length_um > 0.0 && length_um <= LARGEST)) {
        return Err(damaged("a length is not positive".to_owned()));
    }
    if read.fidelity != FIDELITY {
        return Err(damaged(format!("its fidelity is not \"{FIDELITY}\"")));
    }
    let answered = match (read.answer, read.failed) {
        (Some(answer), None) => answer.check(loads).map(|()| Ok(answer))?,
        (None, Some(reason)) => Err(reason),
        _ => return Err(damaged("it holds neither an answer nor a reason why there is none".to_owned())),
    };
    Ok(Evaluation { lengths_um, answered })
}

/// Checks that the `first` line states the inputs `depends_on` and this version; otherwise returns the difference in
/// words.
fn same(first: &Value, depends_on: &Map<String, Value>) -> Result<(), String> {
    let (Some(version), Some(theirs)) = (first["version"].as_str(), first["depends_on"].as_object()) else {
        return Err("is no study".to_owned());
    };
    if version != VERSION {
        return Err(format!("is a study by version {version}: this is {VERSION}"));
    }
    let none = Value::Null;
    for name in depends_on.keys().chain(theirs.keys()) {
        let (ours, theirs) = (depends_on.get(name).unwrap_or(&none), theirs.get(name).unwrap_or(&none));
        if ours != theirs {
            return Err(format!("is a study of another design: its `{name}` is {theirs}, here it is {ours}"));
        }
    }
    Ok(())
}
