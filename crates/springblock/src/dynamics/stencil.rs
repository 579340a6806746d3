//! Linear spring forces as a stencil over structure-of-arrays, one row at a time.
//!
//! Inside, coefficients are constants; rows that touch the counterface or a cavity, and the two free
//! sides, carry a coefficient per spring. The loops over blocks are in [`super::sweep`]. Units: k = 1,
//! l = 1, m = 1.

use multiversion::multiversion;

use super::rows::{Field, INSIDE, Row, RowCoefficients, Site};
use super::sweep::{Kick, contact_row_forces, sweep};
use crate::lattice::Lattice;

/// A lattice prepared for fast stepping.
#[derive(Clone, Debug)]
pub struct Stencil {
    rows: Vec<Row>,
    periodic: bool,
    /// Vertical stiffness and cross stiffness of every top block to the bulk, and their sums.
    to_bulk_yy: Vec<f64>,
    to_bulk_xy: Vec<f64>,
    bulk_yy: f64,
    bulk_xy: f64,
    contact_inverse_mass: Vec<f64>,
}

impl Stencil {
    /// Prepares a plain lattice (whole blocks of equal width).
    #[must_use]
    pub fn new(lattice: &Lattice) -> Self {
        let (nx, ny) = (lattice.nx(), lattice.ny());
        let mut sites = vec![Site::default(); nx * ny];
        let (mut to_bulk_yy, mut to_bulk_xy) = (vec![0.0; nx], vec![0.0; nx]);
        lattice.for_each_bond(|bond| {
            let (i, j) = bond.a;
            let k = bond.stiffness;
            let own = &mut sites[j * nx + i].springs;
            let [x, y] = bond.rest;
            match (x, y) {
                (x, 0.0) if x > 0.0 => own.east = k,
                (0.0, _) => own.north = k,
                (x, _) if x > 0.0 => own.north_east = k,
                _ => own.north_west = k,
            }
            match bond.b {
                Some((bi, bj)) => {
                    let other = &mut sites[bj * nx + bi].springs;
                    match (x, y) {
                        (x, 0.0) if x > 0.0 => other.west = k,
                        (0.0, _) => other.south = k,
                        (x, _) if x > 0.0 => other.south_west = k,
                        _ => other.south_east = k,
                    }
                }
                None => {
                    let [_, kxy, kyy] = bond.linear();
                    to_bulk_yy[i] += kyy;
                    to_bulk_xy[i] += kxy;
                }
            }
        });
        for (number, site) in sites.iter_mut().enumerate() {
            let mass = lattice.mass(number % nx, number / nx);
            site.inverse_mass = if mass > 0.0 { 1.0 / mass } else { 0.0 };
        }
        let inside = Site { springs: INSIDE, inverse_mass: 1.0 };
        let periodic = lattice.is_periodic();
        let rows = sites
            .chunks_exact(nx)
            .enumerate()
            .map(|(j, row)| {
                let sides = if periodic { 0 } else { 1 };
                // The contact row is always general: its forces are needed apart from its motion.
                if j > 0 && nx > 2 && row[sides..nx - sides].iter().all(|site| *site == inside) {
                    Row::Plain { sides: (!periodic).then(|| [row[0], row[nx - 1]]) }
                } else {
                    Row::General(RowCoefficients::new(row))
                }
            })
            .collect();
        Self {
            rows,
            periodic,
            bulk_yy: to_bulk_yy.iter().sum(),
            bulk_xy: to_bulk_xy.iter().sum(),
            to_bulk_yy,
            to_bulk_xy,
            contact_inverse_mass: sites[..nx].iter().map(|site| site.inverse_mass).collect(),
        }
    }

    /// Inverse mass of the blocks of row 0, by column.
    #[must_use]
    pub fn contact_inverse_mass(&self) -> &[f64] {
        &self.contact_inverse_mass
    }

    /// Sets the bulk to the horizontal displacement `bulk_x` and to the height that balances `load`.
    pub fn place_bulk(&self, field: &mut Field, bulk_x: f64, load: f64) {
        let (nx, ny) = (field.nx, field.ny);
        let top = field.at(0, ny - 1)..field.at(nx, ny - 1);
        // sum [kyy (H - u_y) + kxy (X - u_x)] = -load
        let held =
            weighted_sum(&self.to_bulk_yy, &field.uy[top.clone()]) + weighted_sum(&self.to_bulk_xy, &field.ux[top]);
        let height = (held - self.bulk_xy * bulk_x - load) / self.bulk_yy;
        let bulk = field.at(0, ny) - 1..field.at(nx, ny) + 1;
        field.ux[bulk.clone()].fill(bulk_x);
        field.uy[bulk].fill(height);
    }

    /// Spring forces on row 0, by column.
    pub fn contact_forces(&self, field: &Field, force_x: &mut [f64], force_y: &mut [f64]) {
        if let Row::General(coefficients) = &self.rows[0] {
            contact_row_forces(coefficients, field, force_x, force_y);
        }
    }

    /// Kicks and drifts all rows; row 0 has been kicked already. `kept`: share of the velocity that
    /// damping leaves; `kick`: displacement per step that a unit force adds to a unit mass.
    pub fn kick_and_drift(&self, field: &mut Field, kept: f64, kick: f64, scratch: &mut [Vec<f64>; 2]) {
        let [force_x, force_y] = scratch;
        sweep(&self.rows, field, Kick { kept, kick }, force_x, force_y);
        self.wrap(field);
    }

    /// Copies the sides of every row to its periodic images.
    pub fn wrap(&self, field: &mut Field) {
        if self.periodic {
            for j in 0..field.ny {
                let row = field.at(0, j)..field.at(field.nx, j);
                for u in [&mut field.ux, &mut field.uy] {
                    u[row.start - 1] = u[row.end - 1];
                    u[row.end] = u[row.start];
                }
            }
        }
    }
}

/// Sum of a[i] b[i] in eight fixed partial sums: the same with any vector width.
#[multiversion(targets("x86_64+avx2"))]
fn weighted_sum(a: &[f64], b: &[f64]) -> f64 {
    const LANES: usize = 8;
    let (a_chunks, b_chunks) = (a.chunks_exact(LANES), b.chunks_exact(LANES));
    let rest: f64 = a_chunks.remainder().iter().zip(b_chunks.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; LANES];
    for (a, b) in a_chunks.zip(b_chunks) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    ((sums[0] + sums[4]) + (sums[1] + sums[5])) + ((sums[2] + sums[6]) + (sums[3] + sums[7])) + rest
}
