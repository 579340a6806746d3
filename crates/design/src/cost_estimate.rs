//! What a design takes, said before it is begun.

use slipgrid_springblock::{Expense, RunOptions, Scene, expense};

use crate::DesignError;
use crate::lattice_table::lattice;
use crate::multi_fidelity::MultiFidelityLoop;
use crate::task::DesignTask;

/// Seconds, and bytes, up to which nothing is said.
const SHORT_S: f64 = 30.0;
const SMALL_BYTES: f64 = (1_u64 << 30) as f64;

/// Designs that a search, and what is said of its best one, ask of: of the model in the plane, and in space of its guide
/// and of the model itself.
const PLANE_DESIGNS: f64 = 200.0;
const GUIDE_DESIGNS: f64 = 400.0;
const SOLID_DESIGNS: f64 = 25.0;
/// Cells of larger blocks, as a guide's are, cost this share of the model's.
const GUIDE_SHARE: f64 = 0.02;
/// A search condenses its cells: they cost this share of all equations.
const CONDENSED_SHARE: f64 = 0.03;
/// Confirming runs go on until their standard error is small enough: they are usually this much longer.
const CONFIRMED_TIMES: f64 = 1.5;

impl MultiFidelityLoop<'_> {
    /// Says what the search and one confirming run take, where that is much, at the middle of the bounds; a table, samples
    /// and trade-offs in the plane with them.
    ///
    /// # Errors
    /// [`DesignError::Input`] where the confirming run takes more memory or time than anybody means to give it.
    pub(super) fn announce(&self, design: &DesignTask) -> Result<(), DesignError> {
        let space = &design.space;
        let Ok(pattern) = space.middle() else { return Ok(()) };
        let searched = self.model.scene(&pattern);
        let draws = self.model.draws(&pattern, crate::confirmation::LEAST_CONTACTS);
        let run = RunOptions { draws, ..self.round.confirming };
        let confirmed = Scene { run, ..searched.clone() };
        // A middle that is no design says nothing of the others.
        if searched.validate().is_err() || confirmed.validate().is_err() {
            return Ok(());
        }
        slipgrid_springblock::bounded(&confirmed).map_err(|error| design.refuse_blocks(&error))?;
        let (cell, run) = (expense(&searched), expense(&confirmed));
        // Searches look at the whole space, where the largest cells cost most.
        let widest = space.pattern([space.width_m()[1], space.spacing_m()[1], pattern.depth_m()]);
        let largest = widest.ok().map(|widest| self.model.scene(&widest)).filter(|scene| scene.validate().is_ok());
        let spread_s = f64::midpoint(cell.core_s, largest.map_or(cell.core_s, |scene| expense(&scene).core_s));
        let threads = rayon::current_num_threads() as f64;
        let search_s = if self.model.is_cheap_per_design() {
            let table = if design.table { lattice(design).0.len() } else { 0 };
            let draws = design.tolerances.map_or(0, |tolerances| tolerances.draws);
            let compared = design.trade_offs.as_ref().map_or(0, |input| input.designs);
            spread_s * CONDENSED_SHARE * (PLANE_DESIGNS + (table + draws + compared) as f64)
        } else {
            spread_s * GUIDE_DESIGNS * GUIDE_SHARE + cell.core_s * SOLID_DESIGNS
        };
        let run_s = CONFIRMED_TIMES * run.wall_s;
        let all = Expense {
            core_s: search_s + CONFIRMED_TIMES * run.core_s,
            wall_s: search_s / threads + run_s,
            bytes: run.bytes.max(cell.bytes * threads),
        };
        let line = cost_line("a search with one confirming run", all, false, rayon::current_num_threads());
        if let Some(line) = line {
            self.monitor.note(&line);
        }
        Ok(())
    }
}

/// That `what` takes `expense` on `threads` threads, where that is more than half a minute or a gigabyte; `may_go_on`: until a
/// standard error is small enough.
#[must_use]
pub fn cost_line(what: &str, expense: Expense, may_go_on: bool, threads: usize) -> Option<String> {
    if expense.wall_s <= SHORT_S && expense.bytes <= SMALL_BYTES {
        return None;
    }
    let time = duration(expense.wall_s);
    let longer = if may_go_on { " or, until the standard error is small enough, longer" } else { "" };
    let memory = if expense.bytes > SMALL_BYTES {
        format!(" and {:.1} GiB of memory", expense.bytes / SMALL_BYTES)
    } else {
        String::new()
    };
    Some(format!("{what} takes about {time}{longer}{memory}, estimated for {threads} threads with cores of their own"))
}

/// Seconds in the unit that fits them.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 100.0 => format!("{:.0} s", s.ceil()),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.0} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_long_or_large_is_said() {
        let expense = |wall_s: f64, gib: f64| Expense { core_s: wall_s, wall_s, bytes: gib * SMALL_BYTES };
        assert_eq!(cost_line("this run", expense(29.0, 0.9), true, 2), None);
        let told = cost_line("this run", expense(31.0, 0.1), false, 2).unwrap();
        assert_eq!(told, "this run takes about 31 s, estimated for 2 threads with cores of their own");
        let told = cost_line("this run", expense(7300.0, 2.0), true, 2).unwrap();
        assert!(told.contains("2 h or, until") && told.contains("2.0 GiB of memory"), "{told}");
        assert!(cost_line("a", expense(1.0, 1.5), false, 1).unwrap().contains("about 1 s and 1.5 GiB"));
        assert_eq!((duration(600.0), duration(1e6)), ("10 min".to_owned(), "12 days".to_owned()));
    }
}
