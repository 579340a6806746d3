//! Friction ratios of patterns on specimens, from strips or from one cell.

use crate::export::{ExportError, Layout, Specimen};
use slipgrid_base::monitor::cached;
use slipgrid_model::pattern::Pattern;
use slipgrid_model::springblock::{
    Extent, Face, Load, Monitor, RunOptions, Scene, SceneError, Simulation, Status, SteadyCell, Strip, add_tilt,
    even_speed_m_s, simulate, simulate_specimen, simulate_strip, steady_face_bytes, steady_face_ratios, tilt_shifts,
    time_changes,
};

use crate::specimen::laid::{Laid, cavity_fraction, density_share, on_face};

/// Number of bands into which a face is divided across the sliding direction; the strip in the middle of each band is
/// solved. On discs of 10 mm the ratio from 32 bands differs from the one from 128 bands by less than the stated error
/// (`bands_sample_a_disc`).
const BANDS: usize = 32;
/// Number of bands for rough corrections: a fifth of the cost, at an accuracy of about a tenth of the corrections.
const ROUGH_BANDS: usize = 6;
/// Root-mean-square deviation of rows of squares, solved in three dimensions, from the formula 1 - r = (1 - `r_cell`) D
/// / `D_period`, over the deviation of grooves of the same section. Measured for five textures at three loads
/// (`rows_in_space_depart_from_the_rule_as_far_as_is_stated`).
const ROW_ERROR_OVER_GROOVES: f64 = 1.7;
/// Fraction of the layout error that remains if the row through the middle of the specimen is solved as a strip: root
/// mean square over the textures of `ROW_ERROR_OVER_GROOVES`.
const OTHER_ROWS_ERROR: f64 = 0.3;
/// Minimum length of a strip that is solved, in blocks. Shorter strips have no interior and hardly any area.
const MIN_STRIP_BLOCKS: f64 = 2.0;

/// Reason why a pattern on a specimen was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecimenError {
    /// The solver refuses the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The pattern does not fit on the specimen.
    #[error(transparent)]
    Layout(#[from] ExportError),
}

/// Solves `scene` on `specimen`; without a specimen, on the strip or cell that the scene specifies.
///
/// # Errors
/// [`SpecimenError`] if the scene is invalid or the pattern does not fit on the specimen.
pub fn simulate_on(
    scene: &Scene,
    specimen: Option<&Specimen>,
    monitor: &dyn Monitor,
) -> Result<Simulation, SpecimenError> {
    let Some((specimen, pattern)) = specimen.zip(scene.pattern) else { return Ok(simulate(scene, monitor)?) };
    let scene = &with_specimen_length(specimen, &pattern, scene);
    let layout = specimen.layout(pattern)?;
    if scene.dimension().takes_strips() {
        return Ok(simulate_specimen(scene, &solved_face(BANDS, &layout, scene.layer.block_m)?, monitor)?);
    }
    let share = density_share(&layout, scene.dimension());
    let (mut simulation, strip_density_ratio) = if scene.run.extent == Extent::Strip {
        simulate_strip(scene, &middle_row(&layout, scene.layer.block_m)?, monitor)?
    } else {
        (simulate(scene, monitor)?, 1.0)
    };
    let mut ends = layout_errors(scene, specimen, &pattern, monitor)?;
    if scene.run.extent == Extent::Strip {
        ends.iter_mut().flatten().for_each(|error| *error *= OTHER_ROWS_ERROR);
    }
    if monitor.cancelled() {
        // The error is not known after a cancellation.
        simulation.loads.iter_mut().for_each(|load| load.surface.status = Status::Cancelled);
    }
    // 1 - r = D (1 - r_strip) / D_strip, or with one cell for the strip.
    for (load, error) in simulation.loads.iter_mut().zip(&ends) {
        load.scale_to_layout(share / strip_density_ratio, *error);
    }
    let whole = face_from_strips(&layout, layout.strips(BANDS), scene.layer.block_m)?;
    add_tilt(&mut simulation, scene, &pattern, &whole, share, monitor);
    let largest = ends.iter().flatten().copied().fold(0.0, f64::max);
    simulation.statements.model(format!(
        "specimen as it is laid out: cavities take {:.2} % of its face, {:.2} % of {}; friction is lowered in that proportion, which gives the ratio an error of {largest:.4} at most, as strips of grooves and rows in space show",
        100.0 * layout.areal_density(),
        100.0 * pattern.areal_density() * strip_density_ratio,
        if scene.run.extent == Extent::Strip { "the strip through its middle" } else { "a period" },
    ));
    Ok(simulation)
}

/// Strip of the row of cavities through the middle of `layout`, with its ends and margins. If a hole divides the row,
/// the longer part.
fn middle_row(layout: &Layout, block_m: f64) -> Result<Strip, SceneError> {
    let face = face_from_strips(layout, layout.central_strip(), block_m)?;
    let textured = face.strips().iter().filter(|strip| !strip.cavities_m.is_empty());
    let longest = textured.reduce(|longest, strip| if strip.length_m > longest.length_m { strip } else { longest });
    longest.cloned().ok_or(SceneError::Unsupported {
        what: "a strip of a specimen that has no cavity on the line through its middle",
        instead: "ask for extent = \"sample\"",
    })
}

/// Returns `scene` with `pattern` and with the length of `specimen` along the sliding direction.
fn with_specimen_length(specimen: &Specimen, pattern: &Pattern, scene: &Scene) -> Scene {
    let mut scene = Scene { pattern: Some(*pattern), ..scene.clone() };
    let sliding = pattern.texture().sliding_direction_on_specimen();
    scene.layer.length_m = specimen.whole_length_m(sliding, scene.layer.block_m);
    scene
}

/// Strips of `layout` for the solver: those of all `bands` for grooves across the sliding direction, and the strip
/// through the middle of the cavities for other planforms in two dimensions.
fn solved_face(bands: usize, layout: &Layout, block_m: f64) -> Result<Face, SceneError> {
    let is_groove = layout.pattern().texture().is_one_section();
    let strips = if is_groove { layout.strips(bands) } else { layout.central_strip() };
    face_from_strips(layout, strips, block_m)
}

fn face_from_strips(layout: &Layout, strips: Vec<Strip>, block_m: f64) -> Result<Face, SceneError> {
    let is_groove = layout.pattern().texture().is_one_section();
    let share = if is_groove { layout.areal_density() } else { cavity_fraction(&strips) };
    let kept = strips.into_iter().filter(|strip| strip.length_m >= MIN_STRIP_BLOCKS * block_m);
    Face::new(kept.collect(), share)
}

/// Corrections that convert steady ratios of an infinite pattern, `r_cell`, to ratios r of a specimen, at the loads of
/// a scene:
///
/// ```text
/// r = 1 - (1 - r_cell) D / D_period + ends + tilt
/// ```
///
/// D and `D_period` are the areal densities of the face and of the infinite pattern. `ends` is the deviation of the
/// strips from the first two terms, solved for grooves across the sliding direction; for other planforms it is 0 here
/// and part of the error ([`simulate_on`]). `tilt` is the mean effect of the pressure gradient that friction causes; it
/// depends on the holder.
#[derive(Clone, Debug)]
pub struct SteadyOnFace {
    laid: Laid,
    /// Sum of the corrections for the specimen's ends and pressure tilt at each load; `None` if strips have no ratio.
    added: Vec<Option<f64>>,
}

impl SteadyOnFace {
    /// Computes the corrections for `pattern`, which replaces that of `scene`, on `specimen`. Takes them from the cache
    /// of `monitor` if it holds them, for example from an earlier trial. With `is_rough`, few strips are solved, for
    /// ranking designs: the corrections are accurate to about a tenth, at a fifth of the cost.
    ///
    /// # Errors
    /// [`SpecimenError`] if the scene is invalid or the pattern does not fit on the specimen.
    pub fn new(
        scene: &Scene,
        pattern: &Pattern,
        specimen: &Specimen,
        is_rough: bool,
        monitor: &dyn Monitor,
    ) -> Result<Self, SpecimenError> {
        let scene = with_specimen_length(specimen, pattern, scene);
        scene.validate()?;
        let layout = specimen.layout(*pattern)?;
        let laid = Laid::from_layout(&layout, scene.dimension());
        let share = laid.share(pattern);
        let bands = if is_rough { ROUGH_BANDS } else { BANDS };
        let content = (bands, &scene, pattern, specimen);
        let solve = || ends_and_tilt(bands, &scene, pattern, (&layout, share), monitor);
        let added = cached(monitor, ("face", &content), 0.0, solve)?;
        Ok(Self { laid, added })
    }

    /// Memory, in bytes, that [`Self::new`] needs for the equations of the strips; 0 if no strips are solved.
    ///
    /// # Errors
    /// Errors of [`Self::new`] that are known before solving.
    pub fn bytes(scene: &Scene, pattern: &Pattern, specimen: &Specimen) -> Result<f64, SpecimenError> {
        let scene = with_specimen_length(specimen, pattern, scene);
        scene.validate()?;
        if !scene.dimension().takes_strips() {
            return Ok(0.0);
        }
        Ok(steady_face_bytes(&scene, pattern, &solved_face(BANDS, &specimen.layout(*pattern)?, scene.layer.block_m)?)?)
    }

    /// Areal density of the face over that of an infinite pattern, for a sample with the dimensions `made`.
    pub fn share(&self, made: &Pattern) -> f64 {
        self.laid.share(made)
    }

    /// Term added to the friction ratio for the specimen's ends and pressure tilt at the load with the index `place`,
    /// after the correction for areal density; `None` if strips have no ratio.
    pub fn added(&self, place: usize) -> Option<f64> {
        self.added.get(place).copied().flatten()
    }

    /// Friction ratio on the specimen at the load with the index `place`, for a cut sample with the dimensions `made`;
    /// `cell` is the ratio of an infinite pattern with these dimensions. `None` if strips have no ratio.
    pub fn ratio(&self, cell: f64, made: &Pattern, place: usize) -> Option<f64> {
        Some(on_face(cell, self.share(made)) + self.added(place)?)
    }
}

/// Sum of the corrections for the specimen's ends and pressure tilt, for `pattern` on the specimen of `layout`, at each
/// load; `share` is that of [`Laid::share`].
fn ends_and_tilt(
    bands: usize,
    scene: &Scene,
    pattern: &Pattern,
    (layout, share): (&Layout, f64),
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, SpecimenError> {
    let takes_strips = scene.dimension().takes_strips();
    let block_m = scene.layer.block_m;
    let face = if takes_strips {
        solved_face(bands, layout, block_m)?
    } else {
        face_from_strips(layout, layout.strips(bands), block_m)?
    };
    let tilt = tilt_shifts(scene, pattern, &face, share, monitor);
    let ends = if takes_strips {
        let scene = Scene { run: RunOptions { extent: Extent::Sample, ..scene.run }, ..scene.clone() };
        let strips = steady_face_ratios(&scene, pattern, &face, monitor)?;
        let cells = SteadyCell::new(&scene).ratios(pattern);
        let end = |(strip, cell): (Option<f64>, Option<f64>)| Some(strip? - on_face(cell?, share));
        strips.into_iter().zip(cells).map(end).collect()
    } else {
        vec![Some(0.0); scene.loads.len()]
    };
    Ok(ends.into_iter().zip(tilt).map(|(end, tilt)| Some(end? + tilt.unwrap_or(0.0))).collect())
}

/// Changes of the ratio from steady to dynamic sliding at each load, for the pattern of `scene` on `specimen`, or for
/// an infinite pattern on a strip of the layer's length. The longest strip is run from a sliding start at the maximum
/// speed of even sliding; at other speeds the changes are equal within the error of a run
/// (`what_time_adds_hangs_on_no_speed`). `None` if the run has no result, without a pattern, and in three dimensions,
/// where the change is not known.
///
/// # Errors
/// See [`simulate_on`].
pub fn time_changes_on(
    scene: &Scene,
    specimen: Option<&Specimen>,
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, SpecimenError> {
    let Some(pattern) = scene.pattern.filter(|_| scene.dimension().takes_strips()) else {
        return Ok(vec![None; scene.loads.len()]);
    };
    let lightest_pa = scene.loads.iter().map(|load| load.pressure_pa).fold(f64::INFINITY, f64::min);
    let mut scene = Scene {
        speed_m_s: even_speed_m_s(&scene.elastic, lightest_pa),
        run: RunOptions { extent: Extent::Sample, ..scene.run.from_sliding() },
        ..scene.clone()
    };
    let face = match specimen {
        Some(specimen) => {
            scene = with_specimen_length(specimen, &pattern, &scene);
            solved_face(BANDS, &specimen.layout(pattern)?, scene.layer.block_m)?
        }
        None => infinite_strip(&pattern, scene.layer.length_m)?,
    };
    Ok(time_changes(&scene.in_time(), &face, monitor)?)
}

/// Replaces each unknown change by the known one at the nearest pressure, because changes depend smoothly on pressure.
/// `changes` and `loads` correspond. `None` if no change is known.
pub fn nearest_known(changes: &[Option<f64>], loads: &[Load]) -> Option<Vec<f64>> {
    let at = |load: &Load| {
        let apart = |other: &Load| (other.pressure_pa / load.pressure_pa).ln().abs();
        let known = changes.iter().zip(loads).filter_map(|(change, other)| Some(((*change)?, apart(other))));
        known.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(change, _)| change)
    };
    loads.iter().map(at).collect()
}

/// A strip of an infinite pattern, `length_m` long, with half a land at its left end and complete cavities only.
fn infinite_strip(pattern: &Pattern, length_m: f64) -> Result<Face, SceneError> {
    let (width_m, pitch_m) = (pattern.width_m(), pattern.pitch_m());
    let starts_m = (0..).map(|number| 0.5 * pattern.spacing_m() + f64::from(number) * pitch_m);
    let cavities_m = starts_m.map(|start_m| [start_m, start_m + width_m]).take_while(|[_, end_m]| *end_m <= length_m);
    let strip = Strip { band: 0, width_m: length_m, length_m, cavities_m: cavities_m.collect() };
    Face::new(vec![strip], pattern.section_density())
}

/// Error of [`LoadOutcome::scale_to_layout`](slipgrid_model::springblock::LoadOutcome::scale_to_layout) at each load;
/// `None` if unknown. It is estimated from the deviation of strips of grooves with the same section on this specimen,
/// times the cavity fraction across the rows (areal density over section density), times `ROW_ERROR_OVER_GROOVES`.
pub fn layout_errors(
    scene: &Scene,
    specimen: &Specimen,
    pattern: &Pattern,
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, SpecimenError> {
    let groove = pattern.as_groove();
    let run = RunOptions { extent: Extent::Sample, dimensions: Some(2), ..RunOptions::default() };
    let plane = Scene { run, ..with_specimen_length(specimen, &groove, scene) };
    let Ok(layout) = specimen.layout(groove) else { return Ok(vec![None; scene.loads.len()]) };
    let share = layout.areal_density() / groove.areal_density();
    let strips = steady_face_ratios(&plane, &groove, &solved_face(BANDS, &layout, plane.layer.block_m)?, monitor)?;
    let cells = SteadyCell::new(&plane).ratios(&groove);
    let across = pattern.areal_density() / pattern.section_density();
    let error = |(ratio, cell): (Option<f64>, Option<f64>)| {
        ratio.zip(cell).map(|(ratio, cell)| ROW_ERROR_OVER_GROOVES * (ratio - on_face(cell, share)).abs() * across)
    };
    Ok(strips.into_iter().zip(cells).map(error).collect())
}

#[cfg(test)]
mod tests;
