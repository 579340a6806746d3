//! Cache of condensed cells. One texture is solved for several moduli, area laws and measurements, on which the
//! condensed equations do not depend.

use std::cell::RefCell;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::CondensedCell;
use crate::springblock::Lattice;

/// Minimum number of multiplications for condensing a cell for an entry in the shared cache; this number takes some
/// milliseconds.
pub const MIN_SHARED_PRODUCTS: f64 = 1e7;
/// Maximum number of f64 values in the shared cache, which take 64 MB.
const MAX_NUMBERS: usize = 8 << 20;

thread_local! {
    /// The last cell that this thread has condensed, with its lattice. Small cells are not worth an entry in the shared
    /// cache; with one entry the memory is reused.
    static THREAD_CACHE: RefCell<Option<(Lattice, Arc<CondensedCell>)>> = const { RefCell::new(None) };
}

/// Returns the cell of `lattice` from this thread's cache, or condenses it.
pub fn get_or_condense_per_thread(
    lattice: &Lattice,
    condense: impl FnOnce() -> Option<Arc<CondensedCell>>,
) -> Option<Arc<CondensedCell>> {
    let known = THREAD_CACHE
        .with_borrow(|own| own.as_ref().filter(|(known, _)| known == lattice).map(|(_, cell)| Arc::clone(cell)));
    if known.is_some() {
        return known;
    }
    // Free the memory of the old cell before the new one is created.
    THREAD_CACHE.set(None);
    let cell = condense()?;
    THREAD_CACHE.set(Some((lattice.clone(), Arc::clone(&cell))));
    Some(cell)
}

/// Result of condensing a cell, empty while it is being condensed.
type CacheEntry = Arc<OnceLock<Option<Arc<CondensedCell>>>>;

/// Cache of condensed cells, the most recently used last, with the maximum number of f64 values in it.
pub struct CellCache {
    made: Mutex<Vec<(Lattice, CacheEntry)>>,
    max_numbers: usize,
}

/// Cache that all threads of this process share.
pub static SHARED_CACHE: CellCache = CellCache::with_capacity(MAX_NUMBERS);

impl CellCache {
    const fn with_capacity(max_numbers: usize) -> Self {
        Self { made: Mutex::new(Vec::new()), max_numbers }
    }

    /// Returns the cell of `lattice` from the cache, or condenses it. Waits if another thread is condensing the same
    /// cell.
    pub fn get_or_condense(
        &self,
        lattice: &Lattice,
        condense: impl FnOnce() -> Option<Arc<CondensedCell>>,
    ) -> Option<Arc<CondensedCell>> {
        let all = || self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let own = {
            let mut all = all();
            let known = all.iter().position(|(known, _)| known == lattice).map(|place| all.remove(place));
            let (lattice, own) = known.unwrap_or_else(|| (lattice.clone(), CacheEntry::default()));
            all.push((lattice, Arc::clone(&own)));
            own
        };
        let cell = own.get_or_init(condense).clone();
        let mut all = all();
        while all.iter().map(|(_, made)| numbers(made)).sum::<usize>() > self.max_numbers {
            all.remove(0);
        }
        cell
    }
}

fn numbers(made: &CacheEntry) -> usize {
    let size = |cell: &Arc<CondensedCell>| cell.response.influence.len() + cell.unknowns.len();
    made.get().and_then(Option::as_ref).map_or(0, size)
}

#[cfg(test)]
mod tests {
    use super::super::Equations;
    use super::*;
    use crate::springblock::columns;
    use crate::springblock::tests::samples::groove;

    #[test]
    fn a_thread_has_its_last_cell_and_no_other() {
        let lattice = |width_um: f64| Lattice::new(columns::cell(&groove(width_um, 100.0, 20.0), 10e-6), 20, true);
        let anew = [80.0, 80.0, 81.0, 80.0].map(|width_um| {
            let (lattice, mut is_new) = (lattice(width_um), false);
            let found = get_or_condense_per_thread(&lattice, || {
                is_new = true;
                Equations::for_lattice(&lattice, false)?.condense(&lattice).map(Arc::new)
            });
            let expected = Equations::for_lattice(&lattice, false).unwrap().condense(&lattice).unwrap();
            assert_eq!(found.unwrap().unknowns, expected.unknowns);
            is_new
        });
        assert_eq!(anew, [true, false, true, true]);
        assert_eq!(get_or_condense_per_thread(&lattice(82.0), || None).map(|cell| cell.unknowns.len()), None);
    }

    #[test]
    fn a_cell_is_condensed_once_and_the_oldest_are_forgotten() {
        let lattice = |width_um: f64| Lattice::new(columns::cell(&groove(width_um, 100.0, 20.0), 10e-6), 20, true);
        let made = |lattice: &Lattice| Equations::for_lattice(lattice, false)?.condense(lattice).map(Arc::new);
        let of_one = numbers(&Arc::new(OnceLock::from(made(&lattice(80.0)))));
        let latest = CellCache::with_capacity(2 * of_one + of_one / 2);
        let widths = [80.0, 81.0, 80.0, 82.0, 80.0, 81.0];
        let anew: Vec<bool> = widths
            .into_iter()
            .map(|width_um| {
                let mut is_new = false;
                let lattice = lattice(width_um);
                let found = latest.get_or_condense(&lattice, || {
                    is_new = true;
                    made(&lattice)
                });
                assert!(found.is_some());
                is_new
            })
            .collect();
        // The third request for 82 um evicted 81 um, which was used before the other.
        assert_eq!(anew, [true, true, false, true, false, true]);
    }
}
