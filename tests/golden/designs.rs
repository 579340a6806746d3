//! Designs: the shipped ones and small ones, searched, confirmed and exported.

use std::fs;

use crate::Case;
use crate::place::{Place, shipped};
use crate::record::Record;
use slipgrid_tests::repository;

/// Design that is searched and confirmed in a second: that of the refusals, with a laser whose time can be estimated.
fn small() -> String {
    include_str!("inputs/design.toml")
        .replace("test design", "small")
        .replace("spot_um = 23.0", "spot_um = 23.0\nrepetition_hz = 1000.0\nspeed_mm_s = 10.0")
}

/// Variants of [`small`]: name, text, and replacement.
const VARIANTS: [(&str, &str, &str); 11] = [
    ("as it is", "", ""),
    ("mu", "quantity = \"ratio\"", "quantity = \"mu_dynamic\""),
    ("lowest", "value = 0.9\ntolerance = 0.08", "goal = \"lowest\""),
    ("band", "value = 0.9\ntolerance = 0.08", "lowest = 0.8\nhighest = [0.98, 0.95]"),
    ("even", "value = 0.9\ntolerance = 0.08", "lowest = 0.7\nhighest = [1.0, 0.95]\ngoal = \"even\""),
    (
        "limits",
        "max_peak_pressure_mpa = 20.0",
        "min_bearing_area = 0.6\nliftoff = \"refuse\"\nmin_clearance_um = 1.0\nmax_areal_density = 0.4",
    ),
    (
        "ring",
        "shape = \"disc\"\ndiameter_mm = 1.0",
        "shape = \"ring\"\nouter_diameter_mm = 2.0\ninner_diameter_mm = 1.0",
    ),
    ("rectangle", "shape = \"disc\"\ndiameter_mm = 1.0", "shape = \"rectangle\"\nlength_mm = 1.0\nwidth_mm = 0.6"),
    ("tolerances", "[search]", "[tolerances]\nwidth_std_um = 3.0\ndepth_std_um = 0.4\n[search]"),
    ("squares", "planform = \"groove\"", "planform = \"square\""),
    ("table", "[search]", "[search]\ntable = true"),
];

pub fn cases() -> Vec<Case> {
    let variants = VARIANTS.iter().map(|(name, from, to)| {
        Case::new(format!("small, {name}"), true, move || {
            let small = small();
            assert!(small.contains(from));
            search(&Place::with(&[("design.toml", &small.replacen(from, to, usize::from(!from.is_empty())))]))
        })
    });
    assert!(
        shipped("").iter().all(|name| ["ldpe-", "scene-", "campaign-"].iter().any(|start| name.starts_with(start)))
    );
    // All use the calibration in `calibration/ldpe-cast-iron`.
    let shipped =
        shipped("ldpe-").into_iter().map(|name| Case::new(name.clone(), false, move || search(&with_material(&name))));
    let others = [
        Case::new("template", false, || {
            let text = include_str!("../../crates/cli/src/templates/design.toml");
            search(&Place::with(&[("design.toml", text)]))
        }),
        Case::new("next", false, || {
            let mut record = Record::new();
            with_material("ldpe-lower-friction").run("next @design.toml --count 2 --json", &mut record);
            record
        }),
        Case::new("campaign of rims", true, campaign),
    ];
    variants.chain(shipped).chain(others).collect()
}

/// Records the outputs of a search, and of an export of its result in every format.
fn search(place: &Place) -> Record {
    let mut record = Record::new();
    place.run("optimize @design.toml --json --no-explorer -o @out", &mut record);
    place.record_folder("out", &mut record);
    let (code, _, err) = place.run_raw("export @out/result.json --format plt,gcode,corners,hatch,stl -o @laser");
    record.insert("export".into(), format!("{code} {}", err.trim()).into());
    for name in ["pattern.plt", "pattern.gcode", "corners.csv", "hatch.csv", "removed.stl"] {
        place.record_file(&format!("laser/{name}"), name, &mut record);
    }
    record
}

/// Folder with a shipped design and the material of its calibration, which is fitted once.
fn with_material(name: &str) -> Place {
    static MATERIAL: std::sync::LazyLock<String> = std::sync::LazyLock::new(|| {
        let place = Place::new();
        let calibration = repository().join("calibration/ldpe-cast-iron/calibration.toml");
        let (code, _, err) = place.run_raw(&format!("calibrate {} -o @m.toml", calibration.display()));
        assert_eq!(code, 0, "{err}");
        fs::read_to_string(place.path("m.toml")).unwrap()
    });
    let text = fs::read_to_string(repository().join(format!("designs/{name}.toml"))).unwrap();
    let design = text.replace("../calibration/ldpe-cast-iron/calibration.toml", "m.toml");
    assert_ne!(design, text);
    Place::with(&[("design.toml", &design), ("m.toml", &MATERIAL)])
}

/// Records the plan of a campaign.
fn campaign() -> Record {
    let mut record = Record::new();
    let place = Place::new();
    let campaign = repository().join("designs/campaign-rims.toml");
    place.run(&format!("campaign plan {} -o @out", campaign.display()), &mut record);
    record
}
