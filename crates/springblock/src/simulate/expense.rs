//! What solving a scene takes, roughly and before anything is begun.
//!
//! Rates are those of one core with vector units of 256 bits, rounded to the slow side: a run in time moves 6e8 blocks a
//! second by linear springs in the plane, 7e7 by exact ones, 1.5e8 in space (tests/accuracy), and a band factor takes
//! 2e-10 s a product.

use slipgrid_pattern::Pattern;

use super::space_strip::BYTES_PER_BLOCK as STRIP_BYTES_PER_BLOCK;
use super::{FLAT_CELL_COLUMNS, MOST_FACTOR_BYTES, UNIFORM_COLUMNS};
use crate::cell::{SteadyCell, condensing_cell};
use crate::dimension::Dimension;
use crate::dynamics::{MOST_STEPS, Plan, usual_step_s};
use crate::error::SceneError;
use crate::scene::{Extent, Fidelity, Scene, Springs};
use crate::space::SpaceLattice;
use crate::steady::{band_products, factor_bytes};

/// Seconds a block and force evaluation, by linear and by exact springs in the plane, and in space.
const LINEAR_S: f64 = 1.6e-9;
const EXACT_S: f64 = 14e-9;
const SPACE_S: f64 = 7e-9;
/// Seconds a product of a band factor, and an entry of it in a solution of its equations.
const PRODUCT_S: f64 = 2e-10;
const ENTRY_S: f64 = 5e-10;
/// Solutions that a load takes.
const SOLUTIONS: f64 = 15.0;
/// Seconds that a column of a steady cell in space takes for each explicit row and load, smooth and with rims or other heights
/// on its face: the median of cells of squares, discs and crossing grooves of 4 to 200 columns a side is 1.3e-6 and 2.6e-6.
const SPACE_COLUMN_S: f64 = 2e-6;
const RAISED_COLUMN_S: f64 = 4e-6;
/// Longest time of one core that is begun, in seconds: a month.
const MOST_CORE_S: f64 = 30.0 * 86_400.0;
/// Bytes a block of a run in time, and of one in space with its warm start.
const BYTES_PER_BLOCK: f64 = 200.0;
const SPACE_BYTES_PER_BLOCK: f64 = 900.0;

/// What solving a scene takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expense {
    /// Seconds of one core of its own. A run that goes on until its standard error is small enough may take twenty times
    /// as many.
    pub core_s: f64,
    /// The same where it runs on the cores of rayon's current pool.
    pub wall_s: f64,
    /// Memory, in bytes.
    pub bytes: f64,
}

/// What solving `scene`, which is valid, takes on rayon's current pool.
#[must_use]
pub fn expense(scene: &Scene) -> Expense {
    of_threads(scene, rayon::current_num_threads() as f64)
}

/// Refuses a scene that takes more memory or time than anybody means to give it, on one thread.
///
/// # Errors
/// [`SceneError::TooLarge`], [`SceneError::TooLong`].
pub fn bounded(scene: &Scene) -> Result<(), SceneError> {
    let Expense { core_s, bytes, .. } = of_threads(scene, 1.0);
    if bytes > MOST_FACTOR_BYTES {
        return Err(SceneError::TooLarge { bytes, most_bytes: MOST_FACTOR_BYTES });
    }
    if core_s > MOST_CORE_S {
        return Err(SceneError::TooLong { core_s, most_s: MOST_CORE_S });
    }
    Ok(())
}

fn of_threads(scene: &Scene, threads: f64) -> Expense {
    match (scene.run.fidelity, scene.dimension()) {
        (Fidelity::Steady, Dimension::Space) => space(scene, threads),
        (Fidelity::Steady, Dimension::Plane) => plane(scene, threads),
        (_, dimension) => in_time(scene, dimension == Dimension::Space, threads),
    }
}

/// Columns of the scene's own surface in the vertical plane, and of its flat companion.
fn surfaces(scene: &Scene) -> [Option<usize>; 2] {
    let whole = scene.layer.columns();
    match (&scene.pattern, scene.run.extent) {
        (None, Extent::Sample | Extent::Strip) => [Some(whole), None],
        (None, Extent::Cell) => [Some(whole.min(FLAT_CELL_COLUMNS)), None],
        (Some(_), Extent::Sample | Extent::Strip) => [Some(whole); 2],
        (Some(pattern), Extent::Cell) => {
            // At most 4e7: the cast is exact.
            let own = (pattern.pitch_m() / scene.layer.block_m).ceil() as usize;
            [Some(own), Some(if scene.run.fidelity == Fidelity::Steady { UNIFORM_COLUMNS } else { own })]
        }
    }
}

/// Steady sliding in the plane: a factor for each surface, side by side.
fn plane(scene: &Scene, threads: f64) -> Expense {
    let (rows, is_cell, loads) = (scene.layer.rows(), scene.run.extent == Extent::Cell, scene.loads.len() as f64);
    let (mut core_s, mut bytes) = (0.0, 0.0);
    if let Some(pattern) = scene.pattern.as_ref().filter(|_| is_cell && scene.layer.is_backed()) {
        let (products, bytes) = condensing_cell(pattern, scene.layer.block_m);
        return Expense { core_s: products * PRODUCT_S, wall_s: products * PRODUCT_S, bytes };
    }
    for columns in surfaces(scene).into_iter().flatten() {
        let own = factor_bytes(columns, rows, is_cell);
        bytes += own;
        // Of a strip a quarter of a ring's, whose band is twice as wide.
        let products = band_products(columns, rows) * if is_cell { 1.0 } else { 0.25 };
        core_s += products * PRODUCT_S + loads * SOLUTIONS * own / 8.0 * ENTRY_S;
    }
    Expense { core_s, wall_s: core_s / threads.min(2.0), bytes }
}

/// Columns of a strip of the sample in space, a period of `pattern` wide.
fn strip_columns(scene: &Scene, pattern: &Pattern) -> f64 {
    let [nx, ny] = SpaceLattice::columns_of(pattern, scene.layer.block_m);
    scene.layer.columns() as f64 * if pattern.texture().slides_along_rows() { ny } else { nx }
}

/// Steady sliding in space: one cell or a strip, its loads one after the other.
fn space(scene: &Scene, threads: f64) -> Expense {
    let Some(pattern) = &scene.pattern else { return Expense::default() };
    let model = SteadyCell::solved(scene, Dimension::Space);
    let column_s = if scene.is_raised() { RAISED_COLUMN_S } else { SPACE_COLUMN_S };
    let loads = scene.loads.len() as f64;
    if scene.run.extent == Extent::Strip {
        // Its ends are missing springs from the face to the bulk; the flat one is solved beside it.
        let blocks = strip_columns(scene, pattern) * (scene.layer.rows() + 1) as f64;
        let core_s = 2.0 * blocks * loads * column_s;
        return Expense { core_s, wall_s: core_s / threads.min(2.0), bytes: 2.0 * blocks * STRIP_BYTES_PER_BLOCK };
    }
    let [nx, ny] = model.columns(pattern);
    let explicit = (pattern.depth_m() / scene.layer.block_m).ceil() + 1.0;
    let core_s = nx * ny * explicit * loads * column_s;
    Expense { core_s, wall_s: core_s, bytes: model.bytes(pattern) }
}

/// Runs in time: one for each surface, load and draw.
fn in_time(scene: &Scene, is_spatial: bool, threads: f64) -> Expense {
    let rows = scene.layer.rows();
    let columns: Vec<f64> = match (&scene.pattern, is_spatial) {
        (Some(pattern), true) if scene.run.extent == Extent::Strip => vec![strip_columns(scene, pattern); 2],
        (Some(pattern), true) => {
            let [nx, ny] = SpaceLattice::columns_of(pattern, scene.layer.block_m);
            vec![nx * if pattern.is_uniform_along_y() { nx } else { ny }; 2]
        }
        _ => surfaces(scene).into_iter().flatten().map(|columns| columns as f64).collect(),
    };
    let steps = Plan::new(scene, scene.run.step_s.unwrap_or_else(|| usual_step_s(scene, is_spatial))).total();
    // Longer ones are not begun, and say so.
    let steps = if steps > MOST_STEPS { 0.0 } else { steps as f64 };
    let is_exact = match scene.run.springs {
        Some(springs) => springs == Springs::Exact,
        None => scene.run.fidelity == Fidelity::Reference,
    };
    let stages = if scene.run.fidelity == Fidelity::Reference { 4.0 } else { 1.0 };
    let block_s = if is_spatial {
        SPACE_S
    } else if is_exact {
        EXACT_S
    } else {
        LINEAR_S
    };
    let each = scene.loads.len() as f64 * scene.run.draws as f64;
    let blocks: f64 = columns.iter().map(|columns| columns * rows as f64).sum();
    let largest = columns.iter().copied().fold(0.0, f64::max);
    let at_once = threads.min(each * columns.len() as f64);
    let (mut core_s, mut bytes) = (each * blocks * steps * stages * block_s, 0.0);
    if is_spatial {
        bytes += at_once * largest * rows as f64 * SPACE_BYTES_PER_BLOCK;
    } else {
        bytes += at_once * largest * rows as f64 * BYTES_PER_BLOCK;
        if scene.run.warm_start {
            let is_cell = scene.run.extent == Extent::Cell;
            // Each run factors its own.
            bytes += at_once * factor_bytes(largest as usize, rows, is_cell);
            let products = band_products(largest as usize, rows) * if is_cell { 1.0 } else { 0.25 };
            core_s += each * columns.len() as f64 * products * PRODUCT_S;
        }
    }
    Expense { core_s, wall_s: core_s / at_once.max(1.0), bytes }
}

#[cfg(test)]
mod tests {
    use slipgrid_pattern::Planform;

    use super::*;
    use crate::Unwatched;
    use crate::samples;
    use crate::scene::{Layer, RunOptions};
    use crate::simulate::simulate;

    fn scene(fidelity: Fidelity, extent: Extent, block_m: f64) -> Scene {
        let run = RunOptions { fidelity, extent, ..RunOptions::default() };
        let scene = samples::scene(samples::groove(130.0, 370.0, 20.0), &[1.0; 2], run);
        Scene { area_law: None, layer: Layer { block_m, ..scene.layer }, ..scene }
    }

    #[test]
    fn it_is_of_the_size_that_runs_were_measured_to_have() {
        // Seconds and gigabytes on one core of 2.8 GHz.
        let within = |found: f64, measured: f64| found > 0.4 * measured && found < 3.0 * measured;
        for (found, core_s, bytes) in [
            (expense(&scene(Fidelity::Steady, Extent::Sample, 2.5e-6)), 13.5, 1.67e9),
            (expense(&scene(Fidelity::Steady, Extent::Cell, 1e-6)), 19.5, 1.28e9),
        ] {
            assert!(within(found.core_s, core_s) && within(found.bytes, bytes), "{found:?}");
        }
        // Squares of 130/370/20 um: 50 x 50 x 20 blocks, then 200 x 200 x 80 of them.
        for (block_m, core_s) in [(10e-6, 0.0088), (2.5e-6, 0.38)] {
            let mut squares = scene(Fidelity::Steady, Extent::Cell, block_m);
            squares.pattern = Some(Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6).unwrap());
            let found = expense(&squares).core_s;
            assert!(found > core_s && found < 5.0 * core_s, "{found} s, where {core_s} s were measured");
        }
        // Two surfaces, two loads, 250,000 steps of travel and 3000 of ramp and rest, 19,920 blocks.
        let dynamic = expense(&scene(Fidelity::Dynamic, Extent::Sample, 10e-6));
        assert!(within(dynamic.core_s, 4.0 * 253e3 * 19_920.0 / 6.9e8), "{dynamic:?}");
        let reference = expense(&scene(Fidelity::Reference, Extent::Sample, 10e-6));
        assert!(within(reference.core_s, 4.0 * 1.012e6 * 4.0 * 19_920.0 / 8.5e7), "{reference:?}");
    }

    #[test]
    fn what_is_not_begun_takes_no_time() {
        let mut slow = scene(Fidelity::Dynamic, Extent::Sample, 10e-6);
        slow.speed_m_s = 1e-9;
        assert_eq!(expense(&slow).core_s, 0.0);
    }

    #[test]
    fn what_takes_months_or_more_memory_than_there_is_is_refused_at_once() {
        let mut scene = scene(Fidelity::Dynamic, Extent::Sample, 1e-6);
        scene.layer.length_m = 0.19;
        scene.run.sliding_m = 75e-6;
        // What `simulate` asks first: a run that it did not refuse would not end.
        assert!(matches!(bounded(&scene), Err(SceneError::TooLong { .. })), "{:?}", expense(&scene));
        scene.run.fidelity = Fidelity::Steady;
        assert!(matches!(simulate(&scene, &Unwatched), Err(SceneError::TooLarge { .. })));
        // A pitch of millions of blocks is refused before its columns are counted out.
        scene.run.extent = Extent::Cell;
        scene.pattern = Some(Pattern::new(Planform::Groove, 130e-6, 0.15, 20e-6).unwrap());
        assert!(matches!(simulate(&scene, &Unwatched), Err(SceneError::TooLarge { .. })));
    }

    #[test]
    fn loads_and_draws_are_counted() {
        let one = expense(&scene(Fidelity::Dynamic, Extent::Cell, 10e-6));
        let mut many = scene(Fidelity::Dynamic, Extent::Cell, 10e-6);
        many.loads.extend(many.loads.clone());
        many.run.draws = 3;
        assert!((expense(&many).core_s / one.core_s - 6.0).abs() < 1e-9);
    }
}
