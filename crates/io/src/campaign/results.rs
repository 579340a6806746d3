//! Results of a campaign as one table.

use serde_json::Value as Json;
use slipgrid_base::units::{counted, tidy};
use slipgrid_design::results::guard_formula;

use crate::campaign::records::{Campaign, Kind, Task};
use crate::campaign::worker::{Done, Outcome};

/// Columns of the results of a campaign of scenes, which has one row per load.
const SCENE_COLUMNS: [&str; 8] = [
    "pressure_mpa",
    "mu_dynamic",
    "mu_dynamic_stderr",
    "mu_static",
    "ratio",
    "ratio_stderr",
    "peak_pressure_mpa",
    "cavity_closed",
];
/// Columns of the results of a campaign of designs, with JSON pointers to the values in result.json.
const DESIGN_COLUMNS: [(&str, &str); 6] = [
    ("found", "/advice"),
    ("chance", "/chance"),
    ("width_um", "/design/width_um"),
    ("spacing_um", "/design/spacing_um"),
    ("depth_um", "/design/depth_um"),
    ("specimen_areal_density", "/specimen_areal_density"),
];

/// Number of tasks by state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Number of tasks whose computation succeeded.
    pub done: usize,
    /// Number of tasks whose input was refused.
    pub refused: usize,
    /// Number of tasks whose computation failed.
    pub failed: usize,
    /// Number of tasks that have not been done.
    pub missing: usize,
}

impl Counts {
    /// Describes the counts in one line.
    pub fn words(&self) -> String {
        let Self { done, refused, failed, missing } = self;
        let tasks = counted(done + refused + failed + missing, "task");
        format!("{tasks}: {done} done, {refused} refused, {failed} failed, {missing} missing")
    }

    /// Number of tasks with any outcome.
    pub(crate) const fn ended(self) -> usize {
        self.done + self.refused + self.failed
    }

    /// Adds a task with this outcome to the counts.
    pub(crate) fn add(&mut self, outcome: Outcome) {
        match outcome {
            Outcome::Done => self.done += 1,
            Outcome::Refused => self.refused += 1,
            Outcome::Failed => self.failed += 1,
        }
    }
}

/// Table of results in the order of the campaign: one row per load of a scene, one per design, and one per task without
/// a result. The table does not depend on who did which task.
pub struct Results<'a> {
    campaign: &'a Campaign,
    text: String,
    /// Number of columns between the columns for outcome and reason; depends on the kind of task.
    columns: usize,
    counts: Counts,
}

impl<'a> Results<'a> {
    /// Creates an empty table.
    pub fn new(campaign: &'a Campaign) -> Self {
        let own = match campaign.kind {
            Kind::Scene => SCENE_COLUMNS.to_vec(),
            Kind::Design => DESIGN_COLUMNS.map(|(name, _)| name).to_vec(),
        };
        let keys: String = campaign.keys.iter().map(|key| quoted(key) + ",").collect();
        let text = format!("task,{keys}outcome,{},reason\n", own.join(","));
        Self { campaign, text, columns: own.len(), counts: Counts::default() }
    }

    /// Adds the result `done` of `task`, which is `None` if the task has not been done.
    pub fn add(&mut self, task: &Task, done: Option<&Done>) {
        match done {
            Some(done) => self.counts.add(done.outcome),
            None => self.counts.missing += 1,
        }
        for cells in self.rows(done) {
            let values: String = self.campaign.keys.iter().map(|key| cell(task.values.get(key)) + ",").collect();
            self.text += &format!("{},{values}{cells}\n", task.id);
        }
    }

    /// The table as CSV.
    pub fn csv(&self) -> &str {
        &self.text
    }

    /// Number of tasks by state.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    /// Cells of each row of one task: outcome, columns for the kind of task, and reason; `done` is `None` if the task has
    /// not been done.
    fn rows(&self, done: Option<&Done>) -> Vec<String> {
        let commas = ",".repeat(1 + self.columns);
        let Some(done) = done else { return vec![format!("missing{commas}")] };
        let reason = quoted(done.reason.as_deref().unwrap_or_default());
        let record = match (&done.record, done.outcome) {
            (Some(record), Outcome::Done) => record,
            (_, Outcome::Refused) => return vec![format!("refused{commas}{reason}")],
            _ => return vec![format!("failed{commas}{reason}")],
        };
        let cells: Vec<Vec<String>> = match self.campaign.kind {
            Kind::Design => vec![DESIGN_COLUMNS.iter().map(|(_, place)| cell(record.pointer(place))).collect()],
            Kind::Scene => {
                let loads = record.get("results").and_then(Json::as_array).into_iter().flatten();
                loads.map(|load| SCENE_COLUMNS.iter().map(|name| cell(load.get(*name))).collect()).collect()
            }
        };
        cells.into_iter().map(|cells| format!("done,{},", cells.join(","))).collect()
    }
}

/// Formats a JSON value as a cell of the CSV; empty for `None`.
fn cell(value: Option<&Json>) -> String {
    match value {
        None | Some(Json::Null) => String::new(),
        Some(Json::Number(number)) => {
            number.as_f64().map_or_else(|| number.to_string(), |value| tidy(value).to_string())
        }
        Some(Json::String(text)) => quoted(text),
        Some(other) => quoted(&other.to_string()),
    }
}

/// Formats text as a cell: guarded against formulas, and quoted if necessary.
fn quoted(text: &str) -> String {
    let text = guard_formula(text);
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_design::DesignReport;
    use slipgrid_design::results::LoadReport;

    /// A renamed field would leave its column empty.
    #[test]
    fn columns_have_the_names_of_the_records_they_are_taken_from() {
        let design = serde_json::to_value(DesignReport::default()).unwrap();
        assert_eq!(DESIGN_COLUMNS.into_iter().find(|(_, place)| design.pointer(place).is_none()), None);
        let load = serde_json::to_value(LoadReport::default()).unwrap();
        assert_eq!(SCENE_COLUMNS.into_iter().find(|name| load.get(name).is_none()), None);
    }
}
