//! Files of a designed texture or a solved scene, identical for every caller.

use slipgrid_design::DesignOutcome;
use slipgrid_design::results::SimulationReport;
use slipgrid_io::formats::Diagnostic;
use slipgrid_io::formats::confirmed_scene::DesignScene;
use slipgrid_model::springblock::{Scene, Simulation};

use crate::laser_files::about;
use crate::uncertainty_budget::{self, UncertaintyBudget};
use crate::{DrawingInput, Failure, LaserFile, Outputs, charts, csv, draw, html, linked_data, pictures};

/// Makes the files of the design `found`, except record and page (see `add_report`): scene of the run that confirms the
/// design, laser drawings, tables and pictures.
///
/// # Errors
/// [`Failure`] if a file cannot be drawn or written.
pub fn of_design(found: &DesignOutcome) -> Result<Outputs, Failure> {
    let (task, report) = (&found.task, &found.report);
    let mut outputs = Outputs::default();
    if let Some(lattice) = &found.lattice {
        outputs.add("table.csv", csv::lattice(task, lattice));
    }
    let scene = DesignScene {
        task,
        known: &found.material,
        pattern: &found.pattern,
        loads: &found.loads,
        speed_m_s: found.scene.speed_m_s,
        run: &found.scene.run,
    };
    outputs.add("scene.toml", scene.to_toml()?);
    // The laser or the specimen of the design is refused.
    draw(&drawing(found), &LaserFile::ALWAYS, &mut outputs)
        .map_err(|error| Diagnostic { reason: error.to_string(), ..Diagnostic::default() })?;
    outputs.add("interface.csv", csv::interface(&found.confirmed));
    if let Some(trace) = csv::friction_trace(&found.confirmed) {
        outputs.add("friction.csv", trace);
    }
    pictures::simulation(&found.scene, &found.confirmed, &[], &mut outputs)?;
    if let Some(compared) = &found.compared {
        outputs.add("trade-offs.csv", csv::trade_offs(compared, &found.pattern));
        if !compared.front.is_empty() {
            outputs.add("trade-offs.svg", charts::trade_offs(&task.name, compared, &found.pattern)?);
        }
    }
    let title = format!("{}: friction of a cut sample", report.name);
    outputs.add("target.svg", charts::target(&title, report, Some(found))?);
    Ok(outputs)
}

/// Adds the record of `found` (result.json and timings.json), the uncertainty budget, the description for data
/// catalogues and the page report.html to `outputs`, which has the other files of the design; the page embeds the
/// pictures in `outputs`.
///
/// # Errors
/// [`Failure`] if a value has no JSON form.
pub fn add_report(found: &DesignOutcome, outputs: &mut Outputs) -> Result<(), Failure> {
    outputs.add_record(&found.report)?;
    outputs.add(uncertainty_budget::FILE, UncertaintyBudget::csv(&UncertaintyBudget::of_design(&found.report)));
    outputs.add(linked_data::FILE, linked_data::of_design(&found.report, outputs)?);
    let law = found.material.material.area_law.as_ref();
    let page = html::design(&found.report, law, &found.loads, outputs, Some(found));
    outputs.add("report.html", page);
    Ok(())
}

/// Input for the drawings of `found`.
pub fn drawing(found: &DesignOutcome) -> DrawingInput {
    let about = about(&found.task, &found.task.name, &found.report.material);
    DrawingInput { pattern: found.pattern, outline: found.task.specimen, about }
}

/// Makes the files of a solved `scene`: record, tables and pictures.
///
/// # Errors
/// [`Failure`] if a file cannot be drawn or written.
pub fn of_scene(scene: &Scene, simulation: &Simulation, report: &SimulationReport) -> Result<Outputs, Failure> {
    let mut outputs = Outputs::default();
    outputs.add_record(report)?;
    outputs.add("interface.csv", csv::interface(simulation));
    if let Some(trace) = csv::friction_trace(simulation) {
        outputs.add("friction.csv", trace);
    }
    outputs.add(uncertainty_budget::FILE, UncertaintyBudget::csv(&UncertaintyBudget::of_scene(report)));
    pictures::simulation(scene, simulation, &report.errors.by_pressure, &mut outputs)?;
    Ok(outputs)
}
