//! Alternative to the area law: local friction mu depends on local pressure p as measured flat friction depends on
//! nominal pressure P, mu(p) = mu_flat(P = p).

use slipgrid_model::material::{AreaLaw, Extrapolation};
use slipgrid_model::pattern::Pattern;

use super::model::{Body, Case, predict};
use super::ratios::{MeasuredLawRatio, Pair};
use crate::Failure;
use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_infer::calibrate::Measurement;
use slipgrid_io::formats::calibration::Calibration;

/// Modelled ratios of `pattern` at each of `pairs`, with the flat measurements at the speed and humidity of the pair as
/// the local law. Returns one list per pair, with one entry per extrapolation of the law beyond the measured pressures;
/// a list is empty if these measurements have a single pressure.
///
/// # Errors
/// [`Failure`] if the numbers make no valid scene.
pub fn ratios(
    calibration: &Calibration,
    body: Body<'_>,
    pattern: Pattern,
    pairs: &[Pair],
    monitor: &dyn Monitor,
) -> Result<Vec<Vec<MeasuredLawRatio>>, Failure> {
    // The law does not depend on the modulus.
    let body = Body { modulus_relative_std: None, ..body };
    let mut found: Vec<Vec<MeasuredLawRatio>> = vec![Vec::new(); pairs.len()];
    let progress = Stage::new(monitor, "measured law", None);
    let mut rest: Vec<usize> = (0..pairs.len()).collect();
    while let Some(&first) = rest.first() {
        let flat = &pairs[first].flat;
        let own: Vec<usize>;
        (own, rest) = rest.into_iter().partition(|&other| pairs[other].flat.has_condition_of(flat));
        let laws = laws(calibration, flat);
        let alike: Vec<Pair> = own.iter().map(|&row| pairs[row]).collect();
        let cases: Vec<Case<'_>> = laws.iter().map(|(_, law)| Case { pattern, law: Some(law) }).collect();
        for ((extrapolation, _), predicted) in laws.iter().zip(predict(body, &cases, &alike, &progress)?) {
            for (&row, prediction) in own.iter().zip(predicted) {
                found[row].push(MeasuredLawRatio {
                    extrapolation: extrapolation.name(),
                    ratio_groove: prediction.outcome.ratio,
                    ratio_square: prediction.squares.ratio,
                });
            }
        }
    }
    progress.finish();
    Ok(found)
}

/// Local laws from the flat measurements at the speed and humidity of `measured`, one per extrapolation beyond the
/// measured pressures; empty if these measurements have a single pressure.
fn laws(calibration: &Calibration, measured: &Measurement) -> Vec<(Extrapolation, AreaLaw)> {
    let mut rows: Vec<[f64; 2]> = calibration
        .stated
        .flat
        .iter()
        .filter(|other| other.has_condition_of(measured))
        .map(|other| [calibration.pressure_pa(other.force_n), other.mu_dynamic])
        .collect();
    rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let (pressures_pa, mu): (Vec<f64>, Vec<f64>) = rows.into_iter().map(|[p, mu]| (p, mu)).unzip();
    if pressures_pa.len() < 2 {
        return Vec::new();
    }
    let law =
        |extrapolation| Some((extrapolation, AreaLaw::from_flat_friction(&pressures_pa, &mu, extrapolation).ok()?));
    Extrapolation::ALL.into_iter().filter_map(law).collect()
}
