//! What the stages of a job took and what they brought.

use serde::{Deserialize, Serialize};

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    /// Reading or calibrating the material.
    pub material: f64,
    /// The flat sample in time, where the target is dynamic friction itself.
    pub flat: f64,
    /// Searching.
    pub search: f64,
    /// Choosing among the designs on target.
    pub choice: f64,
    /// Finding out why the target is out of reach.
    pub explain: f64,
    /// The table of designs, where asked for.
    pub table: f64,
    /// Confirming.
    pub confirm: f64,
    /// Confirming at further conditions.
    pub confirm_further: f64,
    /// Errors, slopes and tolerances at the design, and what others reach.
    pub uncertainty: f64,
    /// Comparing designs by the goals of `[trade_offs]`.
    pub trade_offs: f64,
    /// Solving the table for the page's explorer.
    #[serde(default)]
    pub explorer: f64,
    /// Drawing and tabulating, up to result.json itself.
    pub export: f64,
}

impl Timings {
    /// The seconds in words; stages that few designs have, where they took any.
    #[must_use]
    pub fn words(&self) -> String {
        let always = true;
        let all = [
            ("material", self.material, always),
            ("flat sample", self.flat, always),
            ("search", self.search, always),
            ("choice", self.choice, self.choice > 0.0),
            ("confirmation", self.confirm + self.confirm_further, always),
            ("why not", self.explain, self.explain > 0.0),
            ("table", self.table, self.table > 0.0),
            ("slopes and tolerances", self.uncertainty, always),
            ("trade-offs", self.trade_offs, always),
            ("explorer", self.explorer, self.explorer > 0.0),
            ("export", self.export, always),
        ];
        let told = all.into_iter().filter(|(_, _, is_told)| *is_told);
        told.map(|(what, seconds, _)| format!("{what} {seconds:.1} s")).collect::<Vec<_>>().join(", ")
    }
}

/// The best design after a number of evaluations.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ImprovementReport {
    /// The search, counted from 1.
    pub round: usize,
    /// Evaluations of this search up to and including the improvement.
    pub evaluation: usize,
    /// Largest distance from the target in tolerances, by the search's model.
    pub misfit: f64,
    /// Every limit is respected.
    pub feasible: bool,
}
