//! Ratios of patterns on specimens, strip by strip or from a cell.

use slipgrid_export::{ExportError, LaidStrip, Layout, Specimen};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{
    Extent, Face, Load, Monitor, RunOptions, Scene, SceneError, Simulation, Status, SteadyCell, SteadySpecimen, Strip,
    TILT_MEAN, add_tilt, even_speed_m_s, simulate, simulate_specimen, simulate_strip, steady_face_bytes,
    steady_face_ratios, tilt_changes, time_changes,
};

use crate::laid::{Laid, density_share, on_face, share_of};

/// Bands that a face is cut into: the strips in their middles sample it. On discs of 10 mm the ratio by 32 bands differs
/// from that by 128 by less than the error stated (`bands_sample_a_disc`).
const BANDS: usize = 32;
/// Bands of a face for [`SteadyOnFace::roughly`].
const ROUGH_BANDS: usize = 6;
/// By how many times rows of squares in space depart from the formula of a face more than grooves do, in the root mean square
/// (`rows_in_space_depart_from_the_rule_as_far_as_is_stated`; five textures at three loads: 1.7).
const ROWS_OVER_GROOVES: f64 = 1.7;
/// Share of that error that a strip through the middle leaves open for the other rows, in the root mean square of the same textures.
const OTHER_ROWS: f64 = 0.3;
/// Shortest strip that is solved, in blocks: less has no inside, and next to no share of the face.
const MIN_STRIP_BLOCKS: f64 = 2.0;

/// Why a pattern on a specimen was not solved.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SpecimenError {
    /// The solver refuses the scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The specimen does not take the pattern.
    #[error(transparent)]
    Layout(#[from] ExportError),
}

/// Solves `scene` on `specimen`; one strip as long as the scene says, or the cell that it asks for, without.
///
/// # Errors
/// [`SpecimenError`] where the scene means nothing or the specimen does not take its pattern.
pub fn simulate_on(
    scene: &Scene,
    specimen: Option<&Specimen>,
    monitor: &dyn Monitor,
) -> Result<Simulation, SpecimenError> {
    let Some((specimen, pattern)) = specimen.zip(scene.pattern) else { return Ok(simulate(scene, monitor)?) };
    let scene = &on(specimen, &pattern, scene);
    let layout = specimen.layout(pattern)?;
    if scene.dimension().takes_strips() {
        return Ok(simulate_specimen(scene, &face(&layout, scene.layer.block_m)?, monitor)?);
    }
    let share = density_share(&layout, scene.dimension());
    let (mut simulation, of_it) = if scene.run.extent == Extent::Strip {
        simulate_strip(scene, &middle_row(&layout, scene.layer.block_m)?, monitor)?
    } else {
        (simulate(scene, monitor)?, 1.0)
    };
    let mut ends = ends_error(scene, specimen, &pattern, monitor)?;
    if scene.run.extent == Extent::Strip {
        ends.iter_mut().flatten().for_each(|error| *error *= OTHER_ROWS);
    }
    if monitor.cancelled() {
        // Its error is not known.
        simulation.loads.iter_mut().for_each(|load| load.surface.status = Status::Cancelled);
    }
    // 1 - r = D (1 - r_strip) / D_strip
    onto(&mut simulation, share / of_it, &ends);
    let whole = face_of(&layout, layout.strips(BANDS), scene.layer.block_m)?;
    add_tilt(&mut simulation, scene, &pattern, &whole, share, monitor);
    let largest = ends.iter().flatten().copied().fold(0.0, f64::max);
    simulation.statements.model(format!(
        "specimen as it is laid out: cavities take {:.2} % of its face, {:.2} % of {}; friction is lowered in that proportion, which gives the ratio an error of {largest:.4} at most, as strips of grooves and rows in space show",
        100.0 * layout.areal_density(),
        100.0 * pattern.areal_density() * of_it,
        if scene.run.extent == Extent::Strip { "the strip through its middle" } else { "a period" },
    ));
    Ok(simulation)
}

/// The row of cavities through the middle of `layout`, with its own ends and margins; the longer of two parts beside a hole.
fn middle_row(layout: &Layout, block_m: f64) -> Result<Strip, SceneError> {
    let face = face_of(layout, layout.central_strip(), block_m)?;
    let textured = face.strips().iter().filter(|strip| !strip.cavities_m.is_empty());
    let longest = textured.reduce(|longest, strip| if strip.length_m > longest.length_m { strip } else { longest });
    longest.cloned().ok_or(SceneError::Unsupported {
        what: "a strip of a specimen that has no cavity on the line through its middle",
        instead: "ask for extent = \"sample\"",
    })
}

/// `scene` with `pattern`, as long as `specimen` is along the direction that it slides in.
fn on(specimen: &Specimen, pattern: &Pattern, scene: &Scene) -> Scene {
    let mut scene = Scene { pattern: Some(*pattern), ..scene.clone() };
    let sliding = pattern.texture().sliding_direction_on_specimen();
    scene.layer.length_m = specimen.whole_length_m(sliding, scene.layer.block_m);
    scene
}

/// `specimen` with the pattern of `scene` in steady sliding, from which a run in time goes on; `None` where it takes no strips, and once
/// `monitor` has cancelled.
///
/// # Errors
/// As [`simulate_on`].
pub fn strips_on(
    scene: &Scene,
    specimen: &Specimen,
    monitor: &dyn Monitor,
) -> Result<Option<SteadySpecimen>, SpecimenError> {
    let Some(pattern) = scene.pattern.filter(|_| scene.dimension().takes_strips()) else { return Ok(None) };
    let scene = on(specimen, &pattern, scene);
    let face = face(&specimen.layout(pattern)?, scene.layer.block_m)?;
    Ok(SteadySpecimen::new(&scene, &face, monitor)?)
}

/// The strips of `layout` as a solver takes them: all of grooves across the sliding direction; of another planform, which
/// the plane takes a section of, that through the middle of the cavities.
fn face(layout: &Layout, block_m: f64) -> Result<Face, SceneError> {
    face_by(BANDS, layout, block_m)
}

fn face_by(bands: usize, layout: &Layout, block_m: f64) -> Result<Face, SceneError> {
    let is_groove = layout.pattern().texture().is_one_section();
    let strips = if is_groove { layout.strips(bands) } else { layout.central_strip() };
    face_of(layout, strips, block_m)
}

fn face_of(layout: &Layout, strips: Vec<LaidStrip>, block_m: f64) -> Result<Face, SceneError> {
    let is_groove = layout.pattern().texture().is_one_section();
    let share = if is_groove { layout.areal_density() } else { share_of(&strips) };
    let kept = strips.into_iter().filter(|strip| strip.length_m >= MIN_STRIP_BLOCKS * block_m);
    let strip = |LaidStrip { band, width_m, length_m, cavities_m }| Strip { band, width_m, length_m, cavities_m };
    Face::new(kept.map(strip).collect(), share)
}

/// `simulation` of one cell as that of a specimen whose cavities take `share` of what a period's take.
pub fn onto(simulation: &mut Simulation, share: f64, layout_error: &[Option<f64>]) {
    for (place, load) in simulation.loads.iter_mut().enumerate() {
        load.set_ratio(load.ratio.map(|ratio| on_face(ratio, share)));
        let scaled = |error: Option<f64>| error.map(|error| error * share);
        load.ratio_stderr = scaled(load.ratio_stderr);
        load.ratio_time_change = scaled(load.ratio_time_change);
        load.ratio_discretization_error = scaled(load.ratio_discretization_error);
        load.ratio_layer_difference = scaled(load.ratio_layer_difference);
        load.ratio_layer_error = scaled(load.ratio_layer_error);
        load.ratio_layout_error = layout_error.get(place).copied().flatten();
    }
}

/// What a specimen makes of the steady ratios of an endless pattern, at the loads of a scene.
///
/// ```text
/// r = 1 - (1 - r_cell) D / D_period + ends + tilt
/// ```
///
/// The ends are what grooves across the sliding direction solved strip by strip depart from the rest of the formula; those of other
/// planforms are part of its error ([`simulate_on`]). Of what friction changes by tilting the pressure it is the mean.
#[derive(Clone, Debug)]
pub struct SteadyOnFace {
    laid: Laid,
    /// Ends and tilt, by load.
    added: Vec<Option<f64>>,
}

impl SteadyOnFace {
    /// Of `pattern` in the place of that of `scene`, on `specimen`.
    ///
    /// # Errors
    /// [`SpecimenError`] where the scene means nothing or the specimen does not take its pattern.
    pub fn new(
        scene: &Scene,
        pattern: &Pattern,
        specimen: &Specimen,
        monitor: &dyn Monitor,
    ) -> Result<Self, SpecimenError> {
        Self::by_bands(BANDS, scene, pattern, specimen, monitor)
    }

    /// The same by few strips, for ranking designs: ends and tilt to about a tenth of themselves at a fifth of the cost.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn roughly(
        scene: &Scene,
        pattern: &Pattern,
        specimen: &Specimen,
        monitor: &dyn Monitor,
    ) -> Result<Self, SpecimenError> {
        Self::by_bands(ROUGH_BANDS, scene, pattern, specimen, monitor)
    }

    fn by_bands(
        bands: usize,
        scene: &Scene,
        pattern: &Pattern,
        specimen: &Specimen,
        monitor: &dyn Monitor,
    ) -> Result<Self, SpecimenError> {
        let mut scene = on(specimen, pattern, scene);
        scene.validate()?;
        let dimension = scene.dimension();
        let layout = specimen.layout(*pattern)?;
        let laid = Laid::of(&layout, dimension);
        let share = laid.share(pattern);
        let takes_strips = dimension.takes_strips();
        let block_m = scene.layer.block_m;
        let face = if takes_strips {
            face_by(bands, &layout, block_m)?
        } else {
            face_of(&layout, layout.strips(bands), block_m)?
        };
        let tilt = tilt_changes(&scene, pattern, &face, share, monitor);
        let ends = if takes_strips {
            scene.run.extent = Extent::Sample;
            let strips = steady_face_ratios(&scene, pattern, &face, monitor)?;
            let cells = SteadyCell::new(&scene).ratios(pattern);
            let end = |(strip, cell): (Option<f64>, Option<f64>)| Some(strip? - on_face(cell?, share));
            strips.into_iter().zip(cells).map(end).collect()
        } else {
            vec![Some(0.0); scene.loads.len()]
        };
        let added = ends.into_iter().zip(tilt).map(|(end, tilt)| Some(end? + TILT_MEAN * tilt.unwrap_or(0.0)));
        Ok(Self { laid, added: added.collect() })
    }

    /// Memory, in bytes, that [`Self::new`] takes for the equations of the face's strips; 0 where it solves none.
    ///
    /// # Errors
    /// Those of [`Self::new`] that are known before anything is solved.
    pub fn bytes(scene: &Scene, pattern: &Pattern, specimen: &Specimen) -> Result<f64, SpecimenError> {
        let scene = on(specimen, pattern, scene);
        scene.validate()?;
        if !scene.dimension().takes_strips() {
            return Ok(0.0);
        }
        Ok(steady_face_bytes(&scene, pattern, &face(&specimen.layout(*pattern)?, scene.layer.block_m)?)?)
    }

    /// Ends and tilt at the load `place`, beside the share of the face; `None` where strips have no ratio.
    #[must_use]
    pub fn added(&self, place: usize) -> Option<f64> {
        self.added.get(place).copied().flatten()
    }

    /// The ratio of `made`, a sample of the pattern whose endless ratio is `cell`, on the specimen, at the load `place`; `None` where
    /// strips have none.
    #[must_use]
    pub fn ratio(&self, cell: f64, made: &Pattern, place: usize) -> Option<f64> {
        Some(on_face(cell, self.laid.share(made)) + self.added(place)?)
    }
}

/// What sliding in time adds to the steady ratio of the pattern of `scene` on `specimen`, or of an endless one on a strip as long as its
/// layer, at each load: by a run from sliding of the longest strip, as fast as that slides evenly. At other speeds it is the same within the
/// error of a run (`what_time_adds_hangs_on_no_speed`). `None` where that gives none, and in space, where it is not known.
///
/// # Errors
/// As [`simulate_on`].
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
            scene = on(specimen, &pattern, &scene);
            face(&specimen.layout(pattern)?, scene.layer.block_m)?
        }
        None => endless(&pattern, scene.layer.length_m)?,
    };
    Ok(time_changes(&scene.in_time(), &face, monitor)?)
}

/// `changes` at `loads`, where one is not known that at the nearest pressure at which it is: it goes smoothly with the pressure. `None` where none
/// is known.
#[must_use]
pub fn nearest_known(changes: &[Option<f64>], loads: &[Load]) -> Option<Vec<f64>> {
    let at = |load: &Load| {
        let apart = |other: &Load| (other.pressure_pa / load.pressure_pa).ln().abs();
        let known = changes.iter().zip(loads).filter_map(|(change, other)| Some(((*change)?, apart(other))));
        known.min_by(|(_, a), (_, b)| a.total_cmp(b)).map(|(change, _)| change)
    };
    loads.iter().map(at).collect()
}

/// A strip of an endless pattern, `length_m` long, with half a land at its left end and whole cavities.
fn endless(pattern: &Pattern, length_m: f64) -> Result<Face, SceneError> {
    let (width_m, pitch_m) = (pattern.width_m(), pattern.pitch_m());
    let starts_m = (0..).map(|number| 0.5 * pattern.spacing_m() + f64::from(number) * pitch_m);
    let cavities_m = starts_m.map(|start_m| [start_m, start_m + width_m]).take_while(|[_, end_m]| *end_m <= length_m);
    let strip = Strip { band: 0, width_m: length_m, length_m, cavities_m: cavities_m.collect() };
    Face::new(vec![strip], pattern.section_density())
}

/// What [`onto`] leaves open at each load: the distance of strips of grooves of the same section on the same specimen from
/// it, in proportion to the share of a period across the cavities' row that is cavity, and as much more as rows in space depart.
fn ends_error(
    scene: &Scene,
    specimen: &Specimen,
    pattern: &Pattern,
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, SpecimenError> {
    let groove = pattern.as_groove();
    let run = RunOptions { extent: Extent::Sample, dimensions: Some(2), ..RunOptions::default() };
    let plane = Scene { run, ..on(specimen, &groove, scene) };
    let Ok(layout) = specimen.layout(groove) else { return Ok(vec![None; scene.loads.len()]) };
    let share = layout.areal_density() / groove.areal_density();
    let strips = steady_face_ratios(&plane, &groove, &face(&layout, plane.layer.block_m)?, monitor)?;
    let cells = SteadyCell::new(&plane).ratios(&groove);
    let across = pattern.areal_density() / pattern.section_density();
    let error = |(ratio, cell): (Option<f64>, Option<f64>)| {
        ratio.zip(cell).map(|(ratio, cell)| ROWS_OVER_GROOVES * (ratio - on_face(cell, share)).abs() * across)
    };
    Ok(strips.into_iter().zip(cells).map(error).collect())
}

#[cfg(test)]
mod tests;
