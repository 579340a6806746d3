//! Cells that were condensed last: one texture slides under several moduli, area laws and measurements, of which its equations know nothing.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::CondensedCell;
use crate::lattice::Lattice;

/// Multiplications from which a cell is worth remembering: some milliseconds.
pub const WORTH_REMEMBERING: f64 = 1e7;
/// Numbers that remembered cells hold at most: 64 MB.
const MOST_NUMBERS: usize = 8 << 20;

/// What came of a cell, once it has been condensed.
type Made = Arc<OnceLock<Option<Arc<CondensedCell>>>>;

/// Cells that were made, the latest last, and how many numbers they hold at most.
pub struct Latest {
    made: Mutex<Vec<(Lattice, Made)>>,
    most_numbers: usize,
}

/// Those of this process.
pub static LATEST: Latest = Latest::of(MOST_NUMBERS);

impl Latest {
    const fn of(most_numbers: usize) -> Self {
        Self { made: Mutex::new(Vec::new()), most_numbers }
    }

    /// The cell of `lattice`, as `condense` makes it or has made it before; one that another thread is condensing is waited for.
    pub fn recall(
        &self,
        lattice: &Lattice,
        condense: impl FnOnce() -> Option<Arc<CondensedCell>>,
    ) -> Option<Arc<CondensedCell>> {
        let all = || self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let own = {
            let mut all = all();
            let known = all.iter().position(|(known, _)| known == lattice).map(|place| all.remove(place));
            let (lattice, own) = known.unwrap_or_else(|| (lattice.clone(), Made::default()));
            all.push((lattice, Arc::clone(&own)));
            own
        };
        let cell = own.get_or_init(condense).clone();
        let mut all = all();
        while all.iter().map(|(_, made)| numbers(made)).sum::<usize>() > self.most_numbers {
            all.remove(0);
        }
        cell
    }
}

/// Numbers that a cell holds.
fn numbers(made: &Made) -> usize {
    let size = |cell: &Arc<CondensedCell>| cell.response.influence.len() + cell.unknowns.len();
    made.get().and_then(Option::as_ref).map_or(0, size)
}

#[cfg(test)]
mod tests {
    use super::super::Equations;
    use super::*;
    use crate::columns;
    use crate::samples::groove;

    #[test]
    fn a_cell_is_condensed_once_and_the_oldest_are_forgotten() {
        let lattice = |width_um: f64| Lattice::new(columns::cell(&groove(width_um, 100.0, 20.0), 10e-6), 20, true);
        let made = |lattice: &Lattice| Equations::of(lattice, &[], false)?.condense(lattice).map(Arc::new);
        let of_one = numbers(&Arc::new(OnceLock::from(made(&lattice(80.0)))));
        let latest = Latest::of(2 * of_one + of_one / 2);
        let widths = [80.0, 81.0, 80.0, 82.0, 80.0, 81.0];
        let anew: Vec<bool> = widths
            .into_iter()
            .map(|width_um| {
                let mut is_new = false;
                let lattice = lattice(width_um);
                let found = latest.recall(&lattice, || {
                    is_new = true;
                    made(&lattice)
                });
                assert!(found.is_some());
                is_new
            })
            .collect();
        // The third one of 82 um has put out that of 81 um, which was asked for before the other.
        assert_eq!(anew, [true, true, false, true, false, true]);
    }
}
