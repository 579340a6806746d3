//! Session that `optimize` and `next` share: the table over the bounds and the search in it.

use slipgrid_base::units::counted;
use slipgrid_laser::export::Division;
use slipgrid_model::springblock::{Fidelity, Load, RunOptions};

use crate::DesignError;
use crate::as_cut::BeyondCells;
use crate::band::Asked;
use crate::cache_key::cache_key;
use crate::cost_estimate::announce;
use crate::evaluation_cache::{EvaluationCache, Evaluations};
use crate::inputs::Inputs;
use crate::prepared_task::PreparedTask;
use crate::search::Search;
use crate::sensitivities::Models;
use crate::steady_model::SteadyModel;
use crate::table::Table;
use crate::time_budget::TimeBudget;
use crate::timings::Timings;

/// Message if the time limit ended before the table was complete.
const NO_TABLE: &str = "max_seconds was spent before the designs within the bounds were tabulated";

/// Tabulates the model over the bounds of `prepared` and calls `then` with the search. With `division`, samples are
/// sectors of one specimen. `cache`, if given, stores the results of the model.
///
/// # Errors
/// [`DesignError`] for a task that is refused or that the monitor cancels, where no design can be computed, and those of `then`.
pub fn with_table<T>(
    prepared: &PreparedTask,
    division: Option<&Division>,
    cache: Option<&mut dyn EvaluationCache>,
    budget: TimeBudget<'_>,
    timings: &mut Timings,
    then: impl FnOnce(&Search<'_>, &mut Timings) -> Result<T, DesignError>,
) -> Result<T, DesignError> {
    let PreparedTask { task, material, settings, .. } = prepared;
    let monitor = budget.monitor;
    let began_s = monitor.seconds();
    let run = RunOptions { fidelity: Fidelity::Steady, dimensions: task.search.dimensions, ..RunOptions::default() };
    let scene = task.flat_scene(material, prepared.loads().to_vec(), run);
    let elsewhere: Vec<&[Load]> = settings[1..].iter().map(|at| &at.loads[..]).collect();
    let model = SteadyModel::new(&scene, &elsewhere, &task.directions.different_deg, &task.space);
    let model = model.watched_by(monitor);
    // A sector is modelled as part of an infinite pattern: the pressed area has no outer rim.
    let mut model = if division.is_none() { model.on(task.specimen) } else { model };
    announce(prepared, &model, cache.is_some(), monitor)?;
    if let Some(cache) = cache {
        let place = cache.place();
        let key = cache_key(model.asked(), task.space.texture(), &task.directions.different_deg);
        let (evaluations, known) = Evaluations::cached(cache, &key, model.asked().loads.len())?;
        if known > 0 {
            monitor.note(&format!("took over {} from {place}", counted(known, "answer")));
        }
        model.keep(evaluations);
    }
    let asked = Asked::new(prepared)?;
    let models = Models::new(&model, prepared)?;
    let inputs = Inputs::new(prepared, &model, asked.flat_rest.as_ref())?;
    let face = Some(task.specimen).filter(|_| division.is_none());
    let beyond = BeyondCells { model: &model, face, count: asked.count, seed: task.search.seed };

    let before_s = monitor.seconds() - began_s;
    let stage = budget.stage_of_share("table");
    let table = Table::new(task, &models, &beyond, &stage);
    let is_out_of_time = stage.is_out_of_time();
    timings.table = before_s + stage.finish();
    monitor.heed()?;
    let table = match table {
        Some(table) => table,
        None if is_out_of_time => return Err(DesignError::OutOfTime(NO_TABLE.to_owned())),
        None => return Err(model.nothing_computed(&task.space)),
    };
    let searching_s = monitor.seconds();
    let stage = budget.stage_of_share("search");
    let search = Search::new((prepared, &asked), (&models, &inputs), (&beyond, &table), &stage);
    timings.search = monitor.seconds() - searching_s;
    then(&search, timings)
}
