//! Linear part of steady sliding: stiffness, its factorization, and the response to friction and to the bulk.

use super::band::{BATCH, BandFactor, BandMatrix};
use super::{LinearResponse, Response};
use crate::springblock::Lattice;
use crate::springblock::lattice::{Bond, tie};

/// A block of row 0 that touches the counterface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contact {
    pub column: usize,
    /// Width of the contact, in lattice spacings.
    pub width: f64,
    /// Distance of the block's centre from the left side, in lattice spacings.
    pub centre: f64,
    /// Index of the horizontal unknown; the vertical unknown has the next index.
    pub dof: usize,
    /// Whether the block has lifted off the counterface.
    pub lifted: bool,
    /// Stiffness, in units of the spring stiffness k, of the vertical tie to the face for a block that touches in part;
    /// `None` for a block pinned to the counterface.
    pub tie: Option<f64>,
}

/// Contribution of one spring to the normal force N on a contact: kxy (x_contact - x_other) + kyy (y_contact -
/// y_other), with displacements x and y, is added to N. `other` is the index of an unknown; `None` for the bulk.
#[derive(Clone, Copy, Debug)]
struct Support {
    contact: usize,
    other: Option<usize>,
    kxy: f64,
    kyy: f64,
}

/// Factored equations of a lattice with given blocks pinned to the counterface.
#[derive(Clone, Debug)]
pub struct System {
    rows: usize,
    position: Vec<usize>,
    contacts: Vec<Contact>,
    supports: Vec<Support>,
    factor: Option<BandFactor>,
    /// Load on the bulk in units of P l^2 (nominal pressure P, lattice spacing l), which equals the length of the
    /// lattice in lattice spacings.
    load: f64,
    /// Force on every unknown per rise of the bulk with all blocks fixed, in units of the spring stiffness k.
    coupling: Vec<f64>,
    /// Displacement of every unknown per rise of the bulk, without friction.
    bulk_response: Vec<f64>,
    /// Vertical force on the bulk per rise of the bulk with all blocks fixed, in units of the spring stiffness k.
    bulk_stiffness: f64,
    /// Response to the heights of the face; `None` for a flat face.
    relief: Option<Relief>,
}

/// Response to the heights of the face at the contacts, in lattice spacings, with the bulk at rest.
#[derive(Clone, Debug)]
struct Relief {
    displacement: Vec<f64>,
    /// Vertical force on the bulk due to the heights of pinned contacts, in units of k l (spring stiffness times
    /// lattice spacing).
    pull: f64,
}

/// A lattice whose face heights, in lattice spacings, are multiplied by `scale`.
pub struct Raised<'a> {
    pub system: &'a System,
    pub scale: f64,
}

/// Half bandwidth of the equations of a lattice. Neighbouring columns are one position apart in the order of
/// elimination, or two in a folded periodic lattice.
fn half_bandwidth(columns: usize, rows: usize, periodic: bool) -> usize {
    let apart = if periodic { 2.min(columns - 1) } else { 1.min(columns - 1) };
    (2 * rows * apart + 3).min(2 * columns * rows - 1)
}

/// Memory of the factorization of a lattice, in bytes.
pub fn factor_bytes(columns: usize, rows: usize, periodic: bool) -> f64 {
    let row = half_bandwidth(columns, rows, periodic) + 1;
    8.0 * (2 * columns * rows) as f64 * row as f64
}

/// Number of multiplications and additions for factoring a periodic lattice of `columns` columns and `rows` rows.
pub fn band_products(columns: usize, rows: usize) -> f64 {
    let half_bandwidth = half_bandwidth(columns, rows, true) as f64;
    (2 * columns * rows) as f64 * half_bandwidth * half_bandwidth
}

impl System {
    /// Assembles and factors `lattice`. Contact blocks are pinned vertically, or tied if they touch in part, except for
    /// those of the columns `lifted`.
    pub fn new(lattice: &Lattice, lifted: &[usize]) -> Self {
        let (nx, rows) = (lattice.nx(), lattice.ny());
        let position = column_order(nx, lattice.is_periodic());
        let order = 2 * nx * rows;

        let contacts = contacts(lattice, lifted, |i| 2 * position[i] * rows);
        let mut system = Self {
            rows,
            position,
            contacts,
            supports: Vec::new(),
            factor: None,
            load: lattice.length(),
            coupling: vec![0.0; order],
            bulk_response: vec![0.0; order],
            bulk_stiffness: 0.0,
            relief: None,
        };
        let mut contact_at = vec![None; nx];
        for (number, contact) in system.contacts.iter().enumerate() {
            contact_at[contact.column] = Some(number);
        }

        let mut stiffness = BandMatrix::zero(order, half_bandwidth(nx, rows, lattice.is_periodic()));
        let mut touched = vec![false; order];
        lattice.for_each_bond(|bond| system.add_bond(&bond, &contact_at, &mut stiffness, &mut touched));
        // Removed blocks and pinned directions become identity rows.
        for (dof, touched) in touched.iter().enumerate() {
            if !touched {
                stiffness.pin(dof);
            }
        }
        for contact in &system.contacts {
            match contact.tie {
                _ if contact.lifted => {}
                Some(tie) => stiffness.add(contact.dof + 1, contact.dof + 1, tie),
                None => {
                    stiffness.pin(contact.dof + 1);
                    system.coupling[contact.dof + 1] = 0.0;
                }
            }
        }
        system.factor = stiffness.factor();
        if let Some(factor) = &system.factor {
            system.bulk_response.copy_from_slice(&system.coupling);
            factor.solve(&mut system.bulk_response);
            system.relief = lattice.is_raised().then(|| system.by_relief(lattice, &contact_at, factor));
        }
        system
    }

    fn by_relief(&self, lattice: &Lattice, contact_at: &[Option<usize>], factor: &BandFactor) -> Relief {
        let held = |contact: &Contact| contact.tie.is_none() && !contact.lifted;
        let height_of = |end: (usize, usize)| {
            let contact = if end.1 == 0 { contact_at[end.0] } else { None };
            contact.filter(|&number| held(&self.contacts[number])).map_or(0.0, |_| lattice.columns()[end.0].relief)
        };
        let mut relief = Relief { displacement: vec![0.0; self.coupling.len()], pull: 0.0 };
        lattice.for_each_bond(|bond| {
            let [_, kxy, kyy] = bond.linear();
            let ends = [Some(bond.a), bond.b];
            let heights = ends.map(|end| end.map_or(0.0, height_of));
            // f = -K r
            for (own, other) in [(0, 1), (1, 0)] {
                if let Some((i, j)) = ends[own] {
                    let dof = self.dof(i, j);
                    relief.displacement[dof] += kxy * (heights[other] - heights[own]);
                    relief.displacement[dof + 1] += kyy * (heights[other] - heights[own]);
                }
            }
            if bond.b.is_none() {
                relief.pull += kyy * heights[0];
            }
        });
        for contact in self.contacts.iter().filter(|contact| !contact.lifted) {
            let height = lattice.columns()[contact.column].relief;
            match contact.tie {
                Some(tie) => relief.displacement[contact.dof + 1] += tie * height,
                None => relief.displacement[contact.dof + 1] = height,
            }
        }
        factor.solve(&mut relief.displacement);
        relief
    }

    fn add_bond(
        &mut self,
        bond: &Bond,
        contact_at: &[Option<usize>],
        stiffness: &mut BandMatrix,
        touched: &mut [bool],
    ) {
        let k = bond.linear();
        let [kxx, kxy, kyy] = k;
        let a = self.dof(bond.a.0, bond.a.1);
        let b = bond.b.map(|(i, j)| self.dof(i, j));
        for end in [Some(a), b].into_iter().flatten() {
            stiffness.add(end, end, kxx);
            stiffness.add(end, end + 1, kxy);
            stiffness.add(end + 1, end + 1, kyy);
            touched[end] = true;
            touched[end + 1] = true;
        }
        match b {
            // A column that is its own neighbour has springs without relative motion along x.
            Some(b) if b == a => {}
            Some(b) => {
                stiffness.add(a, b, -kxx);
                stiffness.add(a, b + 1, -kxy);
                stiffness.add(a + 1, b, -kxy);
                stiffness.add(a + 1, b + 1, -kyy);
            }
            None => {
                self.coupling[a] += kxy;
                self.coupling[a + 1] += kyy;
                self.bulk_stiffness += kyy;
            }
        }
        for (end, other, block) in [(Some(bond.a), b, a), (bond.b, Some(a), b.unwrap_or(a))] {
            if let Some((i, 0)) = end
                && let Some(contact) = contact_at[i]
            {
                debug_assert_eq!(self.contacts[contact].dof, block);
                self.supports.push(Support { contact, other, kxy, kyy });
            }
        }
    }

    /// Index of the horizontal unknown of the block in column i of row j; the vertical unknown has the next index.
    pub fn dof(&self, i: usize, j: usize) -> usize {
        2 * (self.position[i] * self.rows + j)
    }

    /// Vertical force on the bulk per rise of the bulk, with the blocks following without friction, in units of the
    /// spring stiffness k.
    pub fn bulk_stiffness(&self) -> f64 {
        // c0 - b . u_b
        let give: f64 = self.coupling.iter().zip(&self.bulk_response).map(|(b, u)| b * u).sum();
        self.bulk_stiffness - give
    }

    /// Like [`LinearResponse::respond`], on a face whose heights, in lattice spacings, are multiplied by `scale`.
    fn respond_raised(&self, scale: f64, friction: &[f64], displacement: &mut [f64], normal: &mut [f64]) {
        displacement.fill(0.0);
        for (contact, force) in self.contacts.iter().zip(friction) {
            displacement[contact.dof] = -force;
        }
        if let Some(factor) = &self.factor {
            factor.solve(displacement);
        }
        self.complete(scale, displacement, normal);
    }

    /// Adds the effect of the face and the load to `displacement`, the displacements due to friction, and computes the
    /// normal forces.
    fn complete(&self, scale: f64, displacement: &mut [f64], normal: &mut [f64]) {
        if self.factor.is_none() {
            normal.fill(f64::NAN);
            return;
        }
        let relief = self.relief.as_ref().filter(|_| scale != 0.0);
        if let Some(relief) = relief {
            displacement.iter_mut().zip(&relief.displacement).for_each(|(u, by_relief)| *u += scale * by_relief);
        }
        // Load on the bulk: c0 H - b.u = -P L l with u = u_T + u_r + H u_b
        let pull: f64 = self.coupling.iter().zip(displacement.iter()).map(|(b, u)| b * u).sum();
        let pull = relief.map_or(pull, |relief| pull + scale * relief.pull);
        let height = (pull - self.load) / self.bulk_stiffness();
        for (u, response) in displacement.iter_mut().zip(&self.bulk_response) {
            *u += height * response;
        }
        normal.fill(0.0);
        for support in &self.supports {
            let own = self.contacts[support.contact].dof;
            let (other_x, other_y) =
                support.other.map_or((0.0, height), |dof| (displacement[dof], displacement[dof + 1]));
            // N = -(force of the springs on the block)_y
            normal[support.contact] +=
                support.kxy * (displacement[own] - other_x) + support.kyy * (displacement[own + 1] - other_y);
        }
        for (normal, contact) in normal.iter_mut().zip(&self.contacts) {
            if contact.lifted {
                *normal = 0.0; // in equilibrium off the counterface: what is left is rounding
            }
        }
    }
}

impl LinearResponse for System {
    fn order(&self) -> usize {
        self.coupling.len()
    }

    fn load(&self) -> f64 {
        self.load
    }

    fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    fn respond(&self, friction: &[f64], displacement: &mut [f64], normal: &mut [f64]) {
        self.respond_raised(0.0, friction, displacement, normal);
    }

    fn respond_each(&self, each: &mut [Response<'_>]) {
        let Some(factor) = self.factor.as_ref().filter(|_| each.len() > 1) else {
            for Response { friction, displacement, normal } in each {
                self.respond(friction, displacement, normal);
            }
            return;
        };
        let mut together = vec![[0.0; BATCH]; self.coupling.len()];
        for each in each.chunks_mut(BATCH) {
            together.fill([0.0; BATCH]);
            for (side, response) in each.iter().enumerate() {
                for (contact, force) in self.contacts.iter().zip(response.friction) {
                    together[contact.dof][side] = -force;
                }
            }
            factor.solve_batch(&mut together);
            for (side, Response { displacement, normal, .. }) in each.iter_mut().enumerate() {
                displacement.iter_mut().zip(&together).for_each(|(own, each)| *own = each[side]);
                self.complete(0.0, displacement, normal);
            }
        }
    }
}

impl LinearResponse for Raised<'_> {
    fn order(&self) -> usize {
        self.system.order()
    }

    fn load(&self) -> f64 {
        self.system.load()
    }

    fn contacts(&self) -> &[Contact] {
        self.system.contacts()
    }

    fn respond(&self, friction: &[f64], displacement: &mut [f64], normal: &mut [f64]) {
        self.system.respond_raised(self.scale, friction, displacement, normal);
    }
}

/// Contact blocks of `lattice`, left to right, with those of the columns `lifted` off the counterface; `dof` returns the
/// index of the horizontal unknown of the contact in a column.
pub fn contacts(lattice: &Lattice, lifted: &[usize], dof: impl Fn(usize) -> usize) -> Vec<Contact> {
    let mut contacts = Vec::new();
    let mut left = 0.0;
    for (i, column) in lattice.columns().iter().enumerate() {
        let share = lattice.contact_share(i);
        if share > 0.0 {
            contacts.push(Contact {
                column: i,
                width: share * column.width,
                centre: left + 0.5 * column.width,
                dof: dof(i),
                lifted: lifted.contains(&i),
                tie: (share < 1.0).then(|| tie(share, lattice.presence(i, 0))),
            });
        }
        left += column.width;
    }
    contacts
}

/// Position of every column in the order of elimination. A periodic lattice is folded, 0, n-1, 1, n-2, ..., so that
/// neighbours are at most two positions apart.
fn column_order(columns: usize, periodic: bool) -> Vec<usize> {
    (0..columns)
        .map(|i| match (periodic, i < columns.div_ceil(2)) {
            (false, _) => i,
            (true, true) => 2 * i,
            (true, false) => 2 * (columns - 1 - i) + 1,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folded_ring_keeps_neighbours_within_two_positions() {
        for columns in 1..12 {
            let position = column_order(columns, true);
            let mut sorted = position.clone();
            sorted.sort_unstable();
            assert_eq!(sorted, (0..columns).collect::<Vec<_>>());
            for i in 0..columns {
                assert!(position[i].abs_diff(position[(i + 1) % columns]) <= 2, "{columns} {i}");
            }
        }
    }
}
