//! Wrong input files: files of another command, folders, empty files.

use crate::common::{CALIBRATION, DESIGN, FLAT, Place, SCENE};

#[test]
fn a_file_given_to_another_command() {
    let material =
        "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n[friction]\nstatic_mean = 0.3\ndynamic_mean = 0.27\n";
    let result = "{\"design\": {}}";
    let folder = Place::with(&[
        ("scene.toml", SCENE),
        ("design.toml", DESIGN),
        ("calibration.toml", CALIBRATION),
        ("flat.csv", FLAT),
        ("material.toml", material),
        ("result.json", result),
        ("campaign.toml", "base = \"scene.toml\"\n[[grid]]\nkey = \"load.pressure_mpa\"\nvalues = [1.0]\n"),
    ]);
    let before = folder.names();
    let kinds = [
        ("scene.toml", "a scene file", "simulate"),
        ("design.toml", "a design file", "optimize"),
        ("calibration.toml", "a calibration file", "calibrate"),
        ("material.toml", "a material file", ""),
        ("result.json", "a result of `slipgrid optimize`", "export"),
        ("campaign.toml", "a campaign file", "campaign plan"),
    ];
    for command in ["simulate", "optimize", "calibrate", "export", "traces", "validate", "accuracy", "campaign plan"] {
        for (file, kind, takes) in kinds {
            let own = match command {
                "traces" | "validate" => "calibrate",
                "accuracy" => "simulate",
                other => other,
            };
            // Traces are tables; one .toml beside them is taken for a calibration.
            if takes != own && (command != "traces" || file.ends_with(".toml")) {
                let words: Vec<&str> = command.split(' ').chain([file]).collect();
                let output: &[&str] = if command == "campaign plan" { &["-o", "out"] } else { &[] };
                let message = folder.refuse(&[&words[..], output].concat());
                let says = format!("error: {file}: seems to be {kind}, which");
                assert!(message.starts_with(&says) && message.lines().count() == 1, "{command}: {message}");
                assert!(takes.is_empty() || message.contains(&format!("`slipgrid {takes}`")), "{command}: {message}");
            }
        }
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn a_folder_in_place_of_a_file() {
    let folder = Place::with(&[]);
    std::fs::create_dir(folder.path("mine")).unwrap();
    for command in ["simulate", "optimize", "calibrate", "export", "traces", "surface", "area-law", "validate"] {
        let message = folder.refuse(&[command, "mine"]);
        assert!(message.starts_with("error: mine: is a folder"), "{command}: {message}");
        assert!(message.contains("; expected "), "{command}: {message}");
    }
    // The one that was meant is named.
    std::fs::write(folder.path("mine/calibration.toml"), CALIBRATION).unwrap();
    let message = folder.refuse(&["calibrate", "mine"]);
    assert!(message.contains("(did you mean `mine/calibration.toml`?)"), "{message}");
    assert!(!folder.refuse(&["optimize", "mine"]).contains("did you mean"));
}

#[test]
fn an_empty_file_and_a_missing_table_are_said_with_the_command_that_writes_one() {
    let cut = DESIGN.find("[target]").unwrap()..DESIGN.find("[bounds]").unwrap();
    let without_target = DESIGN.replace(&DESIGN[cut], "");
    let place = Place::with(&[("empty.toml", "# nothing\n"), ("design.toml", &without_target)]);
    for (args, file, writes) in [
        (&["optimize", "empty.toml"][..], "empty.toml: holds no keys", "`slipgrid new design`"),
        (&["simulate", "empty.toml"], "empty.toml: holds no keys", "`slipgrid new scene`"),
        (&["calibrate", "empty.toml"], "empty.toml: holds no keys", "`slipgrid new calibration`"),
        (&["campaign", "plan", "empty.toml", "-o", "out"], "empty.toml: holds no keys", "base = \"scene.toml\""),
        (
            &["optimize", "design.toml"],
            "design.toml:1: target: is missing; expected a table [target]",
            "`slipgrid new design`",
        ),
    ] {
        let message = place.refuse(args);
        assert!(message.starts_with(&format!("error: {file}")) && message.contains(writes), "{message}");
    }
}

#[test]
#[cfg(unix)]
fn a_file_without_an_end_is_refused() {
    let place = Place::with(&[]);
    for command in ["simulate", "optimize", "calibrate", "export"] {
        let message = place.refuse(&[command, "/dev/zero"]);
        assert!(message.starts_with("error: /dev/zero: cannot be read: it has more than 64 MiB"), "{message}");
    }
}
