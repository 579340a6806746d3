//! The chance that what is made of a design is on target, by draws that all designs share.

use crate::ModelFailure;
use crate::sensitivity::folded;
use crate::uncertainty::Uncertainty;
use crate::uncertainty_propagation::{Linearization, Probability, drawn};
use slipgrid_pattern::Pattern;
use slipgrid_statistics::Normals;

/// Seeded draws of everything that is not known exactly. Designs judged by the same draws are compared without the
/// scatter of drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonDraws {
    /// Deviations of the inputs, one draw after the other.
    deviations: Vec<f64>,
    inputs: usize,
    draws: usize,
    /// Place of the rims' height.
    rim: Option<usize>,
}

impl CommonDraws {
    /// `draws` draws from `uncertainty`.
    #[must_use]
    pub fn new(uncertainty: &Uncertainty, draws: usize, seed: u64) -> Self {
        let mut normals = Normals::new(seed);
        let draw = |_| {
            let z: Vec<f64> = (0..uncertainty.inputs()).map(|_| normals.draw()).collect();
            uncertainty.deviations(&z)
        };
        Self::of(uncertainty, (0..draws).flat_map(draw).collect())
    }

    /// Those of [`propagate`](crate::propagate) about `design`.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where hardly any leaves its dimensions positive.
    pub fn about(design: &Pattern, uncertainty: &Uncertainty, draws: usize, seed: u64) -> Result<Self, ModelFailure> {
        let mut normals = Normals::new(seed);
        let deviations: Vec<Vec<f64>> = (0..draws)
            .map(|_| Ok(drawn(design, uncertainty, &mut normals)?.deviations))
            .collect::<Result<_, ModelFailure>>()?;
        Ok(Self::of(uncertainty, deviations.concat()))
    }

    fn of(uncertainty: &Uncertainty, deviations: Vec<f64>) -> Self {
        let inputs = uncertainty.inputs();
        Self { draws: deviations.len() / inputs, deviations, inputs, rim: uncertainty.rim() }
    }

    /// How often `judge` holds of the values of `about`, moved to first order by each draw.
    #[must_use]
    pub fn probability(&self, about: &Linearization, judge: impl Fn(&[f64]) -> bool) -> Probability {
        self.probability_of(about, &|_| true, judge)
    }

    /// The same where the inputs of `of` alone are off.
    #[must_use]
    pub fn probability_of(
        &self,
        about: &Linearization,
        of: &dyn Fn(usize) -> bool,
        judge: impl Fn(&[f64]) -> bool,
    ) -> Probability {
        self.probability_by(about, of, |values, _| judge(values))
    }

    /// The same where `judge` is also told the deviations of all inputs: of some it may make more than slopes can.
    #[must_use]
    pub fn probability_by(
        &self,
        about: &Linearization,
        of: &dyn Fn(usize) -> bool,
        judge: impl Fn(&mut [f64], &[f64]) -> bool,
    ) -> Probability {
        // What moves nothing need not be added up.
        let moving: Vec<usize> = (0..self.inputs)
            .filter(|&input| of(input) && about.slopes()[input].iter().any(|slope| *slope != 0.0))
            .collect();
        let height_m = about.design().rim_height_m();
        let off = |input: usize, by: f64| if self.rim == Some(input) { folded(height_m, by) } else { by };
        let mut values = about.values().to_vec();
        let mut held = 0_usize;
        for draw in 0..self.draws {
            let deviations = &self.deviations[draw * self.inputs..(draw + 1) * self.inputs];
            values.copy_from_slice(about.values());
            for &input in &moving {
                for (value, slope) in values.iter_mut().zip(&about.slopes()[input]) {
                    *value += off(input, deviations[input]) * slope;
                }
            }
            held += usize::from(judge(&mut values, deviations));
        }
        Probability::of(held, self.draws)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Tolerances, propagate};
    use slipgrid_pattern::Planform;

    #[test]
    fn the_share_within_a_band_is_that_of_the_normal_distribution() {
        let tolerances = Tolerances { std_m: [3e-6, 0.0, 0.0], ..Tolerances::default() };
        let known = Uncertainty::new(&tolerances, &[vec![16.0]]).unwrap();
        let draws = CommonDraws::new(&known, 20_000, 7);
        let design = Pattern::new(Planform::Groove, 1e-4, 1e-4, 1e-5).unwrap();
        // v = 1 + w / um + p: a standard deviation of 5 in all, of 3 by the width alone.
        let none = vec![0.0];
        let about = Linearization::of_slopes(design, vec![1.0], vec![vec![1e6], none.clone(), none, vec![1.0]]);
        let within = |values: &[f64]| (values[0] - 1.0).abs() <= 5.0;
        let all = draws.probability(&about, within);
        assert!((all.share - 0.6827).abs() < 3.0 * all.stderr && all.stderr < 0.004, "{all:?}");
        let width = draws.probability_of(&about, &|input| input < 3, within);
        assert!((width.share - 0.9044).abs() < 3.0 * width.stderr, "{width:?}");
        assert_eq!(draws.probability(&about, within), CommonDraws::new(&known, 20_000, 7).probability(&about, within));
    }

    #[test]
    fn draws_about_a_design_are_those_that_a_model_is_asked_of() {
        // One in six widths is not positive and drawn again.
        let tolerances = Tolerances { std_m: [1e-4, 0.0, 0.0], ..Tolerances::default() };
        let known = Uncertainty::new(&tolerances, &[vec![4.0]]).unwrap();
        let design = Pattern::new(Planform::Groove, 1e-4, 1e-4, 1e-5).unwrap();
        let none = vec![0.0];
        let about = Linearization::of_slopes(design, vec![0.0], vec![vec![1e6], none.clone(), none, vec![1.0]]);
        let values = |draws: &CommonDraws| {
            let values = std::cell::RefCell::new(Vec::new());
            let _ = draws.probability(&about, |moved| {
                values.borrow_mut().push(moved[0]);
                true
            });
            values.into_inner()
        };
        let model = |made: &Pattern, off: &[f64]| Ok(vec![(made.width_m() - 1e-4) * 1e6 + off[0]]);
        let asked = propagate(&model, &design, &known, 500, 7).unwrap();
        assert!(asked.redrawn > 40);
        let drawn = values(&CommonDraws::about(&design, &known, 500, 7).unwrap());
        let place = std::cell::Cell::new(0);
        let same = asked.judged(|of| (of[0] - drawn[place.replace(place.get() + 1)]).abs() < 1e-9);
        assert!(same.len() == 500 && same.into_iter().all(|same| same));
    }
}
