use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use slipgrid_topography::HeightMap;

use crate::rough_contact::check;
use crate::solver::Spare;
use crate::{ContactError, Convergence, Monitor, RoughContact, SolveOptions};

/// Real contact area at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaPoint {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Pixels in contact over all pixels.
    pub area_fraction: f64,
    /// The same, corrected for the boundary of the contact.
    pub area_fraction_corrected: f64,
    /// Estimate of the error that ending at the tolerance leaves in both.
    pub area_error: f64,
    /// How the solve ended.
    pub convergence: Convergence,
}

/// Real contact area against nominal pressure.
#[derive(Clone, Debug, PartialEq)]
pub struct AreaCurve {
    /// One point per pressure, in the order asked for.
    pub points: Vec<AreaPoint>,
    /// The pressure from which all of the map is in contact, in pascals.
    pub full_contact_pressure_pa: f64,
}

/// Contact area of `map` on a half-space of contact modulus E* = E/(1 - nu^2) at each of `pressures_pa`,
/// in parallel; the numbers do not depend on the number of threads. Each pressure is solved on its own, so
/// that one that does not converge leaves the others as they are. The monitor hears of each solved
/// pressure; when it cancels, the rest is reported as cancelled.
///
/// # Errors
/// [`ContactError`] if the map is incomplete, or the modulus, a pressure or the tolerance means nothing.
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
    let contact = RoughContact::watched(map, contact_modulus_pa, monitor)?;
    let share = 1.0 / pressures_pa.len() as f64;
    let spares: Mutex<Vec<Spare>> = Mutex::default();
    let points = pressures_pa
        .par_iter()
        .with_max_len(1)
        .map(|&pressure_pa| {
            let point = area_point(&contact, pressure_pa, options, monitor, &spares);
            monitor.advance(share);
            point
        })
        .collect();
    Ok(AreaCurve { points, full_contact_pressure_pa: contact.full_contact_pressure_pa() })
}

/// One point of the curve, solved in fields that an earlier one has left.
fn area_point(
    contact: &RoughContact,
    pressure_pa: f64,
    options: &SolveOptions,
    monitor: &dyn Monitor,
    spares: &Mutex<Vec<Spare>>,
) -> AreaPoint {
    let (area, area_error, convergence) = match contact.known_area(pressure_pa) {
        Some(area) => (area, 0.0, Convergence::KNOWN),
        None => {
            let spares = || spares.lock().unwrap_or_else(PoisonError::into_inner);
            let mut spare = spares().pop().unwrap_or_default();
            let outcome = contact.minimize(pressure_pa, options, monitor, &mut spare);
            let (area, area_error) = contact.area(&outcome);
            let convergence = outcome.convergence;
            spare.take_back(outcome);
            spares().push(spare);
            (area, area_error, convergence)
        }
    };
    AreaPoint {
        pressure_pa,
        area_fraction: area.fraction,
        area_fraction_corrected: area.fraction_corrected,
        area_error,
        convergence,
    }
}
