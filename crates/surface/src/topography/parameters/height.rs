//! Height parameters of ISO 25178-2, clause 4.1.

use slipgrid_base::monitor::{Cancelled, Monitor};

use crate::topography::HeightMap;

/// Height parameters, relative to the mean height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeightParameters {
    /// Sa, arithmetical mean height, in metres.
    pub sa_m: f64,
    /// Sq, root mean square height, in metres.
    pub sq_m: f64,
    /// Ssk, skewness: negative where pits prevail. Zero for a flat map.
    pub ssk: f64,
    /// Sku, kurtosis: 3 for Gaussian heights. Zero for a flat map.
    pub sku: f64,
    /// Sp, height of the highest peak above the mean, in metres.
    pub sp_m: f64,
    /// Sv, depth of the deepest pit below the mean, in metres.
    pub sv_m: f64,
    /// Sz, maximum height Sp + Sv, in metres.
    pub sz_m: f64,
}

impl HeightMap {
    /// Height parameters over the points present. The form is not removed here; remove it first.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub fn height_parameters(&self, monitor: &dyn Monitor) -> Result<HeightParameters, Cancelled> {
        let mean_m = self.mean_m();
        monitor.heed()?;
        let (mut highest, mut lowest) = (0.0_f64, 0.0_f64);
        for deviation in self.heights_m().iter().filter(|height| !height.is_nan()).map(|height| height - mean_m) {
            highest = highest.max(deviation);
            lowest = lowest.min(deviation);
        }
        monitor.heed()?;
        let sq_m = self.sq_m();
        // Powers of heights divided by Sq stay within the range of f64.
        let moment = |power: i32| {
            monitor.heed()?;
            Ok(if sq_m > 0.0 { self.mean_deviation(|deviation| (deviation / sq_m).powi(power)) } else { 0.0 })
        };
        Ok(HeightParameters {
            // Ssk = mean h^3 / Sq^3
            ssk: moment(3)?,
            // Sku = mean h^4 / Sq^4
            sku: moment(4)?,
            // Sa = mean |h|
            sa_m: self.sa_m(),
            // Sq^2 = mean h^2
            sq_m,
            // Sp = max h, Sv = -min h, Sz = Sp + Sv
            sp_m: highest,
            sv_m: -lowest,
            sz_m: highest - lowest,
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use slipgrid_base::monitor::Unwatched;

    /// shape(x) over one period of 720 rows, in micrometres.
    fn profile(shape: impl Fn(f64) -> f64) -> HeightMap {
        let heights = (0..720 * 3).map(|n| 1e-6 * shape((n / 3) as f64 / 720.0)).collect();
        HeightMap::new(720, 3, 1e-6, 1e-6, heights).unwrap()
    }

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() <= tolerance * expected.abs().max(1e-12), "{found} and {expected}");
    }

    #[test]
    fn a_sinusoid() {
        let p = profile(|t| (TAU * t).sin()).height_parameters(&Unwatched).unwrap();
        // The moments of the sine are sums over whole periods and exact up to rounding; Sa is exact in the limit of
        // many points.
        assert_near(p.sa_m, 2e-6 / PI, 1e-5);
        assert_near(p.sq_m, 1e-6 / 2f64.sqrt(), 1e-13);
        assert!(p.ssk.abs() < 1e-12);
        assert_near(p.sku, 1.5, 1e-12);
        assert_near(p.sp_m, 1e-6, 1e-13);
        assert_near(p.sv_m, 1e-6, 1e-13);
        assert_near(p.sz_m, 2e-6, 1e-13);
    }

    #[test]
    fn a_triangular_wave_and_a_step() {
        // Uniform heights on -1..1, at the middles of 720 equal steps: mean square 1/3 - 1/(3 720^2).
        let p = profile(|t| 2.0 * (t + 0.5 / 720.0) - 1.0).height_parameters(&Unwatched).unwrap();
        assert_near(p.sa_m, 0.5e-6, 1e-12);
        assert_near(p.sq_m, 1e-6 * ((1.0 - 1.0 / 720f64.powi(2)) / 3.0).sqrt(), 1e-12);
        assert!(p.ssk.abs() < 1e-12);
        assert_near(p.sku, 1.8, 1e-5);
        // A quarter of the surface is a pit of depth 1: mean -1/4, Sq^2 = 3/16, Ssk = -2/sqrt 3, Sku = 7/3.
        let p = profile(|t| if t < 0.25 { -1.0 } else { 0.0 }).height_parameters(&Unwatched).unwrap();
        assert_near(p.sa_m, 0.375e-6, 1e-12);
        assert_near(p.sq_m, 1e-6 * (3.0_f64 / 16.0).sqrt(), 1e-12);
        assert_near(p.ssk, -2.0 / 3f64.sqrt(), 1e-12);
        assert_near(p.sku, 7.0 / 3.0, 1e-12);
        assert_near(p.sp_m, 0.25e-6, 1e-12);
        assert_near(p.sv_m, 0.75e-6, 1e-12);
    }

    #[test]
    fn a_flat_map_has_none() {
        let p = profile(|_| 3.0).height_parameters(&Unwatched).unwrap();
        assert_eq!((p.sq_m, p.ssk, p.sku, p.sz_m), (0.0, 0.0, 0.0, 0.0));
    }
}
