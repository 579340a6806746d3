//! The steady ratio of many patterns of one material under the same loads: what a search calls.

use std::cell::OnceCell;

use slipgrid_material::{AreaLaw, Elastic};
use slipgrid_pattern::Pattern;

use crate::columns;
use crate::lattice::Lattice;
use crate::outcome::{Status, SurfaceOutcome};
use crate::scene::{Layer, Load, Scene};
use crate::steady::{CondensedModel, SteadyLoad, SteadyModel};

/// Steady sliding of one periodic cell with mean coefficients, for any pattern.
///
/// The flat surface needs no solve: a uniform layer carries the nominal pressure P everywhere and
/// slides at mu_d f(P), so that ratio = mu / (mu_d f(P)).
#[derive(Clone, Debug)]
pub struct SectionModel {
    elastic: Elastic,
    area_law: Option<AreaLaw>,
    layer: Layer,
    loads: Vec<Load>,
    liftoff: bool,
}

/// One load's answer for a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionOutcome {
    /// The patterned surface.
    pub surface: SurfaceOutcome,
    /// mu of the flat surface; `None` if its friction vanishes.
    pub mu_flat: Option<f64>,
    /// Ratio, patterned over flat; `None` without load or friction, or if the solve did not converge.
    pub ratio: Option<f64>,
}

impl SectionModel {
    /// The model behind `scene`, whose pattern is ignored.
    #[must_use]
    pub fn new(scene: &Scene) -> Self {
        Self {
            elastic: scene.elastic,
            area_law: scene.area_law.clone(),
            layer: scene.layer,
            loads: scene.loads.clone(),
            liftoff: scene.run.liftoff,
        }
    }

    /// Steady sliding on `pattern`, one answer per load: by the few forces about the cavity where that is possible and
    /// cheaper, otherwise as [`Self::solve_all_blocks`] does. Both give the same to rounding.
    #[must_use]
    pub fn solve(&self, pattern: &Pattern) -> Vec<SectionOutcome> {
        let lattice = self.lattice(pattern);
        let stiffness = self.elastic.youngs_modulus_pa();
        let condensed = CondensedModel::new(&lattice, self.layer.block_m, stiffness, self.liftoff);
        let all_blocks = OnceCell::new();
        self.answers(lattice.nx(), |load| {
            condensed
                .as_ref()
                .and_then(|model| model.solve(load))
                .unwrap_or_else(|| all_blocks.get_or_init(|| self.steady_model(lattice.clone())).solve(load))
        })
    }

    /// Steady sliding on `pattern` by a factorization of the equations of all blocks: slower, and the judge of
    /// [`Self::solve`].
    #[must_use]
    pub fn solve_all_blocks(&self, pattern: &Pattern) -> Vec<SectionOutcome> {
        let model = self.steady_model(self.lattice(pattern));
        self.answers(model.lattice().nx(), |load| model.solve(load))
    }

    fn lattice(&self, pattern: &Pattern) -> Lattice {
        Lattice::new(columns::cell(pattern, self.layer.block_m), self.layer.rows(), true)
    }

    fn steady_model(&self, lattice: Lattice) -> SteadyModel {
        SteadyModel::new(lattice, self.layer.block_m, self.elastic.youngs_modulus_pa(), self.liftoff)
    }

    fn answers(&self, columns: usize, solve: impl Fn(&SteadyLoad) -> SurfaceOutcome) -> Vec<SectionOutcome> {
        self.loads
            .iter()
            .map(|load| {
                let mean = load.friction.dynamic_mean();
                let dynamic_mu = vec![mean; columns];
                let area_law = self.area_law.as_ref();
                let surface = solve(&SteadyLoad { pressure_pa: load.pressure_pa, dynamic_mu: &dynamic_mu, area_law });
                // mu_flat = mu_d f(P)
                let mu_flat = Some(mean * area_law.map_or(1.0, |law| law.factor(load.pressure_pa)))
                    .filter(|mu| *mu > 0.0 && load.pressure_pa > 0.0);
                let ratio = match (surface.status, surface.mu_dynamic, mu_flat) {
                    (Status::Converged | Status::NoFriction, Some(mu), Some(flat)) => Some(mu / flat),
                    _ => None,
                };
                SectionOutcome { surface, mu_flat, ratio }
            })
            .collect()
    }

    /// The ratios alone.
    #[must_use]
    pub fn ratios(&self, pattern: &Pattern) -> Vec<Option<f64>> {
        self.solve(pattern).into_iter().map(|outcome| outcome.ratio).collect()
    }
}
