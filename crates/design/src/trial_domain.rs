//! Aiming with the discrepancy only where it was measured: near the patterns of the calibration's patterned samples, and
//! where the physics alone says that the pattern does something.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_calibrate::{DENSITY_FACTOR, DEPTH_FACTOR, Far, TrialDomain};
use slipgrid_optimize::{Bound, Limit};
use slipgrid_pattern::Pattern;

use crate::constraint_quantities::ConstraintQuantity;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use slipgrid_units::{LENGTH_UM, tidy};

/// Slack of the limits, relative: depths are whole bursts, written in decimals.
const SLACK: f64 = 1e-9;

/// Keeps the search of a `design` that aims with the discrepancy to patterns near those of its trials, whose friction
/// differs from the flat surface's by more than the tolerance by the physics alone.
pub fn keep_near(design: &mut DesignTask, domain: Option<&TrialDomain>) {
    let Some(domain) = domain.filter(|_| design.discrepancy) else { return };
    let is_like = domain.has_planform(design.space.planform());
    let ([least, most], [shallowest_m, deepest_m]) = (domain.areal_density(), domain.depth_m());
    let um = LENGTH_UM.to_si(1.0);
    let mut limit = |measure, name, (unit, unit_si): (&'static str, f64), bound: Bound| {
        let limit = bound.limit();
        let scale = if limit == 0.0 { 1.0 } else { limit };
        design.quantities.push(measure);
        // Nothing is learned of these by relaxing them: the loosest limit is the limit.
        design.constraints.quantities.push(Limit { name, unit, unit_si, bound, scale, loosest: limit });
    };
    let (none, length) = (("", 1.0), ("um", um));
    if !is_like {
        let name = "planform (1 where no trial had it)";
        limit(ConstraintQuantity::OtherPlanform, name, none, Bound::AtMost(0.0));
    }
    let [low, high] = ["areal density (no less than near the trials)", "areal density (no more than near the trials)"];
    limit(ConstraintQuantity::PatternDensity, low, none, Bound::AtLeast(least * (1.0 - SLACK)));
    limit(ConstraintQuantity::PatternDensity, high, none, Bound::AtMost(most * (1.0 + SLACK)));
    let [low, high] = ["depth (no less than near the trials)", "depth (no more than near the trials)"];
    limit(ConstraintQuantity::Depth, low, length, Bound::AtLeast(shallowest_m * (1.0 - SLACK)));
    limit(ConstraintQuantity::Depth, high, length, Bound::AtMost(deepest_m * (1.0 + SLACK)));
    if design.target.has_demands() {
        let name = "effect of the pattern by the physics alone in tolerances";
        limit(ConstraintQuantity::Effect, name, none, Bound::AtLeast(1.0));
    }
}

/// How much a pattern does by the physics alone.
#[derive(Clone, Debug, Default)]
pub struct Effect {
    /// What is accepted at each pressure; absent where nothing is demanded.
    tolerance: Vec<Option<f64>>,
    /// Of each value: the flat surface's, times the discrepancy's factor, and that factor.
    flat: Vec<[f64; 2]>,
}

impl Effect {
    /// Of the values that `model` gives designs of `design`.
    pub fn new(design: &DesignTask, model: &SteadyModel) -> Self {
        Self {
            tolerance: design.target.points().iter().map(|point| point.wanted.tolerance()).collect(),
            flat: (0..design.target.values()).map(|load| [model.scale(load), model.factor(load)]).collect(),
        }
    }

    /// Largest distance from the flat surface over the pressures, in tolerances, by the physics behind `values`; at the
    /// condition where that is least. Infinite where nothing is demanded.
    pub fn of(&self, values: &[f64]) -> f64 {
        let count = self.tolerance.len().max(1);
        let at_condition = |(values, flat): (&[f64], &[[f64; 2]])| {
            let each = values.iter().zip(flat).zip(&self.tolerance);
            // |v / k - flat| / T, where v and k flat are compared with the target
            each.filter_map(|((value, [scale, factor]), tolerance)| {
                Some((value - scale).abs() / factor / (*tolerance)?)
            })
            .reduce(f64::max)
            .unwrap_or(f64::INFINITY)
        };
        values.chunks(count).zip(self.flat.chunks(count)).map(at_condition).fold(f64::INFINITY, f64::min)
    }
}

/// The patterns that a discrepancy is used for, beside the one found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DomainReport {
    /// Planforms of the trials.
    pub planforms: Vec<Cow<'static, str>>,
    /// Least and largest areal density that counts as near, and those of the trials.
    pub areal_density: [f64; 2],
    /// Those of the trials.
    pub trials_areal_density: [f64; 2],
    /// Least and largest depth that counts as near.
    pub depth_um: [f64; 2],
    /// Those of the trials.
    pub trials_depth_um: [f64; 2],
    /// In what the design is far from them; empty where it is near.
    pub far: Vec<Cow<'static, str>>,
}

impl DomainReport {
    /// How near `pattern` is to the trials of `domain`.
    #[must_use]
    pub fn new(domain: &TrialDomain, pattern: &Pattern) -> Self {
        let mut planforms: Vec<Cow<'static, str>> = Vec::new();
        for name in domain.trials().iter().map(|trial| trial.planform.name().into()) {
            if !planforms.contains(&name) {
                planforms.push(name);
            }
        }
        let um = |length_m: f64| tidy(LENGTH_UM.from_si(length_m));
        let ([least, most], [shallowest_m, deepest_m]) = (domain.areal_density(), domain.depth_m());
        let name = |far: Far| match far {
            Far::Planform => "planform".into(),
            Far::ArealDensity => "areal density".into(),
            Far::Depth => "depth".into(),
        };
        Self {
            planforms,
            areal_density: [tidy(least), tidy(most)],
            trials_areal_density: [tidy(least * DENSITY_FACTOR), tidy(most / DENSITY_FACTOR)],
            depth_um: [um(shallowest_m), um(deepest_m)],
            trials_depth_um: [um(shallowest_m * DEPTH_FACTOR), um(deepest_m / DEPTH_FACTOR)],
            far: domain.far(pattern).into_iter().map(name).collect(),
        }
    }

    /// What counts as near, with the numbers of the trials.
    #[must_use]
    pub fn words(&self) -> String {
        let percent = |[from, to]: [f64; 2]| span([100.0 * from, 100.0 * to]);
        format!(
            "{} with an areal density of {} % (the trials: {} %) and a depth of {} um (the trials: {} um)",
            self.planforms.join(" or "),
            percent(self.areal_density),
            percent(self.trials_areal_density),
            span(self.depth_um),
            span(self.trials_depth_um),
        )
    }
}

/// Three digits of both ends, or of the one number.
fn span([from, to]: [f64; 2]) -> String {
    let short = |value: f64| format!("{value:.2e}").parse::<f64>().unwrap_or(value);
    if short(from) == short(to) { short(from).to_string() } else { format!("{} to {}", short(from), short(to)) }
}
