//! The study file, which keeps results of the search's model beyond a run.

use std::fs;
use std::path::Path;

use serde_json::{Map, Value};
use slipgrid_cli::study_file::StudyFile;
use slipgrid_design::Answer;
use slipgrid_design::optimize::ModelFailure;
use slipgrid_design::results::VERSION;
use slipgrid_design::{DesignError, Evaluations};
use slipgrid_model::pattern::{Pattern, Planform};

fn design(width_um: f64) -> Pattern {
    Pattern::new(Planform::Groove, width_um / 1e6, 300e-6, 10e-6).unwrap()
}

fn answer(width_um: f64) -> Answer {
    // Numbers with all their digits.
    let ratio = vec![1.0 / width_um, 1.0 + (width_um / 3.0).sin()];
    let (peak_pressure_mpa, clearance_um) = (width_um / 7.0, Some(0.1 + 0.2));
    Answer { ratio, peak_pressure_mpa, least_pressure: -1.0 / 3.0, clearance_um }
}

fn depends_on(modulus: f64) -> Map<String, Value> {
    [("youngs_modulus_gpa".to_owned(), Value::from(modulus))].into_iter().collect()
}

fn never() -> Result<Answer, ModelFailure> {
    panic!("is known already")
}

/// Opens the study at `path` for a cache of results; also returns the number of results that the file holds.
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
    let failure = || Err(ModelFailure::Trial("too \"wide\"\n".to_owned()));
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
    assert_eq!(failed, Err(ModelFailure::Trial("too \"wide\"\n".to_owned())));
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
        let failure = || Err(ModelFailure::Trial("too \"wide\"\n".to_owned()));
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
    assert!(message.contains("its `youngs_modulus_gpa` is 0.38, here it is 0.4"), "{message}");
    let older = whole.replacen(VERSION, "0.0.1", 1);
    assert!(refused(&older, 0.38).contains("version 0.0.1"));
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
        ("\"answer\":", "\"failed\":\"why\",\"answer\":", "neither an answer nor a reason why"),
    ] {
        let refused = read(&line.replacen(from, to, 1)).unwrap_err().to_string();
        assert!(refused.contains("study.jsonl:2: ") && refused.contains(says), "{to}: {refused}");
        assert!(refused.contains("delete this line") && refused.contains("without --resume"), "{refused}");
    }
}
