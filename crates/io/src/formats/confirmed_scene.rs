//! Writes the scene of a design: scene.toml, an input of `simulate`.

use slipgrid_infer::calibrate::uncertainty::InputUncertainty;
use slipgrid_model::material::{ConditionFriction, Friction, LocalFriction, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Extent, Load, RunOptions};

use crate::Failure;
use crate::formats::friction::FrictionFile;
use crate::formats::learned::LearnedFile;
use crate::formats::material::{AreaLawFile, MaterialFile};
use crate::formats::pattern::PatternFile;
use crate::formats::scene::{LoadFile, SampleFile, SceneFile};
use crate::formats::values::{Numbers, PathOr, each, number_list};
use crate::formats::written_material::flat_friction;
use slipgrid_base::units::{LENGTH_MM, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::results::{SCHEMA, VERSION};
use slipgrid_design::{DesignTask, KnownMaterial, loads};
use slipgrid_infer::discrepancy::Discrepancy;
use slipgrid_laser::export::SpecimenRecord;

/// Contents of scene.toml.
pub struct DesignScene<'a> {
    /// Design task, which gives the scene its name, condition, specimen and layer.
    pub task: &'a DesignTask,
    /// Material with its uncertainty.
    pub known: &'a KnownMaterial,
    /// Pattern of the design.
    pub pattern: &'a Pattern,
    /// Nominal pressures with their local friction coefficients.
    pub loads: &'a [Load],
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Options of the confirming run.
    pub run: &'a RunOptions,
}

/// Steady scene of `pattern` on the specimen of `task`, at `loads`, with the material `known`, as TOML.
///
/// # Errors
/// [`Failure`] if the values have no TOML form, or the material cannot be shifted by its errors.
pub fn steady_scene(
    task: &DesignTask,
    known: &KnownMaterial,
    loads: &[Load],
    pattern: &Pattern,
) -> Result<String, Failure> {
    let extent = if task.search.strip { Extent::Strip } else { Extent::Sample };
    let run =
        RunOptions { seed: task.search.seed, dimensions: task.search.dimensions, extent, ..RunOptions::default() };
    DesignScene { task, known, pattern, loads, speed_m_s: task.speed_m_s, run: &run }.to_toml()
}

impl DesignScene<'_> {
    /// Scene as TOML. The file is self-contained: it includes the material.
    ///
    /// # Errors
    /// [`Failure`] if the values have no TOML form, or the material cannot be shifted by its errors.
    pub fn to_toml(&self) -> Result<String, Failure> {
        let um = |length_m: f64| LENGTH_UM.from_si(length_m).into();
        let name = |name: &str| name.to_owned().into();
        let (task, run) = (self.task, self.run);
        let file = SceneFile {
            name: Some(task.name.clone()),
            schema: Some(SCHEMA.into()),
            // The discrepancy depends on the condition.
            condition: task.condition.filter(|_| self.learned().is_some()).map(Into::into),
            material: PathOr::Table(Box::new(self.material().map_err(Failure::failed)?)).into(),
            pattern: Some(PatternFile::from(self.pattern).into()),
            specimen: Some(SpecimenRecord::from(&task.specimen).into()),
            sample: SampleFile {
                length_um: None,
                layer_um: Some(um(task.layer.height_m)),
                thickness_mm: task.layer.thickness_m.map(|thickness_m| LENGTH_MM.from_si(thickness_m).into()),
                holder: task.layer.holder.map(|holder| name(holder.name())),
                block_um: Some(um(task.layer.block_m)),
            }
            .into(),
            load: LoadFile {
                pressure_mpa: each(self.loads.iter().map(|load| PRESSURE_MPA.from_si(load.pressure_pa))),
                speed_mm_s: Some(SPEED_MM_S.from_si(self.speed_m_s).into()),
            }
            .into(),
            // A three-dimensional sample is solved as one cell.
            run: RunOptions {
                extent: if run.extent == Extent::Strip { Extent::Strip } else { Extent::Sample },
                ..*run
            }
            .into(),
        };
        let body =
            toml::to_string(&file).map_err(|error| Failure::Failed(format!("the design has no TOML form: {error}")))?;
        Ok(format!("# Scene of the confirming run, by slipgrid {VERSION}: slipgrid simulate scene.toml\n{body}"))
    }

    fn material(&self) -> Result<MaterialFile, MaterialError> {
        let KnownMaterial { material, uncertainty } = self.known;
        let modulus_gpa = MODULUS_GPA.from_si(material.elastic.youngs_modulus_pa());
        let loads = self.measured_loads()?;
        let errors = uncertainty.at_loads(material.area_law.as_ref(), &loads, self.task.condition.as_ref())?;
        let origin = match (uncertainty.law_is_fitted, uncertainty.law_is_measured) {
            (true, _) => Some("fit".to_owned()),
            (_, true) => Some("measured".to_owned()),
            _ => None,
        };
        let area_law = material.area_law.as_ref();
        Ok(MaterialFile {
            youngs_modulus_std_gpa: uncertainty.modulus_relative_std.map(|std| tidy(std * modulus_gpa).into()),
            // Flat friction serves only the discrepancy.
            flat_friction: self.learned().map_or_else(Vec::new, |_| flat_friction(&uncertainty.flat_friction)),
            learned: self.learned().map(|learned| LearnedFile::new(learned).into()),
            area_law: area_law.map(|law| AreaLawFile { origin, ..AreaLawFile::new(law, |factor| factor) }.into()),
            ..MaterialFile::new(&material.elastic, &material.provenance, self.friction(&loads, &errors))
        })
    }

    /// Discrepancy of the model learned from trials; `None` without trials.
    fn learned(&self) -> Option<&Discrepancy> {
        self.known.uncertainty.learned.as_ref().filter(|learned| !learned.trials().is_empty())
    }

    /// Pressures at which friction was measured, with the coefficients of the design's condition, or those of the design
    /// if one pair of coefficients holds. Coefficients of the design's own pressures would no longer be known as those of
    /// the flat samples that trials share.
    fn measured_loads(&self) -> Result<Vec<Load>, MaterialError> {
        let (friction, own) = (&self.known.material.friction, self.task.condition.as_ref());
        let Friction::PerCondition(rows) = friction else { return Ok(self.loads.to_vec()) };
        let is_own = |row: &&ConditionFriction| row.condition.is_none_or(|of| own.is_some_and(|own| of.matches(own)));
        // A condition between measured ones takes from all of them.
        let is_measured = rows.iter().any(|row| is_own(&row));
        let rows = rows.iter().filter(|row| is_own(row) || !is_measured);
        let mut pressures_pa: Vec<f64> = rows.map(|row| row.pressure_pa).collect();
        pressures_pa.sort_by(f64::total_cmp);
        pressures_pa.dedup();
        Ok(loads(friction, &pressures_pa, own)?.0)
    }

    /// Local friction coefficients with standard errors: one pair if all loads share a pair, otherwise one pair per
    /// pressure.
    fn friction(&self, loads: &[Load], errors: &InputUncertainty) -> FrictionFile {
        let known = &self.known.uncertainty;
        let mut order: Vec<usize> = (0..loads.len()).collect();
        order.sort_by(|&a, &b| loads[a].pressure_pa.total_cmp(&loads[b].pressure_pa));
        let mut loads: Vec<&Load> = order.iter().map(|&place| &loads[place]).collect();
        let pressures_pa: Vec<f64> = loads.iter().map(|load| load.pressure_pa).collect();
        let is_shared = loads.windows(2).all(|pair| pair[0].friction == pair[1].friction);
        let mut excess = known.excess(&pressures_pa, self.task.condition.as_ref());
        if is_shared {
            loads.truncate(1);
            excess = excess.map(|all| vec![all.iter().sum::<f64>() / all.len() as f64]);
        }
        let column = |values: Vec<f64>| match values[..] {
            [one] if is_shared => Numbers::One(one).into(),
            _ => each(values),
        };
        let [static_mean, dynamic_mean]: [Vec<f64>; 2] = [LocalFriction::static_mean, LocalFriction::dynamic_mean]
            .map(|of| loads.iter().map(|load| of(&load.friction)).collect());
        // Standard errors from relative variances, in the order of the loads.
        let std_error = |variances: &Option<Vec<f64>>, mean: &[f64]| {
            let variances = variances.as_ref()?;
            let relative = order.iter().map(|&place| variances[place].sqrt());
            Some(column(relative.zip(mean).map(|(share, mean)| share * mean).collect()))
        };
        // If the scale of the law was fitted together with the coefficients, the covariance includes their errors.
        let joint = known.scale_covariance;
        let dynamic_error = std_error(&errors.flat_friction, &dynamic_mean).filter(|_| joint.is_none());
        let (given_law, with_law) =
            if known.has_marginal_errors { (dynamic_error, None) } else { (None, dynamic_error) };
        let scale_covariance = joint.zip(dynamic_mean.first()).filter(|_| is_shared);
        FrictionFile {
            pressure_mpa: (!is_shared)
                .then(|| number_list(pressures_pa.iter().map(|&pressure_pa| PRESSURE_MPA.from_si(pressure_pa)))),
            relative_std: loads.first().map(|load| load.friction.relative_std().into()),
            static_std_error: std_error(&errors.static_friction, &static_mean),
            dynamic_std_error: with_law,
            dynamic_std_error_given_law: given_law,
            dynamic_over_steady: excess.map(|all| column(all.into_iter().map(tidy).collect())),
            scale_covariance: scale_covariance
                .map(|([[a, b], [c, d]], mean)| vec![vec![a * mean * mean, b * mean], vec![c * mean, d]].into()),
            static_mean: Some(column(static_mean)),
            dynamic_mean: Some(column(dynamic_mean)),
            ..FrictionFile::default()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Document;
    use crate::formats::run::Overrides;
    use crate::formats::scene::SceneInput;
    use slipgrid_design::optimize::{DesignSpace, Quantity, Target, TargetPoint};
    use slipgrid_infer::calibrate::uncertainty::MaterialUncertainty;
    use slipgrid_laser::export::{Outline, Specimen};
    use slipgrid_model::material::{AreaLaw, Elastic, Material, Provenance};
    use slipgrid_model::pattern::Planform;
    use slipgrid_model::springblock::{Holder, Layer};

    #[test]
    fn the_written_scene_is_the_confirmed_one() {
        let row = |(pressure_pa, dynamic_mean)| {
            let friction = LocalFriction::new(0.3, dynamic_mean, 0.04).unwrap();
            ConditionFriction { pressure_pa, condition: None, friction }
        };
        let friction = Friction::PerCondition([(0.65e6, 0.25), (2.6e6, 0.27)].map(row).to_vec());
        let (loads, _) = loads(&friction, &[2.6e6, 1.3e6], None).unwrap();
        let material = Material {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            friction: friction.clone(),
            area_law: Some(AreaLaw::new(vec![0.7e6, 2.6e6], vec![1.0, 0.9]).unwrap()),
            provenance: Provenance {
                name: "a \"b\"".into(),
                synthetic_surface: true,
                warnings: vec!["slope: 2".into()],
                ..Provenance::default()
            },
        };
        let pattern = Pattern::new(Planform::Square, 130.1e-6, 370e-6, 5.2e-6).unwrap();
        let holder = Some(Holder::Rigid);
        let layer = Layer { length_m: 8e-3, height_m: 200e-6, block_m: 10e-6, thickness_m: Some(6.5e-3), holder };
        let specimen = Specimen { outline: Outline::Disc { diameter_m: 8e-3 }, is_clipped: true };
        let run = RunOptions { seed: 7, ..RunOptions::default() };
        let point = TargetPoint { pressure_pa: 1e6, value: 0.9 };
        let target = Target::new(Quantity::Ratio, vec![point], 0.01).unwrap();
        let space = DesignSpace::new(*pattern.texture(), [1e-4; 2], [1e-4; 2], [1e-5; 2]).unwrap();
        let task = DesignTask::without_material(target, space, specimen, layer);
        let known = KnownMaterial { material, uncertainty: MaterialUncertainty::default() };
        let material = &known.material;
        let scene =
            DesignScene { task: &task, known: &known, pattern: &pattern, loads: &loads, speed_m_s: 2e-3, run: &run };
        let document = Document::new("scene.toml", scene.to_toml().unwrap());
        let read = SceneInput::from_document(document, Overrides::default()).unwrap();
        assert_eq!((read.scene.pattern, read.specimen), (Some(pattern), Some(specimen)));
        assert_eq!((read.scene.layer, read.scene.run, read.scene.speed_m_s), (layer, run, 2e-3));
        assert_eq!(read.scene.area_law, material.area_law);
        assert_eq!((read.scene.loads, read.material.friction), (loads, friction));
        assert_eq!(read.material.provenance, material.provenance);
    }
}
