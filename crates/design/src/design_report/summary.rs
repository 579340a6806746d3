//! Result as text: advice, texture, expected values of a sample, limits of the chance, and doubts.

use std::fmt::Write as _;

use slipgrid_base::units::counted;

use super::DesignReport;
use crate::blocked::LiftedReport;
use crate::prediction::{Expected, LimitedBy, ModelledRatio, SampleReport, percent};
use crate::results::{
    Table, believed, believed_interval, beyond_measured, beyond_measured_range, duration_in_words, fixed,
    length_in_words, material_doubts, notes,
};

/// If a target pressure is outside the measured pressures by more than this factor, the extrapolated coefficient is
/// listed before all other doubts about the material.
const FAR_BEYOND: f64 = 1.25;

impl DesignReport {
    /// Formats the full text report.
    pub fn summary(&self) -> String {
        [self.texture_text(), self.expected_text(), self.found_beside(), self.notes_text(), self.cost()].concat()
    }

    /// Advice and texture.
    fn texture_text(&self) -> String {
        let mut text = format!(
            "{}: {}\n\n  {}\n  {:.1} % of the specimen's face, {:.1} % of a period\n",
            self.name,
            self.words,
            self.design_in_words(),
            100.0 * self.specimen_areal_density,
            100.0 * self.sample.design.areal_density,
        );
        if let Some(removal) = &self.removal {
            let _ = writeln!(text, "  {}", removal.words());
        }
        // Loads outside the measured range make the chance itself doubtful.
        if let Some(line) = self.beyond_range() {
            let _ = writeln!(text, "! {line}");
        }
        text + "\n"
    }

    /// Describes the lengths of the texture, its other properties, and the exposures by the laser.
    pub(super) fn design_in_words(&self) -> String {
        let design = &self.sample.design;
        format!(
            "{} {} um wide, spacing {} um, {} um deep{}{}",
            design.planform(),
            length_in_words(design.width_um),
            length_in_words(design.spacing_um),
            length_in_words(design.depth_um),
            design.texture_words(),
            self.exposure_words(),
        )
    }

    /// Table of target and expected values, one row per load, with the columns `of_model` of the model alone, the first
    /// of which is its ratio, under the headings `further`.
    pub(super) fn table_of_loads<'a>(
        &'a self,
        further: &[&'a str],
        of_model: impl Fn(&ModelledRatio) -> Vec<String>,
    ) -> Table {
        let expected = &self.sample.expected;
        let has_several = expected.iter().any(|at| !at.is_at_condition_of(&expected[0]));
        let mut columns = vec!["P MPa"];
        columns.extend(has_several.then_some("at"));
        columns.extend(["target", "expected", "95 % of samples", self.model_alone()]);
        columns.extend(further);
        let mut table = Table::new(columns);
        for (at, modelled) in expected.iter().zip(&self.sample.modelled) {
            let mut row = vec![at.pressure_mpa.to_string()];
            row.extend(has_several.then(|| at.condition_in_words()));
            let interval = believed_interval([at.low_95, at.high_95]);
            row.extend([at.target_in_words(), believed(at.median, 3), interval]);
            row.extend(of_model(modelled));
            table.row(row);
        }
        table
    }

    /// Expected values of a sample at every load, and values of the model alone.
    fn expected_text(&self) -> String {
        let of_model = |modelled: &ModelledRatio| [modelled.ratio, modelled.std].map(|value| fixed(Some(value), 3));
        let table = self.table_of_loads(&["+-"], |modelled| of_model(modelled).to_vec());
        let mut text = format!("  {}\n{table}", self.quantity_in_words());
        let lines = [self.trials_in_words()].into_iter().chain(self.limit_in_words()).chain(self.goal_in_words());
        for line in lines.chain(self.bounds_in_words()) {
            let _ = writeln!(text, "  {line}");
        }
        text
    }

    /// Main limit of the chance, in words; `None` if no input limits it significantly.
    pub fn limit_in_words(&self) -> Option<String> {
        let LimitedBy { input, known_to, chance_if_known, .. } = self.limit()?;
        Some(format!("limited mostly by {input} ({known_to}): without it, {} chance", percent(*chance_if_known)))
    }

    /// Name of the quantity that the expected values have.
    pub(super) fn quantity_in_words(&self) -> &'static str {
        if self.is_ratio() { "ratio to the flat surface" } else { "dynamic friction" }
    }

    /// Heading of the column with values of the model alone, which are ratios even if the target is friction.
    fn model_alone(&self) -> &'static str {
        if self.is_ratio() { "model alone" } else { "ratio, model alone" }
    }

    /// Sentence on the number of trials that correct the model.
    pub(super) fn trials_in_words(&self) -> String {
        match self.trials {
            0 => "no trial so far: before one the model's error is believed to be large".to_owned(),
            1 => "expected: the model corrected by one trial".to_owned(),
            count => format!("expected: the model corrected by {count} trials"),
        }
    }

    /// Sentence on the bounds that the texture rests on; `None` if it rests on none.
    pub(super) fn bounds_in_words(&self) -> Option<String> {
        let bounds = self.at_bounds.join(" and ");
        (!bounds.is_empty()).then(|| format!("rests on {bounds}: wider bounds may help"))
    }

    /// Expected value of the goal, in words; `None` without a goal.
    pub(super) fn goal_in_words(&self) -> Option<String> {
        let goal = self.goal.as_ref()?;
        let interval =
            goal.interval_95.map_or_else(String::new, |ends| format!(" (95 %: {})", believed_interval(ends)));
        let (goal, of, expected, modelled) = (&goal.goal, &goal.of, goal.expected, goal.modelled);
        Some(format!("{goal} {of}: {expected:.4} expected{interval}, {modelled:.4} by the model alone"))
    }

    /// Chance without each limit or bound that keeps the target out of reach, in words.
    pub(super) fn blocked_in_words(&self) -> Vec<String> {
        let one = |lifted: &LiftedReport| {
            let reach = if lifted.is_within_reach { "" } else { ", still out of reach" };
            let (what, chance) = (&lifted.what, percent(lifted.chance));
            format!("without {what}: {chance} for {} um{reach}", lifted.design.lengths_in_words())
        };
        self.blocked_by.iter().map(one).collect()
    }

    /// Effects that the model does not include, in words.
    pub(super) fn lacking(&self) -> String {
        let of_lasering = if self.sample.design.rim().is_some() { "roughening by the laser" } else { "recast rims" };
        format!("not modelled: {of_lasering}, plasticity, viscoelasticity, heating, wear")
    }

    /// Input that limits the chance most; `None` unless the chance without the error of this input is more than 0.02
    /// higher.
    pub fn limit(&self) -> Option<&LimitedBy> {
        let chance = self.sample.chance?;
        self.sample.limited_by.first().filter(|limit| limit.chance_if_known > chance + 0.02)
    }

    /// Other textures, limits and bounds that keep the target out of reach, and trade-offs.
    fn found_beside(&self) -> String {
        let mut text = String::new();
        if !self.others.is_empty() {
            let table = samples_table(self.others.iter().map(|other| ("also".to_owned(), other)));
            let _ = write!(text, "\n  other textures within the bounds\n{table}");
        }
        for line in self.blocked_in_words() {
            let _ = writeln!(text, "  {line}");
        }
        if let Some(trade_offs) = &self.trade_offs {
            let _ = write!(text, "\n{}", trade_offs.text());
        }
        text
    }

    /// Sentence on the target pressures outside the measured range; `None` if there are none.
    fn beyond_range(&self) -> Option<String> {
        beyond_measured_range(&self.beyond_mpa(), self.measured_mpa)
    }

    /// Reasons to doubt the design, one sentence each, the gravest first; the text marks them with `!`.
    pub fn doubts(&self) -> Vec<String> {
        let [before, after] = self.other_doubts();
        let beyond = self.beyond_range();
        // Just beyond the measured loads the nearest coefficients hardly differ; far beyond them friction is a guess.
        let (far, near) = if self.is_far_beyond() { (beyond, None) } else { (None, beyond) };
        before.into_iter().chain(far).chain(material_doubts(&self.material)).chain(near).chain(after).collect()
    }

    /// Says by how much whole passes miss the depth of the texture, and which speed makes it; `None` within tolerances.
    pub fn wrong_depth(&self) -> Option<String> {
        let depth_std_um = self.tolerances.as_ref().and_then(|of| of.depth_um);
        let asked = [self.sample.design.depth_um, self.laser.speed_mm_s?];
        self.removal.as_ref()?.wrong_depth(asked, depth_std_um)
    }

    /// Doubts listed before and after those about the material. Before: broken limits, runs without a valid result, and
    /// passes that make another depth, which make every number void. After: coarse blocks and bursts, which change
    /// numbers by a known amount.
    fn other_doubts(&self) -> [Vec<String>; 2] {
        let beyond = beyond_measured(&self.beyond_mpa());
        let loads = crate::results::warnings(&self.confirmed);
        let loads = loads.into_iter().filter(|warning| Some(warning) != beyond.as_ref());
        // Cavities that the laser makes differently from the design, by passes over lines or by bursts on spots.
        let of_laser = self.removal.iter().flat_map(|removal| &removal.warnings).chain(&self.laser_warnings);
        let depth = self.wrong_depth();
        let of_laser = of_laser.filter(|warning| Some(*warning) != depth.as_ref());
        let laser = of_laser.map(|warning| format!("laser: {warning}"));
        [
            self.sample.violations.iter().cloned().chain(loads).chain(depth.clone()).collect(),
            self.unresolved().into_iter().chain(laser).collect(),
        ]
    }

    /// Whether a target pressure lies farther from the measured range than [`FAR_BEYOND`].
    fn is_far_beyond(&self) -> bool {
        let is_far =
            |mpa: &f64| self.measured_mpa.is_none_or(|[low, high]| *mpa > FAR_BEYOND * high || FAR_BEYOND * mpa < low);
        self.beyond_mpa().iter().any(is_far)
    }

    /// Doubts, marked `!`, and notes on the model, on effects that it does not include, and on the method.
    fn notes_text(&self) -> String {
        let mut text = "\n".to_owned();
        let [before, after] = self.other_doubts();
        for doubt in before.into_iter().chain(material_doubts(&self.material)).chain(after) {
            let _ = writeln!(text, "! {doubt}");
        }
        let stated = self.model.iter().map(String::as_str);
        text + &notes(stated.chain([self.lacking().as_str()]), &self.method)
    }

    /// Number of compared designs, error of the table, and times of the stages.
    fn cost(&self) -> String {
        format!(
            "\n{} compared by a table of {}, off by {:.4} in the median and {:.4} at most of {}; {}\n",
            counted(self.compared, "design"),
            counted(self.table.nodes, "node"),
            self.table.median_error,
            self.table.worst_error,
            self.table.checked,
            self.timings_s.words(),
        )
    }

    /// Warning if the blocks do not resolve the pattern, from the confirming run.
    pub fn unresolved(&self) -> Option<String> {
        crate::results::unresolved(&self.confirmed, self.block_um)
    }

    /// Target pressures outside the measured range, in MPa.
    fn beyond_mpa(&self) -> Vec<f64> {
        self.confirmed.iter().filter(|load| load.friction_extrapolated).map(|load| load.pressure_mpa).collect()
    }
}

impl Expected {
    /// Whether speed, humidity and direction equal those of `other`.
    pub fn is_at_condition_of(&self, other: &Self) -> bool {
        let condition = |of: &Self| (of.speed_mm_s, of.humidity_pct, of.sliding_angle_deg);
        condition(self) == condition(other)
    }

    /// Describes speed, humidity and direction.
    pub fn condition_in_words(&self) -> String {
        let direction = self.sliding_angle_deg.map_or_else(String::new, |angle| format!(", at {angle} deg"));
        format!("{} mm/s, {} %{direction}", self.speed_mm_s, self.humidity_pct)
    }

    /// Describes the accepted values.
    pub fn target_in_words(&self) -> String {
        match (self.target_low, self.target_high) {
            (Some(low), Some(high)) => format!("{low:.3} to {high:.3}"),
            (Some(low), None) => format!(">= {low:.3}"),
            (None, Some(high)) => format!("<= {high:.3}"),
            (None, None) => "-".to_owned(),
        }
    }
}

/// Minimum information that counts as `some`, in bits: one tenth of the bit that separates two equally likely forms of
/// the model error.
const LEARNS_SOME: f64 = 0.1;
/// Minimum information that counts as `much`, in bits: one third of the bit that separates two equally likely forms.
const LEARNS_MUCH: f64 = 0.33;

impl SampleReport {
    /// Information gained by measuring the sample, in words: `little`, `some` or `much`.
    pub fn learns(&self) -> &'static str {
        match self.information_bits {
            bits if bits < LEARNS_SOME => "little",
            bits if bits < LEARNS_MUCH => "some",
            _ => "much",
        }
    }

    /// Row of [`samples_table`], labelled `name`; `has_times` adds the laser time.
    fn row(&self, name: String, has_times: bool) -> Vec<String> {
        let at = |at: &Expected| format!("{} ({})", believed(at.median, 3), believed_interval([at.low_95, at.high_95]));
        let mut row = vec![
            name,
            self.design.lengths_in_words().replace(' ', ""),
            self.chance.map_or_else(|| "-".to_owned(), percent),
            self.learns().to_owned(),
        ];
        row.extend(has_times.then(|| self.laser_s.map_or_else(|| "-".to_owned(), duration_in_words)));
        row.extend(first_and_last(&self.expected).map(at));
        row
    }
}

/// First and last of `all`, once if there is only one.
fn first_and_last(all: &[Expected]) -> impl Iterator<Item = &Expected> {
    all.first().into_iter().chain(all[1.min(all.len())..].last())
}

/// Table of named samples: texture, chance, information gained by a measurement, laser time if known, and expected
/// values at the first and the last load.
pub fn samples_table<'a>(samples: impl Iterator<Item = (String, &'a SampleReport)>) -> Table {
    let samples: Vec<_> = samples.collect();
    let loads = samples.first().map_or(&[][..], |(_, sample)| &sample.expected);
    let has_several = |load: &Expected| loads.iter().any(|other| !other.is_at_condition_of(load));
    let at = |load: &Expected| {
        let at = format!("at {} MPa", load.pressure_mpa);
        if has_several(load) { format!("{at}, {}", load.condition_in_words()) } else { at }
    };
    let headings = first_and_last(loads).map(at).enumerate();
    let headings: Vec<String> = headings.map(|(place, at)| if place == 0 { at + " (95 %)" } else { at }).collect();
    let has_times = samples.iter().any(|(_, sample)| sample.laser_s.is_some());
    let mut columns = vec!["", "width/spacing/depth um", "chance", "learns"];
    columns.extend(has_times.then_some("laser"));
    columns.extend(headings.iter().map(String::as_str));
    let mut table = Table::new(columns);
    samples.into_iter().for_each(|(name, sample)| table.row(sample.row(name, has_times)));
    table
}
