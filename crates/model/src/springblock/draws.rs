//! Random local coefficients, identical on every platform.

use crate::material::LocalFriction;
use crate::springblock::Dimension;
use slipgrid_base::statistics::{Normals, normal_probability};

/// Range of the phase of a block in its stick-slip cycle: 0 at the dynamic and 1 at the static coefficient of friction.
///
/// A block starts to slip at 1 and by symmetry stops at -1 or above. The lower end is raised to -0.75, which gives the
/// mean phase of 0.13 observed in runs of the flat sample.
const PHASES: [f64; 2] = [-0.75, 1.0];
/// Combined with the seed by exclusive or, so that the random numbers of phases differ from those of coefficients.
const OTHER_NUMBERS: u64 = 0x5851_F42D_4C95_7F2D;
/// Relative scatter of dynamic friction, and of its ratio, over mu_s/mu_d - 1, in the plane and in space.
///
/// Which blocks stick together depends on the phases at the start and on the thresholds drawn, and hardly changes
/// during a run: the mean of a run ten times as long scatters as much between seeds. Neighbours in the plane move
/// together, so that a longer strip does not average this out. Found from 6 to 12 seeds each of two cells and a strip in
/// the plane and of three cells in space, with relative standard deviations of the coefficients of 0 to 0.05, mu_s/mu_d
/// of 1.1 to 1.5 and travels of 0.1 to 1 um: 0.003 to 0.019 and up to 0.003, beyond the errors within the runs and of
/// the drawn means.
const PHASE_SCATTER: [f64; 2] = [0.01, 0.0025];

/// Local friction coefficients of one column: mu_s = mean_s (1 + s g1), mu_d = mean_d (1 + s g2), with the relative
/// standard deviation s and standard normal g1, g2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Static coefficient mu_s of the column's contact block.
    pub static_mu: f64,
    /// Dynamic coefficient mu_d.
    pub dynamic_mu: f64,
}

impl Coefficients {
    /// Friction coefficient at which a block at rest starts to slide: mu_s, or mu_d if mu_s < mu_d was drawn.
    pub fn starting_mu(&self) -> f64 {
        self.static_mu.max(self.dynamic_mu)
    }
}

/// Draws the coefficients of `count` columns, left to right. Columns in cavities get coefficients too, so that a flat
/// and a patterned surface have the same draws. A pair with a nonpositive coefficient is drawn again.
pub fn draw(friction: &LocalFriction, seed: u64, count: usize) -> Vec<Coefficients> {
    let mut normals = Normals::new(seed);
    let std = friction.relative_std();
    (0..count)
        .map(|_| {
            loop {
                let (g1, g2) = (normals.draw(), normals.draw());
                let drawn = Coefficients {
                    static_mu: friction.static_mean() * (1.0 + std * g1),
                    dynamic_mu: friction.dynamic_mean() * (1.0 + std * g2),
                };
                if drawn.static_mu > 0.0 && drawn.dynamic_mu > 0.0 {
                    return drawn;
                }
            }
        })
        .collect()
}

/// Draws a friction coefficient for every column, with each block at a random phase of its stick-slip cycle:
///
/// ```text
/// mu = mu_d + phase (mu_s - mu_d),     phase uniform in [-0.75, 1], mu >= 0
/// ```
///
/// If all blocks started at mu_d, they would slip together and make the layer oscillate over a tenth of a micrometre.
pub fn random_phase_friction(coefficients: &[Coefficients], seed: u64) -> Vec<f64> {
    let mut normals = Normals::new(seed ^ OTHER_NUMBERS);
    let [from, to] = PHASES;
    coefficients
        .iter()
        .map(|drawn| {
            let phase = from + (to - from) * normal_probability(normals.draw());
            (drawn.dynamic_mu + phase * (drawn.starting_mu() - drawn.dynamic_mu)).max(0.0)
        })
        .collect()
}

/// Like [`random_phase_friction`] for `count` blocks that all have the mean coefficients; returns the friction
/// coefficients divided by the mean dynamic coefficient.
pub fn random_phase_mean_friction(friction: &LocalFriction, seed: u64, count: usize) -> Vec<f64> {
    let (static_mu, dynamic_mu) = (friction.static_mean(), friction.dynamic_mean());
    let frictions = random_phase_friction(&vec![Coefficients { static_mu, dynamic_mu }; count], seed);
    frictions.into_iter().map(|mu| mu / dynamic_mu).collect()
}

/// Relative scatter of dynamic friction and of its ratio between runs that differ in the phases of stick-slip, for
/// blocks with the coefficients `friction`. The standard error from the fluctuations within one run does not contain it.
pub fn phase_scatter(friction: &LocalFriction, dimension: Dimension) -> f64 {
    let drop = (friction.static_mean() / friction.dynamic_mean() - 1.0).max(0.0);
    drop * PHASE_SCATTER[usize::from(dimension == Dimension::Space)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::springblock::tests::samples;

    #[test]
    fn moments_are_those_asked_for() {
        let friction = samples::friction();
        let drawn = draw(&friction, 7, 100_000);
        let n = drawn.len() as f64;
        let mean = |f: fn(&Coefficients) -> f64| drawn.iter().map(f).sum::<f64>() / n;
        let (static_mean, dynamic_mean) = (mean(|c| c.static_mu), mean(|c| c.dynamic_mu));
        // Standard errors: 0.05 * 0.3 / sqrt(1e5) = 5e-5; four of them.
        assert!((static_mean - 0.3).abs() < 2e-4 && (dynamic_mean - 0.27).abs() < 2e-4);
        let covariance =
            drawn.iter().map(|c| (c.static_mu - static_mean) * (c.dynamic_mu - dynamic_mean)).sum::<f64>() / n;
        let variance = drawn.iter().map(|c| (c.static_mu - static_mean).powi(2)).sum::<f64>() / n;
        assert!((variance.sqrt() / 0.3 - 0.05).abs() < 5e-4);
        assert!((covariance / (0.05 * 0.05 * 0.3 * 0.27)).abs() < 0.02);
    }

    #[test]
    fn blocks_are_caught_anywhere_between_where_they_stop_and_where_they_start() {
        let friction = LocalFriction::new(0.3, 0.27, 0.0).unwrap();
        let frictions = random_phase_friction(&draw(&friction, 7, 100_000), 7);
        let phases: Vec<f64> = frictions.iter().map(|mu| (mu - 0.27) / 0.03).collect();
        assert!(phases.iter().all(|phase| (-0.75..=1.0).contains(phase)));
        let mean = phases.iter().sum::<f64>() / 1e5;
        // 1.75 / sqrt 12 / sqrt(1e5) = 0.0016; four of them.
        assert!((mean - 0.125).abs() < 7e-3, "{mean}");
        // Without a drop of friction there is no stick-slip.
        let even = LocalFriction::new(0.27, 0.27, 0.0).unwrap();
        assert!(super::random_phase_friction(&draw(&even, 7, 10), 7).iter().all(|mu| (mu - 0.27).abs() < 1e-15));
        // Friction never becomes negative, even if the drop is large.
        let deep = LocalFriction::new(0.9, 0.2, 0.0).unwrap();
        assert!(super::random_phase_friction(&draw(&deep, 7, 1000), 7).iter().all(|mu| *mu >= 0.0));
    }

    #[test]
    fn a_longer_draw_begins_like_a_shorter_one() {
        let friction = samples::friction();
        assert_eq!(draw(&friction, 1, 50), draw(&friction, 1, 996)[..50]);
        assert_ne!(draw(&friction, 1, 50), draw(&friction, 2, 50));
    }

    #[test]
    fn wide_scatter_never_gives_a_coefficient_that_is_not_positive() {
        let friction = LocalFriction::new(0.3, 0.27, 0.8).unwrap();
        assert!(draw(&friction, 3, 10_000).iter().all(|c| c.static_mu > 0.0 && c.dynamic_mu > 0.0));
    }

    #[test]
    fn deviates_stay_what_they_were_first_recorded_to_be() {
        let drawn = draw(&LocalFriction::new(1.0, 1.0, 0.05).unwrap(), 1, 1)[0];
        // First pair of seed 1: ChaCha8 stream through Box and Muller, recorded on x86-64 Linux.
        assert_eq!((drawn.static_mu, drawn.dynamic_mu), (1.0590347075109492, 1.0326401947605386));
    }
}
