//! Flags that must be refused: exit code 2, the flag and its value in the message, nothing written.

use crate::common::{Place, SCENE};

#[test]
fn flags() {
    let folder = Place::with(&[("scene.toml", SCENE), ("map.txt", "1 2 3 4\n1 2 3 5\n")]);
    for (args, says) in [
        (vec!["simulate", "absent.toml"], "error: absent.toml: cannot be read"),
        (vec!["simulate", "scene.toml", "-o", "map.txt"], "error: --output: map.txt is a file"),
        (vec!["simulate", "scene.toml", "-o", "map.txt/below"], "error: --output: map.txt/below cannot be made"),
        (vec!["simulate", "scene.toml", "--fidelity", "fast"], "error: invalid value 'fast'"),
        (vec!["simulate", "scene.toml", "--threads", "0"], "error: invalid value '0'"),
        (
            vec!["simulate", "scene.toml", "--threads", "100000"],
            "error: invalid value '100000' for '--threads <N>': expected a whole number from 1 to 1024",
        ),
        (vec!["polish"], "error: unrecognized subcommand 'polish'"),
        (vec!["accuracy", "--quick", "--full"], "error: the argument '--quick' cannot be used with '--full'"),
        (vec!["accuracy", "--seeds", "0"], "error: invalid value '0'"),
        (vec!["accuracy", "missing.toml"], "error: missing.toml: cannot be read"),
        (vec!["accuracy", "-o", "map.txt"], "error: --output: map.txt is a file"),
        (vec!["area-law", "map.txt"], "error: map.txt: "),
        (
            vec!["area-law", "map.txt"],
            "error: map.txt: the unit of the heights and the pixel size are not known; expected a header line such as \"# Value units: um\", \
             or a unit by option: m, cm, mm, um, nm, pm; and header lines such as",
        ),
        (
            vec!["area-law", "map.txt", "--pixel-um", "1"],
            "error: map.txt: the unit of the heights is not known; expected a header line such as \"# Value units: um\", \
             or a unit by option: m, cm, mm, um, nm, pm (--height-unit um; in a calibration's [surface]: height_unit",
        ),
        (
            vec!["surface", "map.txt", "--height-unit", "um"],
            "error: map.txt: the pixel size is not known; expected header lines such as \"# Width: 1 mm\" and \
             \"# Height: 1 mm\", or a pixel size by option (--pixel-um 0.5; in",
        ),
        (vec!["area-law", "map.txt", "--pressures-mpa", "2,1"], "error: --pressures-mpa: 1 does not exceed"),
        (vec!["area-law", "map.txt", "--poisson-ratio", "0.7"], "error: --poisson-ratio: 0.7 is out of range"),
        (vec!["area-law", "map.txt", "--threshold-mpa", "0"], "error: --threshold-mpa: 0 is out of range"),
        (vec!["area-law", "map.txt", "--persson-rms-slope", "0.01"], "error: the argument"),
        (vec!["area-law", "--persson-rms-slope", "-1"], "error: "),
        (
            vec!["area-law", "--persson-rms-slope", "0.01", "--crop", "0,0,2,2"],
            "error: the argument '--persson-rms-slope <SLOPE>' cannot be used with '--crop",
        ),
        (
            vec!["area-law", "--persson-rms-slope", "0.01", "--form", "mean"],
            "error: the argument '--persson-rms-slope <SLOPE>' cannot be used with '--form",
        ),
        (vec!["area-law", "map.txt", "--pressures-mpa", "-1,2"], "error: --pressures-mpa: -1 is out of range"),
        (vec!["campaign", "work", "out", "--max-seconds", "-1"], "error: invalid value '-1' for '--max-seconds <S>'"),
        (vec!["next", "map.txt", "--candidate", "-1,2,3"], "error: map.txt"),
        (vec!["area-law"], "error: the following required arguments"),
        (vec!["area-law", "map.txt", "--height-unit", "inch"], "error: --height-unit: "),
        (vec!["synthesize", "--waves", "64:4", "-o", "m"], "error: invalid value '64:4'"),
        (vec!["synthesize", "--sa-um", "-1", "-o", "m"], "error: --sa-um: -1 is out of range"),
        (vec!["synthesize", "--sa-um", "1e300", "-o", "m"], "error: --sa-um: 1e300 is out of range"),
        (
            vec!["synthesize", "--pixels", "64", "-o", "m"],
            "error: --waves: 4:64 has waves that 64 pixels per side do not resolve; expected at most 31 waves",
        ),
        (vec!["synthesize", "--cavities", "5000,5000,3", "-o", "m"], "error: --cavities: 5000,5000,3 cuts none"),
        (vec!["export", "scene.toml"], "error: scene.toml: seems to be a scene file, which `slipgrid simulate` takes"),
        (vec!["export", "map.txt"], "error: map.txt:1: is not a result of `slipgrid optimize`"),
        (
            vec!["area-law", "scene.toml"],
            "error: scene.toml: seems to be a scene file, which `slipgrid simulate` takes",
        ),
        (vec!["validate"], "error: calibration/ldpe-cast-iron/calibration.toml: cannot be read"),
        (vec!["validate", "--depth-um", "200"], "error: --depth-um: 200 leaves nothing of the layer of 200 um"),
        (vec!["validate", "--width-um", "-1"], "error: --width-um: -1 is out of range"),
        (vec!["validate", "--width-um", "0"], "error: --width-um: 0 is out of range"),
        (
            vec!["validate", "--sliding-um=-3"],
            "error: --sliding-um: -3 is out of range; expected a number from 0 up to 100 um",
        ),
        (
            vec!["next", "scene.toml", "--one-disc"],
            "error: --count: 1 cannot be the number of sectors of one specimen, which --one-disc asks for; expected 2 to 12",
        ),
        (
            vec!["next", "scene.toml", "--one-disc", "--count", "13"],
            "error: --count: 13 cannot be the number of sectors of one specimen, which --one-disc asks for; expected 2 to 12",
        ),
        (vec!["validate", "--slope-factors", "0"], "error: --slope-factors: 0 is out of range"),
        (vec!["validate", "-o", "map.txt"], "error: --output: map.txt is a file"),
    ] {
        let message = folder.refuse(&args);
        assert!(message.starts_with(says), "{args:?}: {message}");
        assert_eq!(folder.names(), ["map.txt", "scene.toml"], "{args:?}");
    }
    let mut command = crate::common::program();
    let ended = command.env("RAYON_NUM_THREADS", "100000").args(["new", "scene", "new.toml"]).output().unwrap();
    let message = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(message.starts_with("error: RAYON_NUM_THREADS: 100000 is no number of threads"), "{message}");
    assert!(ended.status.code() == Some(2) && !folder.path("new.toml").exists());
}
