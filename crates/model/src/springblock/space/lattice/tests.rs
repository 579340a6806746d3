use super::*;
use crate::pattern::Planform;
use crate::springblock::tests::samples::{groove, pattern};

fn squares(width_um: f64, spacing_um: f64, depth_um: f64) -> SpaceLattice {
    SpaceLattice::cell(&pattern(Planform::Square, width_um, spacing_um, depth_um), 10e-6, 20)
}

#[test]
fn whole_blocks_are_the_plain_lattice() {
    let lattice = squares(130.0, 370.0, 20.0);
    assert_eq!((lattice.columns(), lattice.spacing(), lattice.is_plain()), ([50; 2], [1.0; 2], true));
    for (i, j) in (0..50).flat_map(|j| (0..50).map(move |i| (i, j))) {
        // floor(37 / 2) = 18 columns of land before the cavity of 13.
        let covered = (18..31).contains(&i) && (18..31).contains(&j);
        assert_eq!(lattice.contact_share(i, j), if covered { 0.0 } else { 1.0 });
        assert_eq!(lattice.presence(i, j, 1), if covered { 0.0 } else { 1.0 });
        assert_eq!(lattice.presence(i, j, 2), 1.0);
    }
}

#[test]
fn springs_are_counted() {
    let lattice = squares(20.0, 30.0, 20.0);
    let mut kinds = [0; 2];
    lattice.for_each_bond(|bond| {
        assert_eq!((bond.share, bond.spring.stiffness), (1.0, 1.0));
        kinds[usize::from(bond.spring.step.iter().filter(|s| **s != 0).count() == 2)] += 1;
    });
    // 25 columns of 20 rows. In each of the two lowest rows 2 x 2 blocks are removed, with 2 x 3 springs along x, as
    // many along y, and 4 upward; diagonals: 4 for each of 4 blocks minus those between two of them, 16 - 2 in the row,
    // and those to the rows above.
    assert_eq!(kinds[0], 3 * 500 - 2 * (6 + 6 + 4));
    let mut weakened = 0;
    lattice.for_each_weakened_bond(|bond| {
        assert_eq!(bond.share, 0.0);
        weakened += 1;
    });
    assert_eq!(kinds[0] + kinds[1] + weakened, 9 * 500);
}

#[test]
fn masses_follow_the_eighth_cells() {
    let lattice = squares(130.0, 370.0, 20.0);
    assert_eq!(lattice.mass(5, 5, 10), 1.0); // inside
    assert_eq!(lattice.mass(5, 5, 0), 0.5); // on the counterface
    assert_eq!(lattice.mass(5, 5, 19), 1.0); // below the bulk
    assert_eq!(lattice.mass(17, 25, 0), 0.25); // edge of the land
    assert_eq!(lattice.mass(17, 17, 0), 0.375); // corner of the land: three quarters of the cells exist
    assert_eq!(lattice.mass(17, 25, 1), 0.5); // wall
    assert_eq!(lattice.mass(17, 25, 2), 0.75); // edge of the ceiling
    assert_eq!(lattice.mass(25, 25, 1), 0.0); // removed
    assert_eq!(lattice.mass(25, 25, 2), 0.5); // ceiling
    let flat = SpaceLattice::flat([5, 4], 3);
    let total: f64 = (0..60).map(|n| flat.mass(n % 5, n / 5 % 4, n / 20)).sum();
    assert!((total - 20.0 * 2.5).abs() < 1e-12);
    // A post of one column has at least an eighth of the mass.
    assert_eq!(squares(20.0, 10.0, 20.0).mass(2, 2, 0), 0.125);
}

#[test]
fn nearest_whole_blocks_are_the_lattice_itself_or_half_a_block_away() {
    let plain = squares(130.0, 370.0, 20.0);
    assert_eq!(plain.nearest_whole(), plain);
    let whole = squares(133.3, 371.9, 14.0).nearest_whole();
    assert!(whole.is_plain() && whole.columns() == [51; 2] && whole.depth() == 1.0);
    assert_eq!((0..51 * 51).filter(|n| whole.contact_share(n % 51, n / 51) == 0.0).count(), 13 * 13);
    // Cavities narrower than half a block vanish; posts narrower than half a block remain.
    assert_eq!(squares(4.0, 46.0, 20.0).nearest_whole(), SpaceLattice::flat([5; 2], 20));
    let post = squares(46.0, 4.0, 20.0).nearest_whole();
    assert!((0..25).any(|n| post.contact_share(n % 5, n / 5) == 1.0));
    assert!(squares(100.0, 100.0, 199.0).nearest_whole().depth() == 19.0);
    let groove = SpaceLattice::cell(&groove(20.0, 30.0, 20.0), 10e-6, 5);
    let long = groove.repeated_along_y(4);
    assert!((0..20).all(|n| long.contact_share(n % 5, n / 5) == groove.contact_share(n % 5, 0)));
}

#[test]
fn other_dimensions_keep_their_areas() {
    for (width, spacing) in [(133.3, 371.9), (17.0, 18.0), (7.0, 6.0)] {
        let lattice = squares(width, spacing, 14.0);
        let [nx, ny] = lattice.columns();
        let [a, b] = lattice.spacing();
        assert!(a > 0.93 && a < 1.07 && a == b, "{a}");
        let land: f64 = (0..nx * ny).map(|n| lattice.contact_share(n % nx, n / nx)).sum::<f64>() / (nx * ny) as f64;
        let expected = 1.0 - (width / (width + spacing)).powi(2);
        assert!((land - expected).abs() < 1e-5, "{width}: {land} {expected}");
    }
    let lattice = squares(133.0, 370.0, 14.0);
    // The lower left edge is that of a column; the opposite edge cuts a column.
    assert_eq!((lattice.contact_share(17, 20), lattice.contact_share(18, 20)), (1.0, 0.0));
    assert!((lattice.presence(20, 20, 1) - 0.6).abs() < 1e-9 && lattice.presence(20, 20, 0) == 0.0);
}
