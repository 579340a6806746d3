//! What the mixture says of a texture.

use slipgrid_statistics::{box_probability, normal_probability, normal_quantile};

use crate::mixture::Member;
use crate::residual::Place;
use crate::rows::Basis;
use crate::{DimensionShift, Features, Form};
use slipgrid_statistics::cholesky::{covariance_factor, dot};

/// Members of less weight change no digit that is reported.
const MIN_WEIGHT: f64 = 1e-7;

/// Steps towards a quantile at most; those that suffice are shorter, or lie at probabilities nearer, than these.
const MAX_STEPS: usize = 60;
const MIN_STEP: f64 = 1e-13;
const MIN_OFF: f64 = 1e-12;

/// Pressure, speed and humidity at which friction is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, from 0 to 1.
    pub humidity: f64,
}

/// The mixture at some loads, for many textures: what does not depend on the texture is computed once.
#[derive(Clone, Debug)]
pub struct Predictor {
    basis: Basis,
    loads: Vec<Load>,
    /// What the measured humidities leave open of eta, loads x loads.
    humidity_left: Vec<f64>,
    members: Vec<Prepared>,
}

/// A form at the loads. With L L^T the precision, b_l what multiplies the form's coefficients and e the modulus's column:
/// B_l = L^-1 b_l and E = L^-1 e.
#[derive(Clone, Debug)]
struct Prepared {
    member: Member,
    /// b_l times the mean coefficients, and e.
    mean_of_form: Vec<f64>,
    mean_of_modulus: f64,
    mean_of_residual: Vec<f64>,
    b: Vec<Vec<f64>>,
    e: Vec<f64>,
    /// B_l B_m, B_l E and E E.
    bb: Vec<f64>,
    be: Vec<f64>,
    ee: f64,
    /// Columns of L^-1 that multiply the residual's features.
    residual: Vec<Vec<f64>>,
}

/// What is predicted of one texture: the logarithm of a cut sample's true ratio over the modelled one, at each load.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// One normal distribution a form.
    pub components: Vec<Component>,
}

/// What one form predicts.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// The form.
    pub form: Form,
    /// Its weight; all weights sum to 1.
    pub weight: f64,
    /// Mean at each load.
    pub mean: Vec<f64>,
    /// Covariance, loads x loads.
    pub covariance: Vec<f64>,
    /// Mean without that of the modulus: the part that is proportional to the form.
    pub of_form: Vec<f64>,
    /// The part of the covariance that is left where the discrepancy of the texture is known: modulus, dimensions, the sample's own scatter.
    pub without_form: Vec<f64>,
}

/// Draws from a prediction: all loads at once.
#[derive(Clone, Debug)]
pub struct Sampler {
    forms: Vec<FormSampler>,
}

#[derive(Clone, Debug)]
struct FormSampler {
    /// Sum of the weights up to this form.
    cumulated_weight: f64,
    form: Form,
    mean: Vec<f64>,
    /// L of the covariance L L^T.
    factor: Vec<f64>,
    of_form: Vec<f64>,
}

impl Predictor {
    pub(crate) fn new(basis: &Basis, members: &[Member], loads: &[Load]) -> Self {
        let (p, of_form, modulus) = (basis.count(), basis.of_form(), basis.modulus());
        let rows: Vec<Vec<f64>> = loads.iter().map(|load| basis.at_load(load)).collect();
        let prepared = |member: &Member| {
            let column = |c: usize| -> Vec<f64> { (0..p).map(|row| member.inverse[row * p + c]).collect() };
            let times = |row: &[f64]| -> Vec<f64> {
                // A lower triangle: entries beyond the diagonal are zeros.
                (0..p).map(|r| dot(&member.inverse[r * p..][..=r.min(of_form - 1)], row)).collect()
            };
            let b: Vec<Vec<f64>> = rows.iter().map(|row| times(row)).collect();
            let e: Vec<f64> = column(modulus).iter().map(|entry| basis.modulus_std() * entry).collect();
            Prepared {
                mean_of_form: rows.iter().map(|row| dot(row, &member.mean)).collect(),
                mean_of_modulus: basis.modulus_std() * member.mean[modulus],
                mean_of_residual: member.mean[modulus + 1..].to_vec(),
                bb: b.iter().flat_map(|left| b.iter().map(|right| dot(left, right))).collect(),
                be: b.iter().map(|left| dot(left, &e)).collect(),
                ee: dot(&e, &e),
                b,
                e,
                residual: (modulus + 1..p).map(column).collect(),
                member: Member { mean: Vec::new(), inverse: Vec::new(), ..member.clone() },
            }
        };
        Self {
            loads: loads.to_vec(),
            humidity_left: loads.iter().flat_map(|a| loads.iter().map(|b| basis.humidity_left(a, b))).collect(),
            members: members.iter().filter(|member| member.weight > MIN_WEIGHT).map(prepared).collect(),
            basis: basis.clone(),
        }
    }

    /// Prediction of a sample with the features `of`, made exactly, whose modelled ratio goes with the logarithm of Young's modulus as
    /// `modulus_sensitivity` at each load. The sample's own scatter is in it.
    #[must_use]
    pub fn predict(&self, of: &Features, modulus_sensitivity: &[f64]) -> Prediction {
        self.predict_made(of, modulus_sensitivity, &[])
    }

    /// Prediction of ln(true ratio / modelled ratio as designed) of a sample whose dimensions are off by independent `shifts`: these move its
    /// modelled ratio and the discrepancy. To first order in the shifts, form by form.
    #[must_use]
    pub fn predict_made(&self, of: &Features, modulus_sensitivity: &[f64], shifts: &[DimensionShift]) -> Prediction {
        let places: Vec<Place> = self.loads.iter().map(|load| self.basis.place(of, load)).collect();
        let features: Vec<Vec<f64>> = places.iter().map(|place| self.basis.residual(place)).collect();
        let n = self.loads.len();
        let residual_left: Vec<f64> = (0..n * n)
            .map(|e| {
                let (l, m) = (e / n, e % n);
                self.basis.residual_left([&places[l], &places[m]], [&features[l], &features[m]])
            })
            .collect();
        let g = modulus_sensitivity;
        let component = |member: &Prepared| {
            let h = member.member.value(of);
            let own = member.member.scatter.powi(2);
            // What multiplies the residual's coefficients at load l, and R_l = L^-1 of that, below form and modulus.
            let size = h * member.member.residual;
            let first = member.e.len() - member.residual.len();
            let r: Vec<Vec<f64>> = features
                .iter()
                .map(|features| {
                    let mut r = vec![0.0; member.residual.len()];
                    for (place, (column, feature)) in member.residual.iter().zip(features).enumerate() {
                        for (sum, entry) in r[place..].iter_mut().zip(&column[first + place..]) {
                            *sum += size * feature * entry;
                        }
                    }
                    r
                })
                .collect();
            let re: Vec<f64> = r.iter().map(|r| dot(r, &member.e[first..])).collect();
            let mean_form: f64 = shifts.iter().map(|shift| shift.mean_form(&member.member.form, of)).product();
            let of_form: Vec<f64> = (0..n)
                .map(|l| mean_form * (h * member.mean_of_form[l] + size * dot(&features[l], &member.mean_of_residual)))
                .collect();
            // d ln h and d ln R + D d ln h by one standard deviation of each shift, D the mean discrepancy
            let of_shift = |shift: &DimensionShift| {
                let log_form = shift.log_form(&member.member.form, of);
                let moved = shift.log_ratio.iter().zip(&of_form).map(|(by, mean)| by + mean * log_form);
                (log_form, moved.collect::<Vec<f64>>())
            };
            let of_shifts: Vec<(f64, Vec<f64>)> = shifts.iter().map(of_shift).collect();
            // E (1 + d ln h)^2 of the part that is not known
            let times = 1.0 + of_shifts.iter().map(|(log_form, _)| log_form * log_form).sum::<f64>();
            // v_l = h B_l + g_l E + R_l, covariance v_l v_m
            let mut covariance = vec![0.0; n * n];
            let mut without_form = vec![0.0; n * n];
            for l in 0..n {
                for m in 0..=l {
                    let [rb, br] = [(l, m), (m, l)].map(|(l, m)| dot(&r[l], &member.b[m][first..]));
                    let left = self.humidity_left[l * n + m];
                    let unknown_form = h * h * (member.bb[l * n + m] + left)
                        + h * (rb + br)
                        + dot(&r[l], &r[m])
                        + size * size * residual_left[l * n + m];
                    let of_modulus = h * (g[m] * member.be[l] + g[l] * member.be[m])
                        + g[l] * g[m] * member.ee
                        + g[m] * re[l]
                        + g[l] * re[m];
                    let of_dimensions: f64 = of_shifts.iter().map(|(_, moved)| moved[l] * moved[m]).sum();
                    let entry = times * unknown_form + of_modulus + of_dimensions + own;
                    let left = g[l] * g[m] * member.ee + of_dimensions + own;
                    for (all, entry) in [(&mut covariance, entry), (&mut without_form, left)] {
                        all[l * n + m] = entry;
                        all[m * n + l] = entry;
                    }
                }
            }
            Component {
                form: member.member.form,
                weight: member.member.weight,
                mean: (0..n).map(|l| of_form[l] + g[l] * member.mean_of_modulus).collect(),
                covariance,
                of_form,
                without_form,
            }
        };
        Prediction { components: self.members.iter().map(component).collect() }
    }
}

impl Sampler {
    /// The draw of the form that the normal deviate `which` picks, with normal deviates `z`, one a load. `log_form` gives ln(h as made / h as
    /// designed) of a form.
    #[must_use]
    pub fn draw(&self, which: f64, z: &[f64], log_form: &dyn Fn(&Form) -> f64) -> Vec<f64> {
        let share = normal_probability(which);
        let picked = self.forms.iter().find(|form| share <= form.cumulated_weight).or(self.forms.last());
        let Some(FormSampler { form, mean, factor, of_form, .. }) = picked else { return Vec::new() };
        let n = mean.len();
        // D (h' / h - 1)
        let grown = libm::expm1(log_form(form));
        (0..n).map(|load| mean[load] + grown * of_form[load] + dot(&factor[load * n..][..=load], z)).collect()
    }

    /// The forms that draws come from.
    pub fn forms(&self) -> impl Iterator<Item = &Form> {
        self.forms.iter().map(|sampler| &sampler.form)
    }
}

impl Component {
    /// No less than the probability of lying between `lower` and `upper` at all loads: the least of those of each load, and of the
    /// difference of any two,
    ///
    /// ```text
    /// lower_l - upper_m <= y_l - y_m <= upper_l - lower_m
    /// ```
    ///
    /// Loads go together, so that it is their differences that tell most textures from what is wanted.
    pub(crate) fn most_within(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let n = self.mean.len();
        let within = |mean: f64, variance: f64, [from, to]: [f64; 2]| {
            let std = variance.max(1e-300).sqrt();
            let below = |end: f64| normal_probability((end - mean) / std);
            below(to) - below(from)
        };
        let mut most: f64 = 1.0;
        for l in 0..n {
            most = most.min(within(self.mean[l], self.covariance[l * n + l], [lower[l], upper[l]]));
        }
        for l in 0..n {
            for m in 0..l {
                let [ll, mm, lm] = [(l, l), (m, m), (l, m)].map(|(l, m)| self.covariance[l * n + m]);
                let ends = [lower[l] - upper[m], upper[l] - lower[m]];
                most = most.min(within(self.mean[l] - self.mean[m], ll + mm - 2.0 * lm, ends));
            }
        }
        most
    }
}

impl Prediction {
    /// Loads.
    #[must_use]
    pub fn loads(&self) -> usize {
        self.components.first().map_or(0, |component| component.mean.len())
    }

    /// The same with a further `covariance`, loads x loads, as of the tolerances of a sample's dimensions.
    #[must_use]
    pub fn with(mut self, covariance: &[f64]) -> Self {
        for component in &mut self.components {
            component.covariance.iter_mut().zip(covariance).for_each(|(own, further)| *own += further);
            component.without_form.iter_mut().zip(covariance).for_each(|(own, further)| *own += further);
        }
        self
    }

    /// The same where the discrepancy of the texture is known to be its median: what modulus, dimensions and the sample's own scatter leave.
    #[must_use]
    pub fn with_form_known(&self) -> Self {
        let medians = self.medians();
        let known =
            |of: &Component| Component { mean: medians.clone(), covariance: of.without_form.clone(), ..of.clone() };
        Self { components: self.components.iter().map(known).collect() }
    }

    /// Mean and standard deviation at `load`.
    #[must_use]
    pub fn moments(&self, load: usize) -> (f64, f64) {
        let n = self.loads();
        let mean: f64 = self.components.iter().map(|of| of.weight * of.mean[load]).sum();
        let spread = |of: &Component| of.covariance[load * n + load] + (of.mean[load] - mean).powi(2);
        (mean, self.components.iter().map(|of| of.weight * spread(of)).sum::<f64>().sqrt())
    }

    /// Probability of less than `value` at `load`.
    #[must_use]
    pub fn probability_below(&self, load: usize, value: f64) -> f64 {
        let n = self.loads();
        let of = |of: &Component| {
            let std = of.covariance[load * n + load].max(0.0).sqrt();
            let below = if std > 0.0 {
                normal_probability((value - of.mean[load]) / std)
            } else if of.mean[load] < value {
                1.0
            } else {
                0.0
            };
            of.weight * below
        };
        self.components.iter().map(of).sum()
    }

    /// The value below which a share `p` lies at `load`.
    #[must_use]
    pub fn quantile(&self, load: usize, p: f64) -> f64 {
        let n = self.loads();
        let z = normal_quantile(p);
        // It lies between the least and the greatest of the forms' own.
        let own =
            || self.components.iter().map(|of| of.mean[load] + z * of.covariance[load * n + load].max(0.0).sqrt());
        let (mut low, mut high) = (own().fold(f64::INFINITY, f64::min), own().fold(f64::NEG_INFINITY, f64::max));
        let off = |value: f64| self.probability_below(load, value) - p;
        let (mut off_low, mut off_high) = (off(low), off(high));
        // Regula falsi with halved ends (Dowell and Jarratt 1971, the Illinois method): P grows with the value.
        let mut side = 0;
        for _ in 0..MAX_STEPS {
            if high - low <= MIN_STEP || off_high <= off_low {
                break;
            }
            let middle = (low * off_high - high * off_low) / (off_high - off_low);
            let found = off(middle);
            if found < 0.0 {
                (low, off_low) = (middle, found);
                off_high *= if side < 0 { 0.5 } else { 1.0 };
                side = -1;
            } else {
                (high, off_high) = (middle, found);
                off_low *= if side > 0 { 0.5 } else { 1.0 };
                side = 1;
            }
            if found.abs() < MIN_OFF {
                return middle;
            }
        }
        f64::midpoint(low, high)
    }

    /// Whether half of all samples or more lie on the accepted side of every end of `lower` and `upper`: the median lies between them.
    #[must_use]
    pub fn has_medians_within(&self, lower: &[f64], upper: &[f64]) -> bool {
        (0..self.loads()).all(|load| {
            self.probability_below(load, lower[load]) <= 0.5 && self.probability_below(load, upper[load]) >= 0.5
        })
    }

    /// The value below which half lies at each load.
    #[must_use]
    pub fn medians(&self) -> Vec<f64> {
        (0..self.loads()).map(|load| self.quantile(load, 0.5)).collect()
    }

    /// Draws from this prediction.
    #[must_use]
    pub fn sampler(&self) -> Sampler {
        let n = self.loads();
        let mut reached = 0.0;
        let form = |of: &Component| {
            reached += of.weight;
            FormSampler {
                cumulated_weight: reached,
                form: of.form,
                mean: of.mean.clone(),
                factor: covariance_factor(&of.covariance, n),
                of_form: of.of_form.clone(),
            }
        };
        Sampler { forms: self.components.iter().map(form).collect() }
    }

    /// Probability that all loads lie between `lower` and `upper`.
    #[must_use]
    pub fn probability_within(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let n = self.loads();
        let of = |of: &Component| {
            let factor = covariance_factor(&of.covariance, n);
            of.weight * box_probability(&of.mean, &factor, lower, upper)
        };
        self.components.iter().map(of).sum()
    }

    /// No less than [`Prediction::probability_within`], and cheaper: form by form the least of what each load, and each two loads, allow.
    #[must_use]
    pub fn most_probability_within(&self, lower: &[f64], upper: &[f64]) -> f64 {
        self.components.iter().map(|of| of.weight * of.most_within(lower, upper)).sum()
    }

    /// Mean and covariance of the whole mixture.
    #[must_use]
    pub fn mixed(&self) -> (Vec<f64>, Vec<f64>) {
        let n = self.loads();
        let mut mean = vec![0.0; n];
        for of in &self.components {
            mean.iter_mut().zip(&of.mean).for_each(|(sum, own)| *sum += of.weight * own);
        }
        let mut covariance = vec![0.0; n * n];
        for of in &self.components {
            for l in 0..n {
                for m in 0..n {
                    let between = (of.mean[l] - mean[l]) * (of.mean[m] - mean[m]);
                    covariance[l * n + m] += of.weight * (of.covariance[l * n + m] + between);
                }
            }
        }
        (mean, covariance)
    }
}
