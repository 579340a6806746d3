//! Real contact area of a surface as a function of nominal pressure, and the area law, the factor f, computed from it.

use slipgrid_base::monitor::cached;
use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::statistics::{normal_probability, normal_quantile};
use slipgrid_base::units::{LENGTH_UM, PRESSURE_MPA, significant};
use slipgrid_model::material::{AreaLaw, MAX_FACTOR, MaterialError};
use slipgrid_surface::contact::closed_form::persson_area_fraction;
use slipgrid_surface::contact::{AreaCurve, AreaPoint, ContactError, Convergence, SolveOptions};
use slipgrid_surface::topography::{HeightMap, MapWarning, PreparedMap, limits};

use crate::calibrate::area_law_sampling::{
    DEFAULT_WINDOWS, MIN_DEFAULT_SIDE, WindowSpread, takes_default_windows, window_spread,
};

/// Relative error tolerance of the contact solver in a calibration: it changes the factors of the reference map by about
/// 1e-4, a hundredth of their standard errors (`factors_of_a_calibration_are_those_of_exact_contact`).
pub const CONTACT_TOLERANCE: f64 = 1e-4;

/// Default pressures of an area law, in MPa: up to the local pressures at edges of cavities, with [`area_law`] between
/// them. Pressures beyond full contact cost no time.
pub const DEFAULT_PRESSURES_MPA: [f64; 20] =
    [0.1, 0.2, 0.4, 0.7, 0.85, 1.0, 1.3, 1.6, 2.0, 2.6, 3.2, 4.0, 5.0, 6.5, 8.0, 10.0, 17.0, 30.0, 55.0, 100.0];

/// Between the pressures of a curve, an area law is tabulated at so many that f linear between them is off by about
/// this.
const MAX_OFF: f64 = 2e-4;
/// Maximum number of such intervals between two pressures of a curve.
const MAX_PARTS: f64 = 64.0;

/// Recommended side of a map, in millimetres, as in how-to/measure.md of the book.
const ADVISED_SIDE_MM: f64 = 0.5;

/// Options for computing an area law.
#[derive(Clone, Copy, Debug)]
pub struct AreaLawRequest<'a> {
    /// Contact modulus E* = E / (1 - nu^2), in pascals.
    pub contact_modulus_pa: f64,
    /// Nominal pressures to solve for, increasing, in pascals.
    pub pressures_pa: &'a [f64],
    /// Pressure P0 up to which friction is proportional to load, in pascals.
    pub threshold_pa: f64,
    /// Relative error tolerance of the contact solver for the whole map.
    pub tolerance: f64,
    /// Number of windows along each side of the map; their spread gives the standard errors of the law. Fewer than 2
    /// for no errors, `None` for [`DEFAULT_WINDOWS`] if the map is large enough.
    pub windows: Option<usize>,
}

/// Reason to doubt an area law. Each message begins with the name of the warning.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceWarning {
    /// A warning about the map.
    Map(MapWarning),
    /// A warning about the law, or about the slope that was given in place of a map.
    Law(String),
}

impl SurfaceWarning {
    /// Warns if a given rms slope is outside the range that slopes of maps are checked against; `None` if it is inside.
    pub fn check_slope(rms_slope: f64) -> Option<Self> {
        let [least, most] = limits::WARNED_SLOPE;
        (!(least..=most).contains(&rms_slope)).then(|| {
            Self::Law(format!(
                "slope: the rms slope given is {rms_slope:e}; surfaces that slide have {least:e} to {most:e}"
            ))
        })
    }
}

impl std::fmt::Display for SurfaceWarning {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Map(warning) => warning.fmt(f),
            Self::Law(text) => f.write_str(text),
        }
    }
}

/// Reason why a surface has no area law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AreaLawError {
    /// The contact solver refused the map or a number.
    #[error(transparent)]
    Contact(#[from] ContactError),
    /// The map cannot be split into the requested number of windows.
    #[error(transparent)]
    Windows(ContactError),
    /// The area factor f exceeds 1 by more than the counting error of contact points.
    #[error("f reaches {factor:.3} at {} MPa: the area law means nothing", PRESSURE_MPA.from_si(*pressure_pa))]
    FactorsAboveOne {
        /// Pressure at which f is largest, in pascals.
        pressure_pa: f64,
        /// Area factor f at this pressure.
        factor: f64,
        /// Warnings about the map.
        warnings: Vec<MapWarning>,
    },
    /// The monitor asked to stop.
    #[error("stopped")]
    Cancelled,
}

/// Contact area and area law of a map.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceAreaLaw {
    /// Contact area at the requested pressures.
    pub curve: AreaCurve,
    /// Area law, with standard errors of its factors if windows were solved; an error if the curve does not bracket the
    /// threshold pressure.
    pub law: Result<AreaLaw, MaterialError>,
    /// Spread of the law over windows of the map; `None` if no windows were solved, or one has no area law.
    pub windows: Option<WindowSpread>,
    /// Reasons to doubt the law.
    pub warnings: Vec<SurfaceWarning>,
    /// Time to solve the whole map, in seconds of the monitor's clock.
    pub curve_s: f64,
}

/// Computes the contact area of `surface` at every pressure, the area law, and the spread of the law over windows of
/// the map. Stages of the monitor: "area law", "windows".
///
/// # Errors
/// [`AreaLawError`] if the contact solver refuses a number, a pressure does not converge, the map is too small for the
/// requested windows, the factors exceed 1 by more than the counting error, or the monitor cancels.
pub fn surface_area_law(
    surface: &PreparedMap,
    request: &AreaLawRequest<'_>,
    monitor: &dyn Monitor,
) -> Result<SurfaceAreaLaw, AreaLawError> {
    let check_cancelled = || if monitor.cancelled() { Err(AreaLawError::Cancelled) } else { Ok(()) };
    // Check the windows before the contact computation, which takes long.
    if let Some(per_side) = request.windows.filter(|per_side| *per_side > 1) {
        slipgrid_surface::contact::window_pixels(&surface.map, per_side).map_err(AreaLawError::Windows)?;
    }
    let stage = Stage::new(monitor, "area law", None);
    let curve = area_curve(&surface.map, request.contact_modulus_pa, request.pressures_pa, request.tolerance, &stage);
    let curve_s = stage.finish();
    check_cancelled()?;
    let curve = curve?;
    let mut law = area_law(&curve.points, request.threshold_pa);
    let mut warnings: Vec<SurfaceWarning> = surface.warnings.iter().cloned().map(SurfaceWarning::Map).collect();
    if let Some((pressure_pa, factor)) = law.as_ref().ok().and_then(AreaLaw::above_one) {
        if factor > MAX_FACTOR {
            return Err(AreaLawError::FactorsAboveOne { pressure_pa, factor, warnings: surface.warnings.clone() });
        }
        warnings.push(SurfaceWarning::Law(format!(
            "factor above 1: f reaches {factor:.3} at {} MPa, where real contact area grows no faster than pressure: too few \
             points are in contact for their number to say more, or a few high ones carry the load of the rest; map a larger \
             area, and look for spikes",
            PRESSURE_MPA.from_si(pressure_pa)
        )));
    }
    let per_side = request.windows.unwrap_or(if takes_default_windows(&surface.map) { DEFAULT_WINDOWS } else { 0 });
    let mut windows = None;
    if per_side >= 2 {
        let stage = Stage::new(monitor, "windows", None);
        let spread = window_spread(&surface.map, per_side, request, &stage);
        let wall_s = stage.finish();
        check_cancelled()?;
        windows = spread?.map(|spread| WindowSpread { wall_s, ..spread });
    }
    if windows.is_none() && request.windows.is_none() && !takes_default_windows(&surface.map) {
        let map = &surface.map;
        let [along_x, along_y] = [map.rows(), map.cols()];
        let [x_um, y_um] = [map.dx_m() * along_x as f64, map.dy_m() * along_y as f64].map(|m| LENGTH_UM.from_si(m));
        warnings.push(SurfaceWarning::Law(format!(
            "small map: it measures {} x {} um in {along_x} x {along_y} points, too little to tell how far another place differs: the \
             area law has no error, and counts as if it were known; take {ADVISED_SIDE_MM} mm a side or more, in at \
             least {MIN_DEFAULT_SIDE} x {MIN_DEFAULT_SIDE} points",
            significant(x_um, 4),
            significant(y_um, 4)
        )));
    }
    if let Some(windows) = &windows {
        law = law.and_then(|law| with_errors(law, &curve.points, &windows.factor_std()));
    }
    Ok(SurfaceAreaLaw { curve, law, windows, warnings, curve_s })
}

/// Adds standard errors to the factors of the law: `factor_std`, one per point of `curve`, and linear between them.
fn with_errors(law: AreaLaw, curve: &[AreaPoint], factor_std: &[f64]) -> Result<AreaLaw, MaterialError> {
    let at = |pressure_pa: &f64| {
        let above = curve.partition_point(|point| point.pressure_pa < *pressure_pa);
        let below = above.saturating_sub(1);
        let [from_pa, to_pa] = [below, above].map(|row| curve[row].pressure_pa);
        let share = if above > below { (pressure_pa - from_pa) / (to_pa - from_pa) } else { 0.0 };
        factor_std[below] + share * (factor_std[above] - factor_std[below])
    };
    let errors = law.pressures_pa().iter().map(at).collect();
    law.with_factor_std(errors)
}

/// Returns the contact area of `map` at every pressure with the relative error `tolerance`, from the monitor's cache if
/// it holds the result.
///
/// # Errors
/// [`ContactError`] if the contact solver refuses a number, or a pressure does not converge.
pub fn area_curve(
    map: &HeightMap,
    contact_modulus_pa: f64,
    pressures_pa: &[f64],
    tolerance: f64,
    monitor: &dyn Monitor,
) -> Result<AreaCurve, ContactError> {
    let options = SolveOptions { tolerance, ..SolveOptions::default() };
    let content = (map, contact_modulus_pa, pressures_pa, tolerance);
    cached(monitor, ("area", &content), 1.0, || {
        slipgrid_surface::contact::area_curve(map, contact_modulus_pa, pressures_pa, &options, monitor)
    })
}

/// Computes the area law from a contact area curve, with friction proportional to load up to `threshold_pa`.
///
/// Between the pressures of the curve, contact area follows Persson's form with a scale that changes with pressure:
///
/// ```text
/// A(P) = erf(y P / sqrt 2),     y linear in ln P
/// ```
///
/// y is constant in the theory, and falls by a quarter from light loads to full contact on a map. On the reference map f
/// is within 0.0012 of contact at each pressure between those of [`DEFAULT_PRESSURES_MPA`]
/// (`the_law_between_its_pressures_is_that_of_contact`); f linear between 28 pressures was within 0.0037.
///
/// # Errors
/// [`MaterialError`] if the curve does not bracket the threshold pressure.
pub fn area_law(curve: &[AreaPoint], threshold_pa: f64) -> Result<AreaLaw, MaterialError> {
    let own = |point: &AreaPoint| [point.pressure_pa, point.area_fraction_corrected];
    let per_pa = curve.iter().map(|point| point.area_fraction_corrected / point.pressure_pa).fold(0.0, f64::max);
    let inner = curve.windows(2).flat_map(|pair| between(own(&pair[0]), own(&pair[1]), per_pa));
    let (pressures_pa, areas): (Vec<f64>, Vec<f64>) =
        inner.chain(curve.last().map(own)).map(|[pressure_pa, area]| (pressure_pa, area)).unzip();
    AreaLaw::from_area_curve(&pressures_pa, &areas, threshold_pa)
}

/// Pressures, in pascals, and contact areas from the point `from` of a curve, included, to the point `to`, excluded.
/// `per_pa` is contact area over pressure at light loads.
fn between(from: [f64; 2], to: [f64; 2], per_pa: f64) -> Vec<[f64; 2]> {
    let ([from_pa, from_area], [to_pa, to_area]) = (from, to);
    let scale = |[pressure_pa, area]: [f64; 2]| normal_quantile(0.5 + 0.5 * area) / pressure_pa;
    let [first, last] = [from, to].map(scale);
    // In full contact the scale is infinite; its value in partial contact goes on.
    let by = if last.is_finite() { last - first } else { 0.0 };
    let step = (to_pa / from_pa).ln();
    let area_at = |pressure_pa: f64| match (pressure_pa / from_pa).ln() / step {
        share if first.is_finite() => 2.0 * normal_probability((first + share * by) * pressure_pa) - 1.0,
        _ => to_area,
    };
    // Halving an interval leaves a quarter of the error of linear interpolation, which is greatest near the middle.
    let middle_pa = f64::midpoint(from_pa, to_pa);
    let off = area_at(middle_pa) / middle_pa - f64::midpoint(from_area / from_pa, to_area / to_pa);
    let parts = (off.abs() / per_pa / MAX_OFF).sqrt().ceil().min(MAX_PARTS);
    // At most MAX_PARTS: the cast is exact.
    let parts = if step.is_finite() { parts as usize } else { 1 };
    let inner = (1..parts).map(|part| {
        let pressure_pa = from_pa * (part as f64 / parts as f64 * step).exp();
        [pressure_pa, area_at(pressure_pa)]
    });
    std::iter::once(from).chain(inner).collect()
}

/// Contact area at every pressure by Persson's theory, for a surface of which only the rms slope is known.
///
/// # Errors
/// [`ContactError`] if the theory refuses a number.
pub fn persson_curve(
    rms_slope: f64,
    contact_modulus_pa: f64,
    pressures_pa: &[f64],
) -> Result<Vec<AreaPoint>, ContactError> {
    let point = |&pressure_pa: &f64| {
        let area_fraction = persson_area_fraction(pressure_pa, contact_modulus_pa, rms_slope)?;
        Ok(AreaPoint {
            pressure_pa,
            area_fraction,
            area_fraction_corrected: area_fraction,
            area_error: 0.0,
            convergence: Convergence::default(),
        })
    };
    pressures_pa.iter().map(point).collect()
}

/// Warnings about the table of an area law, one sentence each; each begins with the name of the warning.
pub fn table_warnings(law: &AreaLaw) -> Vec<String> {
    let shown = |number: f64| significant(number, 4);
    let step = law.step().map(|(pressure_pa, factor)| {
        format!(
            "area law jumps: f falls from 1 to {} at its first pressure, {} MPa, where a law that comes of contact area \
             begins with 1",
            shown(factor),
            shown(PRESSURE_MPA.from_si(pressure_pa))
        )
    });
    let above = law.above_one().map(|(pressure_pa, factor)| {
        format!(
            "factor above 1: f is {} at {} MPa, where real contact area grows no faster than pressure",
            shown(factor),
            shown(PRESSURE_MPA.from_si(pressure_pa))
        )
    });
    step.into_iter().chain(above).collect()
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicBool, Ordering};

    use super::*;
    use slipgrid_base::monitor::{CachingMonitor, Unwatched};
    use slipgrid_surface::topography::{Form, MapFormat, Preparation, ReadMap, SelfAffine};

    /// Area law of the first `side` x `side` points of a synthetic map.
    fn law_of(side: usize, windows: Option<usize>) -> SurfaceAreaLaw {
        let whole = SelfAffine { pixels: 64, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap();
        let height_m = (0..side * side).map(|n| whole.heights_m()[n / side * 64 + n % side]).collect();
        let map = HeightMap::new(side, side, 2.5e-6, 2.5e-6, height_m).unwrap();
        let read = ReadMap { map, whole: false, format: MapFormat::Matrix, comments: Vec::new(), notes: Vec::new() };
        let how = Preparation { form: Form::Plane, ..Preparation::default() };
        let surface = PreparedMap::one_period(read, how, &Unwatched).unwrap();
        let request = AreaLawRequest {
            contact_modulus_pa: 0.43e9,
            pressures_pa: &[0.5e6, 0.7e6, 2.0e6],
            threshold_pa: 0.7e6,
            tolerance: 1e-4,
            windows,
        };
        surface_area_law(&surface, &request, &Unwatched).unwrap()
    }

    #[test]
    fn a_curve_is_kept_to_the_last_bit_and_solved_again_for_another_map_or_pressure() {
        let map = SelfAffine { pixels: 32, max_wave: 8, ..SelfAffine::STAND_IN }.map().unwrap();
        let mut height_m = map.heights_m().to_vec();
        height_m[7] += 1e-12;
        let other = HeightMap::new(32, 32, map.dx_m(), map.dy_m(), height_m).unwrap();
        let cancelling = AtomicBool::new(false);
        let monitor = CachingMonitor::new(&cancelling);
        let pressures_pa = [0.5e6, 2e6, 1e9];
        for (map, pressures_pa) in [(&map, &pressures_pa[..]), (&other, &pressures_pa), (&map, &pressures_pa[..2])] {
            let curve = |monitor: &dyn Monitor| area_curve(map, 0.43e9, pressures_pa, 1e-6, monitor);
            let is_kept_as = |expected: &AreaCurve| {
                cancelling.store(true, Ordering::Relaxed);
                let found = curve(&monitor);
                cancelling.store(false, Ordering::Relaxed);
                found.as_ref() == Ok(expected)
            };
            let solved = curve(&Unwatched).unwrap();
            assert!(!is_kept_as(&solved), "another curve is no answer");
            assert_eq!(curve(&monitor).as_ref(), Ok(&solved));
            assert!(is_kept_as(&solved));
        }
    }

    #[test]
    fn factors_of_a_calibration_are_those_of_exact_contact() {
        let map = SelfAffine { pixels: 256, max_wave: 32, ..SelfAffine::STAND_IN }.map().unwrap();
        let pressures_pa = [0.3e6, 0.7e6, 1.0e6, 2.0e6, 4.0e6, 8.0e6];
        let factors = |tolerance: f64| -> Vec<f64> {
            let curve = area_curve(&map, 0.43e9, &pressures_pa, tolerance, &Unwatched).unwrap();
            let law = area_law(&curve.points, 0.3e6).unwrap();
            pressures_pa.iter().map(|pressure_pa| law.factor(*pressure_pa)).collect()
        };
        // Standard errors of the factors of measured maps are 0.02 to 0.07.
        for (found, exact) in factors(CONTACT_TOLERANCE).iter().zip(factors(1e-8)) {
            assert!((found - exact).abs() < 3e-4, "{found} {exact}");
        }
    }

    #[test]
    fn the_law_between_its_pressures_is_that_of_contact() {
        let map = SelfAffine { pixels: 256, max_wave: 32, ..SelfAffine::STAND_IN }.map().unwrap();
        let pressures_pa = DEFAULT_PRESSURES_MPA.map(|mpa| PRESSURE_MPA.to_si(mpa));
        let curve = |pressures_pa: &[f64]| area_curve(&map, 0.43e9, pressures_pa, 1e-6, &Unwatched).unwrap();
        let law = area_law(&curve(&pressures_pa).points, 0.7e6).unwrap();
        let at_threshold = law.pressures_pa()[0];
        let inner: Vec<f64> = pressures_pa[3..].windows(2).map(|pair| (pair[0] * pair[1]).sqrt()).collect();
        let solved = curve(&[&[at_threshold][..], &inner].concat()).points;
        for point in &solved[1..] {
            // f(P) = [A(P) / A(P0)] / [P / P0]
            let relative = point.area_fraction_corrected / solved[0].area_fraction_corrected;
            let exact = relative / (point.pressure_pa / at_threshold);
            let found = law.factor(point.pressure_pa);
            assert!((found - exact).abs() < 2e-3, "{} Pa: {found} {exact}", point.pressure_pa);
        }
        // In full contact f P is constant.
        let kept = law.factor(80e6) - law.factor(100e6) * 100.0 / 80.0;
        assert!(kept.abs() < MAX_OFF, "{kept}");
        let from_zero = [0.0, 0.7e6, 2e6].map(|pressure_pa| AreaPoint { pressure_pa, ..solved[0] });
        assert_eq!(area_law(&from_zero, 0.7e6).unwrap().factor(0.35e6), 1.0);
    }

    #[test]
    fn a_map_too_small_for_an_error_of_its_law_is_told() {
        let told = |found: &SurfaceAreaLaw| {
            let is_small = |warning: &&SurfaceWarning| warning.to_string().starts_with("small map");
            found.warnings.iter().find(is_small).map(ToString::to_string)
        };
        for side in [12, 40] {
            let said = told(&law_of(side, None)).unwrap();
            let size = format!("{} x {} um in {side} x {side} points", 2.5 * side as f64, 2.5 * side as f64);
            assert!(
                said.contains(&size) && said.contains("0.5 mm a side") && said.contains("64 x 64 points"),
                "{said}"
            );
            assert!(!said.contains("  "), "{said}");
        }
        // A map that is large enough for windows has errors, and a request for no windows causes no warning.
        let whole = law_of(64, None);
        assert!(told(&whole).is_none() && whole.windows.is_some());
        assert_eq!(told(&law_of(40, Some(0))), None);
    }

    #[test]
    fn a_given_slope_is_doubted_as_that_of_a_map() {
        for usual in [1e-4, 0.1, 1.0] {
            assert_eq!(SurfaceWarning::check_slope(usual), None);
        }
        for doubtful in [1e-5, 1.5] {
            let said = SurfaceWarning::check_slope(doubtful).unwrap().to_string();
            assert!(said.starts_with("slope: the rms slope given is") && said.contains("1e-4 to 1e0"), "{said}");
        }
        let [least, most] = limits::POSSIBLE_SLOPE;
        let slope = slipgrid_base::units::SLOPE;
        assert!(
            slope.accepts(least) && !slope.accepts(0.9 * least) && slope.accepts(most) && !slope.accepts(1.1 * most)
        );
    }
}
