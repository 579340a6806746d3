//! What was found, as text for people: the verdict, friction at each pressure, what limits it, and what is doubtful.

use std::fmt::Write as _;

use super::DesignReport;
use crate::conditions_report::ConditionsReport;
use crate::infeasibility::ExplanationReport;
use crate::robustness_report::MEANING;
use slipgrid_results::{
    PressureErrors, Table, beyond_measured, beyond_measured_range, fixed, length_in_words, notes, with_error,
};

impl DesignReport {
    /// The report for people.
    #[must_use]
    pub fn summary(&self) -> String {
        [
            self.verdict_text(),
            self.friction_text(),
            self.found_beside(),
            self.out_of_reach(),
            self.notes_text(),
            self.cost(),
        ]
        .concat()
    }

    /// The verdict, the design, and the chance that a cut sample is on target.
    fn verdict_text(&self) -> String {
        let design = &self.design;
        let verdict = self.verdict();
        let nearest = if verdict.shows_nearest { "; nearest design:" } else { "" };
        let mut text = format!("{}: {}{}{nearest}\n\n", self.name, self.chance_words(), verdict.words);
        text += &format!(
            "  {} {} um wide, {} um apart, {} um deep{}{}\n  {:.1} % of the specimen's face, {:.1} % of a period\n",
            design.planform,
            length_in_words(design.width_um),
            length_in_words(design.spacing_um),
            length_in_words(design.depth_um),
            design.texture_words(),
            self.exposure_words(),
            100.0 * self.specimen_areal_density,
            100.0 * design.areal_density,
        );
        let removal = self.removal.as_ref().map(|removal| removal.words());
        let selection = self.selection.as_ref().map(|selection| selection.words.clone());
        let chance = self.chance.iter().flat_map(|chance| chance.lines(self.advice.as_ref()));
        for line in removal.into_iter().chain(selection).chain(chance) {
            let _ = writeln!(text, "  {line}");
        }
        // Loads beyond what was measured make the chance itself doubtful.
        if let Some(line) = self.beyond_range() {
            let _ = writeln!(text, "! {line}");
        }
        text += &self.advice.as_ref().map_or_else(String::new, |advice| advice.text());
        text + "\n"
    }

    /// Friction at every pressure, predicted and confirmed, with its errors.
    fn friction_text(&self) -> String {
        let mut table = Table::new([
            "P MPa",
            "target",
            "predicted",
            "+-",
            "confirmed",
            "+-",
            "mu",
            "+-",
            "mu flat",
            "+-",
            "peak MPa",
        ]);
        for (row, pressure_mpa) in self.target.pressure_mpa.iter().enumerate() {
            let at = self.errors.at(row);
            let value = [
                at.and_then(|at| at.predicted.as_ref()),
                self.confirmed_at(row),
                at.map(|at| &at.mu),
                at.and_then(|at| at.mu_flat.as_ref()),
            ];
            let cells = value.into_iter().flat_map(|of| [of.and_then(|of| of.value), of.and_then(|of| of.std)]);
            let first = [pressure_mpa.to_string(), self.target.wanted(row)];
            let peak = fixed(self.predicted.get(row).map(|load| load.peak_pressure_mpa), 2);
            table.row(first.into_iter().chain(cells.map(|cell| fixed(cell, 4))).chain([peak]));
        }
        let mut text = format!(
            "  {}{} (predicted: steady cell{}{}; confirmed: {})\n{table}  predicted counts the specimen's share of cavities, \
             and its +- how far confirmed is from it; peak is the steady cell's largest pressure, over a block\n",
            self.target.quantity,
            if self.discrepancy.is_some() { ", aimed with what trials say that the model lacks" } else { "" },
            self.in_space(),
            if self.rounds > 1 { ", corrected before the last search" } else { "" },
            self.confirmation()
        );
        let _ = writeln!(text, "  {}", self.errors.meaning);
        let confirmed = |row: &PressureErrors| if self.is_ratio() { row.ratio.clone() } else { Some(row.mu.clone()) };
        if let Some(line) = self.errors.intervals("confirmed", confirmed) {
            let _ = writeln!(text, "  {line}");
        }
        text += &self.discrepancy.as_ref().map_or_else(String::new, |found| found.text());
        for line in self.conditions.iter().flat_map(ConditionsReport::lines) {
            let _ = writeln!(text, "  {line}");
        }
        text
    }

    /// The goal, the misfit, slopes, tolerances and trade-offs.
    fn found_beside(&self) -> String {
        let mut text = String::new();
        if let Some(goal) = &self.goal {
            let _ = writeln!(text, "\n  {}", goal.words());
        }
        if self.target.has_demands() {
            let _ = writeln!(
                text,
                "\n  misfit {} of {} predicted, {} confirmed",
                fixed(Some(self.misfit.predicted), 2),
                self.target.tolerance_words(),
                fixed(self.misfit.confirmed, 2),
            );
        }
        if let Some(sensitivities) = &self.sensitivities {
            let _ = writeln!(text, "\n{}", sensitivities.text());
        }
        if let Some(robustness) = &self.robustness {
            let _ = writeln!(text, "{}", robustness.text());
        }
        if let Some(trade_offs) = &self.trade_offs {
            let _ = writeln!(text, "{}", trade_offs.text());
        }
        text
    }

    /// Why a target is not met, what designs reach, and the table of all of them.
    fn out_of_reach(&self) -> String {
        let mut text = String::new();
        let who = match self.reachable_among {
            Some(count) => format!("among the {count} designs solved in space those within bounds and limits"),
            None => "designs within bounds and limits".to_owned(),
        };
        for range in self.reachable.iter().filter(|_| self.status != "met") {
            let _ = writeln!(
                text,
                "  at {} MPa {who} reach {} to {}{}",
                range.pressure_mpa,
                with_error(range.lowest, range.lowest_std, 4),
                with_error(range.highest, range.highest_std, 4),
                if self.conditions.is_some() { ", at the condition designed for" } else { "" },
            );
        }
        let conflicts = self.conditions.iter().filter_map(|conditions| conditions.conflict.as_ref());
        let reasons = self.explanation.iter().flat_map(ExplanationReport::lines);
        for reason in conflicts.map(|conflict| conflict.words.clone()).chain(reasons) {
            let _ = writeln!(text, "  why: {reason}");
        }
        for line in self.table.iter().flat_map(|table| table.lines(self.timings_s.table)) {
            let _ = writeln!(text, "  {line}");
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
        let mut text = String::new();
        for doubt in self.other_doubts() {
            let _ = writeln!(text, "! {doubt}");
        }
        let stated = self.model.iter().map(String::as_str);
        let discrepancy = self.discrepancy.as_ref().map(|found| found.meaning().to_owned());
        let spread = self.robustness.as_ref().map(|_| MEANING);
        let of_lasering = if self.design.rim.is_some() { "roughening by the laser" } else { "recast rims" };
        let lacking = format!("not modelled: {of_lasering}, plasticity, viscoelasticity, heating, wear");
        text + &notes(stated.chain(discrepancy.as_deref()).chain(spread).chain([lacking.as_str()]), &self.method)
    }

    /// How much was computed.
    fn cost(&self) -> String {
        format!(
            "\ndesigns tried: {}{}, searches: {}; {}\n",
            self.evaluations,
            match self.solid_evaluations {
                0 => String::new(),
                solid => format!(" ({solid} in space)"),
            },
            self.rounds,
            self.timings_s.words(),
        )
    }

    /// Whether blocks resolve the pattern, as the confirming run says, or else the steady model.
    pub fn unresolved(&self) -> Option<String> {
        slipgrid_results::unresolved(&self.confirmed, self.block_um)
            .or_else(|| slipgrid_results::unresolved(&self.predicted, self.block_um))
    }

    /// Pressures beyond those at which friction was measured.
    fn beyond_mpa(&self) -> Vec<f64> {
        self.confirmed.iter().filter(|load| load.friction_extrapolated).map(|load| load.pressure_mpa).collect()
    }
}
