//! What may be asked in larger blocks, where space makes it worth while.

use super::*;

/// The model in larger blocks: the low-fidelity model of a search in space.
pub struct LowFidelity<'a> {
    pub(super) model: &'a SteadyModel<'a>,
    pub(super) scene: &'a Scene,
    pub(super) solver: &'a Solver,
}

impl ForwardModel for LowFidelity<'_> {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        self.model.ask(self.scene, self.solver, (design, design))
    }
}

impl SteadyModel<'_> {
    /// Values of an endless pattern at the loads of the condition designed for, as they are compared with the target but not
    /// corrected, and the largest local pressure at any of them in MPa; by the guide where `coarse` and there is one.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design cannot be computed.
    pub fn endless(&self, design: &Pattern, coarse: bool) -> Result<(Vec<f64>, f64), ModelFailure> {
        let (scene, solver) = match self.guide.as_ref().filter(|_| coarse) {
            Some((scene, solver)) => (scene, solver),
            None => (&self.asked, &self.solver),
        };
        let mut answer = self.answer(scene, solver, design)?;
        if let Some(learned) = &self.learned {
            answer.modulus_sensitivity = learned.modulus_sensitivity(design)?;
        }
        let answer = open(answer)?;
        let factors = self.factors_of(design, &answer);
        let own = answer.ratio.iter().zip(&factors).take(self.scene.loads.len()).enumerate();
        Ok((own.map(|(load, (ratio, factor))| ratio * self.scale(load) * factor).collect(), answer.peak_pressure_mpa))
    }
}
