//! Scene of a design: scene.toml, an input of `simulate`.

use crate::formats::spanned::Spanned;
use slipgrid_infer::calibrate::uncertainty::InputUncertainty;
use slipgrid_model::material::{Condition, LocalFriction, Material, MaterialError};
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{Extent, Layer, Load, RunOptions};

use crate::formats::learned::LearnedFile;
use crate::formats::material::{AreaLawFile, ConditionFile, FrictionFile, MaterialFile};
use crate::formats::run::RunFile;
use crate::formats::scene::{LoadFile, SampleFile, SceneFile};
use crate::formats::values::{Numbers, PathOr, number, number_list};
use crate::formats::written_material::flat_friction;
use slipgrid_base::units::{
    DENSITY_G_CM3, HUMIDITY_PCT, LENGTH_MM, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, Quantity, SPEED_MM_S, tidy,
};
use slipgrid_design::results::{SCHEMA, VERSION};
use slipgrid_design::{DesignTask, KnownMaterial};
use slipgrid_infer::calibrate::uncertainty::MaterialUncertainty;
use slipgrid_infer::discrepancy::Discrepancy;
use slipgrid_laser::export::Specimen;

/// A design that cannot be written as a scene.
#[derive(Debug, thiserror::Error)]
pub enum UnwritableScene {
    /// The numbers have no TOML form.
    #[error("the design has no TOML form: {0}")]
    Toml(#[from] toml::ser::Error),
    /// The material cannot be varied within its errors.
    #[error(transparent)]
    Material(#[from] MaterialError),
}

/// Contents of scene.toml.
pub struct DesignScene<'a> {
    /// Name of the design.
    pub name: &'a str,
    /// The material.
    pub material: &'a Material,
    /// Uncertainty of the material.
    pub uncertainty: &'a MaterialUncertainty,
    /// Speed and humidity for which the coefficients of the loads hold.
    pub condition: Option<&'a Condition>,
    /// The design.
    pub pattern: &'a Pattern,
    /// Specimen on which the pattern is laid.
    pub specimen: &'a Specimen,
    /// The modelled layer.
    pub layer: &'a Layer,
    /// Loads with their coefficients.
    pub loads: &'a [Load],
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Options of the confirming run.
    pub run: &'a RunOptions,
}

/// Steady scene of `pattern` on the specimen of `task`, at the loads of `task`, with the material `known`, as TOML.
///
/// # Errors
/// [`UnwritableScene`] if the values have no TOML form.
pub fn steady_scene(
    task: &DesignTask,
    known: &KnownMaterial,
    loads: &[Load],
    pattern: &Pattern,
) -> Result<String, UnwritableScene> {
    let extent = if task.strip { Extent::Strip } else { Extent::Sample };
    let run = RunOptions { seed: task.seed, dimensions: task.dimensions, extent, ..RunOptions::default() };
    let scene = DesignScene {
        name: &task.name,
        material: &known.material,
        uncertainty: &known.uncertainty,
        condition: task.condition.as_ref(),
        pattern,
        specimen: &task.specimen,
        layer: &task.layer,
        loads,
        speed_m_s: task.speed_m_s,
        run: &run,
    };
    scene.to_toml()
}

impl DesignScene<'_> {
    /// Scene as TOML. The file is self-contained: it includes the material.
    ///
    /// # Errors
    /// [`UnwritableScene`] if the values have no TOML form.
    pub fn to_toml(&self) -> Result<String, UnwritableScene> {
        let micrometres = |length_m| number(LENGTH_UM.from_si(length_m));
        let knowledge = self.uncertainty.at_loads(self.material.area_law.as_ref(), self.loads, self.condition)?;
        let file = SceneFile {
            name: Some(self.name.to_owned()),
            schema: Some(unplaced(SCHEMA)),
            // The discrepancy depends on the condition.
            condition: self.condition.filter(|_| self.learned().is_some()).map(|condition| {
                unplaced(ConditionFile {
                    speed_mm_s: number(SPEED_MM_S.from_si(condition.speed_m_s)),
                    humidity_pct: number(HUMIDITY_PCT.from_si(condition.humidity)),
                })
            }),
            material: unplaced(PathOr::Table(Box::new(self.material(&knowledge)))),
            pattern: Some(unplaced(self.pattern.into())),
            specimen: Some(unplaced(self.specimen.into())),
            sample: unplaced(SampleFile {
                length_um: None,
                layer_um: Some(micrometres(self.layer.height_m)),
                thickness_mm: self.layer.thickness_m.map(|thickness_m| number(LENGTH_MM.from_si(thickness_m))),
                holder: self.layer.holder.map(|holder| unplaced(holder.name().to_owned())),
                block_um: Some(micrometres(self.layer.block_m)),
            }),
            load: unplaced(LoadFile {
                pressure_mpa: each(self.loads.iter().map(|load| load.pressure_pa), PRESSURE_MPA),
                speed_mm_s: Some(number(SPEED_MM_S.from_si(self.speed_m_s))),
            }),
            run: RunFile {
                fidelity: Some(unplaced(self.run.fidelity.name().to_owned())),
                // A sample in space is run as one cell.
                extent: Some(unplaced(
                    if self.run.extent == Extent::Strip { Extent::Strip } else { Extent::Sample }.name().to_owned(),
                )),
                seed: Some(self.run.seed),
                sliding_um: Some(micrometres(self.run.sliding_m)),
                mu_stderr: self.run.mu_stderr.map(number),
                warm_start: self.run.warm_start.then_some(true),
                dimensions: self.run.dimensions.map(|dimensions| unplaced(u64::from(dimensions))),
                draws: (self.run.draws > 1).then(|| unplaced(self.run.draws)),
                refine: self.run.refine.then_some(true),
                ..RunFile::default()
            },
        };
        let body = toml::to_string(&file)?;
        Ok(format!("# Scene of the confirming run, by slipgrid {VERSION}: slipgrid simulate scene.toml\n{body}"))
    }

    fn material(&self, knowledge: &InputUncertainty) -> MaterialFile {
        let youngs_modulus_gpa = MODULUS_GPA.from_si(self.material.elastic.youngs_modulus_pa());
        let provenance = &self.material.provenance;
        let named = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        MaterialFile {
            name: named(&provenance.name),
            source: named(&provenance.source),
            schema: None,
            slipgrid_version: Some(VERSION.to_owned()),
            synthetic_surface: Some(provenance.synthetic_surface),
            notes: provenance.notes.clone(),
            warnings: provenance.warnings.clone(),
            youngs_modulus_gpa: number(youngs_modulus_gpa),
            youngs_modulus_std_gpa: self
                .uncertainty
                .modulus_relative_std
                .map(|std| number(tidy(std * youngs_modulus_gpa))),
            density_g_cm3: number(DENSITY_G_CM3.from_si(self.material.elastic.density_kg_m3())),
            yield_pressure_mpa: self.material.elastic.yield_pressure_pa().map(|pa| number(PRESSURE_MPA.from_si(pa))),
            friction: unplaced(self.friction(knowledge)),
            // Flat friction serves only the discrepancy.
            flat_friction: self.learned().map_or_else(Vec::new, |_| flat_friction(&self.uncertainty.flat_friction)),
            discrepancy: None,
            made_from: None,
            learned: self.learned().map(|learned| unplaced(LearnedFile::new(learned))),
            area_law: self.material.area_law.as_ref().map(|law| {
                unplaced(AreaLawFile {
                    origin: match (self.uncertainty.law_is_fitted, self.uncertainty.law_is_measured) {
                        (true, _) => Some("fit".to_owned()),
                        (_, true) => Some("measured".to_owned()),
                        _ => None,
                    },
                    rms_slope: None,
                    sa_um: None,
                    pixel_um: None,
                    pixel_y_um: None,
                    poisson_ratio: None,
                    pressure_mpa: number_list(law.pressures_pa().iter().map(|&p| PRESSURE_MPA.from_si(p))),
                    factor: number_list(law.factors().iter().copied()),
                    factor_std: law.factor_std().map(|std| number_list(std.iter().copied())),
                    area_fraction: None,
                })
            }),
        }
    }

    /// Discrepancy learned from trials, if any.
    fn learned(&self) -> Option<&Discrepancy> {
        self.uncertainty.learned.as_ref().filter(|learned| !learned.trials().is_empty())
    }

    /// One pair of coefficients if all loads share it, otherwise one pair per pressure, with standard errors.
    fn friction(&self, knowledge: &InputUncertainty) -> FrictionFile {
        let mut order: Vec<usize> = (0..self.loads.len()).collect();
        order.sort_by(|&a, &b| self.loads[a].pressure_pa.total_cmp(&self.loads[b].pressure_pa));
        let loads: Vec<&Load> = order.iter().map(|&place| &self.loads[place]).collect();
        // Relative errors of the coefficients. If the scale of the law was fitted together with the coefficients, the
        // covariance includes them.
        let relative = |known: &Option<Vec<f64>>| -> Option<Vec<f64>> {
            let known = known.as_ref()?;
            Some(order.iter().map(|&place| known[place].sqrt()).collect())
        };
        let joint = self.uncertainty.scale_covariance;
        let dynamic_error = relative(&knowledge.flat_friction).filter(|_| joint.is_none());
        let static_error = relative(&knowledge.static_friction);
        let pressures_pa: Vec<f64> = loads.iter().map(|load| load.pressure_pa).collect();
        let excess = self.uncertainty.excess(&pressures_pa, self.condition);
        let is_marginal = self.uncertainty.has_marginal_errors;
        let relative_std = loads.first().map(|load| number(load.friction.relative_std()));
        let shared = loads.first().filter(|first| loads.iter().all(|load| load.friction == first.friction));
        if let Some(load) = shared {
            let (static_mean, mean) = (load.friction.static_mean(), load.friction.dynamic_mean());
            let one = |value: f64| Some(unplaced(Numbers::One(value)));
            let error = |relative: Option<Vec<f64>>, mean: f64| relative.and_then(|all| one(all[0] * mean));
            return FrictionFile {
                static_mean: one(static_mean),
                dynamic_mean: one(mean),
                relative_std,
                static_std_error: error(static_error, static_mean),
                dynamic_std_error: error(dynamic_error.clone().filter(|_| !is_marginal), mean),
                dynamic_std_error_given_law: error(dynamic_error.filter(|_| is_marginal), mean),
                dynamic_over_steady: excess
                    .map(|all| unplaced(Numbers::One(tidy(all.iter().sum::<f64>() / all.len() as f64)))),
                scale_covariance: joint
                    .map(|[[a, b], [c, d]]| unplaced(vec![vec![a * mean * mean, b * mean], vec![c * mean, d]])),
                ..FrictionFile::default()
            };
        }
        let column = |values: Vec<f64>| Some(unplaced(Numbers::Each(values.into_iter().map(number).collect())));
        let [static_mean, dynamic_mean]: [Vec<f64>; 2] = [LocalFriction::static_mean, LocalFriction::dynamic_mean]
            .map(|of| loads.iter().map(|load| of(&load.friction)).collect());
        let errors = |relative: Option<Vec<f64>>, mean: &[f64]| {
            relative.and_then(|all| column(all.iter().zip(mean).map(|(share, mean)| share * mean).collect()))
        };
        FrictionFile {
            pressure_mpa: Some(number_list(loads.iter().map(|load| PRESSURE_MPA.from_si(load.pressure_pa)))),
            static_std_error: errors(static_error, &static_mean),
            dynamic_std_error: errors(dynamic_error.clone().filter(|_| !is_marginal), &dynamic_mean),
            dynamic_std_error_given_law: errors(dynamic_error.filter(|_| is_marginal), &dynamic_mean),
            dynamic_over_steady: excess.and_then(|all| column(all.into_iter().map(tidy).collect())),
            static_mean: column(static_mean),
            dynamic_mean: column(dynamic_mean),
            relative_std,
            ..FrictionFile::default()
        }
    }
}

fn unplaced<T>(value: T) -> Spanned<T> {
    Spanned::new(0..0, value)
}

fn each(values: impl Iterator<Item = f64>, quantity: Quantity) -> Spanned<Numbers> {
    unplaced(Numbers::Each(values.map(|value| number(tidy(quantity.from_si(value)))).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Document;
    use crate::formats::run::Overrides;
    use crate::formats::scene::SceneInput;
    use slipgrid_laser::export::Outline;
    use slipgrid_model::material::{AreaLaw, Elastic, Friction, Provenance};
    use slipgrid_model::pattern::Planform;
    use slipgrid_model::springblock::Holder;

    #[test]
    fn the_written_scene_is_the_confirmed_one() {
        let friction = |dynamic_mean| LocalFriction::new(0.3, dynamic_mean, 0.04).unwrap();
        let loads = [(2.6e6, 0.27), (0.65e6, 0.25)]
            .map(|(pressure_pa, dynamic_mean)| Load { pressure_pa, friction: friction(dynamic_mean) });
        let material = Material {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            friction: Friction::Single(friction(0.25)),
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
        let scene = DesignScene {
            name: "test",
            material: &material,
            uncertainty: &MaterialUncertainty::default(),
            condition: None,
            pattern: &pattern,
            specimen: &specimen,
            layer: &layer,
            loads: &loads,
            speed_m_s: 2e-3,
            run: &run,
        };
        let document = Document::new("scene.toml", scene.to_toml().unwrap());
        let read = SceneInput::from_file(document.clone(), &document.parse().unwrap(), Overrides::default()).unwrap();
        assert_eq!((read.scene.pattern, read.specimen), (Some(pattern), Some(specimen)));
        assert_eq!((read.scene.layer, read.scene.run, read.scene.speed_m_s), (layer, run, 2e-3));
        assert_eq!(read.scene.area_law, material.area_law);
        assert_eq!(read.scene.loads, loads);
        assert_eq!(read.material.provenance, material.provenance);
    }
}
