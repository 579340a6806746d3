//! Linear spring forces as a stencil over structure-of-arrays, one row at a time.
//!
//! Inside, coefficients are constants; rows that touch the counterface or a cavity, and the two free
//! sides, carry a coefficient per spring. Units: k = 1, l = 1, m = 1. Per block and force evaluation
//! inside the lattice: 22 additions, 4 multiplications, 18 values read.

use multiversion::multiversion;

use crate::lattice::Lattice;

/// Stiffness of the springs of one block over k: east, west, north, south, then the diagonals.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Springs8 {
    east: f64,
    west: f64,
    north: f64,
    south: f64,
    north_east: f64,
    north_west: f64,
    south_east: f64,
    south_west: f64,
}

const INSIDE: Springs8 = Springs8 {
    east: 1.0,
    west: 1.0,
    north: 1.0,
    south: 1.0,
    north_east: 0.5,
    north_west: 0.5,
    south_east: 0.5,
    south_west: 0.5,
};

/// One block's springs and inverse mass.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Site {
    springs: Springs8,
    inverse_mass: f64,
}

/// Coefficients of a row, one array per spring, one entry per column.
#[derive(Clone, Debug, Default)]
struct RowCoefficients {
    east: Vec<f64>,
    west: Vec<f64>,
    north: Vec<f64>,
    south: Vec<f64>,
    north_east: Vec<f64>,
    north_west: Vec<f64>,
    south_east: Vec<f64>,
    south_west: Vec<f64>,
    inverse_mass: Vec<f64>,
}

impl RowCoefficients {
    fn new(sites: &[Site]) -> Self {
        let column = |f: fn(&Site) -> f64| sites.iter().map(f).collect::<Vec<f64>>();
        Self {
            east: column(|s| s.springs.east),
            west: column(|s| s.springs.west),
            north: column(|s| s.springs.north),
            south: column(|s| s.springs.south),
            north_east: column(|s| s.springs.north_east),
            north_west: column(|s| s.springs.north_west),
            south_east: column(|s| s.springs.south_east),
            south_west: column(|s| s.springs.south_west),
            inverse_mass: column(|s| s.inverse_mass),
        }
    }
}

/// How the forces on a row are found.
#[derive(Clone, Debug)]
enum Row {
    /// Every block is an inside one, but for the two at free sides.
    Plain { sides: Option<[Site; 2]> },
    /// Springs or masses differ from block to block.
    General(RowCoefficients),
}

/// Displacements of all blocks, and velocities times the step. Row r, column i is at
/// r * stride + 1 + i; a column of padding on each side holds the periodic images; row ny is the bulk.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    pub nx: usize,
    pub ny: usize,
    pub stride: usize,
    pub ux: Vec<f64>,
    pub uy: Vec<f64>,
    pub wx: Vec<f64>,
    pub wy: Vec<f64>,
}

impl Field {
    /// A lattice at rest.
    #[must_use]
    pub fn at_rest(nx: usize, ny: usize) -> Self {
        // Rows begin at multiples of a cache line.
        let stride = (nx + 2).next_multiple_of(8);
        let size = stride * (ny + 1);
        Self { nx, ny, stride, ux: vec![0.0; size], uy: vec![0.0; size], wx: vec![0.0; size], wy: vec![0.0; size] }
    }

    /// Index of block (i, j).
    #[must_use]
    pub const fn at(&self, i: usize, j: usize) -> usize {
        j * self.stride + 1 + i
    }
}

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
            general_forces(coefficients, field, 0, force_x, force_y);
        }
    }

    /// Kicks and drifts all rows; row 0 has been kicked already. `kept`: share of the velocity that
    /// damping leaves; `kick`: displacement per step that a unit force adds to a unit mass.
    pub fn kick_and_drift(&self, field: &mut Field, kept: f64, kick: f64, scratch: &mut [Vec<f64>; 2]) {
        let [force_x, force_y] = scratch;
        for (j, row) in self.rows.iter().enumerate().skip(1) {
            match row {
                Row::Plain { sides } => {
                    let ends = sides.map(|[left, right]| {
                        let nx = field.nx;
                        [site_force(&left.springs, field, 0, j), site_force(&right.springs, field, nx - 1, j)]
                    });
                    let old = field.at(0, j);
                    let last = field.at(field.nx - 1, j);
                    let ends_before = [old, last].map(|at| [field.wx[at], field.wy[at]]);
                    plain_kick(field, j, kept, kick);
                    if let (Some(ends), Some(sides)) = (ends, sides) {
                        for (number, at) in [old, last].into_iter().enumerate() {
                            let scale = kick * sides[number].inverse_mass;
                            field.wx[at] = kept * ends_before[number][0] + scale * ends[number][0];
                            field.wy[at] = kept * ends_before[number][1] + scale * ends[number][1];
                        }
                    }
                }
                Row::General(coefficients) => {
                    general_forces(coefficients, field, j, force_x, force_y);
                    general_kick(coefficients, field, j, kept, kick, force_x, force_y);
                }
            }
            // Row j no longer needs the old positions of row j - 1.
            self.drift(field, j - 1);
        }
        self.drift(field, field.ny - 1);
    }

    fn drift(&self, field: &mut Field, j: usize) {
        let row = field.at(0, j)..field.at(field.nx, j);
        add_to(&mut field.ux[row.clone()], &field.wx[row.clone()]);
        add_to(&mut field.uy[row.clone()], &field.wy[row.clone()]);
        if self.periodic {
            for u in [&mut field.ux, &mut field.uy] {
                u[row.start - 1] = u[row.end - 1];
                u[row.end] = u[row.start];
            }
        }
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
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
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

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn add_to(u: &mut [f64], w: &[f64]) {
    for (u, w) in u.iter_mut().zip(w) {
        *u += w;
    }
}

/// The rows below, at and above row j, padding included.
struct Neighbours<'a> {
    below: [&'a [f64]; 2],
    here: [&'a [f64]; 2],
    above: [&'a [f64]; 2],
}

fn neighbours<'a>(ux: &'a [f64], uy: &'a [f64], stride: usize, j: usize) -> Neighbours<'a> {
    let row = |j: usize| [&ux[j * stride..(j + 1) * stride], &uy[j * stride..(j + 1) * stride]];
    // Row 0 has no springs downwards: whatever stands for its lower row is multiplied by zero.
    Neighbours { below: row(j.saturating_sub(1)), here: row(j), above: row(j + 1) }
}

/// Kicks a whole row of inside blocks.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn plain_kick(field: &mut Field, j: usize, kept: f64, kick: f64) {
    let (nx, stride) = (field.nx, field.stride);
    let Neighbours { below, here, above } = neighbours(&field.ux, &field.uy, stride, j);
    let start = j * stride + 1;
    let (wx, wy) = (&mut field.wx[start..start + nx], &mut field.wy[start..start + nx]);
    let n = wx.len().min(wy.len());
    let [bx, by] = below;
    let [hx, hy] = here;
    let [ax, ay] = above;
    let (bxw, bxe) = (&bx[..n], &bx[2..n + 2]);
    let (byw, byc, bye) = (&by[..n], &by[1..=n], &by[2..n + 2]);
    let (hxw, hxc, hxe) = (&hx[..n], &hx[1..=n], &hx[2..n + 2]);
    let hyc = &hy[1..=n];
    let (axw, axe) = (&ax[..n], &ax[2..n + 2]);
    let (ayw, ayc, aye) = (&ay[..n], &ay[1..=n], &ay[2..n + 2]);
    for i in 0..n {
        let (x, y) = (hxc[i], hyc[i]);
        // Differences along the two diagonals: u_NE + u_SW and u_NW + u_SE, for x and y.
        let (rise_x, fall_x) = (axe[i] + bxw[i], axw[i] + bxe[i]);
        let (rise_y, fall_y) = (aye[i] + byw[i], ayw[i] + bye[i]);
        // F_x = u_E + u_W - 3 u + 1/4 (sum of diagonals + cross differences of u_y)
        let force_x = (hxe[i] + hxw[i]) - 3.0 * x + 0.25 * ((rise_x + fall_x) + (rise_y - fall_y));
        // F_y = u_N + u_S - 3 u + 1/4 (sum of diagonals + cross differences of u_x)
        let force_y = (ayc[i] + byc[i]) - 3.0 * y + 0.25 * ((rise_y + fall_y) + (rise_x - fall_x));
        wx[i] = kept * wx[i] + kick * force_x;
        wy[i] = kept * wy[i] + kick * force_y;
    }
}

/// Forces on a row with a coefficient per spring.
#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn general_forces(k: &RowCoefficients, field: &Field, j: usize, force_x: &mut [f64], force_y: &mut [f64]) {
    let n = field.nx;
    let Neighbours { below, here, above } = neighbours(&field.ux, &field.uy, field.stride, j);
    let [bx, by] = below;
    let [hx, hy] = here;
    let [ax, ay] = above;
    let (bx, by) = (&bx[..n + 2], &by[..n + 2]);
    let (hx, hy) = (&hx[..n + 2], &hy[..n + 2]);
    let (ax, ay) = (&ax[..n + 2], &ay[..n + 2]);
    let (east, west, north, south) = (&k.east[..n], &k.west[..n], &k.north[..n], &k.south[..n]);
    let (ne, nw, se, sw) = (&k.north_east[..n], &k.north_west[..n], &k.south_east[..n], &k.south_west[..n]);
    let (force_x, force_y) = (&mut force_x[..n], &mut force_y[..n]);
    for i in 0..n {
        let (x, y) = (hx[i + 1], hy[i + 1]);
        // Half the stiffness times the elongation along each diagonal: e e^T has entries 1/2.
        let ne = 0.5 * ne[i] * ((ax[i + 2] - x) + (ay[i + 2] - y));
        let sw = 0.5 * sw[i] * ((bx[i] - x) + (by[i] - y));
        let nw = 0.5 * nw[i] * ((ax[i] - x) - (ay[i] - y));
        let se = 0.5 * se[i] * ((bx[i + 2] - x) - (by[i + 2] - y));
        force_x[i] = east[i] * (hx[i + 2] - x) + west[i] * (hx[i] - x) + ((ne + sw) + (nw + se));
        force_y[i] = north[i] * (ay[i + 1] - y) + south[i] * (by[i + 1] - y) + ((ne + sw) - (nw + se));
    }
}

#[multiversion(targets("x86_64+avx512f", "x86_64+avx2"))]
fn general_kick(
    coefficients: &RowCoefficients,
    field: &mut Field,
    j: usize,
    kept: f64,
    kick: f64,
    force_x: &[f64],
    force_y: &[f64],
) {
    let row = field.at(0, j)..field.at(field.nx, j);
    let inverse_mass = &coefficients.inverse_mass;
    for ((w, force), inverse) in field.wx[row.clone()].iter_mut().zip(force_x).zip(inverse_mass) {
        *w = kept * *w + kick * inverse * force;
    }
    for ((w, force), inverse) in field.wy[row].iter_mut().zip(force_y).zip(inverse_mass) {
        *w = kept * *w + kick * inverse * force;
    }
}

/// Force on one block.
fn site_force(k: &Springs8, field: &Field, i: usize, j: usize) -> [f64; 2] {
    let Neighbours { below, here, above } = neighbours(&field.ux, &field.uy, field.stride, j);
    let (x, y) = (here[0][i + 1], here[1][i + 1]);
    let ne = 0.5 * k.north_east * ((above[0][i + 2] - x) + (above[1][i + 2] - y));
    let sw = 0.5 * k.south_west * ((below[0][i] - x) + (below[1][i] - y));
    let nw = 0.5 * k.north_west * ((above[0][i] - x) - (above[1][i] - y));
    let se = 0.5 * k.south_east * ((below[0][i + 2] - x) - (below[1][i + 2] - y));
    let force_x = k.east * (here[0][i + 2] - x) + k.west * (here[0][i] - x) + ((ne + sw) + (nw + se));
    let force_y = k.north * (above[1][i + 1] - y) + k.south * (below[1][i + 1] - y) + ((ne + sw) - (nw + se));
    [force_x, force_y]
}
