//! Sampling scatter of friction from the random draw of local coefficients.

use slipgrid_model::springblock::{LoadOutcome, SurfaceOutcome};

/// Relative standard deviations between runs with different draws of the local coefficients; `None` if a run has no
/// friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SamplingScatter {
    /// Scatter of the ratio.
    pub ratio: Option<f64>,
    /// Scatter of the surface's dynamic or static friction; each block contributes its friction times its normal
    /// deviate.
    pub mu: Option<f64>,
    /// Scatter of the flat surface's friction.
    pub flat: Option<f64>,
}

/// Computes the sampling scatter of `load` for local coefficients with the relative standard deviation `scatter`.
///
/// ```text
/// d ln(mu) = sum_i w_i s g_i,  w_i = F_i / sum F:  std = s sqrt(sum w_i^2)
/// d ln(ratio) = sum_i (w_i - 1/n) s g_i:           std = s sqrt(sum w_i^2 - 1/n)
/// ```
///
/// with the friction F of a block, its deviate g, and the number n of blocks of the flat surface, which has the same
/// deviates.
pub fn sampling_scatter(load: &LoadOutcome, scatter: f64) -> SamplingScatter {
    let own = concentration(&load.surface);
    // The blocks of the flat surface carry equal shares.
    let blocks = load.flat.as_ref().map(|flat| flat.interface.len()).filter(|blocks| *blocks > 0);
    let flat = blocks.map(|blocks| 1.0 / blocks as f64);
    let std = |square: f64| scatter * square.max(0.0).sqrt();
    SamplingScatter { ratio: own.zip(flat).map(|(own, flat)| std(own - flat)), mu: own.map(std), flat: flat.map(std) }
}

/// Sum of w_i^2, with the share w_i of each block in friction: the inverse of the effective number of blocks that carry
/// friction. `None` without friction.
fn concentration(surface: &SurfaceOutcome) -> Option<f64> {
    let total: f64 = surface.interface.iter().map(|point| point.friction_pa).sum();
    let square: f64 = surface.interface.iter().map(|point| (point.friction_pa / total).powi(2)).sum();
    (square.is_finite() && square > 0.0).then_some(square)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::material::{AreaLaw, Elastic, LocalFriction};
    use slipgrid_model::pattern::{Pattern, Planform};
    use slipgrid_model::springblock::{Extent, Fidelity, Layer, Load, RunOptions, Scene, Unwatched, simulate};

    fn scene(run: RunOptions) -> Scene {
        Scene {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            area_law: Some(AreaLaw::new(vec![0.7e6, 2.6e6, 26e6], vec![1.0, 0.8, 0.2]).unwrap()),
            pattern: Some(Pattern::new(Planform::Groove, 100e-6, 200e-6, 20e-6).unwrap()),
            relief: None,
            layer: Layer { length_m: 1200e-6, height_m: 50e-6, block_m: 10e-6, thickness_m: None, holder: None },
            loads: vec![Load { pressure_pa: 2e6, friction: LocalFriction::new(0.30, 0.27, 0.05).unwrap() }],
            speed_m_s: 2e-3,
            run,
        }
    }

    /// Relative standard deviation, and the relative standard error of this estimate.
    fn spread(values: &[f64]) -> f64 {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / (values.len() - 1) as f64).sqrt() / mean
    }

    #[test]
    fn the_scatter_between_seeds_is_the_one_expected() {
        const SEEDS: u64 = 200;
        let run = |seed| RunOptions { extent: Extent::Sample, seed, ..RunOptions::default() };
        let found: Vec<LoadOutcome> =
            (0..SEEDS).map(|seed| simulate(&scene(run(seed)), &Unwatched).unwrap().loads.remove(0)).collect();
        let column = |value: fn(&LoadOutcome) -> f64| spread(&found.iter().map(value).collect::<Vec<_>>());
        let expected = sampling_scatter(&found[0], 0.05);
        let cases = [
            (expected.ratio, column(|load| load.ratio().unwrap())),
            (expected.mu, column(|load| load.surface.mu_dynamic.unwrap())),
            (expected.flat, column(|load| load.flat.as_ref().unwrap().mu_dynamic.unwrap())),
        ];
        for (expected, found) in cases {
            // A standard deviation of 200 values is known to 5 %; pressures depend slightly on the draws.
            let share = found / expected.unwrap();
            assert!((0.85..1.15).contains(&share), "{share}: {cases:?}");
        }
    }

    #[test]
    fn static_peaks_scatter_no_more_than_expected() {
        const SEEDS: u64 = 40;
        let run = |seed| RunOptions {
            fidelity: Fidelity::Dynamic,
            extent: Extent::Sample,
            sliding_m: 0.3e-6,
            seed,
            ..RunOptions::default()
        };
        let of = |seed| simulate(&scene(run(seed)), &Unwatched).unwrap().loads.remove(0);
        let found: Vec<LoadOutcome> = (0..SEEDS).map(of).collect();
        let peaks: Vec<f64> = found.iter().map(|load| load.surface.mu_static.unwrap()).collect();
        let share = spread(&peaks) / sampling_scatter(&found[0], 0.05).mu.unwrap();
        // With 40 values it is known to 11 %.
        assert!((0.5..1.3).contains(&share), "{share}");
    }

    #[test]
    fn no_friction_no_scatter() {
        let mut scene = scene(RunOptions::default());
        scene.loads[0].pressure_pa = 0.0;
        let load = simulate(&scene, &Unwatched).unwrap().loads.remove(0);
        assert_eq!(sampling_scatter(&load, 0.05).mu, None);
    }
}
