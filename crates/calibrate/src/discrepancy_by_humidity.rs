//! The discrepancy at the humidities at which patterned samples were measured.

use crate::Discrepancy;

/// The discrepancy over all conditions, and at humidities that have one of their own.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscrepancyByHumidity {
    /// Over all measured conditions.
    pub all: Discrepancy,
    /// At humidities, from 0 to 1, with enough measurements of their own.
    pub by_humidity: Vec<(f64, Discrepancy)>,
}

impl DiscrepancyByHumidity {
    /// The discrepancy for a humidity, from 0 to 1: its own where one was estimated, between two that have one what lies
    /// between theirs, that of all conditions otherwise.
    #[must_use]
    pub fn at(&self, humidity: Option<f64>) -> Discrepancy {
        let Some(humidity) = humidity else { return self.all.clone() };
        let is_own = |measured: f64| (humidity - measured).abs() <= 1e-6 * measured.max(1e-3);
        if let Some((_, own)) = self.by_humidity.iter().rfind(|(measured, _)| is_own(*measured)) {
            return own.clone();
        }
        let nearest = |is_on_side: &dyn Fn(f64) -> bool| {
            let on_side = self.by_humidity.iter().filter(|(measured, _)| is_on_side(*measured));
            on_side.min_by(|a, b| (a.0 - humidity).abs().total_cmp(&(b.0 - humidity).abs()))
        };
        let below = nearest(&|measured| measured < humidity);
        let above = nearest(&|measured| measured > humidity);
        let between = below
            .zip(above)
            .and_then(|((low, dry), (high, humid))| dry.towards(humid, (humidity - low) / (high - low)));
        between.unwrap_or_else(|| self.all.clone())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_measured_humidities_lies_what_lies_between_theirs() {
        let of = |coefficient: f64| Discrepancy {
            coefficients: vec![coefficient],
            covariance: vec![vec![1e-4]],
            reference_pressure_pa: 1.5e6,
            scatter: 0.02,
            modulus_sensitivity: vec![0.1],
            modulus_relative_std: 0.2,
            pressure_range_pa: [0.6e6, 2.5e6],
            chi_square: 4.0,
            degrees_of_freedom: 4,
        };
        let found = DiscrepancyByHumidity {
            all: of(-0.5),
            by_humidity: vec![(0.80, of(-0.4)), (0.15, of(-0.2)), (0.40, of(-0.1))],
        };
        let coefficient = |humidity: Option<f64>| found.at(humidity).coefficients[0];
        assert_eq!(
            [None, Some(0.15), Some(0.4), Some(0.1), Some(0.9)].map(coefficient),
            [-0.5, -0.2, -0.1, -0.5, -0.5]
        );
        assert!((coefficient(Some(0.275)) + 0.15).abs() < 1e-12 && (coefficient(Some(0.5)) + 0.175).abs() < 1e-12);
    }
}
