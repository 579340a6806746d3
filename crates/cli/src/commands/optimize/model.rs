//! The model that the search asks: the steady cell.

use slipgrid_material::Material;
use slipgrid_optimize::{ForwardModel, ModelFailure, Quantity, Response};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{
    Extent, Fidelity, Layer, Load, RunOptions, Scene, SceneError, SectionModel, Simulation, Status, Unwatched, simulate,
};

/// Friction of a design by the steady cell, with what confirming runs found the model to miss.
pub struct SteadyCell {
    scene: Scene,
    section: SectionModel,
    quantity: Quantity,
    /// Added to the model's value at each pressure: dynamic minus steady at a confirmed design.
    correction: Vec<f64>,
}

impl SteadyCell {
    /// A model of `material` on `layer` at `loads`.
    #[must_use]
    pub fn new(material: &Material, layer: Layer, loads: Vec<Load>, speed_m_s: f64, quantity: Quantity) -> Self {
        let correction = vec![0.0; loads.len()];
        let scene = Scene {
            elastic: material.elastic,
            area_law: material.area_law.clone(),
            pattern: None,
            layer,
            loads,
            speed_m_s,
            run: RunOptions { fidelity: Fidelity::Steady, extent: Extent::Cell, ..RunOptions::default() },
        };
        Self { section: SectionModel::new(&scene), scene, quantity, correction }
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

    /// Takes the difference between `confirmed` and `predicted` at one design as the model's error
    /// at every design, and returns the largest change of it. Pressures where either is absent keep
    /// their correction.
    pub fn correct(&mut self, predicted: &Simulation, confirmed: &Simulation) -> f64 {
        let pairs = self.values(predicted).into_iter().zip(self.values(confirmed));
        let mut largest = 0.0_f64;
        for (correction, pair) in self.correction.iter_mut().zip(pairs) {
            if let (Some(predicted), Some(confirmed)) = pair {
                largest = largest.max((confirmed - predicted - *correction).abs());
                *correction = confirmed - predicted;
            }
        }
        largest
    }

    /// The target's quantity at each load, absent where a run gave none.
    #[must_use]
    pub fn values(&self, simulation: &Simulation) -> Vec<Option<f64>> {
        let value = |load: &slipgrid_springblock::LoadOutcome| match self.quantity {
            Quantity::Ratio => load.ratio,
            Quantity::DynamicFriction => load.surface.mu_dynamic,
        };
        simulation.loads.iter().map(value).collect()
    }
}

impl ForwardModel for SteadyCell {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        let trial = |reason: String| ModelFailure::Trial { reason };
        self.scene(design).validate().map_err(|error| trial(error.to_string()))?;
        let mut value = Vec::new();
        let mut peak_pressure_pa = 0.0_f64;
        for (outcome, correction) in self.section.solve(design).iter().zip(&self.correction) {
            let surface = &outcome.surface;
            if surface.status != Status::Converged {
                return Err(trial(format!("steady run: {}", surface.status.name())));
            }
            if surface.cavity_closed {
                return Err(trial("the cavity closes under load".to_owned()));
            }
            let found = match self.quantity {
                Quantity::Ratio => outcome.ratio,
                Quantity::DynamicFriction => surface.mu_dynamic,
            };
            value.push(found.ok_or_else(|| trial("friction is not defined".to_owned()))? + correction);
            peak_pressure_pa = peak_pressure_pa.max(surface.peak_pressure_pa);
        }
        Ok(Response { value, peak_pressure_pa })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_material::{AreaLaw, Elastic, Friction, LocalFriction, Provenance};
    use slipgrid_pattern::Planform;

    #[test]
    fn the_search_sees_what_simulate_reports() {
        let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
        let material = Material {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            friction: Friction::Single(friction),
            area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.6]).unwrap()),
            provenance: Provenance::default(),
        };
        let layer = Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6 };
        let loads = vec![Load { pressure_pa: 0.65e6, friction }, Load { pressure_pa: 2.6e6, friction }];
        let design = Pattern::new(Planform::Groove, 130.3e-6, 371e-6, 13e-6).unwrap();
        for quantity in [Quantity::Ratio, Quantity::DynamicFriction] {
            let model = SteadyCell::new(&material, layer, loads.clone(), 2e-3, quantity);
            let response = model.respond(&design).unwrap();
            let simulation = model.simulate(&design).unwrap();
            for (load, (value, reported)) in response.value.iter().zip(model.values(&simulation)).enumerate() {
                assert!((value - reported.unwrap()).abs() < 1e-9, "{load}");
            }
            let peak = simulation.loads.iter().map(|load| load.surface.peak_pressure_pa).fold(0.0, f64::max);
            assert!((response.peak_pressure_pa / peak - 1.0).abs() < 1e-9);
        }
        let deep = Pattern::new(Planform::Groove, 130e-6, 370e-6, 250e-6).unwrap();
        let model = SteadyCell::new(&material, layer, loads, 2e-3, Quantity::Ratio);
        assert!(matches!(model.respond(&deep), Err(ModelFailure::Trial { .. })));
    }
}
