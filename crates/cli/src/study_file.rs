//! The study: answers of the search's model, appended to a file as soon as they are known.
//!
//! The first line says what the answers depend on. Every other line is one design.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use slipgrid_design::{Answer, Evaluation, EvaluationCache, Fault, LARGEST};
use slipgrid_results::VERSION;

use crate::interruption;
use slipgrid_formats::Diagnostic;

/// A line of the file.
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

/// The fidelity of all answers.
const FIDELITY: &str = "steady";

/// Answers in a file.
#[derive(Debug)]
pub struct StudyFile {
    path: PathBuf,
    /// What the file holds is known already; without, the file is replaced at the first answer.
    resume: bool,
    writer: Mutex<Option<Writer>>,
    /// Why the file was refused, with its line.
    refused: Option<Diagnostic>,
}

impl StudyFile {
    /// A study in the file at `path`. With `resume` what the file holds is known already, but for a last line that was
    /// being written; without, the file is replaced at the first answer.
    #[must_use]
    pub const fn new(path: PathBuf, resume: bool) -> Self {
        Self { path, resume, writer: Mutex::new(None), refused: None }
    }

    /// Why the file was refused, with its line.
    #[must_use]
    pub const fn refused(&self) -> Option<&Diagnostic> {
        self.refused.as_ref()
    }

    /// What the file holds of answers at `loads` loads that depend on `depends_on`.
    ///
    /// # Errors
    /// [`Diagnostic`] for a file of other answers, by what differs, or that is no study; for a line that is damaged or
    /// cannot be the model's answer, by its number.
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
            interruption::kept(path, known.len());
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

/// Appends lines, each in one piece.
#[derive(Debug)]
struct Writer {
    path: PathBuf,
    /// Answers that it holds.
    answers: usize,
    header: String,
    /// Bytes of whole lines in a file that is resumed; `None` where it is begun.
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
        // One call: lines of two processes may follow one another, and do not mix.
        file.write_all(text.as_bytes()).map_err(failed)?;
        self.file = Some(file);
        self.answers += 1;
        interruption::kept(&self.path, self.answers);
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

/// Whether the file at `path` is a study, or holds nothing.
fn is_replaceable(path: &Path) -> bool {
    const BEGINNING: &[u8] = b"{\"depends_on\":";
    let mut head = Vec::new();
    let read = File::open(path).and_then(|file| file.take(BEGINNING.len() as u64).read_to_end(&mut head));
    read.is_err() || BEGINNING.starts_with(&head)
}

/// The first line.
fn header(depends_on: &Map<String, Value>) -> String {
    let mut object = Map::new();
    object.insert("study".to_owned(), Value::from("slipgrid optimize"));
    object.insert("version".to_owned(), Value::from(VERSION));
    object.insert("hash".to_owned(), Value::from(hash(depends_on)));
    object.insert("depends_on".to_owned(), Value::Object(depends_on.clone()));
    Value::Object(object).to_string() + "\n"
}

/// Version and everything the answers depend on, by Fowler, Noll and Vo's hash (FNV-1a, 64 bits).
fn hash(depends_on: &Map<String, Value>) -> String {
    let text = format!("{VERSION}\n{}", Value::Object(depends_on.clone()));
    let fold = |hash: u64, byte: u8| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    format!("{:016x}", text.bytes().fold(0xcbf2_9ce4_8422_2325, fold))
}

/// What a study holds, with the number of bytes of its whole lines; `None` where not even its first line is whole.
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
    // What follows the last line break was being written.
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
        // Of two answers to one design the first counts.
        if seen.insert(evaluation.lengths_um.map(f64::to_bits)) {
            known.push(evaluation);
        }
    }
    Ok((known, Some(end as u64 + 1)))
}

/// One design of a study, with what is known of it at `loads` loads.
fn read_line(line: &[u8], loads: usize) -> Result<Evaluation, Fault> {
    let whole = || "a whole line, as the search writes it".to_owned();
    let damaged = |reason: String| Fault { reason: format!("is damaged: {reason}"), expected: whole() };
    let read: Line = serde_json::from_slice(line).map_err(|error| {
        // The line of the error is that of the file, not the first.
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
        _ => return Err(damaged("it holds neither an answer nor why there is none".to_owned())),
    };
    Ok(Evaluation { lengths_um, answered })
}

/// Whether the first line is of answers that depend on `depends_on`; if not, what differs.
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
            let name = name.replace('_', " ");
            return Err(format!("is a study of another design: its {name} is {theirs}, here it is {ours}"));
        }
    }
    if first["hash"].as_str() == Some(hash(depends_on).as_str()) {
        Ok(())
    } else {
        Err("is a study whose first line was changed: its hash does not fit".to_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_design::{DesignError, Evaluations};
    use slipgrid_optimize::ModelFailure;
    use slipgrid_pattern::{Pattern, Planform};

    fn design(width_um: f64) -> Pattern {
        Pattern::new(Planform::Groove, width_um / 1e6, 300e-6, 10e-6).unwrap()
    }

    fn answer(width_um: f64) -> Answer {
        // Numbers with all their digits.
        let ratio = vec![1.0 / width_um, 1.0 + (width_um / 3.0).sin()];
        Answer { ratio, peak_pressure_mpa: width_um / 7.0, least_pressure: -1.0 / 3.0, clearance_um: Some(0.1 + 0.2) }
    }

    fn depends_on(modulus: f64) -> Map<String, Value> {
        [("youngs_modulus_gpa".to_owned(), Value::from(modulus))].into_iter().collect()
    }

    fn never() -> Result<Answer, ModelFailure> {
        panic!("is known already")
    }

    /// Answers with the study in the file at `path`, and how many that holds.
    fn begin(path: &Path, modulus: f64, resume: bool) -> Result<(Evaluations<'static>, usize), DesignError> {
        // As long as the test: a few hundred bytes.
        let study = Box::leak(Box::new(StudyFile::new(path.to_owned(), resume)));
        Evaluations::cached(study, &depends_on(modulus), 2)
    }

    const WIDTHS_UM: [f64; 3] = [100.0, 133.7, 0.1 + 0.2];

    fn written(path: &Path) -> Vec<u8> {
        let (study, _) = begin(path, 0.38, false).unwrap();
        for width_um in WIDTHS_UM {
            assert_eq!(study.answer(10e-6, &design(width_um), || Ok(answer(width_um))).unwrap(), answer(width_um));
            assert_eq!(study.answer(10e-6, &design(width_um), never).unwrap(), answer(width_um));
        }
        let failure = || Err(ModelFailure::Trial { reason: "too \"wide\"\n".to_owned() });
        assert!(study.answer(10e-6, &design(400.0), failure).is_err());
        fs::read(path).unwrap()
    }

    #[test]
    fn what_was_written_is_known_to_the_last_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out/a.study.jsonl");
        let before = written(&path);
        let (study, resumed) = begin(&path, 0.38, true).unwrap();
        assert_eq!(resumed, 4);
        for width_um in WIDTHS_UM {
            assert_eq!(study.answer(10e-6, &design(width_um), never).unwrap(), answer(width_um));
        }
        let failed = study.answer(10e-6, &design(400.0), never);
        assert_eq!(failed, Err(ModelFailure::Trial { reason: "too \"wide\"\n".to_owned() }));
        assert_eq!(fs::read(&path).unwrap(), before, "nothing new, nothing written");
        // Other blocks are another question, and a study without `resume` begins anew.
        assert_eq!(study.answer(40e-6, &design(100.0), || Ok(answer(1.0))).unwrap(), answer(1.0));
        assert_eq!(written(&path), before);
    }

    #[test]
    fn a_file_cut_at_any_byte_of_its_last_line_loses_that_line_alone() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.study.jsonl");
        let whole = written(&path);
        let last = whole[..whole.len() - 1].iter().rposition(|&byte| byte == b'\n').unwrap() + 1;
        for cut in last..whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            let (study, resumed) = begin(&path, 0.38, true).unwrap();
            assert_eq!(resumed, 3, "{cut}");
            let failure = || Err(ModelFailure::Trial { reason: "too \"wide\"\n".to_owned() });
            assert!(study.answer(10e-6, &design(400.0), failure).is_err());
            assert_eq!(fs::read(&path).unwrap(), whole, "{cut}");
        }
        // A first line that is not whole holds nothing.
        for cut in [0, 1, 40] {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(begin(&path, 0.38, true).unwrap().1, 0);
        }
    }

    #[test]
    fn a_study_of_something_else_is_refused_by_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.study.jsonl");
        let whole = String::from_utf8(written(&path)).unwrap();
        let refused = |text: &str, modulus: f64| {
            fs::write(&path, text).unwrap();
            begin(&path, modulus, true).err().unwrap().to_string()
        };
        let message = refused(&whole, 0.4);
        assert!(message.contains("its youngs modulus gpa is 0.38, here it is 0.4"), "{message}");
        let older = whole.replacen(VERSION, "0.0.1", 1);
        assert!(refused(&older, 0.38).contains("version 0.0.1"));
        let forged = whole.replacen("\"hash\":\"", "\"hash\":\"0", 1);
        assert!(refused(&forged, 0.38).contains("hash does not fit"));
        assert!(refused("hello\n", 0.38).contains("is no study") && refused("[1]\n", 0.38).contains("is no study"));
        let broken = whole.replacen("\"ratio\"", "\"rat", 1);
        assert!(refused(&broken, 0.38).contains("study.jsonl:2: "));
    }
    #[test]
    fn what_is_no_study_is_not_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.study.jsonl");
        let begun = |path: &Path| begin(path, 0.38, false).map(|_| ());
        for (text, ok) in [("", true), ("{\"depe", true), ("{\"depends_on\":{}}\n", true), ("my notes", false)] {
            fs::write(&path, text).unwrap();
            assert_eq!(begun(&path).is_ok(), ok, "{text}");
        }
        assert!(begun(folder.path()).unwrap_err().to_string().contains("is a folder"));
    }

    #[test]
    fn a_line_that_cannot_be_an_answer_is_refused_by_its_number() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.study.jsonl");
        let whole = String::from_utf8(written(&path)).unwrap();
        let line = r#""answer":{"ratio":[0.9,0.8],"peak_pressure_mpa":5.0,"least_pressure":-0.1,"clearance_um":3.0}"#;
        let head = r#"{"width_um":1.0,"spacing_um":2.0,"depth_um":3.0,"fidelity":"steady","block_um":10.0,"#;
        let read = |line: &str| {
            fs::write(&path, format!("{}\n{head}{line}}}\n", whole.lines().next().unwrap())).unwrap();
            begin(&path, 0.38, true).map(|(_, resumed)| resumed)
        };
        assert_eq!(read(line).unwrap(), 1);
        for (from, to, says) in [
            ("[0.9,0.8]", "[0.9]", "answer.ratio: has 1 ratios; expected 2, one for each load"),
            ("[0.9,0.8]", "[]", "has 0 ratios"),
            ("[0.9,0.8]", "[0.9,0.8,0.7]", "has 3 ratios"),
            ("0.8", "-5", "-5e0 is no ratio"),
            ("0.8", "0", "0e0 is no ratio"),
            ("0.8", "1e300", "1e300 is no ratio"),
            ("0.8", "1e999", "is damaged: number out of range"),
            ("0.8", "NaN", "is damaged"),
            ("0.8", "null", "is damaged: invalid type: null"),
            ("5.0", "-5.0", "answer.peak_pressure_mpa: -5e0 is out of range"),
            ("-0.1", "1e300", "answer.least_pressure: 1e300 is out of range"),
            ("3.0", "1e300", "answer.clearance_um: 1e300 is out of range"),
            ("\"answer\":", "\"failed\":\"why\",\"answer\":", "neither an answer nor why"),
        ] {
            let refused = read(&line.replacen(from, to, 1)).unwrap_err().to_string();
            assert!(refused.contains("study.jsonl:2: ") && refused.contains(says), "{to}: {refused}");
            assert!(refused.contains("delete this line") && refused.contains("without --resume"), "{refused}");
        }
    }
}
