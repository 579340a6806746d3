//! Parameters of a fit.

use slipgrid_model::material::{AreaLaw, LocalFriction};

use crate::calibrate::flat_sample::Pairs;
use crate::calibrate::{Coefficients, FitError, Problem};

/// Bounds of mean local coefficients; values outside are not those of dry contact.
pub(super) const FRICTION_BOUNDS: [f64; 2] = [1e-3, 5.0];
/// Bounds of the local static coefficient mu_s over the first guess of the local dynamic coefficient mu_d. Below the
/// lower bound sliding would take more force than rest. Above the upper bound a larger mu_s does not raise the peak of
/// the modelled sample, because its ends slip long before its middle.
pub const STATIC_OVER_DYNAMIC: [f64; 2] = [0.9, 3.5];

/// Indices of the parameters of a fit: for each measurement the local coefficients mu_d and, if fitted, mu_s; and the
/// scale of the area law.
pub(super) struct Layout {
    pub(super) dynamic: Vec<usize>,
    pub(super) fixed_static: Vec<Option<usize>>,
    /// Index of the logarithm of the area law's scale, if it is fitted.
    pub(super) log_scale: Option<usize>,
    pub(super) count: usize,
}

impl Layout {
    pub(super) fn new(problem: &Problem) -> Self {
        let measured = &problem.measurements;
        let groups = match problem.coefficients {
            Coefficients::Single => 1,
            Coefficients::PerCondition => measured.len(),
        };
        let group_of = |i: usize| if groups == 1 { 0 } else { i };
        let mut count = groups;
        let mut group_static = vec![None; groups];
        for (i, measured) in measured.iter().enumerate() {
            if measured.static_peak.is_some() && group_static[group_of(i)].is_none() {
                group_static[group_of(i)] = Some(count);
                count += 1;
            }
        }
        Self {
            dynamic: (0..measured.len()).map(group_of).collect(),
            fixed_static: (0..measured.len()).map(|i| group_static[group_of(i)]).collect(),
            log_scale: problem.area_law_scale.as_ref().map(|_| count),
            count: count + usize::from(problem.area_law_scale.is_some()),
        }
    }

    pub(super) fn bounds(&self, problem: &Problem) -> Vec<[f64; 2]> {
        let mut bounds = vec![FRICTION_BOUNDS; self.count];
        let first = first_guess(problem, self);
        for (dynamic, fixed) in self.dynamic.iter().zip(&self.fixed_static) {
            if let Some(number) = fixed {
                bounds[*number] = STATIC_OVER_DYNAMIC.map(|ratio| ratio * first[*dynamic]);
            }
        }
        if let (Some(number), Some(unknown)) = (self.log_scale, &problem.area_law_scale) {
            bounds[number] = unknown.bounds_pa.map(f64::ln);
        }
        bounds
    }

    /// Area law for the parameters, and the logarithm of its scale in pascals, which is 0 if the law is given.
    pub(super) fn law(&self, problem: &Problem, parameters: &[f64]) -> Result<(Option<AreaLaw>, f64), FitError> {
        let log_scale = self.log_scale.map_or(0.0, |number| parameters[number]);
        Ok((problem.law_at(log_scale.exp())?, log_scale))
    }

    /// Local coefficients of measurement `i`.
    pub(super) fn pair(&self, problem: &Problem, parameters: &[f64], i: usize) -> Result<LocalFriction, FitError> {
        let dynamic_mean = parameters[self.dynamic[i]];
        let static_mean =
            self.fixed_static[i].map_or(problem.static_over_dynamic * dynamic_mean, |number| parameters[number]);
        Ok(LocalFriction::new(static_mean, dynamic_mean, problem.relative_std)?)
    }

    pub(super) fn pairs(&self, problem: &Problem, parameters: &[f64]) -> Result<Pairs, FitError> {
        (0..self.dynamic.len()).map(|i| self.pair(problem, parameters, i)).collect()
    }
}

/// Initial parameters: measured friction over the area factor f(P), averaged over the measurements that share a
/// parameter.
pub(super) fn first_guess(problem: &Problem, layout: &Layout) -> Vec<f64> {
    let mut sums = vec![(0.0, 0.0); layout.count];
    // The scale of an unknown law starts in the middle of its range.
    let middle =
        problem.area_law_scale.as_ref().map_or(0.0, |unknown| unknown.bounds_pa.map(f64::ln).iter().sum::<f64>() / 2.0);
    let law = problem.law_at(middle.exp()).ok().flatten();
    for (i, measured) in problem.measurements.iter().enumerate() {
        let factor = law.as_ref().map_or(1.0, |law| law.factor(problem.pressure_pa(measured)));
        let mut add = |number: usize, mu: f64| {
            sums[number].0 += mu / factor;
            sums[number].1 += 1.0;
        };
        add(layout.dynamic[i], measured.mu_dynamic);
        if let (Some(number), Some(peak)) = (layout.fixed_static[i], measured.static_peak) {
            add(number, peak.mu);
        }
    }
    if let Some(number) = layout.log_scale {
        sums[number] = (middle, 1.0);
    }
    sums.into_iter().map(|(sum, count): (f64, f64)| sum / count.max(1.0)).collect()
}
