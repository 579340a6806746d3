//! The model that the search asks: the steady cell.

use slipgrid_material::Material;
use slipgrid_optimize::{ForwardModel, ModelFailure, Quantity, Response};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{
    Extent, Fidelity, Layer, Load, RunOptions, Scene, SceneError, Simulation, Status, Unwatched, simulate,
};

/// Friction of a design by the steady cell, with what confirming runs found the model to miss.
pub struct SteadyCell {
    scene: Scene,
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
        Self { scene, quantity, correction }
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
        let simulation = self.simulate(design).map_err(|error| ModelFailure::Trial { reason: error.to_string() })?;
        let mut value = Vec::new();
        let mut peak_pressure_pa = 0.0_f64;
        let values = self.values(&simulation);
        for ((load, found), correction) in simulation.loads.iter().zip(values).zip(&self.correction) {
            let surface = &load.surface;
            if surface.status != Status::Converged {
                return Err(ModelFailure::Trial { reason: format!("steady run: {}", surface.status.name()) });
            }
            if surface.cavity_closed {
                return Err(ModelFailure::Trial { reason: "the cavity closes under load".to_owned() });
            }
            let found = found.ok_or_else(|| ModelFailure::Trial { reason: "friction is not defined".to_owned() })?;
            value.push(found + correction);
            peak_pressure_pa = peak_pressure_pa.max(surface.peak_pressure_pa);
        }
        Ok(Response { value, peak_pressure_pa })
    }
}
