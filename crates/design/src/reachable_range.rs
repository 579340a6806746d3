//! What designs within bounds and limits reach.

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::uncertainty::{InputUncertainty, Slopes};
use slipgrid_optimize::{Quantity, ReachableRange, Status};
use slipgrid_pattern::Pattern;

use crate::DesignError;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_units::{PRESSURE_MPA, tidy};

/// Half a unit of the last digit that is shown.
const LEAST_STD: f64 = 5e-5;

/// What designs within bounds and limits can do at one pressure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReachableReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// Lowest value.
    pub lowest: f64,
    /// Its standard deviation by what is known of the material; null where nothing that moves it is, and where the target is met.
    pub lowest_std: Option<f64>,
    /// Highest value.
    pub highest: f64,
    /// Its standard deviation.
    pub highest_std: Option<f64>,
}

/// What designs within bounds and limits reach at each pressure of the condition designed for; where the target is not met, of the
/// design that was confirmed what its run gave, and with errors, as far as there is time: then they decide. Nothing where a target is met
/// in space: there only designs near it are solved.
///
/// # Errors
/// [`DesignError::Material`] for an area law that cannot be moved.
pub(super) fn of_search(
    design: &DesignTask,
    material: &MaterialUncertainty,
    found: &MultiFidelityLoop<'_>,
    bar: &Stage<'_>,
) -> Result<Vec<ReachableReport>, DesignError> {
    let is_open = found.status != Status::Met;
    if !found.model.is_cheap_per_design() && !is_open {
        return Ok(Vec::new());
    }
    let known = material.at_loads(found.scene.area_law.as_ref(), &found.scene.loads, design.condition.as_ref())?;
    let std = |place: usize, pattern: &Pattern, value: f64| {
        if bar.cancelled() {
            return None;
        }
        let slopes = Slopes::new(&found.model.scene(pattern), &known);
        let lacking = found.model.learned().map(|learned| learned.each(pattern)).transpose().ok()?;
        // A value is a ratio times what the target's quantity and the discrepancy take it by.
        let factor = lacking.as_ref().map_or(1.0, |all| all[place].factor);
        let scale = found.model.scale(place);
        let knowledge = InputUncertainty { discrepancy: lacking, ..known.clone() };
        let of = slopes.deviations(place, value / (scale * factor), scale, &knowledge)?;
        Some(match design.target.quantity() {
            Quantity::Ratio => of.ratio,
            Quantity::DynamicFriction => of.mu,
        })
        // An error that does not show says that what decides is not among its parts.
        .filter(|of| of.std >= LEAST_STD)
        .map(|of| tidy(of.std))
    };
    // The search ended before its confirming run, which says of its design what that design reaches. How far the model is off elsewhere it
    // does not say: near the flat surface it can hardly be off.
    let best = found.round.best.as_ref().map(|best| best.design);
    let confirmed = found.confirmed_values().filter(|_| is_open);
    let told = |place: usize, pattern: &Pattern, value: f64| {
        confirmed.as_ref().filter(|_| best.as_ref() == Some(pattern)).map_or(value, |values| values[place])
    };
    let report = |(place, range): (usize, &ReachableRange)| {
        let end = |pattern: &Pattern, value: f64| {
            let value = told(place, pattern, value);
            (value, is_open.then(|| std(place, pattern, value)).flatten())
        };
        let (lowest, lowest_std) = end(&range.lowest_design, range.lowest);
        let (highest, highest_std) = end(&range.highest_design, range.highest);
        let pressure_mpa = PRESSURE_MPA.from_si(range.pressure_pa);
        ReachableReport { pressure_mpa, lowest, lowest_std, highest, highest_std }
    };
    Ok(found.round.reachable.iter().enumerate().map(report).collect())
}
