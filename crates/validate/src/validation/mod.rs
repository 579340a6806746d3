//! Comparison of measured ratios of patterned to flat friction with the model.

mod figures;
mod laws;
mod measured_law;
mod model;
mod page;
mod published;
mod ratios;
mod report;
#[cfg(test)]
mod report_for_tests;
mod rims;
mod statements;
mod summary;
mod tables;
mod text;

use std::path::Path;

use slipgrid_base::monitor::{Monitor, Stage};
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_MM, LENGTH_UM, SPEED_MM_S, tidy};
use slipgrid_design::results::{MadeBy, SCHEMA};
use slipgrid_infer::calibrate::CutSample;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::scene::{DEFAULT_LAYER, DEFAULT_SPECIMEN};
use slipgrid_io::formats::source::Source;
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::Layer;
use slipgrid_report::Outputs;

use crate::Failure;
use figures::Figures;
use laws::{ScaledLaw, ScaledLaws, scaled_laws};
use model::{Body, Case, predict, squares};
use ratios::{MeasuredLawRatio, MeasuredReport, ModelledRatio, Pair, RatioReport, pairs};
use summary::Summary;

pub use published::is_published;
pub use report::ValidationReport;
pub use text::text;

/// Input of a validation.
#[derive(Clone, Debug)]
pub struct ValidationTask<'a> {
    /// File of the calibration.
    pub path: &'a Path,
    /// Measurements on flat and on patterned samples.
    pub calibration: &'a Calibration,
    /// Name of the trial whose measurements are compared; `None` to compare the calibration's patterned samples.
    pub trial: Option<String>,
    /// Pattern of the patterned samples at the modelled and at the measured depth, as grooves.
    pub patterns: Patterns,
    /// Factors on the slopes of the surface, increasing, including 1.
    pub slope_factors: Vec<f64>,
    /// Compare every measured condition, not only the speed and humidity of the first flat measurement that has a
    /// patterned counterpart.
    pub all: bool,
    /// Travel of the transient run for friction against time, in metres; `None` for no run.
    pub sliding_m: Option<f64>,
    /// Make the files of the comparison: ratios for rims of several heights, pictures with their data, and the page.
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

    /// Compared sample: the named trial, or otherwise the sample of the patterned measurements; `None` if there is no
    /// such sample.
    fn cut(&self) -> Option<&CutSample> {
        let mut samples = self.calibration.stated.trials.samples.iter();
        match &self.trial {
            Some(name) => samples.find(|cut| cut.name == *name),
            None => samples.next().filter(|_| self.calibration.pattern.is_some()),
        }
    }

    /// Layer of the published simulations for the published samples; for all other samples the whole specimen, as in
    /// `calibrate`, `trials` and designs.
    fn layer(&self) -> Layer {
        let is_published = self.trial.is_none() && is_published(&self.calibration.stated.source);
        if is_published {
            return DEFAULT_LAYER;
        }
        Layer { thickness_m: self.stated_thickness_m().or(DEFAULT_SPECIMEN.thickness_m), ..DEFAULT_SPECIMEN }
    }

    /// Specimen as modelled.
    fn body(&self) -> Body<'_> {
        Body {
            path: self.path,
            elastic: self.calibration.stated.elastic,
            modulus_relative_std: self.calibration.modulus_relative_std(),
            layer: self.layer(),
        }
    }

    /// Stated thickness of the compared sample in the calibration, in metres.
    fn stated_thickness_m(&self) -> Option<f64> {
        self.cut().and_then(|cut| cut.specimen.thickness_m)
    }
}

/// Describes the origin of the specimen's height, and the height that trials and designs use. `stated_m` is the
/// thickness in the calibration, `default_m` the default of designs.
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

/// Pattern with the modelled and with the measured depth, as grooves.
#[derive(Clone, Copy, Debug)]
pub struct Patterns {
    /// Pattern with the modelled depth.
    pub modelled: Pattern,
    /// Pattern with the measured depth.
    pub measured: Pattern,
}

/// Models every compared condition of `task`, and makes the files if `task.figures`. A map is read from `source`.
///
/// # Errors
/// [`Failure`] for a calibration without measurements to compare, a surface that gives no area law, numbers that
/// make no valid scene, a picture that cannot be drawn, and if the monitor cancels.
pub fn validate(
    task: &ValidationTask<'_>,
    source: &Source,
    monitor: &dyn Monitor,
) -> Result<(ValidationReport, Outputs), Failure> {
    let started_s = monitor.seconds();
    let pairs = measured(task)?;
    let surface = scaled_laws(task, source, monitor)?;
    let mut report = compare(task, &pairs, &surface, monitor)?;
    let mut outputs = Outputs::default();
    if task.figures {
        let alike = pairs.iter().filter(|pair| pair.flat.has_condition_of(&pairs[0].flat));
        let alike: Vec<Pair> = alike.copied().collect();
        // Rims are tabulated only if the samples may have square cavities.
        if let Some(law) = surface.given().filter(|_| report.has_squares()) {
            let groove = &task.patterns.measured;
            report.rims = Some(rims::rims(task.body(), law, groove, &alike, monitor)?);
        }
        let heaviest = alike.into_iter().max_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa));
        if let Some(heaviest) = heaviest {
            let figures = Figures { task, surface: &surface, report: &report, heaviest };
            report.in_time = figures.draw(&mut outputs, monitor)?;
        }
    }
    report.wall_s = monitor.seconds() - started_s;
    if task.figures {
        figures::add_report(&report, &mut outputs)?;
    }
    Ok((report, outputs))
}

/// Pairs of flat and patterned measurements to compare.
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
        pairs.retain(|pair| pair.flat.has_condition_of(&first.flat));
    }
    Ok(pairs)
}

fn compare(
    task: &ValidationTask<'_>,
    pairs: &[Pair],
    surface: &ScaledLaws,
    monitor: &dyn Monitor,
) -> Result<ValidationReport, Failure> {
    let (calibration, patterns) = (task.calibration, &task.patterns);
    // Cases: every slope factor, then Amontons-Coulomb friction, then the surface as given at the measured depth.
    let proportional = ScaledLaw::without_surface(None);
    let given = surface.laws.iter().find(|law| law.slope_factor == 1.0);
    let deep = given.filter(|_| patterns.modelled != patterns.measured);
    let laws = surface.laws.iter().chain([&proportional]).map(|law| (patterns.modelled, law));
    let laws: Vec<(Pattern, &ScaledLaw)> = laws.chain(deep.map(|law| (patterns.measured, law))).collect();
    let cases: Vec<Case<'_>> = laws.iter().map(|&(pattern, law)| Case { pattern, law: law.law.as_ref() }).collect();

    let progress = Stage::new(monitor, "patterns", None);
    let body = task.body();
    let predicted = predict(body, &cases, pairs, &progress);
    progress.finish();
    monitor.heed()?;
    let predicted = predicted?;

    let by_measured_law = measured_law::ratios(calibration, body, patterns.modelled, pairs, monitor)?;
    let result = |(row, (pair, measured_law)): (usize, (&Pair, Vec<MeasuredLawRatio>))| {
        let mut modelled = laws
            .iter()
            .zip(&predicted)
            .map(|((pattern, law), predicted)| ModelledRatio::new(law, pattern, &predicted[row]));
        RatioReport {
            measured: MeasuredReport::new(pair),
            modelled: modelled.by_ref().take(surface.laws.len()).collect(),
            ratio_amontons_coulomb: modelled.next().and_then(|proportional| proportional.ratio_groove),
            measured_law,
            modelled_at_measured_depth: modelled.next(),
        }
    };
    let results: Vec<RatioReport> = pairs.iter().zip(by_measured_law).enumerate().map(result).collect();
    let slope_factors: Vec<f64> = surface.laws.iter().map(|law| law.slope_factor).collect();
    let mut report = ValidationReport {
        made_by: MadeBy::slipgrid(SCHEMA),
        name: calibration.stated.name.clone(),
        source: calibration.stated.source.clone(),
        trial: task.trial.clone(),
        cut_as: task.cut_as().map(|planform| planform.to_string()),
        thickness_mm: task.layer().thickness_m.map(|thickness_m| LENGTH_MM.from_si(thickness_m)),
        synthetic_surface: surface.synthetic,
        model: model_notes(task, pairs, &surface.notes),
        errors: errors_note(calibration),
        pattern: (&patterns.modelled).into(),
        areal_density_square: tidy(squares(&patterns.modelled).areal_density()),
        measured_depth_um: LENGTH_UM.from_si(patterns.measured.depth_m()),
        summary: Summary::new(&results, &slope_factors),
        slope_factors,
        statements: Vec::new(),
        published: Vec::new(),
        measured: self::pairs(calibration).iter().map(MeasuredReport::new).collect(),
        // A measured law has no contact area.
        area_laws: surface.laws.iter().filter(|scaled| !scaled.pressure_mpa.is_empty()).cloned().collect(),
        rims: None,
        in_time: None,
        wall_s: 0.0,
        threads: rayon::current_num_threads(),
        results,
    };
    report.statements = statements::statements(&report);
    report.published = published::published(&report);
    Ok(report)
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
    let condition = pairs.first().filter(|_| !task.all).map(|first| {
        format!(
            "measured at {} mm/s and {} % humidity, the condition of the table's first row; --all compares every one",
            SPEED_MM_S.from_si(first.flat.speed_m_s),
            HUMIDITY_PCT.from_si(first.flat.humidity),
        )
    });
    let lengths = format!(
        "grooves {} um wide, {} um apart and {} um deep; the measured cavities are {} um deep",
        um(pattern.width_m()),
        um(pattern.spacing_m()),
        um(pattern.depth_m()),
        um(patterns.measured.depth_m()),
    );
    let layer = task.layer();
    let body = match layer.thickness_m {
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
    };
    let coefficients = "at each measurement mu_d = mu_flat / f(P): a flat cell slides at mu_d f(P), so that the model's flat surface has \
                        the measured friction; the patterned measurements enter nowhere";
    let (squares, rims) = match task.cut_as() {
        Some(Planform::Groove) => (None, ""),
        Some(Planform::Square) | None => (Some(String::new()), RIMS_BESIDE),
        Some(other) => (Some(format!("the cavities were cut as {other}; here squares stand for them. ")), RIMS_BESIDE),
    };
    let squares = squares.map(|stand_in| {
        format!(
            "{stand_in}squares of the same lengths by the same in space, nu = 1/4; their strip estimate, 1 - (width/pitch)(1 - ratio of \
             the groove), counts strips between rows of cavities as flat"
        )
    });
    let absent =
        format!("not modelled in these ratios: recast rims{rims}, plasticity, viscoelasticity, heating, wear, menisci");
    let before = [condition, Some(lengths), Some(body), Some(coefficients.to_owned()), squares];
    before.into_iter().flatten().chain(surface.iter().cloned()).chain([absent]).collect()
}

/// Remark that rims of squares are in another table.
const RIMS_BESIDE: &str = " (what they would do stands in a table of its own)";

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
