//! Finds the values that readers accept for a key: writes an invalid value and parses the refusal.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use slipgrid_book::keys::{all_keys, has_type};
use slipgrid_book::schema::{Accepted, is_judged};
use slipgrid_io::campaign::plan;
use slipgrid_io::disk::disk;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;
use slipgrid_io::formats::material::{MaterialFile, read_known};
use slipgrid_io::formats::scene::SceneInput;
use slipgrid_io::formats::{Diagnostic, Document};
use toml::{Table, Value};

use crate::{root, text};

/// Schemas of the types that are read, by the kind of file.
static SCHEMAS: LazyLock<[(&str, serde_json::Value); 5]> = LazyLock::new(slipgrid_io::schemas);

/// Kind of file, with examples that contain all tables, and its reader, which returns the read values as text.
pub struct Kind {
    /// Name of the kind.
    pub name: &'static str,
    /// Description of the kind of file in one sentence.
    pub meaning: &'static str,
    /// Accepted files of this kind, which together contain every table.
    examples: fn() -> Vec<String>,
    read: fn(&Path, &str) -> Result<String, Box<Diagnostic>>,
}

/// All kinds of TOML files that the program reads.
pub const KINDS: [Kind; 5] = [
    Kind {
        name: "material",
        meaning: "A material as `calibrate` writes it; a scene or a design may hold the same keys in its table `[material]`.",
        examples: materials,
        read: |path, text| {
            let document = Document::within(&disk(), path, text);
            let file: MaterialFile = document.parse()?;
            Ok(format!("{:?}", read_known(&document, &file, &(0..text.len()))?))
        },
    },
    Kind {
        name: "design",
        meaning: "What is wanted of a surface, read by `optimize`, `next` and `explore`.",
        examples: designs,
        read: |path, text| Ok(format!("{:?}", Design::from_document(Document::within(&disk(), path, text))?.task)),
    },
    Kind {
        name: "scene",
        meaning: "One surface under given loads, read by `simulate` and `accuracy`.",
        examples: scenes,
        read: |path, text| {
            let document = Document::within(&disk(), path, text);
            let input = SceneInput::from_document(document, slipgrid_io::formats::run::Overrides::default())?;
            Ok(format!("{:?}", (input.scene, input.specimen, input.material)))
        },
    },
    Kind {
        name: "calibration",
        meaning: "What was measured, read by `calibrate`, `traces` and `trials`, and by every command that takes a material.",
        examples: calibrations,
        read: |path, text| Ok(format!("{:?}", Calibration::from_document(&Document::within(&disk(), path, text))?)),
    },
    Kind {
        name: "campaign",
        meaning: "Many scenes or designs, read by `campaign plan`.",
        examples: campaigns,
        read: |path, text| {
            // A campaign reads a file that stands on the disk.
            let folder = tempfile::tempdir().unwrap();
            let copy = folder.path().join("campaign.toml");
            let base = path.parent().unwrap().join("scene-rims.toml").display().to_string();
            std::fs::write(&copy, text.replace("\"scene-rims.toml\"", &format!("{base:?}"))).unwrap();
            match plan(&disk(), &copy, &slipgrid_base::monitor::Unwatched) {
                Ok(planned) => Ok(format!("{:?}", planned.tasks)),
                Err(slipgrid_io::Failure::Refused(refused)) => Err(Box::new(refused)),
                Err(other) => panic!("{other}"),
            }
        },
    },
];

fn template(name: &str) -> String {
    text(&root().join("crates/cli/src/templates").join(name))
}

/// Uncomments the lines with `keys` in a template.
fn uncommented(text: &str, keys: &[&str]) -> String {
    let begins =
        |line: &str| keys.iter().any(|key| line.starts_with(&format!("# {key} =")) || line == format!("# [{key}]"));
    let bare = |line: &str| line.split("   ").next().unwrap_or(line).to_owned();
    let shown = text.lines().map(|line| match begins(&bare(line)) || begins(line) {
        true => line.trim_start_matches("# ").to_owned(),
        false => line.to_owned(),
    });
    shown.collect::<Vec<_>>().join("\n") + "\n"
}

fn designs() -> Vec<String> {
    let design = template("design.toml");
    let rims = ["rim_height_um", "rim_width_um", "tolerances", "width_std_um", "trade_offs", "goals"];
    vec![
        design.clone(),
        uncommented(&design, &rims),
        design.replace("depth_per_burst_um = 2.6", "# no burst")
            + "\n[laser.ablation]\nfluence_j_cm2 = [1.0, 2.0, 4.0]\n\
            depth_per_burst_um = [0.6, 1.1, 1.7]\n",
        design.replace("value = [0.95, 0.88]", "").replace("tolerance = 0.02", "goal = \"lowest\""),
        design.replace("planform = \"groove\"", "planform = \"square\""),
        design.replace("planform = \"groove\"", "planform = \"rectangle\"\nlength_um = 100.0"),
        design.replace("planform = \"groove\"", "planform = \"crosshatch\""),
        design.replace("planform = \"groove\"", "planform = \"polygon\"\nvertices_um = [[0, 0], [9, 0], [4, 6]]"),
        design
            .replace("shape = \"disc\"", "shape = \"ring\"")
            .replace("diameter_mm = 10.0", "outer_diameter_mm = 30.0\ninner_diameter_mm = 20.0"),
        design
            .replace("shape = \"disc\"", "shape = \"rectangle\"")
            .replace("diameter_mm = 10.0", "length_mm = 10.0\nwidth_mm = 10.0"),
        design.replace(
            "name = \"my design\"",
            "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }\n\
            also_at = [{ speed_mm_s = 2.0, humidity_pct = 15.0 }]",
        ),
    ]
}

fn scenes() -> Vec<String> {
    let scene = template("scene.toml");
    let specimen = "\n[specimen]\nshape = \"disc\"\ndiameter_mm = 10.0\n";
    vec![
        scene.clone(),
        scene.replace("length_um = 9960.0", "") + specimen,
        scene.replace("length_um = 9960.0", "")
            + "\n[specimen]\nshape = \"ring\"\nouter_diameter_mm = 30.0\ninner_diameter_mm = 20.0\n",
        scene.replace("length_um = 9960.0", "")
            + "\n[specimen]\nshape = \"rectangle\"\nlength_mm = 10.0\nwidth_mm = 10.0\n",
        uncommented(&scene, &["rim_height_um", "rim_width_um"]),
        scene.replace("planform = \"groove\"", "planform = \"square\""),
        scene.replace("planform = \"groove\"", "planform = \"rectangle\"\nlength_um = 100.0"),
        scene.replace("planform = \"groove\"", "planform = \"crosshatch\""),
        scene.replace("planform = \"groove\"", "planform = \"polygon\"\nvertices_um = [[0, 0], [9, 0], [4, 6]]"),
        scene.replace("name = \"my scene\"", "condition = { speed_mm_s = 2.0, humidity_pct = 15.0 }"),
    ]
}

fn calibrations() -> Vec<String> {
    let calibration = template("calibration.toml");
    let patterned = "[pattern]\nplanform = \"square\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let traces =
        "[traces]\n[[traces.condition]]\nforce_n = 1.0\nspeed_mm_s = 1.0\nhumidity_pct = 1.0\nfiles = [\"none.csv\"]\n";
    let trial = "[[trial]]\nname = \"cut-1\"\n[trial.pattern]\nplanform = \"groove\"\nwidth_um = 130.0\nspacing_um = 370.0\ndepth_um = 5.2\n";
    let of_trial = traces.replace("[traces]\n", "").replace("traces.condition", "trial.traces");
    let rims = "rim_height_um = 0.1\nrim_width_um = 20.0\n";
    let mapped = calibration.replace("persson_rms_slope = 0.0137", "map = \"flat-map.asc\"");
    let ring = "outer_diameter_mm = 30.0\ninner_diameter_mm = 20.0";
    vec![
        calibration.clone(),
        format!("{mapped}{trial}"),
        mapped,
        format!("{calibration}{patterned}{rims}"),
        format!("{calibration}{trial}"),
        format!("{calibration}{trial}{rims}"),
        format!("{calibration}{trial}{of_trial}"),
        format!("{calibration}[trial_prior]\n"),
        calibration
            .replace("[measurements]", "[measurements_]")
            .replace("flat = \"flat.csv\"", "")
            .replace("[measurements_]", "")
            + traces,
        calibration.replace("radius_mm = 5.0", "diameter_mm = 10.0"),
        calibration.replace("radius_mm = 5.0", ring),
        calibration.replace("radius_mm = 5.0", "length_mm = 10.0\nwidth_mm = 5.0"),
        calibration.replace("persson_rms_slope = 0.0137", "local_law = \"measured\"\nextrapolation = \"constant\""),
        calibration.replace("[surface]", "").replace("persson_rms_slope = 0.0137", "").replace(
            "coefficients = \"per-condition\"",
            "coefficients = \"single\"\narea_law_scale_mpa = [1.0, 100.0]",
        ),
        format!("{calibration}{}", patterned.replace("square", "rectangle") + "length_um = 100.0\n"),
        format!("{calibration}{}", patterned.replace("square", "crosshatch")),
        format!("{calibration}{}", patterned.replace("square", "groove")),
        format!("{calibration}{}", patterned.replace("square", "polygon") + "vertices_um = [[0, 0], [9, 0], [4, 6]]\n"),
    ]
}

fn materials() -> Vec<String> {
    let bulk = "youngs_modulus_gpa = 0.38\ndensity_g_cm3 = 0.9\n";
    let law = "[area_law]\npressure_mpa = [0.7, 1.3]\nfactor = [1.0, 0.9]\n";
    let one = "[friction]\nstatic_mean = 0.3\ndynamic_mean = 0.27\n";
    let each = "[friction]\n[[friction.conditions]]\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [0.65, 2.6]\n\
                static_mean = [0.3, 0.3]\ndynamic_mean = [0.27, 0.27]\n";
    let several = "[friction]\npressure_mpa = [0.65, 2.6]\nstatic_mean = [0.3, 0.3]\ndynamic_mean = [0.27, 0.27]\n";
    vec![format!("{bulk}{one}{law}"), format!("{bulk}{each}{law}"), format!("{bulk}{several}{law}")]
}

fn campaigns() -> Vec<String> {
    vec![text(&root().join("designs/campaign-rims.toml"))]
}

/// Sets the key at `path` to `value`, in the first element of each list of tables; `false` if this is impossible.
fn put(table: &mut Table, path: &[&str], value: &Value) -> bool {
    let [first, rest @ ..] = path else { return false };
    if rest.is_empty() {
        table.insert((*first).to_owned(), value.clone());
        return true;
    }
    match table.get_mut(*first) {
        Some(Value::Table(inner)) => put(inner, rest, value),
        Some(Value::Array(list)) => match list.first_mut() {
            Some(Value::Table(inner)) => put(inner, rest, value),
            _ => false,
        },
        // A table whose keys may all be absent.
        None if path.len() == 2 => {
            let mut inner = Table::new();
            let done = put(&mut inner, rest, value);
            table.insert((*first).to_owned(), Value::Table(inner));
            done
        }
        _ => false,
    }
}

/// Value of the type of `schema` that no reader accepts; `None` for tables and flags.
fn nonsense(schema: &serde_json::Value) -> Option<Value> {
    let has = |kind| has_type(schema, kind);
    Some(match () {
        () if has("number") => Value::Float(-1e300),
        () if has("integer") => Value::Integer(i64::MAX),
        () if has("string") && !has("object") => Value::String("?".to_owned()),
        () if has("array") => Value::Array(vec![nonsense(&schema["items"])?]),
        () => return None,
    })
}

impl Kind {
    /// Schema of the type that is read.
    pub fn schema(&self) -> &'static serde_json::Value {
        &SCHEMAS.iter().find(|(name, _)| *name == self.name).unwrap().1
    }

    /// Examples as tables, each with the path under which it is read.
    pub fn examples(&self) -> Vec<(PathBuf, Table)> {
        let folder = root().join(match self.name {
            "calibration" => "calibration/ldpe-cast-iron",
            _ => "designs",
        });
        (self.examples)().iter().map(|text| (folder.join("example.toml"), text.parse().unwrap())).collect()
    }

    /// Reads `table` as a file at `path`.
    pub fn read(&self, path: &Path, table: &Table) -> Result<String, Box<Diagnostic>> {
        (self.read)(path, &toml::to_string(table).unwrap())
    }

    /// Accepted values of each key, as the reader's refusals state them.
    pub fn accepted(&self) -> Accepted {
        let examples = self.examples();
        let mut accepted = Accepted::new();
        // A scene and a design hold a material, or name the file of one.
        if ["design", "scene"].contains(&self.name) {
            let inner = KINDS.into_iter().find(|kind| kind.name == "material").unwrap().accepted();
            accepted.extend(inner.into_iter().map(|(path, range)| (format!("material.{path}"), range)));
        }
        for (path, key) in all_keys(self.schema()) {
            let Some(value) = nonsense(key.schema) else { continue };
            let parts: Vec<&str> = path.split('.').collect();
            for (file, example) in &examples {
                let mut spoiled = example.clone();
                if !put(&mut spoiled, &parts, &value) {
                    continue;
                }
                let Err(refused) = self.read(file, &spoiled) else { continue };
                // The message names the key that it is about, in a list without its place.
                let is_about =
                    refused.key.as_deref().is_some_and(|about| about == path || about.ends_with(&format!(".{path}")));
                if let Some(expected) = refused.expected.as_ref().filter(|_| is_about) {
                    // One example lacks what the key needs beside it, which says nothing of the key: another has it.
                    let is_judged = is_judged(expected);
                    if is_judged || !accepted.contains_key(&path) {
                        accepted.insert(path.clone(), expected.to_string());
                    }
                    if is_judged {
                        break;
                    }
                }
            }
        }
        accepted
    }
}

/// Examples with the key at `path` set to `value`: path, unchanged table and changed table.
pub fn changed(kind: &Kind, path: &str, value: &Value) -> Vec<(PathBuf, Table, Table)> {
    let parts: Vec<&str> = path.split('.').collect();
    let spoiled = kind.examples().into_iter().filter_map(|(file, example)| {
        let mut changed = example.clone();
        put(&mut changed, &parts, value).then_some((file, example, changed))
    });
    spoiled.collect()
}
