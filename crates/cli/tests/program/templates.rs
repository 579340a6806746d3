//! Template files run unchanged; completions and the manual page list every command.

use crate::common::{CALIBRATION, COMMANDS, Place, names};
use slipgrid_io::formats::Document;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;

#[test]
fn templates_run_as_they_are() {
    let place = Place::with(&[]);
    for (template, made) in [("scene", "scene.toml"), ("design", "design.toml"), ("calibration", "calibration")] {
        assert_eq!(place.succeed(&["new", template]).trim_end(), made);
        let message = place.refuse(&["new", template]);
        assert!(message.contains(made) && message.contains("exists already"), "{message}");
    }
    assert!(place.succeed(&["simulate", "scene.toml"]).contains("converged"));
    assert!(place.succeed(&["calibrate", "calibration/calibration.toml", "-o", "m.toml"]).contains("my polymer"));
    Design::read(&slipgrid_io::disk::disk(), &place.path("design.toml")).unwrap();

    // The design as it is, but on a short sample.
    let text = place.read("design.toml");
    let short = text
        .replace("diameter_mm = 10.0", "diameter_mm = 2.0")
        .replace("tolerance = 0.02", "tolerance = 0.05")
        .replace("depth_um = [2.0, 50.0]", "depth_um = 10.4")
        .replace("spacing_um = [40.0, 1000.0]", "spacing_um = [100.0, 300.0]");
    place.write("short.toml", short);
    place.succeed(&["optimize", "short.toml", "-o", "out"]);
    assert!(names(&place.path("out")).contains(&"report.html".to_owned()));
}

/// Commented lines of the design template that contain a key are valid if uncommented.
#[test]
fn commented_keys_of_templates_are_known() {
    let place = Place::with(&[]);
    place.succeed(&["new", "design"]);
    let text = place.read("design.toml");
    let every: String = text
        .lines()
        .map(|line| match line.strip_prefix("# ") {
            // A condition needs a material of its own, and the chance is that of designs on a target, not of a goal.
            Some(key) if ["condition", "goal ="].iter().any(|name| key.starts_with(name)) => line,
            Some(key) if key.starts_with('[') => key,
            Some(key) if key.contains(" = ") && !key.starts_with(char::is_uppercase) => key,
            _ => line,
        })
        .filter(|line| !line.starts_with("depth_per_burst_um"))
        .map(|line| format!("{line}\n"))
        .collect();
    place.write("every.toml", every);
    let design = Design::read(&slipgrid_io::disk::disk(), &place.path("every.toml")).unwrap();
    assert!(
        design.task.laser.ablation.is_some()
            && design.task.laser.speed_mm_s.is_some()
            && design.task.specimen.is_clipped
    );
}

#[test]
fn shells_and_readers_learn_every_command() {
    let place = Place::with(&[]);
    for shell in ["bash", "zsh", "fish"] {
        let script = place.succeed(&["completions", shell]);
        assert!(COMMANDS.split(' ').all(|command| script.contains(command)), "{shell}");
    }
    let page = place.succeed(&["man"]);
    assert!(page.contains(".TH slipgrid 1") && page.contains("Exit codes"));
    place.succeed(&["man", "-o", "man1"]);
    let mut expected: Vec<String> = COMMANDS.split(' ').map(|command| format!("slipgrid-{command}.1")).collect();
    expected.extend(["plan", "work", "merge"].map(|step| format!("slipgrid-campaign-{step}.1")));
    expected.push("slipgrid.1".to_owned());
    expected.sort();
    assert_eq!(names(&place.path("man1")), expected);
    let page = place.read("man1/slipgrid-optimize.1");
    assert!(page.contains(".TH slipgrid-optimize 1") && page.contains("Design file"), "{page}");
    let page = place.read("man1/slipgrid-campaign-work.1");
    assert!(page.contains(".TH slipgrid-campaign-work 1") && page.contains("Folder of the campaign"), "{page}");
}

/// The template explains every key that the reader accepts in each table of a calibration.
#[test]
fn the_calibration_template_explains_every_key() {
    let place = Place::with(&[]);
    place.succeed(&["new", "calibration"]);
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
    for table in [
        "",
        "[material]",
        "[surface]",
        "[specimen]",
        "[measurements]",
        "[traces]",
        "[[traces.condition]]",
        "[pattern]",
        "[fit]",
    ] {
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
