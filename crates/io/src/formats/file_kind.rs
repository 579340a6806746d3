//! Recognises the kind of a file by its tables, so that a design given to `simulate` is reported as such.

use std::path::{Path, PathBuf};

use slipgrid_surface::topography::{LengthUnit, MapFormat, ReadMap, ReadOptions, read_map};
use slipgrid_traces::cells::{cut, separator, unquoted};
use toml::de::{DeTable, DeValue};

use crate::formats::diagnostic::Diagnostic;
use crate::formats::source::Source;

/// Kinds of files that commands read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// Input of `simulate`.
    Scene,
    /// Input of `optimize`.
    Design,
    /// Input of `calibrate`.
    Calibration,
    /// Output of `calibrate`.
    Material,
    /// Output of `optimize`.
    Result,
    /// Input of `campaign plan`.
    Campaign,
}

impl FileKind {
    /// Apparent kind of `text`; `None` if there is no evidence or the evidence is contradictory.
    pub fn of(text: &str) -> Option<Self> {
        if text.trim_start().starts_with('{') {
            let read: serde_json::Value = serde_json::from_str(text).ok()?;
            return read.get("design").is_some().then_some(Self::Result);
        }
        let parsed = DeTable::parse(text).ok()?;
        let value = |key: &str| Some(parsed.get_ref().get(key)?.get_ref());
        let table = |key: &str| matches!(value(key), Some(DeValue::Table(_) | DeValue::Array(_)));
        let mut seen = [
            (Self::Scene, table("load")),
            (Self::Design, table("target") && table("bounds")),
            (Self::Calibration, table("measurements") || table("traces")),
            (Self::Material, table("friction")),
            (Self::Campaign, matches!(value("base"), Some(DeValue::String(_)))),
        ]
        .into_iter()
        .filter_map(|(kind, marked)| marked.then_some(kind));
        seen.next().filter(|_| seen.next().is_none())
    }

    /// Refuses `text`, read from `path`, if it seems to be a file of another kind.
    ///
    /// # Errors
    /// [`Diagnostic`] that names the apparent kind, the command that takes it, and the expected kind.
    pub fn require(self, path: &Path, text: &str) -> Result<(), Diagnostic> {
        let seems = match Self::of(text) {
            Some(found) if found != self => found.seems(),
            None if is_table_of_numbers(text) => TABLE_OF_NUMBERS,
            _ => return Ok(()),
        };
        Err(Diagnostic::file(path, seems).expected(self.expected()))
    }

    /// Creates a diagnostic for the folder at `path`, given in place of a file, which suggests the first file of this
    /// kind in the folder.
    pub fn refuse_folder(self, source: &Source, path: &Path) -> Diagnostic {
        let mut refused = Diagnostic::file(path, "is a folder").expected(self.expected());
        refused.suggestion = self.first_in(source, path).map(|inside| inside.display().to_string().into());
        refused
    }

    /// Description of the expected file for messages.
    pub const fn expected(self) -> &'static str {
        match self {
            Self::Scene => "a scene file, with [material] and [load]",
            Self::Design => "a design file, with [target] and [bounds]",
            Self::Calibration => "a calibration file, with [measurements] or [traces]",
            Self::Material => "a material file, with [friction], as `slipgrid calibrate` writes it",
            Self::Result => "result.json as `slipgrid optimize` or `next` writes it, or its folder",
            Self::Campaign => "a campaign file, with base = \"SCENE or DESIGN\"",
        }
    }

    /// Command that writes a file of this kind, or shows an example.
    pub const fn written_by(self) -> &'static str {
        match self {
            Self::Scene => "slipgrid new scene",
            Self::Design => "slipgrid new design",
            Self::Calibration => "slipgrid new calibration",
            Self::Material => "slipgrid calibrate",
            Self::Result => "slipgrid optimize",
            Self::Campaign => "slipgrid campaign --help",
        }
    }

    /// Keys needed in the required outermost table `key` of a file of this kind; `None` if `key` is no such table.
    pub fn needed_table(self, key: &str) -> Option<&'static str> {
        match (self, key) {
            (Self::Design, "target") => Some("quantity, pressure_mpa, and value with tolerance"),
            (Self::Design, "bounds") => Some("width_um, spacing_um and depth_um"),
            (Self::Design, "specimen") => Some("shape and diameter_mm, or what its shape needs"),
            (Self::Scene, "load") => Some("pressure_mpa and speed_mm_s"),
            (Self::Calibration, "material") => Some("youngs_modulus_gpa and density_g_cm3"),
            (Self::Calibration, "specimen") => Some("radius_mm, or what its shape needs"),
            (Self::Calibration, "measurements") => Some("flat = \"TABLE.csv\""),
            (Self::Material, "friction") => Some("static_mean and dynamic_mean"),
            _ => None,
        }
    }

    /// Reason to refuse a file of this kind where another is expected; names the command that reads it.
    pub const fn seems(self) -> &'static str {
        match self {
            Self::Scene => "seems to be a scene file, which `slipgrid simulate` takes",
            Self::Design => "seems to be a design file, which `slipgrid optimize` takes",
            Self::Calibration => "seems to be a calibration file, which `slipgrid calibrate` takes",
            Self::Material => "seems to be a material file, which scenes and designs name by material = \"PATH\"",
            Self::Result => "seems to be a result of `slipgrid optimize`, which `slipgrid export` takes",
            Self::Campaign => "seems to be a campaign file, which `slipgrid campaign plan` takes",
        }
    }

    /// First file of this kind in `folder` in the order of names; `None` if there is none.
    fn first_in(self, source: &Source, folder: &Path) -> Option<PathBuf> {
        let mut paths: Vec<PathBuf> = source.names(folder).iter().map(|name| folder.join(name)).collect();
        paths.retain(|path| path.extension().is_some_and(|extension| extension == "toml"));
        paths.sort();
        let text = |path: &PathBuf| String::from_utf8(source.read(path).ok()?).ok();
        paths.into_iter().find(|path| text(path).is_some_and(|text| Self::of(&text) == Some(self)))
    }
}

/// Reason to refuse a table of numbers; names the commands that read one.
const TABLE_OF_NUMBERS: &str = "is a table of numbers: `slipgrid surface` and `area-law` take an altitude map, `traces` a recording, and a \
                                calibration names tables of friction";

/// Whether no line of `text` assigns a value, and one has numbers alone, two or more. Lists of TOML may have such lines,
/// but follow a `=`.
fn is_table_of_numbers(text: &str) -> bool {
    let lines = || text.lines().filter(|line| !line.trim_start().starts_with('#'));
    let is_row = |line: &str| {
        let fields = || line.split([',', ';', '\t', ' ']).map(str::trim).filter(|field| !field.is_empty());
        fields().count() > 1 && fields().all(|field| field.parse::<f64>().is_ok())
    };
    lines().all(|line| !line.contains('=')) && lines().any(is_row)
}

/// Minimum number of heights in a line of a text that is recognised as an altitude map.
const MIN_COLUMNS: usize = 8;

/// Kinds of texts with rows of numbers, other than recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableKind {
    /// Heights of a surface, as points or as a matrix.
    AltitudeMap,
    /// Friction coefficients by load.
    Friction,
}

impl TableKind {
    /// Number of bytes from the start of a text by which its kind is recognised.
    pub const START_BYTES: usize = 1 << 18;

    /// Kind of a text that begins with `start`, as the readers of altitude maps and of tables of friction take it;
    /// `None` for any other text.
    pub fn of(start: &str) -> Option<Self> {
        let start = match start.as_bytes().get(..Self::START_BYTES) {
            Some(bytes) => &start[..=bytes.iter().rposition(|byte| *byte == b'\n')?],
            None => start,
        };
        let is_data = |line: &&str| !line.trim().is_empty() && !line.trim_start_matches([' ', '"']).starts_with('#');
        let header = start.trim_start_matches('\u{feff}').lines().find(is_data)?;
        let titles: Vec<&str> = cut(header, separator(header).unwrap_or(',')).into_iter().map(unquoted).collect();
        if titles.contains(&"force_n") && titles.iter().any(|title| ["mu", "mu_dynamic"].contains(title)) {
            return Some(Self::Friction);
        }
        // What a map does not state can be given as options.
        let unit = Some(LengthUnit::Micrometre);
        let options =
            ReadOptions { pixel_m: Some([1e-6; 2]), height_unit: unit, lateral_unit: unit, ..ReadOptions::default() };
        let ReadMap { map, format, .. } = read_map(start.as_bytes(), &options).ok()?;
        // Columns of a recording without titles are few, and as points leave most of their grid open. The points of a
        // line lie along x, which is down the rows of a map.
        let is_wide = format != MapFormat::Matrix || map.rows() >= MIN_COLUMNS;
        (is_wide && 2 * map.missing() < map.heights_m().len()).then_some(Self::AltitudeMap)
    }

    /// Reason to refuse a text of this kind where a recording is expected; says where it belongs.
    pub const fn is_no_recording(self) -> &'static str {
        match self {
            Self::AltitudeMap => "is an altitude map and no recording: `map` in [surface] names it",
            Self::Friction => {
                "is a table of friction coefficients and no recording: `flat` or `patterned` in [measurements] names it, or \
                 `measurements` in a [[trial]]"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Long texts are recognised by their start.
    #[test]
    fn maps_and_tables_of_friction_are_told_from_recordings() {
        let height = |i: u32, j: u32| f64::from((7 * i + 13 * j) % 11) / 10.0;
        let points = |mark: &str, side: u32| -> String {
            let point =
                |i: u32, j: u32| format!("{}{mark}{}{mark}{}\n", f64::from(i) / 2.0, f64::from(j) / 2.0, height(i, j));
            (0..side).flat_map(|j| (0..side).map(move |i| (i, j))).map(|(i, j)| point(i, j)).collect()
        };
        let matrix = |side: u32| -> String {
            let row = |j: u32| (0..side).map(|i| height(i, j).to_string()).collect::<Vec<_>>().join("\t") + "\n";
            (0..side).map(row).collect()
        };
        let trace = |rows: u32| -> String {
            (0..rows)
                .map(|row| format!("{};{};10\n", f64::from(row) / 10.0, 2.0 + f64::from(row % 7) / 100.0))
                .collect()
        };
        for side in [20, 400] {
            for map in [points(" ", side), points(",", side), format!("x,y,z\n{}", points(",", side)), matrix(side)] {
                assert_eq!(TableKind::of(&map), Some(TableKind::AltitudeMap), "{}", &map[..40]);
            }
        }
        let friction =
            "# flat samples\nforce_n;speed_mm_s;humidity_pct;mu_dynamic;mu_dynamic_std\n50;2;15;0,248;0,002\n";
        for table in [friction, "force_n,speed_mm_s,humidity_pct,mu\n50,2,15,0.248\n"] {
            assert_eq!(TableKind::of(table), Some(TableKind::Friction), "{table}");
        }
        for rows in [100, 20_000] {
            for none in [format!("time [s];Fx [N];Fz [N]\n{}", trace(rows)), trace(rows)] {
                assert_eq!(TableKind::of(&none), None, "{}", &none[..40]);
            }
        }
        for none in ["", "a text\n", "load [N],mu\n1,0.2\n", &"0.1 0.2 0.3 0.4\n".repeat(50)] {
            assert_eq!(TableKind::of(none), None, "{none}");
        }
    }

    #[test]
    fn kinds_are_told_by_their_tables() {
        for (text, kind) in [
            ("material = \"m.toml\"\n[load]\npressure_mpa = 1", Some(FileKind::Scene)),
            ("[material.friction]\n[load]", Some(FileKind::Scene)),
            ("load = 50.0", None),
            ("[target]\n[bounds]", Some(FileKind::Design)),
            ("[target]", None),
            ("[target]\n[bounds]\n[load]", None),
            ("[measurements]\n[fit]", Some(FileKind::Calibration)),
            ("[[traces]]", Some(FileKind::Calibration)),
            ("[[friction.conditions]]", Some(FileKind::Material)),
            ("base = \"scene.toml\"\n[[grid]]", Some(FileKind::Campaign)),
            ("base = \"scene.toml\"\n[load]", None),
            ("{\"design\": {}}", Some(FileKind::Result)),
            ("{}", None),
            ("{", None),
            ("[load", None),
            ("force_n,speed_mm_s\n50,2\n", None),
        ] {
            assert_eq!(FileKind::of(text), kind, "{text}");
        }
    }

    #[test]
    fn tables_of_numbers_are_told_from_toml() {
        for table in ["width_um,mu\n100,0.9\n", "# a = map\n1.0 2.0\n", "a;b\n1;2\n", "x\ty\n1e-3\t-2\n"] {
            let refused = FileKind::Design.require(Path::new("a.csv"), table).unwrap_err().to_string();
            assert!(refused.starts_with("a.csv: is a table of numbers: `slipgrid surface`"), "{refused}");
            assert!(refused.ends_with("expected a design file, with [target] and [bounds]"), "{refused}");
        }
        for other in ["value = [\n1.0, 2.0,\n", "", "load", "[load\n1 b\n", "1\n2\n"] {
            assert!(FileKind::Design.require(Path::new("a.toml"), other).is_ok(), "{other}");
        }
    }

    #[test]
    fn what_tells_nothing_is_left_to_the_reader() {
        let path = Path::new("a.toml");
        assert!(FileKind::Scene.require(path, "[run]").is_ok() && FileKind::Scene.require(path, "[load]").is_ok());
        assert_eq!(
            FileKind::Scene.require(path, "[target]\n[bounds]").unwrap_err().to_string(),
            "a.toml: seems to be a design file, which `slipgrid optimize` takes; expected a scene file, with [material] \
             and [load]"
        );
    }
}
