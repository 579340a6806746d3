//! Writes the material file of a calibration.

use crate::formats::spanned::Spanned;
use slipgrid_infer::calibrate::uncertainty::CoefficientEstimate;
use slipgrid_infer::calibrate::{
    AreaLawOrigin, CalibrationOutcome, CalibrationTask, Coefficients, FittedPair, FittedRow as Row,
};
use slipgrid_model::material::Condition;

use crate::Failure;
use crate::formats::friction::{ConditionTable, FlatFrictionTable, FrictionFile};
use crate::formats::learned::LearnedFile;
use crate::formats::made_from::MadeFrom;
use crate::formats::material::{AreaLawFile, MaterialFile};
use crate::formats::values::{Numbers, each, number_list};
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::results::{SCHEMA, VERSION};

/// Formats the material of `outcome` as TOML. `made_from` is given for a file stored with its calibration, as
/// `calibrate -o` writes it; pages and cached results have none.
///
/// # Errors
/// [`Failure`] if the fit has neither one pair nor one pair per measurement, or a number has no TOML form.
pub fn material_toml(
    task: &CalibrationTask,
    outcome: &CalibrationOutcome,
    made_from: Option<MadeFrom>,
) -> Result<String, Failure> {
    let facts = &outcome.surface;
    let area_law = facts.law.as_ref().map(|law| {
        // A(P) = f(P) A(P0) P / P0
        let threshold_pa = law.pressures_pa()[0];
        let at_threshold = facts.curve.iter().find(|point| point.pressure_pa == threshold_pa);
        let areas = at_threshold.map(|point| {
            let per_pa = point.area_fraction_corrected / threshold_pa;
            let area = |(pressure_pa, factor): (&f64, &f64)| tidy(factor * per_pa * pressure_pa);
            law.pressures_pa().iter().zip(law.factors()).map(area).collect::<Vec<f64>>()
        });
        let um = |length_m: f64| LENGTH_UM.from_si(length_m).into();
        AreaLawFile {
            origin: facts.origin.map(|origin| AreaLawOrigin::name(origin).to_owned()),
            rms_slope: facts.rms_slope.map(|slope| tidy(slope).into()),
            sa_um: facts.sa_m.map(um),
            pixel_um: facts.pixel_m.map(um),
            pixel_y_um: facts.pixel_y_m.map(um),
            poisson_ratio: Some(tidy(task.poisson_ratio).into()),
            area_fraction: areas.map(number_list),
            ..AreaLawFile::new(law, tidy)
        }
    });
    let file = MaterialFile {
        schema: Some(SCHEMA.into()),
        synthetic_surface: Some(facts.synthetic),
        youngs_modulus_std_gpa: task.youngs_modulus_std_pa.map(|std_pa| MODULUS_GPA.from_si(std_pa).into()),
        area_law: area_law.map(Into::into),
        flat_friction: flat_friction(&outcome.uncertainty.flat_friction),
        made_from,
        learned: outcome.uncertainty.learned.as_ref().map(|learned| LearnedFile::new(learned).into()),
        ..MaterialFile::new(&task.elastic, &outcome.material.provenance, friction(task, outcome)?)
    };
    let body =
        toml::to_string(&file).map_err(|error| Failure::Failed(format!("the material has no TOML form: {error}")))?;
    Ok(format!(
        "# Material, by slipgrid calibrate {VERSION}. Scenes and designs name this file: material = \"...\".\n\
         # residual: model minus measured dynamic friction of the flat sample.\n{body}"
    ))
}

/// Rounds a residual to remove rounding errors of the fit.
fn rounded(residual: f64) -> f64 {
    (residual * 1e9).round() / 1e9 + 0.0
}

fn friction(task: &CalibrationTask, outcome: &CalibrationOutcome) -> Result<FrictionFile, Failure> {
    let (relative_std, fit) = (Some(task.relative_std.into()), &outcome.fit);
    let one = |value: f64| Numbers::One(value).into();
    let error = |error: Option<f64>| error.map(|error| one(tidy(error)));
    match (task.coefficients, &fit.pairs[..]) {
        (Coefficients::Single, [pair]) => Ok(FrictionFile {
            static_mean: Some(one(tidy(pair.static_mean))),
            dynamic_mean: Some(one(tidy(pair.dynamic_mean))),
            static_std_error: error(pair.static_std_error),
            dynamic_std_error: error(pair.dynamic_std_error),
            dynamic_std_error_given_law: error(pair.dynamic_std_error_given_law),
            dynamic_over_steady: fit.mean_over_local_law().map(one),
            relative_std,
            residual: Some(fit.predictions.iter().map(|predicted| rounded(predicted.residual)).collect()),
            scale_covariance: fit.scale_covariance().map(|rows| rows.map(|row| row.to_vec()).to_vec().into()),
            ..FrictionFile::default()
        }),
        (Coefficients::PerCondition, _) => {
            let tables = outcome.by_condition.iter();
            let conditions = tables.map(|(condition, rows)| condition_table(*condition, rows).into()).collect();
            Ok(FrictionFile { relative_std, conditions, ..FrictionFile::default() })
        }
        (_, pairs) => Err(Failure::Failed(format!("the fit returned {} pairs of coefficients", pairs.len()))),
    }
}

fn condition_table(condition: Condition, rows: &[Row]) -> ConditionTable {
    let column = |value: fn(&Row) -> f64| each(rows.iter().map(|row| tidy(value(row))));
    let errors = |value: fn(&FittedPair) -> Option<f64>| {
        let errors: Option<Vec<f64>> = rows.iter().map(|row| value(&row.pair).map(tidy)).collect();
        errors.map(each)
    };
    ConditionTable {
        speed_mm_s: SPEED_MM_S.from_si(condition.speed_m_s).into(),
        humidity_pct: HUMIDITY_PCT.from_si(condition.humidity).into(),
        pressure_mpa: number_list(rows.iter().map(|row| PRESSURE_MPA.from_si(row.pressure_pa))),
        static_mean: column(|row| row.pair.static_mean),
        dynamic_mean: column(|row| row.pair.dynamic_mean),
        static_std_error: errors(|pair| pair.static_std_error),
        dynamic_std_error: errors(|pair| pair.dynamic_std_error),
        dynamic_std_error_given_law: errors(|pair| pair.dynamic_std_error_given_law),
        dynamic_over_steady: Some(column(|row| row.dynamic_over_steady)),
        residual: Some(rows.iter().map(|row| rounded(row.residual)).collect()),
    }
}

/// Converts flat friction to tables, one for each run of consecutive measurements at one condition.
pub(crate) fn flat_friction(measured: &[CoefficientEstimate]) -> Vec<Spanned<FlatFrictionTable>> {
    let table = |rows: &[CoefficientEstimate]| {
        let Condition { speed_m_s, humidity } = rows[0].condition?;
        let pressures = rows.iter().filter_map(|row| row.pressure_pa);
        let table = FlatFrictionTable {
            speed_mm_s: SPEED_MM_S.from_si(speed_m_s).into(),
            humidity_pct: HUMIDITY_PCT.from_si(humidity).into(),
            pressure_mpa: number_list(pressures.map(|pressure_pa| PRESSURE_MPA.from_si(pressure_pa))),
            mu_dynamic: each(rows.iter().map(|row| tidy(row.value))),
        };
        Some(table.into())
    };
    measured.chunk_by(|a, b| a.condition == b.condition).filter_map(table).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::Document;
    use crate::formats::material::read_known;
    use crate::formats::scene::DEFAULT_LAYER;
    use slipgrid_base::monitor::Unwatched;
    use slipgrid_infer::calibrate::{CutSample, CutSpecimen, LandSlope, Measurement, Selection, Surface, TrialsTask};
    use slipgrid_laser::export::{Outline, Specimen};
    use slipgrid_model::material::{Elastic, Friction};
    use slipgrid_model::pattern::{Pattern, Planform};
    use std::sync::LazyLock;

    fn measurement(force_n: f64, humidity: f64, mu_dynamic: f64) -> Measurement {
        Measurement { force_n, speed_m_s: 2e-3, humidity, mu_dynamic, mu_dynamic_std: 0.002, static_peak: None }
    }

    /// Numbers of a short sample that have no short decimal form.
    fn task(coefficients: Coefficients, surface: Surface) -> CalibrationTask {
        let flat = vec![measurement(200.0, 0.15, 0.28), measurement(50.0, 0.8, 0.22), measurement(50.0, 0.15, 0.25)];
        let patterned: Vec<Measurement> =
            flat.iter().map(|flat| Measurement { mu_dynamic: flat.mu_dynamic * 0.9, ..*flat }).collect();
        // Its border changes the share of the face that is cavity.
        let face = Specimen { outline: Outline::Disc { diameter_m: 1.1e-3 }, is_clipped: false };
        let sample = CutSample {
            name: "squares".into(),
            date: String::new(),
            notes: String::new(),
            pattern: Pattern::new(Planform::Square, 80e-6, 120e-6, 5.2e-6).unwrap(),
            relief: None,
            map: None,
            land: Some(LandSlope { rms_slope: 0.015, over_flat: 1.1, log_std: 0.05 }),
            dimensions_std_m: [1e-6, 2e-6, 0.2e-6],
            sample_std: None,
            disc: Some("disc \"1\"".into()),
            specimen: CutSpecimen { face: Some(face), ..CutSpecimen::default() },
            measured: patterned,
        };
        CalibrationTask {
            name: "test".into(),
            source: "nowhere".into(),
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            youngs_modulus_std_pa: Some(0.08e9),
            poisson_ratio: 1.0 / 3.0,
            surface,
            threshold_pa: None,
            specimen_area_m2: std::f64::consts::PI * 25e-6,
            flat,
            trials: TrialsTask { samples: vec![sample], ..TrialsTask::default() },
            coefficients,
            relative_std: 0.05,
            static_over_dynamic: 0.30 / 0.27,
            layer: slipgrid_model::springblock::Layer { length_m: 500e-6, height_m: 40e-6, ..DEFAULT_LAYER },
            seed: 1,
            selection: Selection::default(),
            notes: vec!["a \"note\"".into()],
            doubts: vec!["measured ratio: a \"doubt\"".into()],
        }
    }

    /// Task and outcome that two tests read.
    static PER_CONDITION: LazyLock<(CalibrationTask, CalibrationOutcome)> =
        LazyLock::new(|| calibrated(Coefficients::PerCondition, Surface::RmsSlope(0.0137)));

    fn calibrated(coefficients: Coefficients, surface: Surface) -> (CalibrationTask, CalibrationOutcome) {
        let task = task(coefficients, surface);
        let outcome = slipgrid_infer::calibrate::run(&task, &Unwatched).unwrap();
        (task, outcome)
    }

    /// Checks that the outcome of a task equals the content of its file, and returns the file.
    fn read_back((task, outcome): &(CalibrationTask, CalibrationOutcome)) -> String {
        let written = material_toml(task, outcome, None).unwrap();
        let document = Document::new("m.toml", written.clone());
        let (material, uncertainty) = read_known(&document, &document.parse().unwrap(), &(0..0)).unwrap();
        assert_eq!(material, outcome.material);
        assert_eq!(uncertainty, outcome.uncertainty);
        assert!(material.provenance.notes.contains(&"a \"note\"".to_owned()), "{:?}", material.provenance.notes);
        written
    }

    /// A file written before the local law existed.
    #[test]
    fn a_file_without_flat_friction_is_read() {
        let (task, outcome) = &*PER_CONDITION;
        let mut file: toml::Table = material_toml(task, outcome, None).unwrap().parse().unwrap();
        assert!(file.remove("flat_friction").is_some());
        let trials = file["learned"]["trial"].as_array_mut().unwrap();
        assert!(trials[0].as_table_mut().unwrap().remove("local_law_change").is_some());
        let document = Document::new("m.toml", file.to_string());
        let (_, uncertainty) = read_known(&document, &document.parse().unwrap(), &(0..0)).unwrap();
        let zeros = uncertainty.learned.unwrap();
        assert!(uncertainty.flat_friction.is_empty());
        assert!(zeros.trials()[0].measured.iter().all(|at| at.sensitivity.local_law == 0.0));
    }

    #[test]
    fn a_material_is_the_one_that_its_file_says() {
        read_back(&PER_CONDITION);
        let each = &PER_CONDITION.1;
        let own = |force_n: f64, humidity| {
            let pressure_pa = force_n / (std::f64::consts::PI * 25e-6);
            let condition = Condition { speed_m_s: 2e-3, humidity };
            let at = each.material.friction.at(pressure_pa, Some(&condition)).unwrap();
            (at.friction.dynamic_mean(), at.outside_measured_range)
        };
        for (place, (force_n, humidity)) in [(200.0, 0.15), (50.0, 0.8), (50.0, 0.15)].into_iter().enumerate() {
            let (found, outside) = own(force_n, humidity);
            assert!((found - each.fit.pairs[place].dynamic_mean).abs() < 1e-11 && !outside);
        }
        assert!(own(40.0, 0.15).1);
        assert!(
            each.material.area_law.is_some()
                && each.uncertainty.learned.as_ref().unwrap().trials()[0].measured.len() == 3
        );
        assert!(each.uncertainty.has_marginal_errors);
        // Friction rises with load at 15 %, where the area law falls; at 80 % one load was measured.
        assert_eq!(each.uncertainty.flat_friction.len(), 3);
        let learned = each.uncertainty.learned.as_ref().unwrap();
        let changes: Vec<f64> = learned.trials()[0].measured.iter().map(|at| at.sensitivity.local_law).collect();
        assert!(changes[0] > 1e-4 && changes[1] == 0.0 && changes[2] > 1e-4, "{changes:?}");

        let back = |coefficients, surface| {
            let both = calibrated(coefficients, surface);
            let written = read_back(&both);
            (both.1, written)
        };
        let (single, _) = back(Coefficients::Single, Surface::None);
        assert!(matches!(single.material.friction, Friction::Single(_)) && single.material.area_law.is_none());
        assert!(single.uncertainty.flat_friction.is_empty());
        let (fitted, _) = back(Coefficients::Single, Surface::FittedScale { bounds_pa: [0.5e6, 50e6] });
        assert!(fitted.uncertainty.law_is_fitted && fitted.material.area_law.is_some());
        let synthetic = slipgrid_surface::topography::SelfAffine {
            pixels: 32,
            max_wave: 8,
            ..slipgrid_surface::topography::SelfAffine::STAND_IN
        };
        // Pixels are twice as wide across the sliding direction.
        let square = synthetic.map().unwrap();
        let (dx_m, heights_m) = (square.dx_m(), square.heights_m().to_vec());
        let read = slipgrid_surface::topography::ReadMap {
            map: slipgrid_surface::topography::HeightMap::new(32, 32, dx_m, 2.0 * dx_m, heights_m).unwrap(),
            format: slipgrid_surface::topography::MapFormat::Matrix,
            whole: true,
            comments: vec!["synthetic, one period".into()],
            notes: Vec::new(),
        };
        let map = slipgrid_surface::topography::PreparedMap::one_period(
            read,
            slipgrid_surface::topography::Preparation::default(),
            &slipgrid_base::monitor::Unwatched,
        )
        .unwrap();
        let surface = slipgrid_infer::calibrate::MapSurface { map, synthetic: true, windows: Some(2), after: None };
        let surface = Surface::Map(Box::new(surface));
        let (of_map, written) = back(Coefficients::PerCondition, surface);
        assert!(written.contains("\npixel_um = 31.25\npixel_y_um = 62.5\n"), "{written}");
        assert!(of_map.material.provenance.synthetic_surface);
        assert!(of_map.material.area_law.unwrap().factor_std().is_some());
    }
}
