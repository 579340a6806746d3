//! Distribution of the load over the parts of a face of an elastic specimen.
//!
//! Under a bulk that is rigid directly above the layer, the solid margin of a specimen carries far more than its softer
//! cavities. A specimen several millimetres thick also deforms above the margin, which evens out the pressure. A strip
//! of the face is cut in the middle of its first and its last cavity into pieces that are periodic if mirrored at their
//! sides. The middle piece has cavities of width w and lands of width g. An end piece with a margin of width m is half
//! a cell with cavity w and land 2 m; if the strip's end cuts a cavity to the width v, the end piece is half a cell
//! with cavity 2 v and land g. The excess compliance of each piece compared with solid is
//!
//! ```text
//! C = E (1/k_cell - 1/k_solid),     k: mean pressure over descent of the bulk
//! ```
//!
//! The pressure p(x) is that under an elastic body of the specimen's thickness on the foundation C(x) ([`body`]). The
//! ratio r of the face, with the strips s of width w_s, the area A and the nominal pressure P, follows from the
//! friction of steady cells at their local pressure,
//!
//! ```text
//! r = sum_s w_s int p mu_cell(p) dx / (P mu_flat(P) A)
//! ```
//!
//! For the layer alone, with a rigid bulk, the pressure is more uneven. The difference between the two ratios is added
//! to the ratio of strips of the layer.

pub mod body;

use std::collections::{BTreeMap, BTreeSet};

use crate::material::AreaLaw;
use crate::pattern::{Pattern, Planform};
use rayon::prelude::*;

use super::specimen::without_slivers;
use crate::springblock::steady::CondensedModel;
use crate::springblock::{
    CellOutcome, Dimension, Face, Lattice, Load, Monitor, Scene, SteadyCell, SteadyModel, Strip, columns,
};
use body::{FacePressure, Foundation, face_pressure};

/// Relative standard error of the change of the friction ratio by load sharing
/// (`strips_share_the_load_as_all_blocks_of_the_specimen_say`).
pub const RELATIVE_ERROR: f64 = 0.15;
/// Maximum step of the logarithm of the pressure between cells that are solved.
const PRESSURE_STEP: f64 = 0.7;
/// Number of pressures in each such step at which friction follows from the local pressures of the cells at its ends;
/// between them it is interpolated linearly.
const FINE: usize = 12;
/// Minimum pressure, in units of the nominal pressure, at which cells are solved; parts under less have the same
/// coefficient.
const MIN_PRESSURE: f64 = 0.1;
/// Cells in space are solved until the residual force over the load is this small.
const BALANCE: f64 = 1e-6;
/// Excess compliance C of solid pieces, as a fraction of the height of the body; exactly it would be zero.
pub const SOLID_COMPLIANCE: f64 = 1e-4;
/// Maximum number of columns and minimum number of rows of the cells that determine compliances of a thick specimen.
/// Such a cell is at least as high as its period is long.
const COMPLIANCE_COLUMNS: f64 = 24.0;
/// Unit of [`CellWidths`], in metres: widths of cavities and lands that differ by less count as equal.
const WIDTH_UNIT_M: f64 = 1e-8;

/// Widths of the cavity and of the land of a cell, in this order, in units of [`WIDTH_UNIT_M`].
type CellWidths = (u64, u64);
/// Key of solid parts, in a strip without cavities.
const SOLID: CellWidths = (0, 0);

/// Part of a strip that is periodic if mirrored at its sides.
struct Piece {
    widths: CellWidths,
    length_m: f64,
}

fn widths(cavity_m: f64, land_m: f64) -> CellWidths {
    let units = |length_m: f64| (length_m / WIDTH_UNIT_M).round() as u64;
    (units(cavity_m), units(land_m))
}

/// A strip of the face, cut into pieces from left to right; there are no pieces if the strip has no cavity.
struct CutStrip {
    pieces: Vec<Piece>,
    width_m: f64,
    length_m: f64,
}

/// Cuts `strip` into pieces, from left to right; empty if the strip has no cavity.
fn pieces(strip: &Strip) -> Vec<Piece> {
    let cavities = &strip.cavities_m;
    let (Some(first), Some(last)) = (cavities.first(), cavities.last()) else { return Vec::new() };
    let mut pieces = Vec::new();
    let mut push = |length_m: f64, cavity_m: f64, land_m: f64| {
        if length_m > WIDTH_UNIT_M {
            pieces.push(Piece { widths: widths(cavity_m, land_m), length_m });
        }
    };
    let margins = [first[0], strip.length_m - last[1]];
    if let [[start_m, end_m]] = cavities[..] {
        let width_m = end_m - start_m;
        match margins.map(|margin_m| margin_m > WIDTH_UNIT_M) {
            [true, true] => margins.iter().for_each(|margin_m| push(margin_m + 0.5 * width_m, width_m, 2.0 * margin_m)),
            // Half a cell of twice the cavity and twice the land.
            _ => push(strip.length_m, 2.0 * width_m, 2.0 * (margins[0] + margins[1])),
        }
        return pieces;
    }
    let land_m = cavities[1][0] - first[1];
    let width_m = cavities.iter().map(|[start_m, end_m]| end_m - start_m).fold(0.0, f64::max);
    let end = |[start_m, end_m]: [f64; 2], margin_m: f64| {
        let own_m = end_m - start_m;
        if margin_m > WIDTH_UNIT_M {
            (margin_m + 0.5 * own_m, own_m, 2.0 * margin_m)
        } else {
            (own_m + 0.5 * land_m, 2.0 * own_m, land_m)
        }
    };
    let (left, right) = (end(*first, margins[0]), end(*last, margins[1]));
    push(left.0, left.1, left.2);
    push(strip.length_m - left.0 - right.0, width_m, land_m);
    push(right.0, right.1, right.2);
    pieces
}

/// Excess compliance C of the face of `scene` with cavities of `pattern`, compared with a solid face and seen from far
/// above the cavities: compliance times Young's modulus, in metres; `None` if no lattice can have such cavities.
pub fn excess_compliance_m(scene: &Scene, pattern: &Pattern) -> Option<f64> {
    let groove = pattern.as_groove();
    let soft = Cell::new(scene, widths(groove.width_m(), groove.spacing_m()), groove.depth_m())?;
    // For other planforms scale by the area fraction.
    Some(soft.compliance_m[1] * pattern.areal_density() / groove.areal_density())
}

/// A groove with given widths of cavity and land, with its compliances.
struct Cell {
    pattern: Pattern,
    /// Excess compliance C (compliance times Young's modulus), in metres: in the layer alone, and in the whole
    /// specimen.
    compliance_m: [f64; 2],
}

impl Cell {
    /// `None` if no lattice can have such cavities.
    fn new(scene: &Scene, widths: CellWidths, depth_m: f64) -> Option<Self> {
        let [width_m, land_m] = [widths.0, widths.1].map(|units| units as f64 * WIDTH_UNIT_M);
        let pattern = Pattern::new(Planform::Groove, width_m, land_m, depth_m).ok()?;
        let layer = scene.layer;
        // The cell is one period high, so that its top is far above the cavities, with some dozens of blocks per
        // period.
        let block_m = layer.block_m.max(pattern.pitch_m() / COMPLIANCE_COLUMNS);
        let rows = (pattern.pitch_m().max(2.0 * depth_m) / block_m).ceil().max(COMPLIANCE_COLUMNS);
        let compliance_m =
            [compliance_m(&pattern, layer.block_m, layer.rows())?, compliance_m(&pattern, block_m, rows as usize)?];
        Some(Self { pattern, compliance_m })
    }
}

/// Excess compliance C, in metres, of the cell of `pattern` with `rows` rows of blocks of `block_m`; `None` if the rows
/// cannot hold the cavity or C is not positive.
fn compliance_m(pattern: &Pattern, block_m: f64, rows: usize) -> Option<f64> {
    let height_m = rows as f64 * block_m;
    if pattern.depth_m() >= height_m - block_m {
        return None;
    }
    let stiffness = |columns| {
        let lattice = Lattice::new(columns, rows, true);
        let condensed = CondensedModel::new(&lattice, block_m, 1.0, false);
        let of_blocks = || SteadyModel::new(lattice, block_m, 1.0, false).stiffness_per_length();
        condensed.map_or_else(of_blocks, |model| model.stiffness_per_length())
    };
    let solid_over_own = stiffness(columns::flat(super::UNIFORM_COLUMNS)) / stiffness(columns::cell(pattern, block_m));
    // A solid without strain along the face: E / k = (1 - nu^2) H
    let compliance_m = 8.0 / 9.0 * height_m * (solid_over_own - 1.0);
    (compliance_m.is_finite() && compliance_m > 0.0).then_some(compliance_m)
}

/// Part of the face with a uniform pressure, stated relative to the nominal pressure.
pub struct LoadShare {
    widths: CellWidths,
    area_m2: f64,
    pressure: f64,
}

impl LoadShare {
    /// Creates a part of `area_m2` without cavities, under `pressure` times the nominal pressure.
    pub const fn solid(area_m2: f64, pressure: f64) -> Self {
        Self { widths: SOLID, area_m2, pressure }
    }

    #[cfg(test)]
    pub const fn area_m2(&self) -> f64 {
        self.area_m2
    }

    /// Force on the part, in newtons under a nominal pressure of 1 Pa.
    #[cfg(test)]
    pub const fn force(&self) -> f64 {
        self.area_m2 * self.pressure
    }
}

/// Ratio of `face` with flat lands and cavities of `pattern` on a specimen of the scene's thickness, minus the ratio of
/// the layer alone under one rigid bulk, at each load. A load is `None` if a cell has no ratio. Returns `None` if the
/// computation failed or `monitor` has cancelled.
pub fn difference(scene: &Scene, pattern: &Pattern, face: &Face, monitor: &dyn Monitor) -> Option<Vec<Option<f64>>> {
    let (depth_m, block_m) = (pattern.depth_m(), scene.layer.block_m);
    let cut = |strip: &Strip| {
        let pieces = pieces(&without_slivers(strip.clone(), depth_m, block_m));
        CutStrip { pieces, width_m: strip.width_m, length_m: strip.length_m }
    };
    let strips: Vec<CutStrip> = face.strips().iter().map(cut).collect();
    let all_widths: BTreeSet<CellWidths> =
        strips.iter().flat_map(|strip| &strip.pieces).map(|piece| piece.widths).collect();
    let solved: Option<Vec<(CellWidths, Cell)>> = all_widths
        .into_par_iter()
        .map(|widths| {
            monitor.heed().ok()?;
            Some((widths, Cell::new(scene, widths, depth_m)?))
        })
        .collect();
    let cells: BTreeMap<CellWidths, Cell> = solved?.into_iter().collect();
    let layer = Scene { layer: scene.layer.alone(), ..scene.clone() };
    let alone = friction_reduction(&layer, &cells, &load_shares(&layer, &strips, &cells)?, monitor)?;
    let thick = friction_reduction(scene, &cells, &load_shares(scene, &strips, &cells)?, monitor)?;
    // Strips only sample the face, whose exact cavity fraction is known.
    let area_m2: f64 = face.strips().iter().map(Strip::area_m2).sum();
    let cavities_m2: f64 = face.strips().iter().map(|strip| strip.cavity_length_m() * strip.width_m).sum();
    let sampled = face.cavity_share() * area_m2 / cavities_m2;
    Some(thick.iter().zip(&alone).map(|(thick, alone)| Some(-sampled * ((*thick)? - (*alone)?))).collect())
}

/// Pressures on parts of the strips under an elastic body as thick as the specimen of `scene`, or as its layer if no
/// thickness is given. One rigid back carries all strips. `None` if a strip has no solution.
fn load_shares(scene: &Scene, strips: &[CutStrip], cells: &BTreeMap<CellWidths, Cell>) -> Option<Vec<LoadShare>> {
    let (height_m, place) = scene.layer.thickness_m.map_or((scene.layer.height_m, 0), |thickness_m| (thickness_m, 1));
    let solid_m = SOLID_COMPLIANCE * height_m;
    let load_shares = |strip: &CutStrip| -> Option<Vec<LoadShare>> {
        let foundation = |piece: &Piece| Foundation {
            length_m: piece.length_m,
            compliance_m: cells.get(&piece.widths).map_or(solid_m, |cell| cell.compliance_m[place]),
        };
        let mut foundations: Vec<Foundation> = strip.pieces.iter().map(foundation).collect();
        if foundations.is_empty() {
            foundations.push(Foundation { length_m: strip.length_m, compliance_m: solid_m });
        }
        let FacePressure { patches, stiffness_per_m } = face_pressure(&foundations, height_m)?;
        let part = |patch: &body::Patch| LoadShare {
            widths: strip.pieces.get(patch.piece).map_or(SOLID, |piece| piece.widths),
            area_m2: patch.length_m * strip.width_m,
            pressure: patch.pressure * stiffness_per_m,
        };
        Some(patches.iter().map(part).collect())
    };
    let each: Option<Vec<Vec<LoadShare>>> = strips.par_iter().map(load_shares).collect();
    Some(normalized(each?.into_iter().flatten().collect()))
}

/// Scales the pressures of `parts` so that their mean over the area is 1.
pub fn normalized(mut parts: Vec<LoadShare>) -> Vec<LoadShare> {
    let area_m2: f64 = parts.iter().map(|part| part.area_m2).sum();
    let mean = parts.iter().map(|part| part.area_m2 * part.pressure).sum::<f64>() / area_m2;
    parts.iter_mut().for_each(|part| part.pressure /= mean);
    parts
}

/// Friction reduction 1 - r of the face, which consists of `parts`, at each load; a load is `None` if a cell has no
/// friction. Returns `None` once `monitor` has cancelled.
fn friction_reduction(
    scene: &Scene,
    cells: &BTreeMap<CellWidths, Cell>,
    parts: &[LoadShare],
    monitor: &dyn Monitor,
) -> Option<Vec<Option<f64>>> {
    let mut by_widths: BTreeMap<CellWidths, Vec<&LoadShare>> = BTreeMap::new();
    for part in parts {
        by_widths.entry(part.widths).or_default().push(part);
    }
    let area_m2: f64 = parts.iter().map(|part| part.area_m2).sum();
    let forces = |(widths, parts): (CellWidths, Vec<&LoadShare>)| -> Option<Vec<Option<f64>>> {
        monitor.heed().ok()?;
        let cell = cells.get(&widths).map(|cell| (&cell.pattern, Dimension::Plane));
        let friction = CellFriction::new(scene, cell, parts.iter().copied(), monitor);
        Some((0..scene.loads.len()).map(|place| friction.force(place, parts.iter().copied())).collect())
    };
    let each: Option<Vec<Vec<Option<f64>>>> = by_widths.into_par_iter().map(forces).collect();
    let each = each?;
    let at = |(place, load): (usize, &Load)| {
        let friction: f64 = each.iter().map(|forces| forces[place]).sum::<Option<f64>>()?;
        let flat = load.pressure_pa * load.flat_mu(scene.area_law.as_ref()) * area_m2;
        (flat > 0.0).then(|| 1.0 - friction / flat)
    };
    Some(scene.loads.iter().enumerate().map(at).collect())
}

/// Friction of cells of one pattern, or of solid parts, as a function of pressure.
pub struct CellFriction<'a> {
    scene: &'a Scene,
    /// Logarithm of the lowest pressure of `factors`, in pascals, and its step to the next.
    lowest: f64,
    step: f64,
    /// Least and greatest local coefficient of a load.
    coefficients: [f64; 2],
    /// Friction coefficient of cells over the local one, for each of `coefficients`; `None` if the cell has no solution.
    /// Empty for solid parts, for which it is the area factor f.
    factors: Vec<[Option<f64>; 2]>,
}

impl<'a> CellFriction<'a> {
    /// Solves cells of the pattern `cell`, or solid parts, over the range of pressures of `parts` at the loads of
    /// `scene`. Solves stop without a result when `monitor` cancels.
    ///
    /// Friction depends on the pressure itself, whatever the nominal one, and is very nearly linear in the local
    /// coefficient (`parts_rub_like_cells_under_their_pressures`).
    pub fn new<'b>(
        scene: &'a Scene,
        cell: Option<(&Pattern, Dimension)>,
        parts: impl Iterator<Item = &'b LoadShare>,
        monitor: &dyn Monitor,
    ) -> Self {
        let coefficient = |load: &&Load| load.friction.dynamic_mean();
        let order = |a: &&Load, b: &&Load| coefficient(a).total_cmp(&coefficient(b));
        let bounds = scene.loads.iter().min_by(order).zip(scene.loads.iter().max_by(order));
        let ends = |of: &mut dyn Iterator<Item = f64>| {
            of.fold([f64::INFINITY, 0.0_f64], |[least, most], at| [least.min(at), most.max(at)])
        };
        let nominal_pa = ends(&mut scene.loads.iter().map(|load| load.pressure_pa).filter(|at_pa| *at_pa > 0.0));
        let solid = Self { scene, lowest: 0.0, step: 1.0, coefficients: [0.0; 2], factors: Vec::new() };
        let asked = cell.zip(bounds).filter(|_| nominal_pa[1] > 0.0);
        let Some(((pattern, dimension), (low, high))) = asked else { return solid };
        let shares = ends(&mut parts.map(|part| part.pressure.max(MIN_PRESSURE)));
        let [lowest, highest] = [0, 1].map(|end| (shares[end] * nominal_pa[end]).ln());
        let steps = ((highest - lowest) / PRESSURE_STEP).ceil().max(1.0) as usize;
        // Not zero where all parts are under one pressure.
        let step = ((highest - lowest) / (steps * FINE) as f64).max(f64::EPSILON);
        let pressure_pa = |number: usize| (lowest + step * number as f64).exp();
        let at = |number: usize| [low, high].map(|load| Load { pressure_pa: pressure_pa(number * FINE), ..*load });
        let loads = (0..=steps).flat_map(at).collect();
        let model = SteadyCell::with_dimension(&Scene { loads, ..scene.clone() }, dimension).balanced_to(BALANCE);
        let solved = model.solve_heeding(pattern, monitor);
        let law = scene.area_law.as_ref();
        let factors = |number: usize| {
            let (before, share) = (number / FINE, (number % FINE) as f64 / FINE as f64);
            let from = |place: usize, bound: usize| {
                scaled(law, solved.get(2 * place + bound)?, pressure_pa(place * FINE), pressure_pa(number))
            };
            [0, 1].map(|bound| {
                let next = if share > 0.0 { share * from(before + 1, bound)? } else { 0.0 };
                Some((1.0 - share) * from(before, bound)? + next)
            })
        };
        let factors = (0..=steps * FINE).map(factors).collect();
        Self { lowest, step, coefficients: [coefficient(&low), coefficient(&high)], factors, ..solid }
    }

    /// Friction force of `parts` at the load with the index `place`, in newtons; `None` if a required cell has no
    /// friction.
    pub fn force<'b>(&self, place: usize, mut parts: impl Iterator<Item = &'b LoadShare>) -> Option<f64> {
        let nominal = &self.scene.loads[place];
        parts.try_fold(0.0, |sum, part| {
            let load = Load { pressure_pa: nominal.pressure_pa * part.pressure.max(0.0), ..*nominal };
            Some(sum + part.area_m2 * load.pressure_pa * load.friction.dynamic_mean() * self.factor(&load)?)
        })
    }

    /// Friction coefficient of a cell under `load` over the local one; `None` if a required cell has no friction.
    fn factor(&self, load: &Load) -> Option<f64> {
        let Some(last) = self.factors.len().checked_sub(2) else {
            return Some(self.scene.area_law.as_ref().map_or(1.0, |law| law.factor(load.pressure_pa)));
        };
        let at = ((load.pressure_pa.ln() - self.lowest) / self.step).clamp(0.0, (last + 1) as f64);
        let first = (at as usize).min(last);
        let [low, high] = self.coefficients;
        let share = if low < high { (load.friction.dynamic_mean() - low) / (high - low) } else { 0.0 };
        let [from, to] = [first, first + 1].map(|number| {
            let [low, high] = self.factors[number];
            Some(low? + share * (high? - low?))
        });
        Some(from? + (at - first as f64) * (to? - from?))
    }
}

/// Friction coefficient of the cell `solved` at `from_pa` over the local one, if its local pressures were in proportion to
/// the nominal pressure up to `to_pa`, as they very nearly are; `None` if the cell has no ratio.
fn scaled(law: Option<&AreaLaw>, solved: &CellOutcome, from_pa: f64, to_pa: f64) -> Option<f64> {
    let Some(law) = law else { return solved.ratio };
    let friction = |nominal_pa: f64| {
        let mut near = 0;
        let local_pa = solved.surface.interface.iter().map(|point| point.pressure_pa.max(0.0));
        local_pa.map(|own_pa| own_pa * law.factor_near(own_pa * nominal_pa / from_pa, &mut near)).sum::<f64>()
    };
    Some(solved.ratio? * law.factor(from_pa) * friction(to_pa) / friction(from_pa))
}

#[cfg(test)]
mod tests;
