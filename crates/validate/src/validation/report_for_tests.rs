//! Test fixture: records of a validation.

use super::laws::ScaledLaw;
use super::ratios::{MeasuredReport, ModelledRatio, RatioReport};
use super::report::{PublishedReport, TimeReport, ValidationReport};
use super::summary::Summary;
use slipgrid_design::results::{MadeBy, PatternReport};

/// Condition with a measured `ratio`, modelled at two slopes, the first of which did not converge.
pub fn row(ratio: f64, groove: Option<f64>, deep: f64) -> RatioReport {
    let modelled = |slope_factor, ratio_groove: Option<f64>| ModelledRatio {
        slope_factor,
        area_law_factor: 1.0,
        dynamic_mean: 0.3,
        ratio_groove,
        ratio_square: ratio_groove.map(|ratio| 1.0 - 0.125 * (1.0 - ratio)),
        ratio_square_estimate: ratio_groove.map(|ratio| 1.0 - 0.25 * (1.0 - ratio)),
        peak_pressure_mpa: 1.0,
        peak_pressure_square_mpa: 1.0,
        status: "converged",
        status_square: "converged",
        ..ModelledRatio::default()
    };
    RatioReport {
        measured: MeasuredReport {
            force_n: 50.0,
            pressure_mpa: 0.6,
            speed_mm_s: 2.0,
            humidity_pct: 15.0,
            mu_flat: 0.25,
            mu_flat_std: 0.002,
            mu_patterned: 0.2,
            mu_patterned_std: 0.002,
            ratio,
            ratio_std: 0.0,
        },
        ratio_amontons_coulomb: Some(1.0),
        measured_law: Vec::new(),
        modelled: vec![modelled(0.5, None), modelled(1.0, groove)],
        modelled_at_measured_depth: Some(modelled(1.0, Some(deep))),
    }
}

/// Report on two conditions with all parts that a page can show.
pub fn report() -> ValidationReport {
    let mut results = vec![row(0.75, Some(0.9), 0.85), row(0.875, Some(0.95), 0.9)];
    (results[1].measured.force_n, results[1].measured.pressure_mpa) = (200.0, 2.5);
    let slope_factors = vec![0.5, 1.0];
    ValidationReport {
        made_by: MadeBy { version: "0.0.0".into(), ..MadeBy::slipgrid(1) },
        name: "a <b> & \"c\"".into(),
        source: "a paper".into(),
        trial: None,
        cut_as: Some("square".into()),
        thickness_mm: None,
        synthetic_surface: true,
        model: vec!["grooves".into()],
        errors: "+- of modelled values: nothing".into(),
        pattern: PatternReport { width_um: 130.0, spacing_um: 370.0, depth_um: 20.0, ..PatternReport::default() },
        areal_density_square: 0.0676,
        measured_depth_um: 10.0,
        summary: Summary::new(&results, &slope_factors),
        slope_factors,
        statements: vec!["the ratio is lower".into()],
        published: vec![PublishedReport { quantity: "q".into(), source: "s".into(), here: "h".into() }],
        measured: results.iter().map(|row| row.measured.clone()).collect(),
        area_laws: vec![ScaledLaw {
            slope_factor: 1.0,
            rms_slope: Some(0.2),
            law: None,
            pressure_mpa: vec![0.5, 2.0],
            area_fraction: vec![0.01, 0.03],
            factor: vec![1.0, 0.75],
        }],
        rims: None,
        in_time: Some(TimeReport {
            pressure_mpa: 2.5,
            speed_mm_s: 2.0,
            sliding_um: 20.0,
            static_mean: 0.33,
            dynamic_mean: 0.3,
            relative_std: 0.05,
            mu_flat: Some(0.255),
            mu_flat_stderr: Some(0.0001),
            mu_flat_std: Some(0.003),
            mu_patterned: Some(0.21),
            mu_patterned_stderr: Some(0.0001),
            mu_patterned_std: Some(0.002),
            mu_static_patterned: Some(0.25),
            mu_static_patterned_std: Some(0.001),
            ratio: Some(0.8235),
            status_flat: "converged",
            status_patterned: "no_onset",
            wall_s: 1.0,
            ..TimeReport::default()
        }),
        wall_s: 1.0,
        threads: 1,
        results,
    }
}
