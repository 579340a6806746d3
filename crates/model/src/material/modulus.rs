//! Area laws for another Young's modulus, or with shifted factors.

use crate::material::error::positive;
use crate::material::{AreaLaw, MaterialError};

/// The first tabulated interval counts as a step if its width is less than this fraction of its first pressure. A step
/// does not show the curvature of the contact area.
const MAX_STEP_WIDTH: f64 = 1e-2;

/// Maximum pressure, relative to the threshold, of the three points whose parabola extrapolates area per load below the
/// threshold; if a point lies higher, the extrapolation is linear.
const MAX_CURVATURE_RATIO: f64 = 3.0;

/// Extrapolation of g(P) = A(P) / P, relative to the threshold P0, to pressures below P0: g = value + slope x +
/// curvature x^2 with x = P - P0, in pascals.
struct ThresholdExtrapolation {
    value: f64,
    slope: f64,
    curvature: f64,
}

impl ThresholdExtrapolation {
    /// Fits the extrapolation to the factors `f` at the pressures `p`, in pascals; there are at least two.
    fn fit(p: &[f64], f: &[f64]) -> Self {
        let straight = Self { value: f[0], slope: (f[1] - f[0]) / (p[1] - p[0]), curvature: 0.0 };
        let nearest = |wanted: f64| {
            (1..p.len()).min_by(|&a, &b| (p[a] - wanted * p[0]).abs().total_cmp(&(p[b] - wanted * p[0]).abs()))
        };
        let (Some(a), Some(b)) = (nearest(1.5), nearest(2.0)) else { return straight };
        if a == b || p[b] > MAX_CURVATURE_RATIO * p[0] {
            return straight;
        }
        // Divided differences.
        let (first, second) = ((f[a] - f[0]) / (p[a] - p[0]), (f[b] - f[a]) / (p[b] - p[a]));
        let curvature = (second - first) / (p[b] - p[0]);
        Self { value: f[0], slope: first - curvature * (p[a] - p[0]), curvature }
    }

    /// g at the pressure P0 + `by`; `by` is in pascals and negative below the threshold. Beyond the vertex of the
    /// parabola g is constant: contact area is proportional to load.
    fn value_at(&self, by: f64) -> f64 {
        let turns = -self.slope / (2.0 * self.curvature);
        let by = if turns.is_finite() && turns < 0.0 && self.curvature < 0.0 { by.max(turns) } else { by };
        self.value + self.slope * by + self.curvature * by * by
    }
}

impl AreaLaw {
    /// Area law of the same surface with Young's modulus multiplied by c = `factor`, and the same threshold P0. Contact
    /// area depends on P / E only, A(P; c E) = A(P / c; E), so that
    ///
    /// f(P; c E) = [A(P / c) / A(P0 / c)] / [P / P0] = g(P / c) / g(P0 / c),   g(P) = A(P) / P.
    ///
    /// g equals f above the threshold. Below it, where a law has no data, g is extrapolated by the parabola through the
    /// threshold and the tabulated pressures nearest to 1.5 and 2 times the threshold, or linearly from the first two
    /// if the table is too coarse. A law that begins with a step is scaled along P by c.
    ///
    /// # Errors
    /// [`MaterialError`] unless `factor` is positive and finite.
    pub fn at_modulus(&self, factor: f64) -> Result<Self, MaterialError> {
        positive("factor on Young's modulus", factor)?;
        let (p, f) = (self.pressures_pa(), self.factors());
        let moved = |pressure_pa: &f64| pressure_pa * factor;
        let is_step = p.len() > 1 && p[1] < p[0] * (1.0 + MAX_STEP_WIDTH);
        if is_step || p.len() < 2 {
            return Self::new(p.iter().map(moved).collect(), f.to_vec());
        }
        let threshold_pa = p[0];
        let below = ThresholdExtrapolation::fit(p, f);
        let g = |pressure_pa: f64| {
            if pressure_pa < threshold_pa {
                below.value_at(pressure_pa - threshold_pa)
            } else {
                self.factor(pressure_pa)
            }
        };
        let at_threshold = g(threshold_pa / factor);
        let (mut pressure_pa, mut factors) = (vec![threshold_pa], vec![1.0]);
        for (tabulated_pa, own) in p.iter().zip(f) {
            // A pressure that is scaled to the threshold, up to rounding, is the threshold.
            if moved(tabulated_pa) > threshold_pa * (1.0 + 1e-9) {
                pressure_pa.push(moved(tabulated_pa));
                factors.push(own / at_threshold);
            }
        }
        Self::new(pressure_pa, factors)
    }

    /// Adds `deviates` standard errors to all factors, and raises negative factors to 0; returns the law itself if
    /// standard errors are not known. Shifting all factors to the same side is the worst case.
    pub fn with_factors_off_by(&self, deviates: f64) -> Self {
        let Some(std) = self.factor_std() else { return self.clone() };
        let factors = self.factors().iter().zip(std).map(|(f, std)| (f + deviates * std).max(0.0)).collect();
        // Pressures and non-negative factors of a valid law form a valid table.
        Self::new(self.pressures_pa().to_vec(), factors).unwrap_or_else(|_| self.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A = 1 - exp(-P / 4 MPa E0 / E): concave, with A / P falling from the start.
    fn area(pressure_pa: f64, modulus: f64) -> f64 {
        1.0 - (-pressure_pa / (4e6 * modulus)).exp()
    }

    fn law(modulus: f64) -> AreaLaw {
        let pressure_pa: Vec<f64> = (1..400).map(|i| 0.05e6 * f64::from(i)).collect();
        let area: Vec<f64> = pressure_pa.iter().map(|&p| area(p, modulus)).collect();
        AreaLaw::from_area_curve(&pressure_pa, &area, 0.7e6).unwrap()
    }

    #[test]
    fn the_law_of_a_stiffer_surface_is_that_of_its_own_area_curve() {
        let known = law(1.0);
        for factor in [0.6, 0.8, 1.0, 1.25, 1.6] {
            let moved = known.at_modulus(factor).unwrap();
            let exact = law(factor);
            for i in 1..200 {
                let p = 0.05e6 * f64::from(i);
                let off = (moved.factor(p) - exact.factor(p)).abs();
                // Exact above the threshold; for a stiffer solid, with the error of the parabola for A / P below it.
                let most = if factor <= 1.0 { 3e-5 } else { 2.5e-4 };
                assert!(off < most, "{factor} {p}: {off}");
            }
        }
        assert_eq!(known.at_modulus(1.0).unwrap(), known);
        assert!(known.at_modulus(0.0).unwrap_err().to_string().contains("expected a positive number"));
    }

    #[test]
    fn a_law_with_a_step_moves_along_the_pressure() {
        let stepped = AreaLaw::new(vec![0.7e6, 2.6e6], vec![0.8, 0.5]).unwrap();
        let moved = stepped.at_modulus(1.3).unwrap();
        for p in [0.5e6, 0.9e6, 1.7e6, 4e6] {
            assert!((moved.factor(1.3 * p) - stepped.factor(p)).abs() < 1e-9, "{p}");
        }
    }

    #[test]
    fn factors_move_by_their_standard_errors() {
        let law = AreaLaw::new(vec![0.7e6, 2.6e6], vec![1.0, 0.9]).unwrap();
        assert_eq!(law.with_factors_off_by(2.0), law);
        let known = law.with_factor_std(vec![0.0, 0.02]).unwrap();
        assert!((known.with_factors_off_by(-2.0).factor(2.6e6) - 0.86).abs() < 1e-12);
        assert_eq!(known.with_factors_off_by(-100.0).factor(2.6e6), 0.0);
    }
}
