//! Forces in space, spring by spring: slow and simple, the reference for the sweeps in tests.

use crate::springblock::SpaceLattice;

/// A spring between two blocks. The block in column i along x and j along y of layer k has the number (k ny + j) nx +
/// i; the bulk has the last number.
#[derive(Clone, Copy, Debug)]
struct Link {
    ends: [u32; 2],
    direction: [f64; 3],
}

/// The springs of a lattice of whole cubes. Units: k = 1, l = 1, m = 1.
#[derive(Clone, Debug)]
pub struct SpaceBonds {
    links: Vec<Link>,
    /// Springs to the bulk.
    to_bulk: Vec<Link>,
    /// Number of the bulk, which is the number of blocks.
    bulk: usize,
    /// Mass by block; 0 for removed blocks.
    mass: Vec<f64>,
}

impl SpaceBonds {
    /// Collects the springs of `lattice`.
    pub fn new(lattice: &SpaceLattice) -> Self {
        let ([nx, ny], rows) = (lattice.columns(), lattice.rows());
        let bulk = nx * ny * rows;
        let number = |[i, j, k]: [usize; 3]| if k < rows { ((k * ny + j) * nx + i) as u32 } else { bulk as u32 };
        let mut links = Vec::new();
        lattice.for_each_bond(|bond| {
            links.push(Link { ends: [number(bond.a), number(bond.b)], direction: bond.spring.direction() });
        });
        let to_bulk = links.iter().filter(|link| link.ends[1] as usize == bulk).copied().collect();
        let mass = (0..bulk).map(|n| lattice.mass(n % nx, n / nx % ny, n / (nx * ny))).collect();
        Self { links, to_bulk, bulk, mass }
    }

    pub fn mass(&self) -> &[f64] {
        &self.mass
    }

    /// Computes the spring forces x, y and z on every block and, last, on the bulk, in units of k l (spring stiffness
    /// times lattice spacing). `displacement` contains the blocks and, last, the bulk, in lattice spacings.
    pub fn forces(&self, displacement: &[[f64; 3]], force: &mut [[f64; 3]]) {
        force.fill([0.0; 3]);
        for Link { ends: [a, b], direction } in &self.links {
            let (a, b) = (*a as usize, *b as usize);
            // F = k e (e . (u_b - u_a))
            let stretch: f64 = (0..3).map(|c| direction[c] * (displacement[b][c] - displacement[a][c])).sum();
            for c in 0..3 {
                force[a][c] += stretch * direction[c];
                force[b][c] -= stretch * direction[c];
            }
        }
    }

    /// Sets the vertical displacement of the bulk, the last entry of `displacement`, such that the springs to the bulk
    /// carry `load`, in units of k l; x and y of the bulk remain as given.
    pub fn balance(&self, displacement: &mut [[f64; 3]], load: f64) {
        // sum over springs to the bulk of e_z (e . (u_bulk - u_a)) = -load, linear in the height
        let (mut top_row_force, mut stiffness) = (0.0, 0.0);
        let bulk = displacement[self.bulk];
        for Link { ends: [a, _], direction: e } in &self.to_bulk {
            let u = displacement[*a as usize];
            top_row_force += e[2] * (e[0] * (u[0] - bulk[0]) + e[1] * (u[1] - bulk[1]) + e[2] * u[2]);
            stiffness += e[2] * e[2];
        }
        displacement[self.bulk][2] = (top_row_force - load) / stiffness;
    }

    #[cfg(test)]
    pub fn energy(&self, displacement: &[[f64; 3]]) -> f64 {
        let along = |link: &Link| -> f64 {
            let [a, b] = link.ends.map(|end| displacement[end as usize]);
            (0..3).map(|c| link.direction[c] * (b[c] - a[c])).sum()
        };
        self.links.iter().map(|link| 0.5 * along(link).powi(2)).sum()
    }
}
