//! One sweep of the leapfrog over the lattice, row by row: forces and kick of row j, then drift of row
//! j - 1, which no later row reads, while both are in a near cache.
//!
//! The inside kernel is bound by additions: 18 of them, 8 multiplications and 18 values read a block,
//! on two 256-bit adders 2.25 cycles a block. Tiles of columns, which would read every row from the
//! next cache once instead of three times, gain nothing, and 512-bit vectors lose where they are
//! executed in halves. No fused multiply-add: results are the same on every machine.

use std::ops::Range;

use multiversion::multiversion;

use super::rows::{Field, Row, RowCoefficients, Site, Springs8};

/// What a kick does to velocities (times the step).
#[derive(Clone, Copy, Debug)]
pub struct Kick {
    /// Share of the velocity that damping leaves.
    pub kept: f64,
    /// Displacement per step that a unit force adds to a unit mass.
    pub kick: f64,
}

/// Kicks rows 1 and up and drifts all rows. Periodic images are left as they were.
#[multiversion(targets("x86_64+avx2"))]
pub fn sweep(rows: &[Row], field: &mut Field, kick: Kick, force_x: &mut [f64], force_y: &mut [f64]) {
    for (j, row) in rows.iter().enumerate().skip(1) {
        kick_row(row, field, j, kick, force_x, force_y);
        drift(field, j - 1);
    }
    drift(field, field.ny - 1);
}

/// Spring forces on row 0, by column.
#[multiversion(targets("x86_64+avx2"))]
pub fn contact_row_forces(k: &RowCoefficients, field: &Field, force_x: &mut [f64], force_y: &mut [f64]) {
    general_forces(k, field, 0, force_x, force_y);
}

#[inline(always)]
fn kick_row(row: &Row, field: &mut Field, j: usize, kick: Kick, force_x: &mut [f64], force_y: &mut [f64]) {
    match row {
        Row::Plain { sides: None } => plain_kick(field, j, 0..field.nx, kick),
        Row::Plain { sides: Some([left, right]) } => {
            let last = field.nx - 1;
            side_kick(left, field, 0, j, kick);
            side_kick(right, field, last, j, kick);
            plain_kick(field, j, 1..last, kick);
        }
        Row::General(coefficients) => {
            general_forces(coefficients, field, j, force_x, force_y);
            general_kick(coefficients, field, j, kick, force_x, force_y);
        }
    }
}

#[inline(always)]
fn drift(field: &mut Field, j: usize) {
    let row = field.at(0, j)..field.at(field.nx, j);
    for (u, w) in [(&mut field.ux, &field.wx), (&mut field.uy, &field.wy)] {
        for (u, w) in u[row.clone()].iter_mut().zip(&w[row.clone()]) {
            *u += w;
        }
    }
}

/// The rows below, at and above row j, padding included.
struct Neighbours<'a> {
    below: [&'a [f64]; 2],
    here: [&'a [f64]; 2],
    above: [&'a [f64]; 2],
}

#[inline(always)]
fn neighbours<'a>(ux: &'a [f64], uy: &'a [f64], stride: usize, j: usize, columns: &Range<usize>) -> Neighbours<'a> {
    // With one column of padding before column 0, the window of columns a..b and its neighbours is a..b + 2.
    let row = |j: usize| {
        let window = j * stride + columns.start..j * stride + columns.end + 2;
        [&ux[window.clone()], &uy[window]]
    };
    // Row 0 has no springs downwards: whatever stands for its lower row is multiplied by zero.
    Neighbours { below: row(j.saturating_sub(1)), here: row(j), above: row(j + 1) }
}

/// Kicks inside blocks.
#[inline(always)]
fn plain_kick(field: &mut Field, j: usize, columns: Range<usize>, Kick { kept, kick }: Kick) {
    let n = columns.len();
    let row = field.at(columns.start, j)..field.at(columns.end, j);
    let Neighbours { below: [bx, by], here: [hx, hy], above: [ax, ay] } =
        neighbours(&field.ux, &field.uy, field.stride, j, &columns);
    let (wx, wy) = (&mut field.wx[row.clone()][..n], &mut field.wy[row][..n]);
    let (bxw, bxe) = (&bx[..n], &bx[2..n + 2]);
    let (byw, byc, bye) = (&by[..n], &by[1..=n], &by[2..n + 2]);
    let (hxw, hxc, hxe) = (&hx[..n], &hx[1..=n], &hx[2..n + 2]);
    let hyc = &hy[1..=n];
    let (axw, axe) = (&ax[..n], &ax[2..n + 2]);
    let (ayw, ayc, aye) = (&ay[..n], &ay[1..=n], &ay[2..n + 2]);
    for i in 0..n {
        let (x, y) = (hxc[i], hyc[i]);
        // Along the diagonal to the upper right x + y counts, along the other x - y:
        // p = (x + y)_NE + (x + y)_SW, q = (x - y)_NW + (x - y)_SE
        let p = (axe[i] + bxw[i]) + (aye[i] + byw[i]);
        let q = (axw[i] + bxe[i]) - (ayw[i] + bye[i]);
        // F_x = x_E + x_W - 3 x + (p + q) / 4
        let force_x = (hxe[i] + hxw[i]) - 3.0 * x + 0.25 * (p + q);
        // F_y = y_N + y_S - 3 y + (p - q) / 4
        let force_y = (ayc[i] + byc[i]) - 3.0 * y + 0.25 * (p - q);
        wx[i] = kept * wx[i] + kick * force_x;
        wy[i] = kept * wy[i] + kick * force_y;
    }
}

/// Forces on a row with a coefficient per spring, by column.
#[inline(always)]
fn general_forces(k: &RowCoefficients, field: &Field, j: usize, force_x: &mut [f64], force_y: &mut [f64]) {
    let n = field.nx;
    let Neighbours { below: [bx, by], here: [hx, hy], above: [ax, ay] } =
        neighbours(&field.ux, &field.uy, field.stride, j, &(0..n));
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

#[inline(always)]
fn general_kick(
    coefficients: &RowCoefficients,
    field: &mut Field,
    j: usize,
    Kick { kept, kick }: Kick,
    force_x: &[f64],
    force_y: &[f64],
) {
    let row = field.at(0, j)..field.at(field.nx, j);
    for (w, force) in [(&mut field.wx, force_x), (&mut field.wy, force_y)] {
        for ((w, force), inverse) in w[row.clone()].iter_mut().zip(force).zip(&coefficients.inverse_mass) {
            *w = kept * *w + kick * inverse * force;
        }
    }
}

/// Kicks a block at a free side.
#[inline(always)]
fn side_kick(site: &Site, field: &mut Field, i: usize, j: usize, Kick { kept, kick }: Kick) {
    let k: &Springs8 = &site.springs;
    let Neighbours { below, here, above } = neighbours(&field.ux, &field.uy, field.stride, j, &(i..i + 1));
    let (x, y) = (here[0][1], here[1][1]);
    let ne = 0.5 * k.north_east * ((above[0][2] - x) + (above[1][2] - y));
    let sw = 0.5 * k.south_west * ((below[0][0] - x) + (below[1][0] - y));
    let nw = 0.5 * k.north_west * ((above[0][0] - x) - (above[1][0] - y));
    let se = 0.5 * k.south_east * ((below[0][2] - x) - (below[1][2] - y));
    let force_x = k.east * (here[0][2] - x) + k.west * (here[0][0] - x) + ((ne + sw) + (nw + se));
    let force_y = k.north * (above[1][1] - y) + k.south * (below[1][1] - y) + ((ne + sw) - (nw + se));
    let (at, scale) = (field.at(i, j), kick * site.inverse_mass);
    field.wx[at] = kept * field.wx[at] + scale * force_x;
    field.wy[at] = kept * field.wy[at] + scale * force_y;
}
