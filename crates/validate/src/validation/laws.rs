//! Area laws of the surface of a calibration, with heights scaled by several factors.

use serde::Serialize;
use slipgrid_infer::calibrate::area_law::{
    CONTACT_TOLERANCE, DEFAULT_PRESSURES_MPA, area_curve, area_law, persson_curve,
};
use slipgrid_infer::calibrate::{LawPressures, Selection, Surface};
use slipgrid_model::material::AreaLaw;
use slipgrid_surface::contact::AreaPoint;

use super::ValidationTask;
use crate::Failure;
use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::units::{PRESSURE_MPA, tidy};
use slipgrid_design::results::fixed;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::altitude_map::{read_period, told};
use slipgrid_io::formats::calibrated::calibrate;
use slipgrid_io::formats::scene::DEFAULT_SAMPLE;
use slipgrid_io::formats::source::Source;
use slipgrid_io::formats::surface::NamedMap;

/// Area law of the surface with all heights multiplied by one factor, and the contact area at each tabulated pressure;
/// without a surface, the lists of pressures and areas are empty.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct ScaledLaw {
    /// Factor on heights and slopes of the surface.
    pub slope_factor: f64,
    /// Rms slope; null without a surface.
    pub rms_slope: Option<f64>,
    /// Area law; `None` without a surface.
    #[serde(skip)]
    pub law: Option<AreaLaw>,
    /// Nominal pressures, increasing.
    pub pressure_mpa: Vec<f64>,
    /// Real contact area over nominal area, corrected along its perimeter.
    pub area_fraction: Vec<f64>,
    /// Area factor f at each pressure.
    pub factor: Vec<f64>,
}

impl ScaledLaw {
    /// Creates an entry for a calibration without a surface, whose `law` does not depend on a slope.
    pub fn without_surface(law: Option<AreaLaw>) -> Self {
        Self { slope_factor: 1.0, law, ..Self::default() }
    }
}

/// Area laws of one surface at all slope factors.
#[derive(Clone, Debug, PartialEq)]
pub struct ScaledLaws {
    /// Laws, one per slope factor, in the order of the factors.
    pub laws: Vec<ScaledLaw>,
    /// The surface is synthetic.
    pub synthetic: bool,
    /// Notes on the processing of the surface.
    pub notes: Vec<String>,
}

impl ScaledLaws {
    /// Area law of the surface as given, with factor 1; `None` without an area law.
    pub fn given(&self) -> Option<&AreaLaw> {
        self.laws.iter().find(|law| law.slope_factor == 1.0)?.law.as_ref()
    }
}

/// Computes the area laws of the surface of `task`, one per slope factor; a map is read from `source`.
///
/// # Errors
/// [`Failure`] if the map cannot be read or its contact area gives no law.
pub fn scaled_laws(task: &ValidationTask<'_>, source: &Source, monitor: &dyn Monitor) -> Result<ScaledLaws, Failure> {
    let (path, calibration, factors) = (task.path, task.calibration, &task.slope_factors);
    let contact_modulus_pa = calibration.stated.elastic.contact_modulus_pa(calibration.stated.poisson_ratio);
    let refuse = |error: &dyn std::fmt::Display| Diagnostic::file(path, error.to_string());
    let law = |points: &[AreaPoint], threshold_pa: f64| {
        area_law(points, threshold_pa)
            .map_err(|error| Diagnostic::file(path, format!("the contact area gives no area law: {error}")))
    };
    let without_surface = |law: Option<AreaLaw>, note: &str| ScaledLaws {
        laws: vec![ScaledLaw::without_surface(law)],
        synthetic: false,
        notes: vec![note.to_owned()],
    };
    let stated_pa = calibration.stated.threshold_pa;
    match (&calibration.map, &calibration.stated.surface) {
        (None, Surface::FittedScale { .. }) => fitted_laws(task, source, monitor),
        (None, Surface::None | Surface::Map(_)) => Ok(without_surface(
            None,
            "the calibration has no surface: friction is proportional to load, whatever the slope",
        )),
        (None, Surface::FlatFriction { law, .. }) => Ok(without_surface(
            Some(law.clone()),
            "the calibration takes measured flat friction for the local law: no surface, whatever the slope",
        )),
        (None, Surface::RmsSlope(rms_slope)) => {
            let pressures_pa = DEFAULT_PRESSURES_MPA.map(|pressure_mpa| PRESSURE_MPA.to_si(pressure_mpa));
            let laws = at_slopes(factors, *rms_slope, |slope_factor| {
                let scaled = rms_slope * slope_factor;
                let curve = |pressures_pa: &[f64]| persson_curve(scaled, contact_modulus_pa, pressures_pa);
                let areas = curve(&pressures_pa).map_err(|e| refuse(&e))?;
                let of = LawPressures::new(stated_pa, contact_modulus_pa, scaled, None);
                let behind = curve(&of.pressures_pa).map_err(|e| refuse(&e))?;
                Ok((law(&behind, of.threshold_pa)?, areas))
            })?;
            let notes = vec!["area law by Persson's theory from the rms slope: no substitute for a map".to_owned()];
            Ok(ScaledLaws { laws, synthetic: false, notes })
        }
        (Some(NamedMap { path: map_path, synthetic, options, .. }), _) => {
            let surface = read_period(source, map_path, options, monitor)?;
            // A(P; s h) = A(P/s; h), with area A, pressure P, heights h, factor s: the curve of the given surface
            // suffices.
            let points = surface.map.rows() * surface.map.cols();
            let of = LawPressures::new(stated_pa, contact_modulus_pa, surface.rms_slope, Some(points));
            // With a stated threshold, the tabulated pressures suffice for the scaled laws.
            let light_pa = if stated_pa.is_none() { of.pressures_pa.as_slice() } else { &[] };
            let solved_pa = unscaled_pressures_pa(factors, light_pa);
            let progress = Stage::new(monitor, "area law", None);
            let curve = area_curve(&surface.map, contact_modulus_pa, &solved_pa, CONTACT_TOLERANCE, &progress);
            progress.finish();
            monitor.heed()?;
            let curve = curve.map_err(|error| Diagnostic::file(map_path, error.to_string()))?;
            let mut notes = vec![format!(
                "area law of {}: rms slope {}{}",
                map_path.display(),
                fixed(Some(surface.rms_slope), 4),
                if *synthetic || surface.synthetic { ", synthetic" } else { "" },
            )];
            notes.extend(surface.notes.iter().cloned());
            notes.extend(surface.warnings.iter().map(|warning| format!("warning: {}", told(warning))));
            let laws = at_slopes(factors, surface.rms_slope, |slope_factor| {
                let areas = scaled(&curve.points, slope_factor);
                let law = match stated_pa {
                    Some(threshold_pa) => law(&areas, threshold_pa)?,
                    None => law(&stretched(&curve.points, slope_factor), slope_factor * of.threshold_pa)?,
                };
                Ok((law, areas))
            })?;
            Ok(ScaledLaws { laws, synthetic: *synthetic || surface.synthetic, notes })
        }
    }
}

/// Computes the area laws by Persson's theory with a pressure scale fitted to flat friction, as in calibrations.
fn fitted_laws(task: &ValidationTask<'_>, source: &Source, monitor: &dyn Monitor) -> Result<ScaledLaws, Failure> {
    // The fit uses flat samples only, so that trials are removed.
    let mut flat = task.calibration.clone();
    flat.stated.trials.samples.clear();
    let (_, found) = calibrate(&flat, task.path, source, DEFAULT_SAMPLE, Selection::default(), monitor)?;
    let refuse = |error: &dyn std::fmt::Display| {
        let key = Some("fit.area_law_scale_mpa".into());
        Diagnostic { key, ..Diagnostic::file(task.path, format!("gives no area law: {error}")) }
    };
    let scale = found.fit.parameters.iter().find(|parameter| parameter.name == "area_law_scale_pa");
    let (Some(own), Some(scale)) = (&found.surface.law, scale) else {
        return Err(refuse(&"the fit found no scale")
            .expected("measurements of flat samples at two loads or more")
            .into());
    };
    let scale_pa = scale.value;
    let rms_slope = scale_pa / flat.stated.elastic.contact_modulus_pa(flat.stated.poisson_ratio);
    let pressures_pa = DEFAULT_PRESSURES_MPA.map(|pressure_mpa| PRESSURE_MPA.to_si(pressure_mpa));
    let laws = at_slopes(&task.slope_factors, rms_slope, |slope_factor| {
        let areas = persson_curve(1.0, slope_factor * scale_pa, &pressures_pa).map_err(|error| refuse(&error))?;
        if slope_factor == 1.0 {
            return Ok((own.clone(), areas));
        }
        let points = stretched(&found.surface.curve, slope_factor);
        Ok((area_law(&points, points[0].pressure_pa).map_err(|error| refuse(&error))?, areas))
    })?;
    let notes = vec![format!(
        "area law by Persson's theory, its pressure scale fitted to flat friction ([fit] area_law_scale_mpa): {} MPa, as an rms slope \
         of {} has it",
        fixed(Some(PRESSURE_MPA.from_si(scale_pa)), 2),
        fixed(Some(rms_slope), 4),
    )];
    Ok(ScaledLaws { laws, synthetic: false, notes })
}

/// Makes one entry per slope factor from the area law and the tabulated areas that `of` returns for the factor;
/// `rms_slope` is the slope at factor 1.
fn at_slopes(
    factors: &[f64],
    rms_slope: f64,
    of: impl Fn(f64) -> Result<(AreaLaw, Vec<AreaPoint>), Diagnostic>,
) -> Result<Vec<ScaledLaw>, Diagnostic> {
    let at = |&slope_factor: &f64| {
        let (law, areas) = of(slope_factor)?;
        Ok(ScaledLaw {
            slope_factor,
            rms_slope: Some(tidy(rms_slope * slope_factor)),
            pressure_mpa: areas.iter().map(|point| tidy(PRESSURE_MPA.from_si(point.pressure_pa))).collect(),
            area_fraction: areas.iter().map(|point| point.area_fraction_corrected).collect(),
            factor: areas.iter().map(|point| law.factor(point.pressure_pa)).collect(),
            law: Some(law),
        })
    };
    factors.iter().map(at).collect()
}

/// Converts a contact-area curve to the surface with heights scaled by `factor`: equal areas are reached at `factor`
/// times the pressure.
fn stretched(curve: &[AreaPoint], factor: f64) -> Vec<AreaPoint> {
    curve.iter().map(|point| AreaPoint { pressure_pa: factor * point.pressure_pa, ..*point }).collect()
}

/// Pressures, increasing, at which the unscaled surface is solved: those needed for all tabulated pressures of the
/// scaled surfaces, and `more`.
fn unscaled_pressures_pa(factors: &[f64], more: &[f64]) -> Vec<f64> {
    let mut pressures_pa: Vec<f64> = factors
        .iter()
        .flat_map(|&factor| tabulated_pa(factor).map(|pair| pair[1]))
        .chain(more.iter().copied())
        .collect();
    pressures_pa.sort_by(f64::total_cmp);
    pressures_pa.dedup();
    pressures_pa
}

/// Tabulated pressures of a surface with heights scaled by `factor`, each with the pressure at which the unscaled
/// surface has the same area, both in pascals.
fn tabulated_pa(factor: f64) -> impl Iterator<Item = [f64; 2]> {
    DEFAULT_PRESSURES_MPA.into_iter().map(move |pressure_mpa| {
        let pressure_pa = PRESSURE_MPA.to_si(pressure_mpa);
        // Rounded, so that equal pressures for two factors are solved once.
        [pressure_pa, tidy(pressure_pa / factor)]
    })
}

/// Contact area of the surface with heights scaled by `factor`, at the tabulated pressures, from the contact-area
/// `curve` of the unscaled surface.
fn scaled(curve: &[AreaPoint], factor: f64) -> Vec<AreaPoint> {
    tabulated_pa(factor)
        .filter_map(|[pressure_pa, unscaled_pa]| {
            let point = curve.iter().find(|point| point.pressure_pa == unscaled_pa)?;
            Some(AreaPoint { pressure_pa, ..*point })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_surface::topography::{HeightMap, SelfAffine};

    #[test]
    fn a_scaled_surface_has_the_curve_of_its_own_map() {
        let map = SelfAffine { pixels: 32, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap();
        let progress = slipgrid_base::monitor::Unwatched;
        let solve = |map: &HeightMap, pressures_pa: &[f64]| {
            area_curve(map, 427.5e6, pressures_pa, 1e-10, &progress).unwrap().points
        };
        let own = solve(&map, &unscaled_pressures_pa(&[0.5, 1.0, 2.0], &[]));
        for factor in [0.5, 1.0, 2.0] {
            let by_identity = scaled(&own, factor);
            assert_eq!(by_identity.len(), DEFAULT_PRESSURES_MPA.len());
            let listed: Vec<f64> = by_identity.iter().map(|point| point.pressure_pa).collect();
            let solved = solve(&map.scaled(factor).unwrap(), &listed);
            for (a, b) in by_identity.iter().zip(&solved) {
                assert!((a.area_fraction - b.area_fraction).abs() < 1e-9, "{factor} {a:?} {b:?}");
            }
        }
    }
}
