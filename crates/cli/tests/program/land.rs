//! The land of a cut sample, which is steeper than the flat sample, corrects the modelled ratio of its trial.

use crate::common::{CALIBRATION, Place, THREE_FORCES, at, column};

/// Options for all maps: pixels of 4 um, waves of 32 um and longer.
const MAP: &str = "synthesize --pixels 256 --waves 4:32 --quiet";
/// Grooves of the cut sample, without scatter.
const CUT: &str = "--cavities 60,140,5.2 --wall-um 4 --cavity-std 0,0,0 -o cut.asc";

#[test]
fn a_land_a_fifth_steeper_lowers_the_modelled_ratio_as_its_contact_area() {
    let file = |map: &str, more: &str| {
        format!(
            "{}[[trial]]\nname = \"cut\"\nmeasurements = \"cut.csv\"\n{more}[trial.pattern]\nwidth_um = 60.0\n\
             spacing_um = 140.0\ndepth_um = 5.2\n",
            CALIBRATION.replace("persson_rms_slope = 0.0137", map)
        )
    };
    let (flat, mapped) = ("map = \"flat.asc\"", "map = \"cut.asc\"\n");
    let place = Place::with(&[
        ("flat.csv", THREE_FORCES),
        ("cut.csv", THREE_FORCES),
        ("alone.toml", &file(flat, "")),
        ("mapped.toml", &file(flat, mapped)),
        ("slope.toml", &file("persson_rms_slope = 0.0137", mapped)),
        ("uncut.toml", &file(flat, "map = \"flat.asc\"\n")),
        ("fine.toml", &file(flat, "map = \"fine.asc\"\n")),
    ]);
    place.succeed(&format!("{MAP} --rms-slope 0.02 --side-mm 1.024 -o flat.asc"));
    place.succeed(&format!("{MAP} --rms-slope 0.024 --side-mm 1.024 {CUT}"));
    place.succeed(&format!("{MAP} --rms-slope 0.024 --side-mm 0.512 -o fine.asc"));
    let [alone, mapped] = ["alone", "mapped"].map(|name| place.json(&format!("trials {name}.toml --json -q")));
    assert!(alone.get("lands").is_none());
    let land = &mapped["lands"][0];
    let (over_flat, log_std) = (at(land, "/over_flat"), at(land, "/log_std"));
    assert!((over_flat / 1.2 - 1.0).abs() < 3.0 * log_std.max(0.01) && log_std < 0.06, "{land}");
    let factors = column(&land["factor"], "");
    let [before, after] = [&alone, &mapped].map(|of| column(&of["trials"][0]["measured"], "/modelled"));
    for ((before, after), factor) in before.iter().zip(after).zip(&factors) {
        assert!((after / before - factor).abs() < 1e-4, "{before} {after} {factor}");
        // Between area in proportion to load and full contact.
        assert!((0.97 / over_flat..0.99).contains(factor), "{factor}");
    }
    // The less the load, the more the slope counts.
    assert!(factors.is_sorted(), "{factors:?}");
    place.refuse_all(
        "trials slope.toml => no map of a flat sample
         trials uncut.toml => heights do not part
         trials fine.toml => expected pixels of 4 x 4 um",
    );
}
