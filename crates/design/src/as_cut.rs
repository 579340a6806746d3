//! A texture as its samples are cut, as far as it is known: by the table, by the model itself, or with ends, tilt and time of its own.

use std::sync::Arc;

use slipgrid_discrepancy::{Candidate, DimensionShift, Features, Sensitivity};
use slipgrid_export::Specimen;
use slipgrid_monitor::{Monitor, Part as Share};
use slipgrid_pattern::Pattern;
use slipgrid_specimen::{SteadyOnFace, nearest_known, time_changes_on};
use slipgrid_springblock::{RunOptions, Scene, Simulation};

use crate::inputs::{Effect, Part};
use crate::steady_model::SteadyModel;
use crate::table::Modelled;

/// Blocks that lands and cavities keep where larger ones serve.
const MIN_BLOCKS: f64 = 2.0;

/// How a texture is known, each better than the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Known {
    /// By the table.
    Interpolated,
    /// By the model itself in blocks as small as it can have, with everything that is not known exactly.
    Solved,
    /// With ends and tilt of its own, in the plane with its own run in time.
    AsCut,
}

/// A texture as its samples are cut.
#[derive(Clone, Debug)]
pub struct CutTexture {
    pub pattern: Pattern,
    pub features: Features,
    pub known: Known,
    /// Modelled ratio at each load.
    pub ratio: Vec<f64>,
    /// How ln R follows what all textures have in common, at each load.
    pub sensitivity: Vec<Sensitivity>,
    /// Covariance of ln R that all samples share beside the discrepancy, loads x loads; empty where that is not known.
    pub covariance: Vec<f64>,
    /// Errors that each sample has of its own.
    pub dimension_shifts: Vec<DimensionShift>,
    /// What these are made of; none by the table.
    pub parts: Vec<Part>,
    /// How far it is beyond the limits, relative to them: 0 where it keeps them all.
    pub excess: f64,
    /// Its run in time, where it had one.
    pub run: Option<Arc<Simulation>>,
}

impl CutTexture {
    /// By the table, with errors of dimensions alone.
    pub fn interpolated(pattern: Pattern, modelled: Modelled, dimension_shifts: Vec<DimensionShift>) -> Self {
        Self {
            features: Features::from(&pattern),
            pattern,
            known: Known::Interpolated,
            ratio: modelled.log_ratio.iter().map(|log| log.exp()).collect(),
            sensitivity: modelled.sensitivity,
            covariance: Vec::new(),
            dimension_shifts,
            parts: Vec::new(),
            excess: 0.0,
            run: None,
        }
    }

    /// The same with what is known of its inputs.
    pub fn with_parts(mut self, parts: Vec<Part>) -> Self {
        (self.covariance, self.dimension_shifts) = sums(&parts, None);
        self.parts = parts;
        self
    }

    /// The same with what else moves the logarithms of its ratios.
    pub fn moved(mut self, by: &[f64]) -> Self {
        self.ratio.iter_mut().zip(by).for_each(|(ratio, by)| *ratio *= by.exp());
        self
    }

    /// What the discrepancy is asked with.
    pub fn candidate(&self) -> Candidate<'_> {
        Candidate {
            features: self.features,
            modelled: &self.ratio,
            sensitivity: &self.sensitivity,
            covariance: &self.covariance,
            dimension_shifts: &self.dimension_shifts,
        }
    }
}

/// The covariance of all `parts` that samples share, and the errors that they have of their own, without those of the part at the place `without`.
pub fn sums(parts: &[Part], without: Option<usize>) -> (Vec<f64>, Vec<DimensionShift>) {
    let (mut covariance, mut shifts) = (Vec::new(), Vec::new());
    for (_, part) in parts.iter().enumerate().filter(|(place, _)| Some(*place) != without) {
        match &part.effect {
            Effect::Shared(own) if covariance.is_empty() => covariance.clone_from(own),
            Effect::Shared(own) => covariance.iter_mut().zip(own).for_each(|(sum, own)| *sum += own),
            Effect::OfSample(shift) => shifts.push(shift.clone()),
        }
    }
    (covariance, shifts)
}

/// Differences of samples from their cells: ends of strips, tilt of the pressure, and sliding in time, of each texture by itself.
pub struct BeyondCells<'a> {
    pub model: &'a SteadyModel<'a>,
    /// Face of the specimen; `None` where samples are sectors of one.
    pub face: Option<Specimen>,
    /// Loads of the first condition; those of others are taken to differ as these.
    pub count: usize,
    pub seed: u64,
}

impl BeyondCells<'_> {
    /// The cell of `pattern` at the loads of the first condition.
    fn scene(&self, pattern: &Pattern) -> Scene {
        let mut scene = self.model.cell(pattern, false);
        scene.loads.truncate(self.count);
        scene
    }

    /// Change of the logarithm of each of `ratios` by `run`, the specimen in time; `None` where that has a load without a ratio.
    pub fn by_run(&self, ratios: &[f64], run: &Simulation) -> Option<Vec<f64>> {
        let of_run: Vec<f64> =
            run.loads.iter().map(|load| load.ratio.filter(|_| load.is_trusted())).collect::<Option<_>>()?;
        (of_run.len() == self.count).then(|| self.log_shifts(ratios, &|load| of_run[load] - ratios[load]))
    }

    /// Change of the logarithm of each of `ratios`, one a load of every condition, by what is `added` to those of the first.
    fn log_shifts(&self, ratios: &[f64], added: &dyn Fn(usize) -> f64) -> Vec<f64> {
        let shift = |(load, ratio): (usize, &f64)| (added(load % self.count) / ratio).max(-0.5).ln_1p();
        ratios.iter().enumerate().map(shift).collect()
    }

    /// Change of the logarithms of `ratios` of `pattern` by ends and tilt; zeros without a face, and where strips are too large to solve.
    /// Roughly where many are compared.
    pub fn by_face(&self, pattern: &Pattern, ratios: &[f64], is_rough: bool, monitor: &dyn Monitor) -> Vec<f64> {
        let solve = if is_rough { SteadyOnFace::roughly } else { SteadyOnFace::new };
        let part = Share::new(monitor, 0.0);
        let mut scene = self.scene(pattern);
        // What ends and tilt add hardly depends on the blocks, as long as lands and cavities have two of them.
        let (coarse_m, rows) = (2.0 * scene.layer.block_m, scene.layer.rows());
        let least_m = pattern.width_m().min(pattern.spacing_m());
        if is_rough && rows.is_multiple_of(2) && least_m >= MIN_BLOCKS * coarse_m {
            scene.layer.block_m = coarse_m;
        }
        let on_face = self.face.as_ref().and_then(|face| solve(&scene, pattern, face, &part).ok());
        self.log_shifts(ratios, &|load| on_face.as_ref().and_then(|on_face| on_face.added(load)).unwrap_or(0.0))
    }

    /// Change of the logarithms of `ratios` of `pattern` by sliding in time; none in space, and where a run gives none.
    pub fn by_time(&self, pattern: &Pattern, ratios: &[f64], monitor: &dyn Monitor) -> Vec<f64> {
        let scene = self.scene(pattern);
        let timed = Scene {
            pattern: Some(pattern.with_rim(None)),
            run: RunOptions { seed: self.seed, ..scene.run },
            ..scene.clone()
        };
        let changes = time_changes_on(&timed, self.face.as_ref(), &Share::new(monitor, 0.0)).ok();
        let known = changes.and_then(|changes| nearest_known(&changes, &scene.loads));
        known.map_or_else(Vec::new, |changes| self.log_shifts(ratios, &|load| changes[load]))
    }
}
