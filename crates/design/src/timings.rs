//! Time of the stages of a job.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Timings {
    /// Seconds for reading or calibrating the material.
    pub material: f64,
    /// Seconds for the table of the bounds.
    pub table: f64,
    /// Seconds for the search in the table.
    pub search: f64,
    /// Seconds for the dynamic run that confirms the design.
    pub confirm: f64,
    /// Seconds for sample predictions, inputs that limit the chance, limits that keep a target out of reach, slopes,
    /// and the comparison of designs by the goals of `[trade_offs]`.
    pub trade_offs: f64,
    /// Seconds for the predictions that the page's explorer shows.
    #[serde(default)]
    pub explorer: f64,
    /// Seconds for drawing and tabulating before result.json is made, and for all that belongs to no other stage.
    pub export: f64,
}

impl Timings {
    /// Counts the seconds of `wall_s` that belong to no other stage as export, so that the stages sum to `wall_s`.
    pub fn count_rest(&mut self, wall_s: f64) {
        let counted = self.material + self.table + self.search + self.confirm + self.trade_offs + self.explorer;
        // Rounding may leave less than nothing.
        self.export = (wall_s - counted).max(0.0);
    }

    /// Formats the seconds.
    pub fn words(&self) -> String {
        let all = [
            ("material", self.material),
            ("table", self.table),
            ("search", self.search),
            ("confirmation", self.confirm),
            ("trade-offs", self.trade_offs),
            ("explorer", self.explorer),
            ("export", self.export),
        ];
        all.map(|(what, seconds)| format!("{what} {seconds:.1} s")).join(", ")
    }
}
