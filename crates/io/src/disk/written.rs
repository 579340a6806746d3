//! Marks of files written by slipgrid. Tables, pictures and process sheets have no mark: the list in their folder names them.

/// Number of bytes at the beginning of a file in which a mark is searched.
pub const HEAD: usize = 1024;

/// First characters of a material file.
const MATERIAL: &str = "# Material, by slipgrid ";
/// Mark of a synthetic altitude map.
const SYNTHETIC: &str = "synthetic self-affine map, not a measurement";
/// Mark of a height map of the mean period, averaged over the cavities of a measured map.
const MEAN_PERIOD: &str = "mean period of measured cavities, by slipgrid";

/// First characters of files written by slipgrid, by file extension.
const BEGINNINGS: [(&str, &[&str]); 8] = [
    (".toml", &[MATERIAL, "# Scene of the confirming run, by slipgrid ", "# Trials of one disc, by slipgrid: "]),
    (".csv", &["# By slipgrid traces "]),
    (".json", &["{\n  \"program\": \"slipgrid\""]),
    (".dxf", &["999\nslipgrid ", "999\r\nslipgrid "]),
    (".plt", &["CO \"slipgrid "]),
    (".gcode", &["(slipgrid "]),
    (".stl", &["slipgrid "]),
    (".sh", &["#!/bin/bash\n# By slipgrid: "]),
];

/// Whether a file with the lower-case name `name` has a mark of slipgrid in `head`, its first [`HEAD`] bytes.
pub fn has_mark(name: &str, head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    if name.ends_with(".html") {
        return text.contains("<meta name=\"generator\" content=\"slipgrid ");
    }
    if name.ends_with(".csv") && is_campaign_table(&text) {
        return true;
    }
    match BEGINNINGS.iter().find(|(ending, _)| name.ends_with(ending)) {
        Some((_, beginnings)) => beginnings.iter().any(|beginning| text.starts_with(beginning)),
        // Materials and altitude maps may have any name.
        None => {
            text.starts_with(MATERIAL)
                || (text.starts_with("# Channel: ") && [SYNTHETIC, MEAN_PERIOD].iter().any(|says| text.contains(says)))
        }
    }
}

/// Whether `head` is the beginning of a table of a campaign: the first task has an id of 20 hexadecimal digits.
fn is_campaign_table(head: &str) -> bool {
    let mut lines = head.lines();
    let id =
        lines.next().filter(|header| header.starts_with("task,")).and(lines.next()).and_then(|row| row.split_once(','));
    id.is_some_and(|(id, _)| id.len() == 20 && id.bytes().all(|byte| byte.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_its_mark() {
        for (name, head, ours) in [
            ("scene.toml", "# Scene of the confirming run, by slipgrid 0.1.0: slipgrid simulate", true),
            ("scene.toml", "# A design task: the pattern that brings friction to a target.   slipgrid optimize", false),
            ("scene.toml", "name = \"mine\"\n", false),
            ("ldpe.toml", "# Material, by slipgrid calibrate 0.1.0. Scenes", true),
            ("c.toml", "# A calibration: measurements on flat samples", false),
            ("flat.csv", "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n", false),
            ("flat.csv", "# By slipgrid traces 0.1.0: flat samples", true),
            ("trade-offs.csv", "width_um,spacing_um,depth_um,areal_density,x", false),
            ("table.csv", "task,due,who\nbuy laser,2026-12-01,me", false),
            ("table.csv", "task,a,outcome\n8f441b6065e778870488,1,done", true),
            ("pattern.svg", "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100mm\"", false),
            ("fit.json", "{\n  \"parameters\": [\n", false),
            ("result.json", "{\n  \"program\": \"slipgrid\",", true),
            ("result.json", "{}", false),
            ("report.html", "<!DOCTYPE html>\n<title>my report</title>", false),
            ("map.asc", "# Channel: altitude\n# synthetic self-affine map, not a measurement\n", true),
            ("map.asc", "# Channel: altitude\n# Width: 1 mm\n", false),
            ("period.asc", "# Channel: mean period\n# mean period of measured cavities, by slipgrid\n", true),
            ("section.csv", "x_um,height_um\n0,1\n", false),
            ("interface.csv", "load_mpa,surface,x_um,pressure_mpa,friction_mpa\nmine\n", false),
            ("process.toml", "# Process sheet. Mine\n", false),
            ("pattern.dxf", "0\nSECTION", false),
        ] {
            assert_eq!(has_mark(name, head.as_bytes()), ours, "{name} {head}");
        }
    }
}
