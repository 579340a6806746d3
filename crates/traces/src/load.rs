//! Checks of the normal force of a trace: whether it acts, and whether it agrees with the nominal force.

use std::ops::Range;

use slipgrid_base::units::significant;

use super::breaks::find_break;
use super::time_series::median;
use super::{Tangential, TraceChannels, TraceError, TraceFlag, TraceOptions, UNLOADED_FRACTION};

/// Deviation of the mean normal force from the nominal force, relative to the nominal force: above the first number the
/// force is flagged, above the second it is refused.
const LOAD_TOLERANCES: (f64, f64) = (0.05, 0.5);
/// The normal force is flagged if its standard deviation in the window exceeds this fraction of its mean.
const MAX_LOAD_VARIATION: f64 = 0.05;
/// A column counts as the normal force if its mean is within 10 % of the nominal force.
const FORCE_MATCH_TOLERANCE: f64 = 0.1;
/// Units in which forces are recorded by mistake, with the other cause of the same factor, and the newtons per unit.
const UNITS: [(&str, &str, f64); 5] = [
    ("kN", ", or in N where its title says mN", 1e3),
    ("mN", ", or in N where its title says kN", 1e-3),
    ("kgf", "", 9.806_65),
    ("gf", "", 9.806_65e-3),
    ("uN", "", 1e-6),
];

/// Checks the load. Returns the median absolute normal force in the window, in newtons, and whether the force is
/// recorded as negative.
///
/// # Errors
/// [`TraceError`] if the load is lost within the window, or is far from the nominal force.
pub fn check_load(
    channels: &TraceChannels,
    time_s: &[f64],
    inside: &Range<usize>,
    options: &TraceOptions,
    flags: &mut Vec<TraceFlag>,
) -> Result<(f64, bool), TraceError> {
    let recorded = &channels.normal_force_n[inside.clone()];
    let middle = median(recorded.to_vec());
    let turned = middle < 0.0;
    let median_n = middle.abs();
    let sign = if turned { -1.0 } else { 1.0 };
    let lost = recorded.iter().position(|force| sign * force < UNLOADED_FRACTION * median_n || median_n == 0.0);
    if let Some(i) = lost {
        return Err(TraceError::Refused(format!(
            "the normal force falls to {} N at {:.2} s, of {median_n:.2} N: expected a sample under load",
            recorded[i],
            time_s[inside.start + i]
        )));
    }
    if turned {
        flags.push(TraceFlag::Odd("the normal force is recorded as negative and was turned".to_owned()));
    }
    let count = recorded.len() as f64;
    let broken = find_break(recorded);
    if let Some(found) = broken {
        let time_s = time_s[inside.start + found.at];
        flags.push(TraceFlag::Broken { signal: "the normal force", unit: " N", time_s, found });
    }
    // A disturbed reading says nothing of the load.
    let shift = broken.map_or(0.0, |found| sign * found.shift);
    let mean = recorded.iter().map(|force| sign * force).sum::<f64>() / count - shift;
    if let Some(nominal_n) = options.nominal_force_n {
        let off = (mean / nominal_n - 1.0).abs();
        let likely = likely_cause(&channels.tangential, inside, mean, nominal_n);
        if off > LOAD_TOLERANCES.1 {
            let found_n = significant(mean, 3);
            return Err(TraceError::Refused(format!(
                "the normal force is {found_n} N in the window: expected about {nominal_n} N, as the condition says{likely}"
            )));
        }
        if off > LOAD_TOLERANCES.0 {
            flags.push(TraceFlag::Odd(format!(
                "the normal force is {mean:.2} N, not the nominal {nominal_n} N{likely}"
            )));
        }
    }
    let variance = recorded.iter().map(|force| (sign * force - mean).powi(2)).sum::<f64>() / count;
    let relative_std = variance.sqrt() / mean;
    if relative_std > MAX_LOAD_VARIATION && broken.is_none() {
        flags.push(TraceFlag::Odd(format!("the normal force varies by {:.1} % in the window", 100.0 * relative_std)));
    }
    Ok((median_n, turned))
}

/// Describes the likely cause of a normal force `found_n` instead of `nominal_n`, as the end of a message; empty if no
/// cause is known.
fn likely_cause(tangential: &Tangential, inside: &Range<usize>, found_n: f64, nominal_n: f64) -> String {
    let matches_nominal = |force_n: f64| (force_n / nominal_n - 1.0).abs() <= FORCE_MATCH_TOLERANCE;
    if matches_nominal(found_n) {
        return String::new();
    }
    let friction_n = median(tangential.values()[inside.clone()].iter().map(|force| force.abs()).collect());
    // Dry friction is below the normal force, and the radius of a holder is below 1 m.
    let is_above = friction_n > found_n && (friction_n / nominal_n - 1.0).abs() <= LOAD_TOLERANCES.1;
    if matches_nominal(friction_n) || is_above {
        let channel = tangential.name();
        let unit = match tangential {
            Tangential::TorqueNm(_) => " N m",
            Tangential::ForceN(_) => " N",
            Tangential::Coefficient(_) => "",
        };
        return format!(
            "; the {channel} is {friction_n:.2}{unit}, so that normal force and {channel} are likely in each other's place: titles \
             of their columns, or `columns` in [traces]"
        );
    }
    let mut units = UNITS.into_iter().map(|(unit, or, newtons)| (unit, or, found_n * newtons));
    let unit = units.find(|(.., force_n)| matches_nominal(*force_n));
    unit.map_or_else(String::new, |(unit, or, force_n)| {
        format!("; recorded in {unit}{or}, it would be {force_n:.2} N: its unit stands in its title, as `Fz [{unit}]`")
    })
}
