//! `optimize`: the pattern that brings friction to a target, confirmed, and what a laser needs.

mod aim;
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
mod in_time;
mod limited;
mod material;
mod model;
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

use slipgrid_optimize::Status;
use slipgrid_springblock::Scene;

pub use report::{DesignReport, StoredDesign};

use super::drawings::{DrawingInput, draw};
use super::pictures;
use crate::args::{ExportFormat, OptimizeArgs};
use crate::formats::design::Design;
use crate::output::{Outputs, check_folder};
use crate::report::simulation::{MaterialReport, PatternReport, load_reports, model_notes};
use crate::report::{VERSION, csv, json};
use crate::{CliError, Console, exit_code};
use files::DesignScene;
use report::{MisfitReport, patterns};
use rounds::Rounds;
use stages::Timings;
use target_report::{GoalReport, TargetReport};

/// Searches, confirms, writes and reports.
pub fn run(args: &OptimizeArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let started = Instant::now();
    let mut design = Design::read(&args.design)?;
    let folder = args.output.clone().unwrap_or_else(|| subject::default_folder(&args.design));
    check_folder(&folder)?;
    let mut timings = Timings::default();

    let (material, uncertainty) = material::of_design(&mut design, console)?;
    let (loads, outside) = design.loads(&material)?;
    let further = further::further(&design, &material)?;
    design.target = design.target.at_conditions(1 + further.len());
    let with_table = args.table || design.table;
    if with_table {
        table::check(&design)?;
    }
    timings.material = started.elapsed().as_secs_f64();

    let factors = further::all_factors(&design, &uncertainty, &loads, &further);
    let mut found = Rounds::new(&design, &material, loads.clone(), further, console, &mut timings)?;
    found.model.aim_with(factors);
    found.chances = Some(chance::Chances::new(&design, &uncertainty, &found.model, &found.further)?);
    found.study(&design, subject::study_path(&folder), args.resume, console)?;
    found.run(&design, console, &mut timings)?;
    let mut outputs = Outputs::default();
    let explanation = found.explain(&design, console, &mut timings)?;
    let table = if with_table { found.compare(&design, console, &mut timings, &mut outputs)? } else { None };
    let Rounds { best, predicted, confirmed, .. } = &found;
    let (Some(best), Some(predicted), Some(confirmed)) = (best, predicted, confirmed) else {
        return Err(CliError::Other("the search ended without a design".to_owned()));
    };

    let pattern = best.design;
    let probing = Instant::now();
    let target: TargetReport = (&design.target).into();
    let slopes =
        sensitivity::report(&found.model, &pattern, design.layer.block_m, target.quantity, &target.pressure_mpa)?;
    let about = robustness::About { model: &found.model, pattern: &pattern, confirmed, choice: found.choice.as_ref() };
    let spread = robustness::of_design(&design, &uncertainty, &about)?;
    let value = &best.response.value;
    let confirming = Scene { pattern: Some(pattern), run: found.confirming, ..found.scene.clone() };
    let errors = errors::of_design(&design, &uncertainty, &confirming, confirmed, value)?;
    let chance = match &found.chances {
        Some(chances) => found.chance(&design, &uncertainty, chances, &errors.report)?,
        None => None,
    };
    let conditions = found.conditions_report(&design, &uncertainty, &errors.report, &outside)?;
    timings.uncertainty = probing.elapsed().as_secs_f64();

    let exporting = Instant::now();
    let material_report = MaterialReport::from(&material.provenance);
    let scene = DesignScene {
        name: &design.name,
        material: &material,
        uncertainty: &uncertainty,
        condition: design.condition.as_ref(),
        pattern: &pattern,
        layer: &design.layer,
        loads: &loads,
        speed_m_s: design.speed_m_s,
        run: &found.confirming,
    };
    outputs.add("design.toml", scene.to_toml()?);
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

    let comparing = Instant::now();
    let traded = trade_offs::report(
        &design,
        &found.model,
        &pattern,
        &best.response.value,
        found.selection.as_ref(),
        &mut outputs,
    )?;
    timings.trade_offs = comparing.elapsed().as_secs_f64();

    let flat = found.flat_is_best(&design);
    let suffices = flat.as_ref().is_some_and(|flat| flat.suffices);

    // What the vertical plane leaves out needs saying, and only of patterns that have it.
    let is_solid = found.model.is_solid();
    let sectioned = Some(&pattern).filter(|_| !is_solid);
    let mut model = confirmed.model.clone();
    model.extend(found.condition_statements(&design));
    model.extend(found.statements());
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
        bursts: design.constraints.limits.bursts(pattern.depth_m()),
        dimensions: if is_solid { 3 } else { 2 },
        section_model: sectioned.is_some_and(|pattern| pattern.dimensions() > 2),
        fidelity: found.confirming.fidelity.name(),
        extent: found.confirming.extent.name(),
        target,
        predicted: load_reports(predicted, sectioned, &outside),
        predicted_value: best.response.value[..loads.len()].to_vec(),
        confirmed: load_reports(confirmed, sectioned, &outside),
        discrepancy: aim::DiscrepancyReport::new(&design, &uncertainty, &loads, &errors),
        goal: GoalReport::new(&design.target, value, found.confirmed_values().as_deref(), &errors.report),
        errors: errors.report,
        conditions,
        misfit: MisfitReport { predicted: best.misfit.max, confirmed: found.confirmed_misfit(&design) },
        violations: best.violations.iter().map(ToString::to_string).collect(),
        sensitivities: slopes,
        robustness: spread,
        trade_offs: traded,
        reachable: reachable::of_search(&design, &uncertainty, &found)?,
        explanation,
        table,
        alternatives: patterns(&found.alternatives),
        evaluations: found.evaluations,
        solid_evaluations: found.solid_evaluations,
        out_of_time: found.out_of_time,
        failed_trials: found.failed_trials,
        rounds: found.rounds,
        history: found.history.clone(),
        model,
        material: material_report,
        specimen: (&design.outline).into(),
        laser: design.laser,
        timings_s: timings,
        wall_s: started.elapsed().as_secs_f64(),
        threads: console.threads,
        seed: design.seed,
    };
    outputs.add("target.svg", target_picture::target(&report)?);
    outputs.add("result.json", json(&report)?);
    super::pages::design(&report, &mut outputs)?;
    outputs.write(&folder)?;
    let text = if args.json { json(&report)? } else { report.summary() };
    console.out.write_all(text.as_bytes())?;
    console.note(&format!("wrote {} to {}", outputs.names().join(", "), folder.display()));
    Ok(match found.status {
        Status::Met if suffices => exit_code::UNREACHABLE,
        Status::Met => exit_code::DONE,
        Status::Unreachable => exit_code::UNREACHABLE,
        Status::Budget => exit_code::BUDGET,
        Status::Cancelled => exit_code::FAILURE,
    })
}
