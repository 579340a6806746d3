//! Profile likelihood: chi-square as a function of one parameter, minimized over all others.

use super::{Model, Parameter};
use crate::calibrate::least_squares::Solution;
use crate::calibrate::{Coefficients, FitError};

/// Increase of chi-square at the ends of a 95 % interval of one parameter.
const LEVEL: f64 = 3.841_458_8;
/// Number of points of a profile on each side of the fitted value.
const POINTS: usize = 12;
/// Extent of a profile on each side of the fitted value, in standard errors.
const REACH: f64 = 3.5;

/// Computes all parameters with their profiles.
pub fn parameters(model: &Model<'_>, solution: &Solution) -> Result<Vec<Parameter>, FitError> {
    (0..solution.parameters.len()).map(|number| parameter(model, solution, number)).collect()
}

fn parameter(model: &Model<'_>, solution: &Solution, number: usize) -> Result<Parameter, FitError> {
    let layout = model.layout;
    let bounds = layout.bounds(model.problem)[number];
    let value = solution.parameters[number];
    let error = solution.standard_error(number);
    // Each point starts from the solution at the previous one, because the other parameters change smoothly.
    let side = |end: f64| -> Result<Vec<[f64; 2]>, FitError> {
        let reach = (REACH * error).min((end - value).abs());
        let mut start = solution.parameters.clone();
        let mut points = Vec::new();
        for i in 1..=POINTS {
            start[number] = value + (end - value).signum() * reach * i as f64 / POINTS as f64;
            let held = model.least_squares().hold(number).solve(&start)?;
            points.push([start[number], (held.chi_square() - solution.chi_square()).max(0.0)]);
            start = held.parameters;
        }
        Ok(points)
    };
    let below = if value > bounds[0] { side(bounds[0])? } else { Vec::new() };
    let above = if value < bounds[1] { side(bounds[1])? } else { Vec::new() };
    let interval = [crossing(value, &below), crossing(value, &above)];
    let mut profile: Vec<[f64; 2]> = below.into_iter().rev().collect();
    profile.push([value, 0.0]);
    profile.extend(above);
    let is_scale = layout.log_scale == Some(number);
    // The scale is fitted as a logarithm, but reported as a pressure.
    let reported = |x: f64| if is_scale { x.exp() } else { x };
    Ok(Parameter {
        name: name(model, number),
        value: reported(value),
        std_error: if is_scale { reported(value) * error } else { error },
        bounds: bounds.map(reported),
        at_bound: solution.at_bound[number],
        profile: profile.into_iter().map(|[x, rise]| [reported(x), rise]).collect(),
        interval: interval.map(|end| end.map(reported)),
    })
}

/// Value of the parameter at which the profile on one side of the fitted `value` first reaches [`LEVEL`]; `None` if it
/// does not. Between points the square root of the increase is interpolated linearly, which is exact for a parabola.
fn crossing(value: f64, points: &[[f64; 2]]) -> Option<f64> {
    let mut last = [value, 0.0];
    for &[x, rise] in points {
        let root = rise.sqrt();
        if rise >= LEVEL {
            return Some(last[0] + (LEVEL.sqrt() - last[1]) / (root - last[1]) * (x - last[0]));
        }
        last = [x, root];
    }
    None
}

fn name(model: &Model<'_>, number: usize) -> String {
    let layout = model.layout;
    let single = model.problem.coefficients == Coefficients::Single;
    let numbered = |what: &str, i: usize| if single { what.to_owned() } else { format!("{what} {}", i + 1) };
    if layout.log_scale == Some(number) {
        return "area_law_scale_pa".to_owned();
    }
    if let Some(i) = layout.dynamic.iter().position(|&dynamic| dynamic == number) {
        return numbered("dynamic_mean", i);
    }
    let of_static = layout.fixed_static.iter().position(|&fixed| fixed == Some(number));
    numbered("static_mean", of_static.unwrap_or(0))
}
