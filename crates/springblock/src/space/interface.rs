//! What the cavities change of a flat layer: springs that are weaker or gone, blocks that do not touch.
//!
//! Displacements are those of the flat layer under forces that stand for what is missing:
//!
//! ```text
//! u = u_0 + G (g, w, t),     g = R u,     w: N(u) + kappa w = 0,     t = mu f(p) N
//! ```
//!
//! u_0 is uniform compression under the load, G the flat layer's response ([`super::layer`]), R the stiffness
//! of the missing springs, w the vertical displacement of blocks of row 0 that the counterface does not hold, or
//! holds in part as a spring kappa, and t the friction on those that it touches. So the unknowns are few:
//! forces on the blocks about the cavities, and one on each contact.
//!
//! A block that is gone has no unknown. All of its springs are missing, so that its row of R is that of the flat layer K:
//!
//! ```text
//! (g - R u)_b = g_b - (K u)_b = g_b - g_b = 0
//! ```
//!
//! whatever g is elsewhere, and g_b stays at 0.

mod responses;

use std::ops::Range;

use super::lattice::SpaceLattice;
use super::layer::{FlatLayer, Workspace};
use super::springs::{LEVEL, Spring, UPWARD, springs};
use crate::lattice::tie;

/// A spring that is missing, or weaker by `stiffness`, between blocks of which one at least is there.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Number of block a and of block b in the support; [`ABSENT`] of a block that is gone.
    ends: [usize; 2],
    /// Places of their x components.
    places: [usize; 2],
    direction: [f64; 3],
    stiffness: f64,
}

/// Least share of a block's stiffness that counts: what hangs on less is no part of the solid.
const MIN_LEFT: f64 = 1e-4;

/// Number in the support of a block that has none.
const ABSENT: usize = usize::MAX;

/// A block of row 0 that is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Columns along x and y.
    pub column: [usize; 2],
    /// Share of its area that touches the counterface.
    pub contact_share: f64,
    /// Its number among the blocks with an unknown height, and the tie's stiffness.
    free: Option<(usize, f64)>,
    /// Its number among the contacts.
    pub contact: Option<usize>,
    /// Whether it is a contact that has left the counterface.
    lifted: bool,
    /// Whether it is a contact that yields under the pressure that it bears.
    yields: bool,
    /// Height of its face, in lattice spacings.
    pub relief: f64,
    /// Stiffness of its tie to the face where it touches in part; 0 where it does wholly.
    tie: f64,
    /// Stiffness of its springs upward, and of its tie.
    pivot: f64,
}

impl Surface {
    /// Stiffness of what holds it to the face while its height is unknown.
    fn own_tie(&self) -> f64 {
        self.free.map_or(0.0, |(_, tie)| tie)
    }

    /// Height of the face of a block at the height `height` that yields under `face`: above it by what its tie yields.
    fn flattened(&self, height: f64, face: Face) -> f64 {
        if self.tie > 0.0 { height + face.limit * self.contact_share / self.tie } else { height }
    }
}

/// The patterned interface of a lattice.
#[derive(Clone, Debug)]
pub struct Interface {
    columns: [usize; 2],
    /// Columns that are not cut away.
    face_columns: usize,
    area: f64,
    explicit: usize,
    layer: FlatLayer,
    weakened: Vec<Link>,
    /// Places of the x components of the blocks with a missing spring.
    support: Vec<usize>,
    /// For each force of the support, stiffness of the flat layer over what is left of it.
    softness: Vec<f64>,
    surface: Vec<Surface>,
    /// Columns of the contacts, by their number.
    touching: Vec<usize>,
    /// Those of `surface` whose height is unknown, by its number.
    free: Vec<usize>,
    /// Lines whose displacements matter: component field times ny + j.
    wanted: Vec<bool>,
    stencil: Stencil,
    /// Force per block column over 3/2 of a spring: compression of one row under unit pressure.
    compression: f64,
}

/// Forces of the springs upward from row 0 of the flat layer: N = sum k e_z e.(u_a - u_b).
#[derive(Clone, Copy, Debug, Default)]
struct Stencil {
    /// sum k e_z^2
    rise: f64,
    /// k e_z^2 of the vertical spring, and of one along x and along y.
    vertical: [f64; 3],
    /// k e_z e_x of one along x, k e_z e_y of one along y.
    aslant: [f64; 2],
}

/// What of a face does not depend on the unknowns.
#[derive(Clone, Copy, Debug, Default)]
pub struct Face {
    /// Heights of the face over their lengths in lattice spacings: 1 over the unit of displacement of the present load.
    pub raise: f64,
    /// Normal force on the area of a whole column at which it yields, in units of P l^2.
    pub limit: f64,
}

/// The unknowns' image under the elastic response, and the displacements it came from.
pub struct Response {
    /// Displacements of the explicit rows.
    pub fields: Vec<f64>,
    /// R u, then the imbalance of free blocks over their stiffness.
    pub linear: Vec<f64>,
    /// Normal force by contact.
    pub normal: Vec<f64>,
    /// Force that each column presses down.
    pressed: Vec<f64>,
    workspace: Workspace,
}

impl Interface {
    /// The interface of `lattice`; condenses the flat layer above it.
    #[must_use]
    pub fn new(lattice: &SpaceLattice) -> Self {
        // A missing spring reaches from the cavities' last row to the next at most, a contact's from row 0 to 1.
        Self::with_rows(lattice, (lattice.changed_rows() + 1).max(2))
    }

    /// The same with the displacements of all rows and of the bulk, everywhere.
    #[must_use]
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
        // Springs of a block that are missing wholly; without any it is gone.
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
        // Ceilings say whether cavities close.
        let ceiling = lattice.ceiling_row();
        for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
            if lattice.is_cavity(i, j) {
                want(place([i, j, ceiling]));
            }
        }
        // The counterface bears what the springs from row 0 to row 1 press down.
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

    /// What a force on a block of the support does to its own residual is nearly what is left of the block's stiffness, because every
    /// spring of a loaded block of the layer takes about the same share of the load:
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

    /// Multiplies `residual` by what nearly inverts the response to each unknown alone.
    pub fn precondition(&self, residual: &mut [f64]) {
        residual.iter_mut().zip(&self.softness).for_each(|(residual, softness)| *residual *= softness);
    }

    /// Finds the blocks of row 0 that are there, and what presses them down.
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
                // Springs of the plane are two of these.
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

    /// The same with the contacts that `lifted` names by their number off the counterface: free, without friction.
    #[must_use]
    pub fn with_lifted(&self, lifted: &[bool]) -> Self {
        self.with_contacts(lifted, &vec![false; lifted.len()])
    }

    /// The same where those that `yields` names are flattened, free under the pressure at which they yield.
    #[must_use]
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

    /// The unknowns of this interface that continue `unknowns` of `other`, which differs from it in the contacts that are off
    /// the counterface, on a face of `raise` times its heights.
    pub fn continued(&self, other: &Self, unknowns: &[f64], raise: f64) -> Vec<f64> {
        let (forces, rest) = unknowns.split_at(3 * self.support.len());
        let (heights, friction) = rest.split_at(other.free.len());
        let mut continued = forces.to_vec();
        for (own, before) in self.surface.iter().zip(&other.surface).filter(|(own, _)| own.free.is_some()) {
            continued.push(before.free.map_or(raise * own.relief, |(number, _)| heights[number]));
        }
        let lifted = self.surface.iter().filter(|surface| surface.contact.is_some()).map(|surface| surface.lifted);
        continued.extend(lifted.zip(friction).map(|(lifted, friction)| if lifted { 0.0 } else { *friction }));
        continued
    }

    /// Takes the heights of the face from `other`, whose contacts are the same.
    pub fn take_heights(&mut self, other: &Self) {
        for (own, other) in self.surface.iter_mut().zip(&other.surface) {
            own.relief = other.relief;
        }
    }

    /// Makes what yields as high as it stands in `unknowns` under `face`.
    pub fn flatten(&mut self, unknowns: &[f64], face: Face) {
        let heights = &unknowns[3 * self.support.len()..];
        for surface in self.surface.iter_mut().filter(|surface| surface.yields) {
            if let Some((number, _)) = surface.free {
                surface.relief = surface.flattened(heights[number], face) / face.raise;
            }
        }
    }

    /// Height of the face of each contact that yields, under `face`.
    pub fn yielding<'a>(&'a self, unknowns: &'a [f64], face: Face) -> impl Iterator<Item = Option<f64>> + 'a {
        let heights = &unknowns[3 * self.support.len()..];
        let contacts = self.surface.iter().filter(|surface| surface.contact.is_some());
        contacts.map(move |surface| {
            surface.free.filter(|_| surface.yields).map(|(number, _)| surface.flattened(heights[number], face))
        })
    }

    /// Whether each contact is off the counterface, and its height in `unknowns` where it is.
    pub fn lifted<'a>(&'a self, unknowns: &'a [f64]) -> impl Iterator<Item = Option<f64>> + 'a {
        let heights = &unknowns[3 * self.support.len()..];
        let contacts = self.surface.iter().filter(|surface| surface.contact.is_some());
        contacts.map(|surface| surface.free.filter(|_| surface.lifted).map(|(number, _)| heights[number]))
    }

    /// Blocks of row 0 that are there.
    #[must_use]
    pub fn surface(&self) -> &[Surface] {
        &self.surface
    }

    /// Number of contacts.
    #[must_use]
    pub const fn contacts(&self) -> usize {
        self.touching.len()
    }

    /// Number of unknowns before the friction forces: forces about the cavities, heights of free blocks.
    #[must_use]
    pub fn elastic_unknowns(&self) -> usize {
        3 * self.support.len() + self.free.len()
    }

    /// Number of blocks with an unknown height: the last of those unknowns.
    #[must_use]
    pub const fn free(&self) -> usize {
        self.free.len()
    }

    /// The load of the cell in units of P l^2, which is its area over l^2.
    #[must_use]
    pub fn load(&self) -> f64 {
        self.face_columns as f64 * self.area
    }

    /// Nominal area of a column over l^2.
    #[must_use]
    pub const fn column_area(&self) -> f64 {
        self.area
    }
}
