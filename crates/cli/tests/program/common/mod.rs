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
pub const SCENE: &str = r#"[material]
youngs_modulus_gpa = 0.38
density_g_cm3 = 0.9
[material.friction]
static_mean = 0.30
dynamic_mean = 0.27
relative_std = 0.05
[material.area_law]
pressure_mpa = [0.7, 1.3, 2.6, 10.0]
factor = [1.0, 0.96, 0.90, 0.60]
[pattern]
width_um = 130.0
spacing_um = 370.0
depth_um = 20.0
planform = "groove"
[sample]
length_um = 9960.0
layer_um = 200.0
block_um = 10.0
[load]
pressure_mpa = [0.65, 2.6]
speed_mm_s = 2.0
[run]
fidelity = "steady"
extent = "cell"
seed = 1
sliding_um = 2.0
"#;

/// Measurements of flat friction at three forces.
pub const THREE_FORCES: &str = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.25,0.002\n\
    75,2,15,0.25,0.002\n100,2,15,0.26,0.002\n";

/// [`CALIBRATION`] with the table patterned.csv beside flat.csv.
pub fn patterned() -> String {
    CALIBRATION.replace("flat = \"flat.csv\"", "flat = \"flat.csv\"\npatterned = \"patterned.csv\"")
}

/// Calibration of [`patterned`] with the lines `pattern` of `[pattern]`.
pub fn patterned_calibration(pattern: &str) -> String {
    format!("{}[pattern]\n{pattern}", patterned())
}

/// Scene or design `text` with the material of `file` at 2 mm/s and 15 % in place of its own.
pub fn measured(text: &str, file: &str) -> String {
    let (head, _) = text.split_once("[material]").unwrap();
    let rest = text.find("[target]").or_else(|| text.find("[pattern]")).unwrap();
    let condition = "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }";
    format!("{head}material = \"{file}\"\n{condition}\n{}", &text[rest..])
}

/// Design with an inline material.
pub const DESIGN: &str = r#"name = "test design"
[material]
youngs_modulus_gpa = 0.38
density_g_cm3 = 0.9
[material.friction]
static_mean = 0.30
dynamic_mean = 0.27
[material.area_law]
pressure_mpa = [0.7, 1.3, 2.6, 10.0]
factor = [1.0, 0.9, 0.7, 0.3]
[target]
quantity = "ratio"
pressure_mpa = [0.65, 2.6]
value = 0.9
tolerance = 0.01
[bounds]
width_um = [40.0, 400.0]
spacing_um = [40.0, 1000.0]
depth_um = [2.0, 50.0]
[pattern]
planform = "groove"
[limits]
min_land_um = 40.0
depth_per_burst_um = 2.6
max_peak_pressure_mpa = 20.0
[laser]
wavelength_nm = 1064.0
spot_um = 23.0
[specimen]
shape = "disc"
diameter_mm = 10.0
[sample]
layer_um = 200.0
block_um = 10.0
[search]
seed = 1
"#;

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

/// Design that is searched and confirmed in a third of a second.
pub fn small() -> String {
    DESIGN
        .replace("width_um = [40.0, 400.0]", "width_um = [40.0, 80.0]")
        .replace("spacing_um = [40.0, 1000.0]", "spacing_um = 60.0")
        .replace("depth_um = [2.0, 50.0]", "depth_um = 5.2")
        .replace("layer_um = 200.0", "layer_um = 40.0")
        .replace("block_um = 10.0", "block_um = 20.0")
        .replace("diameter_mm = 10.0", "diameter_mm = 1.0")
        .replace("tolerance = 0.01", "tolerance = 0.08")
}

/// Calibration that reads the table `flat.csv` in its folder.
pub const CALIBRATION: &str = r#"name = "test"
source = "nowhere"
[material]
youngs_modulus_gpa = 0.38
youngs_modulus_std_gpa = 0.08
density_g_cm3 = 0.9
[surface]
persson_rms_slope = 0.0137
[specimen]
radius_mm = 5.0
[measurements]
flat = "flat.csv"
[fit]
coefficients = "per-condition"
"#;

/// Table of measurements for [`CALIBRATION`].
pub const FLAT: &str = "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n50,2,15,0.248,0.002\n";

/// Command of the program without the cache of the user's earlier runs.
pub fn program() -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_slipgrid"));
    command.env("SLIPGRID_CACHE", "");
    command
}

/// Folder with input files, in which the program is run.
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

/// Content of a result.json made by hand, from which files for the laser can be exported without any solver; the
/// arguments are keys of its tables.
pub fn by_hand(design: &str, laser: &str, specimen: &str) -> String {
    format!(
        r#"{{"name": "by hand", "version": "0", "seed": 1, "design": {{"width_um": 130.0, "spacing_um": 370.0,
        "depth_um": 5.2, {design}, "areal_density": 0.1, "section_density": 0.1}}, "laser": {{{laser}}},
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

/// Stdout and result.json of `optimize` of `file`, which must end with `code`.
pub fn optimized(place: &Place, file: &str, code: i32) -> (String, Value) {
    let output = place.run(&["optimize", file]);
    assert_eq!(output.status.code(), Some(code), "{file}: {}", String::from_utf8_lossy(&output.stderr));
    let folder = format!("out/{}", file.trim_end_matches(".toml"));
    (String::from_utf8(output.stdout).unwrap(), result(place, &folder))
}

/// Names and contents of all files of a folder, except those that depend on time, with unfinished files and folders.
pub fn untimed(place: &Place, folder: &str) -> Vec<(String, Vec<u8>)> {
    let folder = place.path(folder);
    let read = |name: String| {
        let path = folder.join(&name);
        (name, if path.is_dir() { Vec::new() } else { fs::read(path).unwrap() })
    };
    names(&folder).into_iter().filter(|name| name != "timings.json").map(read).collect()
}

/// Parses JSON from stdout or a file.
pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

/// Content of result.json in a folder of `place`.
pub fn result(place: &Place, folder: &str) -> Value {
    json(&place.read(&format!("{folder}/result.json")))
}

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

/// Correction of the ratio of `load` for `effect`, if there is one.
pub fn correction<'a>(load: &'a Value, effect: &str) -> Option<&'a Value> {
    load["corrections"].as_array().unwrap().iter().find(|correction| correction["effect"] == effect)
}

impl Place {
    /// Creates a folder with `files`, given by name and content.
    pub fn with(files: &[(&str, &str)]) -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap(), cache: None };
        for (name, text) in files {
            place.write(name, text);
        }
        place
    }

    /// Like [`Self::with`], with a cache of its own for the runs in this folder.
    pub fn with_cache(files: &[(&str, &str)]) -> Self {
        Self { cache: Some(tempfile::tempdir().unwrap()), ..Self::with(files) }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// ln(measured / modelled) of the first patterned measurement of the calibration NAME.toml.
    pub fn log_excess(&self, name: &str) -> f64 {
        self.succeed(&["calibrate", &format!("{name}.toml"), "-o", &format!("{name}-m.toml")]);
        let table = self.toml(&format!("{name}-m.toml"));
        let ratio = |key: &str| table["learned"]["trial"][0][key][0].as_float().unwrap();
        (ratio("measured_ratio") / ratio("modelled_ratio")).ln()
    }

    /// Text of a file of the folder.
    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    /// Content of a TOML file of the folder.
    pub fn toml(&self, name: &str) -> toml::Table {
        self.read(name).parse().unwrap()
    }

    /// Writes a file into the folder.
    pub fn write(&self, name: &str, text: impl AsRef<[u8]>) {
        fs::write(self.path(name), text).unwrap();
    }

    /// Names of all entries of the folder, including hidden files.
    pub fn names(&self) -> Vec<String> {
        names(self.folder.path())
    }

    /// Names of the entries of `folder` within this one, separated by spaces.
    pub fn listed(&self, folder: &str) -> String {
        names(&self.path(folder)).join(" ")
    }

    /// Names of all that the runs in this folder kept in the cache.
    pub fn cached(&self) -> Vec<String> {
        names(self.cache.as_ref().map_or_else(|| shared_cache(), |cache| cache.path()))
    }

    /// The program in this folder with `args`.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = self.uncached(args);
        command.env("SLIPGRID_CACHE", self.cache.as_ref().map_or_else(|| shared_cache(), |cache| cache.path()));
        command
    }

    /// Like [`Self::command`], without results of earlier runs.
    pub fn uncached(&self, args: &[&str]) -> Command {
        let mut command = program();
        command.current_dir(self.folder.path()).args(args);
        command
    }

    /// Starts [`Self::uncached`] without waiting for it.
    pub fn begin(&self, args: &[&str]) -> Child {
        self.uncached(args).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    }

    /// Runs the program with `--details` where it has that option: tests read all that is known of a result.
    pub fn run(&self, args: &[&str]) -> Output {
        let mut command = self.command(args);
        let has_details = ["optimize", "simulate", "calibrate", "trials"].contains(args.first().unwrap_or(&""));
        if has_details && !args.contains(&"--json") {
            command.arg("--details");
        }
        command.output().unwrap()
    }

    /// Stdout of a run, which must succeed.
    pub fn succeed(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert!(output.status.success(), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// JSON on the stdout of a run, which must succeed.
    pub fn json(&self, args: &[&str]) -> Value {
        json(&self.succeed(args))
    }

    /// Stderr of a run, which must succeed.
    pub fn told(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let message = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{args:?}: {message}");
        message
    }

    /// Like [`Self::succeed`], for arguments separated by spaces.
    pub fn succeed_line(&self, line: &str) -> String {
        self.succeed(&line.split_whitespace().collect::<Vec<_>>())
    }

    /// Message of a run that must refuse its input, with exit code 2 and nothing on stdout.
    pub fn refuse(&self, args: &[&str]) -> String {
        let output = self.run(args);
        let message = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{args:?}: {message}");
        assert!(output.stdout.is_empty(), "{args:?}");
        message
    }
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
