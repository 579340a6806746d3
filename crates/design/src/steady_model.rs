//! Model used by the search: the steady cell, in the plane or in space as the design requires.

use std::fmt::Debug;

use crate::optimize::{DesignSpace, ModelFailure};
use slipgrid_base::monitor::{Monitor, Unwatched};
use slipgrid_model::material::AreaLaw;
use slipgrid_model::pattern::{Pattern, Texture};
use slipgrid_model::springblock::{Dimension, Extent, Fidelity, Load, RunOptions, Scene, Statements, Status};

use crate::DesignError;
use crate::directional_cells::Solver;
use crate::evaluation_cache::{Answer, Evaluations};
use crate::operating_conditions::turned;
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_laser::export::Specimen;
use slipgrid_laser::specimen::Laid;

/// Block sizes of the guide, a model in larger blocks, as multiples of the layer's block size, in order of preference.
/// Cells of four times the block size cost a hundredth and change the ratio by at most 0.02, cells of twice the block
/// size cost a tenth and change it by 0.013.
const GUIDE_FACTORS: [usize; 4] = [4, 2, 3, 5];
/// Minimum number of rows of blocks in the guide's layer.
const MIN_GUIDE_ROWS: usize = 4;
/// Minimum number of the guide's blocks in the shortest pitch.
const MIN_GUIDE_PITCH: f64 = 2.0;

/// Computes friction ratios of designs by steady periodic cells, scaled to the areal density of the specimen.
pub struct SteadyModel<'a> {
    /// Scene with the loads of every condition in every direction, the design condition first. Conditions differ in the
    /// local coefficients alone, so one factorization serves all conditions of a direction.
    asked: Scene,
    /// Number of loads of the design condition, the first of `asked`.
    own_loads: usize,
    /// Sliding directions besides the designs' own, in degrees; their loads come last.
    directions_deg: Vec<f64>,
    /// Texture of the designs without their lengths, which determines the dimension of the cells.
    texture: Texture,
    solver: Solver,
    /// Guide: scene and solver in larger blocks; `None` in the plane, and if no larger blocks fit layer and pitch.
    guide: Option<(Scene, Solver)>,
    evaluations: Evaluations<'a>,
    /// Monitor that can cancel evaluations.
    monitor: &'a dyn Monitor,
    /// Specimen that designs are cut into; `None` for infinite patterns.
    specimen: Option<Specimen>,
}

impl<'a> SteadyModel<'a> {
    /// Creates a model with the material, layer, loads and dimensions of `scene` for the designs of `space`. `further`
    /// holds the loads of further conditions at the same pressures. The last of them belong to the sliding directions
    /// `directions_deg`, each of which has as many loads as the designs' own direction.
    pub fn new(scene: &Scene, further: &[&[Load]], directions_deg: &[f64], space: &DesignSpace) -> Self {
        let run = RunOptions {
            fidelity: Fidelity::Steady,
            extent: Extent::Cell,
            dimensions: scene.run.dimensions,
            ..RunOptions::default()
        };
        let loads = [&scene.loads[..], &further.concat()].concat();
        let asked = Scene { pattern: None, run, loads, ..scene.clone() };
        let model = Self::without_guide(asked, scene.loads.len(), *space.texture(), directions_deg);
        let rows = scene.layer.rows();
        let shortest_pitch_m = space.width_m()[0] + space.spacing_m()[0];
        let serves = |factor: &usize| {
            rows.is_multiple_of(*factor)
                && rows / factor >= MIN_GUIDE_ROWS
                && shortest_pitch_m >= MIN_GUIDE_PITCH * scene.layer.block_m * *factor as f64
        };
        let is_dear = !model.is_cheap_per_design();
        let guide = GUIDE_FACTORS.into_iter().find(serves).filter(|_| is_dear).map(|factor| {
            let mut coarse = model.asked.clone();
            coarse.layer.block_m *= factor as f64;
            // The cell has no specimen, so any whole number of blocks is valid.
            coarse.layer.length_m = coarse.layer.height_m;
            let solver = Solver::new(&coarse, &model.texture, directions_deg);
            (coarse, solver)
        });
        Self { guide, ..model }
    }

    /// Creates a model of `asked`, the scene with the loads of every condition, for infinite patterns and without a
    /// guide.
    fn without_guide(asked: Scene, own_loads: usize, texture: Texture, directions_deg: &[f64]) -> Self {
        Self {
            solver: Solver::new(&asked, &texture, directions_deg),
            asked,
            own_loads,
            directions_deg: directions_deg.to_vec(),
            texture,
            guide: None,
            evaluations: Evaluations::default(),
            monitor: &Unwatched,
            specimen: None,
        }
    }

    /// Lets `monitor` cancel evaluations with [`ModelFailure::Cancelled`], in space within one solve.
    #[must_use]
    pub fn watched_by(mut self, monitor: &'a dyn Monitor) -> Self {
        self.monitor = monitor;
        self
    }

    /// Evaluates designs on `specimen`, with the areal density of their layout.
    #[must_use]
    pub fn on(mut self, specimen: Specimen) -> Self {
        self.specimen = Some(specimen);
        self
    }

    /// Lays `design` out on the specimen; all samples of the design have this layout.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] if the specimen does not take the design.
    pub fn lay(&self, design: &Pattern) -> Result<Laid, ModelFailure> {
        Laid::new(self.specimen.as_ref(), design, self.dimension())
            .map_err(|error| ModelFailure::Trial(error.to_string()))
    }

    /// Scene with the loads of every condition.
    pub const fn asked(&self) -> &Scene {
        &self.asked
    }

    /// Uses `evaluations` as the store of results.
    pub fn keep(&mut self, evaluations: Evaluations<'a>) {
        self.evaluations = evaluations;
    }

    /// All inputs that results for a texture depend on, except its width, spacing and depth; for cache keys.
    pub(crate) fn content(&self) -> impl Debug + '_ {
        let guide = self.guide.as_ref().map(|(scene, _)| scene);
        (&self.asked, self.own_loads, &self.directions_deg, &self.texture, guide, &self.specimen)
    }

    /// Dimension in which designs are solved.
    pub const fn dimension(&self) -> Dimension {
        self.solver.dimension
    }

    /// Whether solving thousands of designs is affordable: true in the plane.
    pub const fn is_cheap_per_design(&self) -> bool {
        self.dimension().is_cheap_per_design()
    }

    /// Whether a guide, a model in larger blocks, exists.
    pub const fn has_guide(&self) -> bool {
        self.guide.is_some()
    }

    /// Cell of a design with the loads of every condition, in the larger blocks of the guide if `coarse` and a guide
    /// exists.
    pub(crate) fn cell(&self, design: &Pattern, coarse: bool) -> Scene {
        let guide = self.guide.as_ref().filter(|_| coarse).map(|(scene, _)| scene);
        Scene { pattern: Some(*design), ..guide.unwrap_or(&self.asked).clone() }
    }

    /// Cells of a design in every sliding direction, each with the loads of its direction.
    pub(crate) fn cells(&self, design: &Pattern) -> Vec<Scene> {
        let directions = &self.solver.each;
        let loads = self.asked.loads.chunks(self.asked.loads.len() / directions.len());
        let cell = |((angle_deg, _), loads): (&(Option<f64>, _), &[Load])| {
            let pattern = Some(turned(design, *angle_deg));
            Scene { pattern, loads: loads.to_vec(), ..self.asked.clone() }
        };
        directions.iter().zip(loads).map(cell).collect()
    }

    /// Number of draws of the local coefficients at which a cell of `design` has at least `contacts` contact blocks in
    /// total, counted by [`SteadyCell::draws`](slipgrid_model::springblock::SteadyCell::draws).
    pub fn draws(&self, design: &Pattern, contacts: f64) -> u64 {
        self.solver.each.first().map_or(1, |(_, cell)| cell.draws(design, contacts))
    }

    /// Computes the ratios of `made`, a sample with the layout `laid`, at every load of every condition.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] if the sample cannot be computed, or a cavity closes under load.
    pub fn ratios_made(&self, made: &Pattern, laid: &Laid) -> Result<Vec<f64>, ModelFailure> {
        Ok(open(self.answer_made(made, laid)?)?.ratio)
    }

    /// Computes the results for `made`, a sample with the layout `laid`, at every condition, also if cavities close.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the sample cannot be computed.
    pub fn answer_made(&self, made: &Pattern, laid: &Laid) -> Result<Answer, ModelFailure> {
        Ok(self.answer(&self.asked, &self.solver, made)?.on(laid, made))
    }

    /// Computes the results for the infinite pattern of `design` at every condition, also if cavities close, and stores
    /// them; uses the guide, a model in larger blocks, if `coarse` and a guide exists.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design cannot be computed.
    pub fn tabulated(&self, design: &Pattern, coarse: bool) -> Result<Answer, ModelFailure> {
        let (scene, solver) = match self.guide.as_ref().filter(|_| coarse) {
            Some((scene, solver)) => (scene, solver),
            None => (&self.asked, &self.solver),
        };
        self.evaluations.answer(scene.layer.block_m, design, || self.answer(scene, solver, design))
    }

    /// Describes how designs were solved in space, in addition to the statements of the confirming run.
    pub fn describe(&self, said: &mut Statements) {
        if self.dimension().takes_strips() {
            return;
        }
        let um = |length_m: f64| tidy(LENGTH_UM.from_si(length_m));
        let block_um = um(self.asked.layer.block_m);
        said.method(match &self.guide {
            Some((scene, _)) => format!(
                "tabulated in space: steady cells in blocks of {} um, lifted by cells in blocks of {block_um} um",
                um(scene.layer.block_m),
            ),
            None => format!("tabulated in space: steady cells in blocks of {block_um} um"),
        });
        if !self.is_cheap_per_design() {
            said.model("in space what sliding in time adds is not in the chance; it moves ratios by some thousandths");
        }
    }

    /// Computes the results for `design` at every condition without storing them.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] if the design cannot be computed, or a cavity closes under load.
    pub fn steady(&self, design: &Pattern) -> Result<Answer, ModelFailure> {
        open(self.answer_made(design, &self.lay(design)?)?)
    }

    /// Returns the error that no design of `space` can be computed, with the reason for the one in the middle of the bounds.
    pub fn nothing_computed(&self, space: &DesignSpace) -> DesignError {
        let middle = space.pattern(space.lengths_m().map(|[low, high]| (low * high).sqrt())).ok();
        let failure = middle.and_then(|design| self.steady(&design).err());
        let reason = failure.map_or_else(String::new, |failure| format!("; of the one in their middle: {failure}"));
        DesignError::Failed(format!("no design within the bounds can be computed{reason}"))
    }

    /// Builds a model for derivatives, with the scene that `change` makes of the scene with the loads of every
    /// condition. In space the guide's blocks are used, which change derivatives by one fifth, unless they do not
    /// resolve the rims.
    ///
    /// # Errors
    /// The error of `change`.
    pub fn beside<E>(&self, change: impl FnOnce(&Scene) -> Result<Scene, E>) -> Result<Self, E> {
        Ok(self.changed(change(self.serving_guide().unwrap_or(&self.asked))?))
    }

    /// Like [`Self::beside`], in the requested blocks.
    ///
    /// # Errors
    /// The error of `change`.
    pub fn in_own_blocks<E>(&self, change: impl FnOnce(&Scene) -> Result<Scene, E>) -> Result<Self, E> {
        Ok(self.changed(change(&self.asked)?))
    }

    fn changed(&self, asked: Scene) -> Self {
        let (monitor, specimen, own_loads) = (self.monitor, self.specimen, asked.loads.len());
        let model = Self::without_guide(asked, own_loads, self.texture, &self.directions_deg);
        Self { monitor, specimen, ..model }
    }

    /// Scene of the guide, if its blocks resolve the rims, which requires blocks of at most half the width of a rim.
    fn serving_guide(&self) -> Option<&Scene> {
        let serves = |scene: &&Scene| self.texture.rim().is_none_or(|rim| 2.0 * scene.layer.block_m <= rim.width_m());
        self.guide.as_ref().map(|(scene, _)| scene).filter(serves)
    }

    /// Area law of the designs.
    pub const fn area_law(&self) -> Option<&AreaLaw> {
        self.asked.area_law.as_ref()
    }

    /// Computes the results for the cell of `design` by `solver`, which was created from `scene`; ratios are not scaled
    /// to the specimen.
    fn answer(&self, scene: &Scene, solver: &Solver, design: &Pattern) -> Result<Answer, ModelFailure> {
        let trial = |reason: &str| ModelFailure::Trial(reason.to_owned());
        let scene = Scene { pattern: Some(*design), ..scene.clone() };
        scene.validate().map_err(|error| ModelFailure::Trial(error.to_string()))?;
        let mut ratio = Vec::new();
        let (mut peak_pressure_pa, mut least_pressure) = (0.0_f64, f64::INFINITY);
        let mut clearance_m: Option<f64> = None;
        for (outcome, load) in solver.solve(design, self.monitor)?.iter().zip(&scene.loads) {
            let surface = &outcome.surface;
            if surface.status != Status::Converged {
                return Err(match surface.status {
                    Status::NotConverged => trial("the steady solution was not found in the steps allowed"),
                    other => ModelFailure::Trial(format!("steady run: {}", other.name())),
                });
            }
            ratio.push(outcome.ratio.ok_or_else(|| trial("friction is not defined"))?);
            peak_pressure_pa = peak_pressure_pa.max(surface.peak_pressure_pa);
            let least_pa = surface.interface.iter().map(|point| point.pressure_pa).fold(f64::INFINITY, f64::min);
            least_pressure = least_pressure.min(least_pa / load.pressure_pa);
            clearance_m = [clearance_m, surface.clearance_m].into_iter().flatten().reduce(f64::min);
        }
        let (peak_pressure_mpa, clearance_um) = (peak_pressure_pa / 1e6, clearance_m.map(|least_m| least_m * 1e6));
        Ok(Answer { ratio, peak_pressure_mpa, least_pressure, clearance_um })
    }
}

/// Returns `answer` if the cavities stay open under load, otherwise [`ModelFailure::Trial`].
fn open(answer: Answer) -> Result<Answer, ModelFailure> {
    if answer.clearance_m().is_some_and(|clearance_m| clearance_m <= 0.0) {
        return Err(ModelFailure::Trial("the cavity closes under load".to_owned()));
    }
    Ok(answer)
}

#[cfg(test)]
mod tests;
