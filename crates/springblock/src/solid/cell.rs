//! The steady ratio of patterns in three dimensions, of one material under the same loads.

use slipgrid_material::{AreaLaw, Elastic};
use slipgrid_pattern::Pattern;

use super::lattice::SolidLattice;
use super::outcome::SolidOutcome;
use super::steady::{SolidLoad, SolidSteadyModel};
use crate::outcome::{InterfacePoint, Status, SurfaceOutcome};
use crate::scene::{Layer, Load, Scene};
use crate::section::SectionOutcome;

/// Bytes that a column of the cell takes for each of its explicit rows: displacements three times, their spectra,
/// condensed matrices, and the share of a cavity's unknowns in the directions kept.
const BYTES_PER_BLOCK: f64 = 1200.0;

/// Steady sliding of one three-dimensional periodic cell with mean coefficients, for any pattern.
///
/// As for [`crate::SectionModel`] the flat surface needs no solve, ratio = mu / (mu_d f(P)), and cells are as thick as the
/// specimen where the scene says how thick that is.
#[derive(Clone, Debug)]
pub struct SolidModel {
    elastic: Elastic,
    area_law: Option<AreaLaw>,
    layer: Layer,
    loads: Vec<Load>,
    liftoff: bool,
}

impl SolidModel {
    /// The model behind `scene`, whose pattern is ignored, as are options of time integration.
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

    /// Columns along x and y of the cell that [`Self::solve`] takes.
    #[must_use]
    pub fn columns(&self, pattern: &Pattern) -> [f64; 2] {
        SolidLattice::columns_of(pattern, self.layer.block_m)
    }

    /// Whether the cell is made of whole cubes.
    #[must_use]
    pub fn is_plain(&self, pattern: &Pattern) -> bool {
        SolidLattice::cell(pattern, self.layer.block_m, self.layer.rows()).is_plain()
    }

    /// Memory that [`Self::solve`] takes, in bytes, roughly and at most.
    #[must_use]
    pub fn bytes(&self, pattern: &Pattern) -> f64 {
        let [nx, ny] = self.columns(pattern);
        nx * ny * ((pattern.depth_m() / self.layer.block_m).ceil() + 1.0).max(2.0) * BYTES_PER_BLOCK
    }

    /// Steady sliding on `pattern`, one answer per load: the cell is condensed once, and loads help each other.
    #[must_use]
    pub fn solve(&self, pattern: &Pattern) -> Vec<SectionOutcome> {
        let lattice = SolidLattice::cell(pattern, self.layer.block_m, self.layer.thick_rows());
        let stiffness = self.elastic.youngs_modulus_pa();
        let model = SolidSteadyModel::new(lattice, self.layer.block_m, stiffness, self.liftoff);
        let loads: Vec<SolidLoad<'_>> = self
            .loads
            .iter()
            .map(|load| SolidLoad {
                pressure_pa: load.pressure_pa,
                dynamic_mu: load.friction.dynamic_mean(),
                area_law: self.area_law.as_ref(),
                direction: pattern.sliding_direction(),
            })
            .collect();
        let outcomes = model.solve_all(&loads);
        loads.iter().zip(outcomes).map(|(load, outcome)| answer(load, outcome)).collect()
    }

    /// The ratios alone.
    #[must_use]
    pub fn ratios(&self, pattern: &Pattern) -> Vec<Option<f64>> {
        self.solve(pattern).into_iter().map(|outcome| outcome.ratio).collect()
    }
}

/// The outcome of `load` beside the flat surface's friction.
fn answer(load: &SolidLoad, outcome: SolidOutcome) -> SectionOutcome {
    // mu_flat = mu_d f(P)
    let mu_flat = Some(load.dynamic_mu * load.area_law.map_or(1.0, |law| law.factor(load.pressure_pa)))
        .filter(|mu| *mu > 0.0 && load.pressure_pa > 0.0);
    let ratio = match (outcome.status, outcome.mu_dynamic, mu_flat) {
        (Status::Converged | Status::NoFriction, Some(mu), Some(flat)) => Some(mu / flat),
        _ => None,
    };
    SectionOutcome { surface: outcome.into(), mu_flat, ratio }
}

impl From<SolidOutcome> for SurfaceOutcome {
    fn from(outcome: SolidOutcome) -> Self {
        Self {
            mu_dynamic: outcome.mu_dynamic,
            peak_pressure_pa: outcome.peak_pressure_pa,
            tension_blocks: outcome.tension_blocks,
            cavity_closed: outcome.cavity_closed,
            clearance_m: outcome.clearance_m,
            area_law_extrapolated: outcome.area_law_extrapolated,
            residual: Some(outcome.residual).filter(|_| outcome.status != Status::NoLoad),
            iterations: outcome.iterations,
            interface: outcome
                .interface
                .iter()
                .map(|point| InterfacePoint {
                    x_m: point.x_m,
                    y_m: point.y_m,
                    pressure_pa: point.pressure_pa,
                    friction_pa: point.friction_pa,
                })
                .collect(),
            ..Self::unsolved(outcome.status, std::iter::empty())
        }
    }
}
