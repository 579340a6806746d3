//! What the answers of the search's model depend on, for the first line of a study.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};
use slipgrid_pattern::Texture;
use slipgrid_springblock::Scene;

use slipgrid_units::{LENGTH_MM, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA};

/// Everything that the steady cells of a search are made of, but for width, spacing and depth. A texture may slide in
/// `further_deg` directions, too.
#[must_use]
pub fn depends_on(scene: &Scene, texture: &Texture, further_deg: &[f64]) -> Map<String, Value> {
    let um = |length_m: f64| LENGTH_UM.from_si(length_m);
    let area_law = scene.area_law.as_ref().map(|law| {
        let pressure_mpa: Vec<f64> =
            law.pressures_pa().iter().map(|&pressure_pa| PRESSURE_MPA.from_si(pressure_pa)).collect();
        json!({ "pressure_mpa": pressure_mpa, "factor": law.factors() })
    });
    let loads = scene.loads.iter().map(|load| {
        json!({ "pressure_mpa": PRESSURE_MPA.from_si(load.pressure_pa), "dynamic_mean": load.friction.dynamic_mean() })
    });
    let mut layer = json!({ "layer_um": um(scene.layer.height_m), "block_um": um(scene.layer.block_m) });
    if let Some(thickness_m) = scene.layer.thickness_m {
        layer["thickness_mm"] = json!(LENGTH_MM.from_si(thickness_m));
    }
    let entries = [
        ("area_law", json!(area_law)),
        ("dimensions", json!(scene.run.dimensions.unwrap_or_else(|| texture.dimensions()))),
        ("layer", layer),
        ("loads", loads.collect()),
        (
            "pattern",
            json!({
                "planform": texture.planform().name(),
                "arrangement": texture.arrangement().name(),
                "length_um": texture.length_m().map(um),
                "spacing_across_um": texture.spacing_across_m().map(um),
                "angle_deg": texture.orientation_deg(),
                "sliding_angle_deg": match further_deg {
                    [] => json!(texture.sliding_angle_deg()),
                    _ => json!([&[texture.sliding_angle_deg()], further_deg].concat()),
                },
            }),
        ),
        ("youngs_modulus_gpa", json!(MODULUS_GPA.from_si(scene.elastic.youngs_modulus_pa()))),
    ];
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}

/// out/NAME for designs/NAME.toml; out/design where NAME has nothing but dots.
#[must_use]
pub fn default_folder(design: &Path) -> PathBuf {
    let stem = design.file_name().map(Path::new).and_then(Path::file_stem);
    let named = stem.filter(|stem| !stem.to_string_lossy().trim_start_matches('.').is_empty());
    let named = named.filter(|stem| !stem.eq_ignore_ascii_case(".toml"));
    PathBuf::from("out").join(named.unwrap_or_else(|| "design".as_ref()))
}

/// The study's file, beside the folder of results: out/NAME.study.jsonl.
#[must_use]
pub fn study_path(folder: &Path) -> PathBuf {
    beside(folder, ".study.jsonl")
}

/// The file that a run for the folder of results holds locked: out/NAME.lock.
#[must_use]
pub fn lock_path(folder: &Path) -> PathBuf {
    beside(folder, ".lock")
}

fn beside(folder: &Path, ending: &str) -> PathBuf {
    let mut name = folder.file_name().map_or_else(|| "design".into(), std::ffi::OsStr::to_os_string);
    name.push(ending);
    match folder.file_name() {
        Some(_) => folder.with_file_name(name),
        // `.` and `..` have no name to put another beside.
        None => folder.join(name),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_never_go_to_the_current_folder_by_themselves() {
        for (design, folder) in [
            ("designs/ldpe.toml", "out/ldpe"),
            ("a.b.toml", "out/a.b"),
            (".toml", "out/design"),
            ("..toml", "out/design"),
            ("...toml", "out/design"),
            ("/tmp/....toml", "out/design"),
            (".hidden.toml", "out/.hidden"),
            ("..", "out/design"),
        ] {
            assert_eq!(default_folder(Path::new(design)), Path::new(folder), "{design}");
        }
        assert_eq!(study_path(Path::new("out/a")), Path::new("out/a.study.jsonl"));
        assert_eq!(study_path(Path::new("..")), Path::new("../design.study.jsonl"));
        assert_eq!(lock_path(Path::new(".")), Path::new("./design.lock"));
    }
}
