//! `optimize`: the pattern that brings friction to a target, confirmed, and what a laser needs.

mod aim;
mod allowance;
mod announcement;
mod chance;
mod chance_report;
mod conditions;
mod conditions_report;
mod confirmation;
mod errors;
mod explanation;
mod files;
mod flat;
mod further;
mod limited;
mod material;
mod model;
mod near_trials;
mod raised;
mod reachable;
mod report;
mod robust_search;
mod robustness;
mod robustness_report;
mod rounds;
mod selection;
mod sensitivity;
mod stages;
mod study;
mod subject;
mod table;
mod target_picture;
mod target_report;
mod trade_offs;

use std::time::Instant;

use slipgrid_optimize::{ForwardModel, ModelFailure, Status};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::Scene;

pub use report::{DesignReport, StoredDesign};

use super::drawings::{DrawingInput, draw};
use super::pictures;
use crate::args::{ExportFormat, OptimizeArgs};
use crate::formats::design::Design;
use crate::interruption::{goes_on_with, heed};
use crate::lock::Lock;
use crate::output::{Outputs, Place, check_folder};
use crate::progress::Progress;
use crate::report::csv;
use crate::{CliError, Console, exit_code};
use allowance::Allowance;
use files::DesignScene;
use report::{MisfitReport, patterns};
use rounds::{Rounds, time_statement};
use slipgrid_results::{MaterialReport, PatternReport, load_reports, model_notes};
use slipgrid_results::{VERSION, json, json_and_timings};
use slipgrid_units::tidy;
use stages::Timings;
use target_report::{GoalReport, TargetReport};

/// What is written.
const FILES: [&str; 11] = [
    "report.html",
    "result.json",
    "timings.json",
    "design.toml",
    "process.toml",
    "pattern.*",
    "target.svg",
    "trade-offs.*",
    "table.*",
    "friction*",
    "interface*",
];

/// Searches, confirms, writes and reports.
pub fn run(args: &OptimizeArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let started = Instant::now();
    let mut design = Design::read(&args.design)?;
    let folder = args.output.clone().unwrap_or_else(|| subject::default_folder(&args.design));
    check_folder(Place::output(&folder), &FILES, &design.inputs)?;
    let _held = Lock::new(&subject::lock_path(&folder))?;
    let mut timings = Timings::default();
    let allowance = Allowance::new(started, design.max_seconds);
    goes_on_with(args.resuming());

    let (material, uncertainty) = material::of_design(&mut design, console)?;
    let (loads, outside) = design.loads(&material)?;
    let further = further::further(&design, &material)?;
    design.target = design.target.at_conditions(1 + further.len());
    near_trials::keep_near(&mut design, uncertainty.discrepancy_domain.as_ref());
    let with_table = args.table || design.table;
    if with_table {
        table::check(&design)?;
    }
    timings.material = started.elapsed().as_secs_f64();
    heed()?;

    let factors = further::all_factors(&design, &uncertainty, &loads, &further);
    let mut found = Rounds::new(&design, &material, loads.clone(), further, allowance, console, &mut timings)?;
    found.model.aim_with(factors);
    found.chances = Some(chance::Chances::new(&design, &uncertainty, &found.model, &found.further)?);
    let conditions = std::iter::once(design.condition).chain(found.further.iter().map(|further| further.at.condition));
    let excess = conditions.map(|condition| uncertainty.excess(&design.pressures_pa(), condition.as_ref()));
    found.excess = excess.collect();
    found.study(&design, subject::study_path(&folder), args.resume, console)?;
    found.announce(&design, with_table, console)?;
    found.run(&design, console, &mut timings)?;
    let mut outputs = Outputs::default();
    let explanation = found.explain(&design, console, &mut timings)?;
    let table = if with_table { found.compare(&design, console, &mut timings, &mut outputs)? } else { None };
    let (Some(best), Some(predicted), Some(confirmed)) = (&found.best, &found.predicted, &found.confirmed) else {
        return Err(CliError::Other("the search ended without a design".to_owned()));
    };

    let pattern = best.design;
    let probing = Progress::until("slopes and tolerances", console.quiet, allowance.until());
    let target: TargetReport = (&design.target).into();
    let watched = |at: &Pattern| if probing.is_over() { Err(ModelFailure::Cancelled) } else { found.model.respond(at) };
    let slopes = sensitivity::report(&watched, &pattern, design.layer.block_m, target.quantity, &target.pressure_mpa)?;
    let (model, choice) = (&found.model, found.choice.as_ref());
    let about = robustness::About { model, pattern: &pattern, confirmed, choice, bar: &probing };
    let spread = robustness::of_design(&design, &uncertainty, &about)?;
    let value = &best.response.value;
    let confirming = Scene { pattern: Some(pattern), run: found.confirming, ..found.scene.clone() };
    let errors = errors::of_design(&design, &uncertainty, &confirming, confirmed, value)?;
    // What a sample does whose discrepancy nobody knows has no chance that could be said.
    let is_far = design.discrepancy
        && uncertainty.discrepancy_domain.as_ref().is_some_and(|domain| !domain.far(&pattern).is_empty());
    let chance = match found.chances.as_ref().filter(|_| !is_far) {
        Some(chances) => found.chance(&design, &uncertainty, chances, &errors.report)?,
        None => None,
    };
    let conditions = found.conditions_report(&design, &uncertainty, &errors.report, &outside)?;
    let reachable = reachable::of_search(&design, &uncertainty, &found, &probing)?;
    let mut cut_short = found.cut_short.clone();
    cut_short.extend(probing.is_out_of_time().then_some("slopes and tolerances"));
    timings.uncertainty = probing.finish();
    heed()?;

    let exporting = Instant::now();
    let material_report = MaterialReport::from(&material.provenance);
    let scene = DesignScene {
        name: &design.name,
        material: &material,
        uncertainty: &uncertainty,
        condition: design.condition.as_ref(),
        pattern: &pattern,
        specimen: &design.outline,
        layer: &design.layer,
        loads: &loads,
        speed_m_s: design.speed_m_s,
        run: &found.confirming,
    };
    outputs.add("design.toml", scene.to_toml()?);
    let laid = design.outline.layout(pattern).map_err(|error| design.refuse(error.to_string()))?;
    let drawing = DrawingInput {
        name: &design.name,
        version: VERSION,
        seed: design.seed,
        pattern,
        outline: design.outline,
        laser: design.laser,
        material: &material_report,
    };
    draw(&drawing, &ExportFormat::ALL, &mut outputs).map_err(|error| design.refuse(error.to_string()))?;
    outputs.add("interface.csv", csv::interface(confirmed));
    if let Some(trace) = csv::friction_trace(confirmed) {
        outputs.add("friction.csv", trace);
    }
    pictures::simulation(&confirming, confirmed, &errors.report, &mut outputs)?;
    timings.export = exporting.elapsed().as_secs_f64();

    let comparing = Progress::until("trade-offs", console.quiet, allowance.until());
    let value = &best.response.value;
    let selection = found.selection.as_ref();
    let traded = trade_offs::report(&design, &found.model, (&pattern, value), selection, &comparing, &mut outputs)?;
    cut_short.extend((comparing.is_out_of_time() && traded.is_none()).then_some("trade-offs"));
    timings.trade_offs = comparing.finish();
    heed()?;

    let gathering = Instant::now();
    let flat = found.flat_is_best(&design);
    let suffices = flat.as_ref().is_some_and(|flat| flat.suffices);

    // What the vertical plane leaves out needs saying, and only of patterns that have it.
    let is_solid = found.model.is_solid();
    let sectioned = Some(&pattern).filter(|_| !is_solid);
    let mut model = confirmed.model.clone();
    model.extend(found.condition_statements(&design));
    model.extend(found.statements());
    model.extend(time_statement(&cut_short));
    model.extend(model_notes(sectioned, &material.provenance));
    let report = DesignReport {
        program: "slipgrid",
        version: VERSION,
        name: design.name.clone(),
        status: if suffices { raised::FLAT_IS_BEST } else { found.status.name() },
        flat,
        chance,
        selection: found.selection.as_ref().and_then(selection::Chosen::report),
        design: PatternReport::from(&pattern),
        specimen_areal_density: tidy(laid.areal_density()),
        bursts: design.laser.bursts(pattern.depth_m()),
        passes: design.laser.passes(pattern.depth_m()),
        dimensions: if is_solid { 3 } else { 2 },
        section_model: sectioned.is_some_and(|pattern| pattern.dimensions() > 2),
        fidelity: found.confirming.fidelity.name(),
        extent: found.confirming.extent.name(),
        target,
        predicted: load_reports(predicted, sectioned, &outside),
        predicted_value: best.response.value[..loads.len()].to_vec(),
        confirmed: load_reports(confirmed, sectioned, &outside),
        discrepancy: aim::DiscrepancyReport::new(&design, &uncertainty, &loads, &errors, &pattern),
        goal: GoalReport::new(&design.target, value, found.confirmed_values().as_deref(), &errors.report),
        errors: errors.report,
        conditions,
        misfit: MisfitReport { predicted: best.misfit.max, confirmed: found.confirmed_misfit(&design) },
        violations: best.violations.iter().map(ToString::to_string).collect(),
        sensitivities: slopes,
        robustness: spread,
        trade_offs: traded,
        reachable,
        explanation,
        table,
        alternatives: patterns(&found.alternatives),
        evaluations: found.evaluations,
        solid_evaluations: found.solid_evaluations,
        out_of_time: found.out_of_time,
        cut_short,
        failed_trials: found.failed_trials,
        rounds: found.rounds,
        history: found.history.clone(),
        model,
        material: material_report,
        specimen: (&design.outline).into(),
        laser: design.laser,
        timings_s: Timings { export: timings.export + gathering.elapsed().as_secs_f64(), ..timings },
        wall_s: started.elapsed().as_secs_f64(),
        threads: console.threads,
        seed: design.seed,
    };
    outputs.add("target.svg", target_picture::target(&report)?);
    let [result, timings] = json_and_timings(&report)?;
    outputs.add("result.json", result);
    outputs.add("timings.json", timings);
    super::pages::design(&report, &mut outputs)?;
    outputs.write(&folder)?;
    if args.json {
        console.out.write_all(json(&report)?.as_bytes())?;
    } else {
        console.answer(&report.summary())?;
    }
    console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    Ok(match found.status {
        Status::Met if suffices => exit_code::UNREACHABLE,
        Status::Met => exit_code::DONE,
        Status::Unreachable => exit_code::UNREACHABLE,
        Status::Budget => exit_code::BUDGET,
        Status::Cancelled => exit_code::FAILURE,
    })
}
