//! Trials: samples that were cut and measured, and the discrepancy learned from them.

use slipgrid_base::monitor::{Monitor, Part};
use slipgrid_base::units::{counted, tidy};
use slipgrid_model::material::AreaLaw;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::Dimension;
use slipgrid_surface::contact::AreaPoint;

use crate::calibrate::patterned_samples::{Model, Pair, Sensitive, pair_measurements};
use crate::calibrate::{CalibrationError, CalibrationTask, CutSample, LandEffect};
use crate::discrepancy::{Conditions, DimensionShift, Discrepancy, Features, Load, Measured, Sensitivity, Trial};

/// Discrepancy learned from a calibration's samples, and modelled ratios of pending samples.
#[derive(Clone, Debug, PartialEq)]
pub struct Learned {
    /// Posterior of the discrepancy, the logarithm of the measured over the modelled ratio.
    pub discrepancy: Discrepancy,
    /// Warnings about samples that are not modelled like designs, one sentence each.
    pub warnings: Vec<String>,
    /// Effects of the slope of the land on modelled ratios, for measured samples whose land was compared with the flat
    /// sample.
    pub lands: Vec<LandEffect>,
    /// Samples that were cut and not yet measured, modelled at the conditions of the flat sample, if they were asked
    /// for; their measured ratios have no meaning.
    pub pending: Vec<Trial>,
}

/// A cut sample with its measured and modelled ratios.
pub(super) struct ModelledTrial {
    pub trial: Trial,
    /// Warning if the sample is not modelled like designs.
    pub warning: Option<String>,
    /// Effect of the sample's land on the modelled ratios, if known.
    pub land: Option<LandEffect>,
}

/// Learns the discrepancy from the samples of `task`. `law` has the area law, and the contact area from which it is
/// computed if it depends on Young's modulus (empty otherwise). Without samples the result is the prior.
///
/// # Errors
/// [`CalibrationError`] if a scene or the discrepancy is invalid, or the monitor cancels.
pub fn learn(
    task: &CalibrationTask,
    law: (Option<&AreaLaw>, &[AreaPoint]),
    monitor: &dyn Monitor,
) -> Result<Learned, CalibrationError> {
    let measured: Vec<&CutSample> = task.trials.samples.iter().filter(|sample| !sample.measured.is_empty()).collect();
    let monitor = Part::new(monitor, 1.0 / measured.len().max(1) as f64);
    let (mut trials, mut warnings, mut lands) = (Vec::new(), Vec::new(), Vec::new());
    for sample in measured {
        let found = trial(task, sample, law, &monitor)?;
        trials.push(found.trial);
        warnings.extend(found.warning);
        lands.extend(found.land);
    }
    // As for designs: ratios depend on the modulus through the area law only.
    let (_, curve) = law;
    let modulus = if curve.is_empty() { 0.0 } else { tidy(task.modulus_relative_std().unwrap_or(0.0)) };
    let discrepancy = Discrepancy::new(task.trials.prior.clone(), conditions(task), modulus, trials);
    let discrepancy = discrepancy.map_err(CalibrationError::Trials)?;
    Ok(Learned { discrepancy, warnings, lands, pending: Vec::new() })
}

/// Memory, in bytes, for the strips of the largest measured sample of `task`; samples are modelled one after the other.
///
/// # Errors
/// [`CalibrationError`] if a sample is invalid or needs more memory than available.
pub fn sample_bytes(task: &CalibrationTask) -> Result<f64, CalibrationError> {
    let law = (None, &[][..]);
    let mut most = 0.0_f64;
    for cut in task.trials.samples.iter().filter(|sample| !sample.measured.is_empty()) {
        let model = Model { task, law, pattern: cut.pattern, relief: cut.relief.clone(), specimen: cut.specimen };
        most = most.max(model.face_bytes(&pair_measurements(task, &cut.measured))?);
    }
    Ok(most)
}

/// Reference values of the discrepancy, from the measurements on flat samples: mean and lowest pressure, and geometric
/// mean of the speeds.
fn conditions(task: &CalibrationTask) -> Conditions {
    let usual = Conditions::default();
    let count = task.flat.len();
    if count == 0 {
        return usual;
    }
    let pressures = || task.flat.iter().map(|measured| task.pressure_pa(measured));
    let speeds = task.flat.iter().map(|measured| measured.speed_m_s.ln());
    Conditions {
        reference_pressure_pa: tidy(pressures().sum::<f64>() / count as f64),
        lowest_pressure_pa: tidy(pressures().fold(f64::INFINITY, f64::min)),
        reference_speed_m_s: tidy((speeds.sum::<f64>() / count as f64).exp()),
    }
}

/// Models a measured sample; measured and modelled ratios are rounded as in a material file.
///
/// A modelled ratio depends on local friction by a thousandth at most. In three dimensions, where one load takes a
/// tenth of a second, it is solved for the lowest and highest flat friction at each force and interpolated, with an
/// error of 5e-5. In two-dimensional models it is solved for every flat friction.
///
/// The correction from steady to dynamic sliding is included, as in the confirmed ratios of designs. Otherwise it would
/// become part of the discrepancy and would be counted twice in designs.
pub(super) fn trial(
    task: &CalibrationTask,
    cut: &CutSample,
    law: (Option<&AreaLaw>, &[AreaPoint]),
    monitor: &dyn Monitor,
) -> Result<ModelledTrial, CalibrationError> {
    let axes: Vec<usize> = (0..3).filter(|axis| cut.dimensions_std_m[*axis] > 0.0).collect();
    let monitor = Part::new(monitor, 1.0 / (2 + axes.len()) as f64);
    let model = |pattern: Pattern| Model { task, law, pattern, relief: cut.relief.clone(), specimen: cut.specimen };
    let pairs = pair_measurements(task, &cut.measured);
    let is_cheap = Dimension::of(None, cut.pattern.texture()).is_cheap_per_design();
    // Ratios of other pairs are interpolated.
    let solved = if is_cheap { pairs.clone() } else { extreme_pairs(&pairs) };
    let (steady, added) = rayon::join(
        || model(cut.pattern).sensitive_ratios(&solved, &monitor),
        || model(cut.pattern).time_changes(&pairs, &Part::new(&monitor, 0.0)),
    );
    let ((steady, on_face), added) = (steady?, added?);
    let all: Vec<Sensitive> = pairs.iter().map(|pair| between(&solved, pair, |place| steady[place])).collect();
    let ratios: Vec<f64> = all.iter().map(|known| known.map_or(1.0, |[ratio, _]| ratio)).collect();
    let share = |made: &Pattern| on_face.as_ref().map_or(1.0, |on_face| on_face.share(made));
    let face_share = share(&cut.pattern);
    let by_local_law = model(cut.pattern).local_law_changes(&pairs, (&ratios, face_share))?;
    let known = pairs.iter().zip(all).zip(&added.at).zip(by_local_law);
    let known = known.filter_map(|(((pair, known), added), local_law)| {
        let [ratio, modulus] = known?;
        Some((pair, ratio, Sensitivity { modulus, local_law }, *added))
    });
    let known: Vec<(&Pair, f64, Sensitivity, f64)> = known.collect();
    let mut dimension_shifts = Vec::new();
    for axis in axes {
        let lengths_m = cut.pattern.lengths_m();
        // One standard error upwards: a cavity with a rough edge is more likely too large than too small.
        let [width_m, spacing_m, depth_m] = std::array::from_fn(|other| {
            lengths_m[other] + if other == axis { cut.dimensions_std_m[axis] } else { 0.0 }
        });
        let Ok(moved) = Pattern::new(*cut.pattern.texture(), width_m, spacing_m, depth_m) else { continue };
        let others = model(moved).ratios(&solved, on_face.as_ref(), &monitor)?;
        let change = |(pair, own, _, added): &(&Pair, f64, Sensitivity, f64)| {
            let [other] = between(&solved, pair, |place| Some([others[place]?]))?;
            Some(tidy(((other + added) / (own + added)).ln()))
        };
        let log_ratio = known.iter().map(change).collect::<Option<Vec<f64>>>();
        let above = tidy_features(&moved, share(&moved));
        dimension_shifts.extend(log_ratio.map(|log_ratio| DimensionShift { log_ratio, above, below: None }));
    }
    // d ln (r + a) = r / (r + a) d ln r
    let measured = known.iter().map(|([flat, patterned], steady, sensitivity, added)| Measured {
        load: Load {
            pressure_pa: tidy(task.pressure_pa(flat)),
            speed_m_s: tidy(flat.speed_m_s),
            humidity: tidy(flat.humidity),
        },
        measured: tidy(patterned.mu_dynamic / flat.mu_dynamic),
        modelled: tidy(steady + added),
        patterned_std: tidy(patterned.mu_dynamic_std / patterned.mu_dynamic),
        flat_std: tidy(flat.mu_dynamic_std / flat.mu_dynamic),
        sensitivity: Sensitivity {
            modulus: tidy(sensitivity.modulus * steady / (steady + added)),
            local_law: tidy(sensitivity.local_law * steady / (steady + added)),
        },
    });
    let (mut measured, features) = (measured.collect::<Vec<Measured>>(), tidy_features(&cut.pattern, face_share));
    // A measured law holds for the flat sample's land alone.
    let law = law.0.filter(|_| !law.1.is_empty());
    let land = cut
        .land
        .zip(law)
        .map(|(land, law)| land.apply(&cut.name, law, &mut measured, (&mut dimension_shifts, features)));
    let warning = added.unknown.map(|unknown| format!("trial \"{}\": {unknown}", cut.name));
    let trial = Trial {
        name: cut.name.clone(),
        features,
        sample_std: cut.sample_std,
        disc: cut.disc.clone(),
        measured,
        dimensions_std_m: cut.dimensions_std_m.map(tidy),
        dimension_shifts,
    };
    Ok(ModelledTrial { trial, warning, land })
}

/// Features of `pattern`, rounded as in a material file.
fn tidy_features(pattern: &Pattern, face_share: f64) -> Features {
    let features = Features::from(pattern);
    Features {
        areal_density: tidy(features.areal_density),
        edge_1_m: tidy(features.edge_1_m),
        width_m: tidy(features.width_m),
        pitch_m: tidy(features.pitch_m),
        depth_m: tidy(features.depth_m),
        face_share: tidy(face_share),
    }
}

/// Note on the trials for the material; `None` without measured trials.
pub(crate) fn note(learned: &Discrepancy) -> Option<String> {
    let ratios: usize = learned.trials().iter().map(|trial| trial.measured.len()).sum();
    (ratios > 0).then(|| {
        format!(
            "trials: {} of {}; [learned] keeps what they say of the model apart from the physics",
            counted(ratios, "measured ratio"),
            counted(learned.trials().len(), "sample")
        )
    })
}

/// Pairs with the lowest and highest flat friction at each force.
fn extreme_pairs(pairs: &[Pair]) -> Vec<Pair> {
    let mut extreme: Vec<Pair> = Vec::new();
    for [flat, _] in pairs {
        if extreme.iter().any(|[own, _]| own.force_n == flat.force_n) {
            continue;
        }
        let mut alike: Vec<&Pair> = pairs.iter().filter(|[other, _]| other.force_n == flat.force_n).collect();
        alike.sort_by(|a, b| a[0].mu_dynamic.total_cmp(&b[0].mu_dynamic));
        let (least, most) = (*alike[0], *alike[alike.len() - 1]);
        extreme.push(least);
        extreme.extend((most[0].mu_dynamic > least[0].mu_dynamic).then_some(most));
    }
    extreme
}

/// Values for `pair`, interpolated linearly in flat friction between the `solved` pairs at its force; `at` gives the
/// values of a solved pair by index. `None` if `at` has no values for a required pair.
fn between<const N: usize>(solved: &[Pair], pair: &Pair, at: impl Fn(usize) -> Option<[f64; N]>) -> Option<[f64; N]> {
    if let Some(place) = solved.iter().position(|own| own == pair) {
        return at(place);
    }
    let [flat, _] = pair;
    let first = solved.iter().position(|[own, _]| own.force_n == flat.force_n)?;
    let least = at(first)?;
    let Some([most, _]) = solved.get(first + 1).filter(|[most, _]| most.force_n == flat.force_n) else {
        return Some(least);
    };
    let from = solved[first][0].mu_dynamic;
    let t = (flat.mu_dynamic - from) / (most.mu_dynamic - from);
    let greatest = at(first + 1)?;
    Some(std::array::from_fn(|value| least[value] + t * (greatest[value] - least[value])))
}

#[cfg(test)]
pub(super) mod tests;
