//! Surface from which the area law of a calibration is computed: contact area from a map or from theory.

use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, significant};
use slipgrid_model::material::AreaLaw;
use slipgrid_surface::contact::AreaPoint;
use slipgrid_surface::topography::{LIMITED_BY_PIXELS, PreparedMap};

use crate::calibrate::area_law::{
    AreaLawRequest, CONTACT_TOLERANCE, SurfaceWarning, area_curve, area_law, persson_curve, surface_area_law,
};
use crate::calibrate::calibration_task::{CalibrationError, CalibrationTask, MapSurface, Surface};
use crate::calibrate::{AreaLawScale, Fit, LawPressures};

/// Local pressures, in MPa, at which the area laws of maps before and after a test are compared.
const COMPARED_MPA: [f64; 3] = [1.3, 2.6, 8.0];
/// Name of the fitted scale among the parameters of a fit.
const SCALE_PARAMETER: &str = "area_law_scale_pa";
/// Number of tabulated pressures of a fitted law: many, so that the law is smooth.
const SCALED_POINTS: usize = 241;
/// Range of the table of a fitted law, in P / (E* h'rms), pressure over contact modulus and rms slope: from small
/// loads, where contact area over pressure is within 1e-8 of its limit, to full contact.
const SCALED_RANGE: [f64; 2] = [1e-4, 10.0];

/// Origin of an area law.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AreaLawOrigin {
    /// Rough contact of a height map.
    Map,
    /// Persson's theory for a given rms slope.
    Persson,
    /// Persson's theory with a scale that was fitted to friction.
    Fit,
    /// Measured flat friction.
    Measured,
}

slipgrid_base::names!(AreaLawOrigin { Map = "map", Persson = "persson", Fit = "fit", Measured = "measured" });

/// Surface of a calibration and the area law computed from it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SurfaceFindings {
    /// Origin of the law; `None` without a law.
    pub origin: Option<AreaLawOrigin>,
    /// Whether the map is synthetic.
    pub synthetic: bool,
    /// Rms slope of the surface; `None` without a map or a given slope.
    pub rms_slope: Option<f64>,
    /// Arithmetic mean height Sa of the map, in metres; `None` without a map.
    pub sa_m: Option<f64>,
    /// Size of the map's pixels along the sliding direction, in metres; `None` without a map.
    pub pixel_m: Option<f64>,
    /// Size of the map's pixels across the sliding direction, in metres, if it differs from `pixel_m`.
    pub pixel_y_m: Option<f64>,
    /// Contact area from which the law was computed; empty if it was not computed from contact area.
    pub curve: Vec<AreaPoint>,
    /// Area law, with standard errors if windows of the map were solved; `None` without a surface, or before its scale
    /// is fitted.
    pub law: Option<AreaLaw>,
    /// Notes on the method, one sentence each.
    pub notes: Vec<String>,
    /// Reasons to doubt the law.
    pub warnings: Vec<SurfaceWarning>,
    /// Lower and upper bound of the area law's scale, in pascals; `None` if the scale is not fitted.
    pub(crate) scale_bounds_pa: Option<[f64; 2]>,
}

impl SurfaceFindings {
    /// The law, and the contact area from which it is computed if it depends on the modulus (empty otherwise).
    pub(crate) fn law_and_curve(&self) -> (Option<&AreaLaw>, &[AreaPoint]) {
        (self.law.as_ref(), if self.depends_on_modulus() { &self.curve } else { &[] })
    }

    /// Whether the law depends on Young's modulus. A measured law does not, nor one whose scale was fitted to friction.
    pub fn depends_on_modulus(&self) -> bool {
        !matches!(self.origin, Some(AreaLawOrigin::Measured | AreaLawOrigin::Fit))
    }

    /// Area law with a scale to fit: Persson's contact area against P / (E* h'rms), from small loads to full contact.
    /// `None` if the scale is not fitted.
    pub(crate) fn scale(&self) -> Result<Option<AreaLawScale>, CalibrationError> {
        let Some(bounds_pa) = self.scale_bounds_pa else { return Ok(None) };
        let [from, to] = SCALED_RANGE;
        let pressure_over_scale: Vec<f64> =
            (0..SCALED_POINTS).map(|i| from * (to / from).powf(i as f64 / (SCALED_POINTS - 1) as f64)).collect();
        let curve = persson_curve(1.0, 1.0, &pressure_over_scale)?;
        let area_fraction = curve.iter().map(|point| point.area_fraction).collect();
        Ok(Some(AreaLawScale { area_fraction, pressure_over_scale, bounds_pa }))
    }

    /// Sets law and contact area to those at the fitted scale, if the scale was fitted.
    pub(crate) fn set_fitted_scale(&mut self, fit: &Fit) -> Result<(), CalibrationError> {
        let Some(scale) = self.scale()? else { return Ok(()) };
        self.origin = Some(AreaLawOrigin::Fit);
        self.law.clone_from(&fit.area_law);
        if let Some(found) = fit.parameters.iter().find(|parameter| parameter.name == SCALE_PARAMETER) {
            let pressures_pa: Vec<f64> = scale.pressure_over_scale.iter().map(|x| x * found.value).collect();
            // The fit has already accepted these numbers.
            self.curve = persson_curve(1.0, found.value, &pressures_pa).unwrap_or_default();
        }
        Ok(())
    }
}

/// A warning is given if A / P (contact area over pressure) decreases by more than this fraction from the lightest
/// measured load to a stated threshold.
const MAX_AREA_DECREASE: f64 = 0.02;

/// Warning if contact area grows less than in proportion to load below the stated threshold.
fn threshold_warning(task: &CalibrationTask, curve: &[AreaPoint]) -> Option<SurfaceWarning> {
    let threshold_pa = task.threshold_pa?;
    let lightest_pa = task.flat.iter().map(|measured| task.pressure_pa(measured)).reduce(f64::min)?;
    // A / P, interpolated linearly between the points of the curve.
    let per_load = |pressure_pa: f64| {
        let above = curve.partition_point(|point| point.pressure_pa < pressure_pa);
        let share = |point: &AreaPoint| point.area_fraction_corrected / point.pressure_pa;
        let (lower, upper) = (curve.get(above.checked_sub(1)?)?, curve.get(above)?);
        let place = (pressure_pa - lower.pressure_pa) / (upper.pressure_pa - lower.pressure_pa);
        Some((1.0 - place) * share(lower) + place * share(upper))
    };
    let share = per_load(threshold_pa)? / per_load(lightest_pa)?;
    (lightest_pa < threshold_pa && share < 1.0 - MAX_AREA_DECREASE).then(|| {
        SurfaceWarning::Law(format!(
            "threshold: friction counts as proportional to load up to {} MPa, where contact area per load is {share:.2} times that at \
             {} MPa, the lightest load measured; without threshold_mpa the law follows the area that was computed",
            PRESSURE_MPA.from_si(threshold_pa),
            significant(PRESSURE_MPA.from_si(lightest_pa), 3)
        ))
    })
}

/// Computes contact area and area law of the surface of `task`, before the fit.
pub(crate) fn surface_findings(
    task: &CalibrationTask,
    monitor: &dyn Monitor,
) -> Result<SurfaceFindings, CalibrationError> {
    let contact_modulus_pa = task.elastic.contact_modulus_pa(task.poisson_ratio);
    let mut found = match &task.surface {
        Surface::None => SurfaceFindings {
            notes: vec!["no surface was given: friction is proportional to load (Amontons-Coulomb)".to_owned()],
            ..SurfaceFindings::default()
        },
        Surface::FittedScale { bounds_pa } => {
            SurfaceFindings { scale_bounds_pa: Some(*bounds_pa), ..SurfaceFindings::default() }
        }
        Surface::FlatFriction { law, extrapolation } => SurfaceFindings {
            origin: Some(AreaLawOrigin::Measured),
            law: Some(law.clone()),
            notes: vec![format!(
                "local law: measured flat friction itself, mu(p) = mu_flat(P = p), {} above the last measured pressure; no area law, and \
                 Young's modulus does not move it",
                extrapolation.name()
            )],
            ..SurfaceFindings::default()
        },
        Surface::RmsSlope(rms_slope) => {
            let table = LawPressures::new(task.threshold_pa, contact_modulus_pa, *rms_slope, None);
            let curve = persson_curve(*rms_slope, contact_modulus_pa, &table.pressures_pa)?;
            SurfaceFindings {
                origin: Some(AreaLawOrigin::Persson),
                rms_slope: Some(*rms_slope),
                law: Some(area_law(&curve, table.threshold_pa).map_err(CalibrationError::NoAreaLaw)?),
                curve,
                notes: vec!["area law by Persson's theory from the rms slope: no substitute for a map".to_owned()],
                warnings: SurfaceWarning::check_slope(*rms_slope).into_iter().collect(),
                ..SurfaceFindings::default()
            }
        }
        Surface::Map(surface) => {
            let map = &surface.map;
            let points = map.map.rows() * map.map.cols();
            let table = LawPressures::new(task.threshold_pa, contact_modulus_pa, map.rms_slope, Some(points));
            let request = AreaLawRequest {
                contact_modulus_pa,
                pressures_pa: &table.pressures_pa,
                threshold_pa: table.threshold_pa,
                tolerance: CONTACT_TOLERANCE,
                windows: surface.windows,
            };
            findings_from_map(surface, &request, monitor)?
        }
    };
    found.warnings.extend(threshold_warning(task, &found.curve));
    Ok(found)
}

fn findings_from_map(
    surface: &MapSurface,
    request: &AreaLawRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<SurfaceFindings, CalibrationError> {
    let map = &surface.map;
    let found = surface_area_law(map, request, monitor)?;
    let law = found.law.map_err(CalibrationError::NoAreaLaw)?;
    let mut notes = map.notes.clone();
    notes.extend(limited_by_pixels(map, monitor));
    if monitor.cancelled() {
        return Err(CalibrationError::Cancelled);
    }
    if let Some(after) = &surface.after {
        notes.push(after_test(after, (map, &law), request, monitor)?);
    }
    if let Some(windows) = &found.windows {
        notes.push(windows.statement());
    }
    Ok(SurfaceFindings {
        origin: Some(AreaLawOrigin::Map),
        synthetic: surface.synthetic || map.synthetic,
        rms_slope: Some(map.rms_slope),
        sa_m: Some(map.sa_m),
        pixel_m: Some(map.pixel_m()),
        pixel_y_m: Some(map.map.dy_m()).filter(|pixel_y_m| *pixel_y_m != map.pixel_m()),
        curve: found.curve.points,
        law: Some(law),
        notes,
        warnings: found.warnings,
        scale_bounds_pa: None,
    })
}

/// Note that finer pixels would give a higher slope and therefore another law; `None` if short waves contribute little
/// to the slope.
fn limited_by_pixels(map: &PreparedMap, monitor: &dyn Monitor) -> Option<String> {
    let short = map.map.short_waves(monitor).ok().filter(|short| short.slope_share > LIMITED_BY_PIXELS)?;
    Some(format!(
        "area law: {:.0} % of the map's squared slope lies in waves shorter than {:.2} um, four of its pixels: finer pixels would find a \
         higher slope, and the law holds for these pixels",
        100.0 * short.slope_share,
        LENGTH_UM.from_si(short.below_m)
    ))
}

/// Note that compares the map `after` the test with the map before the test, from which the law `own` was computed.
fn after_test(
    after: &PreparedMap,
    (before, own): (&PreparedMap, &AreaLaw),
    request: &AreaLawRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<String, CalibrationError> {
    let stage = Stage::new(monitor, "area law after the test", None);
    let curve = area_curve(&after.map, request.contact_modulus_pa, request.pressures_pa, request.tolerance, &stage);
    stage.finish();
    if monitor.cancelled() {
        return Err(CalibrationError::Cancelled);
    }
    let refuse = |error: &dyn std::fmt::Display| CalibrationError::MapAfter(error.to_string());
    let curve = curve.map_err(|error| refuse(&error))?;
    let other = area_law(&curve.points, request.threshold_pa).map_err(|error| refuse(&error))?;
    let at: Vec<String> = COMPARED_MPA
        .iter()
        .map(|mpa| {
            let [own, other] = [own, &other].map(|law| law.factor(PRESSURE_MPA.to_si(*mpa)));
            format!("{own:.3} and {other:.3} at {mpa} MPa")
        })
        .collect();
    Ok(format!(
        "area law: of the map before the test. After it Sa is {:.3} um instead of {:.3} um and the rms slope {:.4} instead of {:.4}: f \
         before and after would be {}",
        after.sa_m * 1e6,
        before.sa_m * 1e6,
        after.rms_slope,
        before.rms_slope,
        at.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::calibrate::Measurement;
    use crate::calibrate::trial_discrepancy::tests;
    use slipgrid_base::monitor::Unwatched;
    use slipgrid_model::material::Elastic;
    use slipgrid_model::pattern::Planform;

    #[test]
    fn a_given_slope_of_no_surface_makes_the_law_doubtful() {
        let warnings =
            |rms_slope: f64| surface_findings(&task(0.38e9, rms_slope, Vec::new()), &Unwatched).unwrap().warnings;
        assert_eq!(warnings(0.0137), []);
        assert_eq!(warnings(2.0), SurfaceWarning::check_slope(2.0).into_iter().collect::<Vec<_>>());
    }

    fn task(modulus_pa: f64, rms_slope: f64, flat: Vec<Measurement>) -> CalibrationTask {
        CalibrationTask {
            elastic: Elastic::new(modulus_pa, 900.0).unwrap(),
            surface: Surface::RmsSlope(rms_slope),
            specimen_area_m2: 50e-6,
            ..tests::task(flat, Planform::Groove)
        }
    }

    #[test]
    fn without_a_threshold_the_law_follows_the_area_within_the_measured_loads() {
        // Loads of 0.15 to 1 MPa on a soft solid, E* h'rms = 1.93 MPa; the threshold published for polyethylene is
        // within this range.
        let measured = |force_n: f64| tests::measured(force_n, 0.4, 0.6);
        let of = |threshold_pa: Option<f64>| {
            let flat = [7.5, 15.0, 50.0].map(measured).to_vec();
            surface_findings(&CalibrationTask { threshold_pa, ..task(48e6, 0.0358, flat) }, &Unwatched).unwrap()
        };
        let (free, stated) = (of(None), of(Some(0.7e6)));
        let factors =
            |found: &SurfaceFindings| [0.15e6, 1e6].map(|pressure_pa| found.law.as_ref().unwrap().factor(pressure_pa));
        // erf(sqrt 2 x) / (sqrt(8 / pi) x), x = 0.15 / 1.93 and 1 / 1.93
        let ([light, heavy], [clamped, _]) = (factors(&free), factors(&stated));
        assert!((light - 0.9960).abs() < 2e-4 && (heavy - 0.8470).abs() < 5e-4 && clamped == 1.0, "{light} {heavy}");
        assert_eq!(free.warnings, []);
        let said = stated.warnings[0].to_string();
        assert!(said.contains("up to 0.7 MPa, where contact area per load is 0.92 times that at 0.15 MPa"), "{said}");
        // There is no warning for a threshold below the loads, nor if area is proportional to load.
        assert_eq!(of(Some(0.1e6)).warnings, []);
        let stiff = CalibrationTask { threshold_pa: Some(0.7e6), ..task(0.38e9, 0.0137, vec![measured(30.0)]) };
        assert_eq!(surface_findings(&stiff, &Unwatched).unwrap().warnings, []);
    }
}
