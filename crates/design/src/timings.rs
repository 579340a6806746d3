//! What the stages of a job took.

use serde::{Deserialize, Serialize};

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    /// Reading or calibrating the material.
    pub material: f64,
    /// The table of the bounds.
    pub table: f64,
    /// Searching in it.
    pub search: f64,
    /// Confirming in time.
    pub confirm: f64,
    /// What is said of samples, what limits the chance and blocks a target, slopes, and comparing designs by the goals of `[trade_offs]`.
    pub trade_offs: f64,
    /// What the page's explorer shows.
    #[serde(default)]
    pub explorer: f64,
    /// Drawing and tabulating, up to result.json itself.
    pub export: f64,
}

impl Timings {
    /// The seconds in words.
    #[must_use]
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
