//! `calibrate`: local friction coefficients from measurements on flat samples.

mod details;
mod discrepancy;
mod fit;
mod needed;
mod write;

use std::path::Path;

use slipgrid_contact::{AreaPoint, ContactError, Status};
use slipgrid_material::{
    AreaLaw, Condition, ConditionFriction, Elastic, Friction, LocalFriction, Material, MaterialError, Provenance,
};
use slipgrid_springblock::Layer;
use slipgrid_topography::HeightMap;

use details::FitDetails;
use discrepancy::Report;

use super::altitude_map::SurfaceMap;
use super::area_curve::{DEFAULT_PRESSURES_MPA, area_curve, area_law, check_factors, persson_curve};
use super::area_statistics::{
    DEFAULT_WINDOWS, LawRequest, WINDOW_STATEMENT, WindowSpread, takes_default_windows, window_spread,
};
use crate::args::CalibrateArgs;
use crate::interruption::heed;
use crate::output::{Place, check_file, check_folder, write_file};
use crate::progress::Progress;
use crate::{CliError, Console, exit_code};
use slipgrid_calibrate::uncertainty::MaterialUncertainty;
use slipgrid_formats::Diagnostic;
use slipgrid_formats::calibration::{Calibration, Coefficients};
use slipgrid_formats::material_uncertainty::read_known;
use slipgrid_formats::measurements::Measurement;
use slipgrid_formats::scene::DEFAULT_SPECIMEN;
use slipgrid_formats::surface::{MapOptions, Surface};
use slipgrid_formats::{Document, material::MaterialFile};
use slipgrid_report::Outputs;
use slipgrid_results::Table;
use slipgrid_results::fixed;
use slipgrid_units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S};

/// Error at which the contact computation of a calibration ends: on the reference maps no pixel changes after it.
pub const CONTACT_TOLERANCE: f64 = 1e-6;

/// Local pressures at which maps before and after a test are compared.
const AFTER_MPA: [f64; 3] = [1.3, 2.6, 8.0];

/// Seed of the flat sample's local coefficients where nothing else names one.
const DEFAULT_SEED: u64 = 1;

/// What a fit takes: everything that was read or computed before it.
#[derive(Clone, Debug)]
pub struct CalibrationInput {
    /// Young's modulus and density.
    pub elastic: Elastic,
    /// Area law; absent for Amontons-Coulomb.
    pub area_law: Option<AreaLaw>,
    /// Area of one specimen's face, in square metres.
    pub specimen_area_m2: f64,
    /// Measurements on flat samples.
    pub measurements: Vec<Measurement>,
    /// What is fitted.
    pub coefficients: Coefficients,
    /// Scatter of the local coefficients relative to their means: no mean identifies it.
    pub relative_std: f64,
    /// The flat sample as modelled.
    pub layer: Layer,
    /// Seed of its local coefficients.
    pub seed: u64,
    /// Bounds of the area law's scale E* h'rms, in pascals, where it is fitted.
    pub area_law_scale_pa: Option<[f64; 2]>,
}

/// The part of a calibration that a design needs, and how its sample is modelled.
#[derive(Clone, Copy, Debug)]
pub struct Purpose<'a> {
    /// Only measurements at this speed and humidity, or about it, are fitted where coefficients depend on them.
    pub condition: Option<Condition>,
    /// Those at these conditions or about them, too.
    pub also_at: &'a [Condition],
    /// Of these, those at the nominal pressures of the design or about them, in pascals.
    pub pressures_pa: &'a [f64],
    /// The flat sample as modelled.
    pub layer: Layer,
    /// Seed of its local coefficients.
    pub seed: u64,
}

/// Coefficients fitted at one measurement, or for all of them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FittedPair {
    /// Mean local static coefficient.
    pub static_mean: f64,
    /// Its standard error, where it was fitted.
    pub static_std_error: Option<f64>,
    /// Mean local dynamic coefficient.
    pub dynamic_mean: f64,
    /// Its standard error, whatever Young's modulus and the area law are.
    pub dynamic_std_error: Option<f64>,
    /// The same at the given area law, where the two differ: that of flat friction.
    pub dynamic_std_error_given_law: Option<f64>,
}

/// What a fit found.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// One pair for all, or one per measurement in their order.
    pub pairs: Vec<FittedPair>,
    /// Model minus measurement of dynamic friction on the flat sample, one per measurement.
    pub residuals: Vec<f64>,
    /// Dynamic over steady friction of the flat sample, one per measurement.
    pub dynamic_over_steady: Vec<f64>,
    /// How values were obtained, what was assumed.
    pub notes: Vec<String>,
    /// Everything else that was found.
    pub details: FitDetails,
}

/// The surface behind an area law, for the material file.
#[derive(Clone, Debug, Default)]
struct SurfaceFacts {
    origin: Option<&'static str>,
    synthetic: bool,
    rms_slope: Option<f64>,
    sa_m: Option<f64>,
    pixel_m: Option<f64>,
    curve: Vec<AreaPoint>,
    /// Standard errors of f, one per point of the curve.
    factor_std: Option<Vec<f64>>,
    notes: Vec<String>,
    /// What makes the law doubtful.
    warnings: Vec<String>,
}

/// A calibration made: the material, as a file and validated.
struct Calibrated {
    file: String,
    material: Material,
    uncertainty: MaterialUncertainty,
    fit: Fit,
    discrepancy: Option<Report>,
}

/// What is written into the folder of a report, beside what there is of traces.
const FILES: [&str; 4] = ["fit.json", "profiles.csv", "residuals.svg", "discrepancy.*"];

/// Calibrates and reports.
pub fn run(args: &CalibrateArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let calibration = Calibration::read(&crate::input::disk(), &args.calibration)?;
    if let Some(path) = &args.output {
        check_file(Place::output(path), &calibration.inputs)?;
    }
    if let Some(folder) = &args.report {
        let place = Place { flag: "--report", path: folder };
        let names = [&FILES[..], &super::traces::FILES].concat();
        check_folder(place, &names, &calibration.inputs)?;
    }
    let calibrated =
        calibrate(&args.calibration, &calibration, (DEFAULT_SPECIMEN, DEFAULT_SEED), &calibration, console)?;
    if let Some(path) = &args.output {
        write_file(path, calibrated.file.as_bytes())?;
    }
    if let Some(folder) = &args.report {
        let outputs = report(&calibration, &calibrated)?;
        crate::output::write(&outputs, folder)?;
        console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    }
    console.answer(&summary(&calibration, &calibrated))?;
    match &args.output {
        Some(path) => console.note(&format!("wrote {}", path.display())),
        None => console.note("nothing written; -o MATERIAL.toml keeps the material"),
    }
    Ok(exit_code::DONE)
}

/// Coefficients per condition before anything is fitted: the measured ones, enough to find out
/// whether the pressures and the condition of a design are among them.
pub fn provisional(calibration: &Calibration) -> Result<Material, CliError> {
    let rows = calibration.flat.iter().map(|measured| {
        Ok(ConditionFriction {
            pressure_pa: calibration.pressure_pa(measured.force_n),
            condition: (calibration.coefficients == Coefficients::PerCondition)
                .then_some(Condition { speed_m_s: measured.speed_m_s, humidity: measured.humidity }),
            friction: LocalFriction::new(measured.mu_dynamic, measured.mu_dynamic, calibration.relative_std)?,
        })
    });
    let rows: Result<Vec<ConditionFriction>, MaterialError> = rows.collect();
    Ok(Material {
        elastic: calibration.elastic,
        friction: Friction::PerCondition(rows.map_err(|error| CliError::Other(error.to_string()))?),
        area_law: None,
        provenance: Provenance::default(),
    })
}

/// The material of a calibration, fitted as far as `purpose` needs it, and what is known of its errors.
pub fn material(
    path: &Path,
    calibration: &Calibration,
    purpose: &Purpose<'_>,
    console: &mut Console<'_>,
) -> Result<(Material, MaterialUncertainty), CliError> {
    let needed = Calibration { flat: needed::needed(calibration, purpose), ..calibration.clone() };
    // Patterned samples at any speed tell of the model's error.
    let humidities: Vec<f64> =
        purpose.condition.iter().chain(purpose.also_at).map(|condition| condition.humidity).collect();
    let judged = discrepancy::narrowed(calibration, &humidities);
    let calibrated = calibrate(path, &needed, (purpose.layer, purpose.seed), &judged, console)?;
    Ok((calibrated.material, calibrated.uncertainty))
}

fn calibrate(
    path: &Path,
    calibration: &Calibration,
    (layer, seed): (Layer, u64),
    discrepancy_of: &Calibration,
    console: &mut Console<'_>,
) -> Result<Calibrated, CliError> {
    let mut facts = surface_facts(path, calibration, console)?;
    let law = if let Some(law) = &calibration.measured_law {
        Some(law.clone())
    } else if facts.curve.is_empty() {
        None
    } else {
        let law = area_law(&facts.curve, calibration.threshold_pa).and_then(|law| with_errors(law, &facts));
        Some(law.map_err(|error| Diagnostic::file(path, format!("the contact area gives no area law: {error}")))?)
    };
    let mut input = CalibrationInput {
        elastic: calibration.elastic,
        area_law: law,
        specimen_area_m2: calibration.specimen_area_m2,
        measurements: calibration.flat.clone(),
        coefficients: calibration.coefficients,
        relative_std: calibration.relative_std,
        layer,
        seed,
        area_law_scale_pa: calibration.area_law_scale_pa,
    };
    let problem = fit::problem(&input)?;
    if let Some(text) = fit::estimate(&problem) {
        console.note(&text);
    }
    let progress = Progress::start("calibration", console.quiet);
    let fit = fit::fit(&problem, &progress);
    progress.finish();
    let mut fit = fit.map_err(|error| fit::refuse(&error, path, calibration))?;
    if calibration.area_law_scale_pa.is_some() {
        input.area_law.clone_from(&fit.details.area_law);
        facts.origin = Some("fit");
        facts.curve = fit.details.area_curve.clone();
        facts.notes.clear(); // what was said of having no law
    }
    fit::marginal(&mut fit, calibration, &input).map_err(|error| CliError::Other(error.to_string()))?;
    let progress = Progress::start("discrepancy", console.quiet);
    let discrepancy = discrepancy::discrepancy(discrepancy_of, &input, &facts.curve);
    progress.finish();
    heed()?;
    let discrepancy = discrepancy?;
    let file = write::material_toml(calibration, &input, &facts, &fit, discrepancy.as_ref())?;
    // The material is the written one, read back: what is kept in a file gives the same numbers.
    let document = Document::new(path, file.clone());
    let read: MaterialFile = document.parse()?;
    let (material, uncertainty) = read_known(&document, &read, &(0..0))?;
    Ok(Calibrated { file, material, uncertainty, fit, discrepancy })
}

fn surface_facts(file: &Path, calibration: &Calibration, console: &mut Console<'_>) -> Result<SurfaceFacts, CliError> {
    let contact_modulus_pa = calibration.elastic.contact_modulus_pa(calibration.poisson_ratio);
    let mut pressures_pa = DEFAULT_PRESSURES_MPA.map(|pressure_mpa| PRESSURE_MPA.to_si(pressure_mpa)).to_vec();
    let threshold = pressures_pa.partition_point(|&pressure_pa| pressure_pa < calibration.threshold_pa);
    if pressures_pa.get(threshold) != Some(&calibration.threshold_pa) {
        pressures_pa.insert(threshold, calibration.threshold_pa);
    }
    match &calibration.surface {
        Surface::None => Ok(SurfaceFacts {
            notes: vec!["no surface was given: friction is proportional to load (Amontons-Coulomb)".to_owned()],
            ..SurfaceFacts::default()
        }),
        Surface::Measured { extrapolation } => Ok(SurfaceFacts {
            origin: Some("measured"),
            notes: vec![format!(
                "local law: measured flat friction itself, mu(p) = mu_flat(P = p), {} above the last measured pressure; no area law, and \
                 Young's modulus does not move it",
                extrapolation.name()
            )],
            ..SurfaceFacts::default()
        }),
        Surface::Persson { rms_slope } => Ok(SurfaceFacts {
            origin: Some("persson"),
            rms_slope: Some(*rms_slope),
            curve: persson_curve(*rms_slope, contact_modulus_pa, &pressures_pa)
                .map_err(|error| CliError::Other(error.to_string()))?,
            notes: vec!["area law by Persson's theory from the rms slope: no substitute for a map".to_owned()],
            ..SurfaceFacts::default()
        }),
        Surface::Map { path, synthetic, options, windows, after } => {
            let surface = SurfaceMap::read_period(path, options)?;
            let refuse_windows = |error: ContactError| Diagnostic {
                key: Some("surface.windows".into()),
                ..Diagnostic::file(file, error.to_string())
            };
            // Whether the map can be cut so is known before its contact is computed.
            if let Some(per_side) = windows.filter(|per_side| *per_side > 1) {
                slipgrid_contact::windows(&surface.map, per_side).map_err(refuse_windows)?;
            }
            let progress = Progress::start("area law", console.quiet);
            let curve = area_curve(&surface.map, contact_modulus_pa, &pressures_pa, CONTACT_TOLERANCE, &progress);
            progress.finish();
            heed()?;
            let curve = curve.map_err(|error| Diagnostic::file(path, error.to_string()))?;
            let mut warnings = surface.warnings.clone();
            if let Ok(law) = area_law(&curve.points, calibration.threshold_pa) {
                warnings.extend(check_factors(path, &law, &surface.warnings)?);
            }
            let mut notes = surface.notes.clone();
            let unfinished = curve.points.iter().filter(|point| point.convergence.status != Status::Converged).count();
            if unfinished > 0 {
                notes.push(format!("the contact area did not converge at {unfinished} pressures: best states taken"));
            }
            if let Some(after) = after {
                let request = (contact_modulus_pa, &pressures_pa[..], calibration.threshold_pa);
                notes.push(after_test(after, options, (&surface, &curve.points), request, console)?);
            }
            let request =
                LawRequest { contact_modulus_pa, pressures_pa: &pressures_pa, threshold_pa: calibration.threshold_pa };
            let spread = spread(&surface.map, *windows, &request, console).map_err(refuse_windows)?;
            heed()?;
            if let Some(spread) = &spread {
                notes.push(format!(
                    "factor_std: standard deviation of f among {} windows of the map over the root of their number; {WINDOW_STATEMENT}",
                    spread.count()
                ));
            }
            Ok(SurfaceFacts {
                origin: Some("map"),
                synthetic: *synthetic || surface.synthetic,
                rms_slope: Some(surface.rms_slope),
                sa_m: Some(surface.sa_m),
                pixel_m: Some(surface.pixel_m()),
                curve: curve.points,
                factor_std: spread.map(|spread| spread.factor_std()),
                notes,
                warnings,
            })
        }
    }
}

/// How the map at `path`, of a sample after the test, differs from the one before, on which the law rests.
fn after_test(
    path: &Path,
    options: &MapOptions,
    (before, curve): (&SurfaceMap, &[AreaPoint]),
    (contact_modulus_pa, pressures_pa, threshold_pa): (f64, &[f64], f64),
    console: &Console<'_>,
) -> Result<String, CliError> {
    let surface = SurfaceMap::read_period(path, options)?;
    let progress = Progress::start("area law after the test", console.quiet);
    let after = area_curve(&surface.map, contact_modulus_pa, pressures_pa, CONTACT_TOLERANCE, &progress);
    progress.finish();
    heed()?;
    let after = after.map_err(|error| Diagnostic::file(path, error.to_string()))?;
    let law = |points: &[AreaPoint]| {
        area_law(points, threshold_pa).map_err(|error| Diagnostic::file(path, error.to_string()))
    };
    let (own, other) = (law(curve)?, law(&after.points)?);
    let at: Vec<String> = AFTER_MPA
        .iter()
        .map(|mpa| {
            let [own, other] = [&own, &other].map(|law| law.factor(PRESSURE_MPA.to_si(*mpa)));
            format!("{own:.3} and {other:.3} at {mpa} MPa")
        })
        .collect();
    Ok(format!(
        "area law: of the map before the test. After it Sa is {:.3} um instead of {:.3} um and the rms slope {:.4} instead of {:.4}: f \
         before and after would be {}",
        surface.sa_m * 1e6,
        before.sa_m * 1e6,
        surface.rms_slope,
        before.rms_slope,
        at.join(", ")
    ))
}

/// The spread of f among windows of the map, where it is wanted and the map large enough.
fn spread(
    map: &HeightMap,
    wanted: Option<usize>,
    request: &LawRequest<'_>,
    console: &Console<'_>,
) -> Result<Option<WindowSpread>, ContactError> {
    let per_side = wanted.unwrap_or(if takes_default_windows(map) { DEFAULT_WINDOWS } else { 0 });
    if per_side < 2 {
        return Ok(None);
    }
    let progress = Progress::start("windows", console.quiet);
    let spread = window_spread(map, per_side, request, &progress);
    progress.finish();
    spread
}

/// The law with the standard errors of its factors, where they are known.
fn with_errors(law: AreaLaw, facts: &SurfaceFacts) -> Result<AreaLaw, MaterialError> {
    let Some(factor_std) = &facts.factor_std else { return Ok(law) };
    let at = |pressure_pa: &f64| facts.curve.iter().position(|point| point.pressure_pa == *pressure_pa);
    let errors: Option<Vec<f64>> = law.pressures_pa().iter().map(|p| at(p).map(|n| factor_std[n])).collect();
    match errors {
        Some(errors) => law.with_factor_std(errors),
        None => Ok(law),
    }
}

fn summary(calibration: &Calibration, calibrated: &Calibrated) -> String {
    let fit = &calibrated.fit;
    let mut text = format!("{} ({})\n", calibration.name, calibration.source);
    for note in &calibrated.material.provenance.notes {
        text += &format!("- {note}\n");
    }
    for warning in &calibrated.material.provenance.warnings {
        text += &format!("! {warning}\n");
    }
    let mut table = Table::new([
        "F N",
        "P MPa",
        "v mm/s",
        "RH %",
        "mu measured",
        "+-",
        "mu_d",
        "+-",
        "mu_s",
        "+-",
        "model - measured",
    ]);
    for (row, measured) in calibration.flat.iter().enumerate() {
        let pair = if fit.pairs.len() == 1 { fit.pairs.first() } else { fit.pairs.get(row) };
        table.row([
            measured.force_n.to_string(),
            fixed(Some(PRESSURE_MPA.from_si(calibration.pressure_pa(measured.force_n))), 3),
            SPEED_MM_S.from_si(measured.speed_m_s).to_string(),
            HUMIDITY_PCT.from_si(measured.humidity).to_string(),
            fixed(Some(measured.mu_dynamic), 4),
            fixed(Some(measured.mu_dynamic_std), 4),
            fixed(pair.map(|pair| pair.dynamic_mean), 4),
            fixed(pair.and_then(|pair| pair.dynamic_std_error), 4),
            fixed(pair.map(|pair| pair.static_mean), 4),
            fixed(pair.and_then(|pair| pair.static_std_error), 4),
            fixed(fit.residuals.get(row).copied(), 4),
        ]);
    }
    text += &format!("\n{table}{}", fit.details.table());
    if let Some(discrepancy) = &calibrated.discrepancy {
        text += &format!(
            "\nratios patterned / flat: measured, by the model, and predicted without the row itself\n{}",
            discrepancy.table()
        );
    } else if !calibration.patterned.is_empty() && calibration.pattern.is_none() {
        text += "\n- measurements of patterned samples are given, but not their pattern: a table [pattern] would give the model's discrepancy\n";
    }
    text
}

/// Everything that was found, for the folder of a report.
fn report(calibration: &Calibration, calibrated: &Calibrated) -> Result<Outputs, CliError> {
    let mut outputs =
        if calibration.traces.is_empty() { Outputs::default() } else { super::traces::outputs(&calibration.traces)? };
    outputs.add("fit.json", slipgrid_results::json(&calibrated.fit.details)?);
    outputs.add("profiles.csv", calibrated.fit.details.profiles());
    outputs.add("residuals.svg", details::residuals(calibration, &calibrated.fit)?);
    if let Some(discrepancy) = &calibrated.discrepancy {
        outputs.add("discrepancy.csv", discrepancy.csv());
    }
    Ok(outputs)
}
