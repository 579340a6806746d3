//! Modelled friction of patterned samples at the measured conditions: steady cells, the correction for the specimen if
//! it is known, and the correction from steady to dynamic sliding.

use std::sync::Arc;

use rayon::prelude::*;
use slipgrid_base::monitor::{Monitor, Part};
use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_laser::export::Specimen;
use slipgrid_laser::specimen::{SpecimenError, SteadyOnFace, nearest_known, time_changes_on};
use slipgrid_model::material::{AreaLaw, Condition, Elastic, LocalFriction, MaterialError};
use slipgrid_model::pattern::{Pattern, ReliefMap};
use slipgrid_model::springblock::{Layer, Load, RunOptions, Scene, steady_ratios};
use slipgrid_surface::contact::AreaPoint;

use crate::calibrate::area_law::area_law;
use crate::calibrate::select_measurements::by_condition;
use crate::calibrate::uncertainty::{flat_friction, local_law, local_law_changes};
use crate::calibrate::{CalibrationError, CalibrationTask, CutSpecimen, Measurement};

/// Step of ln E, with Young's modulus E, for derivatives of ratios: small against the error of the modulus, large
/// against rounding errors.
const LOG_MODULUS_STEP: f64 = 0.02;

/// Measurements on a flat and on a patterned sample, in this order, at equal force, speed and humidity.
pub(crate) type Pair = [Measurement; 2];

/// Modelled ratio and d ln(ratio) / d ln(E), with Young's modulus E; `None` if the load did not converge.
pub(crate) type Sensitive = Option<[f64; 2]>;

/// Pairs each measurement in `patterned` with the measurement on a flat sample at equal force, speed and humidity;
/// those without a counterpart are dropped.
pub(crate) fn pair_measurements(task: &CalibrationTask, patterned: &[Measurement]) -> Vec<Pair> {
    let pair = |patterned: &Measurement| Some([*task.flat.iter().find(|flat| flat.is_at(patterned))?, *patterned]);
    patterned.iter().filter_map(pair).collect()
}

/// Warning for samples without the correction from steady to dynamic sliding.
const TIME_CHANGE_UNKNOWN: &str = "its modelled ratios lack what sliding in time adds, some thousandths";
/// Warning for dynamic runs without a stationary mean.
const NO_MEAN_IN_TIME: &str = "in time the sample does not slide to a mean";

/// Change of a sample's friction ratios from steady sliding to a dynamic run; 0 where the change is not known, for
/// example in three dimensions.
pub(crate) struct TimeChanges {
    /// Change of the ratio, one per pair of measurements.
    pub at: Vec<f64>,
    /// Warning if the change is not known at a load; `None` otherwise.
    pub unknown: Option<String>,
}

/// Model of a patterned sample.
pub(crate) struct Model<'a> {
    pub task: &'a CalibrationTask,
    /// The area law, and the contact area from which it is computed if it depends on the modulus (empty otherwise).
    pub law: (Option<&'a AreaLaw>, &'a [AreaPoint]),
    pub pattern: Pattern,
    pub relief: Option<Arc<ReliefMap>>,
    /// Specimen into which the sample was cut.
    pub specimen: CutSpecimen,
}

impl Model<'_> {
    /// Modelled ratio of each pair, corrected for the face by `on_face`, or for an infinite pattern without `on_face`;
    /// `None` if the load did not converge.
    pub fn ratios(
        &self,
        pairs: &[Pair],
        on_face: Option<&SteadyOnFace>,
        monitor: &dyn Monitor,
    ) -> Result<Vec<Option<f64>>, CalibrationError> {
        Ok(self.apply_face(&self.cells(0.0, pairs, monitor)?, on_face))
    }

    /// Modelled ratios with their derivatives d ln(ratio) / d ln(E), on the face if the specimen has one. Also returns
    /// the correction for the face.
    pub fn sensitive_ratios(
        &self,
        pairs: &[Pair],
        monitor: &dyn Monitor,
    ) -> Result<(Vec<Sensitive>, Option<SteadyOnFace>), CalibrationError> {
        let third = Part::new(monitor, 1.0 / 3.0);
        let steps = [-LOG_MODULUS_STEP, 0.0, LOG_MODULUS_STEP];
        let (on_face, cells) = rayon::join(
            || self.face_correction(pairs, &Part::new(monitor, 0.0)),
            || steps.par_iter().map(|&step| self.cells(step, pairs, &third)).collect::<Result<Vec<_>, _>>(),
        );
        let on_face = on_face?;
        let all: Vec<Vec<Option<f64>>> = cells?.iter().map(|cells| self.apply_face(cells, on_face.as_ref())).collect();
        let at = |i: usize| {
            let sensitivity = (all[2][i]?.ln() - all[0][i]?.ln()) / (2.0 * LOG_MODULUS_STEP);
            Some([all[1][i]?, sensitivity])
        };
        Ok(((0..pairs.len()).map(at).collect(), on_face))
    }

    /// Changes of the logarithm of the `ratios` of `pairs` if the local coefficient follows the local pressure, as
    /// [`local_law_changes`] gives them for a face of the share `face_share`. 0 where flat friction at the condition
    /// follows the area law.
    pub fn local_law_changes(
        &self,
        pairs: &[Pair],
        (ratios, face_share): (&[f64], f64),
    ) -> Result<Vec<f64>, CalibrationError> {
        let mut found = vec![0.0; pairs.len()];
        let (Some(area_law), false) = (self.law.0, self.law.1.is_empty()) else { return Ok(found) };
        let flat = flat_friction(self.task);
        let conditions = by_condition(pairs.iter().enumerate().map(|(place, [own, _])| (own.condition(), place)));
        let changes = |(condition, places): &(Condition, Vec<usize>)| -> Result<Vec<(usize, f64)>, CalibrationError> {
            let Some(law) = local_law(area_law, &flat, Some(condition)) else { return Ok(Vec::new()) };
            let own: Vec<Pair> = places.iter().map(|place| pairs[*place]).collect();
            let scene = self.scene(self.task.elastic, Some(area_law.clone()), &own)?;
            let Some(scene) = scene else { return Ok(Vec::new()) };
            let ratios: Vec<f64> = places.iter().map(|place| ratios[*place]).collect();
            let changes = local_law_changes(&scene, &self.pattern, &law, (&ratios, face_share));
            Ok(places.iter().copied().zip(changes).collect())
        };
        let all = conditions.par_iter().map(changes).collect::<Result<Vec<_>, _>>()?;
        all.into_iter().flatten().for_each(|(place, change)| found[place] = change);
        Ok(found)
    }

    /// Ratios of infinite patterns, with Young's modulus multiplied by exp(log_modulus); `None` where a load did not
    /// converge.
    fn cells(
        &self,
        log_modulus: f64,
        pairs: &[Pair],
        monitor: &dyn Monitor,
    ) -> Result<Vec<Option<f64>>, CalibrationError> {
        let (law, curve) = self.law;
        let law = match law {
            None => None,
            // A measured law does not depend on the modulus.
            Some(law) if curve.is_empty() => Some(law.clone()),
            Some(law) => Some(law_at_modulus(curve, log_modulus, self.task.threshold_pa, law.pressures_pa()[0])?),
        };
        let elastic = self.task.elastic.at_modulus(log_modulus.exp())?;
        let Some(scene) = self.scene(elastic, law, pairs)? else { return Ok(Vec::new()) };
        Ok(steady_ratios(&scene, monitor)?)
    }

    /// Applies the correction for the specimen to the ratios `cells`.
    fn apply_face(&self, cells: &[Option<f64>], on_face: Option<&SteadyOnFace>) -> Vec<Option<f64>> {
        let Some(on_face) = on_face else { return cells.to_vec() };
        cells.iter().enumerate().map(|(place, cell)| on_face.ratio((*cell)?, &self.pattern, place)).collect()
    }

    /// Computes the correction that takes ratios of infinite patterns to the face of the specimen, at `pairs`; `None`
    /// without a face or without pairs.
    fn face_correction(&self, pairs: &[Pair], monitor: &dyn Monitor) -> Result<Option<SteadyOnFace>, CalibrationError> {
        let Some((face, scene, pattern)) = self.strips(pairs)? else { return Ok(None) };
        Ok(Some(SteadyOnFace::new(&scene, &pattern, face, false, monitor)?))
    }

    /// Memory, in bytes, that [`Self::face_correction`] takes.
    pub fn face_bytes(&self, pairs: &[Pair]) -> Result<f64, CalibrationError> {
        let Some((face, scene, pattern)) = self.strips(pairs)? else { return Ok(0.0) };
        SteadyOnFace::bytes(&scene, &pattern, face).map_err(|error| match error {
            SpecimenError::Scene(error) => error.into(),
            error => error.into(),
        })
    }

    /// Face of the specimen, with the scene and the pattern of its strips at `pairs`; `None` without a face or without
    /// pairs.
    fn strips(&self, pairs: &[Pair]) -> Result<Option<(&Specimen, Scene, Pattern)>, CalibrationError> {
        let Some(face) = &self.specimen.face else { return Ok(None) };
        let flat = self.without_rims();
        let own = if self.pattern.texture().is_one_section() { &flat } else { self };
        Ok(own.face_scene(pairs)?.map(|scene| (face, scene, own.pattern)))
    }

    /// The model without rims and relief, for which strips can be solved; only the ratio of the cell includes the
    /// effect of rims.
    fn without_rims(&self) -> Self {
        Self { pattern: self.pattern.with_rim(None), relief: None, ..*self }
    }

    /// Scene for the face, in blocks of the task's layer: neither tilt nor dynamics needs blocks as small as rims do.
    /// `None` without pairs.
    fn face_scene(&self, pairs: &[Pair]) -> Result<Option<Scene>, CalibrationError> {
        let mut scene = self.scene(self.task.elastic, self.law.0.cloned(), pairs)?;
        scene.iter_mut().for_each(|scene| scene.layer.block_m = self.task.layer.block_m);
        Ok(scene)
    }

    /// Change of the ratio of each pair from steady sliding to a dynamic run, on the face or for an infinite pattern.
    /// There is one run per force, at the mean of flat friction, because the dependence on friction is below the error
    /// of the run. The pattern is run without rims.
    pub fn time_changes(&self, pairs: &[Pair], monitor: &dyn Monitor) -> Result<TimeChanges, CalibrationError> {
        let task = self.task;
        let mut forces_n: Vec<f64> = pairs.iter().map(|[flat, _]| flat.force_n).collect();
        forces_n.sort_by(f64::total_cmp);
        forces_n.dedup();
        let at_mean = |force_n: &f64| {
            let alike: Vec<&Measurement> =
                pairs.iter().map(|[flat, _]| flat).filter(|flat| flat.force_n == *force_n).collect();
            let mu_dynamic = alike.iter().map(|flat| flat.mu_dynamic).sum::<f64>() / alike.len() as f64;
            let mean = Measurement { mu_dynamic, ..*alike[0] };
            [mean, mean]
        };
        let means: Vec<Pair> = forces_n.iter().map(at_mean).collect();
        let nothing = |unknown| TimeChanges { at: vec![0.0; pairs.len()], unknown };
        let Some(mut scene) = self.without_rims().face_scene(&means)? else { return Ok(nothing(None)) };
        scene.run = RunOptions { seed: task.seed, ..RunOptions::default() };
        let static_share = task.local_static_over_dynamic();
        for load in &mut scene.loads {
            let dynamic_mu = load.friction.dynamic_mean();
            load.friction = LocalFriction::new(static_share * dynamic_mu, dynamic_mu, task.relative_std)?;
        }
        if !scene.dimension().takes_strips() {
            return Ok(nothing(None));
        }
        let added = match time_changes_on(&scene, self.specimen.face.as_ref(), monitor) {
            Ok(added) => added,
            Err(error) => return Ok(nothing(Some(format!("{TIME_CHANGE_UNKNOWN}: {error}")))),
        };
        let Some(known) = nearest_known(&added, &scene.loads) else {
            return Ok(nothing(Some(format!("{TIME_CHANGE_UNKNOWN}: {NO_MEAN_IN_TIME} at any pressure"))));
        };
        let without = scene.loads.iter().zip(&added).filter(|(_, added)| added.is_none());
        let without: Vec<String> =
            without.map(|(load, _)| format!("{:.3}", PRESSURE_MPA.from_si(load.pressure_pa))).collect();
        let unknown = (!without.is_empty()).then(|| {
            let at = without.join(" and ");
            format!("{NO_MEAN_IN_TIME} at {at} MPa: what sliding in time adds there is taken from the nearest other pressure")
        });
        let at = |[flat, _]: &Pair| {
            let place = forces_n.iter().position(|force_n| *force_n == flat.force_n);
            place.map_or(0.0, |place| known[place])
        };
        Ok(TimeChanges { at: pairs.iter().map(at).collect(), unknown })
    }

    /// Scene of the sample's steady cells at the loads of `pairs`, with the flat surface at its measured friction;
    /// `None` without pairs.
    fn scene(
        &self,
        elastic: Elastic,
        area_law: Option<AreaLaw>,
        pairs: &[Pair],
    ) -> Result<Option<Scene>, CalibrationError> {
        let Some([first, _]) = pairs.first() else { return Ok(None) };
        let task = self.task;
        let load = |[flat, _]: &Pair| {
            let pressure_pa = task.pressure_pa(flat);
            // A flat cell slides at mu_flat = mu_d f(P).
            let mean = flat.mu_dynamic / area_law.as_ref().map_or(1.0, |law| law.factor(pressure_pa));
            Ok(Load { pressure_pa, friction: LocalFriction::new(mean, mean, 0.0)? })
        };
        let loads = pairs.iter().map(load).collect::<Result<Vec<Load>, MaterialError>>()?;
        let layer = task.layer;
        let block_m = match (self.pattern.texture().rim(), &self.relief) {
            (Some(rim), _) => rim.block_m(layer.block_m),
            // Measured rims are some ten micrometres wide.
            (None, Some(_)) => 0.5 * layer.block_m,
            (None, None) => layer.block_m,
        };
        let CutSpecimen { thickness_m, holder, .. } = self.specimen;
        // A layer without a thickness is modelled alone, in designs and in their trials: else the discrepancy would
        // include what the body behind it changes.
        let thickness_m =
            layer.thickness_m.map(|own_m| thickness_m.map_or(own_m, |thickness_m| thickness_m.max(layer.height_m)));
        Ok(Some(Scene {
            elastic,
            area_law,
            pattern: Some(self.pattern),
            relief: self.relief.clone(),
            layer: Layer { block_m, thickness_m, holder: holder.or(layer.holder), ..layer },
            loads,
            // Steady sliding does not depend on speed.
            speed_m_s: first.speed_m_s,
            // Same refinement as in the run that confirms a design, so that the discrepancy does not include the
            // discretization error.
            run: RunOptions { refine: true, ..RunOptions::default() },
        }))
    }
}

/// Area law from the contact area A(P) in `curve`, for a modulus multiplied by c = exp(log_modulus):
/// A(P; c E) = A(P / c; E). A stated threshold is kept; the reference pressure `light_pa` scales with the modulus.
fn law_at_modulus(
    curve: &[AreaPoint],
    log_modulus: f64,
    stated_pa: Option<f64>,
    light_pa: f64,
) -> Result<AreaLaw, MaterialError> {
    let factor = log_modulus.exp();
    let moved: Vec<AreaPoint> =
        curve.iter().map(|point| AreaPoint { pressure_pa: point.pressure_pa * factor, ..*point }).collect();
    area_law(&moved, stated_pa.unwrap_or(light_pa * factor))
}
