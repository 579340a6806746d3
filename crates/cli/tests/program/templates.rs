//! Template files run unchanged; completions and the manual page list every command.

use crate::common::{CALIBRATION, COMMANDS, Place, names};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;
use slipgrid_io::formats::run::Overrides;
use slipgrid_io::formats::scene::SceneInput;
use slipgrid_io::formats::{Diagnostic, Document};

#[test]
fn templates_run_as_they_are() {
    let place = Place::with(&[]);
    for (template, made) in [("scene", "scene.toml"), ("design", "design.toml"), ("calibration", "calibration")] {
        assert_eq!(place.succeed(&format!("new {template}")).trim_end(), made);
        let message = place.refuse(&format!("new {template}"));
        assert!(message.contains(made) && message.contains("exists already"), "{message}");
    }
    place.succeed("simulate scene.toml");
    place.succeed("calibrate calibration/calibration.toml -o m.toml");
    Design::read(&disk(), &place.path("design.toml")).unwrap();
}

/// Line of a template without the mark of a comment, if it is a key or a header that is commented out.
fn uncommented(line: &str) -> Option<&str> {
    let bare = line.strip_prefix("# ")?;
    let name = bare.split(" = ").next().filter(|name| bare.len() > name.len());
    let is_key = name.is_some_and(|name| name.bytes().all(|byte| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'_')));
    (is_key || bare.starts_with('[')).then_some(bare)
}

/// Every commented key of a template is known in the table in which it stands.
#[test]
fn no_template_shows_a_key_that_is_refused() {
    let place = Place::with(&[]);
    let [calibration, scene, design] = ["calibration", "scene", "design"].map(|template| {
        let made = place.succeed(&format!("new {template}"));
        place.read(if template == "calibration" { "calibration/calibration.toml" } else { made.trim_end() })
    });
    let of_calibration = |text: String| Calibration::from_document(&Document::new("c.toml", text)).map(|_| ());
    let of_scene =
        |text: String| SceneInput::from_document(Document::new("s.toml", text), Overrides::default()).map(|_| ());
    let of_design = |text: String| Design::from_document(Document::new("d.toml", text)).map(|_| ());
    let readers: [&dyn Fn(String) -> Result<(), Diagnostic>; 3] = [&of_calibration, &of_scene, &of_design];
    let mut counts = [0; 3];
    for (number, text) in [calibration, scene, design].into_iter().enumerate() {
        let lines: Vec<&str> = text.lines().collect();
        for place in (0..lines.len()).filter(|place| uncommented(lines[*place]).is_some()) {
            // With the commented headers above it.
            let block = lines[..place].iter().rposition(|line| !line.starts_with('#')).map_or(0, |at| at + 1);
            let shown = (0..lines.len()).map(|own| {
                let is_header = (block..place).contains(&own) && lines[own].starts_with("# [");
                uncommented(lines[own]).filter(|_| own == place || is_header).unwrap_or(lines[own]).to_owned() + "\n"
            });
            let refused =
                readers[number](shown.collect()).err().map_or_else(String::new, |refused| refused.to_string());
            assert!(!refused.contains("is not a known key") && !refused.contains("wrong type"), "{refused}");
            counts[number] += 1;
        }
    }
    assert!(counts[0] > 120 && counts[1] > 15 && counts[2] > 30, "{counts:?}");
}

#[test]
fn the_trial_of_the_template_is_read() {
    let place = Place::with(&[]);
    place.succeed("new calibration");
    let text = place.read("calibration/calibration.toml");
    let (before, rest) = text.split_once("# [[trial]]").unwrap();
    let (trial, after) = rest.split_once("# [[trial.traces]]").unwrap();
    let trial: String = trial.lines().map(|line| uncommented(line).unwrap_or(line).to_owned() + "\n").collect();
    place.write("calibration/calibration.toml", format!("{before}[[trial]]{trial}# [[trial.traces]]{after}"));
    place.write("calibration/cut-1.csv", place.read("calibration/flat.csv"));
    let read = Calibration::read(&slipgrid_io::disk::disk(), &place.path("calibration/calibration.toml")).unwrap();
    assert_eq!(read.stated.trials.samples.iter().map(|cut| cut.measured.len()).collect::<Vec<_>>(), [3]);
    // Without the name of the list the table is none of the trial's.
    let stray = place.read("calibration/calibration.toml").replace("[trial.pattern]", "[pattern]");
    place.write("calibration/calibration.toml", stray);
    let refused = place.refuse("calibrate calibration/calibration.toml");
    assert!(
        refused.contains("trial.pattern: is missing; expected [trial.pattern] in place of [pattern] in line"),
        "{refused}"
    );
}

#[test]
fn shells_and_readers_learn_every_command() {
    let place = Place::with(&[]);
    for shell in ["bash", "zsh", "fish"] {
        let script = place.succeed(&format!("completions {shell}"));
        assert!(COMMANDS.split(' ').all(|command| script.contains(command)), "{shell}");
    }
    assert!(place.succeed("man").contains(".TH slipgrid 1"));
    place.succeed("man -o man1");
    let mut commands: Vec<String> = COMMANDS.split(' ').map(|command| format!("slipgrid-{command}")).collect();
    commands.extend(["plan", "work", "merge"].map(|step| format!("slipgrid-campaign-{step}")));
    commands.push("slipgrid".to_owned());
    commands.sort();
    let mut pages: Vec<String> = commands.iter().map(|command| format!("{command}.1")).collect();
    pages.sort();
    assert_eq!(names(&place.path("man1")), pages);
    for command in commands {
        assert!(place.read(&format!("man1/{command}.1")).contains(&format!(".TH {command} 1")), "{command}");
    }
}

/// The template explains every key that the reader accepts in each table of a calibration.
#[test]
fn the_calibration_template_explains_every_key() {
    let place = Place::with(&[]);
    place.succeed("new calibration");
    let template = place.read("calibration/calibration.toml");
    // Lines with the header above them, without the marks of comments.
    let mut header = "";
    let lines: Vec<(&str, &str)> = template
        .lines()
        .map(|line| {
            let line = line.trim_start_matches("# ");
            header = if line.starts_with('[') { line } else { header };
            (header, line)
        })
        .collect();
    let text = format!(
        "{CALIBRATION}[traces]\n[[traces.condition]]\nforce_n = 1\nspeed_mm_s = 1\nhumidity_pct = 1\nfiles = []\n\
         [pattern]\nwidth_um = 1\nspacing_um = 1\ndepth_um = 1\n"
    );
    let tables = " [material] [surface] [specimen] [measurements] [traces] [[traces.condition]] [pattern] [fit]";
    for table in tables.split(' ') {
        let unknown = format!("{table}\nno_such_key = 1\n");
        let spoiled = if table.is_empty() { unknown + &text } else { text.replace(&format!("{table}\n"), &unknown) };
        let refused = Calibration::from_document(&Document::new("c.toml", spoiled)).unwrap_err();
        let keys = refused.expected.clone().unwrap_or_default();
        let Some(keys) = keys.strip_prefix("one of ") else { panic!("{table}: {refused}") };
        for key in keys.split(", ") {
            let is_explained = lines.iter().any(|(header, line)| {
                header.is_empty() == table.is_empty()
                    && header.starts_with(table)
                    && line.starts_with(&format!("{key} = "))
                    || table.is_empty() && line.contains(&format!("[{key}]"))
                    || table == "[traces]" && line.starts_with(&format!("[[traces.{key}]]"))
            });
            assert!(is_explained, "{table}: {key} is not in the template");
        }
    }
}
