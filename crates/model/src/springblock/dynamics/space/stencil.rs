//! Division of a cell into rows of inside blocks and rows with individual coefficients for every spring.
//!
//! Units: k = 1, l = 1, m = 1.

use std::ops::Range;
use std::sync::Arc;

use super::super::real::{Real, whole_lines};
use crate::springblock::SpaceLattice;

/// Number of springs of a block.
pub const SPRINGS: usize = 18;

/// Steps along x, y and upward to the neighbours: first along the axes, forward and backward; then for each of the
/// planes xy, xz and yz the two rising and the two falling diagonals, each pair beginning with the positive direction
/// of the second axis.
pub const STEPS: [[isize; 3]; SPRINGS] = [
    [1, 0, 0],
    [-1, 0, 0],
    [0, 1, 0],
    [0, -1, 0],
    [0, 0, 1],
    [0, 0, -1],
    [1, 1, 0],
    [-1, -1, 0],
    [-1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [-1, 0, -1],
    [-1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, -1, -1],
    [0, -1, 1],
    [0, 1, -1],
];

/// Spring stiffnesses and inverse masses of a row: for each spring one entry per column, padded with zeros to whole
/// cache lines. Stiffnesses of diagonal springs are halved.
#[derive(Clone, Debug, PartialEq)]
pub struct RowCoefficients<R> {
    /// Stiffnesses in units of the spring stiffness k: for each spring, in the order of [`STEPS`], the values of all
    /// columns.
    pub springs: Vec<R>,
    pub inverse_mass: Vec<R>,
}

impl<R: Real> RowCoefficients<R> {
    /// Creates the coefficients of row `j` of layer `k` of a lattice of whole cubes.
    fn new(lattice: &SpaceLattice, j: usize, k: usize) -> Self {
        let [nx, _] = lattice.columns();
        let padded = whole_lines::<R>(nx);
        let mut springs = vec![R::default(); SPRINGS * padded];
        for (number, step) in STEPS.into_iter().enumerate() {
            let scale = if number < 6 { 1.0 } else { 0.5 };
            for i in 0..nx {
                springs[number * padded + i] = R::round_from(scale * spring(lattice, [i, j, k], step));
            }
        }
        let inverse = |i: usize| if i < nx { lattice.mass(i, j, k) } else { 0.0 };
        let inverse_mass =
            (0..padded).map(inverse).map(|mass| R::round_from(if mass > 0.0 { 1.0 / mass } else { 0.0 })).collect();
        Self { springs, inverse_mass }
    }

    /// Whether all blocks of the row have the mass and the springs of a block inside the lattice.
    fn is_inside(lattice: &SpaceLattice, j: usize, k: usize) -> bool {
        let inside = |i: usize| {
            lattice.mass(i, j, k) == 1.0 && STEPS.into_iter().all(|step| spring(lattice, [i, j, k], step) == 1.0)
        };
        k > 0 && (0..lattice.columns()[0]).all(inside)
    }
}

/// Stiffness, in units of k, of the spring from block (i, j, k) along `step`; 0 unless both blocks exist.
fn spring(lattice: &SpaceLattice, [i, j, k]: [usize; 3], step: [isize; 3]) -> f64 {
    let [nx, ny] = lattice.columns();
    let wrap = |at: usize, step: isize, count: usize| (at + count).wrapping_add_signed(step) % count;
    let Some(above) = k.checked_add_signed(step[2]) else { return 0.0 };
    lattice.spring_share([i, j, k], [wrap(i, step[0], nx), wrap(j, step[1], ny), above])
}

/// A row with individual coefficients for every spring.
#[derive(Clone, Debug)]
pub struct GeneralRow<R> {
    /// Index along y.
    pub row: usize,
    /// Coefficients, shared by all equal rows: 18 numbers per column are more memory traffic than the displacements.
    pub coefficients: Arc<RowCoefficients<R>>,
}

/// Division of a cell into general rows, with individual coefficients, and rows of inside blocks.
#[derive(Clone, Debug)]
pub struct Stencil<R> {
    /// General rows by layer, from the counterface up; all rows of the lowest layer are general.
    pub general: Vec<Vec<GeneralRow<R>>>,
    /// Ranges of rows of inside blocks by layer; the lowest layer has none.
    pub inside: Vec<Vec<Range<usize>>>,
}

impl<R: Real> Stencil<R> {
    /// Classifies the rows of a lattice of whole cubes.
    pub fn new(lattice: &SpaceLattice) -> Self {
        let [_, ny] = lattice.columns();
        let mut distinct: Vec<Arc<RowCoefficients<R>>> = Vec::new();
        let mut shared = |row: RowCoefficients<R>| {
            let known = distinct.iter().find(|known| ***known == row).cloned();
            known.unwrap_or_else(|| {
                distinct.push(Arc::new(row));
                distinct[distinct.len() - 1].clone()
            })
        };
        let (mut general, mut inside) = (Vec::new(), Vec::new());
        for k in 0..lattice.rows() {
            let (mut rows, mut ranges): (Vec<GeneralRow<R>>, Vec<Range<usize>>) = (Vec::new(), Vec::new());
            for j in 0..ny {
                // A cavity affects rows up to the one above its ceiling; free ends affect all rows up to the bulk.
                if (k > lattice.cavity_rows() && !lattice.is_end(j)) || RowCoefficients::<R>::is_inside(lattice, j, k) {
                    match ranges.last_mut() {
                        Some(last) if last.end == j => last.end = j + 1,
                        _ => ranges.push(j..j + 1),
                    }
                } else {
                    rows.push(GeneralRow { row: j, coefficients: shared(RowCoefficients::new(lattice, j, k)) });
                }
            }
            general.push(rows);
            inside.push(ranges);
        }
        Self { general, inside }
    }
}
