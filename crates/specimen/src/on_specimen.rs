//! Ratios of patterns on specimens, strip by strip or from a cell.

use slipgrid_export::{ExportError, LaidStrip, Layout, Specimen};
use slipgrid_pattern::Pattern;
use slipgrid_springblock::{
    Extent, Face, Load, Monitor, RunOptions, Scene, SceneError, Simulation, Status, SteadyCell, SteadySpecimen, Strip,
    TILT_MEAN, add_tilt, even_speed_m_s, simulate, simulate_specimen, simulate_strip, steady_face_ratios, tilt_changes,
    time_changes,
};

use crate::laid::{Laid, density_share, on_face, share_of};

/// Bands that a face is cut into: the strips in their middles sample it. On discs of 10 mm the ratio by 32 bands differs
/// from that by 128 by less than the error stated (`bands_sample_a_disc`).
const BANDS: usize = 32;
/// By how many times rows of squares in space depart from the formula of a face more than grooves do, in the root mean square
/// (`rows_in_space_depart_from_the_rule_as_far_as_is_stated`; five textures at three loads: 1.7).
const ROWS_OVER_GROOVES: f64 = 1.7;
/// Share of that error that a strip through the middle leaves open for the other rows, in the root mean square of the same textures.
const OTHER_ROWS: f64 = 0.3;
/// Shortest strip that is solved, in blocks: less has no inside, and next to no share of the face.
const LEAST_STRIP_BLOCKS: f64 = 2.0;

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
    let is_groove = layout.pattern().texture().is_one_section();
    let strips = if is_groove { layout.strips(BANDS) } else { layout.central_strip() };
    face_of(layout, strips, block_m)
}

fn face_of(layout: &Layout, strips: Vec<LaidStrip>, block_m: f64) -> Result<Face, SceneError> {
    let is_groove = layout.pattern().texture().is_one_section();
    let share = if is_groove { layout.areal_density() } else { share_of(&strips) };
    let kept = strips.into_iter().filter(|strip| strip.length_m >= LEAST_STRIP_BLOCKS * block_m);
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
        let mut scene = on(specimen, pattern, scene);
        scene.validate()?;
        let dimension = scene.dimension();
        let layout = specimen.layout(*pattern)?;
        let laid = Laid::of(&layout, dimension);
        let share = laid.share(pattern);
        let takes_strips = dimension.takes_strips();
        let block_m = scene.layer.block_m;
        let face =
            if takes_strips { face(&layout, block_m)? } else { face_of(&layout, layout.strips(BANDS), block_m)? };
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
mod tests {
    use super::*;
    use slipgrid_export::Outline;
    use slipgrid_material::{AreaLaw, Elastic, LocalFriction};
    use slipgrid_pattern::{Planform, Rim, RimProfile, Texture};
    use slipgrid_springblock::{Dimension, Layer, Load, LoadOutcome, Unwatched, steady_ratios};

    const DISC: Specimen = Specimen { outline: Outline::Disc { diameter_m: 10e-3 }, is_clipped: false };

    fn scene(pattern: Pattern) -> Scene {
        let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
        Scene {
            elastic: Elastic::new(0.38e9, 900.0).unwrap(),
            area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.4]).unwrap()),
            pattern: Some(pattern),
            relief: None,
            layer: Layer { length_m: 10e-3, height_m: 200e-6, block_m: 10e-6, thickness_m: None },
            loads: vec![Load { pressure_pa: 0.65e6, friction }, Load { pressure_pa: 2.6e6, friction }],
            speed_m_s: 2e-3,
            run: RunOptions { extent: Extent::Sample, ..RunOptions::default() },
        }
    }

    /// Grooves on a disc; what time adds to them, and their whole specimen in time at a share `of_even` of the speed of even sliding.
    fn on_disc(of_even: f64) -> (Scene, Vec<Option<f64>>, Simulation) {
        let mut scene = scene(Pattern::new(Planform::Groove, 130e-6, 370e-6, 20e-6).unwrap());
        scene.layer.length_m = DISC.whole_length_m([1.0, 0.0], scene.layer.block_m);
        let found = time_changes_on(&scene, Some(&DISC), &Unwatched).unwrap();
        let speed_m_s = of_even * even_speed_m_s(&scene.elastic, 0.65e6);
        let timed = Scene { run: scene.run.from_sliding(), speed_m_s, ..scene.clone() }.in_time();
        let whole = simulate_on(&timed, Some(&DISC), &Unwatched).unwrap();
        (scene, found, whole)
    }

    #[test]
    fn what_time_adds_alone_is_what_the_whole_specimen_in_time_has() {
        let (scene, found, whole) = on_disc(1.0);
        assert_eq!(found, whole.loads.iter().map(|load| load.ratio_time_change).collect::<Vec<_>>());
        // An endless pattern has as much but for its share, within the error of a run.
        let endless = time_changes_on(&scene, None, &Unwatched).unwrap();
        for (own, endless) in found.iter().zip(&endless) {
            let (own, endless) = (own.unwrap(), endless.unwrap());
            assert!(own > 1e-3 && own < 0.02 && (own - endless).abs() < 0.5 * own, "{own} {endless}");
        }
        let squares = Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6).unwrap();
        let in_space = Scene { pattern: Some(squares), run: RunOptions::default(), ..scene };
        assert_eq!(time_changes_on(&in_space, Some(&DISC), &Unwatched).unwrap(), [None, None]);
    }

    #[test]
    fn what_time_adds_hangs_on_no_speed() {
        let (_, found, slow) = on_disc(0.09);
        for (load, found) in slow.loads.iter().zip(found) {
            let (slow, found) = (load.ratio_time_change.unwrap(), found.unwrap());
            // The standard error of either is up to 0.001.
            assert!((slow - found).abs() < 1e-3 && slow > 2e-3, "{slow} {found} {:?}", load.ratio_stderr);
        }
    }

    /// A rectangle of squares, or of grooves across, by a strip in space.
    fn on_strip(planform: Planform, spacing_um: f64, outline: Outline) -> (Scene, Specimen) {
        let pattern = Pattern::new(planform, 130e-6, spacing_um * 1e-6, 20e-6).unwrap();
        let mut scene = scene(pattern);
        scene.run = RunOptions { extent: Extent::Strip, dimensions: Some(3), ..scene.run };
        for load in &mut scene.loads {
            // Without scatter of the local coefficients.
            load.friction = LocalFriction::new(0.30, 0.27, 0.0).unwrap();
        }
        (scene, Specimen { outline, is_clipped: false })
    }

    #[test]
    fn a_strip_in_space_says_of_grooves_what_the_plane_says_of_their_strips() {
        let (scene, specimen) =
            on_strip(Planform::Groove, 170.0, Outline::Rectangle { length_m: 3.05e-3, width_m: 2e-3 });
        let plane = RunOptions { extent: Extent::Sample, dimensions: Some(2), ..scene.run };
        let in_plane = simulate_on(&Scene { run: plane, ..scene.clone() }, Some(&specimen), &Unwatched).unwrap();
        let in_space = simulate_on(&scene, Some(&specimen), &Unwatched).unwrap();
        for (space, plane) in in_space.loads.iter().zip(&in_plane.loads) {
            let (own, expected) = (space.ratio.unwrap(), plane.ratio.unwrap());
            assert!((own - expected).abs() < 2e-4 && expected < 0.99, "{own} {expected}");
            // At the ends.
            let peaks = [space, plane].map(|load| load.surface.peak_pressure_pa);
            assert!((peaks[0] / peaks[1] - 1.0).abs() < 0.01, "{peaks:?}");
        }
    }

    #[test]
    fn a_strip_in_space_departs_from_the_rule_by_its_ends_alone_and_shows_what_they_bear() {
        // No whole blocks.
        let (scene, specimen) = on_strip(Planform::Square, 171.5, Outline::Disc { diameter_m: 3e-3 });
        let strip = simulate_on(&scene, Some(&specimen), &Unwatched).unwrap();
        let run = RunOptions { extent: Extent::Cell, ..scene.run };
        let cell = simulate_on(&Scene { run, ..scene.clone() }, Some(&specimen), &Unwatched).unwrap();
        for (strip, cell) in strip.loads.iter().zip(&cell.loads) {
            let departs = (strip.ratio.unwrap() - cell.ratio.unwrap()).abs();
            let [own, without] = [strip, cell].map(|load| load.ratio_layout_error.unwrap());
            assert!(departs < 5e-4 && departs > 1e-5, "{departs} {without}");
            assert!((own - OTHER_ROWS * without).abs() < 1e-12);
            let peaks = [strip, cell].map(|load| load.surface.peak_pressure_pa);
            assert!(peaks[0] > 1.02 * peaks[1], "{peaks:?}");
        }
        assert!(strip.statements.model.iter().any(|line| line.contains("of the strip through its middle")));
    }

    /// Squares on discs: every row of them by a strip in space of its own, the row through the middle alone, and the rule.
    #[test]
    fn rows_in_space_depart_from_the_rule_as_far_as_is_stated() {
        let (mut of_rule, mut of_middle) = (Vec::new(), Vec::new());
        for (width_um, spacing_um, depth_um, rows) in
            [(130.0, 170.0, 20.0, 9), (60.0, 60.0, 20.0, 13), (100.0, 60.0, 10.0, 11)]
        {
            let outline = Outline::Disc { diameter_m: f64::from(rows) * (width_um + spacing_um) * 1e-6 };
            let (mut scene, specimen) = on_strip(Planform::Square, spacing_um, outline);
            let pattern = Pattern::new(Planform::Square, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
            scene.pattern = Some(pattern);
            let layout = specimen.layout(pattern).unwrap();
            // A band for each row, through the middle of its cavities.
            let strips = layout.strips(rows as usize);
            let all = face_of(&layout, strips.clone(), scene.layer.block_m).unwrap();
            let area_m2: f64 = all.strips().iter().map(Strip::area_m2).sum();
            let mut lowered = [0.0; 2];
            for strip in all.strips().iter().filter(|strip| !strip.cavities_m.is_empty()) {
                let (found, _) = simulate_strip(&scene, strip, &Unwatched).unwrap();
                for (lowered, load) in lowered.iter_mut().zip(&found.loads) {
                    *lowered += (1.0 - load.ratio.unwrap()) * strip.area_m2() / area_m2;
                }
            }
            // Strips sample the face.
            let sampled =
                layout.areal_density() / pattern.areal_density() * pattern.section_density() / share_of(&strips);
            let middle = simulate_on(&scene, Some(&specimen), &Unwatched).unwrap();
            let run = RunOptions { extent: Extent::Cell, ..scene.run };
            let rule = simulate_on(&Scene { run, ..scene.clone() }, Some(&specimen), &Unwatched).unwrap();
            for (lowered, (middle, rule)) in lowered.into_iter().zip(middle.loads.iter().zip(&rule.loads)) {
                let by_rows = 1.0 - sampled * lowered;
                let departs = |load: &LoadOutcome| (by_rows - load.ratio.unwrap()) / load.ratio_layout_error.unwrap();
                of_rule.push(departs(rule));
                of_middle.push(departs(middle));
                assert!((by_rows - middle.ratio.unwrap()).abs() < 1e-3, "{width_um}: {by_rows} {:?}", middle.ratio);
            }
        }
        let rms = |all: &[f64]| (all.iter().map(|own| own * own).sum::<f64>() / all.len() as f64).sqrt();
        assert!(rms(&of_rule) > 0.6 && rms(&of_rule) < 1.3, "{of_rule:?}");
        assert!(rms(&of_middle) < 1.3, "{of_middle:?}");
    }

    #[test]
    fn turned_with_its_face_and_its_sliding_direction_a_pattern_has_the_same_ratios() {
        let [long, high] =
            [[4e-3, 1.5e-3], [1.5e-3, 4e-3]].map(|[length_m, width_m]| Outline::Rectangle { length_m, width_m });
        let disc = Outline::Disc { diameter_m: 4e-3 };
        for (planform, by_deg, [face, turned_face]) in [
            (Planform::Groove, 60.0, [disc, disc]),
            (Planform::Groove, 90.0, [long, high]),
            (Planform::Square, 90.0, [long, high]),
        ] {
            let ratios = |angle_deg: f64, outline: Outline| {
                let texture = Texture::new(planform).with_sliding_angle_deg(angle_deg).unwrap();
                let turned = texture.with_groove_angle_deg(angle_deg);
                let pattern = Pattern::new(turned.unwrap_or(texture), 130e-6, 170e-6, 20e-6).unwrap();
                let mut scene = Scene { run: RunOptions::default().on_specimen(pattern.texture()), ..scene(pattern) };
                (scene.layer.block_m, scene.layer.thickness_m) = (20e-6, Some(7e-3));
                let specimen = Specimen { outline, is_clipped: false };
                let loads = simulate_on(&scene, Some(&specimen), &Unwatched).unwrap().loads;
                loads.iter().map(|load| [load.ratio, load.ratio_tilt_change]).collect::<Vec<_>>()
            };
            let (own, turned) = (ratios(0.0, face), ratios(by_deg, turned_face));
            for (own, turned) in own.iter().flatten().zip(turned.iter().flatten()) {
                let apart = own.zip(*turned).map(|(own, turned)| (own - turned).abs());
                assert!(apart.is_some_and(|apart| apart < 1e-8), "{planform:?} {by_deg}: {own:?} {turned:?}");
            }
        }
    }

    #[test]
    fn bands_sample_a_disc() {
        for [width_um, spacing_um, depth_um] in [[400.0, 824.5, 49.4], [130.0, 370.0, 20.0]] {
            let pattern = Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
            let (scene, layout) = (scene(pattern), DISC.layout(pattern).unwrap());
            let solved = |bands: usize| {
                let face = face_of(&layout, layout.strips(bands), 10e-6).unwrap();
                simulate_specimen(&scene, &face, &Unwatched).unwrap().loads
            };
            for (coarse, fine) in solved(BANDS).iter().zip(&solved(4 * BANDS)) {
                let distance = (coarse.ratio.unwrap() - fine.ratio.unwrap()).abs();
                let stated = coarse.ratio_layout_error.unwrap();
                assert!(distance < stated.max(1e-4) && stated < 2.5e-3, "{pattern:?}: {distance} {stated}");
            }
        }
    }

    #[test]
    fn the_share_of_cavities_says_what_strips_say_but_for_the_ends() {
        // Seven grooves lie on the disc: 29.9 % of it, 32.7 % of a period.
        let pattern = Pattern::new(Planform::Groove, 400e-6, 824.5e-6, 49.4e-6).unwrap();
        let scene = scene(pattern);
        let share = density_share(&DISC.layout(pattern).unwrap(), Dimension::Plane);
        assert!((share - 0.2993 / 0.3267).abs() < 2e-3, "{share}");
        let strips = simulate_on(&scene, Some(&DISC), &Unwatched).unwrap();
        let cells = SteadyCell::new(&scene).ratios(&pattern);
        for (load, cell) in strips.loads.iter().zip(cells) {
            let (found, cell) = (load.ratio.unwrap(), cell.unwrap());
            assert!((found - on_face(cell, share)).abs() < 0.006, "{found} {cell}");
            assert!(found > cell, "fewer cavities lower friction less");
        }
    }

    #[test]
    fn squares_are_a_cell_in_proportion_to_their_share_of_the_face() {
        let pattern = Pattern::new(Planform::Square, 200e-6, 300e-6, 20e-6).unwrap();
        let asked = scene(pattern);
        let mut scene = Scene { run: asked.run.on_specimen(pattern.texture()), ..asked };
        scene.layer.block_m = 20e-6;
        assert_eq!(scene.run.extent, Extent::Cell);
        let cell = simulate(&scene, &Unwatched).unwrap();
        let on = simulate_on(&scene, Some(&DISC), &Unwatched).unwrap();
        let share = density_share(&DISC.layout(pattern).unwrap(), Dimension::Space);
        for (cell, on) in cell.loads.iter().zip(&on.loads) {
            let (cell, found) = (cell.ratio.unwrap(), on.ratio.unwrap());
            assert!(((1.0 - found) / (1.0 - cell) - share).abs() < 1e-9 && share < 1.0);
            assert!(on.ratio_layout_error.is_some_and(|error| error < 0.003), "{:?}", on.ratio_layout_error);
        }
        // The plane takes the row of cavities through the centre.
        let section = density_share(&DISC.layout(pattern).unwrap(), Dimension::Plane);
        assert!((section - 20.0 * 0.2 / 10.0 / 0.4).abs() < 0.06, "{section}");
    }

    /// Trials are modelled by it: what a design is confirmed as must be what its sample is expected to be.
    #[test]
    fn steady_ratios_on_a_face_are_those_of_the_specimen() {
        let rim = Rim::new(0.1e-6, 20e-6, RimProfile::Round).unwrap();
        for (planform, width_um, spacing_um, depth_um, rim) in [
            (Planform::Groove, 41.6, 46.7, 15.6, None),
            (Planform::Groove, 130.0, 370.0, 20.0, None),
            (Planform::Groove, 130.0, 370.0, 20.0, Some(rim)),
            (Planform::Square, 130.0, 170.0, 20.0, None),
        ] {
            let pattern = Pattern::new(planform, width_um * 1e-6, spacing_um * 1e-6, depth_um * 1e-6).unwrap();
            let pattern = pattern.with_rim(rim);
            let asked = scene(pattern);
            let mut scene = Scene { run: asked.run.on_specimen(pattern.texture()), ..asked };
            scene.layer.thickness_m = Some(7e-3);
            if planform == Planform::Square {
                scene.layer.block_m = 20e-6;
            }
            // Strips lie flat.
            let on_face = SteadyOnFace::new(&scene, &pattern.with_rim(None), &DISC, &Unwatched).unwrap();
            let cells = steady_ratios(&Scene { run: RunOptions::default(), ..scene.clone() }, &Unwatched).unwrap();
            let solved = simulate_on(&scene, Some(&DISC), &Unwatched).unwrap();
            let (mut farthest, mut tilted) = (0.0, 0.0);
            for (place, (load, cell)) in solved.loads.iter().zip(cells).enumerate() {
                let cell = cell.unwrap();
                let (found, asked) = (on_face.ratio(cell, &pattern, place).unwrap(), load.ratio.unwrap());
                assert!((found - asked).abs() < 1e-9, "{pattern:?} {place}: {found} {asked}");
                farthest = f64::max(farthest, (found - cell).abs());
                tilted = f64::max(tilted, load.ratio_tilt_change.unwrap().abs());
            }
            assert!(farthest > 5e-4 && tilted > 1e-3, "{farthest} {tilted}");
        }
    }
}
