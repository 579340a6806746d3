//! Discrepancy at the texture measured last, and its dependence on the condition.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::results::fixed;
use slipgrid_infer::discrepancy::{Discrepancy, Load, Sensitivity};

/// Ratio of posterior to prior standard deviation above which an effect counts as less known than before any trial.
const LESS_KNOWN: f64 = 1.05;

/// Discrepancy ln(measured / modelled ratio), or change of the discrepancy with pressure, speed or humidity.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct DiscrepancyEffect {
    /// Name of the effect.
    pub of: String,
    /// Mean of the effect.
    pub value: f64,
    /// Standard deviation of `value`.
    pub std: f64,
    /// Prior standard deviation.
    pub prior_std: f64,
}

/// Effects at the texture measured last, or without trials at the reference texture: the discrepancy, and changes of
/// the discrepancy with speed, pressure and humidity.
pub(super) fn effects(learned: &Discrepancy) -> Vec<DiscrepancyEffect> {
    let features = learned.trials().last().map_or(learned.hyperparameters().reference, |trial| trial.features);
    let mut humidities: Vec<f64> =
        learned.trials().iter().flat_map(|trial| trial.measured.iter().map(|at| at.load.humidity)).collect();
    humidities.sort_by(f64::total_cmp);
    humidities.dedup();
    let (at, first) = central(learned);
    let before = learned.with_trials(Vec::new()).ok();
    // Discrepancy at `to`, or difference between `to` and `from`; errors of modulus and sample are equal at both loads.
    let effect = |of: String, to: Load, from: Option<Load>| {
        let loads: Vec<Load> = std::iter::once(to).chain(from).collect();
        let moments = |known: &Discrepancy| {
            let (mean, covariance) =
                known.at(&loads).predict(&features, &vec![Sensitivity::default(); loads.len()]).mixed();
            match from {
                None => (mean[0], covariance[0].sqrt()),
                Some(_) => {
                    let variance = covariance[0] - covariance[1] - covariance[2] + covariance[3];
                    (mean[0] - mean[1], variance.max(0.0).sqrt())
                }
            }
        };
        let (value, std) = moments(learned);
        let prior_std = before.as_ref().map_or(std, |before| moments(before).1);
        DiscrepancyEffect { of, value: tidy(value), std: tidy(std), prior_std: tidy(prior_std) }
    };
    let mut found = vec![effect(first, at, None)];
    let faster = Load { speed_m_s: at.speed_m_s * std::f64::consts::E, ..at };
    found.push(effect("a speed 2.72 times as high".to_owned(), faster, Some(at)));
    let heavier = Load { pressure_pa: 2.0 * at.pressure_pa, ..at };
    found.push(effect("twice the pressure".to_owned(), heavier, Some(at)));
    for humidity in humidities.iter().filter(|humidity| **humidity != at.humidity) {
        let of = format!("a humidity of {} % in place of {} %", humidity_pct(*humidity), humidity_pct(at.humidity));
        found.push(effect(of, Load { humidity: *humidity, ..at }, Some(at)));
    }
    found
}

/// States in one line each which effects are less known after the trials than before.
pub(super) fn less_known(effects: &[DiscrepancyEffect]) -> String {
    let less = effects.iter().filter(|effect| effect.std > LESS_KNOWN * effect.prior_std);
    less.map(|effect| {
        format!(
            "less is known of {} than before any trial: forms that are larger at this texture have gained weight\n",
            effect.of
        )
    })
    .collect()
}

/// Returns that condition of the last trial, at its lowest humidity, which is nearest to the centre of the flat sample's
/// conditions in ln P and ln v (pressure P, speed v); without a trial, returns this centre at 40 % humidity.
/// Also returns a name for the discrepancy at the returned condition.
fn central(learned: &Discrepancy) -> (Load, String) {
    let middle = learned.conditions();
    // Squared distance from the centre P0, v0: d^2 = ln(P / P0)^2 + ln(v / v0)^2
    let away = |load: &Load| {
        (load.pressure_pa / middle.reference_pressure_pa).ln().powi(2)
            + (load.speed_m_s / middle.reference_speed_m_s).ln().powi(2)
    };
    let loads = learned.trials().last().into_iter().flat_map(|trial| trial.measured.iter().map(|at| at.load));
    let nearest = loads.min_by(|a, b| a.humidity.total_cmp(&b.humidity).then(away(a).total_cmp(&away(b))));
    match nearest {
        Some(load) => {
            let pressure = fixed(Some(PRESSURE_MPA.from_si(load.pressure_pa)), 2);
            let [speed, humidity] = [tidy(SPEED_MM_S.from_si(load.speed_m_s)), humidity_pct(load.humidity)];
            let name =
                format!("discrepancy at the texture of the last trial, {pressure} MPa, {speed} mm/s, {humidity} %");
            (load, name)
        }
        None => {
            let (pressure_pa, speed_m_s) = (middle.reference_pressure_pa, middle.reference_speed_m_s);
            let name = "discrepancy at the reference texture, in the middle of the flat sample's conditions".to_owned();
            (Load { pressure_pa, speed_m_s, humidity: 0.4 }, name)
        }
    }
}

fn humidity_pct(humidity: f64) -> f64 {
    tidy(HUMIDITY_PCT.from_si(humidity))
}
