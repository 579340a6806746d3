//! Model of patterned samples, based on flat measurements and the surface only.

use std::path::Path;

use rayon::prelude::*;
use slipgrid_infer::calibrate::uncertainty::{Deviations, InputUncertainty, ScaleError, Slopes};
use slipgrid_model::material::{AreaLaw, Elastic, LocalFriction};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{CellOutcome, Layer, Load, Monitor, RunOptions, Scene, SteadyCell};

use super::ratios::Pair;
use crate::Failure;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::scene::DEFAULT_THICKNESS_M;

/// Specimen of a calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Body<'a> {
    /// File of the calibration, for errors.
    pub path: &'a Path,
    /// Young's modulus and density.
    pub elastic: Elastic,
    /// Relative standard deviation of Young's modulus, if known.
    pub modulus_relative_std: Option<f64>,
    /// Modelled layer.
    pub layer: Layer,
}

impl Body<'_> {
    /// Converts `error` to the error that the numbers of the calibration make no valid scene.
    pub fn refuse(&self, error: &impl ToString) -> Failure {
        Diagnostic::file(self.path, error.to_string()).into()
    }
}

/// Uncertainty of flat friction of `pairs` and, with a `law`, of Young's modulus.
pub fn knowledge(modulus_relative_std: Option<f64>, law: Option<&AreaLaw>, pairs: &[Pair]) -> InputUncertainty {
    let std = modulus_relative_std.filter(|std| law.is_some() && *std > 0.0);
    InputUncertainty {
        flat_friction: Some(pairs.iter().map(|of| (of.flat.mu_dynamic_std / of.flat.mu_dynamic).powi(2)).collect()),
        scale: std.map(|std| ScaleError::of_modulus(std, pairs.len())),
        ..InputUncertainty::default()
    }
}

/// Pattern and area law of a model that is solved at every measurement.
#[derive(Clone, Copy, Debug)]
pub struct Case<'a> {
    /// Pattern with grooves as cavities.
    pub pattern: Pattern,
    /// Area law; `None` for Amontons-Coulomb.
    pub law: Option<&'a AreaLaw>,
}

/// Model results at one measurement.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelledRatios {
    /// Area factor f at the nominal pressure.
    pub area_law_factor: f64,
    /// Local dynamic coefficient: measured flat friction over the area factor f.
    pub dynamic_mean: f64,
    /// Solution for grooves.
    pub outcome: CellOutcome,
    /// Solution for square cavities with equal lengths, in three dimensions.
    pub squares: CellOutcome,
    /// Changes of the friction ratios with grooves and with squares if the whole thickness of the source's specimen is
    /// modelled instead of a layer; `None` if the whole specimen is modelled already, or if a solution gives no ratio.
    pub thick: [Option<f64>; 2],
    /// Uncertainties of the friction ratios with grooves and with squares, due to Young's modulus and measured flat
    /// friction; `None` if they cannot be computed.
    pub errors: [Option<Deviations>; 2],
}

/// Solves every case for the flat measurements of all `pairs`, cases in parallel. Returns one list per case, with one
/// prediction per pair.
///
/// # Errors
/// [`Failure`] if the numbers make no valid scene.
pub fn predict(
    body: Body<'_>,
    cases: &[Case<'_>],
    pairs: &[Pair],
    progress: &dyn Monitor,
) -> Result<Vec<Vec<ModelledRatios>>, Failure> {
    let share = 1.0 / cases.len() as f64;
    cases
        .par_iter()
        .map(|case| {
            progress.heed()?;
            let predicted = solve(body, case, pairs);
            progress.advance(share);
            predicted
        })
        .collect()
}

/// Scene of steady sliding of `pattern` with the area law `law` at the pressures of `pairs`.
///
/// # Errors
/// [`Failure`] if the numbers make no valid scene.
pub fn scene(body: Body<'_>, law: Option<&AreaLaw>, pattern: Pattern, pairs: &[Pair]) -> Result<Scene, Failure> {
    let loads = pairs
        .iter()
        .map(|pair| {
            let [_, dynamic_mean] = coefficients(law, pair);
            // Steady sliding does not depend on the static coefficient, and a cell uses the mean.
            let friction = LocalFriction::new(dynamic_mean, dynamic_mean, 0.0).map_err(|error| body.refuse(&error))?;
            Ok(Load { pressure_pa: pair.pressure_pa, friction })
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let scene = Scene {
        elastic: body.elastic,
        area_law: law.cloned(),
        pattern: Some(pattern),
        relief: None,
        layer: body.layer,
        loads,
        // Steady sliding does not depend on the speed.
        speed_m_s: pairs.first().map_or(0.0, |pair| pair.flat.speed_m_s),
        run: RunOptions::default(),
    };
    scene.validate().map_err(|error| body.refuse(&error))?;
    Ok(scene)
}

/// Area factor f and local dynamic coefficient mu_d of `pair`, so that a flat cell slides at mu_flat = mu_d f(P).
fn coefficients(law: Option<&AreaLaw>, pair: &Pair) -> [f64; 2] {
    let area_law_factor = law.map_or(1.0, |law| law.factor(pair.pressure_pa));
    [area_law_factor, pair.flat.mu_dynamic / area_law_factor]
}

fn solve(body: Body<'_>, case: &Case<'_>, pairs: &[Pair]) -> Result<Vec<ModelledRatios>, Failure> {
    let coefficients: Vec<[f64; 2]> = pairs.iter().map(|pair| coefficients(case.law, pair)).collect();
    let scene = scene(body, case.law, case.pattern, pairs)?;
    let in_space = Scene { pattern: Some(squares(&case.pattern)), ..scene.clone() };
    let solved = |layer: Layer| {
        let of = |pattern: Pattern| {
            SteadyCell::new(&Scene { pattern: Some(pattern), layer, ..scene.clone() }).solve(&pattern)
        };
        rayon::join(|| of(case.pattern), || of(squares(&case.pattern)))
    };
    let (grooves, squares) = solved(scene.layer);
    // A layer without thickness neglects the body behind the layer.
    let is_layer = scene.layer.thickness_m.is_none();
    let thick = is_layer.then(|| solved(Layer { thickness_m: Some(DEFAULT_THICKNESS_M), ..scene.layer }));
    let known = knowledge(body.modulus_relative_std, case.law, pairs);
    let slopes = [&scene, &in_space].map(|scene| Slopes::new(scene, &known));
    let predictions = grooves.into_iter().zip(squares).zip(coefficients).enumerate();
    Ok(predictions
        .map(|(place, ((outcome, squares), [area_law_factor, dynamic_mean]))| {
            let error = |slopes: &Slopes, ratio: Option<f64>| {
                slopes.deviations(place, ratio?, pairs[place].flat.mu_dynamic, &known)
            };
            let errors = [error(&slopes[0], outcome.ratio), error(&slopes[1], squares.ratio)];
            let beyond = |thick: &[CellOutcome], own: &CellOutcome| Some(thick[place].ratio? - own.ratio?);
            let thick = match &thick {
                Some((in_plane, in_space)) => [beyond(in_plane, &outcome), beyond(in_space, &squares)],
                None => [None, None],
            };
            ModelledRatios { area_law_factor, dynamic_mean, outcome, squares, thick, errors }
        })
        .collect())
}

/// Pattern of square cavities with the width, spacing and depth of `pattern`.
pub fn squares(pattern: &Pattern) -> Pattern {
    // Lengths of a valid pattern are valid for another planform.
    Pattern::new(Planform::Square, pattern.width_m(), pattern.spacing_m(), pattern.depth_m()).unwrap_or(*pattern)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_infer::calibrate::Measurement;

    /// Short layer, so that the test takes milliseconds.
    const LAYER: Layer = Layer { length_m: 500e-6, height_m: 100e-6, block_m: 10e-6, thickness_m: None, holder: None };

    fn predicted(law: Option<&AreaLaw>, depth_m: f64) -> Vec<ModelledRatios> {
        let pattern = Pattern::new(Planform::Groove, 60e-6, 140e-6, depth_m).unwrap();
        let points = [(0.3e6, 0.25), (2.6e6, 0.278)].map(|(pressure_pa, mu_dynamic)| {
            let mu_dynamic_std = 0.01 * mu_dynamic;
            let (force_n, speed_m_s, humidity) = (100.0, 2e-3, 0.5);
            let flat = Measurement { force_n, speed_m_s, humidity, mu_dynamic, mu_dynamic_std, static_peak: None };
            Pair { pressure_pa, flat, patterned: flat }
        });
        let elastic = Elastic::new(0.38e9, 900.0).unwrap();
        let body = Body { path: Path::new("c.toml"), elastic, modulus_relative_std: Some(0.2), layer: LAYER };
        let progress = slipgrid_base::monitor::Unwatched;
        predict(body, &[Case { pattern, law }], &points, &progress).unwrap().remove(0)
    }

    #[test]
    fn the_flat_surface_has_its_measured_friction() {
        let law = AreaLaw::new(vec![0.7e6, 2.6e6, 26e6], vec![1.0, 0.8, 0.2]).unwrap();
        let [light, heavy] = &predicted(Some(&law), 20e-6)[..] else { panic!() };
        assert_eq!((light.area_law_factor, light.dynamic_mean), (1.0, 0.25));
        assert!((heavy.area_law_factor - 0.8).abs() < 1e-12 && (heavy.dynamic_mean - 0.3475).abs() < 1e-12);
        assert!((heavy.outcome.mu_flat.unwrap() - 0.278).abs() < 1e-12);
        let ratio = |prediction: &ModelledRatios| prediction.outcome.ratio.unwrap();
        assert!(ratio(heavy) < ratio(light) && ratio(light) < 1.0);
        for prediction in [light, heavy] {
            let squares = prediction.squares.ratio.unwrap();
            // At the light load no point reaches the pressure where the area law bends: friction equals the flat surface's, to rounding.
            assert!(squares > ratio(prediction) && squares < 1.0 + 1e-9, "{squares}");
            assert!((prediction.squares.mu_flat.unwrap() - prediction.outcome.mu_flat.unwrap()).abs() < 1e-12);
            // An error of a fifth of Young's modulus changes the reduction by a fraction, less for squares than for grooves.
            let [grooves, in_space] = prediction.errors.clone().map(|errors| errors.unwrap());
            assert!(grooves.ratio.std < 0.5 * (1.0 - ratio(prediction)) && in_space.ratio.std < grooves.ratio.std);
            // Flat friction is known to 1 %; the ratio decreases slightly as flat friction increases.
            assert!(grooves.mu.std > 0.008 * prediction.outcome.mu_flat.unwrap() * ratio(prediction));
        }
    }

    #[test]
    fn no_pattern_changes_friction_without_an_area_law() {
        for prediction in predicted(None, 20e-6) {
            assert!((prediction.outcome.ratio.unwrap() - 1.0).abs() < 1e-9);
            assert!((prediction.squares.ratio.unwrap() - 1.0).abs() < 1e-9);
        }
    }
}
