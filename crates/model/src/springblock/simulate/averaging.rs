//! Mean of outcomes that differ only in their draws of local coefficients.

use crate::springblock::{Correction, DynamicCost, InterfacePoint, LoadOutcome, Status, SurfaceOutcome, TracePoint};

/// Mean of the outcomes `draws` under one load, each with its own draw of local coefficients; `None` for no outcome.
pub fn mean(mut draws: Vec<LoadOutcome>) -> Option<LoadOutcome> {
    if draws.len() < 2 {
        return draws.pop();
    }
    let first = draws.first()?;
    let surfaces: Vec<&SurfaceOutcome> = draws.iter().map(|draw| &draw.surface).collect();
    let flats: Option<Vec<&SurfaceOutcome>> = draws.iter().map(|draw| draw.flat.as_ref()).collect();
    // The surfaces of a draw share their coefficients, so the ratio scatters less than either mu.
    let ratio = all(draws.iter().map(LoadOutcome::ratio));
    let ratio_stderr = all(draws.iter().map(|draw| draw.ratio_stderr));
    Some(LoadOutcome {
        pressure_pa: first.pressure_pa,
        surface: surface(&surfaces),
        flat: flats.map(|flats| surface(&flats)),
        ratio_stderr: standard_error(ratio.as_deref(), ratio_stderr.as_deref()),
        solved: all(draws.iter().map(|draw| draw.solved)).as_deref().map(average),
        corrections: first.corrections.iter().map(|&correction| mean_correction(correction, &draws)).collect(),
    })
}

/// Returns `correction` with the mean change by its effect over the `draws` that have such a correction.
fn mean_correction(correction: Correction, draws: &[LoadOutcome]) -> Correction {
    let changes = draws.iter().filter_map(|draw| draw.correction(correction.effect)).map(|same| same.change);
    Correction { change: average(&changes.collect::<Vec<f64>>()), ..correction }
}

/// Returns all values, or `None` if one is missing.
fn all(values: impl Iterator<Item = Option<f64>>) -> Option<Vec<f64>> {
    values.collect()
}

fn average(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Standard error of the mean of `values`, whose standard errors are `errors`; `None` if either is missing. The scatter
/// of the values includes these errors; as the scatter of a few values is uncertain, the result is at least that from
/// `errors` alone.
fn standard_error(values: Option<&[f64]>, errors: Option<&[f64]>) -> Option<f64> {
    let (values, errors) = (values?, errors?);
    let (n, mean) = (values.len() as f64, average(values));
    // sqrt(sum (m_i - m)^2 / (n (n - 1))), sqrt(sum s_i^2) / n
    let scatter = (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n * (n - 1.0))).sqrt();
    let within = errors.iter().map(|error| error * error).sum::<f64>().sqrt() / n;
    Some(scatter.max(within))
}

fn surface(draws: &[&SurfaceOutcome]) -> SurfaceOutcome {
    let each = |value: fn(&SurfaceOutcome) -> Option<f64>| all(draws.iter().map(|draw| value(draw)));
    let mean_of = |value: fn(&SurfaceOutcome) -> Option<f64>| each(value).as_deref().map(average);
    let largest = |value: fn(&SurfaceOutcome) -> f64| draws.iter().map(|draw| value(draw)).fold(0.0, f64::max);
    let mu = each(|draw| draw.mu_dynamic);
    let stderr = each(|draw| draw.mu_dynamic_stderr);
    let worst = draws.iter().map(|draw| draw.status).max();
    SurfaceOutcome {
        status: worst.unwrap_or(Status::Converged),
        mu_dynamic: mu.as_deref().map(average),
        mu_dynamic_stderr: standard_error(mu.as_deref(), stderr.as_deref()),
        stick_slip_excess: mean_of(|draw| draw.stick_slip_excess),
        mu_across: mean_of(|draw| draw.mu_across),
        averaged_from_s: each(|draw| draw.averaged_from_s).map(|from| from.into_iter().fold(0.0, f64::max)),
        mu_static: mean_of(|draw| draw.mu_static),
        peak_pressure_pa: largest(|draw| draw.peak_pressure_pa),
        tension_blocks: draws.iter().map(|draw| draw.tension_blocks).max().unwrap_or(0),
        cavity_closed: draws.iter().any(|draw| draw.cavity_closed),
        area_law_extrapolated: draws.iter().any(|draw| draw.area_law_extrapolated),
        cost: cost(draws),
        interface: interface(draws),
        trace: trace(draws),
        ..SurfaceOutcome::default()
    }
}

fn cost(draws: &[&SurfaceOutcome]) -> Option<DynamicCost> {
    draws.iter().filter_map(|draw| draw.cost).reduce(|sum, cost| DynamicCost {
        steps: sum.steps + cost.steps,
        dt_s: cost.dt_s,
        site_updates: sum.site_updates + cost.site_updates,
        wall_s: sum.wall_s + cost.wall_s,
    })
}

/// Mean pressure and friction on every contact block; all draws have the same contact blocks.
fn interface(draws: &[&SurfaceOutcome]) -> Vec<InterfacePoint> {
    let mean_at = |number: usize, value: fn(&InterfacePoint) -> f64| {
        draws.iter().filter_map(|draw| draw.interface.get(number)).map(value).sum::<f64>() / draws.len() as f64
    };
    let points = draws.first().map_or(&[][..], |draw| &draw.interface);
    points
        .iter()
        .enumerate()
        .map(|(number, point)| InterfacePoint {
            pressure_pa: mean_at(number, |point| point.pressure_pa),
            friction_pa: mean_at(number, |point| point.friction_pa),
            ..*point
        })
        .collect()
}

/// Mean of mu as a function of time, over the duration that all draws cover.
fn trace(draws: &[&SurfaceOutcome]) -> Vec<TracePoint> {
    let shortest = draws.iter().map(|draw| draw.trace.len()).min().unwrap_or(0);
    let mu_at = |number: usize| draws.iter().map(|draw| draw.trace[number].mu).sum::<f64>() / draws.len() as f64;
    let times = draws.first().map_or(&[][..], |draw| &draw.trace[..shortest]);
    times.iter().enumerate().map(|(number, point)| TracePoint { mu: mu_at(number), ..*point }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn draw(mu: f64, stderr: f64, ratio: f64) -> LoadOutcome {
        let cost = DynamicCost { steps: 10, dt_s: 1e-9, site_updates: 100, wall_s: 0.5 };
        let surface = SurfaceOutcome {
            mu_dynamic: Some(mu),
            mu_dynamic_stderr: Some(stderr),
            cost: Some(cost),
            interface: vec![InterfacePoint { x_m: 1.0, y_m: 2.0, pressure_pa: 10.0 * mu, friction_pa: mu }],
            ..SurfaceOutcome::unsolved(Status::Converged, std::iter::empty())
        };
        LoadOutcome {
            pressure_pa: 1e6,
            flat: Some(SurfaceOutcome { mu_dynamic: Some(mu / ratio), ..surface.clone() }),
            surface,
            ratio_stderr: Some(1e-4),
            solved: Some(ratio),
            corrections: Vec::new(),
        }
    }

    #[test]
    fn one_draw_is_itself_and_several_are_their_mean() {
        assert_eq!(mean(vec![draw(0.25, 1e-3, 0.9)]), Some(draw(0.25, 1e-3, 0.9)));
        let mean = mean(vec![draw(0.24, 1e-3, 0.90), draw(0.26, 1e-3, 0.92), draw(0.25, 1e-3, 0.91)]).unwrap();
        assert!((mean.surface.mu_dynamic.unwrap() - 0.25).abs() < 1e-15);
        // Scatter 0.01, of three.
        assert!((mean.surface.mu_dynamic_stderr.unwrap() - 0.01 / 3.0_f64.sqrt()).abs() < 1e-15);
        assert!((mean.ratio().unwrap() - 0.91).abs() < 1e-15);
        assert!((mean.ratio_stderr.unwrap() - 0.01 / 3.0_f64.sqrt()).abs() < 1e-15);
        assert_eq!(mean.surface.cost.unwrap().site_updates, 300);
        assert!((mean.surface.interface[0].pressure_pa - 2.5).abs() < 1e-15);
    }

    #[test]
    fn draws_that_agree_by_chance_keep_their_own_errors() {
        let mean = mean(vec![draw(0.25, 3e-3, 0.9), draw(0.25, 4e-3, 0.9)]).unwrap();
        assert!((mean.surface.mu_dynamic_stderr.unwrap() - 2.5e-3).abs() < 1e-15);
    }

    #[test]
    fn the_worst_status_stands_and_what_one_lacks_all_lack() {
        let mut lacking = draw(0.25, 1e-3, 0.9);
        lacking.surface.status = Status::NoOnset;
        lacking.remove_ratio();
        let mean = mean(vec![draw(0.25, 1e-3, 0.9), lacking]).unwrap();
        assert_eq!((mean.surface.status, mean.surface.mu_dynamic, mean.ratio()), (Status::NoOnset, None, None));
        assert_eq!(mean.flat.unwrap().status, Status::Converged);
    }
}
