//! The patterned samples behind a discrepancy, and how near a pattern is to them.
//!
//! The discrepancy is one factor whatever the pattern, and samples of one pattern say nothing of how it depends on areal
//! density, depth or planform. Were it proportional to areal density, a ratio measured to be a fifth below the modelled one
//! would be a tenth off at one and a half times the density: that is as far as it is used.

use slipgrid_pattern::{Pattern, Planform};

/// Largest areal density over that of the trials, and the trials' over the smallest.
pub const DENSITY_FACTOR: f64 = 1.5;
/// The same of the depth, which moves the modelled ratio by less.
pub const DEPTH_FACTOR: f64 = 2.0;

/// A pattern that was cut and measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trial {
    /// Shape of its cavities.
    pub planform: Planform,
    /// Share of its face that is cavity.
    pub areal_density: f64,
    /// Depth of its cavities, in metres.
    pub depth_m: f64,
}

impl From<&Pattern> for Trial {
    fn from(pattern: &Pattern) -> Self {
        Self { planform: pattern.planform(), areal_density: pattern.areal_density(), depth_m: pattern.depth_m() }
    }
}

/// The patterns that a discrepancy is used for: near those of the trials.
#[derive(Clone, Debug, PartialEq)]
pub struct TrialDomain {
    trials: Vec<Trial>,
}

/// In what a pattern is far from all trials.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Far {
    /// Its planform.
    Planform,
    /// Its areal density.
    ArealDensity,
    /// Its depth.
    Depth,
}

impl TrialDomain {
    /// The domain about `trials`; `None` without any.
    #[must_use]
    pub fn about(trials: Vec<Trial>) -> Option<Self> {
        (!trials.is_empty()).then_some(Self { trials })
    }

    /// The trials.
    #[must_use]
    pub fn trials(&self) -> &[Trial] {
        &self.trials
    }

    /// Whether a trial had cavities of this shape.
    #[must_use]
    pub fn has_planform(&self, planform: Planform) -> bool {
        self.trials.iter().any(|trial| trial.planform == planform)
    }

    /// Least and largest areal density: those of the trials, less and more by [`DENSITY_FACTOR`].
    #[must_use]
    pub fn areal_density(&self) -> [f64; 2] {
        self.range(|trial| trial.areal_density, DENSITY_FACTOR)
    }

    /// Least and largest depth in metres: those of the trials, less and more by [`DEPTH_FACTOR`].
    #[must_use]
    pub fn depth_m(&self) -> [f64; 2] {
        self.range(|trial| trial.depth_m, DEPTH_FACTOR)
    }

    fn range(&self, of: fn(&Trial) -> f64, factor: f64) -> [f64; 2] {
        let values = || self.trials.iter().map(of);
        [values().fold(f64::INFINITY, f64::min) / factor, values().fold(0.0, f64::max) * factor]
    }

    /// In what `pattern` is far from the trials; empty where it is near.
    #[must_use]
    pub fn far(&self, pattern: &Pattern) -> Vec<Far> {
        // A value within a part in a million of an end counts as that end.
        let outside = |value: f64, [from, to]: [f64; 2]| value < from * (1.0 - 1e-6) || value > to * (1.0 + 1e-6);
        let mut far = Vec::new();
        far.extend((!self.has_planform(pattern.planform())).then_some(Far::Planform));
        far.extend(outside(pattern.areal_density(), self.areal_density()).then_some(Far::ArealDensity));
        far.extend(outside(pattern.depth_m(), self.depth_m()).then_some(Far::Depth));
        far
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn near_the_published_squares_are_squares_of_about_their_density_and_depth() {
        let square = |width_um: f64, spacing_um: f64, depth_um: f64| {
            Pattern::new(Planform::Square, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap()
        };
        let domain = TrialDomain::about(vec![Trial::from(&square(130.0, 370.0, 5.2))]).unwrap();
        assert!((domain.areal_density()[1] - 1.5 * 0.0676).abs() < 1e-12);
        assert!((domain.depth_m()[0] - 2.6e-6).abs() < 1e-15 && (domain.depth_m()[1] - 10.4e-6).abs() < 1e-15);
        for near in [square(130.0, 370.0, 5.2), square(65.0, 185.0, 2.6), square(130.0, 300.0, 10.4)] {
            assert_eq!(domain.far(&near), []);
        }
        // A surface that is hardly textured is not one whose friction was measured.
        assert_eq!(domain.far(&square(36.9, 968.1, 6.3)), [Far::ArealDensity]);
        let groove = Pattern::new(Planform::Groove, 400e-6, 778.3e-6, 33.8e-6).unwrap();
        assert_eq!(domain.far(&groove), [Far::Planform, Far::ArealDensity, Far::Depth]);
        let both = TrialDomain::about(vec![Trial::from(&square(130.0, 370.0, 5.2)), Trial::from(&groove)]).unwrap();
        assert_eq!(both.far(&groove), []);
        assert_eq!(both.far(&square(200.0, 300.0, 20.0)), []);
        assert_eq!(TrialDomain::about(Vec::new()), None);
    }
}
