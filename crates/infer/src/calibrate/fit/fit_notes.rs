//! Notes and warnings of a fit: methods, undetermined values, and measurements that would determine them.

use slipgrid_base::statistics::extremes;

use super::{Fit, FittedPair, MAX_ROUNDS, Model, SETTLED_CHANGE};
use crate::calibrate::flat_sample::speed_m_s;

/// The area law counts as undetermined if the ends of the interval of its scale differ by more than this factor.
const MAX_SCALE_RATIO: f64 = 3.0;

pub fn notes(model: &Model<'_>, fit: &Fit) -> Vec<String> {
    let Model { problem, layout, corrections, .. } = *model;
    let above_pct = |[least, most]: [f64; 2]| format!("{:.2} to {:.2} %", (least - 1.0) * 100.0, (most - 1.0) * 100.0);
    let over_steady = above_pct(extremes(corrections.delta.iter().copied()));
    let over_law = above_pct(extremes(fit.predictions.iter().map(|predicted| predicted.over_local_law)));
    let mut notes = vec![format!(
        "dynamic_mean: fitted through the spring-block model of the flat sample; its dynamic friction lies {over_steady} above its own steady \
         sliding, and the fit corrects for it. Above mu_d f(P), the steady sliding of an endless sample, it lies {over_law}: that is \
         dynamic_over_steady in the material file, or its mean where that is one number"
    )];
    notes.extend(speed_note(model));
    if layout.fixed_static.iter().any(Option::is_none) {
        notes.push(format!(
            "static_mean: not determined by the data where no static peak was measured; static_mean / dynamic_mean = {:.4} is assumed. A measured peak of friction at the onset of sliding would settle it",
            problem.static_over_dynamic
        ));
    }
    notes.push(scatter_note(model));
    notes.extend(scale_note(fit));
    for parameter in fit.parameters.iter().filter(|parameter| !parameter.std_error.is_finite()) {
        notes.push(format!("{}: not determined by the data; it has no standard error", parameter.name));
    }
    let (chi_square, degrees_of_freedom) = (fit.chi_square, fit.degrees_of_freedom);
    if degrees_of_freedom > 0 {
        notes.push(format!("chi-square {chi_square:.1} for {degrees_of_freedom} degrees of freedom"));
    }
    notes
}

/// Reasons to doubt fitted values.
pub fn warnings(fit: &Fit) -> Vec<String> {
    let mut warnings = Vec::new();
    if !fit.settled {
        warnings.push(format!(
            "the fit did not settle: coefficients still changed by more than {SETTLED_CHANGE} of themselves after {MAX_ROUNDS} rounds, and \
             friction of the flat sample in time may miss what was measured"
        ));
    }
    if fit.is_poor() {
        let share = |pair: &FittedPair| Some(100.0 * pair.dynamic_std_error? / pair.dynamic_mean);
        let error = fit.pairs.first().filter(|_| fit.pairs.len() == 1).and_then(share);
        let counted = error.map_or_else(String::new, |percent| {
            format!("; its standard error, {percent:.1} %, has the scatter of the measurements about it in it")
        });
        warnings.push(format!(
            "one pair of coefficients does not describe these measurements: chi-square is {:.0} for {} degrees of freedom{counted}. Fit \
             coefficients per condition",
            fit.chi_square, fit.degrees_of_freedom
        ));
    }
    for parameter in fit.parameters.iter().filter(|parameter| parameter.at_bound) {
        warnings.push(format!(
            "{}: ended at the bound {:.4}; the data ask for a value beyond it",
            parameter.name, parameter.value
        ));
    }
    warnings
}

/// Note on measurements whose runs are slower than the measured speed; `None` if there are none.
fn speed_note(Model { problem, .. }: &Model<'_>) -> Option<String> {
    let speeds = problem.measurements.iter().map(|measured| (measured.speed_m_s, speed_m_s(problem, measured)));
    let slowed: Vec<(f64, f64)> = speeds.filter(|(measured, run)| run < measured).collect();
    let slowest = slowed.iter().map(|(_, run)| *run).fold(f64::INFINITY, f64::min);
    (!slowed.is_empty()).then(|| {
        format!(
            "speed: {} of {} measurements are faster than the modelled layer slides evenly, 0.01 P / sqrt(E rho); their runs in time are at that \
             speed, {:.3} mm/s at the least, and what time adds to steady sliding is known to about 1 %",
            slowed.len(),
            problem.measurements.len(),
            slowest * 1e3
        )
    })
}

/// Note on the scatter of local coefficients. Repeats give an upper bound: the mean over N independent blocks scatters
/// by s / sqrt(N), with the scatter s of one block.
fn scatter_note(model: &Model<'_>) -> String {
    let problem = model.problem;
    let blocks = problem.layer.columns() as f64;
    let spread = problem.measurements.iter().map(|measured| measured.mu_dynamic_std / measured.mu_dynamic);
    let bound = spread.fold(f64::INFINITY, f64::min) * blocks.sqrt();
    format!(
        "relative_std: not determined by means of friction; {} is assumed. Measurements, where they were repeated, say that it is at most about {bound:.2}: friction is the mean over {blocks} blocks, and a larger scatter would let repeats differ by more. The spread of onset events in a trace would settle it",
        problem.relative_std
    )
}

fn scale_note(fit: &Fit) -> Option<String> {
    let parameter = fit.parameters.iter().find(|parameter| parameter.name == "area_law_scale_pa")?;
    let mpa = |pa: f64| format!("{:.3} MPa", pa * 1e-6);
    let open = "friction over a wider range of loads, or an altitude map of a flat sample, would settle it";
    Some(match parameter.interval {
        [Some(from), Some(to)] if to / from < MAX_SCALE_RATIO => format!(
            "area law: its pressure scale E* h'rms = {} (95 %: {} to {}) is fitted to the fall of flat friction with load, not measured; an altitude map would confirm it",
            mpa(parameter.value),
            mpa(from),
            mpa(to)
        ),
        [Some(from), Some(to)] => format!(
            "area law: its pressure scale is hardly determined by the data (95 %: {} to {}); {open}",
            mpa(from),
            mpa(to)
        ),
        [Some(from), None] => format!(
            "area law: not determined by the data; its pressure scale lies above {} (95 %), and friction proportional to load fits as well; {open}",
            mpa(from)
        ),
        [None, Some(to)] => {
            format!("area law: not determined by the data; its pressure scale lies below {} (95 %); {open}", mpa(to))
        }
        [None, None] => format!("area law: not determined by the data at all; {open}"),
    })
}
