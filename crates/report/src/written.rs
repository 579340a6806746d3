//! Whether slipgrid wrote a file: only such a file is replaced.

/// Bytes that are looked at.
pub const HEAD: usize = 1024;

/// How the tables begin that slipgrid writes.
const TABLES: [&str; 20] = [
    "# By slipgrid traces ",
    "load_mpa,surface,",
    "index,centre_x_mm,centre_y_mm,",
    "index,part,corner,",
    "index,line,from_x_mm,",
    "width_um,spacing_um,depth_um,",
    "x_um,height_um",
    "q_per_um,psd_um4,",
    "x_um,y_um,width_x_um,",
    "distance_um,height_um,",
    "pressure_mpa,area_fraction,",
    "slope_factor,rms_slope,pressure_mpa,",
    "force_n,pressure_mpa,speed_mm_s,",
    "force_n,speed_mm_s,humidity_pct,ratio,",
    "parameter,value,",
    "surface,force_n,speed_mm_s,humidity_pct,trace,",
    "kind,family,name,",
    "planform,rim_width_um,rim_height_um,",
    "trial,date,areal_density,",
    "task,",
];

/// How a material file begins.
const MATERIAL: &str = "# Material, by slipgrid ";
/// What an altitude map says that was made, not measured.
const SYNTHETIC: &str = "synthetic self-affine map, not a measurement";
/// What a mean period says that was averaged from a map.
const MEAN_PERIOD: &str = "mean period of measured cavities, by slipgrid";

/// How its other files begin, by their name or its ending.
const BEGINNINGS: [(&str, &[&str]); 14] = [
    ("scene.toml", &["# Scene of the confirming run, by slipgrid "]),
    ("process.toml", &["# Process sheet."]),
    ("trials.toml", &["# Trials of one disc, by slipgrid: "]),
    (".toml", &[MATERIAL]),
    (".csv", &TABLES),
    (".json", &["{\n  \"program\": \"slipgrid\"", "{\n  \"parameters\": [\n"]),
    (".svg", &["<svg width=\"", "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\""]),
    (".dxf", &["999\nslipgrid ", "999\r\nslipgrid "]),
    (".plt", &["CO \"slipgrid "]),
    (".gcode", &["(slipgrid "]),
    (".stl", &["slipgrid "]),
    (".md", &["# Speed against error", "# Simulated laboratories"]),
    (".sh", &["#!/bin/bash\n# By slipgrid: "]),
    (".1", &[".ie \\n(.g .ds Aq"]),
];

/// Whether slipgrid wrote a file called `name`, in small letters, whose first [`HEAD`] bytes are `head`.
#[must_use]
pub fn begins_as_ours(name: &str, head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    if name.ends_with(".html") {
        return text.contains("<meta name=\"generator\" content=\"slipgrid ");
    }
    if name.ends_with(".png") {
        // 16 bits of grey: the height map.
        return head.starts_with(b"\x89PNG\r\n\x1a\n") && head.get(24..26) == Some(&[16, 0]);
    }
    let named =
        BEGINNINGS.iter().find(|(ending, _)| name == *ending || (ending.starts_with('.') && name.ends_with(ending)));
    match named {
        Some((_, beginnings)) => beginnings.iter().any(|beginning| text.starts_with(beginning)),
        // Materials and altitude maps may have any name.
        None => {
            text.starts_with(MATERIAL)
                || (text.starts_with("# Channel: ") && [SYNTHETIC, MEAN_PERIOD].iter().any(|says| text.contains(says)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_its_beginning() {
        for (name, head, ours) in [
            ("scene.toml", "# Scene of the confirming run, by slipgrid 0.1.0: slipgrid simulate", true),
            ("scene.toml", "# A design task: the pattern that brings friction to a target.   slipgrid optimize", false),
            ("scene.toml", "name = \"mine\"\n", false),
            ("ldpe.toml", "# Material, by slipgrid calibrate 0.1.0. Scenes", true),
            ("c.toml", "# A calibration: measurements on flat samples", false),
            ("flat.csv", "force_n,speed_mm_s,humidity_pct,mu_dynamic,mu_dynamic_std\n", false),
            ("flat.csv", "# By slipgrid traces 0.1.0: flat samples", true),
            ("trade-offs.csv", "width_um,spacing_um,depth_um,areal_density,x", true),
            ("result.json", "{\n  \"program\": \"slipgrid\",", true),
            ("result.json", "{}", false),
            ("report.html", "<!DOCTYPE html>\n<title>my report</title>", false),
            ("map.asc", "# Channel: altitude\n# synthetic self-affine map, not a measurement\n", true),
            ("map.asc", "# Channel: altitude\n# Width: 1 mm\n", false),
            ("period.asc", "# Channel: mean period\n# mean period of measured cavities, by slipgrid\n", true),
            ("edge-profile.csv", "distance_um,height_um,height_error_um,rim_um\n", true),
            ("rims.csv", "planform,rim_width_um,rim_height_um,pressure_mpa,ratio,", true),
            ("pattern.dxf", "0\nSECTION", false),
        ] {
            assert_eq!(begins_as_ours(name, head.as_bytes()), ours, "{name} {head}");
        }
    }
}
