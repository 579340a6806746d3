//! The study: every answer of the search's model, kept in memory and appended to a file as soon as it is known, so that
//! a killed run loses no more than what was being computed.
//!
//! The first line says what the answers depend on. Every other line is one design. Answers are those of the model alone,
//! before anything that depends on target, limits or confirming runs: a study serves any of these.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use slipgrid_optimize::ModelFailure;
use slipgrid_pattern::Pattern;

use crate::CliError;
use crate::diagnostic::Diagnostic;
use crate::interruption;
use slipgrid_results::VERSION;

/// What the model says of a design at the target's pressures. Numbers are kept as the file holds them, so that those
/// read back are the same to the last bit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answer {
    /// Friction, patterned over flat, at each pressure.
    pub ratio: Vec<f64>,
    /// Largest local pressure over all of them.
    pub peak_pressure_mpa: f64,
    /// Least local pressure over the nominal one: negative under tension.
    pub least_pressure: f64,
    /// Least height of a ceiling above the counterface; absent where nothing could sag.
    pub clearance_um: Option<f64>,
}

/// Largest size of a number in an answer: far above anything the model gives, far below where sums overflow.
const LARGEST: f64 = 1e9;

impl Answer {
    /// Whether these can be the model's numbers at `loads` loads.
    ///
    /// # Errors
    /// What is wrong, and what would be right.
    fn check(&self, loads: usize) -> Result<(), Fault> {
        let positive = |value: f64| value > 0.0 && value <= LARGEST;
        if self.ratio.len() != loads {
            let reason = format!("answer.ratio: has {} ratios", self.ratio.len());
            return Err(Fault { reason, expected: format!("{loads}, one for each load of each condition") });
        }
        if let Some(place) = self.ratio.iter().position(|&ratio| !positive(ratio)) {
            let reason = format!("answer.ratio: {:e} is no ratio of two frictions", self.ratio[place]);
            return Err(Fault { reason, expected: "positive numbers".to_owned() });
        }
        let sizes = [("least_pressure", self.least_pressure), ("clearance_um", self.clearance_um.unwrap_or(0.0))];
        let beyond = sizes.into_iter().find(|(_, value)| value.is_nan() || value.abs() > LARGEST);
        let beyond =
            beyond.or(Some(("peak_pressure_mpa", self.peak_pressure_mpa)).filter(|&(_, value)| !positive(value)));
        match beyond {
            Some((name, value)) => Err(Fault {
                reason: format!("answer.{name}: {value:e} is out of range"),
                expected: format!("a number up to {LARGEST:e}"),
            }),
            None => Ok(()),
        }
    }

    /// Largest local pressure, in pascals.
    pub fn peak_pressure_pa(&self) -> f64 {
        self.peak_pressure_mpa * 1e6
    }

    /// Least height of a ceiling, in metres.
    pub fn clearance_m(&self) -> Option<f64> {
        self.clearance_um.map(|clearance_um| clearance_um * 1e-6)
    }
}

/// An answer, or why there is none.
pub type Answered = Result<Answer, String>;

/// What is wrong with a line.
struct Fault {
    reason: String,
    expected: String,
}

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

/// Block size and lengths of a design in micrometres, by their bits.
type Key = [u64; 4];

fn key(block_m: f64, design: &Pattern) -> Key {
    [block_m, design.width_m(), design.spacing_m(), design.depth_m()].map(|length_m| (length_m * 1e6).to_bits())
}

/// What has been answered so far.
#[derive(Debug, Default)]
pub struct Study {
    known: Mutex<BTreeMap<Key, Answered>>,
    /// Answers read back.
    resumed: usize,
    /// Loads that an answer has ratios at.
    loads: usize,
    file: Option<Mutex<Writer>>,
}

impl Study {
    /// A study in the file at `path` of answers at `loads` loads that depend on `depends_on`. With `resume` what the file
    /// holds is known already, but for a last line that was being written; without, the file is replaced at the first
    /// answer.
    ///
    /// # Errors
    /// [`Diagnostic`] for a file of other answers, by what differs, or that is no study; for a line that is damaged or
    /// cannot be the model's answer, by its number.
    pub fn in_file(
        path: PathBuf,
        depends_on: Map<String, Value>,
        loads: usize,
        resume: bool,
    ) -> Result<Self, CliError> {
        if path.is_dir() {
            return Err(Diagnostic::file(&path, "is a folder where the study is to go")
                .expected("no such folder")
                .into());
        }
        if !resume && !is_replaceable(&path) {
            let refused = Diagnostic::file(&path, "is no study and would be replaced by one");
            return Err(refused.expected("another folder of results, or no such file").into());
        }
        let (mut known, mut whole) = (BTreeMap::new(), None);
        if resume && path.exists() {
            let mut text = Vec::new();
            File::open(&path)
                .and_then(|mut file| file.read_to_end(&mut text))
                .map_err(|error| Diagnostic::file(&path, format!("cannot be read: {error}")))?;
            (known, whole) = read(&path, &text, &depends_on, loads)?;
        }
        let resumed = known.len();
        if resumed > 0 {
            interruption::kept(&path, resumed);
        }
        let writer = Writer { path, answers: resumed, header: header(&depends_on), whole, file: None };
        Ok(Self { known: Mutex::new(known), resumed, loads, file: Some(Mutex::new(writer)) })
    }

    /// Answers read back from the file.
    pub const fn resumed(&self) -> usize {
        self.resumed
    }

    /// The answer to `design` in blocks of `block_m`: known, or by `model`.
    ///
    /// # Errors
    /// [`ModelFailure`] of the model, and [`ModelFailure::Broken`] where the study cannot be written.
    pub fn answer(
        &self,
        block_m: f64,
        design: &Pattern,
        model: impl FnOnce() -> Result<Answer, ModelFailure>,
    ) -> Result<Answer, ModelFailure> {
        let key = key(block_m, design);
        let trial = |reason: String| ModelFailure::Trial { reason };
        if let Some(known) = self.known().get(&key) {
            return known.clone().map_err(trial);
        }
        let answered = match model() {
            Ok(answer) => Ok(answer),
            Err(ModelFailure::Trial { reason }) => Err(reason),
            Err(other) => return Err(other),
        };
        // Two threads may have come to one design: its first answer is written, if it could be read again.
        let is_readable = answered.as_ref().map_or(true, |answer| answer.check(self.loads).is_ok());
        if self.known().insert(key, answered.clone()).is_none()
            && is_readable
            && let Some(file) = &self.file
        {
            let [width_um, spacing_um, depth_um] =
                [design.width_m(), design.spacing_m(), design.depth_m()].map(|length_m| length_m * 1e6);
            let (answer, failed) = (answered.clone().ok(), answered.clone().err());
            let fidelity = FIDELITY.to_owned();
            let line = Line { width_um, spacing_um, depth_um, fidelity, block_um: block_m * 1e6, answer, failed };
            let mut writer = file.lock().unwrap_or_else(PoisonError::into_inner);
            writer.append(&line).map_err(|reason| ModelFailure::Broken { reason })?;
        }
        answered.map_err(trial)
    }

    /// Entries are whole when they enter: those of a panicking thread are as good as any.
    fn known(&self) -> MutexGuard<'_, BTreeMap<Key, Answered>> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
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
) -> Result<(BTreeMap<Key, Answered>, Option<u64>), Diagnostic> {
    let refuse = |line: usize, reason: String, expected: String| {
        Diagnostic { line: u32::try_from(line).ok(), ..Diagnostic::file(path, reason) }.expected(expected)
    };
    let mut known = BTreeMap::new();
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
        let (key, answered) = read_line(line, loads).map_err(|fault| {
            let instead = "delete this line and its design is computed again, or run without --resume";
            refuse(place + 1, fault.reason, format!("{}: {instead}", fault.expected))
        })?;
        known.entry(key).or_insert(answered);
    }
    Ok((known, Some(end as u64 + 1)))
}

/// One design of a study, with what is known of it at `loads` loads.
fn read_line(line: &[u8], loads: usize) -> Result<(Key, Answered), Fault> {
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
    Ok((lengths_um.map(f64::to_bits), answered))
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
    use slipgrid_pattern::Planform;

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

    const WIDTHS_UM: [f64; 3] = [100.0, 133.7, 0.1 + 0.2];

    fn written(path: &Path) -> Vec<u8> {
        let study = Study::in_file(path.to_owned(), depends_on(0.38), 2, false).unwrap();
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
        let study = Study::in_file(path.clone(), depends_on(0.38), 2, true).unwrap();
        assert_eq!(study.resumed(), 4);
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
            let study = Study::in_file(path.clone(), depends_on(0.38), 2, true).unwrap();
            assert_eq!(study.resumed(), 3, "{cut}");
            let failure = || Err(ModelFailure::Trial { reason: "too \"wide\"\n".to_owned() });
            assert!(study.answer(10e-6, &design(400.0), failure).is_err());
            assert_eq!(fs::read(&path).unwrap(), whole, "{cut}");
        }
        // A first line that is not whole holds nothing.
        for cut in [0, 1, 40] {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(Study::in_file(path.clone(), depends_on(0.38), 2, true).unwrap().resumed(), 0);
        }
    }

    #[test]
    fn a_study_of_something_else_is_refused_by_what_differs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.study.jsonl");
        let whole = String::from_utf8(written(&path)).unwrap();
        let refused = |text: &str, modulus: f64| {
            fs::write(&path, text).unwrap();
            Study::in_file(path.clone(), depends_on(modulus), 2, true).unwrap_err().to_string()
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
        let begun = |path: &Path| Study::in_file(path.to_owned(), depends_on(0.38), 2, false).map(|_| ());
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
            Study::in_file(path.clone(), depends_on(0.38), 2, true).map(|study| study.resumed())
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
