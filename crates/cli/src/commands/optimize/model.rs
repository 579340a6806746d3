//! The model that the search asks: the steady cell.

use slipgrid_optimize::{ForwardModel, ModelFailure, Response};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{
    Extent, Fidelity, LoadOutcome, RunOptions, Scene, SceneError, SectionModel, Simulation, Status, Unwatched, simulate,
};

/// Friction of a design by the steady cell, with what confirming runs found the model to miss.
pub struct SteadyCell {
    scene: Scene,
    section: SectionModel,
    /// Dynamic friction of the flat sample at each load, where the target is dynamic friction itself:
    /// the ratio hardly depends on time, friction itself lies above steady sliding.
    flat_mu: Option<Vec<f64>>,
    /// Added to the model's value at each pressure: dynamic minus steady at a confirmed design.
    correction: Vec<f64>,
}

impl SteadyCell {
    /// A model of the material, layer and loads of `scene`. With `flat_mu`, the dynamic friction of
    /// the flat sample at each load, it gives dynamic friction, without it the ratio.
    #[must_use]
    pub fn new(scene: &Scene, flat_mu: Option<Vec<f64>>) -> Self {
        let run = RunOptions {
            fidelity: Fidelity::Steady,
            extent: Extent::Cell,
            dimensions: Some(2),
            ..RunOptions::default()
        };
        let scene = Scene { pattern: None, run, ..scene.clone() };
        Self { section: SectionModel::new(&scene), flat_mu, correction: vec![0.0; scene.loads.len()], scene }
    }

    /// The scene of a design.
    #[must_use]
    pub fn scene(&self, design: &Pattern) -> Scene {
        Scene { pattern: Some(*design), ..self.scene.clone() }
    }

    /// The scene of a design, solved.
    ///
    /// # Errors
    /// [`SceneError`] if the design has no lattice.
    pub fn simulate(&self, design: &Pattern) -> Result<Simulation, SceneError> {
        simulate(&self.scene(design), &Unwatched)
    }

    /// Takes the difference between `confirmed` and what the search took for `predicted` as the
    /// model's error at every design, and returns the largest change of it. Pressures where either is
    /// absent keep their correction.
    pub fn correct(&mut self, predicted: &[f64], confirmed: &Simulation) -> f64 {
        let mut largest = 0.0_f64;
        let confirmed = self.confirmed(confirmed);
        for (correction, (predicted, confirmed)) in self.correction.iter_mut().zip(predicted.iter().zip(confirmed)) {
            if let Some(confirmed) = confirmed {
                largest = largest.max((confirmed - predicted).abs());
                *correction += confirmed - predicted;
            }
        }
        largest
    }

    /// The target's quantity by a confirming run, absent where it gave none.
    #[must_use]
    pub fn confirmed(&self, simulation: &Simulation) -> Vec<Option<f64>> {
        let value = |load: &LoadOutcome| if self.flat_mu.is_some() { load.surface.mu_dynamic } else { load.ratio };
        simulation.loads.iter().map(value).collect()
    }
}

impl ForwardModel for SteadyCell {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        let trial = |reason: String| ModelFailure::Trial { reason };
        self.scene(design).validate().map_err(|error| trial(error.to_string()))?;
        let mut value = Vec::new();
        let mut peak_pressure_pa = 0.0_f64;
        for (load, outcome) in self.section.solve(design).iter().enumerate() {
            let surface = &outcome.surface;
            if surface.status != Status::Converged {
                return Err(trial(format!("steady run: {}", surface.status.name())));
            }
            if surface.cavity_closed {
                return Err(trial("the cavity closes under load".to_owned()));
            }
            let ratio = outcome.ratio.ok_or_else(|| trial("friction is not defined".to_owned()))?;
            let scale = self.flat_mu.as_ref().map_or(1.0, |flat_mu| flat_mu[load]);
            value.push(ratio * scale + self.correction[load]);
            peak_pressure_pa = peak_pressure_pa.max(surface.peak_pressure_pa);
        }
        Ok(Response { value, peak_pressure_pa })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_material::{AreaLaw, Elastic, LocalFriction};
    use slipgrid_pattern::Planform;
    use slipgrid_springblock::{Layer, Load};

    fn scene() -> Scene {
        let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
        Scene {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.6]).unwrap()),
            pattern: None,
            layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6 },
            loads: vec![Load { pressure_pa: 0.65e6, friction }, Load { pressure_pa: 2.6e6, friction }],
            speed_m_s: 2e-3,
            run: RunOptions::default(),
        }
    }

    #[test]
    fn the_search_sees_what_simulate_reports() {
        let design = Pattern::new(Planform::Groove, 130.3e-6, 371e-6, 13e-6).unwrap();
        let flat_mu = [0.28, 0.25];
        for flat in [None, Some(flat_mu.to_vec())] {
            let model = SteadyCell::new(&scene(), flat.clone());
            let response = model.respond(&design).unwrap();
            let simulation = model.simulate(&design).unwrap();
            for (load, outcome) in simulation.loads.iter().enumerate() {
                let expected = outcome.ratio.unwrap() * if flat.is_some() { flat_mu[load] } else { 1.0 };
                assert!((response.value[load] - expected).abs() < 1e-9, "{load}");
            }
            let peak = simulation.loads.iter().map(|load| load.surface.peak_pressure_pa).fold(0.0, f64::max);
            assert!((response.peak_pressure_pa / peak - 1.0).abs() < 1e-9);
        }
        let deep = Pattern::new(Planform::Groove, 130e-6, 370e-6, 250e-6).unwrap();
        assert!(matches!(SteadyCell::new(&scene(), None).respond(&deep), Err(ModelFailure::Trial { .. })));
    }

    #[test]
    fn a_corrected_model_gives_what_was_confirmed() {
        let design = Pattern::new(Planform::Groove, 130e-6, 370e-6, 20e-6).unwrap();
        let mut model = SteadyCell::new(&scene(), None);
        let before = model.respond(&design).unwrap().value;
        let mut confirmed = model.simulate(&design).unwrap();
        for load in &mut confirmed.loads {
            load.ratio = load.ratio.map(|ratio| ratio + 0.003);
        }
        assert!((model.correct(&before, &confirmed) - 0.003).abs() < 1e-9);
        let after = model.respond(&design).unwrap().value;
        assert!(after.iter().zip(&before).all(|(after, before)| (after - before - 0.003).abs() < 1e-9));
        assert!(model.correct(&after, &confirmed) < 1e-9);
    }
}
