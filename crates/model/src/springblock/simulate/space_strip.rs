//! A strip of the sample in space: one period wide with periodic sides, as long as the sample, with two ends.

use std::ops::Range;

use crate::pattern::Pattern;
use rayon::prelude::*;

use super::drawn_ratios::solve_drawn;
use super::specimen::min_wall_m;
use super::statements::few_periods;
use super::{compare, require_memory, steady_coefficients};
use crate::springblock::{
    LoadOutcome, Monitor, Scene, SceneError, SpaceLattice, SpaceSteadyModel, Strip, SurfaceOutcome,
};

/// Prime factors for which Fourier transforms are fast. The number of lines of a strip, including the gap between its
/// ends, has no other prime factors.
const FACTORS: [usize; 6] = [2, 3, 5, 7, 11, 13];
/// Minimum width of a whole cavity relative to the widest cavity; narrower cavities count as cut by an end of the
/// strip.
const WHOLE_CAVITY: f64 = 1.0 - 1e-6;
/// Memory per block of a steady solution of a strip, in bytes: displacements of all rows, spectra, and stored search
/// directions.
pub const BYTES_PER_BLOCK: f64 = 800.0;

/// A strip and its flat counterpart, as lattices whose y axis runs along the strip.
pub struct SpaceStrip {
    /// Lattice with cavities, and flat lattice.
    pub lattices: [SpaceLattice; 2],
    /// Unit vector of the sliding direction in the axes of the lattices.
    pub direction: [f64; 2],
    /// Whether the y axis of the lattices is the x axis of the pattern.
    is_transposed: bool,
    /// Length in periods; `None` if the cavities are those of a layout.
    periods: Option<f64>,
    /// Cavity fraction of the strip over that of its cells.
    pub relative_cavity_share: f64,
}

impl SpaceStrip {
    /// Creates the strip of `scene` with `pattern`, which repeats `cell` over the length of the cavities of `layout`.
    /// Without a layout the strip begins with a whole cell, and its end cuts the last cell.
    pub fn new(scene: &Scene, pattern: &Pattern, cell: &SpaceLattice, layout: Option<&Strip>) -> Self {
        let [along_x, along_y] = pattern.sliding_direction();
        let is_transposed = pattern.texture().slides_along_rows();
        let direction = [0.0, if is_transposed { along_x.signum() } else { along_y.signum() }];
        let cell = if is_transposed { cell.transposed() } else { cell.clone() };
        let [_, period] = cell.columns();
        // Validated to be at least one block; the cast is exact.
        let spacing = cell.spacing()[1];
        let lines = (scene.layer.columns() as f64 / spacing).round().max(1.0) as usize;
        let gap = gap_after(lines);
        let own = match layout {
            None => cell.strip_along_y(lines, gap, |line| Some(line % period)),
            Some(layout) => {
                let line_m = spacing * scene.layer.block_m;
                let cell_lines = CellLines::new(layout, line_m, &cell);
                // If a wall at an end is too slender, the adjacent cavity replaces it.
                let slender = (min_wall_m(pattern.depth_m(), scene.layer.block_m) / line_m).ceil() as usize;
                let walls = cell_lines.walls(lines).map(|wall| wall.filter(|wall| *wall < slender).unwrap_or(0));
                // A strip that consists of walls only is kept.
                let [first, last] = if walls[0] + walls[1] < lines { walls } else { [0; 2] };
                cell.strip_along_y(lines, gap, |line| cell_lines.line_of_cell(line.clamp(first, lines - 1 - last)))
            }
        };
        // In whole blocks, cavities narrower than half a block vanish.
        let of_cell = cavity_share(&cell);
        let relative_cavity_share = if of_cell > 0.0 { cavity_share(&own) / of_cell } else { 1.0 };
        let flat = cell.strip_along_y(lines, gap, |_| None);
        // The cell may contain several periods.
        let cell_m = pattern.cell_m()[usize::from(!is_transposed)];
        Self {
            lattices: [own, flat],
            direction,
            is_transposed,
            periods: layout.is_none().then_some(scene.layer.length_m / cell_m),
            relative_cavity_share,
        }
    }

    /// Converts an outcome on a lattice of the strip from the axes of the lattice to the axes of the pattern.
    pub fn to_pattern_axes(&self, outcome: &mut SurfaceOutcome) {
        if !self.is_transposed {
            return;
        }
        for point in &mut outcome.interface {
            std::mem::swap(&mut point.x_m, &mut point.y_m);
        }
        outcome.interface.sort_by(|a, b| a.y_m.total_cmp(&b.y_m).then(a.x_m.total_cmp(&b.x_m)));
        // Mirroring exchanges left and right of the sliding direction.
        outcome.mu_across = outcome.mu_across.map(|across| -across);
    }

    /// Statement that the cavity fraction differs from that of a period of `pattern`; `None` if it does not, and for a
    /// strip with the cavities of a layout.
    pub fn few_periods_statement(&self, pattern: &Pattern) -> Option<String> {
        few_periods(self.periods?, cavity_share(&self.lattices[0]), pattern.areal_density())
    }

    /// Number of columns along and across the sliding direction, in this order.
    pub fn columns(&self) -> [usize; 2] {
        let [across, _] = self.lattices[0].columns();
        [self.lattices[0].face_columns() / across, across]
    }

    /// Sentence on the size of the strip, for the statements of a simulation.
    pub fn statement(&self) -> String {
        let [along, across] = self.columns();
        format!(
            "strip: {along} columns along the sliding direction with two free ends, one period of {across} columns across with periodic sides"
        )
    }
}

/// Area fraction of cavities on the face of `lattice`.
fn cavity_share(lattice: &SpaceLattice) -> f64 {
    let [nx, ny] = lattice.columns();
    let bears = (0..nx * ny).map(|column| lattice.contact_share(column % nx, column / nx)).sum::<f64>();
    1.0 - bears / lattice.face_columns() as f64
}

/// Assignment of the lines of a strip (rows of columns across its length) to lines of cells.
struct CellLines {
    /// Line of the strip, possibly negative, at which the first cell begins.
    first: isize,
    /// Lines of the strip that belong to cells.
    lines: Range<isize>,
    /// Number of lines of a cell.
    period: isize,
    /// Number of lines of a cell before its first cavity and after its last one.
    lands: [isize; 2],
}

impl CellLines {
    /// Assigns the lines of the strip `layout`, with lines of `line_m`: as many cells as the strip has whole cavities,
    /// centred on these cavities, so that none is lost if the length of a cell differs from the period. Cells continue
    /// up to an end that cuts a cavity. Without cavities there are no cells.
    fn new(layout: &Strip, line_m: f64, cell: &SpaceLattice) -> Self {
        let [nx, ny] = cell.columns();
        let mut of_cavities = (0..ny).filter(|j| (0..nx).any(|i| cell.is_cavity(i, *j)));
        let ends = of_cavities.next().map(|before| (before, of_cavities.next_back().unwrap_or(before)));
        // Strips have at most 1e7 lines: the casts are exact.
        let period = ny as isize;
        let lands = ends.map_or([0; 2], |(first, last)| [first as isize, (ny - 1 - last) as isize]);
        let widest_m = layout.cavities_m.iter().map(|[start_m, end_m]| end_m - start_m).fold(0.0, f64::max);
        let mut whole = layout.cavities_m.iter().filter(|[start_m, end_m]| end_m - start_m > WHOLE_CAVITY * widest_m);
        let count = whole.clone().count() as isize;
        let (Some(start), Some(end)) = (whole.clone().next(), whole.next_back().or(layout.cavities_m.first())) else {
            return Self { first: 0, lines: 0..0, period, lands };
        };
        let middle = f64::midpoint(start[0], end[1]) / line_m;
        let first = (middle - 0.5 * (count * period) as f64).round() as isize;
        let is_cut = [layout.cavities_m.first() != Some(start), layout.cavities_m.last() != Some(end)];
        let from = if is_cut[0] { isize::MIN } else { first };
        let to = if is_cut[1] { isize::MAX } else { first + count * period };
        Self { first, lines: from..to, period, lands }
    }

    /// Numbers of lines of land at the first and at the last end of a strip of `lines` lines, up to the adjacent
    /// cavity; `None` at an end that cuts a cavity.
    fn walls(&self, lines: usize) -> [Option<usize>; 2] {
        let Range { start, end } = self.lines;
        let before = (start > isize::MIN).then(|| start + self.lands[0]);
        let after = (end < isize::MAX).then(|| lines as isize - end + self.lands[1]);
        // A negative number counts as no wall.
        [before, after].map(|wall| wall.and_then(|wall| usize::try_from(wall).ok()))
    }

    /// Returns the line of the cell to which `line` belongs; `None` for land beyond the cells.
    fn line_of_cell(&self, line: usize) -> Option<usize> {
        let line = line as isize;
        self.lines.contains(&line).then(|| (line - self.first).rem_euclid(self.period) as usize)
    }
}

/// Number of lines in the gap that separates the ends of a strip of `lines` lines in a periodic lattice: at least one,
/// and such that Fourier transforms over the total are fast.
pub fn gap_after(lines: usize) -> usize {
    let is_quick = |mut count: usize| {
        for factor in FACTORS {
            while count.is_multiple_of(factor) {
                count /= factor;
            }
        }
        count == 1
    };
    (1..).find(|gap| is_quick(lines + gap)).unwrap_or(1)
}

/// Solves steady sliding of the strip and its flat counterpart at each load, with randomly drawn local coefficients.
///
/// # Errors
/// [`SceneError::TooLarge`] if the equations do not fit in memory.
pub fn steady_loads(scene: &Scene, strip: &SpaceStrip, monitor: &dyn Monitor) -> Result<Vec<LoadOutcome>, SceneError> {
    require_memory(strip.lattices.iter().map(steady_bytes).sum())?;
    let solved: Vec<Vec<SurfaceOutcome>> =
        strip.lattices.par_iter().map(|lattice| solve(scene, lattice, strip.direction, monitor)).collect();
    let [own, flat] = <[_; 2]>::try_from(solved).unwrap_or_default();
    let each = scene.loads.iter().zip(own.into_iter().zip(flat)).map(|(load, (mut own, mut flat))| {
        strip.to_pattern_axes(&mut own);
        strip.to_pattern_axes(&mut flat);
        compare(load, own, Some(flat))
    });
    Ok(each.collect())
}

fn steady_bytes(lattice: &SpaceLattice) -> f64 {
    let [nx, ny] = lattice.columns();
    (nx * ny * (lattice.rows() + 1)) as f64 * BYTES_PER_BLOCK
}

/// Solves steady sliding on `lattice` along the unit vector `direction` at each load, with randomly drawn local
/// coefficients.
fn solve(scene: &Scene, lattice: &SpaceLattice, direction: [f64; 2], monitor: &dyn Monitor) -> Vec<SurfaceOutcome> {
    let [nx, ny] = lattice.columns();
    let drawn = scene.loads.iter().map(|load| steady_coefficients(scene, load, nx * ny)).collect();
    solve_drawn(scene, &SpaceSteadyModel::for_scene(scene, lattice.clone()), direction, drawn, monitor)
}

#[cfg(test)]
mod tests {
    use crate::material::{Elastic, LocalFriction};
    use crate::pattern::{Planform, Texture};

    use super::*;
    use crate::springblock::Unwatched;
    use crate::springblock::outcome::{Effect, InterfacePoint, Status};
    use crate::springblock::simulate::simulate;
    use crate::springblock::tests::samples;
    use crate::springblock::{Extent, Fidelity, Layer, RunOptions};

    fn scene(pattern: Pattern, dimensions: u8, fidelity: Fidelity) -> Scene {
        let run = RunOptions {
            fidelity,
            extent: if dimensions == 3 { Extent::Strip } else { Extent::Sample },
            dimensions: Some(dimensions),
            ..RunOptions::default()
        };
        let scene = samples::scene(pattern, &[0.65, 2.6], run);
        Scene { layer: Layer { length_m: 960e-6, height_m: 60e-6, ..scene.layer }, ..scene }
    }

    /// Plane strain at nu = 1/4 is plane stress at 1/3 with other moduli, on which steady ratios do not depend.
    #[test]
    fn a_strip_of_grooves_slides_steadily_as_it_does_in_the_plane() {
        let pattern = samples::groove(60.0, 90.0, 20.0);
        let [space, plane] =
            [3, 2].map(|dimensions| simulate(&scene(pattern, dimensions, Fidelity::Steady), &Unwatched).unwrap());
        for (space, plane) in space.loads.iter().zip(&plane.loads) {
            assert_eq!(space.surface.status, Status::Converged);
            let [own, plane_ratio] = [space, plane].map(|load| load.ratio().unwrap());
            assert!((own - plane_ratio).abs() < 1e-8, "{own} {plane_ratio}");
            for (own, plane) in surfaces(space).zip(surfaces(plane)) {
                assert!((own.mu_dynamic.unwrap() - plane.mu_dynamic.unwrap()).abs() < 1e-9);
                assert!((own.peak_pressure_pa / plane.peak_pressure_pa - 1.0).abs() < 1e-6);
                assert_eq!(own.interface.len(), plane.interface.len());
                for (own, plane) in own.interface.iter().zip(&plane.interface) {
                    assert!((own.x_m - plane.x_m).abs() < 1e-12, "{} {}", own.x_m, plane.x_m);
                    let apart_pa = (own.pressure_pa - plane.pressure_pa).abs();
                    assert!(apart_pa < 1e-5 * plane.pressure_pa && apart_pa < 1e-7 * space.pressure_pa, "{apart_pa}");
                }
            }
        }
        assert!(samples::says(&space, "strip: 96 columns"));
    }

    /// Outcomes with cavities and flat.
    fn surfaces(load: &LoadOutcome) -> impl Iterator<Item = &SurfaceOutcome> {
        std::iter::once(&load.surface).chain(&load.flat)
    }

    /// C11 is 6/5 E in space and 9/8 E in the plane.
    #[test]
    fn a_strip_of_grooves_in_time_is_that_of_the_plane() {
        let pattern = samples::groove(60.0, 90.0, 20.0);
        let run = |dimensions: u8, warm_start: bool| {
            let mut scene = scene(pattern, dimensions, Fidelity::Dynamic);
            scene.run.warm_start = warm_start;
            scene.run.sliding_m = 0.2e-6;
            scene.layer.length_m = 480e-6;
            scene.loads.remove(0);
            scene.run.step_s = Some(4e-9);
            if dimensions == 2 {
                scene.elastic = Elastic::new(samples::E_PA * 1.2 / 1.125, 900.0).unwrap();
                // The damping rate in 1/s is the same.
                scene.run.damping *= (1.125_f64 / 1.2).sqrt();
            }
            simulate(&scene, &Unwatched).unwrap().loads
        };
        // From rest the steps are the same throughout; deviations from sliding are in single precision, with other
        // rounding.
        for (space, plane) in run(3, false).iter().zip(&run(2, false)) {
            for (own, plane) in surfaces(space).zip(surfaces(plane)) {
                assert_eq!(own.status, plane.status);
                // In space the effect of the draw is removed from mu.
                let mu = |surface: &SurfaceOutcome| {
                    let sum = |of: fn(&InterfacePoint) -> f64| surface.interface.iter().map(of).sum::<f64>();
                    sum(|point| point.friction_pa) / sum(|point| point.pressure_pa)
                };
                assert!((own.mu_static.unwrap() - plane.mu_static.unwrap()).abs() < 1e-9 && mu(own) > 0.1);
                assert!((mu(own) - mu(plane)).abs() < 1e-9, "{} {}", mu(own), mu(plane));
                assert!((own.peak_pressure_pa / plane.peak_pressure_pa - 1.0).abs() < 1e-6);
                assert!(own.mu_across.unwrap().abs() < 1e-12);
            }
        }
        for (space, plane) in run(3, true).iter().zip(&run(2, true)) {
            for (own, plane) in space.flat.iter().zip(&plane.flat) {
                let apart = (own.mu_dynamic.unwrap() - plane.mu_dynamic.unwrap()).abs();
                let stderr = own.mu_dynamic_stderr.unwrap().hypot(plane.mu_dynamic_stderr.unwrap());
                assert!(apart < 3.0 * stderr && stderr < 2e-3, "{apart} {stderr}");
            }
        }
    }

    #[test]
    fn a_strip_along_rows_and_one_across_them_are_their_own_patterns_turned() {
        for fidelity in [Fidelity::Steady, Fidelity::Dynamic] {
            let loads = [0.0, 90.0].map(|angle_deg| {
                let texture = Texture::new(Planform::Square).with_sliding_angle_deg(angle_deg).unwrap();
                let mut scene = scene(samples::pattern(texture, 60.0, 60.0, 20.0), 3, fidelity);
                scene.run.warm_start = true;
                scene.run.sliding_m = 0.1e-6;
                scene.layer.length_m = 480e-6;
                scene.loads.remove(0);
                scene.loads.iter_mut().for_each(|load| load.friction = LocalFriction::new(0.3, 0.27, 0.02).unwrap());
                simulate(&scene, &Unwatched).unwrap().loads
            });
            for (along, across) in loads[0].iter().zip(&loads[1]) {
                assert_eq!(along.surface.status, Status::Converged);
                assert_eq!(along.ratio(), across.ratio());
                assert_eq!(along.surface.mu_across, across.surface.mu_across.map(|mu| -mu));
                let length = along.surface.interface.iter().map(|point| point.x_m).fold(0.0, f64::max);
                assert!((length - 475e-6).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn a_pattern_that_slides_aslant_has_no_strip() {
        let texture = Texture::new(Planform::Square).with_sliding_angle_deg(30.0).unwrap();
        let aslant = scene(samples::pattern(texture, 60.0, 60.0, 20.0), 3, Fidelity::Steady);
        let error = simulate(&aslant, &Unwatched).unwrap_err();
        assert!(error.to_string().contains("aslant"), "{error}");
    }

    #[test]
    fn time_adds_to_a_strip_what_it_adds_to_a_cell_and_what_is_drawn_moves_neither() {
        let mut scene = scene(samples::pattern(Planform::Square, 60.0, 60.0, 20.0), 3, Fidelity::Dynamic);
        scene.run.warm_start = true;
        scene.run.sliding_m = 0.1e-6;
        let strip = simulate(&scene, &Unwatched).unwrap().loads;
        scene.run.extent = Extent::Cell;
        let cell = |seed: u64| {
            let scene = Scene { run: RunOptions { seed, draws: 2, ..scene.run }, ..scene.clone() };
            simulate(&scene, &Unwatched).unwrap().loads
        };
        let cells = [1, 11, 21, 31].map(cell);
        let steady = crate::springblock::cell::SteadyCell::new(&scene).ratios(&scene.pattern.unwrap());
        for (place, strip) in strip.iter().enumerate() {
            let added = strip.correction(Effect::Time).unwrap().change;
            for cell in cells.iter().map(|loads| &loads[place]) {
                // The change by time is relative to the steady ratio of mean coefficients, for any draw.
                let own = cell.correction(Effect::Time).unwrap().change;
                assert!((cell.ratio().unwrap() - steady[place].unwrap() - own).abs() < 1e-9, "{cell:?}");
                let open = cell.ratio_stderr.unwrap().hypot(strip.ratio_stderr.unwrap());
                assert!((own - added).abs() < 3.0 * open && open < 3e-3, "{own} {added} {open}");
            }
        }
    }

    #[test]
    fn of_a_laid_strip_slender_walls_and_short_strips_are_taken_as_they_are() {
        let scene = scene(samples::pattern(Planform::Square, 60.0, 60.0, 20.0), 3, Fidelity::Steady);
        let pattern = scene.pattern.unwrap();
        let cell = SpaceLattice::cell(&pattern, 10e-6, 6);
        let layout = |lines: usize, cavities_um: &[[f64; 2]]| {
            let cavities_m = cavities_um.iter().map(|ends| ends.map(|at| at * 1e-6)).collect();
            let length_m = lines as f64 * 10e-6;
            let strip = Strip { band: 0, width_m: 1e-3, length_m, cavities_m };
            let scene = Scene { layer: Layer { length_m, ..scene.layer }, ..scene.clone() };
            let found = SpaceStrip::new(&scene, &pattern, &cell, Some(&strip));
            let lattice = &found.lattices[0];
            // Lines with cavities.
            let lines: Vec<usize> = (0..lines).filter(|j| (0..12).any(|i| lattice.is_cavity(i, *j))).collect();
            (lines, found.relative_cavity_share)
        };
        let whole = |from: usize, to: usize| (from..to).collect::<Vec<usize>>();
        // Margins of 50 and 70 um.
        let (lines, relative_cavity_share) = layout(30, &[[50.0, 110.0], [170.0, 230.0]]);
        assert_eq!(lines, [whole(5, 11), whole(17, 23)].concat());
        assert!((relative_cavity_share - 24.0 / 30.0).abs() < 1e-12);
        // A wall of one block in front of a cavity two blocks deep is removed, at either end.
        assert_eq!(layout(30, &[[10.0, 70.0], [130.0, 190.0]]).0, [whole(0, 7), whole(13, 19)].concat());
        assert_eq!(layout(20, &[[10.0, 70.0], [130.0, 190.0]]).0, [whole(0, 7), whole(13, 20)].concat());
        // The border cuts the first cavity; a strip of two blocks has nothing between its ends.
        assert_eq!(
            layout(30, &[[0.0, 30.0], [90.0, 150.0], [210.0, 270.0]]).0,
            [whole(0, 3), whole(9, 15), whole(21, 27)].concat()
        );
        assert_eq!(layout(2, &[[10.0, 20.0]]), (whole(0, 2), 2.0));
        assert_eq!(layout(5, &[]), (Vec::new(), 0.0));
    }

    #[test]
    fn lines_are_cut_away_up_to_a_number_that_transforms_are_quick_with() {
        assert_eq!([47, 299, 300, 996, 1007, 1].map(gap_after), [1, 1, 8, 4, 1, 1]);
    }
}
