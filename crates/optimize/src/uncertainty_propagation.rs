//! What uncertain dimensions and parameters make of a response: by sampling the model, and to first order.

use crate::ModelFailure;
use crate::model::as_many;
use crate::sensitivity::{rim_height_m, with_lengths, with_rim_off};
use crate::uncertainty::Uncertainty;
use rayon::prelude::*;
use slipgrid_pattern::Pattern;
use slipgrid_statistics::Normals;

/// A model whose parameters can be moved. As with [`ForwardModel`](crate::ForwardModel), designs are evaluated from
/// several threads at once and equal inputs give equal answers.
pub trait UncertainModel: Sync {
    /// What `design` does where the parameters lie `deviations` from what they are taken to be.
    ///
    /// # Errors
    /// As [`ForwardModel::respond`](crate::ForwardModel::respond).
    fn respond_at(&self, design: &Pattern, deviations: &[f64]) -> Result<Vec<f64>, ModelFailure>;
}

impl<F> UncertainModel for F
where
    F: Fn(&Pattern, &[f64]) -> Result<Vec<f64>, ModelFailure> + Sync,
{
    fn respond_at(&self, design: &Pattern, deviations: &[f64]) -> Result<Vec<f64>, ModelFailure> {
        self(design, deviations)
    }
}

/// How one value scatters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean.
    pub mean: f64,
    /// Its standard error, from the number of draws.
    pub mean_stderr: f64,
    /// Standard deviation.
    pub std: f64,
    /// Ends of the band that holds 95 % of the draws.
    pub band: [f64; 2],
}

/// A share of draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probability {
    /// The share.
    pub share: f64,
    /// Its binomial standard error; that of (k + 1) / (n + 2), so that it does not vanish where all draws agree.
    pub stderr: f64,
}

/// Draws of the inputs and what the model made of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Propagation {
    /// Values of each draw, in the order drawn; `None` where the model has none.
    samples: Vec<Option<Vec<f64>>>,
    /// Draws for which the model has no answer.
    pub failed: usize,
    /// Draws of a dimension that was not positive: drawn again.
    pub redrawn: usize,
}

/// Draws of all dimensions in vain, one after another, after which nothing positive is expected.
const MOST_REDRAWS: usize = 1000;

/// Draws `draws` times from `uncertainty` about `design`, seeded, and asks `model` of each.
///
/// # Errors
/// [`ModelFailure`] other than of single draws, or where all draws fail; [`ModelFailure::Broken`] where draws differ in
/// their number of values.
pub fn propagate(
    model: &dyn UncertainModel,
    design: &Pattern,
    uncertainty: &Uncertainty,
    draws: usize,
    seed: u64,
) -> Result<Propagation, ModelFailure> {
    let mut normals = Normals::new(seed);
    let mut redrawn = 0;
    let mut inputs: Vec<(Pattern, Vec<f64>)> = Vec::with_capacity(draws);
    for _ in 0..draws {
        let drawn = drawn(design, uncertainty, &mut normals)?;
        redrawn += drawn.redrawn;
        inputs.push((drawn.made, drawn.deviations[uncertainty.parameters()].to_vec()));
    }
    let answers: Vec<_> = inputs.par_iter().map(|(at, parameters)| model.respond_at(at, parameters)).collect();
    let mut samples: Vec<Option<Vec<f64>>> = Vec::with_capacity(draws);
    let (mut expected, mut first_failure) = (None, None);
    for answer in answers {
        match answer {
            Ok(values) if values.iter().all(|value| value.is_finite()) => {
                let expected = *expected.get_or_insert(values.len());
                samples.push(Some(as_many(values, expected)?));
            }
            Ok(_) => samples.push(None),
            Err(failure @ ModelFailure::Trial { .. }) => {
                first_failure = first_failure.or(Some(failure));
                samples.push(None);
            }
            Err(failure) => return Err(failure),
        }
    }
    let failed = samples.iter().filter(|sample| sample.is_none()).count();
    if failed == draws {
        return Err(
            first_failure.unwrap_or_else(|| ModelFailure::Trial { reason: "no draw has finite values".to_owned() })
        );
    }
    Ok(Propagation { failed, samples, redrawn })
}

/// One draw about a design.
pub(crate) struct Drawn {
    /// The design moved by it.
    made: Pattern,
    /// Of all inputs.
    pub deviations: Vec<f64>,
    /// Draws before it of a dimension that was not positive.
    redrawn: usize,
}

/// Draws from `uncertainty` about `design` until every dimension is positive.
pub(crate) fn drawn(design: &Pattern, uncertainty: &Uncertainty, normals: &mut Normals) -> Result<Drawn, ModelFailure> {
    for redrawn in 0..MOST_REDRAWS {
        let z: Vec<f64> = (0..uncertainty.inputs()).map(|_| normals.draw()).collect();
        let deviations = uncertainty.deviations(&z);
        if let Ok(made) = moved(design, &deviations, uncertainty) {
            return Ok(Drawn { made, deviations, redrawn });
        }
    }
    Err(ModelFailure::Trial { reason: "the tolerances hardly leave a dimension positive".to_owned() })
}

/// The design moved by the first deviations, and its rims by the last where their height is not exact.
fn moved(design: &Pattern, deviations: &[f64], uncertainty: &Uncertainty) -> Result<Pattern, ModelFailure> {
    let mut moved_m = design.lengths_m();
    for (length_m, by_m) in moved_m.iter_mut().zip(deviations) {
        *length_m += by_m;
    }
    let made = with_lengths(design, moved_m)?;
    Ok(match uncertainty.rim() {
        Some(place) => with_rim_off(&made, deviations[place]),
        None => made,
    })
}

impl Propagation {
    /// Draws, failed ones included.
    #[must_use]
    pub fn draws(&self) -> usize {
        self.samples.len()
    }

    /// How each value scatters over the draws that have values.
    #[must_use]
    pub fn spreads(&self) -> Vec<Spread> {
        let values = self.samples.iter().flatten().next().map_or(0, Vec::len);
        (0..values).map(|value| spread(self.samples.iter().flatten().map(|sample| sample[value]).collect())).collect()
    }

    /// Whether `judge` holds for each draw, in the order drawn; for a failed one it does not.
    #[must_use]
    pub fn judged(&self, judge: impl Fn(&[f64]) -> bool) -> Vec<bool> {
        self.samples.iter().map(|sample| sample.as_ref().is_some_and(|values| judge(values))).collect()
    }

    /// How often `judge` holds; a failed draw counts as one for which it does not.
    #[must_use]
    pub fn probability(&self, judge: impl Fn(&[f64]) -> bool) -> Probability {
        Probability::of(self.judged(judge).into_iter().filter(|&holds| holds).count(), self.draws())
    }
}

impl Probability {
    /// `held` of `draws`.
    #[must_use]
    pub fn of(held: usize, draws: usize) -> Self {
        let (held, draws) = (held as f64, draws as f64);
        // p' = (k + 1) / (n + 2), error sqrt(p' (1 - p') / (n + 2))
        let smoothed = (held + 1.0) / (draws + 2.0);
        Self { share: held / draws, stderr: (smoothed * (1.0 - smoothed) / (draws + 2.0)).sqrt() }
    }
}

fn spread(mut values: Vec<f64>) -> Spread {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
    let std = if n > 1.0 { (square / (n - 1.0)).sqrt() } else { 0.0 };
    values.sort_by(f64::total_cmp);
    Spread { mean, mean_stderr: std / n.sqrt(), std, band: [quantile(&values, 0.025), quantile(&values, 0.975)] }
}

/// Linear between sorted values, the first at 0 and the last at 1.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    // Between 0 and the last index: the cast is exact.
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - place.floor()) * (sorted[above] - sorted[below])
}

/// A model to first order about a design, with differences as wide as the inputs scatter.
#[derive(Clone, Debug, PartialEq)]
pub struct Linearization {
    design: Pattern,
    values: Vec<f64>,
    /// dv/dx, one row per input.
    slopes: Vec<Vec<f64>>,
}

/// Widest difference along a dimension over the dimension itself.
const WIDEST_SHARE: f64 = 0.5;

impl Linearization {
    /// Of `model` about `design`: central differences over a standard deviation each way; zero slope along inputs that
    /// do not scatter.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design or a neighbour on both sides has no answer, or one of another length.
    pub fn new(model: &dyn UncertainModel, design: &Pattern, uncertainty: &Uncertainty) -> Result<Self, ModelFailure> {
        let parameters = uncertainty.parameters();
        let values = model.respond_at(design, &vec![0.0; parameters.len()])?;
        let slopes = (0..uncertainty.inputs())
            .into_par_iter()
            .map(|input| {
                let std = uncertainty.std(input);
                if std == 0.0 {
                    return Ok(vec![0.0; values.len()]);
                }
                // Rims are no lower than the land: beside it differences are one-sided.
                let is_lowest = uncertainty.rim() == Some(input) && design.rim_height_m() < std;
                let step = design.lengths_m().get(input).map_or(std, |length_m| std.min(WIDEST_SHARE * length_m));
                let ask = |by: f64| {
                    let mut deviations = vec![0.0; uncertainty.inputs()];
                    deviations[input] = by;
                    let made = moved(design, &deviations, uncertainty)?;
                    let answer = model.respond_at(&made, &deviations[parameters.clone()])?;
                    as_many(answer, values.len())
                };
                // (v(x + s) - v(x - s)) / 2s, one-sided beside designs that cannot be computed
                let difference = |above: &[f64], below: &[f64], width: f64| {
                    above.iter().zip(below).map(|(above, below)| (above - below) / width).collect()
                };
                if is_lowest {
                    return Ok(difference(&ask(step)?, &values, step));
                }
                match (ask(step), ask(-step)) {
                    (Ok(above), Ok(below)) => Ok(difference(&above, &below, 2.0 * step)),
                    (Ok(above), Err(ModelFailure::Trial { .. })) => Ok(difference(&above, &values, step)),
                    (Err(ModelFailure::Trial { .. }), Ok(below)) => Ok(difference(&values, &below, step)),
                    (Err(failure), _) | (_, Err(failure)) => Err(failure),
                }
            })
            .collect::<Result<Vec<Vec<f64>>, ModelFailure>>()?;
        Ok(Self { design: *design, values, slopes })
    }

    /// Of a model of which the values at `design` and the slopes along each input, one row an input, are known.
    #[must_use]
    pub const fn of_slopes(design: Pattern, values: Vec<f64>, slopes: Vec<Vec<f64>>) -> Self {
        Self { design, values, slopes }
    }

    /// The design.
    #[must_use]
    pub const fn design(&self) -> &Pattern {
        &self.design
    }

    /// The values at the design.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// dv/dx, one row per input.
    #[must_use]
    pub fn slopes(&self) -> &[Vec<f64>] {
        &self.slopes
    }

    /// Standard deviation of each value: sqrt(g' C g), g its slopes and C the inputs' covariance; of rims whose height may
    /// vanish the root mean square about the design.
    #[must_use]
    pub fn std(&self, uncertainty: &Uncertainty) -> Vec<f64> {
        self.std_of(uncertainty, &|_| true)
    }

    /// The same from the inputs of `of` alone.
    #[must_use]
    pub fn std_of(&self, uncertainty: &Uncertainty, of: &dyn Fn(usize) -> bool) -> Vec<f64> {
        let covariance = self.covariance_of(uncertainty, of);
        covariance.iter().enumerate().map(|(value, row)| row[value].max(0.0).sqrt()).collect()
    }

    /// Covariance of the values from the inputs of `of` alone, one row a value: G' C G, G their slopes and C their covariance.
    #[must_use]
    pub fn covariance_of(&self, uncertainty: &Uncertainty, of: &dyn Fn(usize) -> bool) -> Vec<Vec<f64>> {
        let count = self.values.len();
        let mut covariance = vec![vec![0.0; count]; count];
        for (i, row) in uncertainty.covariance().iter().enumerate().filter(|(i, _)| of(*i)) {
            for (j, entry) in row.iter().enumerate().filter(|(j, entry)| of(*j) && **entry != 0.0) {
                for (value, sums) in covariance.iter_mut().enumerate() {
                    let left = self.slopes[i][value] * entry;
                    sums.iter_mut().zip(&self.slopes[j]).for_each(|(sum, right)| *sum += left * right);
                }
            }
        }
        covariance
    }
}

impl UncertainModel for Linearization {
    fn respond_at(&self, design: &Pattern, deviations: &[f64]) -> Result<Vec<f64>, ModelFailure> {
        let by = design.lengths_m().into_iter().zip(self.design.lengths_m()).map(|(at, about)| at - about);
        let mut values = self.values.clone();
        let about_m = self.design.depth_m();
        let raised = rim_height_m(design, about_m) - rim_height_m(&self.design, about_m);
        for (by, slopes) in by.chain(deviations.iter().copied()).chain([raised]).zip(&self.slopes) {
            for (value, slope) in values.iter_mut().zip(slopes) {
                *value += by * slope;
            }
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests;
