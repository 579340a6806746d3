//! Why a target is out of reach, in the words of the design file.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use slipgrid_monitor::Part;
use slipgrid_optimize::{
    Bound, Candidate, Demand, DesignSpace, Dimension, Explanation, ForwardModel, Limit, ReachableRange, Relief,
    Restriction, SearchError, SearchOptions, Status, explain_infeasibility, search, search_near,
};
use std::cell::Cell;

use crate::DesignError;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::steady_model::SteadyModel;
use crate::task::DesignTask;
use crate::timings::Timings;
use slipgrid_monitor::{Monitor, Stage};
use slipgrid_results::{PatternReport, length_in_words};
use slipgrid_units::{LENGTH_UM, significant, tidy};

/// Bisections of a limit whose relaxing suffices: it is then known to a thirtieth of its change.
const HALVINGS: usize = 5;
/// Designs that each of these searches may ask of.
const MOST_EVALUATIONS: usize = 1500;
/// Bounds are relaxed by this factor.
const BOUND_FACTOR: f64 = 2.0;
/// A cavity wider than the spot by less, relative to it, rests on it.
const AT_SPOT: f64 = 0.01;
/// Least depth tried where no burst says it, in metres.
const LEAST_DEPTH_M: f64 = 1e-6;
/// Digits of limits that suffice, rounded to the loose side.
const DIGITS: i32 = 3;

/// What is said where pressures contradict one another.
const EACH_ALONE: &str = "the target at each pressure alone is met by some design, but none found meets all: friction does not \
                          change with pressure as the target does";

/// Why a target is out of reach.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ExplanationReport {
    /// Each pressure's target alone is met by some design within bounds and limits, so that only together they are out of reach.
    #[serde(default)]
    pub each_alone: bool,
    /// Limits and bounds that bind: relaxing each alone brings a design nearer. Those that suffice first.
    pub binding: Vec<ReliefReport>,
    /// Largest distance of the nearest design from the target, in tolerances, by the search's model as it stands
    /// after the last confirming run.
    pub misfit: f64,
    /// Limits, and bounds on which the nearest design rests, that were relaxed one by one.
    pub relaxed: usize,
    /// Their names, and how far bounds were relaxed.
    #[serde(default)]
    pub tried: Vec<String>,
    /// The limit of the laser that the nearest design rests on and that is not relaxed, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub kept: Option<String>,
    /// The nearest design with all of them relaxed, where none suffices alone.
    pub together: Option<NearestReport>,
    /// Designs asked for.
    pub evaluations: usize,
}

/// What relaxing one limit or bound gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReliefReport {
    /// The limit or bound, in words.
    pub what: String,
    /// Unit of the limits; may be empty.
    pub unit: Cow<'static, str>,
    /// The limit or bound as it is.
    pub limit: f64,
    /// The value that suffices, rounded to the loose side; otherwise the value of the design below.
    pub relaxed: f64,
    /// Whether the target is met then, by the search's model.
    pub suffices: bool,
    /// The design with the limit or bound relaxed.
    pub nearest: NearestReport,
}

/// A design, and by how much it misses.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct NearestReport {
    /// The design.
    pub design: PatternReport,
    /// Largest distance from the target, in tolerances.
    pub misfit: f64,
}

impl From<&Candidate> for NearestReport {
    fn from(candidate: &Candidate) -> Self {
        Self { design: (&candidate.design).into(), misfit: candidate.misfit.max }
    }
}

impl MultiFidelityLoop<'_> {
    /// Says why the target is out of reach, where it is.
    pub(super) fn explain(
        &mut self,
        design: &DesignTask,
        timings: &mut Timings,
    ) -> Result<Option<ExplanationReport>, DesignError> {
        let Some(best) = self.round.best.as_ref().filter(|_| self.status == Status::Unreachable) else {
            return Ok(None);
        };
        // No limit is the reason where physics is.
        if self.flat_is_best(design).is_some() {
            return Ok(None);
        }
        let bar = self.stage("why not");
        let explanation = explanation(design, &self.model, &self.model.judged(design, best), &bar);
        let is_cut = bar.is_out_of_time();
        timings.explain = bar.finish();
        self.monitor.heed()?;
        if is_cut {
            self.cut("why the target is out of reach");
        }
        let each_alone = self.each_is_within_reach(design);
        let told = |explanation: ExplanationReport| ExplanationReport { each_alone, ..explanation };
        explanation.map(|found| found.map(told)).map_err(|error| DesignError::Failed(error.to_string()))
    }

    /// Whether some design is on target at each of several pressures, at one condition.
    fn each_is_within_reach(&self, design: &DesignTask) -> bool {
        let (points, ranges) = (design.target.points(), &self.round.reachable);
        let is_reached = |(demand, range): (&Demand, &ReachableRange)| {
            let [lowest, highest] = demand.wanted.band();
            lowest.is_none_or(|lowest| lowest <= range.highest) && highest.is_none_or(|highest| highest >= range.lowest)
        };
        let is_one_condition = self.further.is_empty() && ranges.len() == points.len();
        points.len() > 1 && is_one_condition && points.iter().zip(ranges).all(is_reached)
    }
}

/// Relaxes what may keep `best` from the target of `design`. In space the guide alone is asked.
///
/// # Errors
/// [`SearchError`] where the model is broken.
pub fn explanation(
    design: &DesignTask,
    model: &SteadyModel,
    best: &Candidate,
    bar: &Stage<'_>,
) -> Result<Option<ExplanationReport>, SearchError> {
    let burst_m = design.constraints.limits.depth_per_burst_m;
    let block_m = design.layer.block_m;
    let [widths, spacings, depths] = design.space.lengths_m();
    let along = |[lower_m, upper_m]: [f64; 2]| [lower_m.min(block_m), BOUND_FACTOR * upper_m];
    let deepest_m = (BOUND_FACTOR * depths[1]).min(design.layer.height_m - block_m).max(depths[1]);
    let shallowest_m = depths[0].min(burst_m.unwrap_or(LEAST_DEPTH_M));
    let Ok(widest) =
        DesignSpace::new(*design.space.texture(), along(widths), along(spacings), [shallowest_m, deepest_m])
    else {
        return Ok(None);
    };
    let options = SearchOptions { seed: design.seed, max_evaluations: MOST_EVALUATIONS };
    let guide = model.guide().map(|(guide, _)| guide);
    let asked: &dyn ForwardModel = guide.as_ref().map_or(model as &dyn ForwardModel, |guide| guide);
    let evaluations = Cell::new(0);
    let found = explain_infeasibility(
        &design.space,
        &design.constraints,
        best,
        &widest,
        if model.is_cheap_per_design() { HALVINGS } else { 0 },
        &mut |space, constraints| {
            if bar.cancelled() {
                return Err(SearchError::CancelledAtStart);
            }
            bar.detail(&format!("why not ({})", evaluations.get()));
            // How many searches there will be is not known.
            let unshown = Part::new(bar, 0.0);
            let target = &design.target;
            let outcome = if model.is_cheap_per_design() {
                search(target, space, constraints, &options, asked, &unshown)?
            } else {
                search_near(&[best.design], target, space, constraints, &options, asked, &unshown)?
            };
            evaluations.set(evaluations.get() + outcome.evaluations);
            Ok(outcome)
        },
    )?;
    let Explanation { reliefs, tried, together } = found;
    // The search moves a lower bound of the spacing that says the same along with the land.
    let is_both = design.constraints.limits.min_land_m.is_some_and(|land_m| (spacings[0] / land_m - 1.0).abs() < 1e-9);
    let land = if is_both { "land between cavities and lower bound of the spacing" } else { "land between cavities" };
    let named = Named { quantities: &design.constraints.quantities, land };
    Ok(Some(ExplanationReport {
        each_alone: false,
        binding: reliefs.iter().map(|relief| relief_report(relief, named)).collect(),
        misfit: best.misfit.max,
        relaxed: tried.len(),
        tried: tried.iter().map(|(restriction, loosest)| tried_words(*restriction, *loosest, named)).collect(),
        kept: design.constraints.limits.spot_m.filter(|spot_m| is_as_narrow(best, *spot_m)).map(spot_words),
        together: together.as_ref().map(NearestReport::from),
        evaluations: evaluations.get(),
    }))
}

/// How restrictions are called.
#[derive(Clone, Copy)]
struct Named<'a> {
    quantities: &'a [Limit],
    /// The smallest land.
    land: &'static str,
}

/// `relief` in the units of a design file.
fn relief_report(relief: &Relief, named: Named<'_>) -> ReliefReport {
    let quantities = named.quantities;
    let (what, is_least) = (words(relief.restriction, named), is_least(relief.restriction, quantities));
    let (unit, unit_si) = match relief.restriction {
        Restriction::Quantity(place) => (quantities[place].unit, quantities[place].unit_si),
        _ => ("um", LENGTH_UM.from_si(1.0).recip()),
    };
    let relaxed = relief.relaxed / unit_si;
    ReliefReport {
        what,
        unit: unit.into(),
        limit: tidy(relief.limit / unit_si),
        relaxed: if relief.suffices { loosened(relaxed, is_least) } else { tidy(relaxed) },
        suffices: relief.suffices,
        nearest: (&relief.best).into(),
    }
}

/// The name of a restriction.
fn words(restriction: Restriction, named: Named<'_>) -> String {
    match restriction {
        Restriction::Quantity(place) => named.quantities[place].name.to_owned(),
        Restriction::SmallestLand => named.land.to_owned(),
        Restriction::LowerBound(dimension) => format!("lower bound of the {}", name(dimension)),
        Restriction::UpperBound(dimension) => format!("upper bound of the {}", name(dimension)),
    }
}

/// Whether it says what a design has at least.
fn is_least(restriction: Restriction, quantities: &[Limit]) -> bool {
    match restriction {
        Restriction::Quantity(place) => matches!(quantities[place].bound, Bound::AtLeast(_)),
        Restriction::UpperBound(_) => false,
        Restriction::SmallestLand | Restriction::LowerBound(_) => true,
    }
}

/// The name with how far it was relaxed, where that is a length.
fn tried_words(restriction: Restriction, loosest: f64, named: Named<'_>) -> String {
    let quantities = named.quantities;
    let what = words(restriction, named);
    let way = if is_least(restriction, quantities) { "down" } else { "up" };
    match restriction {
        Restriction::Quantity(_) if !loosest.is_finite() => format!("{what} (without any limit)"),
        Restriction::Quantity(place) => format!("{what} ({way} to {})", quantities[place].tell(loosest)),
        _ => format!("{what} ({way} to {} um)", length_in_words(LENGTH_UM.from_si(loosest))),
    }
}

/// Whether the smallest extent of `candidate` is the spot.
fn is_as_narrow(candidate: &Candidate, spot_m: f64) -> bool {
    candidate.design.least_extent_m() <= spot_m * (1.0 + AT_SPOT)
}

fn spot_words(spot_m: f64) -> String {
    format!("the laser's spot, {} um", length_in_words(LENGTH_UM.from_si(spot_m)))
}

const fn name(dimension: Dimension) -> &'static str {
    match dimension {
        Dimension::Width => "width",
        Dimension::Spacing => "spacing",
        Dimension::Depth => "depth",
    }
}

/// `value` to [`DIGITS`] digits, down where it is a least allowed value and up where it is a largest.
fn loosened(value: f64, is_least: bool) -> f64 {
    if value == 0.0 {
        return 0.0;
    }
    let step = 10.0_f64.powi(value.abs().log10().floor() as i32 + 1 - DIGITS);
    // Numbers that are whole steps but for rounding stay.
    let steps = value / step;
    let whole = if (steps - steps.round()).abs() < 1e-6 {
        steps.round()
    } else if is_least {
        steps.floor()
    } else {
        steps.ceil()
    };
    tidy(whole * step)
}

impl ExplanationReport {
    /// The reasons, one line each.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = Vec::new();
        if self.each_alone {
            lines.push(EACH_ALONE.to_owned());
        }
        lines.extend(self.binding.iter().map(|relief| relief.words(self.misfit)));
        if self.binding.is_empty() {
            lines.push(match self.relaxed {
                0 => "no limit or bound is the reason: the nearest design rests on none".to_owned(),
                1 => format!(
                    "no limit or bound is the reason: relaxing the {} brings no design nearer",
                    self.tried.join("")
                ),
                _ => format!(
                    "no single limit or bound is the reason: relaxing each alone brings no design nearer: {}",
                    self.tried.join(", ")
                ),
            });
        }
        // Of one alone the line above says it.
        let is_said = self.relaxed == 1 && !self.binding.is_empty();
        if let Some(together) = self.together.as_ref().filter(|_| !is_said) {
            lines.push(if together.misfit <= 1.0 {
                format!(
                    "with {} relaxed together the search's model meets the target: {}",
                    self.tried.join(", "),
                    lengths(&together.design)
                )
            } else {
                format!(
                    "even with {} relaxed{} the nearest design, {}, misses by {:.2} tolerances",
                    self.tried.join(", "),
                    if self.relaxed == 1 { "" } else { " together" },
                    lengths(&together.design),
                    together.misfit
                )
            });
        }
        lines.extend(
            self.kept.iter().map(|kept| format!("the nearest design is as narrow as {kept}, which is not relaxed")),
        );
        lines
    }
}

impl ReliefReport {
    fn words(&self, missed: f64) -> String {
        let unit = if self.unit.is_empty() { String::new() } else { format!(" {}", self.unit) };
        let change =
            format!("with {} {}{unit} instead of {}{unit}", self.what, significant(self.relaxed, 4), self.limit);
        let design = lengths(&self.nearest.design);
        if self.suffices {
            format!("{change} the search's model meets the target, which no run in time has confirmed: {design}")
        } else {
            // Limits come first: what breaks them by less may be farther from the target.
            let limits = if self.nearest.misfit < missed { "" } else { "breaks the limits by less, and " };
            format!(
                "{change} the nearest design, {design}, {limits}misses by {:.2} tolerances, not {missed:.2}",
                self.nearest.misfit
            )
        }
    }
}

fn lengths(design: &PatternReport) -> String {
    format!("{} um", design.lengths_in_words())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_relaxed_is_named_with_how_far() {
        let bounds = [
            (Restriction::LowerBound(Dimension::Width), 30e-6, "lower bound of the width (down to 30 um)"),
            (Restriction::UpperBound(Dimension::Depth), 70.6858e-6, "upper bound of the depth (up to 70.69 um)"),
            (Restriction::SmallestLand, 10e-6, "land between cavities (down to 10 um)"),
        ];
        let named = Named { quantities: &[], land: "land between cavities" };
        let tried: Vec<String> = bounds.iter().map(|(of, loosest, _)| tried_words(*of, *loosest, named)).collect();
        assert_eq!(tried, bounds.map(|(_, _, words)| words));
        let report = ExplanationReport {
            each_alone: false,
            binding: Vec::new(),
            misfit: 3.0,
            relaxed: tried.len(),
            tried,
            kept: Some(spot_words(30e-6)),
            together: Some(NearestReport { design: PatternReport::default(), misfit: 2.0 }),
            evaluations: 0,
        };
        let lines = report.lines();
        assert!(
            lines[1].starts_with("even with lower bound of the width (down to 30 um), upper bound of the depth"),
            "{lines:?}"
        );
        assert_eq!(lines[2], "the nearest design is as narrow as the laser's spot, 30 um, which is not relaxed");
        let each = ExplanationReport { each_alone: true, ..report.clone() };
        assert_eq!((each.lines()[0].as_str(), &each.lines()[1..]), (EACH_ALONE, lines.as_slice()));
        // Of one limit alone the line with its number says it, once.
        let relief = ReliefReport {
            what: "peak pressure".into(),
            unit: "MPa".into(),
            limit: 60.0,
            relaxed: 70.0,
            suffices: false,
            nearest: NearestReport { design: PatternReport::default(), misfit: 2.0 },
        };
        let tried = vec!["peak pressure (without any limit)".to_owned()];
        let one = ExplanationReport { binding: vec![relief], relaxed: 1, tried, kept: None, ..report.clone() };
        assert_eq!(one.lines().len(), 1, "{:?}", one.lines());
        assert!(one.lines()[0].starts_with("with peak pressure 70 MPa instead of 60 MPa the nearest design"));
        // A design that is farther from the target is nearest where it breaks limits by less.
        let farther = ExplanationReport { misfit: 1.5, ..one };
        assert!(farther.lines()[0].ends_with("breaks the limits by less, and misses by 2.00 tolerances, not 1.50"));
    }

    #[test]
    fn what_suffices_is_rounded_to_the_loose_side() {
        for (value, least, most) in [
            (29.96, 29.9, 30.0),
            (0.612_34, 0.612, 0.613),
            (1234.5, 1230.0, 1240.0),
            (30.0, 30.0, 30.0),
            (0.0, 0.0, 0.0),
        ] {
            assert_eq!((loosened(value, true), loosened(value, false)), (least, most), "{value}");
        }
        // A depth of 12 bursts of 2.6 um.
        assert_eq!(loosened(2.6 * 12.0, false), 31.2);
    }
}
