//! Checked task with everything that is derived from it before the search.

use slipgrid_infer::calibrate::uncertainty::MaterialUncertainty;
use slipgrid_model::material::Material;
use slipgrid_model::springblock::Load;

use crate::operating_conditions::{Setting, settings};
use crate::task::{DesignTask, KnownMaterial};
use crate::{DesignError, whole_steps};

/// Task with its material and its conditions.
#[derive(Clone, Debug)]
pub struct PreparedTask {
    /// Task with its conditions resolved.
    pub task: DesignTask,
    /// Material, with notes on interpolation for the conditions.
    pub material: Material,
    /// Uncertainty of the material.
    pub uncertainty: MaterialUncertainty,
    /// Conditions and sliding directions at which the target must hold, the design condition first.
    pub settings: Vec<Setting>,
    /// Whether each load at the design condition lies outside the pressures at which friction was measured.
    pub outside: Vec<bool>,
}

impl PreparedTask {
    /// Checks `task` and prepares it.
    ///
    /// # Errors
    /// [`DesignError`] for a task that is refused.
    pub fn new(task: &DesignTask) -> Result<Self, DesignError> {
        let mut task = task.clone();
        let known = task.material.clone().ok_or_else(|| DesignError::refused("has no material"))?;
        task.check(&known)?;
        let KnownMaterial { mut material, uncertainty } = known;
        let conditions = task.condition.iter().chain(&task.also_at);
        let interpolated = conditions.filter_map(|condition| material.friction.interpolation(Some(condition)));
        material.provenance.notes.extend(interpolated);
        let (_, outside) = task.loads(&material)?;
        let settings = settings(&task, &material)?;
        if task.search.table {
            whole_steps::check(&task)?;
        }
        Ok(Self { task, material, uncertainty, settings, outside })
    }

    /// Loads at the design condition.
    pub fn loads(&self) -> &[Load] {
        &self.settings[0].loads
    }

    /// Relative standard deviation of Young's modulus; 0 if the modulus has no effect.
    pub fn modulus_std(&self) -> f64 {
        self.uncertainty.modulus_std(self.material.area_law.as_ref()).unwrap_or(0.0)
    }
}
