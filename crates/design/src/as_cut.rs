//! Texture as its samples are cut, at one of three accuracies: interpolated, solved, or solved together with the
//! effects of the specimen's ends, pressure tilt and time for this texture.

use std::sync::Arc;

use slipgrid_base::monitor::{Monitor, Part as Share};
use slipgrid_infer::discrepancy::{Candidate, DimensionShift, Features, Sensitivity};
use slipgrid_laser::export::Specimen;
use slipgrid_laser::specimen::{SteadyOnFace, layout_errors, nearest_known, time_changes_on};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{RunOptions, Scene, Simulation};

use crate::evaluation_cache::Answer;
use crate::inputs::{InputEffect, Part};
use crate::sensitivities::Modelled;
use crate::steady_model::SteadyModel;

/// Larger blocks are used only if lands and cavities are at least this number of larger blocks wide.
const MIN_BLOCKS: f64 = 2.0;

/// Accuracy of the data of a texture, in increasing order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Known {
    /// Interpolated in the table.
    Interpolated,
    /// Solved by the model in the smallest affordable blocks, with all input uncertainties.
    Solved,
    /// Solved also with the effects of the specimen's ends and pressure tilt for this texture, in two-dimensional
    /// models by a dynamic run.
    AsCut,
}

/// Texture as its samples are cut, with ratios, sensitivities and errors.
#[derive(Clone, Debug)]
pub struct CutTexture {
    pub pattern: Pattern,
    pub features: Features,
    pub known: Known,
    /// Modelled ratio at each load.
    pub ratio: Vec<f64>,
    /// Sensitivity of ln R, R the ratio, at each load to inputs that all textures share.
    pub sensitivity: Vec<Sensitivity>,
    /// Covariance of ln R between loads from errors that all samples share, without the discrepancy: n by n matrix for
    /// n loads, row by row; empty if unknown.
    pub covariance: Vec<f64>,
    /// Errors that are independent between samples, with the resulting changes of ln R.
    pub dimension_shifts: Vec<DimensionShift>,
    /// Inputs that the covariance and the shifts are composed of; empty if interpolated.
    pub parts: Vec<Part>,
    /// Model's answer that limits are compared with: that of the cell, with the peak pressure of the specimen's run where
    /// this is higher, and without ratios if interpolated. `None` before limits were compared.
    pub limited: Option<Answer>,
    /// Sum of the violations of limits by `limited`, each relative to its limit: 0 if all limits hold.
    pub excess: f64,
    /// Dynamic run of this texture; `None` if it was not run.
    pub run: Option<Arc<Simulation>>,
}

impl CutTexture {
    /// Builds a texture from the table, with errors of dimensions alone.
    pub fn interpolated(pattern: Pattern, modelled: Modelled, dimension_shifts: Vec<DimensionShift>) -> Self {
        Self {
            features: Features::on_face(&pattern, modelled.face_share),
            pattern,
            known: Known::Interpolated,
            ratio: modelled.log_ratio.iter().map(|log| log.exp()).collect(),
            sensitivity: modelled.sensitivity,
            covariance: Vec::new(),
            dimension_shifts,
            parts: Vec::new(),
            limited: None,
            excess: 0.0,
            run: None,
        }
    }

    /// Adds the input uncertainties `parts`.
    pub fn with_parts(mut self, parts: Vec<Part>) -> Self {
        (self.covariance, self.dimension_shifts) = sums(&parts, None);
        self.parts = parts;
        self
    }

    /// Adds the elements of `by` to the logarithms of the ratios; an empty `by` changes nothing.
    pub fn moved(mut self, by: &[f64]) -> Self {
        self.ratio.iter_mut().zip(by).for_each(|(ratio, by)| *ratio *= by.exp());
        self
    }

    /// Borrows the data from which a predictor computes the discrepancy of the texture.
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

/// Sums up `parts` without the part at index `without`: returns the covariance of ln R from errors that all samples
/// share, and the errors that are independent between samples.
pub fn sums(parts: &[Part], without: Option<usize>) -> (Vec<f64>, Vec<DimensionShift>) {
    let (mut covariance, mut shifts) = (Vec::new(), Vec::new());
    for (_, part) in parts.iter().enumerate().filter(|(place, _)| Some(*place) != without) {
        match &part.effect {
            InputEffect::Shared(own) if covariance.is_empty() => covariance.clone_from(own),
            InputEffect::Shared(own) => covariance.iter_mut().zip(own).for_each(|(sum, own)| *sum += own),
            InputEffect::OfSample(shift) => shifts.push(shift.clone()),
        }
    }
    (covariance, shifts)
}

/// Computes the differences in friction ratio between samples of a texture and its periodic cell: effects of the
/// specimen's ends, of pressure tilt and of sliding in time.
pub struct BeyondCells<'a> {
    pub model: &'a SteadyModel<'a>,
    /// Face of the specimen; `None` if samples are sectors of one specimen.
    pub face: Option<Specimen>,
    /// Number of loads of the first condition; changes of the ratio at other conditions are assumed equal.
    pub count: usize,
    /// Seed of the local coefficients.
    pub seed: u64,
}

impl BeyondCells<'_> {
    /// Cell of `pattern` at the loads of the first condition.
    fn scene(&self, pattern: &Pattern) -> Scene {
        let mut scene = self.model.cell(pattern, false);
        scene.loads.truncate(self.count);
        scene
    }

    /// Change of the logarithm of each of `ratios`, those of the cell, by the difference of ratios between `run`, a
    /// dynamic run of the specimen, and the cell; `None` unless the run has a trusted ratio at every load of the first
    /// condition.
    pub fn by_run(&self, ratios: &[f64], run: &Simulation) -> Option<Vec<f64>> {
        let of_run: Vec<f64> =
            run.loads.iter().map(|load| load.ratio().filter(|_| load.is_trusted())).collect::<Option<_>>()?;
        (of_run.len() == self.count).then(|| self.log_shifts(ratios, &|load| of_run[load] - ratios[load]))
    }

    /// Change of the logarithm of each of `ratios`, one per load of every condition, if `added(load)` is added to the
    /// ratio at load number `load`, counted from 0, of every condition.
    fn log_shifts(&self, ratios: &[f64], added: &dyn Fn(usize) -> f64) -> Vec<f64> {
        let shift = |(load, ratio): (usize, &f64)| (added(load % self.count) / ratio).max(-0.5).ln_1p();
        ratios.iter().enumerate().map(shift).collect()
    }

    /// Change of the logarithms of `ratios` of `pattern` by the specimen's ends and pressure tilt; zeros without a face
    /// or if strips are too large to solve. `is_rough` uses larger blocks, for comparisons of many textures.
    pub fn by_face(&self, pattern: &Pattern, ratios: &[f64], is_rough: bool, monitor: &dyn Monitor) -> Vec<f64> {
        let part = Share::new(monitor, 0.0);
        let mut scene = self.scene(pattern);
        // This change hardly depends on the block size if lands and cavities have at least two blocks.
        let (coarse_m, rows) = (2.0 * scene.layer.block_m, scene.layer.rows());
        let least_m = pattern.width_m().min(pattern.spacing_m());
        if is_rough && rows.is_multiple_of(2) && least_m >= MIN_BLOCKS * coarse_m {
            scene.layer.block_m = coarse_m;
        }
        let solve = |face| SteadyOnFace::new(&scene, pattern, face, is_rough, &part).ok();
        let on_face = self.face.as_ref().and_then(solve);
        self.log_shifts(ratios, &|load| on_face.as_ref().and_then(|on_face| on_face.added(load)).unwrap_or(0.0))
    }

    /// Standard deviations of the logarithms of `ratios`, those of the cell, by the layout in space, where a row of
    /// cavities at the border differs from one of an infinite pattern; empty if unknown.
    pub fn layout_log_stds(&self, pattern: &Pattern, ratios: &[f64], monitor: &dyn Monitor) -> Vec<f64> {
        let part = Share::new(monitor, 0.0);
        let of_face = |face| layout_errors(&self.scene(pattern), face, pattern, &part).ok();
        let errors = self.face.as_ref().and_then(of_face).unwrap_or_default();
        errors.iter().zip(ratios).map(|(error, ratio)| error.unwrap_or(0.0) / ratio).collect()
    }

    /// Change of the logarithms of `ratios` of `pattern` by sliding in time; empty, as no change, in space and if the
    /// run gives no ratio.
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
