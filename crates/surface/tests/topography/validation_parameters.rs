//! Compares ISO 25178 parameters and power spectrum with those of independent programs (`reference/make.py`).

use serde_json::Value;
use slipgrid_base::monitor::Unwatched;
use slipgrid_surface::topography::{HeightMap, LengthUnit, MaterialRatioCurve, ReadOptions, Sides, read_map};

fn reference() -> (HeightMap, Value) {
    let folder = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/topography/reference"));
    let options = ReadOptions {
        pixel_m: Some([0.5e-6, 0.75e-6]),
        height_unit: Some(LengthUnit::Micrometre),
        ..ReadOptions::default()
    };
    let map = read_map(&std::fs::read(folder.join("iso.npy")).unwrap()[..], &options).unwrap().map;
    (map, serde_json::from_slice(&std::fs::read(folder.join("iso.json")).unwrap()).unwrap())
}

#[test]
fn validation_iso_parameters_beside_surfalize() {
    let (map, expected) = reference();
    let heights = map.height_parameters(&Unwatched).unwrap();
    let core = MaterialRatioCurve::new(&map, &Unwatched).unwrap().core();
    let lengths = map.correlation_lengths(Sides::Open, &Unwatched).unwrap();
    // Allowed relative differences: rounding where both compute the same sum. The core's line is fitted to the same
    // classes, but fractions above and below are counted here and interpolated in surfalize, which also omits the last
    // class of the areas beyond the core; with the whole area it agrees. surfalize finds decay lengths at the nearest
    // of 1000 positions along a ray to a pixel, this crate in 720 directions.
    for (name, found, tolerance) in [
        ("Sa", heights.sa_m * 1e6, 1e-9),
        ("Sq", heights.sq_m * 1e6, 1e-9),
        ("Ssk", heights.ssk, 1e-9),
        ("Sku", heights.sku, 1e-9),
        ("Sp", heights.sp_m * 1e6, 1e-9),
        ("Sv", heights.sv_m * 1e6, 1e-9),
        ("Sz", heights.sz_m * 1e6, 1e-9),
        ("Sdq", map.rms_slope_finite_difference(), 1e-9),
        ("Sdr", map.sdr(&Unwatched).unwrap() * 100.0, 1e-9),
        ("Sk", core.sk_m * 1e6, 1e-4),
        ("Spk", core.spk_m * 1e6, 5e-3),
        ("Svk", core.svk_m * 1e6, 5e-3),
        ("Spk whole", core.spk_m * 1e6, 2e-4),
        ("Svk whole", core.svk_m * 1e6, 2e-4),
        ("Smr1", core.smr1 * 100.0, 1e-3),
        ("Smr2", core.smr2 * 100.0, 1e-3),
        ("Sal", lengths.sal_m.unwrap() * 1e6, 5e-3),
        ("Str", lengths.str_ratio.unwrap(), 1e-2),
    ] {
        let reference = expected[name].as_f64().unwrap();
        assert!((found / reference - 1.0).abs() < tolerance, "{name}: {found} and {reference}");
    }
}

#[test]
fn validation_power_spectrum_beside_surface_topography() {
    let (map, expected) = reference();
    let list = |value: &Value| value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<f64>>();
    let edges: Vec<f64> = list(&expected["edges_per_um"]).iter().map(|edge| edge * 1e6).collect();
    for (name, window) in [("none", Sides::Periodic), ("hann", Sides::Open)] {
        let reference = list(&expected["spectrum_um4"][name]);
        let bins = map.radial_spectrum_between(&edges, window, &Unwatched).unwrap();
        assert_eq!(bins.len(), reference.len());
        for (bin, reference) in bins.iter().zip(reference) {
            // A map in single precision with a mean of 1e-9 of its Sq.
            let found = bin.psd_m4 * 1e24;
            assert!((found / reference - 1.0).abs() < 1e-6, "{name}, q {}: {found} and {reference}", bin.q_per_m);
        }
    }
}
