//! Pressure under an elastic body on a foundation of varying compliance.
//!
//! The body is a rectangle in plane stress with nu = 1/3, as long as a strip of the specimen and as high as the
//! specimen is thick. Its sides are free; its back is bonded to a rigid plate, which descends by d. Its face rests on a
//! foundation of compliance C(x), which deforms by C p / E under the pressure p:
//!
//! ```text
//! div sigma = 0,     u = 0 at the back,     u_z + C p / E = d,  sigma_xz = mu p at the face
//! ```
//!
//! Solved with bilinear finite elements, fine at the ends of pieces of constant compliance and coarse elsewhere.

use crate::springblock::steady::{BandFactor, BandMatrix};

const POISSON_RATIO: f64 = 1.0 / 3.0;
/// Maximum size of the elements at the ends of a piece, over the height of the body.
const FINE: f64 = 1.0 / 350.0;
/// Maximum size of any element, over the height of the body.
const COARSE: f64 = 1.0 / 7.0;
/// Minimum number of elements in a piece: the elements at its ends are at most the length of the piece over this
/// number.
const MIN_ELEMENTS: f64 = 4.0;
/// Size of an element over the size of its neighbour nearer to the end of the piece.
const GROWTH: f64 = 1.4;
/// The iteration for friction has converged if displacements change by less than this fraction of the descent of the
/// back.
const SETTLED: f64 = 1e-9;
/// Maximum number of iterations for friction.
const MAX_ROUNDS: usize = 100;

/// Part of the face with a uniform foundation.
#[derive(Clone, Copy, Debug)]
pub struct Foundation {
    /// Length, in metres.
    pub length_m: f64,
    /// Compliance times Young's modulus, in metres; positive.
    pub compliance_m: f64,
}

/// Part of the face with uniform pressure.
#[derive(Clone, Copy, Debug)]
pub struct Patch {
    /// Index of the piece of the foundation to which the patch belongs.
    pub piece: usize,
    /// Length, in metres.
    pub length_m: f64,
    /// Pressure relative to the mean pressure on the whole face.
    pub pressure: f64,
}

/// Pressure on the face of a body.
#[derive(Clone, Debug)]
pub struct FacePressure {
    /// Patches from left to right; their lengths sum to that of the face.
    pub patches: Vec<Patch>,
    /// Mean pressure over Young's modulus, per metre of descent of the back.
    pub stiffness_per_m: f64,
}

/// Pressure without friction on the face of a body `height_m` high over `pieces`; `None` without a length or a height.
pub fn face_pressure(pieces: &[Foundation], height_m: f64) -> Option<FacePressure> {
    Body::new(pieces, height_m)?.pressure(0.0)
}

/// A body on its foundation, with the factorized equations.
pub struct Body {
    factor: BandFactor,
    unknowns: usize,
    /// Nodes of the face: index of the unknown displacement along x (the next unknown is that along z), and stiffness
    /// of the foundation's spring over Young's modulus.
    face: Vec<(usize, f64)>,
    /// Elements of the face: index of the piece, and length and compliance in metres.
    across: Vec<(usize, f64, f64)>,
}

impl Body {
    /// Creates a body `height_m` high over `pieces`; `None` without a length or a height.
    pub fn new(pieces: &[Foundation], height_m: f64) -> Option<Self> {
        Self::in_elements(pieces, height_m, 1.0)
    }

    /// Like [`Self::new`], with elements `size` times as large.
    fn in_elements(pieces: &[Foundation], height_m: f64, size: f64) -> Option<Self> {
        let lengths = pieces.iter().map(|piece| piece.length_m);
        let is_solid = |length_m: f64| length_m.is_finite() && length_m > 0.0;
        if pieces.is_empty() || !is_solid(height_m) || !lengths.clone().all(is_solid) {
            return None;
        }
        let fine_of = |length_m: f64| size * (FINE * height_m).min(length_m / MIN_ELEMENTS);
        let most = size * COARSE * height_m;
        let elements = |(piece, foundation): (usize, &Foundation)| {
            let Foundation { length_m, compliance_m } = *foundation;
            graded(length_m, fine_of(length_m), most).map(move |element_m| (piece, element_m, compliance_m))
        };
        let across: Vec<(usize, f64, f64)> = pieces.iter().enumerate().flat_map(elements).collect();
        let finest = lengths.map(fine_of).fold(f64::INFINITY, f64::min);
        let up = one_sided(height_m, finest, most);
        let mesh = Mesh { across: across.iter().map(|(_, element_m, _)| *element_m).collect(), up };
        let mut matrix = mesh.stiffness();
        // Springs of the nodes of the face: half of an element's foundation at each of its ends, a / 2 C.
        let mut springs = vec![0.0; across.len() + 1];
        for (element, (_, length_m, compliance_m)) in across.iter().enumerate() {
            let half = 0.5 * length_m / compliance_m;
            springs[element] += half;
            springs[element + 1] += half;
        }
        let nodes: Option<Vec<usize>> = (0..springs.len()).map(|node| mesh.unknown(node, 0)).collect();
        let face: Vec<(usize, f64)> = nodes?.into_iter().zip(springs).collect();
        for (node, spring) in &face {
            matrix.add(node + 1, node + 1, *spring);
        }
        Some(Self { factor: matrix.factor()?, unknowns: mesh.unknowns(), face, across })
    }

    /// Pressure when the counterface drags the face along x with the friction coefficient `mu`; `None` if the iteration
    /// finds no equilibrium with friction.
    pub fn pressure(&self, mu: f64) -> Option<FacePressure> {
        // Relative to the back, the counterface rises by 1: a node carries k (1 - u_z) and the friction mu k (1 - u_z).
        let mut risen = vec![0.0; self.face.len()];
        let settled = (0..MAX_ROUNDS).any(|_| {
            let mut displacement = vec![0.0; self.unknowns];
            for ((node, spring), risen) in self.face.iter().zip(&risen) {
                displacement[*node] = mu * spring * (1.0 - risen);
                displacement[node + 1] = *spring;
            }
            self.factor.solve(&mut displacement);
            let next: Vec<f64> = self.face.iter().map(|(node, _)| displacement[node + 1]).collect();
            let change = next.iter().zip(&risen).map(|(next, risen)| (next - risen).abs()).fold(0.0, f64::max);
            risen = next;
            mu == 0.0 || change < SETTLED
        });
        if !settled {
            return None;
        }
        // p / E = (1 - u_z) / C
        let patch = |(element, (piece, length_m, compliance_m)): (usize, &(usize, f64, f64))| {
            [element, element + 1].map(|node| Patch {
                piece: *piece,
                length_m: 0.5 * length_m,
                pressure: (1.0 - risen[node]) / compliance_m,
            })
        };
        let mut patches: Vec<Patch> = self.across.iter().enumerate().flat_map(patch).collect();
        let length_m: f64 = patches.iter().map(|patch| patch.length_m).sum();
        let mean = patches.iter().map(|patch| patch.length_m * patch.pressure).sum::<f64>() / length_m;
        patches.iter_mut().for_each(|patch| patch.pressure /= mean);
        Some(FacePressure { patches, stiffness_per_m: mean })
    }
}

/// Lengths of elements that fill `length_m`: `fine` at both ends, growing to at most `most` in the middle.
fn graded(length_m: f64, fine: f64, most: f64) -> impl Iterator<Item = f64> {
    let half = one_sided(0.5 * length_m, fine, most);
    let back: Vec<f64> = half.iter().rev().copied().collect();
    half.into_iter().chain(back)
}

/// Lengths of elements that fill `length_m`: `fine` at the beginning, growing to at most `most`.
fn one_sided(length_m: f64, fine: f64, most: f64) -> Vec<f64> {
    let mut elements = Vec::new();
    let (mut filled, mut next) = (0.0, fine.min(length_m));
    while filled + 0.5 * next < length_m {
        elements.push(next);
        filled += next;
        next = (next * GROWTH).min(most);
    }
    elements.iter_mut().for_each(|element| *element *= length_m / filled);
    elements
}

/// Mesh of rectangles with the lengths `across` and the heights `up`, in metres, from the face to the back; nodes of
/// the back are fixed.
struct Mesh {
    across: Vec<f64>,
    up: Vec<f64>,
}

impl Mesh {
    fn unknowns(&self) -> usize {
        2 * (self.across.len() + 1) * self.up.len()
    }

    /// Index of the unknown displacement along x of the node in column `i` and row `j`; the next unknown is that along
    /// z. `None` at the back.
    fn unknown(&self, i: usize, j: usize) -> Option<usize> {
        (j < self.up.len()).then(|| 2 * (i * self.up.len() + j))
    }

    fn stiffness(&self) -> BandMatrix {
        let mut matrix = BandMatrix::zero(self.unknowns(), 2 * (self.up.len() + 1) + 1);
        for (i, length) in self.across.iter().enumerate() {
            for (j, height) in self.up.iter().enumerate() {
                let own = element_stiffness(*length, *height);
                let nodes = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.unknown(i, j));
                let place = |at: usize| Some(nodes[at / 2]? + at % 2);
                for (row, values) in own.iter().enumerate() {
                    for (column, value) in values.iter().enumerate().skip(row) {
                        if let Some((r, c)) = place(row).zip(place(column)) {
                            matrix.add(r, c, *value);
                        }
                    }
                }
            }
        }
        matrix
    }
}

/// Stiffness matrix of a rectangle of sides a = `length` and b = `height`, divided by Young's modulus. The order is:
/// nodes counterclockwise from the lower left, each with x and z.
///
/// ```text
/// K_nm = [ D1 X_nm + D3 Z_nm        D2 W_nm + D3 W_mn ]     D1 = 1 / (1 - nu^2), D2 = nu D1, D3 = (1 - nu) D1 / 2
///        [ D2 W_mn + D3 W_nm        D1 Z_nm + D3 X_nm ]
///
/// X_nm = int N_n,x N_m,x = x_n x_m (1 + z_n z_m / 3) b / 4 a      with the nodes at x_n, z_n = -1 or 1
/// Z_nm = int N_n,z N_m,z = z_n z_m (1 + x_n x_m / 3) a / 4 b
/// W_nm = int N_n,x N_m,z = x_n z_m / 4
/// ```
fn element_stiffness(length: f64, height: f64) -> [[f64; 8]; 8] {
    const CORNERS: [[f64; 2]; 4] = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let normal = 1.0 / (1.0 - POISSON_RATIO * POISSON_RATIO);
    let (coupled, shear) = (normal * POISSON_RATIO, 0.5 * normal * (1.0 - POISSON_RATIO));
    let mut stiffness = [[0.0; 8]; 8];
    for (n, [xn, zn]) in CORNERS.into_iter().enumerate() {
        for (m, [xm, zm]) in CORNERS.into_iter().enumerate() {
            let along = 0.25 * xn * xm * (1.0 + zn * zm / 3.0) * height / length;
            let upward = 0.25 * zn * zm * (1.0 + xn * xm / 3.0) * length / height;
            let [mixed, turned] = [0.25 * xn * zm, 0.25 * xm * zn];
            stiffness[2 * n][2 * m] = normal * along + shear * upward;
            stiffness[2 * n][2 * m + 1] = coupled * mixed + shear * turned;
            stiffness[2 * n + 1][2 * m] = coupled * turned + shear * mixed;
            stiffness[2 * n + 1][2 * m + 1] = normal * upward + shear * along;
        }
    }
    stiffness
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foundation(length_m: f64, compliance_m: f64) -> Foundation {
        Foundation { length_m, compliance_m }
    }

    fn balance(found: &FacePressure) -> f64 {
        let sum = |of: &dyn Fn(&Patch) -> f64| found.patches.iter().map(of).sum::<f64>();
        sum(&|patch| patch.length_m * patch.pressure) / sum(&|patch| patch.length_m)
    }

    #[test]
    fn a_rectangle_moves_and_turns_without_force_and_stretches_as_plane_stress_says() {
        let stiffness = element_stiffness(0.3, 0.7);
        let force = |u: [f64; 8]| stiffness.map(|row| row.iter().zip(u).map(|(k, u)| k * u).sum::<f64>());
        for rigid in
            [[1., 0., 1., 0., 1., 0., 1., 0.], [0., 1., 0., 1., 0., 1., 0., 1.], [0., 0., 0., 0.3, -0.7, 0.3, -0.7, 0.]]
        {
            assert!(force(rigid).iter().all(|force| force.abs() < 1e-14), "{:?}", force(rigid));
        }
        // Stretched along x by 1 with free sides: u_z = -nu z, and a force of 1 times the height.
        let u = [0., 0., 0.3, 0., 0.3, -0.7 / 3.0, 0., -0.7 / 3.0];
        let expected = [-0.35, 0., 0.35, 0., 0.35, 0., -0.35, 0.];
        assert!(force(u).iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-14));
    }

    #[test]
    fn a_soft_foundation_bears_as_a_row_of_springs() {
        // Compliances far above the body's height give p ~ 1 / C.
        let pieces = [foundation(1e-3, 10.0), foundation(2e-3, 20.0), foundation(1e-3, 40.0)];
        let found = face_pressure(&pieces, 7e-3).unwrap();
        let mean = (1.0 / 10.0 + 2.0 / 20.0 + 1.0 / 40.0) / 4.0;
        assert!((found.stiffness_per_m / mean - 1.0).abs() < 1e-3 && (balance(&found) - 1.0).abs() < 1e-12);
        for patch in &found.patches {
            assert!((patch.pressure * mean * pieces[patch.piece].compliance_m - 1.0).abs() < 1e-3, "{patch:?}");
        }
    }

    #[test]
    fn a_long_body_on_one_foundation_is_compressed_evenly_without_strain_along_it() {
        // d / p = C + (1 - nu^2) H, except near the ends.
        let found = face_pressure(&[foundation(70e-3, 0.2e-3)], 1e-3).unwrap();
        let middle = found.patches[found.patches.len() / 2].pressure * found.stiffness_per_m;
        assert!((middle * (0.2e-3 + 8.0 / 9.0 * 1e-3) - 1.0).abs() < 1e-6, "{middle}");
        assert!((found.stiffness_per_m / middle - 1.0).abs() < 0.01);
    }

    #[test]
    fn stiff_ends_bear_more_and_what_is_left_of_the_mesh_is_small() {
        let pieces = [foundation(0.5e-3, 0.05e-3), foundation(9e-3, 0.5e-3), foundation(0.5e-3, 0.05e-3)];
        let ends = |size: f64| {
            let found = Body::in_elements(&pieces, 7e-3, size).unwrap().pressure(0.0).unwrap();
            assert!((balance(&found) - 1.0).abs() < 1e-12);
            let (first, last) = (found.patches[0].pressure, found.patches[found.patches.len() - 1].pressure);
            assert!((first / last - 1.0).abs() < 1e-9);
            let of_ends = found.patches.iter().filter(|patch| patch.piece != 1);
            of_ends.map(|patch| patch.length_m * patch.pressure).sum::<f64>() / 1e-3
        };
        let [coarse, own, half, quarter] = [2.0, 1.0, 0.5, 0.25].map(ends);
        // Pressure is singular at the ends: halving the elements leaves about two thirds of the error.
        assert!(own > 1.3 && (own - quarter).abs() < 0.005 * own, "{coarse} {own} {half} {quarter}");
        assert!((own - half).abs() < 0.7 * (coarse - own).abs() && (half - quarter).abs() < 0.7 * (own - half).abs());
    }

    #[test]
    fn a_face_without_length_has_no_pressure() {
        assert!(face_pressure(&[], 1e-3).is_none() && face_pressure(&[foundation(0.0, 1.0)], 1e-3).is_none());
        assert!(face_pressure(&[foundation(1e-3, 1.0)], 0.0).is_none());
    }
}
