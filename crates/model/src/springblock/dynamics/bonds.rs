//! Spring forces of any lattice, linear or geometrically exact. The reference integration uses them, and tests compare
//! the stencil with them. Units: k = 1, l = 1, m = 1.
//!
//! Springs of the uniform mesh are evaluated row by row ([`BondRows`]), other springs one by one.

use super::bond_rows::{BondRows, KINDS};
use crate::springblock::{Lattice, Springs};

/// A spring between the blocks with the numbers `a` and `b`; column i of row j has the number j * nx + i, the bulk nx *
/// ny.
#[derive(Clone, Copy, Debug)]
struct Spring {
    a: usize,
    b: usize,
    rest: [f64; 2],
    length: f64,
    stiffness: f64,
}

/// Springs and masses of a lattice, with the spring forces of the last evaluation.
#[derive(Clone, Debug)]
pub struct Bonds {
    law: Springs,
    rows: BondRows,
    /// Springs between blocks that do not fit the uniform mesh of `rows`.
    springs: Vec<Spring>,
    /// Springs to the bulk that do not fit the uniform mesh of `rows`.
    to_bulk: Vec<Spring>,
    /// Vertical stiffness of all springs to the bulk together, as linear springs, in units of the spring stiffness k.
    slope: f64,
    mass: Vec<f64>,
    /// Vertical displacement of the bulk, in lattice spacings.
    height: f64,
    forces: [Vec<f64>; 2],
    /// All springs, for evaluation one by one.
    #[cfg(test)]
    all: Vec<Spring>,
}

/// Relative tolerance of Newton's method for the bulk's height: a smaller step counts as rounding. The step is taken
/// relative to the height or, if larger, to the load over the stiffness of the springs to the bulk.
const BALANCE_TOLERANCE: f64 = 1e-15;
/// Maximum number of Newton steps for the bulk's height. Two or three are needed, since the springs are nearly linear.
const MAX_NEWTON_STEPS: usize = 20;

impl Bonds {
    /// Collects the springs of `lattice` with the force law `law`.
    pub fn new(lattice: &Lattice, law: Springs) -> Self {
        let (nx, ny) = (lattice.nx(), lattice.ny());
        let mut bonds = Self {
            law,
            rows: BondRows::new(nx, ny, law),
            springs: Vec::new(),
            to_bulk: Vec::new(),
            slope: 0.0,
            mass: (0..nx * ny).map(|number| lattice.mass(number % nx, number / nx)).collect(),
            height: 0.0,
            forces: [vec![0.0; nx * ny], vec![0.0; nx * ny]],
            #[cfg(test)]
            all: Vec::new(),
        };
        lattice.for_each_bond(|bond| {
            let number = |(i, j): (usize, usize)| j * nx + i;
            let [x, y] = bond.rest;
            let length = x.hypot(y);
            let b = bond.b.map_or(nx * ny, number);
            let spring = Spring { a: number(bond.a), b, rest: bond.rest, length, stiffness: bond.stiffness };
            #[cfg(test)]
            bonds.all.push(spring);
            if bond.b.is_none() {
                // k y^2 / L^2
                bonds.slope += bond.stiffness * (y / length).powi(2);
            }
            // The spring fits the uniform mesh if its other end is whole steps away, possibly across the periodic side.
            let end = (bond.a.0 as f64 + x).rem_euclid(nx as f64);
            let reaches = |(i, _): (usize, usize)| end == i as f64;
            match KINDS.iter().position(|kind| *kind == bond.rest) {
                Some(kind) if bond.b.is_none_or(reaches) => bonds.rows.add(kind, spring.a, spring.stiffness),
                _ if bond.b.is_some() => bonds.springs.push(spring),
                _ => bonds.to_bulk.push(spring),
            }
        });
        bonds
    }

    /// Inverse mass of every block, in units of the inverse mass 1/m of a block inside; index j * nx + i for column i
    /// of row j. 0 where there is no block.
    pub fn inverse_mass(&self) -> Vec<f64> {
        self.mass.iter().map(|mass| if *mass > 0.0 { 1.0 / mass } else { 0.0 }).collect()
    }

    /// Spring forces x and y on every block at the last evaluation, in units of k l (spring stiffness times lattice
    /// spacing); index j * nx + i for column i of row j.
    pub const fn forces(&self) -> &[Vec<f64>; 2] {
        &self.forces
    }

    /// Evaluates the spring forces at the displacements `u` of the blocks, with the bulk displaced by `bulk_x` along x
    /// and at the height that balances `load`. Units: k = 1, l = 1.
    pub fn evaluate(&mut self, u: &[Vec<f64>; 2], bulk_x: f64, load: f64) {
        self.balance_bulk(u, bulk_x, load);
        let [fx, fy] = &mut self.forces;
        fx.fill(0.0);
        fy.fill(0.0);
        self.rows.evaluate(u, [bulk_x, self.height], &mut self.forces);
        let [fx, fy] = &mut self.forces;
        for spring in &self.springs {
            let (a, b) = (spring.a, spring.b);
            let [x, y] = force(self.law, spring, [u[0][b] - u[0][a], u[1][b] - u[1][a]]);
            fx[a] += x;
            fy[a] += y;
            fx[b] -= x;
            fy[b] -= y;
        }
        for spring in &self.to_bulk {
            let a = spring.a;
            let [x, y] = force(self.law, spring, [bulk_x - u[0][a], self.height - u[1][a]]);
            fx[a] += x;
            fy[a] += y;
        }
    }

    /// Finds the bulk's height by Newton's method: the vertical forces of its springs on the layer sum to -`load`.
    fn balance_bulk(&mut self, u: &[Vec<f64>; 2], bulk_x: f64, load: f64) {
        let slope = self.slope;
        for _ in 0..MAX_NEWTON_STEPS {
            let others = self.to_bulk.iter();
            let others: f64 =
                others.map(|s| force(self.law, s, [bulk_x - u[0][s.a], self.height - u[1][s.a]])[1]).sum();
            let pull = self.rows.pull(u, [bulk_x, self.height]) + others;
            let step = -(load + pull) / slope;
            self.height += step;
            let small = BALANCE_TOLERANCE * (load / slope).abs().max(self.height.abs());
            if step.abs() <= small || step.is_nan() {
                break;
            }
        }
    }
}

#[cfg(test)]
impl Bonds {
    /// Energy of the springs at the last evaluation plus load times height. Under constant load it changes only by the
    /// work of the drive, friction and damping.
    pub fn potential(&self, u: &[Vec<f64>; 2], bulk_x: f64, load: f64) -> f64 {
        let energy = |spring: &Spring, d: [f64; 2]| {
            let [x, y] = spring.rest;
            let along = x * d[0] + y * d[1];
            let elongation = match self.law {
                Springs::Linear => along / spring.length,
                Springs::Exact => {
                    (2.0 * along + d[0] * d[0] + d[1] * d[1]) / ((x + d[0]).hypot(y + d[1]) + spring.length)
                }
            };
            0.5 * spring.stiffness * elongation * elongation
        };
        let springs: f64 = self.all.iter().map(|spring| energy(spring, self.stretch(spring, u, bulk_x))).sum();
        springs + load * self.height
    }

    /// Horizontal force of the drive on the bulk.
    pub fn drive(&self, u: &[Vec<f64>; 2], bulk_x: f64) -> f64 {
        let to_bulk = self.all.iter().filter(|spring| spring.b == self.mass.len());
        to_bulk.map(|spring| force(self.law, spring, self.stretch(spring, u, bulk_x))[0]).sum()
    }

    fn stretch(&self, spring: &Spring, u: &[Vec<f64>; 2], bulk_x: f64) -> [f64; 2] {
        let bulk = [bulk_x, self.height];
        [0, 1].map(|c| u[c].get(spring.b).unwrap_or(&bulk[c]) - u[c][spring.a])
    }

    /// Forces of the last evaluation computed spring by spring, and the vertical force on the bulk.
    fn one_by_one(&self, u: &[Vec<f64>; 2], bulk_x: f64) -> ([Vec<f64>; 2], f64) {
        let blocks = self.mass.len();
        let mut forces = [vec![0.0; blocks + 1], vec![0.0; blocks + 1]];
        for spring in &self.all {
            let on_first = force(self.law, spring, self.stretch(spring, u, bulk_x));
            for (forces, on_first) in forces.iter_mut().zip(on_first) {
                forces[spring.a] += on_first;
                forces[spring.b] -= on_first;
            }
        }
        let on_bulk = forces[1][blocks];
        forces.iter_mut().for_each(|forces| forces.truncate(blocks));
        (forces, on_bulk)
    }
}

/// Force on the first end of a spring whose second end is displaced by `d` relative to the first.
fn force(law: Springs, spring: &Spring, d: [f64; 2]) -> [f64; 2] {
    let [x, y] = spring.rest;
    let along = x * d[0] + y * d[1];
    match law {
        Springs::Linear => {
            // F = k e (e . d)
            let scale = spring.stiffness * along / (spring.length * spring.length);
            [scale * x, scale * y]
        }
        Springs::Exact => {
            // F = k (r - L) (r_b - r_a) / r, with r - L = (2 rest . d + d . d) / (r + L) free of cancellation
            let (x, y) = (x + d[0], y + d[1]);
            let r = (x * x + y * y).sqrt();
            let elongation = (2.0 * along + d[0] * d[0] + d[1] * d[1]) / (r + spring.length);
            let scale = spring.stiffness * elongation / r;
            [scale * x, scale * y]
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::columns::{cell, flat};
    use crate::springblock::tests::samples::groove;

    #[test]
    fn exact_springs_ignore_rigid_rotation_and_linear_ones_do_to_first_order() {
        let lattice = Lattice::new(flat(4), 5, false);
        let rotate = |angle: f64| {
            let moved = |number: u32| {
                let (x, y) = (f64::from(number % 4), f64::from(number / 4) - 4.0);
                (x * (angle.cos() - 1.0) - y * angle.sin(), x * angle.sin() + y * (angle.cos() - 1.0))
            };
            let (u_x, u_y): (Vec<f64>, Vec<f64>) = (0..20).map(moved).unzip();
            [u_x, u_y]
        };
        let largest = |law: Springs, angle: f64| {
            let mut bonds = Bonds::new(&lattice, law);
            bonds.evaluate(&rotate(angle), 0.0, 0.0);
            // The top row is excluded because the bulk does not rotate.
            bonds.forces.iter().flat_map(|forces| &forces[..16]).fold(0.0, |most: f64, f| most.max(f.abs()))
        };
        assert!(largest(Springs::Exact, 0.3) < 1e-14);
        let (coarse, fine) = (largest(Springs::Linear, 1e-2), largest(Springs::Linear, 1e-3));
        assert!(((coarse / fine).log10() - 2.0).abs() < 0.01, "{coarse} {fine}");
    }

    #[test]
    fn rows_of_springs_pull_as_one_by_one_and_the_bulk_balances_the_load() {
        // Full and partial chunks of columns, periodic and free sides, cavities, and columns of other widths.
        let [whole, fitted] =
            [(130.0, 370.0), (33.0, 51.0)].map(|(width_um, land_um)| cell(&groove(width_um, land_um, 20.0), 10e-6));
        for columns in [flat(1), flat(2), flat(5), flat(300), whole, fitted] {
            for (periodic, law) in [false, true].into_iter().flat_map(|p| Springs::ALL.map(|law| (p, law))) {
                let lattice = Lattice::new(columns.clone(), 4, periodic);
                let mut bonds = Bonds::new(&lattice, law);
                let place = |number: usize, phase: f64| 3e-2 * (1.7 * number as f64 + phase).sin();
                let u = [0.0, 1.0].map(|phase| (0..4 * columns.len()).map(|n| place(n, phase)).collect::<Vec<_>>());
                let load = 0.01 * columns.len() as f64;
                bonds.evaluate(&u, 2e-3, load);
                let (forces, on_bulk) = bonds.one_by_one(&u, 2e-3);
                for (found, expected) in bonds.forces.iter().flatten().zip(forces.iter().flatten()) {
                    assert!((found - expected).abs() < 1e-15, "{periodic} {law:?}: {found} {expected}");
                }
                assert!((on_bulk - load).abs() < 1e-14 * load.max(1.0), "{periodic} {law:?}: {on_bulk}");
            }
        }
    }
}
