//! The ledger of trials on the screen, in about 20 lines.

use slipgrid_design::results::{SCREEN_WIDTH, Table, believed, believed_interval, doubts_in_brief, fixed, wrapped};

use super::TrialsReport;

/// Standard deviation, in per cent, above which none is stated.
const MAX_STD_PCT: f64 = 50.0;
/// Maximum number of ratios on the screen; the others are counted.
const MAX_RATIOS: usize = 8;

impl TrialsReport {
    /// Formats the ledger for the screen; [`Self::text`] has all details.
    #[must_use]
    pub fn brief(&self) -> String {
        let line = |text: &str, indent: &str| wrapped(text, SCREEN_WIDTH, indent, 2) + "\n";
        let mut text = line(&self.heading(), "  ") + &doubts_in_brief(&self.warnings);
        if self.trials.is_empty() {
            text += &line("no trial was measured: the error of the model is as wide as the prior", "  ");
        } else {
            let mut table =
                Table::new(["trial", "P MPa", "v mm/s", "RH %", "measured", "model", "predicted before", "95 %"]);
            for (trial, at) in self.trials.iter().flat_map(|trial| trial.measured.iter().map(move |at| (trial, at))) {
                table.row([
                    trial.name.clone(),
                    fixed(Some(at.pressure_mpa), 3),
                    at.speed_mm_s.to_string(),
                    at.humidity_pct.to_string(),
                    fixed(Some(at.measured), 3),
                    fixed(Some(at.modelled), 3),
                    believed(at.before.ratio, 3),
                    believed_interval(at.before.interval_95),
                ]);
            }
            text += &format!("\n  ratio to the flat surface\n{}", table.brief(MAX_RATIOS));
            let counted = self.coverage.iter().filter(|of| of.ratios > 0);
            counted.for_each(|of| text += &line(&format!("  {}", of.text().trim_end()), "    "));
        }
        self.lands_text().lines().for_each(|land| text += &line(&format!("  {land}"), "    "));
        text += &line(&format!("  {}", self.form_in_words()), "    ");
        text + "forms and sizes of the discrepancy, scatter of samples, pending samples: with --details\n"
    }

    /// Size of the ledger and the discrepancy at the texture of the last trial, in one line.
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
}
