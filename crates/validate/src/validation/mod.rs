//! Comparison of measured ratios patterned/flat with the model.

mod figures;
#[cfg(test)]
mod fixture;
mod laws;
mod measured_law;
mod model;
mod page;
mod published;
mod ratios;
mod report;
mod rims;
mod summary;
mod text;

use std::path::Path;

use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_MM, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S};
use slipgrid_design::results::{SCHEMA, VERSION};
use slipgrid_infer::calibrate::CutSample;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::scene::{DEFAULT_LAYER, DEFAULT_SPECIMEN};
use slipgrid_io::formats::source::Source;
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::Layer;
use slipgrid_report::Outputs;

use crate::StudyError;
use figures::{Figures, area_tables};
use laws::{ScaledLaws, scaled_laws};
use model::{Body, Case, FlatPoint, predict, squares};
use ratios::{MeasuredReport, ModelledRatio, Pair, RatioReport, depth_um, pairs, same_condition};
use summary::Summary;

pub use page::validation as page;
pub use published::is_published;
pub use report::ValidationReport;
pub use rims::{RimsReport, csv as rims_csv, picture as rims_picture};
pub use text::{csv, picture, table};

/// Input of a validation.
#[derive(Clone, Debug)]
pub struct ValidationTask<'a> {
    /// File of the calibration.
    pub path: &'a Path,
    /// Measurements on flat and on patterned samples.
    pub calibration: &'a Calibration,
    /// Name of the trial whose measurements replace the patterned samples'; `None` to compare the patterned samples.
    pub trial: Option<String>,
    /// Pattern of the patterned samples, as grooves.
    pub patterns: Patterns,
    /// Factors of the surface's slopes, increasing, including 1.
    pub slope_factors: Vec<f64>,
    /// Compare every measured condition, not only the condition of the first row.
    pub all: bool,
    /// Travel of the transient run for mu(t), in metres; `None` for no run.
    pub sliding_m: Option<f64>,
    /// Compute ratios for rims of several heights.
    pub rims: bool,
    /// Draw pictures and compute their data.
    pub figures: bool,
}

impl ValidationTask<'_> {
    /// Planform of the cavities as cut, if the calibration states it.
    fn cut_as(&self) -> Option<Planform> {
        if self.trial.is_none() {
            return self.calibration.pattern.map(|pattern| pattern.planform());
        }
        Some(self.cut()?.pattern.planform())
    }

    /// Compared sample: the trial, otherwise the first sample.
    fn cut(&self) -> Option<&CutSample> {
        let mut samples = self.calibration.trials.samples.iter();
        match &self.trial {
            Some(name) => samples.find(|cut| cut.name == *name),
            None => samples.next().filter(|_| self.calibration.pattern.is_some()),
        }
    }

    /// Layer of the published simulations if these are compared; for all other samples the whole specimen, as in
    /// `calibrate`, `trials` and designs.
    fn layer(&self) -> Layer {
        let is_published = self.trial.is_none() && is_published(&self.calibration.source);
        if is_published {
            return DEFAULT_LAYER;
        }
        Layer { thickness_m: self.stated_thickness_m().or(DEFAULT_SPECIMEN.thickness_m), ..DEFAULT_SPECIMEN }
    }

    /// Stated thickness of the compared sample in the calibration, in metres.
    fn stated_thickness_m(&self) -> Option<f64> {
        self.cut().and_then(|cut| cut.specimen.thickness_m)
    }
}

/// Describes the origin of the specimen's height and its other uses; `stated_m` of the calibration, `default_m` of designs.
fn thickness_words(stated_m: Option<f64>, default_m: Option<f64>) -> String {
    let mm = |length_m: f64| LENGTH_MM.from_si(length_m);
    match (stated_m, default_m) {
        (None, _) => {
            "The calibration states no thickness_mm; calibrate, trials and designs without thickness_mm take the same"
                .to_owned()
        }
        (Some(stated_m), Some(default_m)) if mm(stated_m) != mm(default_m) => format!(
            "The calibration states thickness_mm = {0}, which its trials are modelled with; designs without thickness_mm take {1} mm, and \
             not {0} mm: thickness_mm = {0} in [sample] of a design makes them agree",
            mm(stated_m),
            mm(default_m)
        ),
        (Some(stated_m), _) => format!(
            "The calibration states thickness_mm = {}; trials and designs without thickness_mm take the same",
            mm(stated_m)
        ),
    }
}

/// Pattern at both depths, as grooves.
#[derive(Clone, Copy, Debug)]
pub struct Patterns {
    /// Pattern as modelled.
    pub modelled: Pattern,
    /// Pattern as measured.
    pub measured: Pattern,
}

impl Patterns {
    fn differ(&self) -> bool {
        self.modelled != self.measured
    }
}

/// Models every measured condition of `task`; draws pictures and computes their data if requested. Maps come from
/// `source`.
///
/// # Errors
/// [`StudyError`] for a calibration without anything to compare, a surface that gives no area law, and numbers that make
/// no valid scene.
pub fn validate(
    task: &ValidationTask<'_>,
    source: &Source,
    monitor: &dyn Monitor,
) -> Result<(ValidationReport, Outputs), StudyError> {
    let started_s = monitor.seconds();
    let pairs = measured(task)?;
    let surface = scaled_laws(task, source, monitor)?;
    let mut report = compare(task, &pairs, &surface, monitor)?;
    // The table of rims is about square cavities.
    if task.rims && report.has_squares() {
        report.rims = rims_of(task, &pairs, &surface, &report, monitor)?;
    }
    let mut outputs = Outputs::default();
    if task.figures
        && let Some(figures) = figures(task, &pairs, &surface, &report)
    {
        report.in_time = figures.draw(&mut outputs, monitor)?;
    }
    report.wall_s = monitor.seconds() - started_s;
    Ok((report, outputs))
}

/// Computes rims at the condition of the first row, on cavities of the measured depth.
fn rims_of(
    task: &ValidationTask<'_>,
    pairs: &[Pair],
    surface: &ScaledLaws,
    report: &ValidationReport,
    monitor: &dyn Monitor,
) -> Result<Option<RimsReport>, StudyError> {
    let Some(first) = pairs.first() else { return Ok(None) };
    let alike = |pair: &&Pair| same_condition(&pair.flat, &first.flat);
    let points: Vec<FlatPoint> = pairs.iter().filter(alike).map(|pair| flat_point(pair, task.calibration)).collect();
    let results: Vec<RatioReport> = report
        .results
        .iter()
        .filter(|row| report.results.first().is_some_and(|first| row.measured.is_at_condition_of(&first.measured)))
        .cloned()
        .collect();
    let Some(law) = surface.given() else { return Ok(None) };
    let groove = &task.patterns.measured;
    rims::rims(task.path, body(task), law, groove, &points, &results, monitor).map(Some)
}

/// Input of the pictures; `None` if nothing was compared.
fn figures<'a>(
    task: &'a ValidationTask<'a>,
    pairs: &[Pair],
    surface: &'a ScaledLaws,
    report: &ValidationReport,
) -> Option<Figures<'a>> {
    let first = pairs.first()?;
    let heaviest = pairs
        .iter()
        .filter(|pair| same_condition(&pair.flat, &first.flat))
        .max_by(|a, b| a.flat.force_n.total_cmp(&b.flat.force_n))?;
    let peaks = report.results.iter().flat_map(|row| &row.modelled).map(|modelled| modelled.peak_pressure_mpa);
    Some(Figures {
        path: task.path,
        calibration: task.calibration,
        layer: task.layer(),
        squares: report.has_squares(),
        laws: &surface.laws,
        pattern: task.patterns.modelled,
        heaviest: flat_point(heaviest, task.calibration),
        peak_pa: PRESSURE_MPA.to_si(peaks.fold(0.0, f64::max)),
        sliding_m: task.sliding_m,
        synthetic: surface.synthetic,
    })
}

/// Flat measurement of a pair, as input of the model.
fn flat_point(pair: &Pair, calibration: &Calibration) -> FlatPoint {
    FlatPoint {
        pressure_pa: calibration.pressure_pa(pair.flat.force_n),
        speed_m_s: pair.flat.speed_m_s,
        mu_flat: pair.flat.mu_dynamic,
        mu_flat_std: pair.flat.mu_dynamic_std,
    }
}

/// Measured pairs for the report.
fn measured(task: &ValidationTask<'_>) -> Result<Vec<Pair>, Diagnostic> {
    let calibration = task.calibration;
    let nothing =
        |reason: &str| Diagnostic { key: Some("measurements.patterned".into()), ..Diagnostic::file(task.path, reason) };
    if calibration.patterned.is_empty() {
        return Err(nothing("is missing: there is nothing to compare with"));
    }
    let mut pairs = pairs(calibration);
    let Some(first) = pairs.first().copied() else {
        return Err(nothing("has no condition in common with measurements.flat")
            .expected("the same force, speed and humidity in both tables"));
    };
    if !task.all {
        pairs.retain(|pair| same_condition(&pair.flat, &first.flat));
    }
    Ok(pairs)
}

fn compare(
    task: &ValidationTask<'_>,
    pairs: &[Pair],
    surface: &ScaledLaws,
    monitor: &dyn Monitor,
) -> Result<ValidationReport, StudyError> {
    let (calibration, patterns) = (task.calibration, &task.patterns);
    let points: Vec<FlatPoint> = pairs.iter().map(|pair| flat_point(pair, calibration)).collect();
    // Every slope, then Amontons-Coulomb, then the surface as given at the measured depth.
    let given = surface.laws.iter().find(|law| law.slope_factor == 1.0);
    let mut cases: Vec<Case<'_>> =
        surface.laws.iter().map(|law| Case { pattern: patterns.modelled, law: law.law.as_ref() }).collect();
    cases.push(Case { pattern: patterns.modelled, law: None });
    let deep = given.filter(|_| patterns.differ());
    cases.extend(deep.map(|law| Case { pattern: patterns.measured, law: law.law.as_ref() }));

    let progress = Stage::new(monitor, "patterns", None);
    let body = body(task);
    let predicted = predict(task.path, body, &cases, &points, &progress);
    progress.finish();
    monitor.heed()?;
    let predicted = predicted?;

    let by_measured_law = measured_law::ratios(task.path, calibration, body, patterns.modelled, pairs, monitor)?;
    let slopes = surface.laws.len();
    let results: Vec<RatioReport> = pairs
        .iter()
        .enumerate()
        .map(|(row, pair)| RatioReport {
            measured: MeasuredReport::new(pair, calibration),
            ratio_amontons_coulomb: predicted[slopes][row].outcome.ratio,
            modelled: surface
                .laws
                .iter()
                .zip(&predicted)
                .map(|(law, predicted)| ModelledRatio::new(law, &patterns.modelled, &predicted[row]))
                .collect(),
            measured_law: by_measured_law[row].clone(),
            modelled_at_measured_depth: deep
                .zip(predicted.get(slopes + 1))
                .map(|(law, predicted)| ModelledRatio::new(law, &patterns.measured, &predicted[row])),
        })
        .collect();
    let slope_factors: Vec<f64> = surface.laws.iter().map(|law| law.slope_factor).collect();
    let mut report = ValidationReport {
        program: "slipgrid".into(),
        version: VERSION.into(),
        schema: SCHEMA,
        name: calibration.name.clone(),
        source: calibration.source.clone(),
        trial: task.trial.clone(),
        cut_as: task.cut_as().map(|planform| planform.to_string()),
        thickness_mm: task.layer().thickness_m.map(|thickness_m| LENGTH_MM.from_si(thickness_m)),
        synthetic_surface: surface.synthetic,
        model: model_notes(task, pairs, &surface.notes),
        errors: errors_note(calibration),
        pattern: (&patterns.modelled).into(),
        areal_density_square: slipgrid_base::units::tidy(squares(&patterns.modelled).areal_density()),
        measured_depth_um: depth_um(&patterns.measured),
        summary: Summary::new(&results, &slope_factors),
        slope_factors,
        statements: Vec::new(),
        published: Vec::new(),
        measured: self::pairs(calibration).iter().map(|pair| MeasuredReport::new(pair, calibration)).collect(),
        area_laws: area_tables(&surface.laws),
        rims: None,
        in_time: None,
        wall_s: 0.0,
        threads: rayon::current_num_threads(),
        results,
    };
    report.statements = text::statements(&report);
    report.published = published::published(&report);
    Ok(report)
}

/// Layer of the model.
fn body(task: &ValidationTask<'_>) -> Body {
    Body {
        elastic: task.calibration.elastic,
        modulus_relative_std: task.calibration.modulus_relative_std(),
        layer: task.layer(),
    }
}

/// Explains which error sources the standard deviations of modelled values include.
fn errors_note(calibration: &Calibration) -> String {
    let modulus = match calibration.modulus_relative_std() {
        Some(std) => format!("Young's modulus, known to {:.0} %, and ", 100.0 * std),
        None => "(Young's modulus is taken as exact: the calibration names no error) ".to_owned(),
    };
    format!(
        "+- of modelled values: one standard deviation of {modulus}measured flat friction, to first order. Not in it: the slope of \
         the surface, of which others stand beside it, and how far the model itself is off"
    )
}

/// Describes model assumptions and methods.
fn model_notes(task: &ValidationTask<'_>, pairs: &[Pair], surface: &[String]) -> Vec<String> {
    let um = |length_m: f64| LENGTH_UM.from_si(length_m);
    let patterns = &task.patterns;
    let pattern = &patterns.modelled;
    let mut notes = Vec::new();
    if let Some(first) = pairs.first().filter(|_| !task.all) {
        notes.push(format!(
            "measured at {} mm/s and {} % humidity, the condition of the table's first row; --all compares every one",
            SPEED_MM_S.from_si(first.flat.speed_m_s),
            HUMIDITY_PCT.from_si(first.flat.humidity),
        ));
    }
    notes.push(format!(
        "grooves {} um wide, {} um apart and {} um deep; the measured cavities are {} um deep",
        um(pattern.width_m()),
        um(pattern.spacing_m()),
        depth_um(pattern),
        depth_um(&patterns.measured),
    ));
    let layer = task.layer();
    notes.push(match layer.thickness_m {
        None => format!(
            "steady sliding of one period in the vertical plane, a layer of {} um in blocks of {} um, as the source simulated it",
            um(layer.height_m),
            um(layer.block_m),
        ),
        Some(thickness_m) => format!(
            "steady sliding of one period in the vertical plane: the whole specimen, {} mm high, in blocks of {} um at the \
             interface. {}",
            LENGTH_MM.from_si(thickness_m),
            um(layer.block_m),
            thickness_words(task.stated_thickness_m(), DEFAULT_SPECIMEN.thickness_m),
        ),
    });
    notes.push(
        "at each measurement mu_d = mu_flat / f(P): a flat cell slides at mu_d f(P), so that the model's flat surface has \
         the measured friction; the patterned measurements enter nowhere"
            .to_owned(),
    );
    let squares = match task.cut_as() {
        Some(Planform::Groove) => None,
        Some(Planform::Square) | None => Some(String::new()),
        Some(other) => Some(format!("the cavities were cut as {other}; here squares stand for them. ")),
    };
    notes.extend(squares.map(|stand_in| format!(
        "{stand_in}squares of the same lengths by the same in space, nu = 1/4; their strip estimate, 1 - (width/pitch)(1 - ratio of \
         the groove), counts strips between rows of cavities as flat"
    )));
    notes.extend(surface.iter().cloned());
    let rims =
        if task.cut_as() == Some(Planform::Groove) { "" } else { " (what they would do stands in a table of its own)" };
    notes.push(format!(
        "not modelled in these ratios: recast rims{rims}, plasticity, viscoelasticity, heating, wear, menisci"
    ));
    notes
}

#[cfg(test)]
mod tests {
    use super::thickness_words;

    #[test]
    fn a_thickness_that_designs_do_not_take_is_named() {
        let said = |stated_m| thickness_words(stated_m, Some(7e-3));
        assert!(said(None).contains("states no thickness_mm"));
        assert!(
            said(Some(7e-3)).contains("states thickness_mm = 7; trials and designs without thickness_mm take the same")
        );
        let other = said(Some(4e-3));
        assert!(other.contains("states thickness_mm = 4") && other.contains("take 7 mm, and not 4 mm"), "{other}");
        assert!(!other.contains("states no") && other.contains("thickness_mm = 4 in [sample] of a design"), "{other}");
    }
}
