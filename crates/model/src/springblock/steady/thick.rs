//! Steady sliding of a cell of a thick specimen.
//!
//! The equations of all blocks would have as many rows as the specimen is thick. The equations around the cavities
//! ([`super::condensed`]) do not depend on the thickness, because the layer above them is represented by the response
//! of a flat layer. Lifted blocks, which a thin layer leaves to the equations of all blocks, are therefore unknowns
//! here.

use super::condensed::CondensedModel;
use super::{Equilibrium, MAX_CONTACT_ROUNDS, SteadyLoad, unloaded};
use crate::springblock::{Lattice, Status, SurfaceOutcome};

/// Model of a cell over the whole thickness of the specimen.
#[derive(Clone, Debug)]
pub struct ThickModel {
    lattice: Lattice,
    block_m: f64,
    youngs_modulus_pa: f64,
    liftoff: bool,
    /// Model with every contact block on the counterface; `None` if the equations are singular.
    condensed: Option<CondensedModel>,
}

impl ThickModel {
    /// Condenses `lattice`, a periodic lattice of equal columns whose blocks are `block_m` metres apart.
    ///
    /// With `liftoff` contact is unilateral and blocks under tension leave the counterface.
    pub fn new(lattice: Lattice, block_m: f64, youngs_modulus_pa: f64, liftoff: bool) -> Self {
        let condensed = CondensedModel::with_lifted(&lattice, block_m, youngs_modulus_pa, &[]);
        Self { lattice, block_m, youngs_modulus_pa, liftoff, condensed }
    }

    /// Solves steady sliding under `load`.
    pub fn solve(&self, load: &SteadyLoad) -> SurfaceOutcome {
        let Some(model) = &self.condensed else {
            return SurfaceOutcome::unsolved(Status::NotConverged, std::iter::empty());
        };
        if load.pressure_pa == 0.0 || model.contacts().is_empty() {
            return unloaded(model.contacts(), self.block_m);
        }
        let state = model.iterate(load);
        if self.liftoff && state.normal.iter().any(|normal| *normal < 0.0) {
            return self.solve_unilateral(model, state, load);
        }
        model.observe(load, &state)
    }

    /// Lifts blocks under tension and lands lifted blocks below the counterface until no block changes, starting from
    /// `state` of `model`, in which all contacts touch.
    fn solve_unilateral(&self, model: &CondensedModel, mut state: Equilibrium, load: &SteadyLoad) -> SurfaceOutcome {
        let mut model = model.clone();
        let mut lifted: Vec<usize> = Vec::new();
        for _ in 0..MAX_CONTACT_ROUNDS {
            let heights = model.heights(&state);
            let leaves = |normal: f64, height: Option<f64>| height.map_or(normal < 0.0, |height| height >= 0.0);
            let off = model.contacts().iter().zip(state.normal.iter().zip(&heights));
            let next: Vec<usize> =
                off.filter(|(_, (normal, height))| leaves(**normal, **height)).map(|(c, _)| c.column).collect();
            if next == lifted {
                return model.observe(load, &state);
            }
            if next.len() == model.contacts().len() {
                break;
            }
            let Some(latest) = CondensedModel::with_lifted(&self.lattice, self.block_m, self.youngs_modulus_pa, &next)
            else {
                break;
            };
            let iterations = state.iterations;
            (model, lifted) = (latest, next);
            state = model.iterate(load);
            state.iterations += iterations;
        }
        state.status = Status::NotConverged;
        model.observe(load, &state)
    }
}
