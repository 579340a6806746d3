//! Rough estimate of the cost of a scene, before anything is solved.
//!
//! Rates are those of one core with 256-bit vector units, rounded to the slow side. A dynamic run moves 6e8 blocks per
//! second with linear springs in the plane, 7e7 with exact springs, and 1.5e8 in space (tests/accuracy); a band
//! factorization takes 2e-10 s per product.

use crate::pattern::Pattern;

use super::blocks;
use super::space::MAX_ESTIMATED_BYTES;
use super::space_strip::BYTES_PER_BLOCK as STRIP_BYTES_PER_BLOCK;
use super::thick_layer::ThickLayerCorrection;
use super::{FLAT_CELL_COLUMNS, UNIFORM_COLUMNS, require_memory};
use crate::springblock::cell::cell_condensing_cost;
use crate::springblock::dynamics::{Plan, default_step_s};
use crate::springblock::space::{MAX_DIRECTIONS, MAX_STORED_DIRECTIONS};
use crate::springblock::steady::{band_products, factor_bytes};
use crate::springblock::{
    Dimension, Extent, Fidelity, MAX_STEPS, Scene, SceneError, SpaceLattice, Springs, SteadyCell,
};

/// Seconds per block and force evaluation with linear springs in the plane.
const LINEAR_S: f64 = 1.6e-9;
/// Seconds per block and force evaluation with exact springs in the plane.
const EXACT_S: f64 = 14e-9;
/// Seconds per block and force evaluation in space.
const SPACE_S: f64 = 7e-9;
/// Seconds per multiplication of a band factorization.
const PRODUCT_S: f64 = 2e-10;
/// Seconds per entry of the factorized matrix in one solution of the linear equations.
const ENTRY_S: f64 = 5e-10;
/// Memory per contact block of the interface and per load, including its part of the report, in bytes.
const BYTES_PER_POINT: f64 = 150.0;
/// Number of solutions of the linear equations per load of a steady solve in the plane.
const SOLUTIONS: f64 = 15.0;
/// Seconds per column, explicit row and load of a cell in space in a search: the median over cells of squares, discs
/// and crossing grooves of 4 to 200 columns per side is 1.3e-6.
const SEARCHED_COLUMN_S: f64 = 2e-6;
/// Seconds per search direction, column and explicit row of the solver in space, rounded to the slow side of measured
/// cells with 100 to 650 columns per side.
const SPACE_COLUMN_S: f64 = 7.5e-8;
/// Number of columns along a side below which a cell in space is thin.
const THIN_SIDE: f64 = 24.0;
/// Factor on [`SPACE_COLUMN_S`] for thin cells, whose short and long transforms are slower per number: from a cell of
/// 15 by 30,004.
const THIN_FACTOR: f64 = 2.9;
/// Factor on the time of a cell in space whose face has rims or other height variations.
const RAISED_FACTOR: f64 = 2.0;
/// Seconds per number for orthogonalizing the image of a new search direction, under the linear equations, against that
/// of an older direction.
const ORTHOGONAL_S: f64 = 6e-10;
/// Coefficients a, b of the number of search directions for the first load, a + b sqrt(n) for a cavity whose narrowest
/// width is n blocks: cavities of 3, 30, 60 and 125 blocks take 22, 30, 46 and 63.
const DIRECTIONS: [f64; 2] = [12.0, 4.0];
/// Number of search directions for a later load over that for the first load, as long as all directions are stored.
const LATER_LOADS: f64 = 0.4;
/// Numbers stored per column for each search direction: unknown, image and normal force.
const NUMBERS_PER_COLUMN: f64 = 3.0;
/// Further numbers stored per column in a cavity for each search direction.
const NUMBERS_PER_CAVITY: f64 = 6.0;
/// Memory per column and explicit row of a cell in space besides the stored directions, in bytes: displacements,
/// spectra and condensed matrices.
const CELL_BYTES_PER_BLOCK: f64 = 500.0;
/// Maximum estimated time on one core, in seconds: a month.
const MAX_CORE_S: f64 = 30.0 * 86_400.0;
/// Memory per block of a dynamic run in the plane, in bytes.
const BYTES_PER_BLOCK: f64 = 200.0;
/// Memory per block of a dynamic run in space with its warm start, in bytes.
const SPACE_BYTES_PER_BLOCK: f64 = 900.0;

/// Estimated cost of solving a scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Expense {
    /// Time on one core, in seconds. A run that continues until its standard error is small enough may take twenty
    /// times as long.
    pub core_s: f64,
    /// Elapsed time on the cores of rayon's current pool, in seconds.
    pub wall_s: f64,
    /// Memory, in bytes.
    pub bytes: f64,
}

impl Expense {
    /// Cost of `self` followed by `next`.
    #[must_use]
    pub const fn then(self, next: Self) -> Self {
        Self { core_s: self.core_s + next.core_s, wall_s: self.wall_s + next.wall_s, bytes: self.bytes.max(next.bytes) }
    }
}

/// Estimates the cost of a valid `scene` on rayon's current pool.
pub fn expense(scene: &Scene) -> Expense {
    expense_on_threads(scene, rayon::current_num_threads() as f64)
}

/// Estimates the cost of one steady cell of a search, on the slow side, without error estimates.
pub fn cell_expense(scene: &Scene) -> Expense {
    let Some(pattern) = scene.pattern.as_ref().filter(|_| scene.dimension() == Dimension::Space) else {
        return plane(scene, 1.0);
    };
    let model = SteadyCell::with_dimension(scene, Dimension::Space);
    let [nx, ny] = model.columns(pattern);
    let explicit = (pattern.depth_m() / scene.layer.block_m).ceil() + 1.0;
    let raised = if scene.is_raised() { RAISED_FACTOR } else { 1.0 };
    let core_s = nx * ny * explicit * scene.loads.len() as f64 * SEARCHED_COLUMN_S * raised;
    Expense { core_s, wall_s: core_s, bytes: model.bytes(pattern) }
}

/// Refuses a scene that takes too much memory or time on one thread.
///
/// # Errors
/// [`SceneError::TooLarge`] or [`SceneError::TooLong`].
pub fn bounded(scene: &Scene) -> Result<(), SceneError> {
    let Expense { core_s, bytes, .. } = expense_on_threads(scene, 1.0);
    require_memory(bytes)?;
    if core_s > MAX_CORE_S {
        return Err(SceneError::TooLong { core_s, most_s: MAX_CORE_S });
    }
    Ok(())
}

fn expense_on_threads(scene: &Scene, threads: f64) -> Expense {
    match (scene.run.fidelity, scene.dimension()) {
        (Fidelity::Steady, Dimension::Space) => space(scene, threads),
        (Fidelity::Steady, Dimension::Plane) => plane(scene, threads).then(plane_error_estimate_cells(scene, threads)),
        (_, dimension) => in_time(scene, dimension == Dimension::Space, threads),
    }
}

/// Numbers of columns of the scene's own surface in the vertical plane and of its flat counterpart; the latter is
/// `None` without a pattern.
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

/// Cost of steady sliding in the plane: one factorization per surface, at the same time on two threads.
fn plane(scene: &Scene, threads: f64) -> Expense {
    let (rows, is_cell, loads) = (scene.layer.rows(), scene.run.extent == Extent::Cell, scene.loads.len() as f64);
    let (mut core_s, mut bytes) = (0.0, 0.0);
    if let Some(pattern) = scene.pattern.as_ref().filter(|_| is_cell) {
        let (condensed, bytes) = cell_condensing_cost(pattern, scene.layer.block_m);
        let columns = pattern.pitch_m() / scene.layer.block_m;
        if scene.layer.is_backed() || condensed < band_products(columns.ceil() as usize, rows) {
            let core_s = condensed * PRODUCT_S + loads * SOLUTIONS * columns * columns * ENTRY_S;
            return Expense { core_s, wall_s: core_s, bytes: bytes + loads * columns * BYTES_PER_POINT };
        }
    }
    for columns in surfaces(scene).into_iter().flatten() {
        let own = factor_bytes(columns, rows, is_cell);
        bytes += own;
        // The band of a periodic lattice is twice as wide, so a strip takes a quarter of the products.
        let products = band_products(columns, rows) * if is_cell { 1.0 } else { 0.25 };
        core_s += products * PRODUCT_S + loads * SOLUTIONS * own / 8.0 * ENTRY_S;
        bytes += loads * columns as f64 * BYTES_PER_POINT;
    }
    Expense { core_s, wall_s: core_s / threads.min(2.0), bytes }
}

/// Cost of the plane cells for error estimates: in other block sizes, and over the whole thickness and the layer alone.
fn plane_error_estimate_cells(scene: &Scene, threads: f64) -> Expense {
    let Some(pattern) = &scene.pattern else { return Expense::default() };
    let cell = |sized: &Scene| {
        let columns = pattern.pitch_m() / sized.layer.block_m;
        let products = SteadyCell::with_dimension(sized, Dimension::Plane).products(pattern);
        let solutions = sized.loads.len() as f64 * SOLUTIONS * columns * columns;
        (products, products * PRODUCT_S + solutions * ENTRY_S)
    };
    let by = |factor: f64| {
        let (products, core_s) = cell(&blocks::with_block_factor(scene, factor)?);
        (products < blocks::MAX_PRODUCTS).then_some(core_s)
    };
    let half = by(0.5);
    let quarter = half.and_then(|_| by(0.25));
    let larger = if quarter.is_some() { None } else { by(2.0) };
    let sizes_s = [half, quarter, larger].into_iter().flatten().sum::<f64>();
    let correction_s = 2.0 * cell(scene).1;
    Expense { core_s: sizes_s + correction_s, wall_s: sizes_s + correction_s / threads.min(2.0), bytes: 0.0 }
}

/// Number of columns of a strip in space, one period of `pattern` wide.
fn strip_columns(scene: &Scene, pattern: &Pattern) -> f64 {
    let [nx, ny] = SpaceLattice::columns_of(pattern, scene.layer.block_m);
    scene.layer.columns() as f64 * if pattern.texture().slides_along_rows() { ny } else { nx }
}

/// Cost of steady sliding in space: a cell or a strip with its loads one after the other, and the cells for error
/// estimates.
fn space(scene: &Scene, threads: f64) -> Expense {
    let Some(pattern) = &scene.pattern else { return Expense::default() };
    let (cell, error_estimate_cells) = (space_cell(scene, pattern), error_estimate_cells(scene, pattern, threads));
    if scene.run.extent == Extent::Strip {
        // Ends lack springs in all rows from the face to the bulk; the flat strip is solved too.
        let (columns, rows) = (strip_columns(scene, pattern), (scene.layer.rows() + 1) as f64);
        let each_s = directions(scene, pattern).iter().sum::<f64>() * columns * rows * SPACE_COLUMN_S * THIN_FACTOR;
        let strips = Expense {
            core_s: 2.0 * each_s,
            wall_s: 2.0 * each_s / threads.min(2.0),
            bytes: 2.0 * columns * rows * STRIP_BYTES_PER_BLOCK,
        };
        return strips.then(cell).then(error_estimate_cells);
    }
    cell.then(error_estimate_cells)
}

/// Number of search directions of the solver in space for each load of `scene`.
fn directions(scene: &Scene, pattern: &Pattern) -> Vec<f64> {
    let narrowest_m = pattern.length_m().map_or_else(|| pattern.width_m(), |length_m| length_m.min(pattern.width_m()));
    let blocks = narrowest_m / scene.layer.block_m;
    let [least, by_root] = DIRECTIONS;
    let first = (least + by_root * blocks.sqrt()).min(MAX_DIRECTIONS as f64);
    let later = if first * (1.0 + LATER_LOADS) < MAX_STORED_DIRECTIONS as f64 { LATER_LOADS * first } else { first };
    (0..scene.loads.len()).map(|load| if load == 0 { first } else { later }).collect()
}

/// Cost of one steady cell in space at all loads.
fn space_cell(scene: &Scene, pattern: &Pattern) -> Expense {
    let [nx, ny] = SpaceLattice::columns_of(pattern, scene.layer.block_m);
    let (columns, each) = (nx * ny, directions(scene, pattern));
    let explicit = (pattern.depth_m() / scene.layer.block_m).ceil() + 1.0;
    let all: f64 = each.iter().sum();
    let kept = all.min(MAX_STORED_DIRECTIONS as f64);
    // A direction, its image and its normal forces.
    let numbers = columns * (NUMBERS_PER_COLUMN + NUMBERS_PER_CAVITY * pattern.areal_density());
    let thin = if nx.min(ny) < THIN_SIDE { THIN_FACTOR } else { 1.0 };
    let raised = if scene.is_raised() { RAISED_FACTOR } else { 1.0 };
    let transforms_s = columns * explicit * SPACE_COLUMN_S * thin;
    let core_s = all * raised * (transforms_s + numbers / 2.0 * kept / 2.0 * ORTHOGONAL_S);
    let bytes = columns * explicit * CELL_BYTES_PER_BLOCK + numbers * kept * size_of::<f64>() as f64;
    Expense { core_s, wall_s: core_s, bytes }
}

/// Cost of the cells in space for error estimates: in other block sizes, and over the whole thickness and the layer
/// alone.
fn error_estimate_cells(scene: &Scene, pattern: &Pattern, threads: f64) -> Expense {
    let is_told =
        |sized: &Scene| SteadyCell::with_dimension(sized, Dimension::Space).bytes(pattern) < MAX_ESTIMATED_BYTES;
    let by =
        |factor: f64| blocks::with_block_factor(scene, factor).filter(is_told).map(|sized| space_cell(&sized, pattern));
    let half = by(0.5);
    let other = match half {
        None => [by(2.0), by(4.0)],
        Some(_) => [half, by(0.25).or_else(|| by(2.0))],
    };
    let sizes = other.into_iter().flatten().fold(Expense::default(), Expense::then);
    let each = space_cell(&ThickLayerCorrection::comparison_scene(scene, pattern), pattern);
    let both = if threads >= 2.0 { 2.0 } else { 1.0 };
    let correction = Expense { core_s: 2.0 * each.core_s, wall_s: 2.0 * each.core_s / both, bytes: both * each.bytes };
    sizes.then(correction)
}

/// Cost of dynamic runs, one for each surface, load and draw, and in space of the steady cells for error estimates.
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
    let steps = Plan::new(scene, scene.run.step_s.unwrap_or_else(|| default_step_s(scene, is_spatial))).total();
    // Longer runs are refused.
    let steps = if steps > MAX_STEPS { 0.0 } else { steps as f64 };
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
            // Each run factors its own equations.
            bytes += at_once * factor_bytes(largest as usize, rows, is_cell);
            let products = band_products(largest as usize, rows) * if is_cell { 1.0 } else { 0.25 };
            core_s += each * columns.len() as f64 * products * PRODUCT_S;
        }
    }
    let runs = Expense { core_s, wall_s: core_s / at_once.max(1.0), bytes };
    // Steady cells are solved before the runs, for error estimates.
    let cells = scene.pattern.as_ref().filter(|_| is_spatial);
    let cells = cells.map(|pattern| space_cell(scene, pattern).then(error_estimate_cells(scene, pattern, threads)));
    cells.unwrap_or_default().then(runs)
}

#[cfg(test)]
mod tests {
    use crate::pattern::Planform;

    use super::*;
    use crate::springblock::Unwatched;
    use crate::springblock::simulate::simulate;
    use crate::springblock::tests::samples;
    use crate::springblock::{Layer, RunOptions};

    fn scene(fidelity: Fidelity, extent: Extent, block_m: f64) -> Scene {
        let run = RunOptions { fidelity, extent, ..RunOptions::default() };
        let scene = samples::scene(samples::groove(130.0, 370.0, 20.0), &[1.0; 2], run);
        Scene { area_law: None, layer: Layer { block_m, ..scene.layer }, ..scene }
    }

    #[test]
    fn it_is_of_the_size_that_runs_were_measured_to_have() {
        // Seconds and gigabytes on one core of 2.8 GHz.
        let within = |found: f64, measured: f64| found > 0.4 * measured && found < 3.0 * measured;
        let sample = expense(&scene(Fidelity::Steady, Extent::Sample, 2.5e-6));
        assert!(within(sample.core_s, 13.5) && within(sample.bytes, 1.67e9), "{sample:?}");
        // A cell of 500 columns in forces about its cavity, whose bounds are on the large side.
        let cell = expense(&scene(Fidelity::Steady, Extent::Cell, 1e-6));
        let above = |found: f64, measured: f64| found > measured && found < 5.0 * measured;
        assert!(above(cell.core_s, 0.11) && above(cell.bytes, 33e6), "{cell:?}");
        // One cell of squares of 130/370/20 um: 50 x 50 x 20 blocks, then 200 x 200 x 80 blocks.
        for (block_m, core_s) in [(10e-6, 0.0088), (2.5e-6, 0.38)] {
            let mut squares = scene(Fidelity::Steady, Extent::Cell, block_m);
            squares.pattern = Some(Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6).unwrap());
            let found = cell_expense(&squares).core_s;
            assert!(found > core_s && found < 5.0 * core_s, "{found} s, where {core_s} s were measured");
        }
        // Two surfaces, two loads, 250,000 steps of travel, 3000 of ramp and rest, 19,920 blocks.
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
        // `simulate` calls this first; otherwise the run would not end.
        assert!(matches!(bounded(&scene), Err(SceneError::TooLong { .. })), "{:?}", expense(&scene));
        scene.run.fidelity = Fidelity::Steady;
        assert!(matches!(simulate(&scene, &Unwatched), Err(SceneError::TooLarge { .. })));
        // A pitch of millions of blocks is refused before its columns are created.
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
