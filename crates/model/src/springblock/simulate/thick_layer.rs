//! Effect of the specimen's thickness beyond the modelled layer.
//!
//! Steady cells are solved over the whole thickness. Strips with ends and dynamic runs have the blocks of the layer
//! only; the effect on the steady cell of the same pattern is added to their ratio:
//!
//! ```text
//! r = r_layer + (r_cell,thick - r_cell,layer) D / D_period
//! ```
//!
//! with the area fractions D of cavities on the face and in a period. If a scene does not give the thickness, no
//! correction is made, but a statement on the effect of a thick specimen.

use crate::pattern::Pattern;

use super::pressure_tilt::PressureTilt;
use super::rim_difference::{CellDifference, without_rim};
use super::{MAX_FACTOR_BYTES, load_sharing, widest};
use crate::springblock::{
    CellOutcome, Dimension, Effect, Extent, Face, Fidelity, Layer, LoadOutcome, Monitor, Scene, Statements, SteadyCell,
};

/// Standard error of the ratio of a dynamic run due to adding the difference of steady cells.
///
/// It is the root mean square difference from runs of the thick layer itself, over ten textures
/// (`a_thick_layer_in_time_is_a_thin_one_and_the_steady_difference`). The largest difference, 0.0025, occurs where
/// cavities are closest: there stick-slip raises friction 1.5 times as much over a layer of 800 um as over a layer of
/// 200 um, at any time step.
const DYNAMIC_ERROR: f64 = 0.0012;
/// Standard error of the ratio of a strip with ends that is at least [`REFERENCE_LENGTH_M`] long; for shorter strips it
/// is inversely proportional to the length (`ends_hardly_change_what_is_behind_the_layer`).
const END_ERROR: f64 = 0.001;
/// Length of a strip, in metres, below which [`END_ERROR`] is increased.
const REFERENCE_LENGTH_M: f64 = 10e-3;
/// Maximum standard error of the correction as a fraction of the friction reduction by the pattern: without a reduction
/// there is no error.
const RELATIVE_ERROR: f64 = 0.1;
/// Thickness beyond the layer, in periods, that is equivalent to a half-space: the effect of a period decays by exp(-4
/// pi) over the length of one period.
const THICK_PERIODS: f64 = 4.0;
/// Cells in space may be compared in blocks of twice the size if a period has at least this number of blocks.
const COARSE_PERIOD: f64 = 8.0;

/// Differences between the steady cell of a thick specimen and that of the layer alone, by load.
#[derive(Clone, Debug)]
pub struct ThickLayerCorrection {
    layer: Layer,
    /// Whether the solved ratios already include the effect of the thickness.
    is_solved: bool,
    /// Standard error of the correction due to the ends of strips.
    end_error: f64,
    /// Relative standard error of the correction due to load sharing; 0 for cells.
    relative_error: f64,
    each: Vec<Option<CellDifference>>,
}

/// Returns `scene` as its solver takes it: with the thickness for steady cells, without it for others.
pub fn solver_scene(scene: &Scene) -> Scene {
    let layer = if is_cell(scene) { scene.layer } else { scene.layer.alone() };
    Scene { layer, ..scene.clone() }
}

/// Whether the scene is a steady cell, which is solved over the whole thickness.
fn is_cell(scene: &Scene) -> bool {
    scene.run.fidelity == Fidelity::Steady && scene.run.extent == Extent::Cell
}

impl ThickLayerCorrection {
    /// Computes the differences for `scene` with `pattern`. If the scene gives no thickness, they are those of a very
    /// thick specimen.
    pub fn new(scene: &Scene, pattern: &Pattern, monitor: &dyn Monitor) -> Self {
        let mut thick = Self::comparison_scene(scene, pattern);
        let extent_m =
            pattern.pitch_m().max(if scene.dimension() == Dimension::Space { pattern.cell_m()[1] } else { 0.0 });
        if !scene.layer.is_backed() {
            thick.layer.thickness_m = Some(scene.layer.height_m + THICK_PERIODS * extent_m);
        }
        let alone = Scene { layer: thick.layer.alone(), ..thick.clone() };
        let (thick, alone) = rayon::join(|| cells(&thick, pattern, monitor), || cells(&alone, pattern, monitor));
        let each = CellDifference::of_loads(&thick, &alone);
        let end_error = match scene.run.extent {
            Extent::Cell => 0.0,
            Extent::Sample | Extent::Strip => END_ERROR * (REFERENCE_LENGTH_M / scene.layer.length_m).max(1.0),
        };
        let is_solved = is_cell(scene) && scene.layer.is_backed();
        Self { layer: scene.layer, is_solved, end_error, relative_error: 0.0, each }
    }

    /// Returns the scene of the compared cells, with blocks of twice the size if this saves time without loss of
    /// accuracy.
    pub fn comparison_scene(scene: &Scene, pattern: &Pattern) -> Scene {
        // Steady cells in space take long, and the block size hardly affects the field far above the blocks.
        let rows = scene.layer.rows();
        let is_coarse = scene.dimension() == Dimension::Space
            && is_cell(scene)
            && rows.is_multiple_of(2)
            && rows > 2
            && pattern.pitch_m() >= COARSE_PERIOD * scene.layer.block_m;
        let mut cell = scene.clone();
        cell.layer.block_m *= if is_coarse { 2.0 } else { 1.0 };
        cell
    }

    /// Scales the differences of the ratios to a face whose cavity fraction is `share` times that of a period.
    pub fn scaled(mut self, share: f64) -> Self {
        self.each.iter_mut().flatten().for_each(|each| each.ratio *= share);
        self
    }

    /// Computes the differences for a specimen with `face` and cavities of `pattern`. If the scene gives the thickness,
    /// the load is distributed over the strips as under the elastic specimen, with flat lands ([`load_sharing`]).
    pub fn for_face(scene: &Scene, pattern: &Pattern, face: &Face, monitor: &dyn Monitor) -> Self {
        if !scene.layer.is_backed() {
            return Self::new(scene, pattern, monitor).scaled(face.share_of(pattern));
        }
        let (scene, pattern) = (&Scene { relief: None, ..scene.clone() }, &without_rim(pattern));
        let mut correction = Self::new(scene, pattern, monitor);
        let differences = load_sharing::difference(scene, pattern, face, monitor);
        let differences = differences.unwrap_or_else(|| vec![None; scene.loads.len()]);
        for (each, for_face) in correction.each.iter_mut().zip(differences) {
            *each = each.zip(for_face).map(|(cell, ratio)| CellDifference { ratio, ..cell });
        }
        correction.relative_error = load_sharing::RELATIVE_ERROR;
        correction
    }

    /// Adds the differences and `tilt` to the ratios of `loads` if the scene gives a thickness that the solution does
    /// not include. Appends a statement on the thickness, and one on the tilt if it is added. With `is_in_time`,
    /// `loads` are from a dynamic run.
    pub fn apply(&self, is_in_time: bool, tilt: &PressureTilt, loads: &mut [LoadOutcome], statements: &mut Statements) {
        let is_added = self.layer.is_backed() && !self.is_solved;
        let open = (if is_in_time { DYNAMIC_ERROR } else { 0.0 }).hypot(self.end_error);
        for (load, difference) in loads.iter_mut().zip(&self.each).filter(|_| is_added) {
            let Some(difference) = difference else { continue };
            add(difference, open.hypot(self.relative_error * difference.ratio), load);
        }
        if !self.each.is_empty() && loads.iter().any(|load| load.ratio().is_some()) {
            self.describe(is_added, loads, statements);
            if is_added {
                tilt.add(loads, statements);
            }
        }
    }

    fn describe(&self, is_added: bool, loads: &[LoadOutcome], statements: &mut Statements) {
        let Layer { height_m, thickness_m, .. } = self.layer;
        let (layer_um, thick_mm) = (height_m * 1e6, (thickness_m.unwrap_or(height_m) * 1e6).round() / 1e3);
        let known = || self.each.iter().flatten().map(|difference| difference.ratio);
        let widest = widest(known());
        if known().count() < loads.iter().filter(|load| load.ratio().is_some()).count() {
            return statements.model(format!(
                "layer of {layer_um:.0} um under a rigid bulk: what a thicker specimen changes could not be computed, as its \
                 steady cell has no equilibrium"
            ));
        }
        let widest = if widest.abs() < 5e-5 { "less than 0.0001".to_owned() } else { format!("{widest:+.4} at most") };
        if self.is_solved {
            return statements.model(format!(
                "specimen {thick_mm} mm thick, all of it elastic: that changes the ratio of its lowest {layer_um:.0} um alone by \
                 {widest}"
            ));
        }
        if is_added {
            let behind = loads.iter().filter_map(|load| load.correction(Effect::Behind));
            let open = behind.filter_map(|behind| behind.std).fold(0.0, f64::max);
            let cells = if self.relative_error == 0.0 { "the steady cell" } else { "steady cells that share the load" };
            return statements.method(format!(
                "blocks of the lowest {layer_um:.0} um of the specimen; the rest of its {thick_mm} mm changes the ratio by \
                 {widest}, as found for {cells}, known to {open:.4}; mu_static and the interface are those of the layer alone"
            ));
        }
        statements.model(format!(
            "layer of {layer_um:.0} um under a rigid bulk, as asked for: a specimen much thicker than the pattern is wide would \
             change the ratio by {widest}"
        ));
    }
}

/// Outcomes of the steady cell of `pattern` by load; empty if the equations do not fit in memory.
fn cells(scene: &Scene, pattern: &Pattern, monitor: &dyn Monitor) -> Vec<CellOutcome> {
    let model = SteadyCell::with_dimension(scene, scene.dimension());
    if model.bytes(pattern) > MAX_FACTOR_BYTES { Vec::new() } else { model.solve_heeding(pattern, monitor) }
}

/// Adds `difference` to `load`, with the standard error `open`, limited by [`RELATIVE_ERROR`].
fn add(difference: &CellDifference, open: f64, load: &mut LoadOutcome) {
    if let Some(ratio) = load.ratio() {
        let std = open.min(RELATIVE_ERROR * (1.0 - ratio - difference.ratio).abs());
        load.correct(Effect::Behind, difference.ratio, std);
    }
    difference.add_to(&mut load.surface);
}

#[cfg(test)]
mod tests;
