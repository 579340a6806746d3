//! What a choice asks of, counted before it is made.

use super::{JUDGED, JUDGED_ROUNDS, LINE, REFINED, SECANT_STEPS, SelectionOptions};

/// Share of the nodes' lines that cross the shell, about: choices in space had a third to nine tenths.
const CROSSING: f64 = 0.6;
/// Leaders over [`REFINED`], as those by rank and by chance are partly the same.
const LEADERS: f64 = 1.5;
/// Designs of a line about a leader, where some are known and some are off the grid.
const OF_A_LINE: f64 = 4.0;

/// Numbers of questions, about: a choice may ask half as many, or not quite twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SelectionCount {
    /// Designs that the model, or its guide, is asked of.
    pub designs: f64,
    /// Designs whose chance is asked for, those asked for again counted again.
    pub chances: f64,
    /// Designs that the dear model judges after its guide; 0 without one.
    pub judged: f64,
}

impl SelectionOptions {
    /// What a choice with these options asks of in a space of `free` dimensions: [`select_multi_fidelity`](crate::select_multi_fidelity)
    /// where `is_guided`, [`select`](crate::select) otherwise. Of n nodes, r refinements of k leaders each, and c the share of lines
    /// that cross the shell:
    ///
    /// ```text
    /// lines = r k (1 + 2 (free - 1))        designs = n (5 + 3 c) + 4 lines        on target = c n + lines
    /// guided: judged = 2 * 8, designs + judged, chances = 2 on target + judged; otherwise chances = on target
    /// ```
    #[must_use]
    pub fn count(&self, free: usize, is_guided: bool) -> SelectionCount {
        if free == 0 {
            return SelectionCount { designs: 0.0, chances: 0.0, judged: 0.0 };
        }
        let nodes = if free == 1 { 1.0 } else { self.nodes as f64 };
        let lines = self.refinements as f64 * LEADERS * REFINED as f64 * (2 * free - 1) as f64;
        let designs = nodes * (LINE.len() as f64 + CROSSING * SECANT_STEPS as f64) + OF_A_LINE * lines;
        let on_target = CROSSING * nodes + lines;
        if !is_guided {
            return SelectionCount { designs, chances: on_target, judged: 0.0 };
        }
        let judged = (JUDGED_ROUNDS * JUDGED) as f64;
        // Every round judges anew what it has found, and the model what it has judged.
        SelectionCount { designs: designs + judged, chances: JUDGED_ROUNDS as f64 * on_target + judged, judged }
    }
}
