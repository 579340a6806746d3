//! How a response moves with the dimensions of its design.

use crate::model::as_many;
use crate::{ForwardModel, ModelFailure, Response};
use rayon::prelude::*;
use slipgrid_pattern::Pattern;

/// Width, spacing, depth.
pub(crate) const AXES: usize = 3;
/// Largest step over the dimension itself, so that twice the step leaves a cavity and a land.
const LARGEST_SHARE: f64 = 0.25;
/// Halvings of the step after which an axis beside designs that cannot be computed has no slope.
const MOST_HALVINGS: usize = 3;

/// A slope with the error of its finite step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// d(value)/d(length), per metre.
    pub per_m: f64,
    /// Distance to the slope at twice the step, per metre: for smooth values three times the error that the step
    /// leaves, for values with kinks its size.
    pub error_per_m: f64,
}

/// Slopes of every value along one dimension.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisSensitivity {
    /// Step of the central differences, in metres.
    pub step_m: f64,
    /// One per value of the response, in its order.
    pub slopes: Vec<Slope>,
}

/// Slopes at one design.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivities {
    /// The response there.
    pub response: Response,
    /// Along width, spacing and depth; `None` where the model fails however small the step.
    pub axes: [Option<AxisSensitivity>; AXES],
}

/// Slopes of the response of `model` at `design` by central differences at `step_m` and twice that (less where
/// the dimension is short), along width, spacing and depth with all else held.
///
/// # Errors
/// [`ModelFailure`] where `design` itself has no response, or the model is broken (it gives another number of values
/// beside the design, too) or cancelled.
pub fn sensitivities(model: &dyn ForwardModel, design: &Pattern, step_m: f64) -> Result<Sensitivities, ModelFailure> {
    let response = model.respond(design)?;
    let axes = (0..AXES)
        .into_par_iter()
        .map(|axis| along(model, design, response.value.len(), axis, step_m))
        .collect::<Result<Vec<_>, ModelFailure>>()?;
    let mut axes = axes.into_iter();
    Ok(Sensitivities { response, axes: std::array::from_fn(|_| axes.next().flatten()) })
}

fn along(
    model: &dyn ForwardModel,
    design: &Pattern,
    values: usize,
    axis: usize,
    step_m: f64,
) -> Result<Option<AxisSensitivity>, ModelFailure> {
    let mut step_m = step_m.min(LARGEST_SHARE * design.lengths_m()[axis]);
    for _ in 0..=MOST_HALVINGS {
        let neighbours: Vec<Result<Response, ModelFailure>> = [-2.0, -1.0, 1.0, 2.0]
            .into_par_iter()
            .map(|steps| {
                let mut moved_m = design.lengths_m();
                moved_m[axis] += steps * step_m;
                model.respond(&with_lengths(design, moved_m)?)
            })
            .collect();
        let mut found = Vec::new();
        for neighbour in neighbours {
            match neighbour {
                Ok(response) => found.push(as_many(response.value, values)?),
                Err(ModelFailure::Trial { .. }) => {}
                Err(failure) => return Err(failure),
            }
        }
        if let [far_below, below, above, far_above] = &found[..] {
            let slopes = (0..values)
                .map(|value| {
                    // D(h) = [v(x + h) - v(x - h)] / 2h
                    let per_m = (above[value] - below[value]) / (2.0 * step_m);
                    let wide_per_m = (far_above[value] - far_below[value]) / (4.0 * step_m);
                    Slope { per_m, error_per_m: (per_m - wide_per_m).abs() }
                })
                .collect();
            return Ok(Some(AxisSensitivity { step_m, slopes }));
        }
        step_m *= 0.5;
    }
    Ok(None)
}

/// The design with other lengths.
pub(crate) fn with_lengths(design: &Pattern, lengths_m: [f64; AXES]) -> Result<Pattern, ModelFailure> {
    let [width_m, spacing_m, depth_m] = lengths_m;
    Pattern::new(*design.texture(), width_m, spacing_m, depth_m)
        .map_err(|error| ModelFailure::Trial { reason: error.to_string() })
}

/// Mean height of the rims of cavities as deep as those of `design`, in metres, where it has rims.
#[must_use]
pub(crate) fn rim_height_m(design: &Pattern, depth_m: f64) -> f64 {
    design.texture().rim().map_or(0.0, |rim| rim.height_m(depth_m))
}

/// The design with the mean height of its rims off by `by_m`: |h + by|, as far above the land as it would be below.
#[must_use]
pub fn with_rim_off(design: &Pattern, by_m: f64) -> Pattern {
    let raised = design.texture().rim().map(|rim| rim.raised(folded(design.rim_height_m(), by_m)));
    design.to_owned().with_rim(raised)
}

/// What a height moves by where it would by `by_m` and is not below the land: |h + by| - h.
pub(crate) fn folded(height_m: f64, by_m: f64) -> f64 {
    (height_m + by_m).abs() - height_m
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_pattern::Planform;

    fn design() -> Pattern {
        Pattern::new(Planform::Groove, 130e-6, 370e-6, 5.2e-6).unwrap()
    }

    fn response(value: Vec<f64>) -> Result<Response, ModelFailure> {
        Ok(Response { value, limited: Vec::new() })
    }

    #[test]
    fn slopes_of_a_polynomial_are_exact_to_second_order_and_the_error_bounds_the_third() {
        let um = |length_m: f64| length_m * 1e6;
        // Linear in spacing, quadratic in depth, cubic in width.
        let model = |at: &Pattern| {
            let [w, s, d] = at.lengths_m().map(um);
            response(vec![2.0 * s + d * d, 1e-3 * w * w * w])
        };
        let found = sensitivities(&model, &design(), 5e-6).unwrap();
        let slope = |axis: usize, value: usize| found.axes[axis].as_ref().unwrap().slopes[value];
        assert!((slope(1, 0).per_m * 1e-6 - 2.0).abs() < 1e-9 && slope(1, 0).error_per_m * 1e-6 < 1e-9);
        assert!((slope(2, 0).per_m * 1e-6 - 2.0 * 5.2).abs() < 1e-9);
        assert!((found.axes[2].as_ref().unwrap().step_m - 1.3e-6).abs() < 1e-18, "a quarter of the depth");
        // D(h) - v' = h^2 v''' / 6 = 25 * 6e-3 / 6, and D(h) lies three times that from D(2h).
        let exact = 3e-3 * 130.0 * 130.0;
        let (off, said) = ((slope(0, 1).per_m * 1e-6 - exact).abs(), slope(0, 1).error_per_m * 1e-6);
        assert!((off - 0.025).abs() < 1e-7 && (said - 0.075).abs() < 1e-7, "{off} {said}");
        assert_eq!(slope(0, 0).per_m, 0.0);
    }

    #[test]
    fn a_model_that_changes_its_number_of_values_is_broken() {
        let model = |at: &Pattern| response(vec![1.0; if at.width_m() > 130e-6 { 1 } else { 2 }]);
        let found = sensitivities(&model, &design(), 5e-6);
        assert!(matches!(found, Err(ModelFailure::Broken { .. })), "{found:?}");
    }

    #[test]
    fn a_step_beside_failing_designs_is_halved_and_at_a_cliff_there_is_no_slope() {
        let failing_beyond = |most_m: f64| {
            move |at: &Pattern| match at.width_m() {
                width_m if width_m > most_m => Err(ModelFailure::Trial { reason: "closes".to_owned() }),
                width_m => response(vec![1e6 * width_m]),
            }
        };
        let near = sensitivities(&failing_beyond(136e-6), &design(), 5e-6).unwrap();
        let width = near.axes[0].as_ref().unwrap();
        assert!((width.step_m - 2.5e-6).abs() < 1e-18 && (width.slopes[0].per_m * 1e-6 - 1.0).abs() < 1e-9);
        let at = sensitivities(&failing_beyond(130.1e-6), &design(), 5e-6).unwrap();
        assert!(at.axes[0].is_none() && at.axes[1].is_some());
        assert!(matches!(sensitivities(&failing_beyond(100e-6), &design(), 5e-6), Err(ModelFailure::Trial { .. })));
    }
}
