//! Spring forces bond by bond: slow, obviously right, linear or geometrically exact. The judge of the
//! stencil, and the force evaluation of the reference integration. Units: k = 1, l = 1, m = 1.

use crate::lattice::Lattice;
use crate::scene::Springs;

/// One spring, ends as block numbers j * nx + i.
#[derive(Clone, Copy, Debug)]
struct Spring {
    a: usize,
    b: usize,
    rest: [f64; 2],
    length: f64,
    stiffness: f64,
}

/// All springs of a lattice.
#[derive(Clone, Debug)]
pub struct Bonds {
    law: Springs,
    springs: Vec<Spring>,
    to_bulk: Vec<Spring>,
    mass: Vec<f64>,
    height: f64,
    forces: [Vec<f64>; 2],
}

/// Share of the load below which the bulk's vertical imbalance counts as rounding.
const BALANCE_TOLERANCE: f64 = 1e-15;
/// Newton steps on the bulk's height; two or three do, as the springs are nearly linear.
const MOST_NEWTON_STEPS: usize = 20;

impl Bonds {
    /// The springs of `lattice` under the force law `law`.
    #[must_use]
    pub fn new(lattice: &Lattice, law: Springs) -> Self {
        let (nx, ny) = (lattice.nx(), lattice.ny());
        let (mut springs, mut to_bulk) = (Vec::new(), Vec::new());
        lattice.for_each_bond(|bond| {
            let number = |(i, j): (usize, usize)| j * nx + i;
            let [x, y] = bond.rest;
            let spring = Spring {
                a: number(bond.a),
                b: bond.b.map_or(nx * ny, number),
                rest: bond.rest,
                length: x.hypot(y),
                stiffness: bond.stiffness,
            };
            if bond.b.is_some() { springs.push(spring) } else { to_bulk.push(spring) }
        });
        let mass = (0..nx * ny).map(|number| lattice.mass(number % nx, number / nx)).collect();
        Self { law, springs, to_bulk, mass, height: 0.0, forces: [vec![0.0; nx * ny], vec![0.0; nx * ny]] }
    }

    /// Inverse mass of every block, 0 where there is none.
    #[must_use]
    pub fn inverse_mass(&self) -> Vec<f64> {
        self.mass.iter().map(|mass| if *mass > 0.0 { 1.0 / mass } else { 0.0 }).collect()
    }

    /// Spring forces at the last evaluation, x and y.
    #[must_use]
    pub const fn forces(&self) -> &[Vec<f64>; 2] {
        &self.forces
    }

    /// Evaluates the forces at the displacements `u`, the bulk at `bulk_x` and at the height that
    /// balances `load`.
    pub fn evaluate(&mut self, u: &[Vec<f64>; 2], bulk_x: f64, load: f64) {
        self.balance_bulk(u, bulk_x, load);
        let [fx, fy] = &mut self.forces;
        fx.fill(0.0);
        fy.fill(0.0);
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

    /// Newton's method for the bulk's height H: sum of the vertical forces of its springs = -load.
    fn balance_bulk(&mut self, u: &[Vec<f64>; 2], bulk_x: f64, load: f64) {
        // Slope of the linear springs: k y^2 / L^2.
        let slope: f64 = self.to_bulk.iter().map(|s| s.stiffness * (s.rest[1] / s.length).powi(2)).sum();
        for _ in 0..MOST_NEWTON_STEPS {
            let pull: f64 =
                self.to_bulk.iter().map(|s| force(self.law, s, [bulk_x - u[0][s.a], self.height - u[1][s.a]])[1]).sum();
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
    /// Energy of the springs at the displacements of the last evaluation plus load times height: what
    /// changes by work alone while the load is constant.
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
        let between = |s: &Spring| energy(s, [u[0][s.b] - u[0][s.a], u[1][s.b] - u[1][s.a]]);
        let to_bulk = |s: &Spring| energy(s, [bulk_x - u[0][s.a], self.height - u[1][s.a]]);
        let springs: f64 = self.springs.iter().map(between).sum();
        springs + self.to_bulk.iter().map(to_bulk).sum::<f64>() + load * self.height
    }

    /// Horizontal force that drives the bulk.
    pub fn drive(&self, u: &[Vec<f64>; 2], bulk_x: f64) -> f64 {
        let pull = |s: &Spring| force(self.law, s, [bulk_x - u[0][s.a], self.height - u[1][s.a]])[0];
        self.to_bulk.iter().map(pull).sum()
    }
}

/// Force on the first end of a spring whose second end has moved by `d` relative to it.
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
    use crate::columns::flat;

    #[test]
    fn exact_springs_ignore_rigid_rotation_and_linear_ones_do_to_first_order() {
        let lattice = Lattice::new(flat(4), 4, false);
        let rotate = |angle: f64| {
            let moved = |number: u32| {
                let (x, y) = (f64::from(number % 4), f64::from(number / 4) - 4.0);
                (x * (angle.cos() - 1.0) - y * angle.sin(), x * angle.sin() + y * (angle.cos() - 1.0))
            };
            let (u_x, u_y): (Vec<f64>, Vec<f64>) = (0..16).map(moved).unzip();
            [u_x, u_y]
        };
        let largest = |law: Springs, angle: f64| {
            let mut bonds = Bonds::new(&lattice, law);
            bonds.to_bulk.clear();
            bonds.evaluate(&rotate(angle), 0.0, 0.0);
            bonds.forces.iter().flatten().fold(0.0, |most: f64, f| most.max(f.abs()))
        };
        assert!(largest(Springs::Exact, 0.3) < 1e-14);
        let (coarse, fine) = (largest(Springs::Linear, 1e-2), largest(Springs::Linear, 1e-3));
        assert!(((coarse / fine).log10() - 2.0).abs() < 0.01, "{coarse} {fine}");
    }

    #[test]
    fn the_bulk_balances_the_load_exactly() {
        let lattice = Lattice::new(flat(5), 3, false);
        let u = [
            (0..15).map(|i| 1e-3 * f64::from(i).sin()).collect::<Vec<_>>(),
            (0..15).map(|i| 1e-3 * f64::from(i).cos()).collect::<Vec<_>>(),
        ];
        for law in Springs::ALL {
            let mut bonds = Bonds::new(&lattice, law);
            bonds.evaluate(&u, 2e-3, 0.01);
            let pull: f64 =
                bonds.to_bulk.iter().map(|s| force(law, s, [2e-3 - u[0][s.a], bonds.height - u[1][s.a]])[1]).sum();
            assert!((pull + 0.01).abs() < 1e-16, "{law:?}: {pull}");
        }
    }
}
