//! A task that was checked, with all that follows from it before anything is searched.

use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_material::Material;
use slipgrid_springblock::Load;

use crate::operating_conditions::{self, Further};
use crate::task::{DesignTask, KnownMaterial};
use crate::{DesignError, lattice_table};

/// A task with its material and its conditions.
#[derive(Clone, Debug)]
pub struct PreparedTask {
    /// The task, its target at every condition.
    pub task: DesignTask,
    /// The material, with notes on what was interpolated for the conditions.
    pub material: Material,
    /// How well it is known.
    pub uncertainty: MaterialUncertainty,
    /// The loads at the condition designed for.
    pub loads: Vec<Load>,
    /// Whether each of them lies outside the range of what was measured.
    pub outside: Vec<bool>,
    /// The other conditions.
    pub further: Vec<Further>,
}

impl PreparedTask {
    /// `task`, where it can be done.
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
        let (loads, outside) = task.loads(&material)?;
        let further = operating_conditions::further(&task, &material)?;
        if task.table {
            lattice_table::check(&task)?;
        }
        Ok(Self { task, material, uncertainty, loads, outside, further })
    }

    /// Relative standard deviation of Young's modulus; 0 where it moves nothing.
    #[must_use]
    pub fn modulus_std(&self) -> f64 {
        self.uncertainty.modulus_std(self.material.area_law.as_ref()).unwrap_or(0.0)
    }
}
