//! The model that the search asks: the steady cell, in the plane or in space as the design needs.

mod coarse;
mod confirming_runs;

use std::fmt::Debug;
use std::sync::Arc;

use slipgrid_export::ExportError;
use slipgrid_material::AreaLaw;
use slipgrid_monitor::{Monitor, Part, Unwatched};
use slipgrid_optimize::{DesignSpace, ForwardModel, ModelFailure, Response};
use slipgrid_pattern::{Pattern, Texture};
use slipgrid_springblock::{Dimension, Extent, Fidelity, Load, RunOptions, Scene, Simulation, Status, simulate};

pub use self::coarse::{Endless, LowFidelity};
use crate::between_designs::BetweenDesigns;
use crate::constraint_quantities::Limited;
use crate::directional_cells::Solver;
use crate::evaluation_cache::{Answer, Evaluations};
use crate::learned_discrepancy::LearnedDiscrepancy;
use slipgrid_export::Specimen;
use slipgrid_specimen::{Laid, SpecimenError, onto};

/// Blocks of the guide over those of the layer, the first that serves: cells of four times the block cost a hundredth
/// and differ by at most 0.02 of the ratio, of twice the block a tenth and 0.013.
const GUIDE_FACTORS: [usize; 4] = [4, 2, 3, 5];
/// Rows that the guide's layer keeps, and blocks that the shortest pitch keeps.
const LEAST_GUIDE_ROWS: usize = 4;
const LEAST_GUIDE_PITCH: f64 = 2.0;

/// Friction of a design by the steady cell, with what specimens of earlier designs, steady or in time, found the model to miss.
pub struct SteadyModel<'a> {
    /// With the loads of the condition designed for.
    scene: Scene,
    /// With the loads of every condition in every direction, those of the condition designed for first: what designs are
    /// asked of. Conditions differ in the local coefficients alone, so one factorization serves all of a direction.
    asked: Scene,
    /// Sliding directions beside that of the designs, whose loads come last.
    directions_deg: Vec<f64>,
    /// Everything of the designs but their lengths: it decides where they are solved.
    texture: Texture,
    solver: Solver,
    /// The same in larger blocks, where space makes it worth while.
    guide: Option<(Scene, Solver)>,
    /// Dynamic friction of the flat sample at each load of each condition, where the target is dynamic friction itself:
    /// the ratio hardly depends on time, friction itself lies above steady sliding.
    flat_mu: Option<Vec<f64>>,
    /// What trials say that the model lacks, where designs aim with it.
    learned: Option<Arc<LearnedDiscrepancy<'a>>>,
    /// Differences of specimens of earlier designs from their cells over [`texture_effect`], at each load of each condition.
    correction: BetweenDesigns,
    limited: Limited,
    evaluations: Evaluations<'a>,
    /// Ends a search.
    monitor: &'a dyn Monitor,
    /// What designs are cut into; absent for endless patterns.
    specimen: Option<Specimen>,
}

impl<'a> SteadyModel<'a> {
    /// A model of the material, layer, loads and dimensions of `scene`, for the designs of `space`, and at the same
    /// pressures of `further` conditions, of which the last are those of each of `directions_deg`, as many as of the
    /// designs' own direction. With `flat_mu`, the dynamic friction of the flat sample at each load of the
    /// scene, it gives dynamic friction, without it the ratio; flat friction elsewhere is that times the ratio of the
    /// coefficients.
    #[must_use]
    pub fn new(
        scene: &Scene,
        further: &[&[Load]],
        directions_deg: &[f64],
        space: &DesignSpace,
        flat_mu: Option<Vec<f64>>,
    ) -> Self {
        let run = RunOptions {
            fidelity: Fidelity::Steady,
            extent: Extent::Cell,
            dimensions: scene.run.dimensions,
            ..RunOptions::default()
        };
        let scene = Scene { pattern: None, run, ..scene.clone() };
        let loads: Vec<Load> =
            scene.loads.iter().chain(further.iter().flat_map(|loads| loads.iter())).copied().collect();
        let flat_mu = flat_mu.map(|flat_mu| {
            // mu_flat = mu_d f(P): at one pressure it goes as mu_d
            let at = |(place, load): (usize, &Load)| {
                let first = place % scene.loads.len();
                flat_mu[first] * load.friction.dynamic_mean() / scene.loads[first].friction.dynamic_mean()
            };
            loads.iter().enumerate().map(at).collect()
        });
        let asked = Scene { loads, ..scene.clone() };
        let rows = scene.layer.rows();
        let shortest_pitch_m = space.width_m()[0] + space.spacing_m()[0];
        let serves = |factor: &usize| {
            rows.is_multiple_of(*factor)
                && rows / factor >= LEAST_GUIDE_ROWS
                && shortest_pitch_m >= LEAST_GUIDE_PITCH * scene.layer.block_m * *factor as f64
        };
        let texture = *space.texture();
        let solver = Solver::new(&asked, &texture, directions_deg);
        let is_dear = !solver.dimension.is_cheap_per_design();
        let guide = GUIDE_FACTORS.into_iter().find(serves).filter(|_| is_dear).map(|factor| {
            let mut coarse = asked.clone();
            coarse.layer.block_m *= factor as f64;
            // The cell knows no specimen: any whole number of blocks does.
            coarse.layer.length_m = coarse.layer.height_m;
            let solver = Solver::new(&coarse, &texture, directions_deg);
            (coarse, solver)
        });
        Self {
            solver,
            texture,
            directions_deg: directions_deg.to_vec(),
            guide,
            flat_mu,
            learned: None,
            correction: BetweenDesigns::default(),
            scene,
            asked,
            limited: Limited::default(),
            evaluations: Evaluations::default(),
            monitor: &Unwatched,
            specimen: None,
        }
    }

    /// Questions end with [`ModelFailure::Cancelled`] once `monitor` has cancelled, in space within one solve.
    #[must_use]
    pub fn watched_by(mut self, monitor: &'a dyn Monitor) -> Self {
        self.monitor = monitor;
        self
    }

    /// Designs are judged as they lie on `specimen` from here on: with the share of its face that their cavities take.
    #[must_use]
    pub fn on(mut self, specimen: Specimen) -> Self {
        self.specimen = Some(specimen);
        self
    }

    /// Share of the specimen's face that is cavity over that of the endless pattern.
    pub(crate) fn share(&self, design: &Pattern) -> Result<f64, ExportError> {
        Ok(Laid::new(self.specimen.as_ref(), design, self.dimension())?.share(design))
    }

    /// `design` as it lies on the specimen, for the samples that are made of it.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the specimen does not take it.
    pub fn lay(&self, design: &Pattern) -> Result<Laid, ModelFailure> {
        Laid::new(self.specimen.as_ref(), design, self.dimension())
            .map_err(|error| ModelFailure::Trial { reason: error.to_string() })
    }

    /// The scene with the loads of every condition.
    #[must_use]
    pub const fn asked(&self) -> &Scene {
        &self.asked
    }

    /// Values are multiplied by the medians of `learned` from here on: those of the model and those of confirming runs.
    pub fn aim_with(&mut self, learned: LearnedDiscrepancy<'a>) {
        self.learned = Some(Arc::new(learned));
    }

    /// What designs aim with beside the physics.
    #[must_use]
    pub const fn learned(&self) -> Option<&Arc<LearnedDiscrepancy<'a>>> {
        self.learned.as_ref()
    }

    /// Takes over the quantities that limits hold, and what has been answered so far.
    pub fn keep(&mut self, limited: Limited, evaluations: Evaluations<'a>) {
        (self.limited, self.evaluations) = (limited, evaluations);
    }

    /// Everything that answers about a texture follow from where designs do not aim with a discrepancy, but for its lengths.
    pub(crate) fn content(&self) -> impl Debug + '_ {
        let guide = self.guide.as_ref().map(|(scene, _)| scene);
        (&self.asked, self.scene.loads.len(), &self.directions_deg, &self.texture, guide, &self.flat_mu, &self.specimen)
    }

    /// Whether designs slide in more than one direction.
    #[must_use]
    pub const fn has_directions(&self) -> bool {
        !self.directions_deg.is_empty()
    }

    /// Where designs are solved.
    #[must_use]
    pub const fn dimension(&self) -> Dimension {
        self.solver.dimension
    }

    /// Whether designs can be asked for by the thousand.
    #[must_use]
    pub const fn is_cheap_per_design(&self) -> bool {
        self.dimension().is_cheap_per_design()
    }

    /// The cheap guide of a search in space, corrected alike, with the size of its blocks in metres; `None` in the
    /// vertical plane, and where the layer or the shortest pitch takes no larger blocks.
    #[must_use]
    pub fn guide(&self) -> Option<(LowFidelity<'_>, f64)> {
        let (scene, solver) = self.guide.as_ref()?;
        Some((LowFidelity { model: self, scene, solver }, scene.layer.block_m))
    }

    /// The cell of a design with the loads of every condition, in the guide's blocks where there is a guide and `coarse` asks for it.
    pub(crate) fn cell(&self, design: &Pattern, coarse: bool) -> Scene {
        let guide = self.guide.as_ref().filter(|_| coarse).map(|(scene, _)| scene);
        Scene { pattern: Some(*design), ..guide.unwrap_or(&self.asked).clone() }
    }

    /// Designs that were solved so far, by the model and by its guide.
    #[cfg(test)]
    pub(crate) fn solved(&self) -> [usize; 2] {
        let guide = self.guide.as_ref().map(|(_, solver)| solver);
        [Some(&self.solver), guide]
            .map(|solver| solver.map_or(0, |solver| solver.asked.load(std::sync::atomic::Ordering::Relaxed)))
    }

    /// Draws of the local coefficients with which a cell of `design` has at least `contacts` contact blocks in all, as
    /// [`SteadyCell::draws`](slipgrid_springblock::SteadyCell::draws) counts them.
    #[must_use]
    pub fn draws(&self, design: &Pattern, contacts: f64) -> u64 {
        self.solver.each.first().map_or(1, |(_, cell)| cell.draws(design, contacts))
    }

    /// The scene of a design.
    #[must_use]
    pub fn scene(&self, design: &Pattern) -> Scene {
        Scene { pattern: Some(*design), ..self.scene.clone() }
    }

    /// The cell of a design, solved, and laid on the specimen.
    ///
    /// # Errors
    /// [`SpecimenError`] if the design has no lattice or does not fit on the specimen.
    pub fn simulate(&self, design: &Pattern) -> Result<Simulation, SpecimenError> {
        let mut simulation = simulate(&self.scene(design), &Part::new(self.monitor, 0.0))?;
        if self.specimen.is_some() {
            onto(&mut simulation, self.share(design)?, &[]);
        }
        Ok(simulation)
    }

    /// Ratios of `made`, a sample of what was `laid`, in `scene`, one of this model's with other coefficients and
    /// another area law.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the design cannot be computed.
    pub fn ratios_of(&self, scene: &Scene, made: &Pattern, laid: &Laid) -> Result<Vec<f64>, ModelFailure> {
        let solver = Solver::new(scene, &self.texture, &self.directions_deg);
        Ok(open(self.answer(scene, &solver, made)?)?.on(laid, made).ratio)
    }

    /// Ratios of `made`, a sample of what was `laid`, at every condition.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the sample cannot be computed.
    pub fn ratios_made(&self, made: &Pattern, laid: &Laid) -> Result<Vec<f64>, ModelFailure> {
        Ok(open(self.answer_made(made, laid)?)?.ratio)
    }

    /// What the model alone says of `made`, a sample of what was `laid`, at every condition, whether or not its cavities close.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the sample cannot be computed.
    pub fn answer_made(&self, made: &Pattern, laid: &Laid) -> Result<Answer, ModelFailure> {
        Ok(self.answer(&self.asked, &self.solver, made)?.on(laid, made))
    }

    /// As [`Self::ratios_made`], kept for the next who asks.
    ///
    /// # Errors
    /// As there.
    pub fn ratios_kept(&self, made: &Pattern, laid: &Laid) -> Result<Vec<f64>, ModelFailure> {
        Ok(open(self.kept(&self.asked, &self.solver, made)?)?.on(laid, made).ratio)
    }

    /// What the model alone says of `design` at every condition: not corrected, not kept.
    ///
    /// # Errors
    /// [`ModelFailure::Trial`] where the design cannot be computed.
    pub fn steady(&self, design: &Pattern) -> Result<Answer, ModelFailure> {
        open(self.answer_made(design, &self.lay(design)?)?)
    }

    /// Largest local pressure of `design` at each load of each condition, in pascals.
    ///
    /// # Errors
    /// [`ModelFailure`] where the design cannot be computed.
    pub fn peak_pressures_pa(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        Ok(self.solver.solve(design, self.monitor)?.iter().map(|outcome| outcome.surface.peak_pressure_pa).collect())
    }

    /// The same material and loads in the vertical plane, without limits.
    #[must_use]
    pub fn in_plane(&self) -> Self {
        let (mut scene, mut asked) = (self.scene.clone(), self.asked.clone());
        (scene.run.dimensions, asked.run.dimensions) = (Some(2), Some(2));
        self.of_scenes(scene, asked)
    }

    /// The same without a guide: [`Self::beside`] it, designs are solved in the blocks asked for. `None` where it has none.
    #[must_use]
    pub fn without_guide(&self) -> Option<Self> {
        self.guide.as_ref().map(|_| self.of_scenes(self.scene.clone(), self.asked.clone()))
    }

    /// The model of `scene` and of `asked`, the same with the loads of every condition, without guide, correction and limits.
    fn of_scenes(&self, scene: Scene, asked: Scene) -> Self {
        Self {
            solver: Solver::new(&asked, &self.texture, &self.directions_deg),
            texture: self.texture,
            directions_deg: self.directions_deg.clone(),
            guide: None,
            flat_mu: self.flat_mu.clone(),
            learned: self.learned.clone(),
            correction: BetweenDesigns::default(),
            limited: Limited::default(),
            evaluations: Evaluations::default(),
            monitor: self.monitor,
            specimen: self.specimen,
            scene,
            asked,
        }
    }

    /// The model that slopes are taken of, of the scene that `change` makes of this one's with the loads of every condition:
    /// in space in the guide's blocks, by which slopes are a fifth off, unless rims are narrower. Its values are ratios.
    ///
    /// # Errors
    /// Those of `change`.
    pub fn beside<E>(&self, change: impl FnOnce(&Scene) -> Result<Scene, E>) -> Result<Self, E> {
        let asked = change(self.serving_guide().unwrap_or(&self.asked))?;
        Ok(Self { flat_mu: None, learned: None, ..self.of_scenes(asked.clone(), asked) })
    }

    /// The guide's scene where there is one and its blocks serve the rims, too: these need blocks of at most half their width.
    fn serving_guide(&self) -> Option<&Scene> {
        let serves = |scene: &&Scene| self.texture.rim().is_none_or(|rim| 2.0 * scene.layer.block_m <= rim.width_m());
        self.guide.as_ref().map(|(scene, _)| scene).filter(serves)
    }

    /// What a ratio is multiplied by at `load`, of all conditions one after the other, before it is compared with the target: the
    /// flat sample's dynamic friction where that is wanted. Beside it stands the discrepancy's factor.
    #[must_use]
    pub fn scale(&self, load: usize) -> f64 {
        self.flat_mu.as_ref().map_or(1.0, |flat_mu| flat_mu[load])
    }

    /// What values of `design` are multiplied by at every load of every condition: the discrepancy's median where designs aim with
    /// it and the model has an answer, 1 otherwise.
    #[must_use]
    pub fn factors(&self, design: &Pattern) -> Vec<f64> {
        self.known_factors(design).unwrap_or_else(|_| vec![1.0; self.asked.loads.len()])
    }

    fn known_factors(&self, design: &Pattern) -> Result<Vec<f64>, ModelFailure> {
        Ok(self.factors_of(design, &self.kept(&self.asked, &self.solver, design)?))
    }

    /// What ratios of `design` are multiplied by before they are compared with the target: scales times factors.
    #[must_use]
    pub fn scales(&self, design: &Pattern) -> Vec<f64> {
        self.factors(design).iter().enumerate().map(|(load, factor)| factor * self.scale(load)).collect()
    }

    /// The discrepancy's medians at `design`, of which the model says `answer`; 1 where designs do not aim with it.
    fn factors_of(&self, design: &Pattern, answer: &Answer) -> Vec<f64> {
        let ones = || vec![1.0; self.asked.loads.len()];
        self.learned.as_ref().map_or_else(ones, |learned| learned.factors(design, &answer.modulus_sensitivity))
    }

    /// The area law that designs are solved with.
    #[must_use]
    pub const fn area_law(&self) -> Option<&AreaLaw> {
        self.scene.area_law.as_ref()
    }

    /// The response of `made`, a sample of what was `designed`: as many cavities lie on it.
    ///
    /// # Errors
    /// As [`ForwardModel::respond`].
    pub fn respond_made(&self, made: &Pattern, designed: &Pattern) -> Result<Response, ModelFailure> {
        self.ask(&self.asked, &self.solver, (made, designed))
    }

    /// What `solver`, made of `scene`, says of `design`, corrected, with the cavities that lie on a sample of what was `designed`.
    fn ask(
        &self,
        scene: &Scene,
        solver: &Solver,
        (design, designed): (&Pattern, &Pattern),
    ) -> Result<Response, ModelFailure> {
        if self.monitor.cancelled() {
            return Err(ModelFailure::Cancelled);
        }
        self.limited.check(design)?;
        let answer = self.kept(scene, solver, design)?.on(&self.lay(designed)?, design);
        if answer.clearance_m().is_some_and(|clearance_m| clearance_m <= 0.0) && !self.limited.judges_clearance() {
            return Err(ModelFailure::Trial { reason: "the cavity closes under load".to_owned() });
        }
        let correction = self.correction_of(designed);
        let corrected =
            |((load, ratio), share): ((usize, &f64), f64)| (ratio + share * texture_effect(*ratio)) * self.scale(load);
        let physics: Vec<f64> = answer.ratio.iter().enumerate().zip(correction).map(corrected).collect();
        let limited = self.limited.values(design, &answer)?;
        let value =
            physics.iter().zip(self.factors_of(design, &answer)).map(|(value, factor)| value * factor).collect();
        Ok(Response { value, limited })
    }

    /// Difference of the specimen of `design` from its cell over [`texture_effect`], interpolated between earlier designs, at each load of
    /// each condition.
    fn correction_of(&self, design: &Pattern) -> Vec<f64> {
        self.correction.at(design).unwrap_or_else(|| vec![0.0; self.asked.loads.len()])
    }

    /// What `solver`, made of `scene`, says of `design`, kept for the next who asks; with slopes along the modulus where designs aim
    /// with the discrepancy.
    fn kept(&self, scene: &Scene, solver: &Solver, design: &Pattern) -> Result<Answer, ModelFailure> {
        let solve = || {
            let answer = self.answer(scene, solver, design)?;
            let Some(learned) = &self.learned else { return Ok(answer) };
            Ok(Answer { modulus_sensitivity: learned.modulus_sensitivity(design)?, ..answer })
        };
        // What is kept goes by the lengths alone: samples whose rims are of another height are not.
        let has_own_rims = design.texture().rim() == self.texture.rim();
        if has_own_rims { self.evaluations.answer(scene.layer.block_m, design, solve) } else { solve() }
    }

    /// What `solver`, made of `scene`, says of `design`.
    fn answer(&self, scene: &Scene, solver: &Solver, design: &Pattern) -> Result<Answer, ModelFailure> {
        let trial = |reason: String| ModelFailure::Trial { reason };
        let scene = Scene { pattern: Some(*design), ..scene.clone() };
        scene.validate().map_err(|error| trial(error.to_string()))?;
        let mut ratio = Vec::new();
        let (mut peak_pressure_pa, mut least_pressure) = (0.0_f64, f64::INFINITY);
        let mut clearance_m: Option<f64> = None;
        for (outcome, load) in solver.solve(design, self.monitor)?.iter().zip(&scene.loads) {
            let surface = &outcome.surface;
            if surface.status != Status::Converged {
                return Err(trial(match surface.status {
                    Status::NotConverged => "the steady solution was not found in the steps allowed".to_owned(),
                    other => format!("steady run: {}", other.name()),
                }));
            }
            ratio.push(outcome.ratio.ok_or_else(|| trial("friction is not defined".to_owned()))?);
            peak_pressure_pa = peak_pressure_pa.max(surface.peak_pressure_pa);
            let least_pa = surface.interface.iter().map(|point| point.pressure_pa).fold(f64::INFINITY, f64::min);
            least_pressure = least_pressure.min(least_pa / load.pressure_pa);
            clearance_m = [clearance_m, surface.clearance_m].into_iter().flatten().reduce(f64::min);
        }
        let (peak_pressure_mpa, clearance_um) = (peak_pressure_pa / 1e6, clearance_m.map(|least_m| least_m * 1e6));
        Ok(Answer { ratio, peak_pressure_mpa, least_pressure, clearance_um, modulus_sensitivity: Vec::new() })
    }
}

/// Least effect of a texture on the ratio that corrections are taken to grow with: below it a run's own error would be blown up.
const LEAST_EFFECT: f64 = 0.02;

/// 1 - R, and at least [`LEAST_EFFECT`] either way. Ends, tilt and time act on what the texture does: a specimen without cavities has a ratio of 1
/// in time, too, so a sparse texture differs less from its cell than a dense one.
fn texture_effect(ratio: f64) -> f64 {
    let effect = 1.0 - ratio;
    effect.abs().max(LEAST_EFFECT).copysign(effect)
}

/// The answer of a design whose cavities stay open.
fn open(answer: Answer) -> Result<Answer, ModelFailure> {
    if answer.clearance_m().is_some_and(|clearance_m| clearance_m <= 0.0) {
        return Err(ModelFailure::Trial { reason: "the cavity closes under load".to_owned() });
    }
    Ok(answer)
}

impl ForwardModel for SteadyModel<'_> {
    fn respond(&self, design: &Pattern) -> Result<Response, ModelFailure> {
        self.ask(&self.asked, &self.solver, (design, design))
    }
}

#[cfg(test)]
mod tests;
