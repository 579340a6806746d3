//! A specimen with the cavities that a laser cuts: the sum of the strips of its face along the sliding direction.
//!
//! All strips are attached to one rigid bulk and descend by the same distance d. With the width w_s, the length L_s and
//! the stiffness per length k_s of strip s, the pressures P_s and the friction coefficient mu of the face under the
//! nominal pressure P are
//!
//! ```text
//! P_s = k_s d,     sum w_s L_s P_s = P sum w_s L_s,     mu = sum w_s L_s P_s mu_s / (P sum w_s L_s)
//! ```
//!
//! This bulk is directly above the modelled layer. The effect of the elastic specimen beyond the layer on the
//! distribution of the load is added ([`load_sharing`](super::load_sharing)).
//!
//! The strips only sample the face. The cavity fraction D of the face is known exactly, and the friction reduction is
//! very nearly proportional to it, so that the ratio to the flat face is taken as 1 - (1 - r) D / D_strips. The
//! deviation of the strips from this proportion is the sampling error.
//!
//! Only one strip, the longest, is run dynamically, on whole blocks. Its change of the ratio from steady to dynamic
//! sliding is applied to the face, scaled with the cavity fraction D over D_1, that of this strip:
//!
//! ```text
//! r = r_steady + (r_dynamic,1 - r_steady,1) D / D_1
//! ```

mod strips;
mod timed_strip;

use crate::pattern::Pattern;

use super::blocks::{self, BlockRefinement};
use super::pressure_tilt::PressureTilt;
use super::rim_difference;
use super::statements::modulus_of_heights;
use super::{ThickLayerCorrection, cancelled, describe_draws, describe_law, discretization_error};
use crate::springblock::{
    Dimension, Extent, Face, Fidelity, LoadOutcome, Monitor, RunOptions, Scene, SceneError, Simulation, Statements,
    SteadyCell, Strip,
};
use strips::{STRIP_HEIGHTS, SteadyFace};
pub use strips::{min_wall_m, without_slivers};
use timed_strip::TimedStrip;

/// The pressure of lands at the border is stated if it exceeds that of the longest strip by more than this factor.
const PRESSED_HARDER: f64 = 1.02;

/// Simulates `scene` with its pattern laid out on `face`, and the flat face for comparison. Loads and strips run in
/// parallel on rayon's current pool; the result does not depend on the number of threads.
///
/// # Errors
/// [`SceneError`] if the scene is invalid or has no pattern, or if the strips do not fit in memory.
pub fn simulate_specimen(scene: &Scene, face: &Face, monitor: &dyn Monitor) -> Result<Simulation, SceneError> {
    let pattern = validated_pattern(scene)?;
    let in_time = || match scene.run.fidelity {
        Fidelity::Steady => Ok(None),
        Fidelity::Dynamic | Fidelity::Reference => {
            TimedStrip::new(&without_thickness(scene), face, &pattern, monitor).map(Some)
        }
    };
    let (steady, in_time) = rayon::join(|| SteadySpecimen::new(scene, face, monitor), in_time);
    let Some(steady) = steady? else { return Ok(cancelled(scene)) };
    Ok(steady.result(in_time?.as_ref(), monitor))
}

/// Validates `scene` and returns its pattern.
fn validated_pattern(scene: &Scene) -> Result<Pattern, SceneError> {
    scene.validate()?;
    if !scene.dimension().takes_strips() {
        return Err(SceneError::Unsupported {
            what: "strips of a pattern that is solved in space",
            instead: "simulate its cell",
        });
    }
    scene.pattern.ok_or(SceneError::Unsupported {
        what: "the layout of a flat specimen",
        instead: "give a pattern, or simulate the flat sample",
    })
}

/// Returns `scene` without the thickness of the specimen, as strips are solved: the layer alone.
fn without_thickness(scene: &Scene) -> Scene {
    Scene { layer: scene.layer.alone(), ..scene.clone() }
}

/// Steady sliding of a specimen, with all corrections except the change from steady to dynamic sliding.
struct SteadySpecimen<'a> {
    scene: &'a Scene,
    face: &'a Face,
    pattern: Pattern,
    loads: Vec<LoadOutcome>,
    /// Number of strips that were shortened by whole periods.
    shortened: usize,
    peak_over_longest: f64,
    block_errors: Option<Vec<f64>>,
    correction: ThickLayerCorrection,
    tilt: PressureTilt,
    refined: Option<Result<BlockRefinement, String>>,
}

impl<'a> SteadySpecimen<'a> {
    /// Solves `scene` with its pattern laid out on `face`; `None` once `monitor` has cancelled.
    ///
    /// # Errors
    /// The errors of [`simulate_specimen`].
    fn new(scene: &'a Scene, face: &'a Face, monitor: &dyn Monitor) -> Result<Option<Self>, SceneError> {
        let pattern = validated_pattern(scene)?;
        let strips = || SteadyFace::new(scene, &pattern, face, monitor);
        let block_errors = || {
            let cells = SteadyCell::with_dimension(scene, Dimension::Plane).ratios(&pattern);
            discretization_error(scene, &pattern, &cells)
        };
        let correction = || {
            let run = RunOptions { extent: Extent::Sample, ..scene.run };
            ThickLayerCorrection::for_face(&Scene { run, ..scene.clone() }, &pattern, face, monitor)
        };
        let tilt = || PressureTilt::for_strips(scene, &pattern, face, face.share_of(&pattern), monitor);
        let refined = || {
            scene.run.refine.then(|| blocks::refinement(scene, &pattern, &[], blocks::MAX_REFINEMENT_PRODUCTS, monitor))
        };
        let (strips, ((block_errors, refined), (correction, tilt))) = rayon::join(strips, || {
            rayon::join(|| rayon::join(block_errors, refined), || rayon::join(correction, tilt))
        });
        let Some(SteadyFace { loads, shortened, peak_over_longest }) = strips? else { return Ok(None) };
        let found =
            Self { scene, face, pattern, loads, shortened, peak_over_longest, block_errors, correction, tilt, refined };
        Ok((!monitor.cancelled()).then_some(found))
    }

    /// Returns the result, with the change from steady to dynamic sliding of `timed`, the dynamic run, if there is one.
    fn result(&self, timed: Option<&TimedStrip>, monitor: &dyn Monitor) -> Simulation {
        let Self { scene, face, pattern, .. } = self;
        let (mut loads, mut statements) = timed.map_or_else(
            || {
                let mut statements = Statements::default();
                statements.model("steady: equilibrium with every contact block sliding, linear elasticity; no time");
                (self.loads.clone(), statements)
            },
            |timed| timed.apply(face, &self.loads),
        );
        // The friction reduction of the face is that of the cell, in proportion to the cavity fraction.
        let share = face.share_of(pattern);
        blocks::set_errors(&mut loads, self.block_errors.as_deref(), share);
        self.describe(&mut statements);
        self.correction.apply(timed.is_some(), &self.tilt, &mut loads, &mut statements);
        let mut simulation = Simulation { statements, loads };
        if let Some(refined) = &self.refined {
            if monitor.cancelled() {
                return cancelled(scene);
            }
            blocks::apply_refinement(scene, refined.clone(), share, &mut simulation);
        }
        describe_draws(scene, &mut simulation.statements);
        describe_law(scene, &mut simulation.statements);
        simulation
    }

    fn describe(&self, statements: &mut Statements) {
        let Self { scene, face, pattern, .. } = self;
        let strips = face.strips().len();
        statements.model(format!(
            "specimen as it is laid out: cavities take {:.2} % of its face, {:.2} % of a period; {} along the sliding direction with cavities and ends of {} own{}",
            100.0 * face.cavity_share(),
            100.0 * pattern.areal_density(),
            if strips == 1 { "one strip".to_owned() } else { format!("{strips} different strips") },
            if strips == 1 { "its" } else { "their" },
            if scene.layer.is_backed() { "" } else { ", under one rigid bulk" },
        ));
        let has_sliver =
            |strip: &Strip| without_slivers(strip.clone(), pattern.depth_m(), scene.layer.block_m) != *strip;
        if face.strips().iter().any(has_sliver) {
            statements.model(
                "walls at the rim that are narrower than the cavities are deep bear nothing: friction would turn them over",
            );
        }
        if scene.is_raised() {
            statements.model(rim_difference::statement());
        }
        if self.peak_over_longest > PRESSED_HARDER {
            statements.model(format!(
                "the largest local pressure is that of the longest strip; narrower lands at the border of the specimen carry up to {:.2} \
                 times that pressure",
                self.peak_over_longest
            ));
        }
        if self.shortened > 0 {
            statements.method(format!(
                "strips longer than {} mm: both ends and periodic cells between them, which changes the ratio of cavities of whole blocks by less than 2e-5",
                (STRIP_HEIGHTS * scene.layer.height_m * 1e6).round() / 1e3
            ));
        }
        statements.method(format!(
            "two dimensions: vertical planes along the sliding direction, plane stress, nu = 1/3{}",
            modulus_of_heights(scene)
        ));
    }
}

/// Memory that [`steady_face_ratios`] needs for the equations of `face`, in bytes.
///
/// # Errors
/// [`SceneError::TooLarge`] if the equations are refused.
pub fn steady_face_bytes(scene: &Scene, pattern: &Pattern, face: &Face) -> Result<f64, SceneError> {
    strips::face_bytes(&without_thickness(scene).layer, pattern, face)
}

/// Steady ratios of `face` by load, including the effect of the specimen's thickness, without error estimates; all
/// `None` once `monitor` has cancelled.
///
/// # Errors
/// [`SceneError`] if the strips do not fit in memory.
pub fn steady_face_ratios(
    scene: &Scene,
    pattern: &Pattern,
    face: &Face,
    monitor: &dyn Monitor,
) -> Result<Vec<Option<f64>>, SceneError> {
    let Some(SteadyFace { mut loads, .. }) = SteadyFace::new(scene, pattern, face, monitor)? else {
        return Ok(vec![None; scene.loads.len()]);
    };
    if scene.layer.is_backed() {
        ThickLayerCorrection::for_face(scene, pattern, face, monitor).apply(
            false,
            &PressureTilt::default(),
            &mut loads,
            &mut Statements::default(),
        );
    }
    Ok(loads.iter().map(|load| load.ratio()).collect())
}

/// Change of the ratio of `face` from steady to dynamic sliding at each load, from a dynamic run of the longest strip
/// with the options of `scene`; `None` if that run has no mean.
///
/// # Errors
/// The errors of [`simulate_specimen`].
pub fn time_changes(scene: &Scene, face: &Face, monitor: &dyn Monitor) -> Result<Vec<Option<f64>>, SceneError> {
    Ok(TimedStrip::new(&without_thickness(scene), face, &validated_pattern(scene)?, monitor)?.change_on(face))
}

#[cfg(test)]
mod tests;
