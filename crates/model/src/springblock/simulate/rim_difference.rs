//! Effect of rims on the strips of a specimen: the effect on the steady cell in proportion to the cavity fraction.
//!
//! Contact that opens and closes makes the equations of a strip nonlinear, which is expensive for a whole face. Rims
//! act near their own cavities only, so that the cell gives their effect on the ratio r of a face with the cavity
//! fraction D, with D_cell for the cell:
//!
//! ```text
//! r = r_strips + (r_cell,rims - r_cell) D / D_cell
//! ```

use crate::pattern::Pattern;

use crate::springblock::{
    CellOutcome, Dimension, Effect, Extent, Fidelity, LoadOutcome, Scene, Statements, Status, SteadyCell,
    SurfaceOutcome,
};

/// Relative standard error of the effect of rims: ends carry more load than the cell, and with few cavities rims have a
/// different weight (`rims_add_to_a_strip_what_they_add_to_the_cell`).
const RELATIVE_ERROR: f64 = 0.02;

/// Difference of the results of two steady cells under one load, the first minus the second.
#[derive(Clone, Copy, Debug)]
pub struct CellDifference {
    /// Difference of the friction ratios.
    pub ratio: f64,
    /// Peak pressure of the first cell over that of the second; 1 if either has none.
    pub peak: f64,
    /// Difference of the clearances under the ceiling, in metres; 0 if either cell has none.
    pub clearance_m: f64,
    /// Whether a pressure of the first cell exceeds the last pressure of the area law.
    pub is_extrapolated: bool,
}

impl CellDifference {
    /// Computes `with` minus `without`; `None` unless both have a ratio.
    pub fn new(with: &CellOutcome, without: &CellOutcome) -> Option<Self> {
        let (of_with, of_without) = (&with.surface, &without.surface);
        // Without friction there is a ratio, but no pressure to compare.
        let is_peak = of_without.peak_pressure_pa > 0.0 && of_with.status == Status::Converged;
        Some(Self {
            ratio: with.ratio? - without.ratio?,
            peak: if is_peak { of_with.peak_pressure_pa / of_without.peak_pressure_pa } else { 1.0 },
            clearance_m: of_with.clearance_m.zip(of_without.clearance_m).map_or(0.0, |(with, without)| with - without),
            is_extrapolated: of_with.area_law_extrapolated,
        })
    }

    /// Computes the differences between the outcomes `with` and `without`, by load.
    pub fn of_loads(with: &[CellOutcome], without: &[CellOutcome]) -> Vec<Option<Self>> {
        with.iter().zip(without).map(|(with, without)| Self::new(with, without)).collect()
    }

    /// Applies the changes of peak pressure, clearance and extrapolation to `surface`, but not that of the ratio.
    pub fn add_to(&self, surface: &mut SurfaceOutcome) {
        surface.peak_pressure_pa *= self.peak;
        surface.clearance_m = surface.clearance_m.map(|clearance_m| clearance_m + self.clearance_m);
        surface.cavity_closed |= surface.clearance_m.is_some_and(|clearance_m| clearance_m <= 0.0);
        surface.area_law_extrapolated |= self.is_extrapolated;
    }
}

/// Returns `pattern` with flat lands.
pub fn without_rim(pattern: &Pattern) -> Pattern {
    pattern.with_rim(None)
}

/// Differences between the steady cells of `scene` with and without the rims of `pattern`, by load; empty without rims.
pub fn of_rims(scene: &Scene, pattern: &Pattern) -> Vec<Option<CellDifference>> {
    if !scene.is_raised() {
        return Vec::new();
    }
    let solve = |scene: &Scene, pattern: &Pattern| SteadyCell::with_dimension(scene, Dimension::Plane).solve(pattern);
    let flat = Scene { relief: None, ..scene.clone() };
    let (with, without) = rayon::join(|| solve(scene, pattern), || solve(&flat, &without_rim(pattern)));
    CellDifference::of_loads(&with, &without)
}

/// Adds `differences` of steady cells to `loads`, whose cavity fraction is `share` times that of a period; a load
/// without a difference loses its ratio.
pub fn add(differences: &[Option<CellDifference>], share: f64, loads: &mut [LoadOutcome]) {
    for (load, difference) in loads.iter_mut().zip(differences) {
        let Some(difference) = difference else {
            load.remove_ratio();
            continue;
        };
        let change = difference.ratio * share;
        load.correct(Effect::Rims, change, RELATIVE_ERROR * change.abs());
        difference.add_to(&mut load.surface);
    }
}

/// Sentence on the effect of rims on strips, for the statements of a simulation.
pub fn statement() -> String {
    format!(
        "rims add to the strips what they add to the steady cell, known to {:.0} %; the interface is that of the cavities alone",
        100.0 * RELATIVE_ERROR
    )
}

/// Adds the effect of plastic yielding on the steady cell to `loads` of a sample or of a dynamic run, whose rims are
/// elastic and whose cavity fraction is `share` times that of a period, and a statement to `statements`. Does nothing if
/// the solid of `scene` does not yield; steady cells already include yielding.
pub fn add_yielding(
    scene: &Scene,
    pattern: &Pattern,
    share: f64,
    loads: &mut [LoadOutcome],
    statements: &mut Statements,
) {
    let Some(yield_pa) = scene.elastic.yield_pressure_pa().filter(|_| scene.is_raised()) else { return };
    let yields = format!(
        "heights of the face flatten for good at {} MPa, in the order of the loads",
        (yield_pa * 1e-3).round() * 1e-3
    );
    if scene.run.fidelity == Fidelity::Steady && scene.run.extent == Extent::Cell {
        statements.model(yields);
        return;
    }
    let Ok(elastic) = scene.elastic.with_yield_pressure_pa(None) else { return };
    let solve = |scene: &Scene| SteadyCell::with_dimension(scene, scene.dimension()).solve(pattern);
    let rigid = Scene { elastic, ..scene.clone() };
    let (with, without) = rayon::join(|| solve(scene), || solve(&rigid));
    add(&CellDifference::of_loads(&with, &without), share, loads);
    statements
        .model(format!("{yields}: by what that changes of the steady cell, known to {:.0} %", 100.0 * RELATIVE_ERROR));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pattern::{Rim, RimProfile};
    use crate::springblock::RunOptions;
    use crate::springblock::columns::{sample, with_relief};
    use crate::springblock::lattice::Lattice;
    use crate::springblock::outcome::Status;
    use crate::springblock::steady::{SteadyLoad, SteadyModel};
    use crate::springblock::tests::samples;

    #[test]
    fn yielding_counts_by_the_cavities_of_the_face() {
        let rim = Rim::new(1e-6, 20e-6, RimProfile::Round).unwrap();
        let pattern = samples::groove(130.0, 370.0, 20.0).with_rim(rim);
        let mut scene = samples::scene(pattern, &[0.65, 2.6], RunOptions::default());
        scene.elastic = scene.elastic.with_yield_pressure_pa(Some(9e6)).unwrap();
        scene.run.extent = Extent::Sample;
        let cell = SteadyCell::with_dimension(&scene, scene.dimension()).solve(&pattern);
        let change = |share: f64| -> Vec<f64> {
            let one = |(cell, load): (&CellOutcome, _)| {
                crate::springblock::simulate::compare(load, cell.surface.clone(), Some(cell.surface.clone()))
            };
            let mut loads: Vec<LoadOutcome> = cell.iter().zip(&scene.loads).map(one).collect();
            add_yielding(&scene, &pattern, share, &mut loads, &mut Statements::default());
            loads.iter().map(|load| load.correction(Effect::Rims).unwrap().change).collect()
        };
        let (half, whole) = (change(0.5), change(1.0));
        assert!(whole.iter().all(|change| change.abs() > 1e-4), "{whole:?}");
        assert!(half.iter().zip(&whole).all(|(half, whole)| (half / whole - 0.5).abs() < 1e-12), "{half:?} {whole:?}");
    }

    #[test]
    fn rims_add_to_a_strip_what_they_add_to_the_cell() {
        let mut worst = 0.0_f64;
        for (width, spacing, depth, height) in
            [(130.0, 370.0, 20.0, 0.1), (80.0, 160.0, 10.0, 0.3), (150.0, 300.0, 40.0, 1.0)]
        {
            let rim = Rim::new(height * 1e-6, 20e-6, RimProfile::Round).unwrap();
            let pattern = samples::groove(width, spacing, depth).with_rim(rim);
            let scene = samples::scene(pattern, &[0.65, 2.6], RunOptions::default());
            let differences = of_rims(&scene, &pattern);
            let law = samples::persson_law();
            let flat = sample(&without_rim(&pattern), 10e-6, 500);
            let share = flat.iter().map(|c| c.coverage).sum::<f64>() / 500.0 / pattern.section_density();
            let solve = |columns: Vec<crate::springblock::columns::Column>, pressure_pa: f64| {
                let lattice = Lattice::new(columns, 20, false);
                let model = SteadyModel::new(lattice, 10e-6, samples::E_PA, false);
                let load = SteadyLoad { pressure_pa, dynamic_mu: &vec![0.27; 500], area_law: Some(&law) };
                let outcome = model.solve(&load);
                assert_eq!(outcome.status, Status::Converged);
                outcome.mu_dynamic.unwrap() / (0.27 * law.factor(pressure_pa))
            };
            for (load, difference) in scene.loads.iter().zip(&differences) {
                let found = difference.as_ref().unwrap().ratio * share;
                let expected = solve(with_relief(flat.clone(), &pattern, 10e-6, None), load.pressure_pa)
                    - solve(flat.clone(), load.pressure_pa);
                worst = worst.max((found / expected - 1.0).abs());
            }
        }
        assert!(worst < 2.0 * RELATIVE_ERROR, "{worst}");
    }
}
