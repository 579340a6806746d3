//! Prediction of the mixture for a texture.

use slipgrid_base::statistics::{mixture_quantile, normal_probability, tabulated_normal_probability};

use crate::discrepancy::flat_friction::{PreparedFlat, conditional};
use crate::discrepancy::mixture::Member;
use crate::discrepancy::residual::Place;
use crate::discrepancy::rows::{Basis, GLOBALS};
use crate::discrepancy::{Candidate, DimensionShift, Features, Form, Sensitivity};
use slipgrid_base::statistics::cholesky::{covariance_factor, dot};

/// Weight below which a member of the mixture is left out; it would not change reported digits.
const MIN_WEIGHT: f64 = 1e-7;

/// Pressure, speed and humidity of a prediction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Load {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, from 0 to 1.
    pub humidity: f64,
}

/// Mixture prepared for some loads, to predict many textures: terms independent of the texture are computed once.
#[derive(Clone, Debug)]
pub struct Predictor {
    basis: Basis,
    loads: Vec<Load>,
    /// Covariance of the humidity terms eta + gamma q that remains given the measured humidities, loads x loads.
    humidity_left: Vec<f64>,
    /// Distinct forms of the members.
    forms: Vec<Form>,
    members: Vec<Prepared>,
}

/// Member prepared for the loads. With the posterior precision L L^T, the row b_l of the form's coefficients at load l
/// and the column e_k of eps (modulus) or lambda (local law): B_l = L^-1 b_l and E_k = L^-1 e_k.
#[derive(Clone, Debug)]
struct Prepared {
    member: Member,
    /// Index of the member's form in `Predictor::forms`.
    form: usize,
    /// Posterior mean of b_l times the form's coefficients, one per load.
    mean_of_form: Vec<f64>,
    /// Posterior means of eps (modulus) and lambda (local law).
    mean_of_globals: [f64; GLOBALS],
    mean_of_residual: Vec<f64>,
    b: Vec<Vec<f64>>,
    e: [Vec<f64>; GLOBALS],
    /// Products B_l B_m, loads x loads.
    bb: Vec<f64>,
    /// Products B_l E_k, one entry per load.
    be: Vec<[f64; GLOBALS]>,
    /// Products E_k E_j.
    ee: [[f64; GLOBALS]; GLOBALS],
    /// Columns of L^-1 for the residual's coefficients.
    residual: Vec<Vec<f64>>,
    /// Flat friction; `None` for predictions of ratios.
    flat: Option<PreparedFlat>,
}

/// Unknown of a prediction that samples share and trials inform about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// The discrepancy of the texture.
    Form,
    /// Error of flat friction.
    Flat,
    /// Error of Young's modulus.
    Modulus,
    /// Share of the local law in friction.
    LocalLaw,
}

/// Prediction for one texture: the logarithm of a cut sample's true ratio over the modelled one, at each load.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    /// One normal distribution per member of the mixture.
    pub components: Vec<Component>,
}

/// Component of a prediction: a normal distribution of the logarithm of the true over the modelled ratio.
#[derive(Clone, Debug, PartialEq)]
pub struct Component {
    /// Form of the component.
    pub form: Form,
    /// Weight of the component; all weights sum to 1.
    pub weight: f64,
    /// Mean at each load; in a joint prediction one value per sample and load.
    pub mean: Vec<f64>,
    /// Covariance between the values at all loads: a matrix of loads x loads, row by row.
    pub covariance: Vec<f64>,
}

/// Form evaluated at one texture.
struct FormAt {
    /// Value of the form in its own units, from `Form::value`.
    value: f64,
    /// Change of the form's logarithm by one standard deviation of each error of the dimensions.
    log_shifts: Vec<f64>,
    /// Mean of the form over errors of the dimensions, relative to the form as designed.
    mean: f64,
}

impl Predictor {
    pub(crate) fn new(basis: &Basis, members: &[Member], loads: &[Load], shares: &[Vec<f64>]) -> Self {
        // Only the columns of L^-1 for the flat sample's errors, which come first, have entries in the first rows.
        let (p, flat, of_form) = (basis.count(), basis.flat.len(), basis.of_form());
        let of_residual = flat + of_form + GLOBALS;
        let rows: Vec<Vec<f64>> = loads.iter().map(|load| basis.at_load(load)).collect();
        let mut forms: Vec<Form> = Vec::new();
        let mut place_of = |form: Form| {
            forms.iter().position(|own| *own == form).unwrap_or_else(|| {
                forms.push(form);
                forms.len() - 1
            })
        };
        let prepared = |member: &Member| {
            let column = |c: usize| -> Vec<f64> { (flat..p).map(|row| member.inverse[row * p + c]).collect() };
            let times = |row: &[f64]| -> Vec<f64> {
                // Lower triangle: entries beyond the diagonal are zero.
                (flat..p).map(|r| dot(&member.inverse[r * p + flat..][..=(r - flat).min(of_form - 1)], row)).collect()
            };
            let b: Vec<Vec<f64>> = rows.iter().map(|row| times(row)).collect();
            let scaled = |global: usize| {
                let std = basis.global_stds()[global];
                column(basis.globals()[global]).iter().map(|entry| std * entry).collect::<Vec<f64>>()
            };
            let e: [Vec<f64>; GLOBALS] = std::array::from_fn(scaled);
            Prepared {
                flat: (flat > 0 && !shares.is_empty())
                    .then(|| PreparedFlat::new(member, [p, flat, of_residual], shares, (&b, &e))),
                mean_of_form: rows.iter().map(|row| dot(row, &member.mean[flat..])).collect(),
                mean_of_globals: basis.global_means(&member.mean),
                mean_of_residual: member.mean[of_residual..].to_vec(),
                bb: b.iter().flat_map(|left| b.iter().map(|right| dot(left, right))).collect(),
                be: b.iter().map(|left| e.each_ref().map(|e| dot(left, e))).collect(),
                ee: e.each_ref().map(|left| e.each_ref().map(|right| dot(left, right))),
                b,
                e,
                residual: (of_residual..p).map(column).collect(),
                form: place_of(member.form),
                member: Member { mean: Vec::new(), inverse: Vec::new(), ..member.clone() },
            }
        };
        let members = members.iter().filter(|member| member.weight > MIN_WEIGHT).map(prepared).collect();
        Self {
            loads: loads.to_vec(),
            humidity_left: loads.iter().flat_map(|a| loads.iter().map(|b| basis.humidity_left(a, b))).collect(),
            forms,
            members,
            basis: basis.clone(),
        }
    }

    /// Predictor with only the members of the mixture of greatest weight, which together have at least `share` of the
    /// weight. Probabilities differ from those of the whole mixture by at most 1 - `share`.
    pub fn likeliest(&self, share: f64) -> Self {
        let mut members = self.members.clone();
        members.sort_by(|a, b| b.member.weight.total_cmp(&a.member.weight));
        let mut sum = 0.0;
        members.retain(|own| {
            let is_needed = sum < share;
            sum += if is_needed { own.member.weight } else { 0.0 };
            is_needed
        });
        members.iter_mut().for_each(|own| own.member.weight /= sum);
        Self { members, ..self.clone() }
    }

    /// Predictor of samples that do not scatter about the friction of their texture.
    pub fn without_scatter(&self) -> Self {
        let mut alike = self.clone();
        alike.members.iter_mut().for_each(|own| own.member.scatter = 0.0);
        alike
    }

    /// Predicts a sample with the features `of` and without errors of its dimensions, with the `sensitivity` of its
    /// modelled ratio to Young's modulus and the local law at each load. Includes the scatter of the sample.
    pub fn predict(&self, of: &Features, sensitivity: &[Sensitivity]) -> Distribution {
        self.predict_made(of, sensitivity, &[])
    }

    /// Predicts ln(true ratio / modelled ratio as designed) of a sample with independent errors `shifts` of its
    /// dimensions, which change its modelled ratio and the discrepancy. First order in the shifts, per form.
    pub fn predict_made(&self, of: &Features, sensitivity: &[Sensitivity], shifts: &[DimensionShift]) -> Distribution {
        let (modelled, covariance) = (&[][..], &[][..]);
        let of = Candidate { features: *of, modelled, sensitivity, covariance, dimension_shifts: shifts };
        self.predicted(&[of], None)
    }

    /// Predicts samples that share all unknowns except the errors of their dimensions; values are sorted by sample,
    /// then by load. Covariances are those given the `known` unknown, if any: what trials say of a sum of two unknowns then
    /// tells the other. The covariances of `samples` are not added.
    fn predicted(&self, samples: &[Candidate<'_>], known: Option<Unknown>) -> Distribution {
        let n = self.loads.len();
        let rows: Vec<(usize, usize)> = (0..samples.len()).flat_map(|of| (0..n).map(move |load| (of, load))).collect();
        let all = rows.len();
        let g: Vec<[f64; GLOBALS]> = rows.iter().map(|(of, load)| samples[*of].sensitivity[*load].globals()).collect();
        // Skips lambda if flat friction follows the area law.
        let globals = if g.iter().all(|[_, local_law]| *local_law == 0.0) { 1 } else { GLOBALS };
        let place = |(of, load): &(usize, usize)| self.basis.place(&samples[*of].features, &self.loads[*load]);
        let places: Vec<Place> = rows.iter().map(place).collect();
        let features: Vec<Vec<f64>> = places.iter().map(|place| self.basis.residual(place)).collect();
        let residual_left: Vec<f64> = (0..all * all)
            .map(|e| {
                let (a, b) = (e / all, e % all);
                self.basis.residual_left([&places[a], &places[b]], [&features[a], &features[b]])
            })
            .collect();
        let form_at = |form: &Form, of: &Candidate<'_>| FormAt {
            value: form.on_face(&of.features),
            log_shifts: of.dimension_shifts.iter().map(|shift| shift.log_form(form, &of.features)).collect(),
            mean: of.dimension_shifts.iter().map(|shift| shift.mean_form(form, &of.features)).product(),
        };
        let forms: Vec<Vec<FormAt>> =
            self.forms.iter().map(|form| samples.iter().map(|of| form_at(form, of)).collect()).collect();
        // Buffers of one member: R_a, R_a E, D_a, and the effects of errors of dimensions.
        let count = self.members.first().map_or(0, |member| member.residual.len());
        let (mut r, mut re, mut of_form) = (vec![0.0; all * count], vec![[0.0; GLOBALS]; all], vec![0.0; all]);
        let mut moved: Vec<Vec<f64>> = vec![Vec::new(); all];
        let component = |member: &Prepared| {
            let forms = &forms[member.form];
            let own = member.member.scatter.powi(2);
            let h = |of: usize| member.member.scale * forms[of].value / member.member.at_reference;
            let first = member.e[0].len() - count;
            r.fill(0.0);
            for (a, (of, load)) in rows.iter().enumerate() {
                // Row of the residual's coefficients, and R_a = L^-1 of the row, below form and modulus.
                let (form, h) = (&forms[*of], h(*of));
                let size = h * member.member.residual;
                let r = &mut r[a * count..][..count];
                for (place, (column, feature)) in member.residual.iter().zip(&features[a]).enumerate() {
                    for (sum, entry) in r[place..].iter_mut().zip(&column[first + place..]) {
                        *sum += size * feature * entry;
                    }
                }
                re[a] = member.e.each_ref().map(|e| dot(r, &e[first..]));
                of_form[a] =
                    form.mean * (h * member.mean_of_form[*load] + size * dot(&features[a], &member.mean_of_residual));
                // d ln R + D d ln h by one standard deviation of each shift, D the mean discrepancy
                let shifts = samples[*of].dimension_shifts.iter().zip(&form.log_shifts);
                moved[a].clear();
                moved[a].extend(shifts.map(|(shift, log_form)| shift.log_ratio[*load] + of_form[a] * log_form));
            }
            // The discrepancy d_a = h B_l + R_a, covariance d_a d_b
            let unknown_form = |a: usize, b: usize| {
                let ((of, l), (other, m)) = (rows[a], rows[b]);
                let (h_a, h_b) = (h(of), h(other));
                let [r_a, r_b] = [a, b].map(|row| &r[row * count..][..count]);
                let [rb, br] = [dot(r_a, &member.b[m][first..]), dot(r_b, &member.b[l][first..])];
                h_a * h_b * (member.bb[l * n + m] + self.humidity_left[l * n + m])
                    + h_b * rb
                    + h_a * br
                    + dot(r_a, r_b)
                    + h_a * h_b * member.member.residual.powi(2) * residual_left[a * all + b]
            };
            // d_a E_k
            let form_with = |a: usize, k: usize| h(rows[a].0) * member.be[rows[a].1][k] + re[a][k];
            // v_a = d_a + sum_k g_ak E_k, covariance v_a v_b
            let mut covariance = vec![0.0; all * all];
            for a in 0..all {
                for b in 0..=a {
                    let (of, other) = (rows[a].0, rows[b].0);
                    let of_globals: f64 = (0..globals)
                        .map(|k| (0..globals).map(|j| g[a][k] * g[b][j] * member.ee[k][j]).sum::<f64>())
                        .sum();
                    // E (1 + d ln h)^2 of the uncertain part; errors of dimensions are a sample's own.
                    let mut times = 1.0;
                    let mut entry = of_globals + own;
                    if of == other {
                        entry += dot(&moved[a], &moved[b]);
                        if known != Some(Unknown::Form) {
                            times += dot(&forms[of].log_shifts, &forms[of].log_shifts);
                        }
                    }
                    entry += times * unknown_form(a, b);
                    entry += (0..globals).map(|k| g[b][k] * form_with(a, k) + g[a][k] * form_with(b, k)).sum::<f64>();
                    covariance[a * all + b] = entry;
                    covariance[b * all + a] = entry;
                }
            }
            let mut mean: Vec<f64> = (0..all).map(|a| of_form[a] + dot(&g[a], &member.mean_of_globals)).collect();
            // d_a F_m
            let form_with_flat = |flat: &PreparedFlat, a: usize, m: usize| {
                let (of, l) = rows[a];
                h(of) * flat.bf[l * n + m] + dot(&r[a * count..][..count], &flat.residual[m])
            };
            // v_a F_m, v_a without the part F_l
            let with_flat = |flat: &PreparedFlat, a: usize, m: usize| {
                form_with_flat(flat, a, m) + dot(&g[a][..globals], &flat.ef[m][..globals])
            };
            if let Some(flat) = &member.flat {
                mean.iter_mut().zip(&rows).for_each(|(mean, (_, load))| *mean += flat.mean[*load]);
                for (e, entry) in covariance.iter_mut().enumerate() {
                    let (a, b) = (e / all, e % all);
                    let (l, m) = (rows[a].1, rows[b].1);
                    *entry += with_flat(flat, a, m) + with_flat(flat, b, l) + flat.ff[l * n + m];
                }
            }
            let flat = member.flat.as_ref();
            let of_global = |k: usize| {
                let of_flat = |l: usize| flat.map_or(0.0, |flat| flat.ef[l][k]);
                let of_globals = |a: usize| (0..globals).map(|j| g[a][j] * member.ee[j][k]).sum::<f64>();
                let with = (0..all).map(|a| of_globals(a) + form_with(a, k) + of_flat(rows[a].1)).collect();
                (with, vec![member.ee[k][k]])
            };
            // Covariances of v_a with the known unknown, and of the latter.
            let given: Option<(Vec<f64>, Vec<f64>)> = match known {
                Some(Unknown::Form) => {
                    let with = |a: usize, b: usize| {
                        let of_globals: f64 = (0..globals).map(|k| g[a][k] * form_with(b, k)).sum();
                        let of_flat = flat.map_or(0.0, |flat| form_with_flat(flat, b, rows[a].1));
                        unknown_form(a, b) + of_globals + of_flat
                    };
                    let matrix =
                        |of: &dyn Fn(usize, usize) -> f64| (0..all * all).map(|e| of(e / all, e % all)).collect();
                    Some((matrix(&with), matrix(&unknown_form)))
                }
                Some(Unknown::Flat) => flat.map(|flat| {
                    let with = |e: usize| with_flat(flat, e / n, e % n) + flat.ff[rows[e / n].1 * n + e % n];
                    ((0..all * n).map(with).collect(), flat.ff.clone())
                }),
                Some(Unknown::Modulus) => Some(of_global(0)),
                Some(Unknown::LocalLaw) => (globals == GLOBALS).then(|| of_global(1)),
                None => None,
            };
            if let Some((with, given)) = given {
                covariance = conditional(&covariance, &with, &given);
            }
            Component { form: member.member.form, weight: member.member.weight, mean, covariance }
        };
        Distribution { components: self.members.iter().map(component).collect() }
    }

    /// Predicts a sample of `candidate`, including its dimension shifts and covariance.
    pub fn of(&self, candidate: &Candidate<'_>) -> Distribution {
        self.predicted(&[*candidate], None).with(candidate.covariance)
    }

    /// Predicts a sample of `candidate` if `known` were exactly what it is expected to be.
    pub fn of_known(&self, candidate: &Candidate<'_>, known: Unknown) -> Distribution {
        self.predicted(&[*candidate], Some(known)).with(candidate.covariance)
    }

    /// Predicts `samples` of one disc, which share its scatter and the errors of the material; values are sorted by
    /// sample, then by load. Marginals equal those of [`Self::of`].
    pub fn on_one_disc(&self, samples: &[Candidate<'_>]) -> Distribution {
        let (n, all) = (self.loads.len(), samples.len() * self.loads.len());
        let factor = |of: &Candidate<'_>| {
            if of.covariance.is_empty() { vec![0.0; n * n] } else { covariance_factor(of.covariance, n) }
        };
        let factors: Vec<f64> = samples.iter().flat_map(factor).collect();
        let row = |row: usize| &factors[row * n..][..n];
        let shared: Vec<f64> = (0..all * all).map(|entry| dot(row(entry / all), row(entry % all))).collect();
        self.predicted(samples, None).with(&shared)
    }
}

impl Component {
    /// Minimum over the loads of the probability between `lower` and `upper`: an upper bound of the joint probability.
    pub(crate) fn most_within(&self, lower: &[f64], upper: &[f64]) -> f64 {
        let n = self.mean.len();
        let within = |load: usize| {
            let std = self.covariance[load * n + load].max(1e-300).sqrt();
            let below = |end: f64| tabulated_normal_probability((end - self.mean[load]) / std);
            below(upper[load]) - below(lower[load])
        };
        (0..n).map(within).fold(1.0, f64::min)
    }
}

impl Distribution {
    /// Number of predicted values: loads, times samples in a joint prediction.
    pub fn loads(&self) -> usize {
        self.components.first().map_or(0, |component| component.mean.len())
    }

    /// Adds a `covariance`, loads x loads, for example that from the tolerances of a sample's dimensions.
    #[must_use]
    pub fn with(mut self, covariance: &[f64]) -> Self {
        for component in &mut self.components {
            component.covariance.iter_mut().zip(covariance).for_each(|(own, further)| *own += further);
        }
        self
    }

    /// Mean and standard deviation of the log ratio at the load with index `load`.
    pub fn moments(&self, load: usize) -> (f64, f64) {
        let n = self.loads();
        let mean: f64 = self.components.iter().map(|of| of.weight * of.mean[load]).sum();
        let spread = |of: &Component| of.covariance[load * n + load] + (of.mean[load] - mean).powi(2);
        (mean, self.components.iter().map(|of| of.weight * spread(of)).sum::<f64>().sqrt())
    }

    /// Probability of a log ratio below `value` at the load with index `load`.
    pub fn probability_below(&self, load: usize, value: f64) -> f64 {
        let below = |[weight, mean, std]: [f64; 3]| {
            let below = if std > 0.0 {
                normal_probability((value - mean) / std)
            } else if mean < value {
                1.0
            } else {
                0.0
            };
            weight * below
        };
        self.at_load(load).into_iter().map(below).sum()
    }

    /// Quantile `p` (0 to 1) of the log ratio at the load with index `load`.
    pub fn quantile(&self, load: usize, p: f64) -> f64 {
        mixture_quantile(&self.at_load(load), p)
    }

    /// Weight, mean and standard deviation of each component at the load with index `load`.
    fn at_load(&self, load: usize) -> Vec<[f64; 3]> {
        let n = self.loads();
        let of = |of: &Component| [of.weight, of.mean[load], of.covariance[load * n + load].max(0.0).sqrt()];
        self.components.iter().map(of).collect()
    }

    /// Whether the median lies between `lower` and `upper` at every load.
    pub fn has_medians_within(&self, lower: &[f64], upper: &[f64]) -> bool {
        (0..self.loads()).all(|load| {
            self.probability_below(load, lower[load]) <= 0.5 && self.probability_below(load, upper[load]) >= 0.5
        })
    }

    /// Median of the log ratio at each load.
    pub fn medians(&self) -> Vec<f64> {
        (0..self.loads()).map(|load| self.quantile(load, 0.5)).collect()
    }

    /// Draws log ratios, one per load, from the component that the standard normal deviate `which` selects, with the
    /// independent deviates `z`, one per load. Draws check probabilities and quantiles independently.
    pub fn draw(&self, which: f64, z: &[f64]) -> Vec<f64> {
        let (n, share, mut reached) = (self.loads(), normal_probability(which), 0.0);
        let is_picked = |of: &&Component| {
            reached += of.weight;
            share <= reached
        };
        let Some(picked) = self.components.iter().find(is_picked).or(self.components.last()) else { return Vec::new() };
        let factor = covariance_factor(&picked.covariance, n);
        (0..n).map(|load| picked.mean[load] + dot(&factor[load * n..][..=load], z)).collect()
    }

    /// Mean, one per load, and covariance, loads x loads, of the whole mixture.
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
