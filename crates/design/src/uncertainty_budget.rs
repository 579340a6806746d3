//! The error beside every number of a design.

use slipgrid_calibrate::uncertainty::{DiscrepancyAt, InputUncertainty, Slopes};
use slipgrid_material::Condition;
use slipgrid_optimize::Quantity;
use slipgrid_springblock::{Scene, Simulation};

use crate::DesignError;
use crate::chance::RIM_HEIGHT;
use crate::scene_errors::Solved;
use crate::task::DesignTask;
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_results::errors::OFF_THE_RUN;
use slipgrid_results::{ErrorReport, ErrorsReport, PressureErrors};

/// Errors of a design's values.
pub struct DesignErrors {
    /// Of values as they are compared with the target.
    pub report: ErrorsReport,
    /// By the physics alone, one per pressure, where designs aim with the discrepancy.
    pub physics: Option<Vec<PressureErrors>>,
}

/// Errors of the values of `confirmed`, which came of `scene`: `predicted` is the target's quantity as the search took it.
/// The design's dimensions are taken as exact; `rim_std` is what the height of its rims leaves open of the ratio at each load, and
/// `lacking` what designs aim with beside the physics.
///
/// # Errors
/// [`DesignError::Material`] for an area law that cannot be moved.
pub fn of_design(
    design: &DesignTask,
    material: &MaterialUncertainty,
    (scene, confirmed): (&Scene, &Simulation),
    predicted: &[f64],
    rim_std: Option<&[f64]>,
    lacking: Option<&[DiscrepancyAt]>,
) -> Result<DesignErrors, DesignError> {
    let known = material.at_loads(scene.area_law.as_ref(), &scene.loads, design.condition.as_ref())?;
    let slopes = Slopes::new(scene, &known);
    let is_ratio = design.target.quantity() == Quantity::Ratio;
    let factor = |place: usize| lacking.map_or(1.0, |all| all[place].factor);
    let rows = |knowledge: &InputUncertainty| {
        let solved = Solved { scene, simulation: confirmed, knowledge, slopes: &slopes };
        let mut rows = solved.errors();
        for (place, (row, value)) in rows.iter_mut().zip(predicted).enumerate() {
            let factor = if knowledge.discrepancy.is_some() { 1.0 } else { factor(place) };
            let value = value / factor;
            let run = if is_ratio { row.ratio.clone() } else { Some(row.mu.clone()) };
            row.predicted = Some(match run.as_ref().and_then(|run| run.value).zip(run) {
                Some((confirmed, run)) => run.about(value).and(OFF_THE_RUN, (confirmed - value).abs()),
                None => {
                    let of = solved.deviations(place).map(|of| if is_ratio { of.ratio } else { of.mu });
                    ErrorReport::new(Some(value), Vec::new(), of.as_ref())
                }
            });
            if let Some(std) = rim_std.and_then(|all| all.get(place)) {
                let times = knowledge.discrepancy.as_ref().map_or(1.0, |all| all[place].factor);
                let flat_mu = confirmed.loads[place].flat.as_ref().and_then(|flat| flat.mu_dynamic);
                with_rim(row, times * std, flat_mu, is_ratio);
            }
        }
        rows
    };
    let physics = rows(&known);
    let aimed = lacking.map(|all| rows(&InputUncertainty { discrepancy: Some(all.to_vec()), ..known.clone() }));
    let solved = Solved { scene, simulation: confirmed, knowledge: &known, slopes: &slopes };
    let (compared, physics) = match aimed {
        Some(aimed) => (aimed, Some(physics)),
        None => (physics, None),
    };
    let unknown = solved.unknown(material, &compared);
    Ok(DesignErrors { report: ErrorsReport::new(compared, unknown, design.discrepancy), physics })
}

/// Adds the part of the rims' height, of which the ratio has `std`, to everything that is patterned in `row`.
fn with_rim(row: &mut PressureErrors, std: f64, flat_mu: Option<f64>, is_ratio: bool) {
    let mu = flat_mu.map(|flat_mu| flat_mu * std);
    row.ratio = row.ratio.take().map(|ratio| ratio.and(RIM_HEIGHT, std));
    if let Some(mu) = mu {
        row.mu = std::mem::take(&mut row.mu).and(RIM_HEIGHT, mu);
    }
    if let Some(of) = if is_ratio { Some(std) } else { mu } {
        row.predicted = row.predicted.take().map(|predicted| predicted.and(RIM_HEIGHT, of));
    }
}

/// Standard deviations at one pressure of a further condition; absent where nothing is known.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FurtherErrors {
    /// Of the ratio.
    pub ratio: Option<f64>,
    /// Of dynamic friction.
    pub mu: Option<f64>,
    /// Of the flat sample's.
    pub mu_flat: Option<f64>,
}

/// Errors at the loads of `scene` under `condition`, where designs aim with `lacking` beside the physics: of `run` where it was run in time; else of the steady model's
/// `ratios` and the flat sample's `mu_flat`, about the run that `first` has the errors of.
///
/// # Errors
/// [`DesignError::Material`] for an area law that cannot be moved.
pub fn of_condition(
    material: &MaterialUncertainty,
    lacking: Option<Vec<DiscrepancyAt>>,
    (scene, condition): (&Scene, Option<&Condition>),
    run: Option<&Simulation>,
    (ratios, mu_flat): (&[f64], &[f64]),
    first: &ErrorsReport,
) -> Result<Vec<FurtherErrors>, DesignError> {
    let known = material.at_loads(scene.area_law.as_ref(), &scene.loads, condition)?;
    let knowledge = InputUncertainty { discrepancy: lacking, ..known };
    let slopes = Slopes::new(scene, &knowledge);
    if let Some(simulation) = run {
        let rows = Solved { scene, simulation, knowledge: &knowledge, slopes: &slopes }.errors();
        let std = |of: Option<ErrorReport>| of.and_then(|of| of.std);
        let errors = |(place, mut row): (usize, PressureErrors)| {
            // The ratio, which hardly depends on the condition, follows the rims as at the first one.
            let about = first.at(place).and_then(|about| about.ratio.as_ref());
            if let Some(std) = about.and_then(|about| about.std_of(RIM_HEIGHT)) {
                let flat_mu = row.mu_flat.as_ref().and_then(|flat| flat.value);
                with_rim(&mut row, std, flat_mu, true);
            }
            FurtherErrors { ratio: std(row.ratio), mu: row.mu.std, mu_flat: std(row.mu_flat) }
        };
        return Ok(rows.into_iter().enumerate().map(errors).collect());
    }
    let at = |place: usize| -> Option<FurtherErrors> {
        let about = first.at(place)?;
        let of = slopes.deviations(place, ratios[place], mu_flat[place], &knowledge)?;
        let factor = knowledge.discrepancy.as_ref().map_or(1.0, |all| all[place].factor);
        // What the run at the first condition left open, in proportion.
        let with = |run: Option<&ErrorReport>, value: f64, own: f64| {
            let open = |run: &ErrorReport| run.std_of_run().hypot(run.std_of(RIM_HEIGHT).unwrap_or(0.0));
            let share = run.and_then(|run| Some(open(run) / run.value?));
            Some(own.hypot(share.unwrap_or(0.0) * value)).filter(|std| *std > 0.0)
        };
        let ratio = ratios[place] * factor;
        Some(FurtherErrors {
            ratio: with(about.ratio.as_ref(), ratio, of.ratio.std),
            mu: with(Some(&about.mu), ratio * mu_flat[place], of.mu.std),
            mu_flat: with(about.mu_flat.as_ref(), mu_flat[place], of.flat.std),
        })
    };
    Ok((0..scene.loads.len()).map(|place| at(place).unwrap_or_default()).collect())
}
