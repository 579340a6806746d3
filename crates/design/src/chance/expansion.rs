//! The values of a design about it, along everything that is not known exactly.

use slipgrid_discrepancy::{DimensionShift, Features, Form, Sampler};

use super::*;
use slipgrid_specimen::Laid;

/// A design to first order along each input, and to second along the modulus (or the fitted scale) and the area law: a search for
/// the greatest chance finds where their slopes vanish. The discrepancy is drawn from its own distribution.
pub struct Expansion {
    pub(super) slopes: Linearization,
    /// Half the second derivative of the values along an input, by its place.
    curvatures: Vec<(usize, Vec<f64>)>,
    discrepancy: Option<Drawn>,
    clearance: Option<Clearance>,
}

/// Least height of a ceiling above the counterface, in metres, with its slopes along inputs by their places.
struct Clearance {
    least_m: f64,
    slopes: Vec<(usize, f64)>,
}

impl Expansion {
    /// To first order, with nothing else.
    pub(super) const fn of_slopes(slopes: Linearization) -> Self {
        Self { slopes, curvatures: Vec::new(), discrepancy: None, clearance: None }
    }

    /// Whether cavities stay open, to first order, where the inputs that `of` names are off by `deviations`.
    pub(super) fn is_open(&self, deviations: &[f64], of: &dyn Fn(usize) -> bool) -> bool {
        self.clearance.as_ref().is_none_or(|Clearance { least_m, slopes }| {
            let off = slopes.iter().filter(|(place, _)| of(*place)).map(|(place, slope)| slope * deviations[*place]);
            least_m + off.sum::<f64>() > 0.0
        })
    }

    /// Adds to `values`, which are those to first order where the inputs are off by `deviations`, what the inputs that `of` names
    /// add to second order, and multiplies them by the discrepancy where it is one of these.
    pub(super) fn complete(&self, values: &mut [f64], deviations: &[f64], of: &dyn Fn(usize) -> bool) {
        for (place, curvature) in self.curvatures.iter().filter(|(place, _)| of(*place)) {
            let square = deviations[*place].powi(2);
            values.iter_mut().zip(curvature).for_each(|(value, half)| *value += half * square);
        }
        if let Some(drawn) = self.discrepancy.as_ref().filter(|drawn| of(drawn.first)) {
            let mut made_m: [f64; DIMENSIONS] =
                std::array::from_fn(|axis| if of(axis) { deviations[axis] } else { 0.0 });
            if let Some((place, depth_m)) = drawn.burst.filter(|(place, _)| of(*place)) {
                made_m[DEPTH] += depth_m * deviations[place].exp_m1();
            }
            values.iter_mut().zip(drawn.factors(deviations, made_m)).for_each(|(value, factor)| *value *= factor);
        }
    }
}

/// The discrepancy of a design: values are multiplied by the exponential of a draw less the median.
pub(super) struct Drawn {
    sampler: Sampler,
    pub(super) medians: Vec<f64>,
    pub(super) first: usize,
    /// d ln h / dx along width, spacing and depth, in 1/m, of each form.
    log_slopes: Vec<(Form, [f64; DIMENSIONS])>,
    /// Place of the depth per burst, with the depth that it scales, in metres.
    burst: Option<(usize, f64)>,
}

impl Drawn {
    /// Factors of the values where the deviates, of all inputs, are `deviations`, and the dimensions are off by `made_m`.
    pub(super) fn factors(&self, deviations: &[f64], made_m: [f64; DIMENSIONS]) -> impl Iterator<Item = f64> {
        let (which, z) = (deviations[self.first], &deviations[self.first + 1..=self.first + self.medians.len()]);
        let log_form = |form: &Form| {
            let slopes =
                self.log_slopes.iter().find(|(own, _)| own == form).map_or([0.0; DIMENSIONS], |(_, slopes)| *slopes);
            slopes.into_iter().zip(made_m).map(|(slope, by_m)| slope * by_m).sum()
        };
        let drawn = self.sampler.draw(which, z, &log_form);
        drawn.into_iter().zip(&self.medians).map(|(drawn, median)| (drawn - median).exp())
    }
}

/// What one input changes, by its unit: of each ratio, half the second derivative of that, and of the least height of a ceiling in metres.
#[derive(Clone, Debug)]
pub(super) struct Slope {
    ratio: Vec<f64>,
    curvature: Vec<f64>,
    clearance: f64,
}

/// (a - b) / step
fn per_step(above: &Answer, below: &Answer, step: f64) -> Slope {
    let ratio: Vec<f64> = above.ratio.iter().zip(&below.ratio).map(|(above, below)| (above - below) / step).collect();
    let clearance = above.clearance_m().zip(below.clearance_m()).map_or(0.0, |(above, below)| (above - below) / step);
    Slope { curvature: vec![0.0; ratio.len()], ratio, clearance }
}

/// How the steady model moves about a design along each input that it is asked of: the dimensions that scatter, the height of the rims, the
/// depth per burst, flat friction, scale and factors of the area law. By central differences over a standard deviation each way.
#[derive(Clone, Debug)]
pub(super) struct Sensitivity(Vec<Slope>);

impl Sensitivity {
    /// As numbers, for [`BetweenDesigns`].
    pub fn numbers(&self) -> Vec<f64> {
        let of = |slope: &Slope| [slope.ratio.clone(), slope.curvature.clone(), vec![slope.clearance]].concat();
        self.0.iter().flat_map(of).collect()
    }

    /// Of these numbers, of so many `values`.
    pub fn of(numbers: &[f64], values: usize) -> Self {
        let of = |numbers: &[f64]| {
            let (ratio, rest) = numbers.split_at(values);
            Slope { ratio: ratio.to_vec(), curvature: rest[..values].to_vec(), clearance: rest[values] }
        };
        Self(numbers.chunks_exact(2 * values + 1).map(of).collect())
    }
}

impl Chances<'_> {
    /// The discrepancy of `design`, where designs aim with it.
    pub(super) fn drawn(&self, design: &Pattern) -> Result<Option<Drawn>, ModelFailure> {
        let Some(learned) = &self.learned else { return Ok(None) };
        let prediction = learned.prediction(design, &learned.modulus_sensitivity(design)?);
        let (sampler, medians) = (prediction.sampler(), prediction.medians());
        let own = Features::from(design);
        let slope = |form: &Form, axis: usize| {
            let step_m = Some(self.tolerances.std_m[axis])
                .filter(|std_m| *std_m > 0.0)
                .unwrap_or(0.01 * design.lengths_m()[axis]);
            let by_m = std::array::from_fn(|other| if other == axis { step_m } else { 0.0 });
            let [above, below] = [1.0, -1.0].map(|side| Features::from(&made(design, &by_m, side)));
            DimensionShift { log_ratio: Vec::new(), above, below: Some(below) }.log_form(form, &own) / step_m
        };
        let mut log_slopes: Vec<(Form, [f64; DIMENSIONS])> = Vec::new();
        for form in sampler.forms() {
            if !log_slopes.iter().any(|(known, _)| known == form) {
                log_slopes.push((*form, std::array::from_fn(|axis| slope(form, axis))));
            }
        }
        Ok(Some(Drawn {
            sampler,
            medians,
            first: self.first_discrepancy,
            log_slopes,
            burst: self.burst.map(|place| (place, design.depth_m())),
        }))
    }

    /// The values of a design about it.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where neighbours of the design cannot be computed.
    pub fn expand(&self, about: &About<'_>) -> Result<Expansion, ModelFailure> {
        self.expand_by(about, &self.sensitivity(about.design, about.still)?)
    }

    /// How the steady model moves about `design`, of which it says `still`.
    pub(super) fn sensitivity(&self, design: &Pattern, still: &Answer) -> Result<Sensitivity, ModelFailure> {
        let laid = self.still.lay(design)?;
        let dimensions = self.tolerances.std_m.into_iter().enumerate().filter(|(_, std_m)| *std_m > 0.0);
        let mut slopes = dimensions
            .map(|(axis, std_m)| self.along_axis(design, &laid, axis, std_m, 1.0))
            .collect::<Result<Vec<Slope>, ModelFailure>>()?;
        if self.uncertainty.rim().is_some() {
            slopes.push(self.along_rim(design)?);
        }
        if let Some(place) = self.burst {
            // By a share of the depth: dr / d ln(depth).
            let (depth_m, std) = (design.depth_m(), self.uncertainty.std(place));
            slopes.push(self.along_axis(design, &laid, DEPTH, std * depth_m, depth_m)?);
        }
        for along in self.beside() {
            // All of them lie on one specimen: laying out crossing grooves takes as long as solving them.
            let at = |model: &SteadyModel| model.answer_made(design, &laid);
            let (above, below) = rayon::join(|| at(&along.above), || at(&along.below));
            let (above, below) = (above?, below?);
            // (r(x + s) - r(x - s)) / 2s and (r(x + s) - 2 r(x) + r(x - s)) / 2s^2
            let load = |load: usize| {
                let (above, below, own) = (above.ratio[load], below.ratio[load], still.ratio[load]);
                let step = along.step[load];
                ((above - below) / (2.0 * step), (above - 2.0 * own + below) / (2.0 * step * step))
            };
            let (ratio, curvature) = (0..self.scale.len()).map(load).unzip();
            let clearance = per_step(&above, &below, 2.0 * along.step[0]).clearance;
            slopes.push(Slope { ratio, curvature, clearance });
        }
        Ok(Sensitivity(slopes))
    }

    /// The values of a design about it, where the steady model moves by `sensitivity`.
    pub(super) fn expand_by(&self, about: &About<'_>, sensitivity: &Sensitivity) -> Result<Expansion, ModelFailure> {
        let (count, values) = (self.scale.len(), about.values.to_vec());
        let discrepancy = self.drawn(about.design)?;
        let medians = discrepancy.as_ref().map(|drawn| &drawn.medians);
        let factor = |load: usize| medians.map_or(1.0, |medians| medians[load].exp());
        let scale: Vec<f64> = self.scale.iter().enumerate().map(|(load, scale)| scale * factor(load)).collect();
        let scaled = |ratio: &[f64]| ratio.iter().zip(&scale).map(|(ratio, scale)| ratio * scale).collect::<Vec<f64>>();
        let mut slopes = vec![vec![0.0; count]; self.uncertainty.inputs()];
        let mut of_clearance: Vec<(usize, f64)> = Vec::new();
        let mut along = sensitivity.0.iter();
        let axes = (0..DIMENSIONS).filter(|axis| self.tolerances.std_m[*axis] > 0.0);
        for (place, along) in axes.chain(self.uncertainty.rim()).chain(self.burst).zip(&mut along) {
            slopes[place] = scaled(&along.ratio);
            of_clearance.push((place, along.clearance));
        }
        for (friction, along) in self.friction.iter().zip(&mut along) {
            for (load, slope) in scaled(&along.ratio).into_iter().enumerate() {
                // mu = r mu_flat (1 + x)
                slopes[friction.first + load % self.inputs_of_loads][load] =
                    slope + if self.is_ratio { 0.0 } else { values[load] };
            }
        }
        let mut curvatures = Vec::new();
        for (law, along) in self.law_scale.iter().chain(&self.law).zip(along) {
            slopes[law.first] = scaled(&along.ratio);
            curvatures.push((law.first, scaled(&along.curvature)));
            of_clearance.push((law.first, along.clearance));
        }
        about.numerical.enter(&mut slopes[self.numerical()]);
        let clearance = about.still.clearance_m().map(|least_m| Clearance { least_m, slopes: of_clearance });
        let slopes = Linearization::of_slopes(*about.design, values, slopes);
        Ok(Expansion { slopes, curvatures, discrepancy, clearance })
    }

    /// Slopes along the height of the rims, per metre: over a standard deviation each way, and upwards alone where the rims are lower
    /// than that.
    fn along_rim(&self, design: &Pattern) -> Result<Slope, ModelFailure> {
        let step_m = self.tolerances.rim_height_std_m;
        let laid = self.still.lay(design)?;
        let at = |by_m: f64| self.still.answer_made(&with_rim_off(design, by_m), &laid);
        let below_m = if design.rim_height_m() < step_m { 0.0 } else { -step_m };
        Ok(per_step(&at(step_m)?, &at(below_m)?, step_m - below_m))
    }

    /// Standard deviation of each ratio of `design` by the height of its rims alone; `None` where that is exact, or where
    /// neighbours of the design cannot be computed.
    #[must_use]
    pub fn rim_std(&self, design: &Pattern) -> Option<Vec<f64>> {
        self.uncertainty.rim()?;
        let per_m = self.along_rim(design).ok()?.ratio;
        Some(per_m.iter().map(|slope| slope.abs() * self.tolerances.rim_height_std_m).collect())
    }

    /// Slopes along one dimension, per `unit_m`.
    fn along_axis(
        &self,
        design: &Pattern,
        laid: &Laid,
        axis: usize,
        std_m: f64,
        unit_m: f64,
    ) -> Result<Slope, ModelFailure> {
        let lengths_m = design.lengths_m();
        let step_m = std_m.min(WIDEST_SHARE * lengths_m[axis]);
        let step = step_m / unit_m;
        let at = |by_m: f64| {
            let mut made_m = lengths_m;
            made_m[axis] += by_m;
            let made = Pattern::new(*design.texture(), made_m[0], made_m[1], made_m[2]);
            let made = made.map_err(|error| ModelFailure::Trial { reason: error.to_string() })?;
            self.still.answer_made(&made, laid)
        };
        match rayon::join(|| at(step_m), || at(-step_m)) {
            (Ok(above), Ok(below)) => Ok(per_step(&above, &below, 2.0 * step)),
            // One-sided beside designs that cannot be computed.
            (Ok(above), Err(ModelFailure::Trial { .. })) => Ok(per_step(&above, &at(0.0)?, step)),
            (Err(ModelFailure::Trial { .. }), Ok(below)) => Ok(per_step(&at(0.0)?, &below, step)),
            (Err(failure), _) | (_, Err(failure)) => Err(failure),
        }
    }
}
