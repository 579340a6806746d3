//! What a design takes, said before it is begun.

use slipgrid_pattern::Pattern;
use slipgrid_springblock::{Expense, RunOptions, Scene, expense};

use super::rounds::Rounds;
use super::table::lattice;
use crate::commands::announcement::say;
use crate::formats::design::Design;
use crate::{CliError, Console};

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

impl Rounds {
    /// Says what the search and one confirming run take, where that is much, at the middle of the bounds; a table, samples
    /// and trade-offs in the plane with them.
    ///
    /// # Errors
    /// [`CliError::Input`] where the confirming run takes more memory or time than anybody means to give it.
    pub(super) fn announce(
        &self,
        design: &Design,
        with_table: bool,
        console: &mut Console<'_>,
    ) -> Result<(), CliError> {
        let middle = |[lower_m, upper_m]: [f64; 2]| (lower_m * upper_m).sqrt();
        let space = &design.space;
        let lengths_m = [space.width_m(), space.spacing_m(), space.depth_m()].map(middle);
        let [width_m, spacing_m, depth_m] = lengths_m;
        let Ok(pattern) = Pattern::new(*space.texture(), width_m, spacing_m, depth_m) else { return Ok(()) };
        let searched = self.model.scene(&pattern);
        let draws = self.model.draws(&pattern, super::confirmation::LEAST_CONTACTS);
        let run = RunOptions { draws, ..self.confirming };
        let confirmed = Scene { run, ..searched.clone() };
        // A middle that is no design says nothing of the others.
        if searched.validate().is_err() || confirmed.validate().is_err() {
            return Ok(());
        }
        slipgrid_springblock::bounded(&confirmed).map_err(|error| design.refuse_blocks(&error))?;
        let (cell, run) = (expense(&searched), expense(&confirmed));
        // Searches look at the whole space, where the largest cells cost most.
        let widest = Pattern::new(*space.texture(), space.width_m()[1], space.spacing_m()[1], depth_m);
        let largest = widest.ok().map(|widest| self.model.scene(&widest)).filter(|scene| scene.validate().is_ok());
        let spread_s = f64::midpoint(cell.core_s, largest.map_or(cell.core_s, |scene| expense(&scene).core_s));
        let threads = console.threads as f64;
        let search_s = if self.model.is_solid() {
            spread_s * GUIDE_DESIGNS * GUIDE_SHARE + cell.core_s * SOLID_DESIGNS
        } else {
            let table = if with_table { lattice(design).0.len() } else { 0 };
            let draws = design.tolerances.map_or(0, |tolerances| tolerances.draws);
            let compared = design.trade_offs.as_ref().map_or(0, |input| input.designs);
            spread_s * CONDENSED_SHARE * (PLANE_DESIGNS + (table + draws + compared) as f64)
        };
        let run_s = CONFIRMED_TIMES * run.wall_s;
        let all = Expense {
            core_s: search_s + CONFIRMED_TIMES * run.core_s,
            wall_s: search_s / threads + run_s,
            bytes: run.bytes.max(cell.bytes * threads),
        };
        say("a search with one confirming run", all, false, console);
        Ok(())
    }
}
