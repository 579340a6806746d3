//! How the target's quantity moves with the height of the rims; of a design without rims, what one would change.
//!
//! A rim of a tenth of a micrometre moves friction more than any dimension of the cavity, and lasers leave rims: so a design
//! that has none says what one would do to it.

use serde::{Deserialize, Serialize};
use slipgrid_optimize::{ModelFailure, Tolerances, with_rim_off};
use slipgrid_pattern::{Pattern, Rim, RimProfile};
use slipgrid_results::RimReport;
use slipgrid_springblock::{Layer, Scene, cell_expense};
use slipgrid_units::{LENGTH_UM, PRESSURE_MPA, tidy};

use crate::DesignError;
use crate::sensitivity::SensitivityReport;
use crate::steady_model::SteadyModel;

/// The rim that a design without rims is tried with, in metres.
const TRIED_HEIGHT_M: f64 = 1e-7;
const TRIED_WIDTH_M: f64 = 10e-6;
/// Step of the height: a share of it, and no less than this, in metres.
const STEP_SHARE: f64 = 0.05;
const LEAST_STEP_M: f64 = 2e-8;
/// Seconds of one core that cells in smaller blocks than the search's may take.
const MOST_CORE_S: f64 = 4.0;

/// What the height of rims moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RimSensitivityReport {
    /// The design has no rims: the values are for rims with which it was tried.
    pub tried: bool,
    /// The rims: the design's own, or those it was tried with; null where the model saw none.
    pub rim: Option<RimReport>,
    /// Size of the blocks, at most half a rim wide.
    pub block_um: f64,
    /// Step of the differences in height; that of the whole rim where it was tried.
    pub step_um: f64,
    /// One per pressure that was computed, at the condition designed for.
    pub by_pressure: Vec<RimSlopeReport>,
    /// All this in a sentence, or the reason why it is missing.
    pub words: String,
}

/// The slope at one pressure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RimSlopeReport {
    /// Nominal pressure.
    pub pressure_mpa: f64,
    /// d(value)/d(height of the rims) per um; of rims that were tried the change over their height.
    pub per_um: f64,
    /// How far the slope at twice the step is from it; null for rims that were tried.
    pub error_per_um: Option<f64>,
    /// Change of the value by the rims that were tried; null for the design's own.
    pub change: Option<f64>,
}

/// What slopes are taken of.
pub struct Asked<'a> {
    /// The model of the search.
    pub model: &'a SteadyModel<'a>,
    /// The design.
    pub design: &'a Pattern,
    /// Pressures of the condition designed for.
    pub pressures: usize,
    /// The search's layer.
    pub layer: &'a Layer,
    /// How samples scatter, where that is known.
    pub tolerances: Option<&'a Tolerances>,
}

/// Slopes of the target's quantity along the height of the rims of `asked`, in blocks of at most half their width, beside
/// those of `others`; `None` where `stopped` says so, or where rims change nothing.
///
/// # Errors
/// [`DesignError::Failed`] for a model that is broken.
pub fn report(
    asked: &Asked<'_>,
    others: &SensitivityReport,
    stopped: &dyn Fn() -> bool,
) -> Result<Option<RimSensitivityReport>, DesignError> {
    let own = asked.design.texture().rim().copied();
    let tried = || Rim::new(TRIED_HEIGHT_M, TRIED_WIDTH_M, RimProfile::Round);
    let Ok(rim) = own.map_or_else(tried, Ok) else { return Ok(None) };
    let layer = Layer { block_m: rim.block_m(asked.layer.block_m), ..*asked.layer };
    let scene = |scene: &Scene| Scene { layer, loads: loads(asked, scene), ..scene.clone() };
    let model = asked.model.beside(|of| Ok::<_, DesignError>(scene(of)))?;
    let least = RimSensitivityReport {
        tried: own.is_none(),
        rim: RimReport::of(&rim),
        block_um: LENGTH_UM.from_si(layer.block_m),
        ..RimSensitivityReport::default()
    };
    let nothing = |reason: &str| {
        let what = if own.is_some() { "the height of the rims" } else { "a rim" };
        let words = format!("what {what} would change was not computed: {reason}");
        Ok(Some(RimSensitivityReport { words, ..least.clone() }))
    };
    let cells = if own.is_some() { 4.0 } else { 2.0 };
    let core_s = cells * cell_expense(&model.scene(asked.design)).core_s;
    if layer.block_m < asked.layer.block_m && core_s > MOST_CORE_S {
        return nothing(&format!("cells in blocks of {} um would take about {core_s:.0} s", least.block_um));
    }
    if stopped() {
        return Ok(None);
    }
    let found = match own {
        Some(_) => of_own(&model, asked.design),
        None => of_tried(&model, asked.design, rim),
    };
    let (step_m, slopes) = match found {
        Ok(found) => found,
        Err(ModelFailure::Trial { reason }) => return nothing(&reason),
        Err(ModelFailure::Cancelled) => return Ok(None),
        Err(failure) => return Err(DesignError::Failed(failure.to_string())),
    };
    let (rows, scales) = (asked.pressures.min(slopes.len()), asked.model.scales(asked.design));
    // A metre's slope times 1e-6 is a micrometre's.
    let slope = |(load, [per_m, error_per_m]): (usize, &[f64; 2])| {
        // A model that keeps one load of several keeps the lowest pressure.
        let pressure_pa = model.asked().loads[load].pressure_pa;
        let place = asked.model.asked().loads[..asked.pressures].iter().position(|own| own.pressure_pa == pressure_pa);
        let scale = scales[place.unwrap_or(load)];
        RimSlopeReport {
            pressure_mpa: PRESSURE_MPA.from_si(pressure_pa),
            per_um: tidy(scale * per_m * 1e-6),
            error_per_um: own.map(|_| tidy(scale * error_per_m * 1e-6)),
            change: own.is_none().then(|| tidy(scale * per_m * step_m)),
        }
    };
    let by_pressure: Vec<RimSlopeReport> = slopes[..rows].iter().enumerate().map(slope).collect();
    let most = by_pressure.iter().max_by(|a, b| a.per_um.abs().total_cmp(&b.per_um.abs()));
    let Some(most) = most.filter(|most| most.per_um != 0.0) else { return Ok(None) };
    let words = words(most, others, asked.tolerances, &rim);
    Ok(Some(RimSensitivityReport { step_um: LENGTH_UM.from_si(step_m), by_pressure, words, ..least }))
}

/// Loads of the condition designed for, in space the lowest alone; all where designs slide in several directions.
fn loads(asked: &Asked<'_>, scene: &Scene) -> Vec<slipgrid_springblock::Load> {
    if asked.model.has_directions() {
        return scene.loads.clone();
    }
    let own = &scene.loads[..asked.pressures];
    let lowest = own.iter().min_by(|a, b| a.pressure_pa.total_cmp(&b.pressure_pa)).copied();
    let is_tried = asked.design.texture().rim().is_none();
    match lowest.filter(|_| !asked.model.is_cheap_per_design() && is_tried) {
        Some(lowest) => vec![lowest],
        None => own.to_vec(),
    }
}

/// A step in metres, with the slope of each ratio and its error, per metre.
type Slopes = (f64, Vec<[f64; 2]>);

/// Central differences in the height of the design's own rims; upwards alone where they are lower than two steps.
fn of_own(model: &SteadyModel<'_>, design: &Pattern) -> Result<Slopes, ModelFailure> {
    let height_m = design.rim_height_m();
    let step_m = (STEP_SHARE * height_m).max(LEAST_STEP_M);
    let laid = model.lay(design)?;
    let at = |by_m: f64| model.ratios_made(&with_rim_off(design, by_m), &laid);
    let is_central = height_m >= 2.0 * step_m;
    let slope = |step_m: f64| -> Result<Vec<f64>, ModelFailure> {
        let below_m = if is_central { -step_m } else { 0.0 };
        let (above, below) = (at(step_m)?, at(below_m)?);
        // [v(h + s) - v(h - s)] / 2s
        Ok(above.iter().zip(&below).map(|(above, below)| (above - below) / (step_m - below_m)).collect())
    };
    let (near, wide) = (slope(step_m)?, slope(2.0 * step_m)?);
    Ok((step_m, near.iter().zip(&wide).map(|(near, wide)| [*near, (near - wide).abs()]).collect()))
}

/// What `rim` makes of a design without rims, over its height.
fn of_tried(model: &SteadyModel<'_>, design: &Pattern, rim: Rim) -> Result<Slopes, ModelFailure> {
    let raised = design.to_owned().with_rim(rim);
    let laid = model.lay(design)?;
    let (with, without) = (model.ratios_made(&raised, &laid)?, model.ratios_made(design, &laid)?);
    let slope = |(with, without): (&f64, &f64)| [(with - without) / TRIED_HEIGHT_M, 0.0];
    Ok((TRIED_HEIGHT_M, with.iter().zip(&without).map(slope).collect()))
}

/// What rims change most, beside the dimensions.
fn words(most: &RimSlopeReport, others: &SensitivityReport, tolerances: Option<&Tolerances>, rim: &Rim) -> String {
    let pressure_mpa = most.pressure_mpa;
    let quantity = if others.quantity == "ratio" { "the ratio" } else { &others.quantity };
    let at = others.by_pressure.iter().find(|row| row.pressure_mpa == pressure_mpa);
    let per_um: Vec<f64> = at.iter().flat_map(|row| row.per_um.all()).flatten().map(f64::abs).collect();
    let Some(change) = most.change else {
        let is_largest = !per_um.is_empty() && per_um.iter().all(|slope| *slope < most.per_um.abs());
        return format!(
            "rims higher by 0.1 um would change {quantity} at {pressure_mpa} MPa by {:.3}{}",
            0.1 * most.per_um,
            if is_largest { " (the height of the rims has the largest slope of all)" } else { "" }
        );
    };
    // What one standard deviation of each dimension changes, or a micrometre where nobody says how well they are made.
    let std_um = tolerances.map(|known| known.std_m.map(|std_m| LENGTH_UM.from_si(std_m)));
    let by_dimension = at.iter().flat_map(|row| row.per_um.all()).zip(std_um.unwrap_or([1.0; 3]));
    let moved: Vec<f64> = by_dimension.filter_map(|(slope, std_um)| Some((slope? * std_um).abs())).collect();
    let is_more = !moved.is_empty() && moved.iter().all(|moved| *moved < change.abs());
    let than = match (is_more, tolerances) {
        (false, _) => "",
        (true, Some(_)) => " (more than any dimension's tolerance)",
        (true, None) => " (more than a micrometre of any dimension)",
    };
    format!(
        "a rim of {} um, {} um wide, would change {quantity} at {pressure_mpa} MPa by {change:.3}{than}",
        LENGTH_UM.from_si(TRIED_HEIGHT_M),
        LENGTH_UM.from_si(rim.width_m()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensitivity::{Dimensions, SlopesReport};

    #[test]
    fn the_largest_change_is_said_beside_what_dimensions_do() {
        let row = SlopesReport {
            pressure_mpa: 0.65,
            per_um: Dimensions { width: Some(-2e-3), spacing: Some(1e-3), depth: None },
            error_per_um: Dimensions::default(),
        };
        let others = SensitivityReport {
            quantity: "ratio".into(),
            step_um: Dimensions::default(),
            by_pressure: vec![row],
            errors_have_blocks: false,
            rim: None,
        };
        let rim = Rim::new(TRIED_HEIGHT_M, TRIED_WIDTH_M, RimProfile::Round).unwrap();
        let tried = RimSlopeReport { pressure_mpa: 0.65, per_um: -0.9, error_per_um: None, change: Some(-0.09) };
        let said = |row: &RimSlopeReport, width_um: Option<f64>| {
            let known = width_um.map(|um| Tolerances { std_m: [um * 1e-6, 1e-6, 0.0], ..Tolerances::default() });
            words(row, &others, known.as_ref(), &rim)
        };
        let start = "a rim of 0.1 um, 10 um wide, would change the ratio at 0.65 MPa by -0.090";
        assert_eq!(said(&tried, Some(8.0)), format!("{start} (more than any dimension's tolerance)"));
        assert_eq!(said(&tried, Some(50.0)), start);
        assert_eq!(said(&tried, None), format!("{start} (more than a micrometre of any dimension)"));
        let own = RimSlopeReport { error_per_um: Some(0.0), change: None, ..tried };
        let own_said = said(&own, None);
        assert!(own_said.starts_with("rims higher by 0.1 um would change the ratio at 0.65 MPa by -0.090 (the height"));
        let small = RimSlopeReport { per_um: -1e-3, ..own };
        assert!(said(&small, None).ends_with("by -0.000"));
    }
}
