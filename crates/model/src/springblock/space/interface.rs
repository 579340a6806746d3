//! Effect of the cavities on a flat layer: springs that are weaker or missing, and blocks that do not touch.
//!
//! Displacements are those of the flat layer under forces that represent the missing springs:
//!
//! ```text
//! u = u_0 + G (g, w, t),     g = R u,     w: N(u) + kappa w = 0,     t = mu f(p) N
//! ```
//!
//! u_0 is uniform compression under the load, G the response of the flat layer ([`super::layer`]), and R the stiffness
//! of the missing springs. w is the vertical displacement of blocks of row 0 that the counterface does not hold, or
//! holds in part by a spring kappa; N is the normal force on a block and t the friction force on the contacts, with the
//! friction coefficient mu and the area factor f at the pressure p. The unknowns are therefore few: forces on the
//! blocks around the cavities, and one friction force per contact.
//!
//! A removed block has no unknown. All of its springs are missing, so that its row of R equals that of the flat layer
//! K:
//!
//! ```text
//! (g - R u)_b = g_b - (K u)_b = g_b - g_b = 0
//! ```
//!
//! for any g elsewhere, and g_b stays at 0.

mod responses;

use std::ops::Range;

use super::lattice::SpaceLattice;
use super::layer::{FlatLayer, Workspace};
use super::springs::{LEVEL, Spring, UPWARD, springs};
use crate::springblock::lattice::tie;

/// A spring that is missing, or weaker than in the flat layer; at least one of the two blocks exists. `stiffness` is
/// the missing part of the stiffness, in units of the spring stiffness k.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Indices in `Interface::support` of the blocks at both ends; [`ABSENT`] for a removed block.
    ends: [usize; 2],
    /// Indices of the x displacements of the two blocks in [`Response::fields`].
    places: [usize; 2],
    direction: [f64; 3],
    stiffness: f64,
}

/// The preconditioner divides by the remaining fraction of a block's stiffness, or by this minimum if the fraction is
/// smaller; springs with a smaller fraction are not part of the lattice.
const MIN_LEFT: f64 = 1e-4;

/// Index of a block that is removed or has no missing spring, and therefore is not in `Interface::support`.
const ABSENT: usize = usize::MAX;

/// A block of row 0, the row at the counterface, that no cavity removes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Column indices along x and y.
    pub column: [usize; 2],
    /// Fraction of the area of the column that touches the counterface.
    pub contact_share: f64,
    /// Index among the blocks with an unknown height, and the stiffness of the tie to the face, in units of the spring
    /// stiffness k; `None` for a block that the counterface holds at the height of its face.
    free: Option<(usize, f64)>,
    /// Index among the contacts; `None` for a block that does not touch.
    pub contact: Option<usize>,
    /// Whether the block is a contact that has lifted off the counterface.
    lifted: bool,
    /// Whether the block is a contact that yields under its pressure.
    yields: bool,
    /// Height of the face, in lattice spacings.
    pub relief: f64,
    /// Stiffness of the spring between block and face (the tie) if the block touches in part, in units of the spring
    /// stiffness k; otherwise 0.
    tie: f64,
    /// Vertical stiffness of the springs upward and the tie together, in units of the spring stiffness k.
    pivot: f64,
}

impl Surface {
    /// Stiffness of the spring between block and face (the tie) if the block's height is an unknown of the equations; 0
    /// if the counterface holds the block. In units of the spring stiffness k.
    fn own_tie(&self) -> f64 {
        self.free.map_or(0.0, |(_, tie)| tie)
    }

    /// Height of the face of a yielding block whose vertical displacement is `height`: the face is higher by the
    /// deformation of the tie. Heights are in units of P l^2 / k (nominal pressure P, lattice spacing l, spring
    /// stiffness k).
    fn flattened(&self, height: f64, face: Face) -> f64 {
        if self.tie > 0.0 { height + face.limit * self.contact_share / self.tie } else { height }
    }
}

/// Equations of the patterned interface of a lattice: cavities and contacts below a flat layer. P is the nominal
/// pressure, l the lattice spacing, k the spring stiffness.
#[derive(Clone, Debug)]
pub struct Interface {
    columns: [usize; 2],
    /// Number of columns that belong to the face, without the gap of a strip.
    face_columns: usize,
    area: f64,
    explicit: usize,
    layer: FlatLayer,
    weakened: Vec<Link>,
    /// Indices in [`Response::fields`] of the x displacements of the blocks with a missing or weaker spring.
    support: Vec<usize>,
    /// For each force component on the blocks of `support`: stiffness in the flat layer divided by the remaining
    /// stiffness.
    softness: Vec<f64>,
    surface: Vec<Surface>,
    /// Column j * nx + i of each contact, by contact index.
    touching: Vec<usize>,
    /// Indices into `surface` of the blocks with an unknown height.
    free: Vec<usize>,
    /// Whether the displacements on a line along x are needed; index f ny + j for field f (three fields x, y, z per
    /// row) and line j.
    wanted: Vec<bool>,
    stencil: Stencil,
    /// Compression of one row under the nominal pressure, in units of P l^2 / k: the area of a column divided by the
    /// vertical stiffness of the springs upward of a block.
    compression: f64,
}

/// Forces of the springs upward from row 0 of the flat layer: N = sum k e_z e.(u_a - u_b), with the unit vector e of a
/// spring and the displacements u_a and u_b of its lower and upper ends.
#[derive(Clone, Copy, Debug, Default)]
struct Stencil {
    /// Sum of k e_z^2 over all springs upward.
    rise: f64,
    /// k e_z^2 of the vertical spring, of a spring inclined along x, and of a spring inclined along y.
    vertical: [f64; 3],
    /// k e_z e_x of the spring inclined along x, and k e_z e_y of the spring inclined along y.
    aslant: [f64; 2],
}

/// Scale of the face heights, and limit of the normal forces, under the current load with the nominal pressure P.
#[derive(Clone, Copy, Debug, Default)]
pub struct Face {
    /// Factor that converts face heights from lattice spacings l to units of P l^2 / k, with the spring stiffness k.
    pub raise: f64,
    /// Normal force at which a column that touches fully yields, in units of P l^2; infinity without a yield pressure.
    pub limit: f64,
}

/// Elastic response to the unknowns, with the displacements from which it was computed; P is the nominal pressure, l
/// the lattice spacing, k the spring stiffness.
pub struct Response {
    /// Displacements of the explicit rows, in units of P l^2 / k: component c of the block in column i, line j and row
    /// k has the index ((3 k + c) ny + j) nx + i.
    pub fields: Vec<f64>,
    /// Forces R u of the missing springs, then for each block with an unknown height the vertical unbalanced force
    /// divided by the stiffness `Surface::pivot`.
    pub linear: Vec<f64>,
    /// Normal force by contact, in units of P l^2.
    pub normal: Vec<f64>,
    /// Downward force on the block of row 0 in each column, in units of P l^2.
    pressed: Vec<f64>,
    workspace: Workspace,
}

impl Interface {
    /// Creates the interface of `lattice`; condenses the flat layer above it.
    pub fn new(lattice: &SpaceLattice) -> Self {
        // A missing spring reaches from the last row of the cavities at most to the next row, a contact's spring from
        // row 0 to 1.
        Self::with_rows(lattice, (lattice.changed_rows() + 1).max(2))
    }

    /// Like [`Self::new`], but computes the displacements of all blocks and of the bulk.
    pub fn uncondensed(lattice: &SpaceLattice) -> Self {
        let mut interface = Self::with_rows(lattice, lattice.rows() + 1);
        interface.wanted.fill(true);
        interface
    }

    fn with_rows(lattice: &SpaceLattice, explicit: usize) -> Self {
        let [nx, ny] = lattice.columns();
        let plane = nx * ny;
        let rows = lattice.rows();
        let place = |[i, j, k]: [usize; 3]| 3 * k * plane + j * nx + i;
        let block = |[i, j, k]: [usize; 3]| k * plane + j * nx + i;
        // Count of missing springs by block; a block without springs is removed.
        let mut missing = vec![0_u8; (explicit * plane).max(1)];
        lattice.for_each_weakened_bond(|bond| {
            if bond.share == 0.0 {
                missing[block(bond.a)] += 1;
                missing[block(bond.b)] += 1;
            }
        });
        let all = |place: usize| if place < plane { 2 * LEVEL + UPWARD } else { 2 * (LEVEL + UPWARD) };
        let mut number = vec![ABSENT; missing.len()];
        let mut support = Vec::new();
        let mut weakened = Vec::new();
        let mut wanted = vec![false; 3 * explicit * ny];
        let mut want = |place: usize| (0..3).for_each(|c| wanted[place / nx + c * ny] = true);
        lattice.for_each_weakened_bond(|bond| {
            let is_there = [bond.a, bond.b].map(|end| usize::from(missing[block(end)]) < all(block(end)));
            if is_there == [false; 2] {
                return;
            }
            let ends = [0, 1].map(|side| {
                let end = [bond.a, bond.b][side];
                want(place(end));
                let slot = &mut number[block(end)];
                if *slot == ABSENT && is_there[side] {
                    *slot = support.len();
                    support.push(place(end));
                }
                *slot
            });
            let stiffness = bond.spring.stiffness * (1.0 - bond.share);
            let places = [place(bond.a), place(bond.b)];
            weakened.push(Link { ends, places, direction: bond.spring.direction(), stiffness });
        });
        // Ceilings are needed to detect closed cavities.
        let ceiling = lattice.ceiling_row();
        for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
            if lattice.is_cavity(i, j) {
                want(place([i, j, ceiling]));
            }
        }
        // The counterface carries the force of the springs from row 0 to row 1.
        (0..ny).for_each(|j| want(place([0, j, 1])));
        let mut interface = Self {
            columns: [nx, ny],
            face_columns: lattice.face_columns(),
            area: 1.0,
            explicit,
            layer: FlatLayer::new([nx, ny], lattice.spacing(), rows, explicit),
            weakened,
            softness: Vec::new(),
            support,
            surface: Vec::new(),
            touching: Vec::new(),
            free: Vec::new(),
            wanted,
            stencil: Stencil::default(),
            compression: 1.0,
        };
        interface.find_surface(lattice);
        interface.find_softness(lattice);
        interface
    }

    /// Computes the diagonal preconditioner.
    ///
    /// A force on a block with a missing spring changes its own residual by nearly the remaining fraction of the
    /// block's stiffness, because every spring of a loaded block of the layer takes about the same share of the load.
    /// With the stiffness K of the flat layer:
    ///
    /// ```text
    /// (I - R G)_ii = ((K - R) G)_ii ~ (K - R)_ii / K_ii
    /// ```
    fn find_softness(&mut self, lattice: &SpaceLattice) {
        let plane = self.columns[0] * self.columns[1];
        let kinds = springs(lattice.spacing());
        let of = |kinds: &[Spring], c: usize| -> f64 {
            kinds.iter().map(|spring| spring.stiffness * spring.direction()[c].powi(2)).sum()
        };
        let whole =
            [0, 1, 2].map(|c| [2.0, 1.0].map(|sides| 2.0 * of(&kinds[..LEVEL], c) + sides * of(&kinds[LEVEL..], c)));
        let mut missing = vec![0.0; 3 * self.support.len()];
        for link in &self.weakened {
            for end in link.ends.into_iter().filter(|end| *end != ABSENT) {
                (0..3).for_each(|c| missing[3 * end + c] += link.stiffness * link.direction[c].powi(2));
            }
        }
        let all = self.support.iter().flat_map(|place| whole.map(|whole| whole[usize::from(*place < plane)]));
        self.softness = all.zip(missing).map(|(all, missing)| 1.0 / (1.0 - missing / all).max(MIN_LEFT)).collect();
    }

    /// Applies the diagonal preconditioner to `residual`.
    pub fn precondition(&self, residual: &mut [f64]) {
        residual.iter_mut().zip(&self.softness).for_each(|(residual, softness)| *residual *= softness);
    }

    /// Finds the blocks of row 0 that no cavity removes, and the springs that press these blocks down.
    fn find_surface(&mut self, lattice: &SpaceLattice) {
        let [nx, ny] = self.columns;
        for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
            if lattice.presence(i, j, 0) <= 0.0 {
                continue;
            }
            let share = lattice.contact_share(i, j);
            let upward = lattice.upward(i, j);
            let pivot: f64 =
                upward.map(|bond| bond.spring.stiffness * bond.share * bond.spring.direction()[2].powi(2)).sum();
            if pivot == 0.0 {
                continue;
            }
            let own = self.surface.len();
            let free = (share < 1.0).then(|| {
                self.free.push(own);
                // A spring of the plane corresponds to two springs in space.
                let held = if share > 0.0 { 2.0 * tie(share, lattice.presence(i, j, 0)) } else { 0.0 };
                (self.free.len() - 1, held)
            });
            let contact = (share > 0.0).then(|| {
                self.touching.push(j * nx + i);
                self.touching.len() - 1
            });
            let tie = free.map_or(0.0, |(_, tie)| tie);
            let pivot = pivot + tie;
            let relief = lattice.relief(i, j);
            self.surface.push(Surface {
                column: [i, j],
                contact_share: share,
                free,
                contact,
                lifted: false,
                yields: false,
                relief,
                tie,
                pivot,
            });
        }
        let [a, b] = lattice.spacing();
        let upward = &springs([a, b])[LEVEL..];
        let along = |spring: &Spring, axis: usize| spring.stiffness * spring.direction()[2] * spring.direction()[axis];
        self.stencil = Stencil {
            rise: upward.iter().map(|spring| along(spring, 2)).sum(),
            vertical: [0, 1, 3].map(|kind| along(&upward[kind], 2)),
            aslant: [along(&upward[1], 0), along(&upward[3], 1)],
        };
        self.area = a * b;
        self.compression = a * b / self.stencil.rise;
    }

    /// Returns the interface with other contact states, given for each contact: lifted contacts are off the counterface
    /// and free, without friction; yielding contacts are free under the pressure at which they yield.
    pub fn with_contacts(&self, lifted: &[bool], yields: &[bool]) -> Self {
        let mut interface = self.clone();
        interface.free.clear();
        for (own, surface) in interface.surface.iter_mut().enumerate() {
            let tie = surface.own_tie();
            let lifts = surface.contact.is_some_and(|number| lifted[number]);
            surface.lifted = lifts;
            surface.yields = surface.contact.is_some_and(|number| yields[number]);
            let is_free = lifts || surface.yields;
            let kept = if is_free { 0.0 } else { tie };
            surface.pivot += kept - tie;
            surface.free = (is_free || surface.free.is_some()).then_some((interface.free.len(), kept));
            if surface.free.is_some() {
                interface.free.push(own);
            }
        }
        interface
    }

    /// Converts the `unknowns` of `other`, which differs in its lifted and yielding contacts, to those of this
    /// interface; `raise` converts face heights to units of P l^2 / k.
    pub fn convert_unknowns(&self, other: &Self, unknowns: &[f64], raise: f64) -> Vec<f64> {
        let (forces, rest) = unknowns.split_at(3 * self.support.len());
        let (heights, friction) = rest.split_at(other.free.len());
        let mut converted = forces.to_vec();
        for (own, before) in self.surface.iter().zip(&other.surface).filter(|(own, _)| own.free.is_some()) {
            converted.push(before.free.map_or(raise * own.relief, |(number, _)| heights[number]));
        }
        let lifted = self.surface.iter().filter(|surface| surface.contact.is_some()).map(|surface| surface.lifted);
        converted.extend(lifted.zip(friction).map(|(lifted, friction)| if lifted { 0.0 } else { *friction }));
        converted
    }

    /// Copies the heights of the face from `other`, which has the same contacts.
    pub fn copy_heights(&mut self, other: &Self) {
        for (own, other) in self.surface.iter_mut().zip(&other.surface) {
            own.relief = other.relief;
        }
    }

    /// Sets the face heights of yielding contacts to the heights to which the contacts are pressed by the solution
    /// `unknowns` under `face`.
    pub fn flatten(&mut self, unknowns: &[f64], face: Face) {
        let heights = &unknowns[3 * self.support.len()..];
        for surface in self.surface.iter_mut().filter(|surface| surface.yields) {
            if let Some((number, _)) = surface.free {
                surface.relief = surface.flattened(heights[number], face) / face.raise;
            }
        }
    }

    /// Height of the face of each yielding contact in the solution `unknowns` under `face`, in units of P l^2 / k;
    /// `None` for other contacts.
    pub fn yielding<'a>(&'a self, unknowns: &'a [f64], face: Face) -> impl Iterator<Item = Option<f64>> + 'a {
        let heights = &unknowns[3 * self.support.len()..];
        let contacts = self.surface.iter().filter(|surface| surface.contact.is_some());
        contacts.map(move |surface| {
            surface.free.filter(|_| surface.yields).map(|(number, _)| surface.flattened(heights[number], face))
        })
    }

    /// Height of each lifted contact in the solution `unknowns`, in units of P l^2 / k; `None` for other contacts.
    pub fn lifted<'a>(&'a self, unknowns: &'a [f64]) -> impl Iterator<Item = Option<f64>> + 'a {
        let heights = &unknowns[3 * self.support.len()..];
        let contacts = self.surface.iter().filter(|surface| surface.contact.is_some());
        contacts.map(|surface| surface.free.filter(|_| surface.lifted).map(|(number, _)| heights[number]))
    }

    /// Blocks of row 0, the row at the counterface, that no cavity removes.
    pub fn surface(&self) -> &[Surface] {
        &self.surface
    }

    pub const fn contacts(&self) -> usize {
        self.touching.len()
    }

    /// Number of unknowns that precede the friction forces: forces around the cavities, then heights of free blocks.
    pub fn elastic_unknowns(&self) -> usize {
        3 * self.support.len() + self.free.len()
    }

    /// Number of blocks with an unknown height, which are the last elastic unknowns.
    pub const fn free(&self) -> usize {
        self.free.len()
    }

    /// Load of the cell in units of P l^2 (nominal pressure P, lattice spacing l), which equals the area of the face
    /// over l^2.
    pub fn load(&self) -> f64 {
        self.face_columns as f64 * self.area
    }

    /// Nominal area of a column, in squares of the lattice spacing.
    pub const fn column_area(&self) -> f64 {
        self.area
    }
}
