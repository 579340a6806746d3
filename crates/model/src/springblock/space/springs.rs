//! Springs of a cubic lattice and of a lattice stretched along x and y.
//!
//! Columns are a lattice spacings apart along x and b along y, rows one spacing. Central springs represent an isotropic
//! solid with nu = 1/4 (Cauchy's relation), C11 = 3 and C12 = C44 = 1 in units of k/l, if
//!
//! ```text
//! C_xxyy = 2 k_xy a^2 b^2 / ((a^2 + b^2) a b) = 1      k_xy = (a^2 + b^2) / (2 a b)
//! C_xxzz = 1                                           k_xz = b (a^2 + 1) / (2 a),  k_yz = a (b^2 + 1) / (2 b)
//! C_xxxx = 3                                           k_x = (b/a) (3 - a^2/b^2 - a^2),  k_y likewise
//! C_zzzz = 3                                           k_z = a b (3 - 1/a^2 - 1/b^2)
//! ```
//!
//! All stiffnesses are 1 for a = b = 1, the cubic lattice.

/// One kind of spring of the lattice in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Offset of the other end, in columns along x, columns along y, and rows.
    pub step: [isize; 3],
    /// Vector to the other end at rest, in lattice spacings.
    pub rest: [f64; 3],
    /// Stiffness in units of k, the stiffness of the springs of the cubic lattice.
    pub stiffness: f64,
}

impl Spring {
    /// Unit vector towards the other end.
    pub fn direction(&self) -> [f64; 3] {
        let [x, y, z] = self.rest;
        let length = (x * x + y * y + z * z).sqrt();
        [x / length, y / length, z / length]
    }
}

/// Number of springs within a row that belong to a block: one of each opposite pair.
pub const LEVEL: usize = 4;
/// Number of springs that connect a block to the row above.
pub const UPWARD: usize = 5;

/// Returns the nine springs that belong to a block, with columns `a` lattice spacings apart along x and `b` along y:
/// first the springs within the row of the block, then the springs upward.
pub fn springs([a, b]: [f64; 2]) -> [Spring; LEVEL + UPWARD] {
    let (aa, bb) = (a * a, b * b);
    let k_x = (b / a) * (3.0 - aa / bb - aa);
    let k_y = (a / b) * (3.0 - bb / aa - bb);
    let k_z = a * b * (3.0 - 1.0 / aa - 1.0 / bb);
    let k_xy = (aa + bb) / (2.0 * a * b);
    let k_xz = b * (aa + 1.0) / (2.0 * a);
    let k_yz = a * (bb + 1.0) / (2.0 * b);
    let spring = |step: [isize; 3], stiffness: f64| {
        let rest = [step[0] as f64 * a, step[1] as f64 * b, step[2] as f64];
        Spring { step, rest, stiffness }
    };
    [
        spring([1, 0, 0], k_x),
        spring([0, 1, 0], k_y),
        spring([1, 1, 0], k_xy),
        spring([1, -1, 0], k_xy),
        spring([0, 0, 1], k_z),
        spring([1, 0, 1], k_xz),
        spring([-1, 0, 1], k_xz),
        spring([0, 1, 1], k_yz),
        spring([0, -1, 1], k_yz),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the energy density in units of k/l for a uniform strain (xx, yy, zz, yz, xz, xy; engineering shears).
    fn twice_energy(spacing: [f64; 2], strain: [f64; 6]) -> f64 {
        let [xx, yy, zz, yz, xz, xy] = strain;
        let energy: f64 = springs(spacing)
            .iter()
            .map(|spring| {
                let [x, y, z] = spring.rest;
                let [ex, ey, ez] = spring.direction();
                let moved = [
                    xx * x + 0.5 * (xy * y + xz * z),
                    yy * y + 0.5 * (xy * x + yz * z),
                    zz * z + 0.5 * (xz * x + yz * y),
                ];
                let along = moved[0] * ex + moved[1] * ey + moved[2] * ez;
                spring.stiffness * along * along
            })
            .sum();
        energy / (spacing[0] * spacing[1])
    }

    #[test]
    fn elastic_constants_are_those_of_an_isotropic_solid_on_plain_and_stretched_lattices() {
        for spacing in [[1.0, 1.0], [1.1, 1.0], [0.93, 1.07], [1.12, 1.12]] {
            for axis in 0..3 {
                // C11 = C22 = C33 = 3
                let mut strain = [0.0; 6];
                strain[axis] = 1.0;
                assert!((twice_energy(spacing, strain) - 3.0).abs() < 1e-12, "{spacing:?} {axis}");
                // C44 = C55 = C66 = 1
                let mut shear = [0.0; 6];
                shear[3 + axis] = 1.0;
                assert!((twice_energy(spacing, shear) - 1.0).abs() < 1e-12, "{spacing:?} {axis}");
                // C11 + C22 + 2 C12 = 8
                strain[(axis + 1) % 3] = 1.0;
                assert!((twice_energy(spacing, strain) - 8.0).abs() < 1e-12, "{spacing:?} {axis}");
            }
            // Extension and shear are not coupled.
            assert!((twice_energy(spacing, [1.0, 0.0, 0.0, 0.0, 1.0, 1.0]) - 5.0).abs() < 1e-12);
        }
        assert!(springs([1.0; 2]).iter().all(|spring| spring.stiffness == 1.0));
    }

    /// Eigenvalue of the dynamical matrix sum k e e^T 2 (1 - cos q.d) at `q`, from its action on `polarization`.
    fn squared_frequency(q: [f64; 3], polarization: [f64; 3]) -> f64 {
        let mut force = [0.0; 3];
        for spring in springs([1.0; 2]) {
            let phase: f64 = (0..3).map(|c| q[c] * spring.step[c] as f64).sum();
            let e = spring.direction();
            let along: f64 = (0..3).map(|c| e[c] * polarization[c]).sum();
            for c in 0..3 {
                force[c] += spring.stiffness * 2.0 * (1.0 - phase.cos()) * along * e[c];
            }
        }
        let value: f64 = (0..3).map(|c| force[c] * polarization[c]).sum();
        for c in 0..3 {
            assert!((force[c] - value * polarization[c]).abs() < 1e-12, "no eigenvector");
        }
        value
    }

    #[test]
    fn waves_along_axes_and_diagonals_have_their_dispersion() {
        let half = |angle: f64| (0.5 * angle).sin().powi(2);
        for q in [1e-3, 0.4, 1.5, std::f64::consts::PI] {
            // [100]: m w^2 = 12 k sin^2(q/2) longitudinal, 4 k sin^2(q/2) transversal
            assert!((squared_frequency([q, 0.0, 0.0], [1.0, 0.0, 0.0]) - 12.0 * half(q)).abs() < 1e-12);
            assert!((squared_frequency([q, 0.0, 0.0], [0.0, 1.0, 0.0]) - 4.0 * half(q)).abs() < 1e-12);
            // [110]: longitudinal 8 sin^2(q/2) + 4 sin^2(q), in-plane transversal 4 sin^2(q/2) + ... by the same sum
            let r = 0.5_f64.sqrt();
            let longitudinal = 8.0 * half(q) + 4.0 * half(2.0 * q);
            assert!((squared_frequency([q, q, 0.0], [r, r, 0.0]) - longitudinal).abs() < 1e-12);
            assert!((squared_frequency([q, q, 0.0], [r, -r, 0.0]) - 8.0 * half(q)).abs() < 1e-12);
            // Polarized along z, four diagonals per block carry the wave: 8 sin^2(q/2).
            assert!((squared_frequency([q, q, 0.0], [0.0, 0.0, 1.0]) - 8.0 * half(q)).abs() < 1e-12);
            // [111]: longitudinal 4 sin^2(q/2) + 8 sin^2(q), transversal 4 sin^2(q/2) + 2 sin^2(q)
            let t = (1.0_f64 / 3.0).sqrt();
            let longitudinal = 4.0 * half(q) + 8.0 * half(2.0 * q);
            assert!((squared_frequency([q; 3], [t; 3]) - longitudinal).abs() < 1e-12);
            let transversal = 4.0 * half(q) + 2.0 * half(2.0 * q);
            assert!((squared_frequency([q; 3], [r, -r, 0.0]) - transversal).abs() < 1e-12);
        }
        // Long waves: c_p^2 = 3 k l^2 / m, c_s^2 = k l^2 / m in every direction.
        let q = 1e-4;
        let t = (1.0_f64 / 3.0).sqrt();
        assert!((squared_frequency([q * t; 3], [t; 3]) / (q * q) - 3.0).abs() < 1e-6);
    }
}
