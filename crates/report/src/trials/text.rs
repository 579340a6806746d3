//! Tables of a ledger of trials, equal on the screen and on a page; the ledger as text, for the screen, and as CSV.

use slipgrid_base::units::counted;
use slipgrid_design::RatioPrediction;
use slipgrid_design::results::{
    Records, SCREEN_WIDTH, Table, believed, believed_interval, believed_std, doubts_in_brief, fixed, guard_formula,
    wrapped,
};
use slipgrid_infer::discrepancy::Form;

use super::effects::less_known;
use super::{Coverage, MeasuredReport, PendingTrial, TrialReport, TrialsReport, load_lines};

/// Maximum standard deviation of a ratio, in per cent, that is stated as a number; larger ones are stated in words.
const MAX_STD_PCT: f64 = 50.0;
/// Maximum number of ratios listed on the screen; further ratios are only counted.
const MAX_RATIOS: usize = 8;

/// Adds the columns that identify a sample. `of` gives areal density, edge length per area in 1/mm and depth in um.
fn sample<T>(table: &mut Records<'_, T>, of: fn(&T) -> [f64; 3]) {
    table.column("density", |row| fixed(Some(of(row)[0]), 3));
    table.column("edges 1/mm", |row| fixed(Some(of(row)[1]), 2));
    table.column("depth um", |row| fixed(Some(of(row)[2]), 1));
}

/// Adds the columns that identify a load. `of` gives pressure in MPa, speed in mm/s and humidity in per cent.
fn load<T>(table: &mut Records<'_, T>, of: fn(&T) -> [f64; 3]) {
    table.column("P MPa", |row| fixed(Some(of(row)[0]), 3));
    table.column("v mm/s", |row| of(row)[1].to_string());
    table.column("RH %", |row| of(row)[2].to_string());
}

impl TrialsReport {
    /// Every measured ratio, paired with its trial.
    pub(crate) fn rows(&self) -> Vec<(&TrialReport, &MeasuredReport)> {
        self.trials.iter().flat_map(|trial| trial.measured.iter().map(move |at| (trial, at))).collect()
    }

    /// States the number of trials and of measured ratios.
    fn size_in_words(&self) -> String {
        let measured: usize = self.trials.iter().map(|trial| trial.measured.len()).sum();
        format!("{} with {}", counted(self.trials.len(), "trial"), counted(measured, "measured ratio"))
    }

    /// States the name of the calibration, the size of the ledger and the names of pending samples, in one line.
    fn heading(&self) -> String {
        format!(
            "{}: {}{}",
            self.name,
            self.size_in_words(),
            if self.pending.is_empty() { String::new() } else { format!("; pending: {}", self.pending.join(", ")) }
        )
    }

    /// Describes the form of the discrepancy that the trials identify, in one sentence.
    pub(crate) fn form_in_words(&self) -> String {
        match &self.identified {
            Some(family) if family == Form::None.family() => "the trials show no effect beyond the model's".to_owned(),
            Some(family) => format!("the trials say that the discrepancy grows with {family}"),
            None if self.one_texture => {
                let (some, other) = match self.trials.len() {
                    1 => ("one texture does", "a second, different one"),
                    _ => ("textures so alike do", "a different one"),
                };
                format!("{some} not tell whether the error grows with area, edges or depth; {other} would")
            }
            None => "form not identified: trials of other densities, edge lengths and depths would tell forms apart"
                .to_owned(),
        }
    }

    /// Table of measured ratios with modelled ratios and predictions from earlier trials; `in_brief` leaves out the
    /// texture and the deviation from the prediction.
    pub(crate) fn ledger(&self, in_brief: bool) -> Table {
        let rows = self.rows();
        let mut table = Table::of(&rows);
        table.column("trial", |(trial, _)| trial.name.clone());
        if !in_brief {
            sample(&mut table, |(trial, _)| [trial.areal_density, trial.edge_per_mm, trial.depth_um]);
        }
        load(&mut table, |(_, at)| [at.pressure_mpa, at.speed_mm_s, at.humidity_pct]);
        table.column("measured", |(_, at)| fixed(Some(at.measured), 3));
        table.column("model", |(_, at)| fixed(Some(at.modelled), 3));
        table.column(if in_brief { "predicted before" } else { "before" }, |(_, at)| believed(at.before.ratio, 3));
        table.column("95 %", |(_, at)| believed_interval(at.before.interval_95));
        if !in_brief {
            table.column("surprise, std", |(_, at)| fixed(Some(at.before.surprise), 1));
        }
        table.table()
    }

    /// Table of predictions for samples that are not measured yet.
    pub(crate) fn pending_table(&self) -> Table {
        let rows: Vec<(&PendingTrial, &RatioPrediction)> =
            self.predicted.iter().flat_map(|of| of.predicted.iter().map(move |at| (of, at))).collect();
        let mut table = Table::of(&rows);
        table.column("pending", |(of, _)| of.name.clone());
        sample(&mut table, |(of, _)| [of.areal_density, of.edge_per_mm, of.depth_um]);
        load(&mut table, |(_, at)| [at.pressure_mpa, at.speed_mm_s, at.humidity_pct]);
        table.column("model", |(_, at)| fixed(Some(at.modelled), 3));
        table.column("predicted", |(_, at)| believed(at.ratio, 3));
        table.column("95 %", |(_, at)| believed_interval(at.interval_95));
        table.table()
    }

    /// Table of the posterior and prior weights of the forms of the discrepancy.
    pub(crate) fn forms_table(&self) -> Table {
        let mut table = Table::of(&self.forms);
        table.column("form", |of| of.form.clone());
        table.column("weight", |of| fixed(Some(of.weight), 3));
        table.column("before", |of| fixed(Some(of.prior), 3));
        table.table()
    }

    /// Table of the discrepancy at the texture measured last, and of its dependence on the condition.
    pub(crate) fn effects_table(&self) -> Table {
        let mut table = Table::of(&self.effects);
        table.column("quantity", |of| of.of.clone());
        table.column("value", |of| fixed(Some(of.value), 3));
        table.column("+-", |of| believed_std(of.std));
        table.column("+- before", |of| believed_std(of.prior_std));
        table.table()
    }

    /// Formats the ledger as text.
    pub fn text(&self) -> String {
        let mut text = self.heading() + "\n";
        text += &crate::marked("!", &self.warnings);
        if self.trials.is_empty() {
            text += "no trial was measured: what the model lacks is as wide as what is believed before\n";
        } else {
            text += "\nratios patterned / flat: measured, modelled, and predicted by the trials before\n";
            text += &self.ledger(false).to_string();
            text += "surprise, std: number of standard deviations by which a normal value as improbable as the measured ratio lies off its prediction\n";
            for of in &self.coverage {
                text += &of.text();
            }
        }
        self.lands.iter().for_each(|land| text += &format!("{}\n", land.words));
        if !self.predicted.is_empty() {
            text += "\npending: cut and not yet measured; ratios modelled, and predicted by all trials\n";
            text += &self.pending_table().to_string();
        }
        text += "\nhow the discrepancy grows with the texture: weight now, and before any trial\n";
        text += &self.forms_table().to_string();
        text += &(self.form_in_words() + "\n");
        text += &self.scatter.map_or_else(String::new, |scatter| scatter.text());
        text += "\nln(measured / modelled)\n";
        text += &(self.effects_table().to_string() + &less_known(&self.effects));
        if !self.load_lines.is_empty() {
            text += "\nfriction force F = dF/dN (N - N0); N0 > 0: something bears load without friction\n";
            text += &load_lines::table(&self.load_lines).to_string();
        }
        text
    }

    /// Formats the ledger for the screen; [`Self::text`] has all details.
    pub fn brief(&self) -> String {
        let line = |text: &str, indent: &str| wrapped(text, SCREEN_WIDTH, indent, 2) + "\n";
        let mut text = line(&self.heading(), "  ") + &doubts_in_brief(&self.warnings);
        if self.trials.is_empty() {
            text += &line("no trial was measured: the error of the model is as wide as the prior", "  ");
        } else {
            text += &format!("\n  ratio to the flat surface\n{}", self.ledger(true).brief(MAX_RATIOS));
            let counted = self.coverage.iter().filter(|of| of.ratios > 0);
            counted.for_each(|of| text += &line(&format!("  {}", of.text().trim_end()), "    "));
        }
        self.lands.iter().for_each(|land| text += &line(&format!("  {}", land.words), "    "));
        text += &line(&format!("  {}", self.form_in_words()), "    ");
        text + "forms and sizes of the discrepancy, scatter of samples, pending samples: with --details\n"
    }

    /// States the size of the ledger and the discrepancy at the texture of the last trial, in one line.
    pub(crate) fn learned_in_words(&self) -> String {
        let of_last = self.effects.first().filter(|_| !self.trials.is_empty());
        let found = of_last.map_or_else(String::new, |of| {
            let (by, side) = (100.0 * of.value.exp_m1(), if of.value < 0.0 { "below" } else { "above" });
            let std = 100.0 * of.std * of.value.exp();
            let std = if std > MAX_STD_PCT { "unsure by half or more".to_owned() } else { format!("+- {std:.0} %") };
            format!("; {}: measured ratios lie {:.0} % {side} the model's ({std})", of.of, by.abs())
        });
        self.size_in_words() + &found
    }

    /// Formats the ledger as CSV, one row per measured ratio.
    pub fn csv(&self) -> String {
        let quoted = |text: &str| format!("\"{}\"", guard_formula(text).replace('"', "\"\""));
        let rows = self.rows();
        let mut table = Table::of(&rows);
        table.column("trial", |(trial, _)| quoted(&trial.name));
        table.column("date", |(trial, _)| quoted(&trial.date));
        table.numbers("areal_density", |(trial, _)| trial.areal_density);
        table.numbers("edge_per_mm", |(trial, _)| trial.edge_per_mm);
        table.numbers("width_um", |(trial, _)| trial.width_um);
        table.numbers("spacing_um", |(trial, _)| trial.spacing_um);
        table.numbers("depth_um", |(trial, _)| trial.depth_um);
        table.numbers("pressure_mpa", |(_, at)| at.pressure_mpa);
        table.numbers("speed_mm_s", |(_, at)| at.speed_mm_s);
        table.numbers("humidity_pct", |(_, at)| at.humidity_pct);
        table.numbers("measured_ratio", |(_, at)| at.measured);
        table.numbers("modelled_ratio", |(_, at)| at.modelled);
        table.numbers("predicted_before", |(_, at)| at.before.ratio);
        table.numbers("predicted_before_low_95", |(_, at)| at.before.interval_95[0]);
        table.numbers("predicted_before_high_95", |(_, at)| at.before.interval_95[1]);
        table.numbers("surprise_before", |(_, at)| at.before.surprise);
        table.numbers("predicted_without_trial", |(_, at)| at.without_trial.ratio);
        table.numbers("surprise_without_trial", |(_, at)| at.without_trial.surprise);
        table.numbers("predicted_without_condition", |(_, at)| at.without_condition.ratio);
        table.numbers("surprise_without_condition", |(_, at)| at.without_condition.surprise);
        table.table().csv()
    }
}

impl Coverage {
    /// States the number of ratios within their predicted intervals in one line.
    fn text(&self) -> String {
        let Self { by, ratios, without_any, within_68, within_95 } = self;
        let mut parts = Vec::new();
        if *ratios > 0 {
            parts.push(format!("{within_68} of {ratios} within 68 %, {within_95} within 95 %"));
        }
        if *without_any > 0 {
            let (ratios, are) = if *without_any == 1 { ("ratio", "is") } else { ("ratios", "are") };
            parts.push(format!("{without_any} {ratios} {are} not counted, because no other measurement says anything of what the model lacks there"));
        }
        format!("predicted by {by}: {}\n", parts.join("; "))
    }
}
