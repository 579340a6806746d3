//! Material ratio (bearing, Abbott-Firestone) curve and the functional parameters of ISO 25178-2 computed from it.

use slipgrid_base::monitor::{Cancelled, Monitor};

use crate::topography::HeightMap;
use crate::topography::order::descending;

/// Number of points along the material ratio curve at which its flattest part is sought.
const CLASSES: usize = 10_000;
/// Width of the range of material ratios to which the equivalent line is fitted.
const EQUIVALENT_LINE: f64 = 0.4;

/// Material ratio curve: the height reached or exceeded by a given fraction of the surface.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialRatioCurve {
    /// All heights present, highest first, relative to their mean, in metres.
    descending_m: Vec<f64>,
}

/// Parameters of a surface's core, from the material ratio curve (ISO 25178-2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoreParameters {
    /// Sk, core height, in metres.
    pub sk_m: f64,
    /// Spk, reduced peak height, in metres.
    pub spk_m: f64,
    /// Svk, reduced pit depth, in metres.
    pub svk_m: f64,
    /// Smr1, fraction of the surface above the core.
    pub smr1: f64,
    /// Smr2, fraction of the surface above the core's lower end.
    pub smr2: f64,
    /// Upper end of the core, above the mean, in metres.
    pub upper_m: f64,
    /// Lower end of the core, above the mean, in metres.
    pub lower_m: f64,
}

impl MaterialRatioCurve {
    /// Curve of the points present.
    ///
    /// # Errors
    /// [`Cancelled`] once `monitor` cancels.
    pub fn new(map: &HeightMap, monitor: &dyn Monitor) -> Result<Self, Cancelled> {
        let mean_m = map.mean_m();
        let present = map.heights_m().iter().filter(|height| !height.is_nan());
        let heights_m: Vec<f64> = present.map(|height| height - mean_m).collect();
        Ok(Self { descending_m: descending(&heights_m, monitor)? })
    }

    /// Height above the mean that the fraction `ratio` of the surface reaches or exceeds, in metres.
    pub fn height_m(&self, ratio: f64) -> f64 {
        let last = self.descending_m.len() - 1;
        let place = ratio.clamp(0.0, 1.0) * last as f64;
        let (index, rest) = (place as usize, place.fract());
        let here = self.descending_m[index];
        here + rest * (self.descending_m[(index + 1).min(last)] - here)
    }

    /// Fraction of the surface above `height_m` (relative to the mean, in metres).
    pub fn ratio(&self, height_m: f64) -> f64 {
        self.descending_m.partition_point(|&height| height > height_m) as f64 / self.descending_m.len() as f64
    }

    /// Core parameters from the equivalent line (ISO 25178-2, annex B): the least-squares line through the part of the
    /// curve that spans 40 % of the ratio and has the flattest secant (the first one if several are equally flat).
    pub fn core(&self) -> CoreParameters {
        let step = 1.0 / (CLASSES - 1) as f64;
        let height: Vec<f64> = (0..CLASSES).map(|class| self.height_m(class as f64 * step)).collect();
        // Number of steps that span 40 %: 0.4/step, up to rounding.
        let span = (EQUIVALENT_LINE / step).round() as usize;
        let flattest = (0..CLASSES - span).fold(0, |best, start| {
            let drop = |start: usize| height[start] - height[start + span];
            if drop(start) < drop(best) { start } else { best }
        });
        // Line h = middle + slope (ratio - mean ratio), least squares over equidistant ratios.
        let part = &height[flattest..=flattest + span];
        let count = part.len() as f64;
        let mean_ratio = (flattest as f64 + 0.5 * span as f64) * step;
        let middle = part.iter().sum::<f64>() / count;
        let (mut across, mut square) = (0.0, 0.0);
        for (n, height) in part.iter().enumerate() {
            let ratio = (flattest + n) as f64 * step - mean_ratio;
            across += ratio * (height - middle);
            square += ratio * ratio;
        }
        let slope = across / square;
        let (upper_m, lower_m) = (middle - slope * mean_ratio, middle + slope * (1.0 - mean_ratio));

        let (smr1, smr2) = (self.ratio(upper_m), self.ratio(lower_m));
        // Triangles with the areas above and below the core, on the corresponding ranges of the ratio: Spk = 2 A1/Smr1,
        // Svk = 2 A2/(1 - Smr2); A1 = mean of (h - upper) where positive.
        let beyond = |excess: &dyn Fn(f64) -> f64| {
            self.descending_m.iter().map(|&height| excess(height).max(0.0)).sum::<f64>()
                / self.descending_m.len() as f64
        };
        let reduced = |area: f64, base: f64| if base > 0.0 { 2.0 * area / base } else { 0.0 };
        CoreParameters {
            // Sk: drop of the line over the whole ratio
            sk_m: upper_m - lower_m,
            spk_m: reduced(beyond(&|height| height - upper_m), smr1),
            svk_m: reduced(beyond(&|height| lower_m - height), 1.0 - smr2),
            smr1,
            smr2,
            upper_m,
            lower_m,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use slipgrid_base::monitor::Unwatched;

    fn curve(points: usize, shape: impl Fn(f64) -> f64) -> MaterialRatioCurve {
        let heights = (0..points * 2).map(|n| 1e-6 * shape(((n / 2) as f64 + 0.5) / points as f64)).collect();
        MaterialRatioCurve::new(&HeightMap::new(points, 2, 1e-6, 1e-6, heights).unwrap(), &Unwatched).unwrap()
    }

    fn assert_near(found: f64, expected: f64, tolerance: f64) {
        assert!((found - expected).abs() < tolerance, "{found} and {expected}");
    }

    #[test]
    fn a_triangular_wave_is_all_core() {
        let curve = curve(20_000, |t| (2.0 * t - 1.0).abs());
        let core = curve.core();
        // Heights from 0.5e-4 to 1 - 0.5e-4 um: the line drops from the highest to the lowest one.
        assert_near(core.sk_m, 0.9999e-6, 1e-12);
        assert_near(core.spk_m, 0.0, 1e-10);
        assert_near(core.svk_m, 0.0, 1e-10);
        assert_near(core.smr1, 0.0, 1e-3);
        assert_near(core.smr2, 1.0, 1e-3);
        assert_near(curve.height_m(0.25), 0.25e-6, 1e-10);
        assert_near(curve.ratio(0.25e-6), 0.25, 1e-4);
    }

    #[test]
    fn a_sinusoid_by_its_integrals() {
        // The curve is cos(pi p); its flattest 40 % begin at 0. Least squares over 0..w:
        // slope = 12/w^3 int (p - w/2) cos(pi p) dp, mean = sin(pi w)/(pi w).
        let core = curve(40_000, |t| (TAU * t).sin()).core();
        let w = 0.4;
        let first_moment = w * (PI * w).sin() / PI + ((PI * w).cos() - 1.0) / PI.powi(2);
        let mean = (PI * w).sin() / (PI * w);
        let slope = 12.0 / w.powi(3) * (first_moment - 0.5 * w * mean * w);
        let upper = mean - slope * w / 2.0;
        assert_near(core.sk_m, -slope * 1e-6, 1e-9);
        assert_near(core.upper_m, upper * 1e-6, 1e-9);
        // upper exceeds 1, so that nothing lies above the core; h < lower for p > acos(lower)/pi.
        assert!(upper > 1.0 && core.smr1 == 0.0 && core.spk_m == 0.0);
        let lower = upper + slope;
        let ratio = lower.acos() / PI;
        assert_near(core.smr2, ratio, 1e-3);
        // A2 = int from ratio to 1 of (lower - cos(pi p)) dp
        let area = lower * (1.0 - ratio) + (PI * ratio).sin() / PI;
        assert_near(core.svk_m, 2.0 * area / (1.0 - ratio) * 1e-6, 2e-9);
    }

    #[test]
    fn a_plateau_with_pits_and_peaks() {
        // 5 % peaks rising 2 to 0 um, a core sloping 1 um over the rest of the ratio, 10 % pits 0 to -4 um deep.
        let core = curve(100_000, |t| {
            if t < 0.05 {
                0.5 + 2.0 * (1.0 - t / 0.05)
            } else if t < 0.9 {
                0.5 - (t - 0.05) / 0.85
            } else {
                -0.5 - 4.0 * (t - 0.9) / 0.1
            }
        })
        .core();
        // The line continues the core's slope 1/0.85 to both ends.
        assert_near(core.sk_m, 1e-6 / 0.85, 1e-9);
        // Above upper end 0.5 + 0.05/0.85 = 0.5588 um: t < 0.05 (1 - 0.0588/2) = 0.048529; triangle 2 - 0.0588.
        assert_near(core.smr1, 0.048_529, 1e-4);
        assert_near(core.spk_m, 1.941_176e-6, 1e-8);
        // Below -0.5 - 0.1/0.85 = -0.6176: t > 0.9 + 0.1 0.1176/4 = 0.902941; triangle 4 - 0.1176.
        assert_near(core.smr2, 0.902_941, 1e-4);
        assert_near(core.svk_m, 3.882_353e-6, 1e-8);
    }

    #[test]
    fn equal_heights_have_no_core() {
        let core = curve(10, |_| 1.0).core();
        assert_eq!((core.sk_m, core.spk_m, core.svk_m), (0.0, 0.0, 0.0));
    }
}
