//! Steady sliding of a cell of a thick specimen.
//!
//! The equations of all blocks would have as many rows as the specimen is thick. The equations around the cavities
//! ([`super::condensed`]) do not depend on the thickness, because the layer above them is represented by the response
//! of a flat layer. Where blocks lift, which a thin layer leaves to the equations of all blocks, contact is that of a
//! face without heights ([`super::raised`]).

use std::sync::OnceLock;

use super::condensed::CondensedModel;
use super::raised::{FaceHistory, RaisedModel};
use super::{SteadyLoad, unloaded};
use crate::material::Elastic;
use crate::springblock::{Lattice, Status, SurfaceOutcome};

/// Model of a cell over the whole thickness of the specimen.
#[derive(Clone, Debug)]
pub struct ThickModel {
    lattice: Lattice,
    block_m: f64,
    elastic: Elastic,
    liftoff: bool,
    /// Model with every contact block on the counterface; `None` if the equations are singular.
    condensed: Option<CondensedModel>,
    /// Model of unilateral contact, created when a block would be under tension; `None` if the equations are singular.
    unilateral: OnceLock<Option<RaisedModel>>,
}

impl ThickModel {
    /// Condenses `lattice`, a periodic lattice of equal columns whose blocks are `block_m` metres apart.
    ///
    /// With `liftoff` contact is unilateral and blocks under tension leave the counterface.
    pub fn new(lattice: Lattice, block_m: f64, elastic: Elastic, liftoff: bool) -> Self {
        let condensed = CondensedModel::with_any_cost(&lattice, block_m, elastic.youngs_modulus_pa());
        Self { lattice, block_m, elastic, liftoff, condensed, unilateral: OnceLock::new() }
    }

    /// Solves steady sliding under `load`.
    pub fn solve(&self, load: &SteadyLoad) -> SurfaceOutcome {
        let unsolved = || SurfaceOutcome::unsolved(Status::NotConverged, std::iter::empty());
        let Some(model) = &self.condensed else { return unsolved() };
        if load.pressure_pa == 0.0 || model.contacts().is_empty() {
            return unloaded(model.contacts(), self.block_m);
        }
        let state = model.iterate(load);
        if !(self.liftoff && state.normal.iter().any(|normal| *normal < 0.0)) {
            return model.observe(load, &state);
        }
        let unilateral = || RaisedModel::new(&self.lattice, self.block_m, self.elastic);
        let unilateral = self.unilateral.get_or_init(unilateral).as_ref();
        unilateral.map_or_else(unsolved, |model| model.solve(load, &mut FaceHistory::default()))
    }
}
