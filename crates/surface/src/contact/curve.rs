use std::sync::{Mutex, PoisonError};

use crate::topography::HeightMap;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::contact::rough_contact::check;
use crate::contact::solver::BufferPool;
use crate::contact::{ContactError, Convergence, Monitor, RoughContact, SolveOptions};

/// Real contact area at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaPoint {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Pixels in contact over all pixels.
    pub area_fraction: f64,
    /// Area fraction corrected for the contact boundary, see [`ContactArea`](crate::contact::ContactArea).
    pub area_fraction_corrected: f64,
    /// Estimated error of both area fractions that results from stopping at the tolerance.
    pub area_error: f64,
    /// Iterations and residual of the solve.
    pub convergence: Convergence,
}

/// Real contact area against nominal pressure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AreaCurve {
    /// One point per pressure, in the order of the requested pressures.
    pub points: Vec<AreaPoint>,
    /// Lowest nominal pressure at which all of the map is in contact, in pascals.
    pub full_contact_pressure_pa: f64,
}

/// Computes the real contact area of `map` at each of `pressures_pa` on a half-space of contact modulus E* = E/(1 -
/// nu^2).
///
/// Pressures are solved in parallel; the result does not depend on the number of threads. `monitor` is advanced after
/// each pressure.
///
/// # Errors
/// [`ContactError`] if the map is incomplete, if the modulus, a pressure or the tolerance is out of range, if a
/// pressure does not converge, or if the area falls with rising pressure; [`crate::topography::MapError::Cancelled`]
/// once `monitor` cancels.
pub fn area_curve(
    map: &HeightMap,
    contact_modulus_pa: f64,
    pressures_pa: &[f64],
    options: &SolveOptions,
    monitor: &dyn Monitor,
) -> Result<AreaCurve, ContactError> {
    for &pressure_pa in pressures_pa {
        check(pressure_pa, options)?;
    }
    let contact = RoughContact::new(map, contact_modulus_pa, monitor)?;
    let share = 1.0 / pressures_pa.len() as f64;
    let pools: Mutex<Vec<BufferPool>> = Mutex::default();
    let points: Vec<Result<AreaPoint, ContactError>> = pressures_pa
        .par_iter()
        .with_max_len(1)
        .map(|&pressure_pa| {
            let point = area_point(&contact, pressure_pa, options, monitor, &pools);
            monitor.advance(share);
            point
        })
        .collect();
    let points = points.into_iter().collect::<Result<Vec<_>, _>>()?;
    require_rising_areas(&points, options.tolerance)?;
    Ok(AreaCurve { points, full_contact_pressure_pa: contact.full_contact_pressure_pa() })
}

/// Computes one point of the curve, in buffers from one of `pools`.
fn area_point(
    contact: &RoughContact<'_>,
    pressure_pa: f64,
    options: &SolveOptions,
    monitor: &dyn Monitor,
    pools: &Mutex<Vec<BufferPool>>,
) -> Result<AreaPoint, ContactError> {
    let (area, area_error, convergence) = match contact.known_area(pressure_pa) {
        Some(area) => (area, 0.0, Convergence::default()),
        None => {
            let pools = || pools.lock().unwrap_or_else(PoisonError::into_inner);
            let mut pool = pools().pop().unwrap_or_default();
            let outcome = contact.minimize(pressure_pa, options, monitor, &mut pool)?;
            let (area, area_error) = contact.area(&outcome);
            let convergence = outcome.convergence;
            pool.recycle(outcome);
            pools().push(pool);
            (area, area_error, convergence)
        }
    };
    Ok(AreaPoint {
        pressure_pa,
        area_fraction: area.fraction,
        area_fraction_corrected: area.fraction_corrected,
        area_error,
        convergence,
    })
}

/// Refuses areas that fall with rising pressure by more than their errors.
fn require_rising_areas(points: &[AreaPoint], tolerance: f64) -> Result<(), ContactError> {
    let mut rising: Vec<&AreaPoint> = points.iter().collect();
    rising.sort_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
    for pair in rising.windows(2) {
        let [lighter, heavier] = [pair[0], pair[1]];
        // The error estimate comes from two states, which may be identical; then only the tolerance bounds the error.
        let allowed = lighter.area_error + heavier.area_error + 2.0 * tolerance;
        if heavier.area_fraction < lighter.area_fraction - allowed {
            return Err(ContactError::FallingArea {
                pressures_pa: [lighter.pressure_pa, heavier.pressure_pa],
                area_fractions: [lighter.area_fraction, heavier.area_fraction],
            });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn areas_that_fall_with_pressure_are_refused() {
        let curve = |areas: [f64; 3]| {
            let point = |(area_fraction, pressure_pa)| AreaPoint {
                pressure_pa,
                area_fraction,
                area_fraction_corrected: area_fraction,
                area_error: 1e-4,
                convergence: Convergence::default(),
            };
            // The points need not be sorted by pressure.
            require_rising_areas(&areas.into_iter().zip([3e6, 1e6, 2e6]).map(point).collect::<Vec<_>>(), 1e-8)
        };
        assert_eq!(curve([0.3, 0.1, 0.2]), Ok(()));
        // A fall within both errors is accepted.
        assert_eq!(curve([0.2, 0.1, 0.20015]), Ok(()));
        let refused = curve([0.19, 0.1, 0.2]).unwrap_err().to_string();
        assert!(refused.contains("from 0.2 at 2 MPa to 0.19 at 3 MPa"), "{refused}");
    }
}
