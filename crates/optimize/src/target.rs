use crate::SearchError;
use crate::error::positive;

/// Which number the target prescribes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// Dynamic friction coefficient over that of the flat surface.
    Ratio,
    /// Dynamic friction coefficient.
    DynamicFriction,
}

/// The wanted value at one nominal pressure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TargetPoint {
    /// Nominal pressure, in pascals.
    pub pressure_pa: f64,
    /// Wanted value, dimensionless.
    pub value: f64,
}

/// What friction should be, and how nearly.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    quantity: Quantity,
    points: Vec<TargetPoint>,
    tolerance: f64,
}

/// Distance of a response from the target, in units of the tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Misfit {
    /// Largest |value - target| / tolerance over the target's pressures: at most 1 where the target is met.
    pub max: f64,
    /// Root mean square of (value - target) / tolerance.
    pub rms: f64,
}

impl Target {
    /// A target of `quantity` at `points`, met where every value lies within `tolerance`.
    ///
    /// # Errors
    /// [`SearchError::NoTargetPoints`], [`SearchError::RepeatedPressure`], or
    /// [`SearchError::OutOfRange`] unless pressures, values and the tolerance are positive and finite.
    pub fn new(quantity: Quantity, points: Vec<TargetPoint>, tolerance: f64) -> Result<Self, SearchError> {
        if points.is_empty() {
            return Err(SearchError::NoTargetPoints);
        }
        for (index, point) in points.iter().enumerate() {
            positive("target pressure", point.pressure_pa)?;
            positive("target value", point.value)?;
            if points[..index].iter().any(|earlier| earlier.pressure_pa == point.pressure_pa) {
                return Err(SearchError::RepeatedPressure { pressure_pa: point.pressure_pa });
            }
        }
        positive("target tolerance", tolerance)?;
        Ok(Self { quantity, points, tolerance })
    }

    /// Which number is prescribed.
    #[must_use]
    pub const fn quantity(&self) -> Quantity {
        self.quantity
    }

    /// The pressures and their values, in the order given.
    #[must_use]
    pub fn points(&self) -> &[TargetPoint] {
        &self.points
    }

    /// Largest accepted |value - target|.
    #[must_use]
    pub const fn tolerance(&self) -> f64 {
        self.tolerance
    }

    /// The same asked of `times` responses, one after the other.
    pub(crate) fn repeated(&self, times: usize) -> Self {
        Self { points: self.points.repeat(times), ..self.clone() }
    }

    /// Misfit of `values`, one per point; further values are ignored.
    #[must_use]
    pub fn misfit(&self, values: &[f64]) -> Misfit {
        // r_i = (value_i - target_i) / tolerance, rms = sqrt(sum r_i^2 / n)
        let residuals = self.points.iter().zip(values).map(|(point, value)| (value - point.value) / self.tolerance);
        let (mut max, mut sum_of_squares) = (0.0_f64, 0.0);
        for residual in residuals {
            max = max.max(residual.abs());
            sum_of_squares += residual * residual;
        }
        Misfit { max, rms: (sum_of_squares / self.points.len() as f64).sqrt() }
    }
}

impl Misfit {
    /// Whether every value lies within the tolerance.
    #[must_use]
    pub fn is_met(&self) -> bool {
        self.max <= 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(pressure_pa: f64, value: f64) -> TargetPoint {
        TargetPoint { pressure_pa, value }
    }

    #[test]
    fn misfit_counts_in_tolerances() {
        let target = Target::new(Quantity::Ratio, vec![point(1e6, 0.9), point(2e6, 0.8)], 0.01).unwrap();
        let misfit = target.misfit(&[0.93, 0.76]);
        assert!((misfit.max - 4.0).abs() < 1e-12);
        assert!((misfit.rms - 12.5_f64.sqrt()).abs() < 1e-12);
        assert!(!misfit.is_met() && target.misfit(&[0.905, 0.795]).is_met());
    }

    #[test]
    fn targets_that_mean_nothing_are_refused() {
        let new = |points, tolerance| Target::new(Quantity::Ratio, points, tolerance);
        assert_eq!(new(vec![], 0.01), Err(SearchError::NoTargetPoints));
        assert!(matches!(new(vec![point(1e6, 0.9); 2], 0.01), Err(SearchError::RepeatedPressure { .. })));
        for (pressure_pa, value, tolerance) in [(0.0, 0.9, 0.01), (1e6, f64::NAN, 0.01), (1e6, 0.9, 0.0)] {
            assert!(matches!(new(vec![point(pressure_pa, value)], tolerance), Err(SearchError::OutOfRange { .. })));
        }
    }
}
