//! From an altitude map to contact area against pressure and the area law.

use std::path::Path;

use slipgrid_contact::closed_form::persson_area_fraction;
use slipgrid_contact::{AreaCurve, AreaPoint, ContactError, Convergence, Monitor, SolveOptions, Status};
use slipgrid_material::{AreaLaw, MOST_FACTOR, MaterialError};
use slipgrid_topography::HeightMap;

use slipgrid_formats::Diagnostic;
use slipgrid_units::PRESSURE_MPA;

/// Pressures of an area law where none are given, in MPa: dense where f bends, up to what edges of cavities see.
/// From full contact on a pressure costs nothing.
pub const DEFAULT_PRESSURES_MPA: [f64; 28] = [
    0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.85, 1.0, 1.3, 1.6, 2.0, 2.6, 3.2, 4.0, 5.0, 6.5, 8.0, 10.0, 13.0, 17.0,
    22.0, 30.0, 40.0, 55.0, 75.0, 100.0,
];

/// What a closed form takes.
const CLOSED_FORM: Convergence =
    Convergence { status: Status::Converged, iterations: 0, fourier_pairs: 0, residual: 0.0 };

/// Computes the contact area of `map` at every pressure to `tolerance`.
///
/// # Errors
/// [`ContactError`] if a number means nothing to the contact solver.
pub fn area_curve(
    map: &HeightMap,
    contact_modulus_pa: f64,
    pressures_pa: &[f64],
    tolerance: f64,
    monitor: &dyn Monitor,
) -> Result<AreaCurve, ContactError> {
    let options = SolveOptions { tolerance, ..SolveOptions::default() };
    slipgrid_contact::area_curve(map, contact_modulus_pa, pressures_pa, &options, monitor)
}

/// The area law that `curve` implies, proportional up to `threshold_pa`.
///
/// # Errors
/// [`MaterialError`] if the curve does not bracket the threshold pressure.
pub fn area_law(curve: &[AreaPoint], threshold_pa: f64) -> Result<AreaLaw, MaterialError> {
    let pressure_pa: Vec<f64> = curve.iter().map(|point| point.pressure_pa).collect();
    let area: Vec<f64> = curve.iter().map(|point| point.area_fraction_corrected).collect();
    AreaLaw::from_area_curve(&pressure_pa, &area, threshold_pa)
}

/// The warning on an area law whose factors exceed 1, if they do: real contact area grows no faster than pressure. `warnings`
/// is what is known to be wrong with the map at `path`.
///
/// # Errors
/// [`Diagnostic`] if they exceed it by more than a count of points scatters.
pub fn check_factors(path: &Path, law: &AreaLaw, warnings: &[String]) -> Result<Option<String>, Diagnostic> {
    let Some((pressure_pa, factor)) = law.above_one() else { return Ok(None) };
    let found = format!("f reaches {factor:.3} at {} MPa", PRESSURE_MPA.from_si(pressure_pa));
    if factor > MOST_FACTOR {
        let mut reason = format!("{found}: the area law means nothing");
        for warning in warnings {
            reason += &format!("; {warning}");
        }
        let expected = format!(
            "contact area that grows no faster than pressure, f at most {MOST_FACTOR}: a few high points carry the load of \
             the surface (--despike, despike = true in [surface])"
        );
        return Err(Diagnostic::file(path, reason).expected(expected));
    }
    Ok(Some(format!(
        "factor above 1: {found}, where real contact area grows no faster than pressure: too few points are in contact for \
         their number to say more, or a few high ones carry the load of the rest"
    )))
}

/// The contact area of a surface of which only the rms slope is known, by Persson's theory.
///
/// # Errors
/// [`ContactError`] if a number means nothing to the theory.
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
            convergence: CLOSED_FORM,
        })
    };
    pressures_pa.iter().map(point).collect()
}
