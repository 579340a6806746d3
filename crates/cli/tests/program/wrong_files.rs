//! Wrong input files: folders, and files without an end. `tests/golden` keeps what is said of files of other commands.

use crate::common::{CALIBRATION, Place};

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
    folder.write("mine/calibration.toml", CALIBRATION);
    let message = folder.refuse(&["calibrate", "mine"]);
    assert!(message.contains("(did you mean `mine/calibration.toml`?)"), "{message}");
    assert!(!folder.refuse(&["optimize", "mine"]).contains("did you mean"));
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
