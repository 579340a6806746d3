//! Cache key: all inputs on which the results of the search model depend.

use serde_json::{Map, Value, json};
use slipgrid_model::pattern::{Texture, TextureRecord};
use slipgrid_model::springblock::{Dimension, Scene};

use slipgrid_base::units::{LENGTH_MM, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA};

/// Builds the cache key of the steady cells of a search: all inputs except width, spacing and depth of the design.
/// `further_deg` are additional sliding directions, in degrees.
pub fn cache_key(scene: &Scene, texture: &Texture, further_deg: &[f64]) -> Map<String, Value> {
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
    // The width varies in the search: with a width of 1 um, corners of an outline are written as fractions of the
    // width.
    let mut pattern = json!(TextureRecord::new(texture, LENGTH_UM.to_si(1.0)));
    if texture.length_m().is_none() {
        pattern["length_um"] = Value::Null;
    }
    if !further_deg.is_empty() {
        pattern["sliding_angle_deg"] = json!([&[texture.sliding_angle_deg()], further_deg].concat());
    }
    let mut entries = [
        ("area_law", json!(area_law)),
        ("dimensions", json!(Dimension::of(scene.run.dimensions, texture).number())),
        ("layer", layer),
        ("loads", loads.collect()),
        ("pattern", pattern),
        ("youngs_modulus_gpa", json!(MODULUS_GPA.from_si(scene.elastic.youngs_modulus_pa()))),
    ];
    if let Some(yield_pa) = scene.elastic.yield_pressure_pa().filter(|_| texture.rim().is_some()) {
        entries[4].1["yield_pressure_mpa"] = json!(PRESSURE_MPA.from_si(yield_pa));
    }
    entries.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
}
