//! A simulation as text: in brief for the screen, and with all details.

use slipgrid_base::units::counted;
use slipgrid_model::springblock::Status;

use super::errors::ErrorReport;
use super::notes::{SCREEN_WIDTH, doubts_in_brief, notes, wrapped};
use super::simulation::{LoadReport, SimulationReport};
use super::table::{Table, fixed};

/// Maximum number of loads on the screen; the others are counted.
const MAX_LOADS: usize = 8;

impl SimulationReport {
    /// Formats the report for the screen; [`Self::text`] has all details.
    pub fn brief(&self) -> String {
        let line = |text: &str, indent: &str| wrapped(text, SCREEN_WIDTH, indent, 3) + "\n";
        let mut text = line(&self.heading(), "  ") + "\n" + &self.load_table().brief(MAX_LOADS);
        text += &line(&format!("  {}", self.errors.meaning), "  ");
        if let Some(corrected) = &self.discrepancy {
            text += &format!("\n  {}\n{}", corrected.meaning(), corrected.table().brief(MAX_LOADS));
        }
        text += &doubts_in_brief(&self.doubts());
        text + &format!("{}; 95 % intervals, assumptions, method: with --details\n", self.duration())
    }

    /// Surface, fidelity and extent in one line.
    fn heading(&self) -> String {
        let surface = self.pattern.as_ref().map_or_else(
            || "flat surface".to_owned(),
            |p| {
                let words = p.texture_words();
                format!(
                    "{} {} um wide, spacing {} um, {} um deep{words}",
                    p.planform(),
                    p.width_um,
                    p.spacing_um,
                    p.depth_um
                )
            },
        );
        format!("{surface}; {}, {}", self.fidelity, self.extent)
    }

    fn duration(&self) -> String {
        format!("{:.3} s on {}", self.wall_s, counted(self.threads, "thread"))
    }

    /// Formats the report as text.
    pub fn text(&self) -> String {
        let mut text = self.heading() + "\n";
        text += &notes(self.model.iter().map(String::as_str), &self.method);
        text.push('\n');
        text += &self.load_table().to_string();
        text += &format!("  {}\n", self.errors.meaning);
        let ratios = self.errors.intervals("ratio", |row| row.ratio.clone());
        for line in ratios.into_iter().chain(self.errors.intervals("mu_dynamic", |row| Some(row.mu.clone()))) {
            text += &format!("  {line}\n");
        }
        if let Some(words) = self.blocks_words() {
            text += &format!("  {words}\n");
        }
        if let Some(corrected) = &self.discrepancy {
            text += &corrected.text();
        }
        for doubt in self.doubts() {
            text += &format!("! {doubt}\n");
        }
        text + &format!("\n{}\n", self.duration())
    }

    /// Describes the largest discretization error of the ratio; `None` if no load has one.
    fn blocks_words(&self) -> Option<String> {
        let each = self.results.iter().filter_map(LoadReport::blocks_error);
        let largest = each.reduce(f64::max)?;
        Some(format!(
            "blocks: with vanishing ones the ratio would change by {largest:.4} at most, as blocks of other sizes say"
        ))
    }

    fn load_table(&self) -> Table {
        let has = |value: fn(&LoadReport) -> bool| self.results.iter().any(value);
        let patterned = self.pattern.is_some();
        let mut header = vec!["P MPa", "mu_dynamic", "+-"];
        if has(|load| load.mu_static.is_some()) {
            header.extend(["mu_static", "+-"]);
        }
        if patterned {
            header.extend(["mu_flat", "+-", "ratio", "+-"]);
        }
        if self.section_model {
            header.extend(["strip ratio", "+-"]);
        }
        header.extend(["peak MPa", "status"]);
        let with_static = header.contains(&"mu_static");
        let mut table = Table::new(header);
        for (load, at) in self.results.iter().zip(&self.errors.by_pressure) {
            let std = |of: Option<&ErrorReport>| of.and_then(|of| of.std);
            let mut cells = vec![load.mu_dynamic, std(Some(&at.mu))];
            if with_static {
                cells.extend([load.mu_static, std(at.mu_static.as_ref())]);
            }
            if patterned {
                cells.extend([load.mu_flat, std(at.mu_flat.as_ref()), load.ratio, std(at.ratio.as_ref())]);
            }
            if self.section_model {
                // 1 - (width / pitch) (1 - ratio): its error is smaller by width over pitch.
                let share = self.pattern.as_ref().map(|p| p.width_um / (p.width_um + p.spacing_um));
                let own = std(at.ratio.as_ref()).zip(share).map(|(std, share)| share * std);
                cells.extend([load.ratio_strip_estimate, own]);
            }
            let cells = cells.into_iter().map(|cell| fixed(cell, 4));
            let peak_mpa = Some(load.peak_pressure_mpa).filter(|_| load.status != Status::NotConverged.name());
            let last = [fixed(peak_mpa, 2), load.status.to_string()];
            table.row([load.pressure_mpa.to_string()].into_iter().chain(cells).chain(last));
        }
        table
    }
}
