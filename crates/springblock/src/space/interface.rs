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

use super::lattice::SpaceLattice;
use super::layer::{FlatLayer, Workspace};
use super::springs::{LEVEL, springs};
use crate::lattice::tie;

/// A spring between two places of the explicit fields.
#[derive(Clone, Copy, Debug)]
struct Link {
    /// Number of block a and of block b in the support, of a spring upward from a contact that of the contact.
    ends: [usize; 2],
    /// Places of their x components.
    places: [usize; 2],
    direction: [f64; 3],
    stiffness: f64,
}

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
    /// Height of the face of a block at the height `height` that yields under `face`: above it by what its tie yields.
    fn flattened(&self, height: f64, face: Face) -> f64 {
        if self.tie > 0.0 { height + face.limit * self.contact_share / self.tie } else { height }
    }
}

/// The patterned interface of a lattice.
#[derive(Clone, Debug)]
pub struct Interface {
    columns: [usize; 2],
    area: f64,
    explicit: usize,
    layer: FlatLayer,
    weakened: Vec<Link>,
    /// Places of the x components of the blocks with a missing spring.
    support: Vec<usize>,
    surface: Vec<Surface>,
    /// Springs upward from the surface blocks.
    upward: Vec<Link>,
    free: usize,
    contacts: usize,
    wanted: Vec<bool>,
    /// Force per block column over 3/2 of a spring: compression of one row under unit pressure.
    compression: f64,
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
    workspace: Workspace,
}

impl Interface {
    /// The interface of `lattice`; condenses the flat layer above it.
    #[must_use]
    pub fn new(lattice: &SpaceLattice) -> Self {
        // A missing spring reaches from the cavities' last row to the next at most, a contact's from row 0 to 1.
        Self::with_rows(lattice, (lattice.cavity_rows() + 1).max(2))
    }

    /// The same with the displacements of all rows and of the bulk.
    #[must_use]
    pub fn uncondensed(lattice: &SpaceLattice) -> Self {
        Self::with_rows(lattice, lattice.rows() + 1)
    }

    fn with_rows(lattice: &SpaceLattice, explicit: usize) -> Self {
        let [nx, ny] = lattice.columns();
        let plane = nx * ny;
        let rows = lattice.rows();
        let place = |[i, j, k]: [usize; 3]| 3 * k * plane + j * nx + i;
        let mut number = vec![usize::MAX; (explicit * plane).max(1)];
        let mut support = Vec::new();
        let mut weakened = Vec::new();
        lattice.for_each_weakened_bond(|bond| {
            let ends = [bond.a, bond.b].map(|[i, j, k]| {
                let slot = &mut number[k * plane + j * nx + i];
                if *slot == usize::MAX {
                    *slot = support.len();
                    support.push(place([i, j, k]));
                }
                *slot
            });
            let stiffness = bond.spring.stiffness * (1.0 - bond.share);
            let places = [place(bond.a), place(bond.b)];
            weakened.push(Link { ends, places, direction: bond.spring.direction(), stiffness });
        });
        let (mut surface, mut upward) = (Vec::new(), Vec::new());
        let (mut free, mut contacts) = (0, 0);
        for (j, i) in (0..ny).flat_map(|j| (0..nx).map(move |i| (j, i))) {
            if lattice.presence(i, j, 0) <= 0.0 {
                continue;
            }
            let share = lattice.contact_share(i, j);
            let own = surface.len();
            let mut pivot = 0.0;
            for bond in lattice.upward(i, j) {
                let direction = bond.spring.direction();
                let stiffness = bond.spring.stiffness * bond.share;
                pivot += stiffness * direction[2] * direction[2];
                let places = [place(bond.a), place(bond.b)];
                upward.push(Link { ends: [own, own], places, direction, stiffness });
            }
            if pivot == 0.0 {
                continue;
            }
            let free = (share < 1.0).then(|| {
                free += 1;
                // Springs of the plane are two of these.
                let held = if share > 0.0 { 2.0 * tie(share, lattice.presence(i, j, 0)) } else { 0.0 };
                (free - 1, held)
            });
            let contact = (share > 0.0).then(|| {
                contacts += 1;
                contacts - 1
            });
            let tie = free.map_or(0.0, |(_, tie)| tie);
            let pivot = pivot + tie;
            let relief = lattice.relief(i, j);
            surface.push(Surface {
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
        // sum k e_z^2 of the springs upward
        let rise: f64 = springs([a, b])[LEVEL..].iter().map(|s| s.stiffness * s.direction()[2].powi(2)).sum();
        let mut wanted = vec![false; 3 * explicit * ny];
        wanted[..6 * ny].fill(true);
        for place in &support {
            for component in 0..3 {
                wanted[(place + component * plane) / nx] = true;
            }
        }
        Self {
            columns: [nx, ny],
            area: a * b,
            explicit,
            layer: FlatLayer::new([nx, ny], [a, b], rows, explicit),
            weakened,
            support,
            surface,
            upward,
            free,
            contacts,
            wanted,
            compression: a * b / rise,
        }
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
        interface.free = 0;
        for surface in &mut interface.surface {
            let tie = surface.free.map_or(0.0, |(_, tie)| tie);
            let lifts = surface.contact.is_some_and(|number| lifted[number]);
            surface.lifted = lifts;
            surface.yields = surface.contact.is_some_and(|number| yields[number]);
            let is_free = lifts || surface.yields;
            let kept = if is_free { 0.0 } else { tie };
            surface.pivot += kept - tie;
            surface.free = (is_free || surface.free.is_some()).then_some((interface.free, kept));
            interface.free += usize::from(surface.free.is_some());
        }
        interface
    }

    /// The unknowns of this interface that continue `unknowns` of `other`, which differs from it in the contacts that are off
    /// the counterface, on a face of `raise` times its heights.
    pub fn continued(&self, other: &Self, unknowns: &[f64], raise: f64) -> Vec<f64> {
        let (forces, rest) = unknowns.split_at(3 * self.support.len());
        let (heights, friction) = rest.split_at(other.free);
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
        self.contacts
    }

    /// Number of unknowns before the friction forces: forces about the cavities, heights of free blocks.
    #[must_use]
    pub fn elastic_unknowns(&self) -> usize {
        3 * self.support.len() + self.free
    }

    /// Number of blocks with an unknown height: the last of those unknowns.
    #[must_use]
    pub const fn free(&self) -> usize {
        self.free
    }

    /// The load of the cell in units of P l^2, which is its area over l^2.
    #[must_use]
    pub fn load(&self) -> f64 {
        (self.columns[0] * self.columns[1]) as f64 * self.area
    }

    /// Nominal area of a column over l^2.
    #[must_use]
    pub const fn column_area(&self) -> f64 {
        self.area
    }

    /// Work space and results of [`Self::respond`].
    #[must_use]
    pub fn response(&self) -> Response {
        Response {
            fields: vec![0.0; 3 * self.explicit * self.columns[0] * self.columns[1]],
            linear: vec![0.0; self.elastic_unknowns()],
            normal: vec![0.0; self.contacts],
            workspace: self.layer.workspace(),
        }
    }

    /// The response to no unknowns at all: uniform compression, u_z = -k P l^2 / (3 k) on row k.
    pub fn compress(&self, response: &mut Response) {
        let plane = self.columns[0] * self.columns[1];
        for (row, fields) in response.fields.chunks_exact_mut(3 * plane).enumerate() {
            fields[..2 * plane].fill(0.0);
            fields[2 * plane..].fill(-(row as f64) * self.compression);
        }
        self.observe(Face::default(), response);
    }

    /// The linear response to `unknowns`, friction acting along `direction`, and to `face`; with
    /// `everywhere` displacements are complete, otherwise only those that matter are computed.
    pub fn respond(
        &self,
        unknowns: &[f64],
        direction: [f64; 2],
        face: Face,
        everywhere: bool,
        response: &mut Response,
    ) {
        let [nx, ny] = self.columns;
        let plane = nx * ny;
        let fields = &mut response.fields;
        fields.fill(0.0);
        let (forces, rest) = unknowns.split_at(3 * self.support.len());
        let (heights, friction) = rest.split_at(self.free);
        for (place, force) in self.support.iter().zip(forces.chunks_exact(3)) {
            for (component, force) in force.iter().enumerate() {
                // Row 0 is held vertically: its displacement is the unknown there, not a force.
                if component < 2 || *place >= plane {
                    fields[place + component * plane] = *force;
                }
            }
        }
        for surface in &self.surface {
            let place = surface.column[1] * nx + surface.column[0];
            match surface.free {
                Some((number, _)) => fields[2 * plane + place] = heights[number],
                None => fields[2 * plane + place] = face.raise * surface.relief,
            }
            if let Some(number) = surface.contact {
                fields[place] += direction[0] * friction[number];
                fields[plane + place] += direction[1] * friction[number];
            }
        }
        if everywhere {
            self.layer.respond(fields, &vec![true; 3 * self.explicit * ny], &mut response.workspace);
        } else {
            self.layer.respond(fields, &self.wanted, &mut response.workspace);
        }
        self.observe(face, response);
    }

    /// R u, normal forces and imbalances from the displacements in `response`.
    fn observe(&self, face: Face, response: &mut Response) {
        let plane = self.columns[0] * self.columns[1];
        let Response { fields, linear, normal, .. } = response;
        let (forces, imbalances) = linear.split_at_mut(3 * self.support.len());
        forces.fill(0.0);
        let along = |link: &Link| -> f64 {
            let [a, b] = link.places;
            (0..3).map(|c| link.direction[c] * (fields[a + c * plane] - fields[b + c * plane])).sum()
        };
        for link in &self.weakened {
            // R = sum (1 - share) k e e^T
            let force = link.stiffness * along(link);
            let [a, b] = link.ends;
            for (c, e) in link.direction.iter().enumerate() {
                forces[3 * a + c] += force * e;
                forces[3 * b + c] -= force * e;
            }
        }
        for (place, force) in self.support.iter().zip(forces.chunks_exact_mut(3)) {
            if *place < plane {
                force[2] = 0.0;
            }
        }
        // The counterface bears what the springs press down: N = sum k e_z e.(u_a - u_b).
        let mut links = self.upward.iter().peekable();
        for (own, surface) in self.surface.iter().enumerate() {
            let mut pressed = 0.0;
            while let Some(link) = links.next_if(|link| link.ends[0] <= own) {
                if link.ends[0] == own {
                    pressed += link.stiffness * link.direction[2] * along(link);
                }
            }
            if let Some((number, tie)) = surface.free {
                let place = surface.column[1] * self.columns[0] + surface.column[0];
                let borne = if surface.yields { face.limit * surface.contact_share } else { 0.0 };
                let above = fields[2 * plane + place] - face.raise * surface.relief;
                imbalances[number] = (pressed - borne + tie * above) / surface.pivot;
            }
            if let Some(number) = surface.contact {
                normal[number] = if surface.lifted { 0.0 } else { pressed };
            }
        }
    }
}
