//! Predictions for any texture of a design: computed once for the present content of its files, then read in
//! microseconds. Results whose inputs changed since are found by the same stamps of files.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::time::SystemTime;

use axum::Json;
use axum::extract::{Query, State};
use serde::Deserialize;
use serde_json::{Value, json};
use slipgrid_base::monitor::Monitor;
use slipgrid_base::units::{HUMIDITY_PCT, LENGTH_UM, PRESSURE_MPA, SPEED_MM_S, tidy};
use slipgrid_design::{DesignError, Explored, explore_bounds};
use slipgrid_io::disk::disk;
use slipgrid_io::formats::calibrated::complete;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::design::Design;

use crate::Shared;
use crate::error::{Answer, Refused, aside};
use crate::folder::At;
use crate::jobs::{locked, start_exploring};
use crate::places::{inside, with_slashes};

/// Input files of a computation, each with its size in bytes and time of change; `None` for a file that cannot be read.
type Stamps = Vec<(PathBuf, Option<(u64, SystemTime)>)>;

/// Predictions by the paths of their designs, with the files that they were computed from.
#[derive(Default)]
pub struct Known(Mutex<HashMap<PathBuf, (Stamps, Arc<Explored>)>>);

fn stamps(paths: impl IntoIterator<Item = PathBuf>) -> Stamps {
    let stamp = |path: &Path| {
        let metadata = std::fs::metadata(path).ok()?;
        Some((metadata.len(), metadata.modified().ok()?))
    };
    paths
        .into_iter()
        .map(|path| {
            let stamp = stamp(&path);
            (path, stamp)
        })
        .collect()
}

/// Computes predictions for all textures within the bounds of the design file at `path`, and stores them in `shared`.
///
/// # Errors
/// The message of the command line, if there are no predictions.
pub fn explore(path: &str, shared: &Shared, monitor: &dyn Monitor) -> Result<(), String> {
    let path = inside(path).map_err(|refused| refused.1)?;
    let mut design = Design::read(&disk(), &path).map_err(|refused| refused.to_string())?;
    let before = stamps(design.inputs.clone());
    let calibration = complete(&mut design, &disk(), monitor).map_err(|error| error.to_string())?;
    let of_calibration = stamps(calibration.into_iter().flat_map(|read| read.inputs));
    let found = explore_bounds(&design.task, monitor).map_err(|error| match error {
        DesignError::Refused(refused) => design.refuse(&refused).to_string(),
        other => other.to_string(),
    })?;
    locked(&shared.explored.0).insert(path, ([before, of_calibration].concat(), Arc::new(found)));
    Ok(())
}

/// Stamps of the input files of the design or calibration at `path`, as far as they can be read.
fn inputs(path: PathBuf) -> Stamps {
    let (mut paths, calibration) = match Design::read(&disk(), &path) {
        Ok(design) => (design.inputs, design.calibration),
        Err(_) => (vec![path.clone()], Some(path)),
    };
    match calibration.map(|path| Calibration::read(&disk(), &path)) {
        Some(Ok(read)) => paths.extend(read.inputs),
        Some(Err(refused)) => paths.extend(refused.file.map(PathBuf::from)),
        None => {}
    }
    paths.sort();
    paths.dedup();
    stamps(paths)
}

/// Paths of a result and of the design or calibration that it was made from, in the query of a request.
#[derive(Deserialize)]
pub struct Made {
    path: String,
    result: String,
}

/// Answers with the input files that are newer than a result, which is as old as the beginning of its run.
pub async fn changed(State(shared): State<Arc<Shared>>, Query(made): Query<Made>) -> Answer<Value> {
    aside(move || {
        let (path, result) = (inside(&made.path)?, inside(&made.result)?);
        let began = std::fs::metadata(&result).and_then(|metadata| metadata.modified());
        let began = began.map_err(|error| Refused::system(&result, &error))?;
        let inputs = inputs(path).into_iter().map(|(path, stamp)| (with_slashes(&path), stamp));
        let came = locked(&shared.came);
        let is_newer = |(path, stamp): &(String, Option<(u64, SystemTime)>)| {
            stamp.is_none_or(|(_, time)| time > began || came.get(path).is_some_and(|came| *came > began))
        };
        Ok(json!({ "changed": inputs.filter(is_newer).map(|(path, _)| path).collect::<Vec<_>>() }))
    })
    .await
}

/// Answers a request to start the computation of predictions for a design.
pub async fn start(State(shared): State<Arc<Shared>>, Json(of): Json<At>) -> Answer<Value> {
    start_exploring(&shared, &of.path)
}

/// Path of a design and lengths of a texture, in the query of a request.
#[derive(Deserialize)]
pub struct Texture {
    path: String,
    width_um: f64,
    spacing_um: f64,
    depth_um: f64,
}

/// Answers with the predictions for one texture; refuses if none were computed for the present files.
pub async fn predict(State(shared): State<Arc<Shared>>, Query(texture): Query<Texture>) -> Answer<Value> {
    aside(move || {
        let path = inside(&texture.path)?;
        let known = locked(&shared.explored.0).get(&path).cloned();
        let current = known.filter(|(known, _)| stamps(known.iter().map(|(path, _)| path.clone())) == *known);
        let (_, found) =
            current.ok_or_else(|| Refused::conflict("no predictions were computed for what the files say now"))?;
        let lengths_um = [texture.width_um, texture.spacing_um, texture.depth_um];
        let points = found.task.target.points();
        let read = found.predict(lengths_um);
        // Values are those of the first condition; the chance is that of all.
        let has_several = !found.task.also_at.is_empty() || !found.task.directions.different_deg.is_empty();
        let condition = found.task.condition.filter(|_| has_several).map(|at| {
            format!("{} mm/s, {} %", tidy(SPEED_MM_S.from_si(at.speed_m_s)), tidy(HUMIDITY_PCT.from_si(at.humidity)))
        });
        let band = |end: usize| points.iter().map(|point| point.wanted.band()[end]).collect::<Vec<_>>();
        let read = read.as_ref();
        Ok(json!({
            "pressure_mpa": points.iter().map(|point| tidy(PRESSURE_MPA.from_si(point.pressure_pa))).collect::<Vec<_>>(),
            "condition": condition,
            "quantity": found.task.target.quantity().name(),
            "lowest": band(0),
            "highest": band(1),
            "expected": read.map(|read| &read.expected),
            "lower_95": read.map(|read| &read.lower_95),
            "upper_95": read.map(|read| &read.upper_95),
            "chance": read.and_then(|read| read.chance),
            "peak_pressure_mpa": read.map(|read| read.peak_pressure_mpa),
            "clearance_um": read.map(|read| read.clearance_um),
            "areal_density": read.map(|read| read.areal_density),
            "exposures": read.and_then(|read| read.exposures),
            "exposures_name": found.task.laser.exposures_name(),
            "laser_s": read.and_then(|read| read.laser_s),
            "bounds_um": found.task.space.lengths_m().map(|ends| ends.map(|m| tidy(LENGTH_UM.from_si(m)))),
            "best_um": found.pattern.lengths_m().map(|m| tidy(LENGTH_UM.from_si(m))),
        }))
    })
    .await
}
