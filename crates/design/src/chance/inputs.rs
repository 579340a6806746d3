//! What is not known exactly, put together block by block.

use super::*;

/// Covariances under construction.
pub(super) struct Parts {
    pub inputs: Vec<Input>,
    pub blocks: Vec<Covariance>,
    pub count: usize,
}

impl Parts {
    /// Adds a block and returns the place of its first input.
    pub fn add(&mut self, block: Covariance) -> usize {
        let first = self.count;
        self.count += block.len();
        self.blocks.push(block);
        first
    }

    pub fn name(&mut self, name: &'static str, known_to: String, places: Range<usize>) {
        self.inputs.push(Input { name, known_to, places });
    }
}

pub(super) fn of_dimensions(tolerances: &Tolerances) -> Vec<Input> {
    let named = ["width", "spacing", "depth"].into_iter().zip(tolerances.std_m).enumerate();
    named
        .filter(|(_, (_, std_m))| *std_m > 0.0)
        .map(|(axis, (name, std_m))| Input {
            name,
            known_to: format!("made to {} um", tidy(LENGTH_UM.from_si(std_m))),
            places: axis..axis + 1,
        })
        .collect()
}

/// Blocks along the diagonal.
pub(crate) fn diagonal(blocks: &[Covariance]) -> Covariance {
    let count = blocks.iter().map(Vec::len).sum();
    let mut all = vec![vec![0.0; count]; count];
    let mut first = 0;
    for block in blocks {
        for (row, entries) in block.iter().enumerate() {
            all[first + row][first..first + block.len()].copy_from_slice(entries);
        }
        first += block.len();
    }
    all
}

/// Root mean square of the standard deviations on the diagonal.
pub(super) fn rms(covariance: &[Vec<f64>]) -> f64 {
    let sum: f64 = covariance.iter().enumerate().map(|(place, row)| row[place]).sum();
    (sum / covariance.len().max(1) as f64).sqrt()
}

pub(super) fn percent(std: f64) -> String {
    let percent = 100.0 * std;
    if percent < 9.95 { format!("known to {percent:.1} %") } else { format!("known to {percent:.0} %") }
}
