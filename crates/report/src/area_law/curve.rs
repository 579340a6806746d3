//! Options of an area-law computation, and conversion of the results to a record.

use slipgrid_base::units::{LENGTH_UM, MODULUS_GPA, PRESSURE_MPA};
use slipgrid_design::results::{MadeBy, SCHEMA};
use slipgrid_infer::calibrate::area_law::{AreaLawRequest, SurfaceAreaLaw, SurfaceWarning, area_law, persson_curve};
use slipgrid_infer::calibrate::area_law_sampling::{Resolution, WindowSpread};
use slipgrid_infer::calibrate::light_pressure_pa;
use slipgrid_io::formats::altitude_map::law_warnings;
use slipgrid_io::formats::plausible::MODULUS;
use slipgrid_model::material::AreaLaw;
use slipgrid_surface::contact::{AreaPoint, ContactError};
use slipgrid_surface::topography::PreparedMap;

use super::{AreaLawReport, ContactArea};

/// Options of an area-law computation.
#[derive(Clone, Debug)]
pub struct AreaLawOptions {
    /// Young's modulus in GPa.
    pub youngs_modulus_gpa: f64,
    /// Poisson's ratio.
    pub poisson_ratio: f64,
    /// Relative error tolerance of the contact solver.
    pub tolerance: f64,
    /// Stated threshold pressure P0, in pascals; `None` for a small load, at which area is proportional to pressure.
    pub threshold_pa: Option<f64>,
    /// Requested pressures, increasing, in pascals.
    pub pressures_pa: Vec<f64>,
}

impl AreaLawOptions {
    /// Plans the curve for a surface with the slope `rms_slope`; `points` is the number of points of the map, if there
    /// is a map.
    ///
    /// The threshold P0 is solved as an additional pressure unless it is requested, or all requested pressures lie below.
    pub fn on_surface(self, rms_slope: f64, points: Option<usize>) -> AreaLawCurve {
        // E* = E / (1 - nu^2)
        let shrink = 1.0 - self.poisson_ratio * self.poisson_ratio;
        let contact_modulus_pa = MODULUS_GPA.to_si(self.youngs_modulus_gpa) / shrink;
        let limit = || light_pressure_pa(contact_modulus_pa, rms_slope, points);
        let threshold_pa = self.threshold_pa.unwrap_or_else(limit);
        let mut solved_pa = self.pressures_pa.clone();
        let place = solved_pa.partition_point(|&pressure_pa| pressure_pa < threshold_pa);
        let added = solved_pa.get(place).is_some_and(|&next_pa| next_pa > threshold_pa).then_some(place);
        if let Some(place) = added {
            solved_pa.insert(place, threshold_pa);
        }
        AreaLawCurve { options: self, contact_modulus_pa, threshold_pa, solved_pa, added }
    }
}

/// Options of an area-law computation with the pressures to solve.
#[derive(Clone, Debug)]
pub struct AreaLawCurve {
    options: AreaLawOptions,
    /// Contact modulus E* = E / (1 - nu^2), in pascals.
    contact_modulus_pa: f64,
    /// Threshold pressure P0, in pascals.
    threshold_pa: f64,
    /// Solved pressures, increasing, in pascals: the requested pressures and the threshold.
    solved_pa: Vec<f64>,
    /// Index of the threshold among the solved pressures if it was not requested.
    added: Option<usize>,
}

impl AreaLawCurve {
    /// Selects the values at requested pressures from those at solved pressures.
    fn requested<T: Clone>(&self, solved: &[T]) -> Vec<T> {
        let is_requested = |(place, _): &(usize, &T)| self.added != Some(*place);
        solved.iter().enumerate().filter(is_requested).map(|(_, value)| value.clone()).collect()
    }

    /// Converts the curve to a request for the solver.
    pub fn law(&self) -> AreaLawRequest<'_> {
        AreaLawRequest {
            contact_modulus_pa: self.contact_modulus_pa,
            pressures_pa: &self.solved_pa,
            threshold_pa: self.threshold_pa,
            tolerance: self.options.tolerance,
            windows: None,
        }
    }

    /// Area factor f at a pressure by `law`; without a law, 1 if no requested pressure exceeds the threshold, otherwise
    /// `None`.
    fn factor(&self, law: Option<&AreaLaw>, pressure_pa: f64) -> Option<f64> {
        let below = self.options.pressures_pa.iter().all(|&pressure_pa| pressure_pa <= self.threshold_pa);
        law.map(|law| law.factor(pressure_pa)).or(below.then_some(1.0))
    }

    /// Reports on the map `name`, from the solutions `found` on its prepared `surface`, and from `resolutions`, the
    /// solutions at coarser pixels.
    pub fn of_map(
        &self,
        name: &str,
        surface: &PreparedMap,
        found: &SurfaceAreaLaw,
        resolutions: &[Resolution],
    ) -> AreaLawReport {
        let coarser = |of: &Resolution| {
            let factor = of.factor.as_deref().map(|factors| self.requested(factors));
            Resolution { factor, ..of.clone() }
        };
        let mut report = AreaLawReport {
            map: Some(name.to_owned()),
            synthetic_surface: surface.synthetic,
            sa_um: Some(LENGTH_UM.from_si(surface.sa_m)),
            periodic_component: surface.is_component,
            pixel_um: Some(LENGTH_UM.from_si(surface.map.dx_m())),
            pixel_y_um: Some(LENGTH_UM.from_si(surface.map.dy_m())),
            rows: Some(surface.map.cols()),
            columns: Some(surface.map.rows()),
            full_contact_pressure_mpa: Some(PRESSURE_MPA.from_si(found.curve.full_contact_pressure_pa)),
            model: model(surface),
            warnings: self.warnings(&found.warnings),
            wall_s: found.curve_s,
            resolutions: resolutions.iter().map(coarser).collect(),
            ..self.report(&found.curve.points, surface.rms_slope)
        };
        if let Some(spread) = &found.windows {
            report.model.push(spread.statement());
            for (point, std) in report.results.iter_mut().zip(self.requested(&spread.factor_std())) {
                point.factor_std = Some(std);
            }
            report.windows = Some(WindowSpread {
                factor_mean: self.requested(&spread.factor_mean),
                factor_spread: self.requested(&spread.factor_spread),
                ..spread.clone()
            });
        }
        report
    }

    /// Reports on a surface with a known rms slope only, by Persson's theory.
    ///
    /// # Errors
    /// [`ContactError`] if an input is outside the theory's domain.
    pub fn of_theory(&self, rms_slope: f64) -> Result<AreaLawReport, ContactError> {
        let curve = persson_curve(rms_slope, self.contact_modulus_pa, &self.solved_pa)?;
        let model = vec![
            "area by Persson's theory, erf(sqrt 2 P / (E* h'rms)): it knows the surface only by its rms slope and is no \
             substitute for a map"
                .to_owned(),
            FACTOR_STATEMENT.to_owned(),
        ];
        let of_slope: Vec<SurfaceWarning> = SurfaceWarning::check_slope(rms_slope).into_iter().collect();
        let warnings = self.warnings(&of_slope);
        Ok(AreaLawReport { model, warnings, ..self.report(&curve, rms_slope) })
    }

    /// Warnings about an unusual modulus and about the surface.
    fn warnings(&self, of_surface: &[SurfaceWarning]) -> Vec<String> {
        let modulus_gpa = self.options.youngs_modulus_gpa;
        let of_modulus =
            MODULUS.judge(modulus_gpa).unwrap_or_else(|expected| Some(format!("is not possible: expected {expected}")));
        let of_modulus = of_modulus.map(|reason| format!("Young's modulus: {modulus_gpa} GPa {reason}"));
        of_modulus.into_iter().chain(law_warnings(of_surface)).collect()
    }

    /// Assembles the report of the solved points `curve`; fields that need a map stay empty.
    fn report(&self, curve: &[AreaPoint], rms_slope: f64) -> AreaLawReport {
        let law = area_law(curve, self.threshold_pa).ok();
        let persson = persson_curve(rms_slope, self.contact_modulus_pa, &self.solved_pa).ok();
        let persson = persson.and_then(|curve| area_law(&curve, self.threshold_pa).ok());
        let report = |point: &AreaPoint| ContactArea {
            pressure_mpa: PRESSURE_MPA.from_si(point.pressure_pa),
            area_fraction: point.area_fraction,
            area_fraction_corrected: point.area_fraction_corrected,
            factor: self.factor(law.as_ref(), point.pressure_pa),
            factor_std: None,
            factor_persson: self.factor(persson.as_ref(), point.pressure_pa),
            area_error: point.area_error,
            iterations: point.convergence.iterations,
            residual: point.convergence.residual,
        };
        AreaLawReport {
            made_by: MadeBy::slipgrid(SCHEMA),
            rms_slope,
            youngs_modulus_gpa: self.options.youngs_modulus_gpa,
            poisson_ratio: self.options.poisson_ratio,
            contact_modulus_gpa: MODULUS_GPA.from_si(self.contact_modulus_pa),
            threshold_mpa: PRESSURE_MPA.from_si(self.threshold_pa),
            threshold_proportionality: proportionality(curve, self.threshold_pa),
            tolerance: self.options.tolerance,
            threads: rayon::current_num_threads(),
            results: self.requested(curve).iter().map(report).collect(),
            ..AreaLawReport::default()
        }
    }
}

/// Ratio of contact area over pressure at the threshold to contact area over pressure at the lowest pressure; `None`
/// unless the curve has points at the threshold and below.
fn proportionality(curve: &[AreaPoint], threshold_pa: f64) -> Option<f64> {
    let share = |point: &AreaPoint| point.area_fraction_corrected / point.pressure_pa;
    let lightest = curve.first().filter(|point| point.pressure_pa < threshold_pa && point.area_fraction > 0.0)?;
    let at_threshold = curve.iter().find(|point| point.pressure_pa == threshold_pa)?;
    Some(share(at_threshold) / share(lightest))
}

/// Definition of the area factor f for the report.
const FACTOR_STATEMENT: &str = "f is the area over that at P0, divided by P/P0, and 1 below P0; without a stated threshold P0 is a small load, where A/P \
     stands for its limit";

/// States the model assumptions for `surface`.
fn model(surface: &PreparedMap) -> Vec<String> {
    let mut model = vec![
        "rough contact of the map with a rigid plane: elastic half-space, periodic, no adhesion".to_owned(),
        FACTOR_STATEMENT.to_owned(),
    ];
    if surface.synthetic {
        model.push("the map is synthetic, not measured".to_owned());
    }
    model.extend(surface.notes.iter().cloned());
    model
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_given_slope_of_no_surface_is_told() {
        let warnings = |youngs_modulus_gpa: f64, rms_slope: f64| curve(youngs_modulus_gpa, None, rms_slope).warnings;
        assert_eq!(warnings(0.38, 0.0137), [""; 0]);
        let told = warnings(0.38, 1e-5);
        assert!(told[0].starts_with("slope: the rms slope given is 1e-5"), "{told:?}");
        let told = warnings(380.0, 0.0137);
        assert!(
            told[0].starts_with("Young's modulus: 380 GPa is unusual") && told[0].contains("would be 0.38 GPa"),
            "{told:?}"
        );
    }

    /// Report for one rms slope at three pressures.
    fn curve(youngs_modulus_gpa: f64, threshold_pa: Option<f64>, rms_slope: f64) -> AreaLawReport {
        curve_at(&[0.5e6, 0.7e6, 2.6e6], youngs_modulus_gpa, threshold_pa, rms_slope)
    }

    fn curve_at(
        pressures_pa: &[f64],
        youngs_modulus_gpa: f64,
        threshold_pa: Option<f64>,
        rms_slope: f64,
    ) -> AreaLawReport {
        let options = AreaLawOptions {
            youngs_modulus_gpa,
            poisson_ratio: 1.0 / 3.0,
            tolerance: 1e-8,
            threshold_pa,
            pressures_pa: pressures_pa.to_vec(),
        };
        options.on_surface(rms_slope, None).of_theory(rms_slope).unwrap()
    }

    #[test]
    fn without_a_threshold_f_falls_from_the_first_load_on() {
        let factors = |threshold_pa: Option<f64>| -> Vec<f64> {
            curve(0.048, threshold_pa, 0.0358).results.iter().map(|point| point.factor.unwrap()).collect()
        };
        // E* h'rms = 1.93 MPa: erf(sqrt 2 x) / (sqrt(8 / pi) x) at x = P / 1.93 MPa
        for (found, known) in factors(None).iter().zip([0.9571, 0.9191, 0.4626]) {
            assert!((found - known).abs() < 2e-4, "{found} {known}");
        }
        assert_eq!(factors(Some(0.7e6))[..2], [1.0, 1.0]);
    }

    #[test]
    fn f_at_a_pressure_is_independent_of_the_others() {
        for threshold_pa in [None, Some(0.7e6)] {
            let last = |pressures_pa: &[f64]| {
                let report = curve_at(pressures_pa, 0.38, threshold_pa, 0.0137);
                assert_eq!(report.results.len(), pressures_pa.len());
                report.results.last().unwrap().factor.unwrap()
            };
            let alone = last(&[2.6e6]);
            for further_pa in [0.01e6, 0.05e6, 0.7e6, 1.3e6] {
                assert_eq!(last(&[further_pa, 2.6e6]), alone, "{further_pa}");
            }
        }
    }
}
