//! Means and standard deviations over the repeats of a condition.

use slipgrid_base::statistics::{Confidence, mean_and_std};

use super::{TraceFindings, TracePeak};

/// Minimum deviation of an odd (outlying) repeat from the mean of the other repeats, relative to this mean. Friction
/// scatters by some per cent.
const MIN_ODD_DEVIATION: f64 = 0.05;
/// Minimum difference of two repeats, relative to their mean, that is reported. Two repeats do not show which of them
/// is odd.
const MIN_PAIR_DIFFERENCE: f64 = 0.1;
/// Number of standard errors that a difference between repeats must exceed to count as significant.
const NOISE_STDERRS: f64 = 4.0;
/// Confidence of the prediction interval for another sample.
const PREDICTION_CONFIDENCE: Confidence = Confidence::PERCENT_95;

/// A repeat that differs significantly from the other repeats of its condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OddRepeat {
    /// Index of the repeat, from 0.
    pub index: usize,
    /// Mean dynamic friction of the other repeats.
    pub others: f64,
    /// Deviation of the repeat from `others`, relative to `others`.
    pub relative: f64,
    /// Maximum minus minimum of the other repeats, relative to their mean; `None` if there is only one other repeat.
    pub others_differ: Option<f64>,
}

/// Finds repeats whose dynamic friction differs from that of the other repeats. `values` are pairs of dynamic friction
/// and its standard error, one per repeat.
///
/// Among three or more repeats, a repeat is odd if it lies outside the 95 % prediction interval of the other repeats
/// (Student's t), and also differs from the mean of the other repeats by more than 5 % and by more than noise. Of two
/// repeats the second is returned if they differ by more than 10 % of their mean and by more than noise. A single
/// repeat is never odd.
pub fn odd_repeats(values: &[(f64, f64)]) -> Vec<OddRepeat> {
    let odd = |index: usize| {
        let (mu, error) = values[index];
        let others: Vec<(f64, f64)> =
            values.iter().enumerate().filter(|(i, _)| *i != index).map(|(_, value)| *value).collect();
        let count = others.len() as f64;
        let (mean, std) = mean_and_std(others.iter().map(|(mu, _)| *mu))?;
        let noise =
            (error * error + others.iter().map(|(_, error)| error * error).sum::<f64>() / (count * count)).sqrt();
        let distance = (mu - mean).abs();
        let allowed = match std {
            None => MIN_PAIR_DIFFERENCE * (mu + mean).abs() / 2.0,
            Some(std) => {
                let expected = Confidence::PERCENT_95.student_t(others.len() - 1) * std * (1.0 + 1.0 / count).sqrt();
                expected.max(MIN_ODD_DEVIATION * mean.abs())
            }
        };
        let [lowest, highest] = [f64::min as fn(f64, f64) -> f64, f64::max]
            .map(|extreme| others.iter().map(|(mu, _)| *mu).reduce(extreme).unwrap_or(mean));
        (distance > allowed.max(NOISE_STDERRS * noise)).then(|| OddRepeat {
            index,
            others: mean,
            relative: mu / mean - 1.0,
            others_differ: std.map(|_| (highest - lowest) / mean),
        })
    };
    let first = usize::from(values.len() == 2);
    (first..values.len()).filter_map(odd).collect()
}

/// Mean and standard deviation of repeats.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanStd {
    /// Mean of the repeats.
    pub mean: f64,
    /// Standard deviation between repeats (n - 1 in the denominator), at least the standard error within a repeat.
    pub std: f64,
    /// Degrees of freedom of `std`: n - 1, plus those that [`moderate`] adds. 0 for a single repeat, whose scatter is
    /// not known.
    pub freedom: usize,
}

impl MeanStd {
    /// Standard deviation for the prediction of another sample from n = `count` repeats with the standard deviation s =
    /// `std` and nu = `freedom`. A normal distribution with this standard deviation has the 95 % interval of Student's
    /// t:
    ///
    /// ```text
    /// s sqrt(1 + 1/n) t_95(nu) / 1.96
    /// ```
    ///
    /// t_95(nu) is the quantile of Student's t for the 95 % interval. Without degrees of freedom t_95 is undefined, and
    /// the factor t_95 / 1.96 is left out; the result is then a lower bound.
    pub fn predictive_std(&self, count: usize) -> f64 {
        let student = if self.freedom == 0 {
            1.0
        } else {
            PREDICTION_CONFIDENCE.student_t(self.freedom) / PREDICTION_CONFIDENCE.student_t(usize::MAX)
        };
        self.std * (1.0 + 1.0 / count as f64).sqrt() * student
    }
}

/// Results of the repeats of one condition.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Repeats {
    /// Number of repeats.
    pub count: usize,
    /// Dynamic friction.
    pub mu_dynamic: MeanStd,
    /// Static friction, with the scatter of repeats only; `None` unless every repeat shows a peak.
    pub mu_static: Option<MeanStd>,
    /// Standard deviation of the part of the peaks that sampling may have missed, in addition to the scatter; `None`
    /// unless every repeat shows a peak.
    pub mu_static_missed: Option<f64>,
    /// Number of repeats that show a static peak.
    pub peaks: usize,
    /// Number of repeats that show stick-slip.
    pub stick_slips: usize,
    /// Mean over the repeats of the normal force in the window, in newtons.
    pub normal_force_n: f64,
}

impl Repeats {
    /// Standard deviation for predicting the dynamic friction of another sample; see [`MeanStd::predictive_std`].
    pub fn mu_dynamic_predictive_std(&self) -> f64 {
        self.mu_dynamic.predictive_std(self.count)
    }

    /// Standard deviation for predicting the static friction of another sample, including the part of peaks that
    /// sampling may have missed; `None` unless every repeat shows a peak.
    pub fn mu_static_predictive_std(&self) -> Option<f64> {
        Some(self.mu_static?.predictive_std(self.count).hypot(self.mu_static_missed?))
    }
}

/// Averages repeats; `None` for an empty slice. For a single repeat the standard deviation is the standard error of its
/// mean.
pub fn average(repeats: &[TraceFindings]) -> Option<Repeats> {
    let count = repeats.len();
    if count == 0 {
        return None;
    }
    let dynamic: Vec<(f64, f64)> = repeats.iter().map(|found| (found.window.mu, found.window.stderr)).collect();
    let peaks: Vec<TracePeak> = repeats.iter().filter_map(|found| found.static_peak).collect();
    Some(Repeats {
        count,
        mu_dynamic: mean_std(&dynamic),
        mu_static: (peaks.len() == count)
            .then(|| mean_std(&peaks.iter().map(|peak| (peak.mu, peak.noise)).collect::<Vec<_>>())),
        mu_static_missed: (peaks.len() == count).then(|| missed(&peaks)),
        peaks: peaks.len(),
        stick_slips: repeats.iter().filter(|found| found.stick_slip.is_some()).count(),
        normal_force_n: repeats.iter().map(|found| found.normal_force_n).sum::<f64>() / count as f64,
    })
}

/// Maximum number of degrees of freedom that the scatter of other conditions adds.
const MAX_PRIOR_FREEDOM: usize = 4;

/// Shrinks the standard deviation at each condition toward the relative scatter of the other conditions, for dynamic
/// and for static friction:
///
/// ```text
/// s^2 = (nu_0 (s_0 mu)^2 + nu s_own^2) / (nu_0 + nu),   nu = n - 1,   s_0^2 = sum nu_j (s_j/mu_j)^2 / sum nu_j over the others
/// ```
///
/// with the mean friction mu, the standard deviation s_own and the number n of repeats of a condition, sums over the
/// other conditions j, and nu_0 = sum nu_j, at most four (moderated variances as in G. K. Smyth, Stat. Appl. Genet.
/// Mol. Biol. 3, 3, 2004). Two or three repeats may agree by chance, and a fit weighted by 1/s^2 would then treat such
/// a condition as nearly exact. The standard deviation of a single repeat, which says nothing about scatter, is never
/// lowered. The degrees of freedom become nu_0 + nu.
pub fn moderate(conditions: &mut [&mut Repeats]) {
    shrink_deviations(conditions.iter_mut().map(|repeats| &mut repeats.mu_dynamic).collect());
    shrink_deviations(conditions.iter_mut().filter_map(|repeats| repeats.mu_static.as_mut()).collect());
}

fn shrink_deviations(mut all: Vec<&mut MeanStd>) {
    let known: Vec<(usize, f64)> =
        all.iter().map(|one| (one.freedom, one.freedom as f64 * (one.std / one.mean).powi(2))).collect();
    for (place, one) in all.iter_mut().enumerate() {
        let others = known.iter().enumerate().filter(|(other, _)| *other != place);
        let (freedom, squares) =
            others.fold((0, 0.0), |(freedom, squares), (_, known)| (freedom + known.0, squares + known.1));
        if freedom == 0 {
            continue;
        }
        let (prior, own) = (freedom.min(MAX_PRIOR_FREEDOM), known[place].0);
        let pooled = squares / freedom as f64 * one.mean * one.mean;
        let moderated = ((prior as f64 * pooled + own as f64 * one.std * one.std) / (prior + own) as f64).sqrt();
        one.std = if own > 0 { moderated } else { moderated.max(one.std) };
        one.freedom = prior + own;
    }
}

/// Mean and standard deviation of pairs of a value and its standard error.
fn mean_std(values: &[(f64, f64)]) -> MeanStd {
    let count = values.len() as f64;
    let (mean, between) = mean_and_std(values.iter().map(|(value, _)| *value)).unwrap_or((f64::NAN, None));
    let within = (values.iter().map(|(_, error)| error * error).sum::<f64>() / count).sqrt();
    MeanStd { mean, std: between.unwrap_or(0.0).max(within), freedom: values.len().saturating_sub(1) }
}

/// Standard deviation of the part of `peaks` that sampling may have missed. Sampling reads every peak too low; with a
/// triggered recording it misses an equal part in each repeat, so that the scatter does not show it. The missed part of
/// several repeats is taken as uniformly distributed.
fn missed(peaks: &[TracePeak]) -> f64 {
    if let [peak] = peaks {
        return peak.missed;
    }
    let missed = peaks.iter().map(|peak| peak.missed).sum::<f64>() / peaks.len() as f64;
    // Uniform distribution from 0 to `missed`.
    missed / 12.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_base::statistics::Noise;

    fn of(count: usize, mean: f64, std: f64) -> Repeats {
        let mu_dynamic = MeanStd { mean, std, freedom: count - 1 };
        Repeats {
            count,
            mu_dynamic,
            mu_static: None,
            mu_static_missed: None,
            peaks: 0,
            stick_slips: 0,
            normal_force_n: 1.0,
        }
    }

    /// Repeats, `count` of them, each drawn by `sample`.
    fn drawn(count: usize, mut sample: impl FnMut() -> f64) -> Repeats {
        let values: Vec<(f64, f64)> = (0..count).map(|_| (sample(), 1e-5)).collect();
        let MeanStd { mean, std, .. } = mean_std(&values);
        of(count, mean, std)
    }

    #[test]
    fn scatter_is_drawn_toward_that_of_other_conditions() {
        let moderated = |mut all: Vec<Repeats>| {
            moderate(&mut all.iter_mut().collect::<Vec<_>>());
            all.into_iter().map(|repeats| repeats.mu_dynamic.std).collect::<Vec<f64>>()
        };
        // nu_0 = 2 from the others, both with 1 % of friction; nu = 1.
        let found = moderated(vec![of(2, 0.3, 0.0), of(2, 0.3, 0.003), of(2, 0.2, 0.002)]);
        assert!((found[0] - (2.0 * 0.003_f64.powi(2) / 3.0).sqrt()).abs() < 1e-15, "{found:?}");
        // nu_0 is limited to four of nine.
        let found = moderated(vec![of(3, 0.3, 0.006), of(10, 0.3, 0.003)]);
        assert!((found[0] - ((4.0 * 0.003_f64.powi(2) + 2.0 * 0.006_f64.powi(2)) / 6.0).sqrt()).abs() < 1e-15);
        // A single repeat has no scatter, and a single condition has no other to learn from.
        let found = moderated(vec![of(1, 0.3, 0.001), of(3, 0.3, 0.003), of(1, 0.3, 0.004)]);
        assert!((found[0] - 0.003).abs() < 1e-15 && found[2] == 0.004, "{found:?}");
        assert_eq!(moderated(vec![of(2, 0.3, 0.0)]), [0.0]);
        assert_eq!(moderated(vec![of(1, 0.3, 0.001), of(1, 0.2, 0.002)]), [0.001, 0.002]);
    }

    /// Means weighted by 1/s^2 over five conditions with an equal truth. Without pooling, the stated errors from two
    /// repeats had a coverage of one half.
    #[test]
    fn means_of_few_repeats_are_as_uncertain_as_they_say() {
        let mut noise = Noise::new(3);
        for count in [2, 3, 5] {
            let mut held = [0, 0];
            for _ in 0..2000 {
                let mut all: Vec<Repeats> =
                    (0..5).map(|_| drawn(count, || 0.3 * (1.0 + 0.01 * noise.normal()))).collect();
                for (place, held) in held.iter_mut().enumerate() {
                    let weights: Vec<f64> = all.iter().map(|of| count as f64 * of.mu_dynamic.std.powi(-2)).collect();
                    let sum: f64 = weights.iter().sum();
                    let mean =
                        all.iter().zip(&weights).map(|(of, weight)| weight * of.mu_dynamic.mean).sum::<f64>() / sum;
                    *held += usize::from((mean - 0.3).abs() < 1.96 / sum.sqrt());
                    if place == 0 {
                        moderate(&mut all.iter_mut().collect::<Vec<_>>());
                    }
                }
            }
            assert!(held[1] > 1660 && held[1] > held[0], "{count} repeats: {held:?}");
        }
    }

    /// Without Student's t and pooling, coverage for another sample is 64 % with two repeats instead of 95 %, 76 % with
    /// three and 86 % with five.
    #[test]
    fn another_sample_is_as_far_from_the_mean_as_it_may_be() {
        let mut noise = Noise::new(17);
        let mut held = |conditions: usize, count: usize| {
            let mut held = [0; 2];
            let runs = 12_000 / conditions;
            for _ in 0..runs {
                let mut sample = || 0.3 * (1.0 + 0.01 * noise.normal());
                let mut all: Vec<Repeats> = (0..conditions).map(|_| drawn(count, &mut sample)).collect();
                let others: Vec<f64> = (0..conditions).map(|_| sample()).collect();
                let within = |of: &Repeats, std: f64, other: f64| (other - of.mu_dynamic.mean).abs() < 1.959_964 * std;
                let plain = all.iter().zip(&others).filter(|(of, other)| within(of, of.mu_dynamic.std, **other));
                held[0] += plain.count();
                moderate(&mut all.iter_mut().collect::<Vec<_>>());
                let told =
                    all.iter().zip(&others).filter(|(of, other)| within(of, of.mu_dynamic_predictive_std(), **other));
                held[1] += told.count();
            }
            held.map(|count| count as f64 / (runs * conditions) as f64)
        };
        for (count, plain) in [(2, 0.64), (3, 0.769), (5, 0.854)] {
            // 12 000 samples determine the coverage to 0.002, or to 0.003 after pooling; for a single condition
            // Student's t is exact.
            let alone = held(1, count);
            assert!((alone[0] - plain).abs() < 0.012 && (alone[1] - 0.95).abs() < 0.008, "{count} repeats: {alone:?}");
            // The other conditions may count for more than the four degrees of freedom that they add.
            let beside = held(5, count);
            assert!(beside[1] > 0.945 && beside[1] < 0.97, "{count} repeats: {beside:?}");
        }
    }

    #[test]
    fn another_sample_needs_the_means_own_error_and_students_t() {
        let two = of(2, 0.3, 0.003);
        assert!((two.mu_dynamic_predictive_std() - 0.003 * 1.5_f64.sqrt() * 12.706_205 / 1.959_964).abs() < 1e-9);
        // The scatter of a single repeat is not known.
        assert!((of(1, 0.3, 0.001).mu_dynamic_predictive_std() - 0.001 * 2.0_f64.sqrt()).abs() < 1e-12);
        let mut all = [of(2, 0.3, 0.003), of(3, 0.3, 0.003), of(1, 0.3, 0.001)];
        moderate(&mut all.iter_mut().collect::<Vec<_>>());
        assert_eq!(all.map(|of| of.mu_dynamic.freedom), [2 + 1, 1 + 2, 3]);
    }

    #[test]
    fn static_friction_scatters_as_that_of_other_conditions_and_keeps_what_sampling_missed() {
        let with = |std: f64, missed: f64| {
            let mu_static = Some(MeanStd { mean: 0.4, std, freedom: 1 });
            Repeats { mu_static, mu_static_missed: Some(missed), ..of(2, 0.3, 0.003) }
        };
        let mut all = [with(0.0, 0.01), with(0.004, 0.0)];
        moderate(&mut all.iter_mut().collect::<Vec<_>>());
        let own = 0.004 / 2.0_f64.sqrt();
        let student = 4.302_653 / 1.959_964 * 1.5_f64.sqrt();
        for (of, missed) in all.iter().zip([0.01, 0.0]) {
            assert!((of.mu_static.unwrap().std - own).abs() < 1e-12 && of.mu_static.unwrap().freedom == 2);
            assert!((of.mu_static_predictive_std().unwrap() - (own * student).hypot(missed)).abs() < 1e-9);
        }
    }

    fn odd(values: &[f64]) -> Vec<usize> {
        let values: Vec<(f64, f64)> = values.iter().map(|mu| (*mu, 3e-4)).collect();
        odd_repeats(&values).iter().map(|odd| odd.index).collect()
    }

    #[test]
    fn a_spoilt_repeat_is_named_and_none_of_like_ones() {
        assert_eq!(odd(&[0.305, 0.308, 0.416]), [2]);
        assert_eq!(odd(&[0.2, 0.305, 0.3, 0.302]), [0]);
        // The others differ by as much among themselves; and a deviation within the scatter of repeats.
        for like in [&[0.30, 0.36, 0.42][..], &[0.3050, 0.3051, 0.3150], &[0.30], &[0.30, 0.32], &[]] {
            assert!(odd(like).is_empty(), "{like:?}");
        }
        assert_eq!(odd(&[0.30, 0.42]), [1]);
        let found = odd_repeats(&[(0.305, 1e-4), (0.308, 1e-4), (0.416, 1e-4)])[0];
        assert!((found.others - 0.3065).abs() < 1e-12 && (found.relative - 0.357_259).abs() < 1e-6, "{found:?}");
        assert!((found.others_differ.unwrap() - 0.009_788).abs() < 1e-6);
        // The deviation is within noise.
        assert!(odd_repeats(&[(0.305, 0.05), (0.308, 0.05), (0.416, 0.05)]).is_empty());
    }

    #[test]
    fn repeats_that_scatter_by_one_or_two_per_cent_are_seldom_odd() {
        let mut noise = Noise::new(11);
        for count in 2..=6 {
            let named = (0..2000)
                .filter(|_| {
                    !odd(&(0..count).map(|_| 0.3 * (1.0 + 0.015 * noise.normal())).collect::<Vec<_>>()).is_empty()
                })
                .count();
            assert!(named < 100, "{count} repeats: {named} of 2000");
        }
    }
}
