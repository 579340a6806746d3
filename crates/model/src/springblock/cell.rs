//! Steady friction ratio of many patterns for one material and fixed loads: the model that a search calls.

use std::cell::OnceCell;
use std::sync::Arc;

use crate::material::{AreaLaw, Elastic};
use crate::pattern::{Pattern, ReliefMap, Texture};
use rayon::prelude::*;

use crate::springblock::rims::Rims;
use crate::springblock::space::TOLERANCE;
use crate::springblock::steady::{
    CondensedModel, FaceHistory, RaisedModel, ThickModel, band_products, condensing_cost, factor_bytes,
};
use crate::springblock::{
    Dimension, Lattice, Layer, Load, MAX_DRAWS, Monitor, Scene, SpaceLattice, SpaceLoad, SpaceSteadyModel, Status,
    SteadyLoad, SteadyModel, SurfaceOutcome, Unwatched, columns,
};

/// Memory per column and explicit row of a cell in space, in bytes: three displacement fields, their spectra, condensed
/// matrices, and a share of the stored search directions.
const BYTES_PER_BLOCK: f64 = 1200.0;
/// Maximum memory of a cell in space if several cells are solved at the same time, in bytes.
const MAX_SPACE_BYTES: f64 = (1_u64 << 30) as f64;
/// Like [`MAX_SPACE_BYTES`], for a cell in the plane, whose equations may include all blocks.
const MAX_PLANE_BYTES: f64 = 4.0 * MAX_SPACE_BYTES;

/// Steady sliding of one periodic cell with mean coefficients, in the vertical plane along the sliding direction or in
/// space.
///
/// The flat surface needs no solve: a uniform layer carries the nominal pressure P everywhere and slides at mu_d f(P),
/// so that ratio = mu / (mu_d f(P)), with the area factor f. If the scene gives the thickness of the specimen, the cell
/// is as thick as the specimen; the rows above the layer are condensed and add no cost.
#[derive(Clone, Debug)]
pub struct SteadyCell {
    dimension: Dimension,
    elastic: Elastic,
    area_law: Option<AreaLaw>,
    layer: Layer,
    loads: Vec<Load>,
    liftoff: bool,
    relief: Option<Arc<ReliefMap>>,
    /// A solve in space ends when the sum of the magnitudes of unbalanced forces over the load is at most this
    /// tolerance.
    tolerance: f64,
}

/// Result of a pattern under one load.
#[derive(Clone, Debug, PartialEq)]
pub struct CellOutcome {
    /// Outcome of the patterned surface.
    pub surface: SurfaceOutcome,
    /// Friction coefficient of the flat surface; `None` without load or if its friction vanishes.
    pub mu_flat: Option<f64>,
    /// Friction of the patterned over that of the flat surface; `None` without load or friction, or if the solve did
    /// not converge.
    pub ratio: Option<f64>,
}

impl CellOutcome {
    /// Combines the outcome `surface` of the pattern under `load` with the friction of the flat surface.
    fn new(load: &Load, area_law: Option<&AreaLaw>, surface: SurfaceOutcome) -> Self {
        let mu_flat = Some(load.flat_mu(area_law)).filter(|mu| *mu > 0.0 && load.pressure_pa > 0.0);
        let ratio = match (surface.status, surface.mu_dynamic, mu_flat) {
            (Status::Converged | Status::NoFriction, Some(mu), Some(flat)) => Some(mu / flat),
            _ => None,
        };
        Self { surface, mu_flat, ratio }
    }
}

impl SteadyCell {
    /// Creates the cell of `scene`; options of time integration are ignored.
    ///
    /// The dimension is the one that the scene requests, otherwise the one that its pattern needs; without a pattern
    /// the cell is in the plane.
    pub fn new(scene: &Scene) -> Self {
        let asked = scene.run.dimensions;
        let flat_dimension = || asked.map_or(Dimension::Plane, Dimension::numbered);
        let pattern_dimension = |pattern: &Pattern| Dimension::of(asked, pattern.texture());
        Self::with_dimension(scene, scene.pattern.as_ref().map_or_else(flat_dimension, pattern_dimension))
    }

    /// Like [`Self::new`], for patterns of `texture` instead of the scene's pattern.
    pub fn of_texture(scene: &Scene, texture: &Texture) -> Self {
        Self::with_dimension(scene, Dimension::of(scene.run.dimensions, texture))
    }

    /// Creates the cell of `scene` for the given dimension.
    pub(crate) fn with_dimension(scene: &Scene, dimension: Dimension) -> Self {
        Self {
            dimension,
            elastic: scene.elastic,
            area_law: scene.area_law.clone(),
            layer: scene.layer,
            loads: scene.loads.clone(),
            liftoff: scene.run.liftoff,
            relief: scene.relief.clone(),
            tolerance: TOLERANCE,
        }
    }

    /// Sets the tolerance of solves in space for the sum of the magnitudes of unbalanced forces over the load, 1e-10 by
    /// default. A tolerance of 1e-7 saves about a third of the time.
    #[must_use]
    pub fn balanced_to(self, tolerance: f64) -> Self {
        Self { tolerance, ..self }
    }

    /// Dimension in which the cell is solved.
    pub const fn dimension(&self) -> Dimension {
        self.dimension
    }

    const fn is_spatial(&self) -> bool {
        matches!(self.dimension, Dimension::Space)
    }

    /// Number of draws of local coefficients, at most [`MAX_DRAWS`], that give a cell of `pattern` at least `contacts`
    /// contact blocks in total. In the vertical plane it is 1, because a sample there already averages over many
    /// blocks.
    pub fn draws(&self, pattern: &Pattern, contacts: f64) -> u64 {
        if !self.is_spatial() {
            return 1;
        }
        let [nx, ny] = self.columns(pattern);
        // A groove is represented by one period along its length.
        let columns = nx * if pattern.is_uniform_along_y() { nx } else { ny };
        // Between 1 and MAX_DRAWS: the cast is exact.
        (contacts / (columns * (1.0 - pattern.areal_density()))).ceil().clamp(1.0, MAX_DRAWS as f64) as u64
    }

    /// Number of columns of the cell of `pattern` along x and y, whole numbers; 1 along y for grooves and in the plane.
    pub fn columns(&self, pattern: &Pattern) -> [f64; 2] {
        if self.is_spatial() {
            return SpaceLattice::columns_of(pattern, self.layer.block_m);
        }
        [self.lattice(pattern).nx() as f64, 1.0]
    }

    /// Estimated upper bound of the memory that [`Self::solve`] needs, in bytes.
    pub fn bytes(&self, pattern: &Pattern) -> f64 {
        if self.is_spatial() {
            let [nx, ny] = self.columns(pattern);
            return nx * ny * ((pattern.depth_m() / self.layer.block_m).ceil() + 1.0).max(2.0) * BYTES_PER_BLOCK;
        }
        if self.layer.is_backed() {
            return cell_condensing_cost(pattern, self.layer.block_m).1;
        }
        factor_bytes(self.max_columns(pattern), self.layer.rows(), true)
    }

    /// Maximum memory that a cell should take if several are solved at the same time, in bytes.
    pub const fn most_bytes(&self) -> f64 {
        if self.is_spatial() { MAX_SPACE_BYTES } else { MAX_PLANE_BYTES }
    }

    /// Estimated upper bound of the number of multiplications that [`Self::solve`] needs in the plane.
    pub(crate) fn products(&self, pattern: &Pattern) -> f64 {
        let (condensed, _) = cell_condensing_cost(pattern, self.layer.block_m);
        if self.layer.is_backed() {
            return condensed;
        }
        band_products(self.max_columns(pattern), self.layer.rows()).min(condensed)
    }

    /// Upper bound of the number of columns of the cell in the plane.
    fn max_columns(&self, pattern: &Pattern) -> usize {
        // The cast saturates: a number beyond 2^64 exceeds every limit.
        (pattern.pitch_m() / self.layer.block_m).ceil() as usize * Rims::periods(pattern)
    }

    /// Whether the cell of `pattern` in space consists of whole cubic blocks.
    pub(crate) fn is_plain(&self, pattern: &Pattern) -> bool {
        SpaceLattice::cell(pattern, self.layer.block_m, self.layer.rows()).is_plain()
    }

    /// Solves steady sliding on `pattern`; returns one outcome per load.
    ///
    /// In the plane condensed equations are used where they apply and take fewer operations, otherwise the equations of
    /// [`Self::solve_all_blocks`]; both agree to rounding. In space the cell is condensed once, and the solution at one
    /// load is the initial guess for the next.
    pub fn solve(&self, pattern: &Pattern) -> Vec<CellOutcome> {
        self.solve_heeding(pattern, &Unwatched)
    }

    /// Like [`Self::solve`]; when `monitor` cancels, solves in space stop without a result.
    pub fn solve_heeding(&self, pattern: &Pattern, monitor: &dyn Monitor) -> Vec<CellOutcome> {
        if self.is_spatial() {
            let lattice = self.space_lattice(pattern, self.layer.thick_rows());
            return self.solve_in_space(lattice, pattern, monitor);
        }
        let lattice = self.lattice(pattern);
        let stiffness = self.elastic.youngs_modulus_pa();
        if lattice.is_raised()
            && let Some(model) = RaisedModel::new(&lattice, self.layer.block_m, self.elastic)
        {
            let mut history = FaceHistory::default();
            return self.solve_in_plane(lattice.nx(), |load| model.solve(load, &mut history));
        }
        if self.layer.is_backed() {
            let columns = lattice.nx();
            let model = ThickModel::new(lattice, self.layer.block_m, self.elastic, self.liftoff);
            return self.solve_in_plane(columns, |load| model.solve(load));
        }
        let condensed = CondensedModel::new(&lattice, self.layer.block_m, stiffness, self.liftoff);
        let all_blocks = OnceCell::new();
        self.solve_in_plane(lattice.nx(), |load| {
            condensed
                .as_ref()
                .and_then(|model| model.solve(load))
                .unwrap_or_else(|| all_blocks.get_or_init(|| self.steady_model(lattice.clone())).solve(load))
        })
    }

    /// Solves steady sliding on `pattern` in the plane by factorizing the equations of all blocks. Slower than
    /// [`Self::solve`]; serves as its reference in tests.
    pub fn solve_all_blocks(&self, pattern: &Pattern) -> Vec<CellOutcome> {
        let model = self.steady_model(self.lattice(pattern));
        self.solve_in_plane(model.lattice().nx(), |load| model.solve(load))
    }

    fn lattice(&self, pattern: &Pattern) -> Lattice {
        let columns = columns::cell_with_map(pattern, self.layer.block_m, self.relief.as_deref());
        Lattice::new(columns, self.layer.thick_rows(), true)
    }

    /// Returns the cell of `pattern` in space with `rows` rows.
    pub(crate) fn space_lattice(&self, pattern: &Pattern, rows: usize) -> SpaceLattice {
        SpaceLattice::cell_with_map(pattern, self.layer.block_m, rows, self.relief.as_deref())
    }

    fn steady_model(&self, lattice: Lattice) -> SteadyModel {
        SteadyModel::new(lattice, self.layer.block_m, self.elastic.youngs_modulus_pa(), self.liftoff)
    }

    fn solve_in_plane(&self, columns: usize, mut solve: impl FnMut(&SteadyLoad) -> SurfaceOutcome) -> Vec<CellOutcome> {
        let area_law = self.area_law.as_ref();
        let solved = |load: &Load| {
            let dynamic_mu = vec![load.friction.dynamic_mean(); columns];
            let surface = solve(&SteadyLoad { pressure_pa: load.pressure_pa, dynamic_mu: &dynamic_mu, area_law });
            CellOutcome::new(load, area_law, surface)
        };
        self.loads.iter().map(solved).collect()
    }

    /// Solves steady sliding of `lattice` along the sliding direction of `pattern`; returns one outcome per load.
    pub(crate) fn solve_in_space(
        &self,
        lattice: SpaceLattice,
        pattern: &Pattern,
        monitor: &dyn Monitor,
    ) -> Vec<CellOutcome> {
        let area_law = self.area_law.as_ref();
        let model = SpaceSteadyModel::new(lattice, self.layer.block_m, self.elastic.youngs_modulus_pa(), self.liftoff)
            .yielding_at(self.elastic.yield_pressure_pa())
            .balanced_to(self.tolerance);
        let loads: Vec<SpaceLoad<'_>> = self
            .loads
            .iter()
            .map(|load| SpaceLoad::with_mean_friction(load, area_law, pattern.sliding_direction()))
            .collect();
        let outcomes = model.solve_all(&loads, monitor).into_iter().zip(&self.loads);
        outcomes.map(|(outcome, load)| CellOutcome::new(load, area_law, outcome)).collect()
    }

    /// Returns only the ratios of [`Self::solve`], one per load: friction of the patterned over that of the flat
    /// surface.
    ///
    /// A closed cavity does not make the ratio `None`, although the result is then invalid: the model lets the ceiling
    /// pass through the counterface. Check `surface.cavity_closed` of [`Self::solve`].
    pub fn ratios(&self, pattern: &Pattern) -> Vec<Option<f64>> {
        self.ratios_heeding(pattern, &Unwatched)
    }

    /// Like [`Self::ratios`], with cancellation as in [`Self::solve_heeding`].
    pub fn ratios_heeding(&self, pattern: &Pattern, monitor: &dyn Monitor) -> Vec<Option<f64>> {
        self.solve_heeding(pattern, monitor).into_iter().map(|outcome| outcome.ratio).collect()
    }

    /// Returns the ratios of many patterns, in the order of the patterns and then of the loads. Patterns are solved in
    /// parallel on rayon's current pool; the result does not depend on the number of threads.
    pub fn ratios_of(&self, patterns: &[Pattern]) -> Vec<Vec<Option<f64>>> {
        patterns.par_iter().map(|pattern| self.ratios(pattern)).collect()
    }
}

/// Estimated number of multiply-adds, and memory in bytes, for the cell of `pattern` on a thick specimen with blocks of
/// `block_m`.
pub fn cell_condensing_cost(pattern: &Pattern, block_m: f64) -> (f64, f64) {
    let blocks = |length_m: f64| (length_m / block_m).ceil();
    let periods = Rims::periods(pattern) as f64;
    condensing_cost(periods * blocks(pattern.pitch_m()), periods * blocks(pattern.width_m()), blocks(pattern.depth_m()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::LocalFriction;
    use crate::pattern::Planform;
    use crate::pattern::{Rim, RimProfile};
    use crate::springblock::RunOptions;
    use crate::springblock::tests::samples;

    fn model() -> SteadyCell {
        let area_law = Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.6]).unwrap());
        let scene = samples::scene(samples::groove(130.0, 370.0, 20.0), &[0.65, 2.6], RunOptions::default());
        SteadyCell::new(&Scene { area_law, pattern: None, ..scene })
    }

    #[test]
    fn ratios_are_the_same_with_any_number_of_threads() {
        let patterns: Vec<Pattern> =
            (1..=40).map(|step| samples::groove(10.0 * f64::from(step), 370.0, 20.0)).collect();
        let ratios = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| model().ratios_of(&patterns))
        };
        let (one, three) = (ratios(1), ratios(3));
        assert!(one == three && one[7] == model().ratios(&patterns[7]));
        assert!(one.iter().flatten().all(|ratio| ratio.is_some_and(|r| r > 0.5 && r < 1.0 + 1e-9)));
    }

    #[test]
    fn a_thick_specimen_is_solved_as_all_of_its_blocks_say_lifted_ones_too() {
        let mut model = model();
        model.layer.thickness_m = Some(600e-6);
        let close = |a: f64, b: f64, scale: f64| (a - b).abs() < 1e-9 * scale;
        for ([width, spacing, depth], liftoff) in [
            ([130.0, 370.0, 20.0], false),
            ([133.3, 171.9, 14.0], true),
            // A land that tilts.
            ([100.0, 40.0, 120.0], true),
        ] {
            model.liftoff = liftoff;
            for load in &mut model.loads {
                load.friction = LocalFriction::new(0.66, 0.6, 0.05).unwrap();
            }
            let pattern = Pattern::new(Planform::Groove, width * 1e-6, spacing * 1e-6, depth * 1e-6).unwrap();
            for (found, expected) in model.solve(&pattern).iter().zip(model.solve_all_blocks(&pattern)) {
                let (own, all) = (&found.surface, &expected.surface);
                assert_eq!((own.status, own.tension_blocks), (all.status, all.tension_blocks), "{width}");
                assert!(close(found.ratio.unwrap(), expected.ratio.unwrap(), 1.0), "{width}");
                assert!(close(own.peak_pressure_pa, all.peak_pressure_pa, all.peak_pressure_pa), "{width}");
                assert!(close(own.clearance_m.unwrap(), all.clearance_m.unwrap(), 1e-3), "{width}");
                let off = |outcome: &SurfaceOutcome| outcome.interface.iter().filter(|p| p.pressure_pa == 0.0).count();
                assert_eq!((off(own), off(own) > 0), (off(all), depth > 100.0));
            }
        }
    }

    #[test]
    fn a_looser_balance_in_space_moves_ratios_by_about_as_much_and_takes_fewer_directions() {
        let um = 1e-6;
        let lengths = [[60.0, 90.0, 20.0], [67.0, 81.0, 23.0], [130.0, 370.0, 20.0], [40.0, 40.0, 5.0]];
        for planform in [Planform::Square, Planform::Disc, Planform::Crosshatch] {
            for [width, spacing, depth] in lengths {
                for rim_height_um in [0.0, 0.3] {
                    let mut pattern = Pattern::new(planform, width * um, spacing * um, depth * um).unwrap();
                    if rim_height_um > 0.0 {
                        pattern = pattern.with_rim(Rim::new(rim_height_um * um, 20.0 * um, RimProfile::Flat).unwrap());
                    }
                    let cell = SteadyCell { dimension: Dimension::Space, ..model() };
                    let directions = |cell: &[CellOutcome]| cell.iter().map(|of| of.surface.iterations).sum::<usize>();
                    let (close, loose) = (cell.solve(&pattern), cell.balanced_to(1e-7).solve(&pattern));
                    assert!(directions(&loose) < directions(&close), "{pattern:?}");
                    for (close, loose) in close.iter().zip(&loose) {
                        let off = (close.ratio.unwrap() - loose.ratio.unwrap()).abs();
                        assert!(off < 1e-7, "{pattern:?}: {off}");
                    }
                }
            }
        }
    }

    #[test]
    fn designs_that_only_all_blocks_can_solve_are_solved() {
        let model = model();
        // A cavity that reaches the top row.
        let pattern = Pattern::new(Planform::Groove, 60e-6, 90e-6, 195e-6).unwrap();
        assert_eq!(model.solve(&pattern), model.solve_all_blocks(&pattern));
        assert!(model.ratios(&pattern).iter().all(Option::is_some));
    }
}
