//! Helpers that run the program in a folder of its own.

#![allow(dead_code, reason = "each test file uses a part")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::LazyLock;

use serde_json::Value;
use tempfile::TempDir;

/// All commands, separated by spaces.
pub const COMMANDS: &str = "simulate optimize explore calibrate next trials area-law studio surface traces synthesize \
                            export validate accuracy campaign new completions man";

/// Scene that is solved in milliseconds.
pub const SCENE: &str = include_str!("../../../../../tests/golden/inputs/scene.toml");

/// Measurements of flat friction at three forces.
pub const THREE_FORCES: &str = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.25,0.002\n\
    75,2,15,0.25,0.002\n100,2,15,0.26,0.002\n";

/// [`CALIBRATION`] with the table patterned.csv beside flat.csv, and `more` below.
pub fn patterned(more: &str) -> String {
    CALIBRATION.replace("flat = \"flat.csv\"", "flat = \"flat.csv\"\npatterned = \"patterned.csv\"") + more
}

/// Scene or design `text` with the material of `file` at 2 mm/s and 15 % in place of its own.
pub fn measured(text: &str, file: &str) -> String {
    let (head, _) = text.split_once("[material]").unwrap();
    let rest = text.find("[target]").or_else(|| text.find("[pattern]")).unwrap();
    let condition = "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }";
    format!("{head}material = \"{file}\"\n{condition}\n{}", &text[rest..])
}

/// Design with an inline material.
pub const DESIGN: &str = include_str!("../../../../../tests/golden/inputs/wide-design.toml");

/// Table `[material.learned]` of a model that is trusted: the prior of the discrepancy is nearly zero.
const TRUST: &str = "[material.learned]\nreference_pressure_mpa = 1.5\nlowest_pressure_mpa = 0.65\n\
    reference_speed_mm_s = 2.0\nmodulus_relative_std = 0.0\n[material.learned.prior]\namplitude_std = 0.002\n\
    pressure_std = 0.001\ninverse_pressure_std = 0.001\nspeed_std = 0.001\nhumidity_std = 0.001\nsample_std = 0.001\n";

/// Design `text` with a trusted model, so that the likeliest sample has its modelled ratio on target.
pub fn trusted(text: &str) -> String {
    text.replace("[target]", &format!("{TRUST}[target]"))
}

/// Lines of a design whose width alone is free, which saves four fifths of the time of a table of all three lengths.
const LINE: [(&str, &str); 2] =
    [("spacing_um = 120.0", "spacing_um = [40.0, 200.0]"), ("depth_um = 10.4", "depth_um = [2.0, 20.0]")];

/// Design of grooves 40 to 100 um wide in a thin layer on a short sample.
pub fn short() -> String {
    DESIGN
        .replace("diameter_mm = 10.0", "diameter_mm = 2.0")
        .replace("layer_um = 200.0", "layer_um = 60.0")
        .replace("width_um = [40.0, 400.0]", "width_um = [40.0, 100.0]")
        .replace("spacing_um = [40.0, 1000.0]", LINE[0].0)
        .replace("depth_um = [2.0, 50.0]", LINE[1].0)
}

/// Design of [`short`] with spacing and depth free as well.
pub fn free(design: &str) -> String {
    LINE.iter().fold(design.to_owned(), |design, (fixed, free)| design.replace(fixed, free))
}

/// Design of [`short`] at one pressure with another target, and `more` below.
pub fn short_at_one_pressure(target: &str, more: &str) -> String {
    short().replace("[0.65, 2.6]", "[2.6]").replace("value = 0.9\ntolerance = 0.01", target) + more
}

/// Design of discs in a thin layer, which is searched, confirmed and explained in space, as its target is out of reach.
pub fn discs() -> String {
    DESIGN
        .replace("value = 0.9", "value = 0.5")
        .replace("\"groove\"", "\"disc\"")
        .replace("[40.0, 1000.0]", "60.0")
        .replace("[40.0, 400.0]", "[40.0, 60.0]")
        .replace("[2.0, 50.0]", "10.4")
        .replace("layer_um = 200.0", "layer_um = 80.0")
        .replace("block_um = 10.0", "block_um = 20.0")
}

/// Design that is searched and confirmed in a third of a second.
pub fn small() -> String {
    include_str!("../../../../../tests/golden/inputs/design.toml")
        .replace("spacing_um = [40.0, 80.0]", "spacing_um = 60.0")
        .replace("depth_um = [2.0, 10.0]", "depth_um = 5.2")
}

/// Calibration that reads the table `flat.csv` in its folder.
pub const CALIBRATION: &str = include_str!("../../../../../tests/golden/inputs/calibration.toml");

/// Table of measurements for [`CALIBRATION`].
pub const FLAT: &str = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.248,0.002\n";

/// Command of the program without the cache of the user's earlier runs.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slipgrid"));
    command.env("SLIPGRID_CACHE", "");
    command
}

/// Content of a result.json made by hand, from which files for the laser can be exported without any solver; the
/// arguments are keys of its tables.
pub fn by_hand(design: &str, laser: &str, specimen: &str) -> String {
    format!(
        r#"{{"name": "by hand", "program": "slipgrid", "version": "0", "seed": 1, "design": {{"width_um": 130.0,
        "spacing_um": 370.0, "depth_um": 5.2, {design}, "areal_density": 0.1, "section_density": 0.1}}, "laser": {{{laser}}},
        "specimen": {{{specimen}}},
        "material": {{"name": "", "source": "", "synthetic_surface": false, "notes": []}}}}"#
    )
}

/// Result of [`by_hand`] with many squares, so that its files are large.
pub fn many_squares(diameter_mm: f64) -> String {
    let specimen = format!(r#""shape": "disc", "diameter_mm": {diameter_mm:.1}"#);
    let result = by_hand(r#""planform": "square""#, r#""spot_um": 23.0"#, &specimen);
    result.replace("130.0", "40.0").replace("370.0", "50.0")
}

/// Number at `pointer` in `value`.
pub fn at(value: &Value, pointer: &str) -> f64 {
    let found = value.pointer(pointer).and_then(Value::as_f64);
    found.unwrap_or_else(|| panic!("no number at {pointer} of {value}"))
}

/// Number at `pointer` in each row of a list.
pub fn column(rows: &Value, pointer: &str) -> Vec<f64> {
    rows.as_array().unwrap().iter().map(|row| at(row, pointer)).collect()
}

/// Row of a list with this text under `key`, if there is one.
pub fn row<'a>(rows: &'a Value, key: &str, text: &str) -> Option<&'a Value> {
    rows.as_array().unwrap().iter().find(|row| row[key] == text)
}

/// Row of `limited_by` of the result `found`.
pub fn limit<'a>(found: &'a Value, input: &str) -> &'a Value {
    row(&found["limited_by"], "input", input).unwrap_or_else(|| panic!("{input}: {}", found["limited_by"]))
}

/// Correction of the ratio of `load` for `effect`, if there is one.
pub fn correction<'a>(load: &'a Value, effect: &str) -> Option<&'a Value> {
    row(&load["corrections"], "effect", effect)
}

/// Folder with input files, in which the program is run. Commands are lines of words without quotes.
pub struct Place {
    folder: TempDir,
    /// Cache of this folder's runs; `None` if it is shared with other folders.
    cache: Option<TempDir>,
}

/// Cache shared by the runs of this test program, as a user's runs share one: many tests begin with the same fits and
/// runs in time of the flat sample. It is empty at first, so that nothing comes from an older version of the program.
fn shared_cache() -> &'static Path {
    static CACHE: LazyLock<PathBuf> = LazyLock::new(|| {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("kept");
        let _ = fs::remove_dir_all(&folder);
        folder
    });
    &CACHE
}

impl Place {
    /// Creates a folder with `files`, given by name and content.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap(), cache: None };
        files.iter().for_each(|(name, text)| place.write(name, text));
        place
    }

    /// Like [`Self::with`], with a cache of its own for the runs in this folder.
    pub fn with_cache(files: &[(&str, &str)]) -> Self {
        Self { cache: Some(tempfile::tempdir().unwrap()), ..Self::with(files) }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    pub fn toml(&self, name: &str) -> toml::Table {
        self.read(name).parse().unwrap()
    }

    /// Content of result.json in `folder`.
    pub fn result(&self, folder: &str) -> Value {
        json(&self.read(&format!("{folder}/result.json")))
    }

    /// Writes a file into the folder.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Names of the entries of `folder` within this one, including hidden ones, separated by spaces.
    pub fn listed(&self, folder: &str) -> String {
        names(&self.path(folder)).join(" ")
    }

    /// Names and contents of all files of a folder, except those that depend on time, with unfinished files and folders.
    pub fn untimed(&self, folder: &str) -> Vec<(String, Vec<u8>)> {
        let folder = self.path(folder);
        let read = |name: String| {
            let path = folder.join(&name);
            (name, if path.is_dir() { Vec::new() } else { fs::read(path).unwrap() })
        };
        names(&folder).into_iter().filter(|name| name != "timings.json").map(read).collect()
    }

    /// Folder of the results that the runs in this folder keep.
    pub fn cache(&self) -> &Path {
        self.cache.as_ref().map_or_else(|| shared_cache(), |cache| cache.path())
    }

    /// The program in this folder without results of earlier runs.
    pub fn uncached(&self, line: &str) -> Command {
        let mut command = program();
        command.current_dir(self.folder.path()).args(line.split_whitespace());
        command
    }

    /// Starts [`Self::uncached`] without waiting for it.
    pub fn begin(&self, line: &str) -> Child {
        self.uncached(line).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// Exit code, stdout and stderr of a run.
    pub fn run(&self, line: &str) -> (i32, String, String) {
        let Output { status, stdout, stderr } =
            self.uncached(line).env("SLIPGRID_CACHE", self.cache()).output().unwrap();
        let [stdout, stderr] = [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        (status.code().unwrap(), stdout, stderr)
    }

    /// Stdout and stderr of a run that must end with `code`.
    pub fn ends(&self, line: &str, code: i32) -> (String, String) {
        let (ended, stdout, stderr) = self.run(line);
        assert_eq!(ended, code, "{line}: {stdout}{stderr}");
        (stdout, stderr)
    }

    /// Stdout of a run, which must succeed.
    pub fn succeed(&self, line: &str) -> String {
        self.ends(line, 0).0
    }

    /// Stderr of a run, which must succeed.
    pub fn told(&self, line: &str) -> String {
        self.ends(line, 0).1
    }

    /// JSON on the stdout of a run, which must succeed.
    pub fn json(&self, line: &str) -> Value {
        json(&self.succeed(line))
    }

    /// Ratios of `simulate` of a scene at every load.
    pub fn ratios(&self, scene: &str) -> Vec<f64> {
        column(&self.json(&format!("simulate {scene} --json"))["results"], "/ratio")
    }

    /// Stdout and result.json of `optimize` of NAME.toml, which must end with `code`.
    pub fn optimized(&self, name: &str, code: i32) -> (String, Value) {
        (self.ends(&format!("optimize {name}.toml --details"), code).0, self.result(&format!("out/{name}")))
    }

    /// ln(measured / modelled) of the first patterned measurement of the calibration NAME.toml.
    pub fn log_excess(&self, name: &str) -> f64 {
        self.succeed(&format!("calibrate {name}.toml -o {name}-m.toml"));
        let table = self.toml(&format!("{name}-m.toml"));
        let ratio = |key: &str| table["learned"]["trial"][0][key][0].as_float().unwrap();
        (ratio("measured_ratio") / ratio("modelled_ratio")).ln()
    }

    /// Message of a run that must refuse its input, with exit code 2 and nothing on stdout.
    pub fn refuse(&self, line: &str) -> String {
        let (stdout, message) = self.ends(line, 2);
        assert!(stdout.is_empty(), "{line}");
        message
    }

    /// Refuses every line of a table of commands and of a part of their messages, with ` => ` between them.
    pub fn refuse_all(&self, table: &str) {
        for (line, says) in table.trim().lines().map(|row| row.split_once(" => ").unwrap()) {
            let message = self.refuse(line);
            assert!(message.contains(says.trim()), "{line}: {message}");
        }
    }
}

pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

pub fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    // The list of what was written is no result.
    names.retain(|name| name != ".slipgrid-written");
    names.sort();
    names
}

/// Whether the tests were started with Ctrl-C ignored, as shells start background jobs. The program then ignores Ctrl-C
/// as well, and there is nothing to test.
pub fn ignores_ctrl_c() -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).unwrap_or(0);
    // Bit 1 is signal 2.
    mask >> 1 & 1 == 1
}
