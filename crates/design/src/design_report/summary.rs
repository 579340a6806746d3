//! What was found, as text for people: what to do, the texture, what is expected of a sample, what limits it, and what is doubtful.

use std::fmt::Write as _;

use super::DesignReport;
use crate::prediction::{Expected, LimitedBy, SampleReport, percent};
use slipgrid_results::{
    Table, believed_interval, beyond_measured, beyond_measured_range, duration_in_words, fixed, length_in_words, notes,
};

impl DesignReport {
    /// The report for people.
    #[must_use]
    pub fn summary(&self) -> String {
        [self.texture_text(), self.expected_text(), self.found_beside(), self.notes_text(), self.cost()].concat()
    }

    /// What to do, and the texture.
    fn texture_text(&self) -> String {
        let design = &self.sample.design;
        let mut text = format!(
            "{}: {}\n\n  {} {} um wide, {} um apart, {} um deep{}{}\n  {:.1} % of the specimen's face, {:.1} % of a period\n",
            self.name,
            self.words,
            design.planform,
            length_in_words(design.width_um),
            length_in_words(design.spacing_um),
            length_in_words(design.depth_um),
            design.texture_words(),
            self.exposure_words(),
            100.0 * self.specimen_areal_density,
            100.0 * design.areal_density,
        );
        if let Some(removal) = &self.removal {
            let _ = writeln!(text, "  {}", removal.words());
        }
        // Loads beyond what was measured make the chance itself doubtful.
        if let Some(line) = self.beyond_range() {
            let _ = writeln!(text, "! {line}");
        }
        text + "\n"
    }

    /// What is expected of a sample at every load, and what the model alone says.
    fn expected_text(&self) -> String {
        let expected = &self.sample.expected;
        let has_several = expected.iter().any(|at| !at.is_at_condition_of(&expected[0]));
        let mut columns = vec!["P MPa"];
        columns.extend(has_several.then_some("at"));
        columns.extend(["target", "expected", "95 % of samples", "model alone", "+-"]);
        let mut table = Table::new(columns);
        for (at, modelled) in expected.iter().zip(&self.sample.modelled) {
            let mut row = vec![at.pressure_mpa.to_string()];
            row.extend(has_several.then(|| at.condition_in_words()));
            row.extend([
                at.target_in_words(),
                fixed(Some(at.median), 3),
                believed_interval([at.low_95, at.high_95]),
                fixed(Some(modelled.ratio), 3),
                fixed(Some(modelled.std), 3),
            ]);
            table.row(row);
        }
        let friction =
            if self.is_ratio() { "ratio to the flat surface" } else { "dynamic friction; model alone: ratio" };
        let mut text = format!("  {friction}\n{table}");
        if let Some(limit) = self.limit() {
            let _ = writeln!(
                text,
                "  limited by {} ({}): without it the chance would be {}",
                limit.input,
                limit.known_to,
                percent(limit.chance_if_known)
            );
        }
        if let Some(goal) = &self.goal {
            let interval =
                goal.interval_95.map_or_else(String::new, |ends| format!(" (95 %: {})", believed_interval(ends)));
            let (goal, of, expected, modelled) = (&goal.goal, &goal.of, goal.expected, goal.modelled);
            let _ = writeln!(text, "  {goal} {of}: {expected:.4} expected{interval}, {modelled:.4} by the model alone");
        }
        text
    }

    /// What limits the chance most, where that is worth a word.
    #[must_use]
    pub fn limit(&self) -> Option<&LimitedBy> {
        let chance = self.sample.chance?;
        self.sample.limited_by.first().filter(|limit| limit.chance_if_known > chance + 0.02)
    }

    /// Other textures, what blocks the target, and trade-offs.
    fn found_beside(&self) -> String {
        let mut text = String::new();
        if !self.others.is_empty() {
            let mut table = Table::new(SampleReport::COLUMNS);
            self.others.iter().for_each(|other| {
                table.row(other.row("also"));
            });
            let _ = write!(text, "\n  other textures within the bounds\n{table}");
        }
        for lifted in &self.blocked_by {
            let reach = if lifted.is_within_reach { "" } else { ", still out of reach" };
            let _ = writeln!(
                text,
                "  without {}: {} for {} um{reach}",
                lifted.what,
                percent(lifted.chance),
                lifted.design.lengths_in_words()
            );
        }
        if let Some(trade_offs) = &self.trade_offs {
            let _ = write!(text, "\n{}", trade_offs.text());
        }
        text
    }

    /// Pressures of the target outside the measured range.
    fn beyond_range(&self) -> Option<String> {
        beyond_measured_range(&self.beyond_mpa(), self.measured_mpa)
    }

    /// What makes the design doubtful, one sentence each: the lines that the text marks with `!`.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        self.beyond_range().into_iter().chain(self.other_doubts()).collect()
    }

    fn other_doubts(&self) -> impl Iterator<Item = String> {
        let laser = self.of_laser().map(|warning| format!("laser: {warning}"));
        let beyond = beyond_measured(&self.beyond_mpa());
        let loads = slipgrid_results::warnings(&self.confirmed);
        let loads = loads.into_iter().filter(move |warning| Some(warning) != beyond.as_ref());
        let violations = self.violations.iter().cloned();
        self.material.doubts().chain(violations).chain(laser).chain(loads).chain(self.unresolved())
    }

    /// Doubts, marked `!`; what was modelled and what was not.
    fn notes_text(&self) -> String {
        let mut text = "\n".to_owned();
        for doubt in self.other_doubts() {
            let _ = writeln!(text, "! {doubt}");
        }
        let stated = self.model.iter().map(String::as_str);
        let of_lasering = if self.sample.design.rim.is_some() { "roughening by the laser" } else { "recast rims" };
        let lacking = format!("not modelled: {of_lasering}, plasticity, viscoelasticity, heating, wear");
        text + &notes(stated.chain([lacking.as_str()]), &self.method)
    }

    /// How much was computed.
    fn cost(&self) -> String {
        format!(
            "\n{} designs compared by a table of {} nodes, off by {:.4} in the median and {:.4} at most of {}; {}\n",
            self.compared,
            self.table.nodes,
            self.table.median_error,
            self.table.worst_error,
            self.table.checked,
            self.timings_s.words(),
        )
    }

    /// Whether blocks resolve the pattern, as the confirming run says.
    pub fn unresolved(&self) -> Option<String> {
        slipgrid_results::unresolved(&self.confirmed, self.block_um)
    }

    /// Pressures beyond those at which friction was measured.
    fn beyond_mpa(&self) -> Vec<f64> {
        self.confirmed.iter().filter(|load| load.friction_extrapolated).map(|load| load.pressure_mpa).collect()
    }
}

impl Expected {
    /// Whether speed, humidity and direction are those of `other`.
    #[must_use]
    pub fn is_at_condition_of(&self, other: &Self) -> bool {
        let condition = |of: &Self| (of.speed_mm_s, of.humidity_pct, of.sliding_angle_deg);
        condition(self) == condition(other)
    }

    /// Speed, humidity and direction.
    #[must_use]
    pub fn condition_in_words(&self) -> String {
        let direction = self.sliding_angle_deg.map_or_else(String::new, |angle| format!(", at {angle} deg"));
        format!("{} mm/s, {} %{direction}", self.speed_mm_s, self.humidity_pct)
    }

    /// What is accepted.
    #[must_use]
    pub fn target_in_words(&self) -> String {
        match (self.target_low, self.target_high) {
            (Some(low), Some(high)) => format!("{low:.3} to {high:.3}"),
            (Some(low), None) => format!(">= {low:.3}"),
            (None, Some(high)) => format!("<= {high:.3}"),
            (None, None) => "-".to_owned(),
        }
    }
}

impl SampleReport {
    /// What [`Self::row`] has.
    pub const COLUMNS: [&str; 8] = [
        "",
        "width / spacing / depth um",
        "planform",
        "chance",
        "tells bits",
        "laser",
        "expected at the first load (95 %)",
        "at the last",
    ];

    /// A row of a table, called `name`.
    #[must_use]
    pub fn row(&self, name: &str) -> [String; 8] {
        let at = |of: Option<&Expected>| {
            of.map_or_else(String::new, |at| {
                format!("{:.3} ({})", at.median, believed_interval([at.low_95, at.high_95]))
            })
        };
        [
            name.to_owned(),
            self.design.lengths_in_words(),
            self.design.planform.clone(),
            self.chance.map_or_else(|| "-".to_owned(), percent),
            fixed(Some(self.information_bits), 2),
            self.laser_s.map_or_else(|| "-".to_owned(), duration_in_words),
            at(self.expected.first()),
            at(self.expected.last()),
        ]
    }
}
