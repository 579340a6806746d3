//! Damped Gauss-Newton steps (Levenberg, Q. Appl. Math. 2, 164, 1944; Marquardt, J. SIAM 11, 431,
//! 1963) with Broyden's update of the Jacobian (Math. Comput. 19, 577, 1965).
//!
//! The misfit is a sum of squares of a few residuals r over at most three shares t. Where the target
//! can be reached, a handful of evaluations does what takes the simplex method fifty:
//!
//!   (J' J + lambda max diag(J' J) I) s = -J' r,   J += (r(t + s) - r(t) - J s) s' / (s' s).
//!
//! The scaled identity keeps steps short in directions that change little, so that different starts
//! end at different designs where many meet the target. Bounds: a share that would leave [0, 1]
//! stops at its bound and the others are solved again. A limited quantity with the relative excess e
//! is the constraint c = ln(1 + e) <= 0: a step that would break constraints to first order is solved
//! again with c + c' s = 0 for each of them as one more, heavily weighted residual.
//!
//! The largest residual is brought down by the same steps, with weights that Lawson's algorithm finds (C. L. Lawson, thesis,
//! UCLA 1961): w_i |r_i + J_i s| takes the place of w_i until the largest of these no longer falls.

use crate::Limit;
use crate::evaluation_archive::LocalArchive;
use crate::local_search::{Cost, Objective};
use crate::low_discrepancy::MOST_DIMENSIONS;
use crate::space::Grid;
use slipgrid_pattern::Pattern;

/// Step of the first difference quotients, as a share of the bounds. Wide enough that a model's
/// noise of 1e-4 of a ratio does not matter, narrow enough that its curvature hardly does.
const DIFFERENCE: f64 = 0.04;
/// Longest step in one share: the difference quotients hold no further.
const LONGEST_STEP: f64 = 0.3;
/// First damping, and its factors after a step that lowered the misfit and one that did not.
const FIRST_DAMPING: f64 = 1e-3;
const DAMPING_DECREASE: f64 = 0.2;
const DAMPING_INCREASE: f64 = 8.0;
/// Steps tried from one start, and vain ones in a row, before the simplex method takes over.
const MOST_STEPS: usize = 15;
const MOST_VAIN_STEPS: usize = 3;
/// A step that lowers the misfit by less than this share is vain.
const WORTHWHILE_GAIN: f64 = 0.02;

/// Weight of the constraint as a residual, over the largest slope of the misfit. Larger loses digits
/// in the normal equations, smaller leaves the constraint broken by more.
const CONSTRAINT_WEIGHT: f64 = 1e3;
/// The constraint is aimed at from within by this much, so that rounding to the grid stays feasible.
const CONSTRAINT_MARGIN: f64 = 5e-4;

/// The same of the largest residual, which begins near its least value and has kinks there.
const FIRST_DAMPING_OF_LARGEST: f64 = 0.3;
const MOST_STEPS_OF_LARGEST: usize = 30;
const WORTHWHILE_GAIN_OF_LARGEST: f64 = 0.002;
/// Rounds in which weights are found; no model is asked.
const MOST_WEIGHTINGS: usize = 100;

/// Least 1 + e, so that a constraint far from binding has a logarithm.
const FAR_WITHIN: f64 = 1e-6;

pub(crate) type Vector = [f64; MOST_DIMENSIONS];

/// A design, its shares, its residuals in tolerances, and the constraints as the last entries of `residuals`.
pub(crate) struct Point {
    pub(crate) design: Pattern,
    pub(crate) t: Vector,
    residuals: Vec<f64>,
    pub(crate) constraints: usize,
    pub(crate) cost: f64,
}

impl Point {
    /// The goal, where that is the only residual.
    pub(crate) fn goal(&self) -> f64 {
        self.residuals[0]
    }

    /// Residuals, then constraints.
    pub(crate) fn split(&self) -> (&[f64], &[f64]) {
        self.residuals.split_at(self.residuals.len() - self.constraints)
    }
}

/// Steps from `start` towards the target while they gain. Returns the best design, or `None`
/// where `start` or its neighbours have no response or the local archive was interrupted before they had.
pub(crate) fn descend(grid: &Grid, start: &Pattern, cost: &Cost, local: &mut LocalArchive<'_>) -> Option<Pattern> {
    let free = grid.free_axes();
    let mut here = visit(grid, start, cost, local)?;
    if !free.is_empty() && here.cost > cost.comfortable() {
        let mut jacobian = difference_quotients(grid, &here, cost, &free, local)?;
        let of_largest = cost.objective == Objective::Largest;
        let (mut damping, mut vain) = (if of_largest { FIRST_DAMPING_OF_LARGEST } else { FIRST_DAMPING }, 0);
        let mut margins = vec![CONSTRAINT_MARGIN; here.constraints];
        let most_steps = if of_largest { MOST_STEPS_OF_LARGEST } else { MOST_STEPS };
        for _ in 0..most_steps {
            let Some(step) = damped_step(&jacobian, &here, &free, of_largest, damping, &margins) else { break };
            let Some(design) = grid.design(&std::array::from_fn(|axis| here.t[axis] + step[axis])) else { break };
            if design == here.design {
                break;
            }
            let next = visit(grid, &design, cost, local);
            if local.interruption.is_some() {
                break;
            }
            let gain = next.as_ref().map_or(0.0, |next| here.cost - next.cost);
            let worthwhile = if of_largest { WORTHWHILE_GAIN_OF_LARGEST } else { WORTHWHILE_GAIN };
            vain = if gain > worthwhile * here.cost { 0 } else { vain + 1 };
            damping *= if gain > 0.0 { DAMPING_DECREASE } else { DAMPING_INCREASE };
            if let Some(next) = next {
                broyden(&mut jacobian, &here, &next);
                // A constraint broken by its curvature is aimed at from further within the next time.
                margins = next.split().1.iter().map(|constraint| CONSTRAINT_MARGIN + constraint.max(0.0)).collect();
                if gain > 0.0 {
                    here = next;
                }
            }
            if here.cost <= cost.comfortable() || vain >= MOST_VAIN_STEPS {
                break;
            }
        }
    }
    Some(here.design)
}

/// The point at `design`; `None` where it has no response or may not be evaluated.
pub(crate) fn visit(grid: &Grid, design: &Pattern, cost: &Cost, local: &mut LocalArchive<'_>) -> Option<Point> {
    let (target, limits) = (local.target(), &local.constraints().quantities);
    let candidate = local.look(design)?.candidate()?;
    // c = ln(1 + e): of a largest allowed value ln(value / limit)
    let constraint = |(limit, value): (&Limit, &f64)| (1.0 + limit.excess(*value)).max(FAR_WITHIN).ln();
    let limited = limits.iter().zip(&candidate.response.limited).map(constraint);
    let (mut residuals, edges) = match target.residuals(&candidate.response.value) {
        Some(residuals) => (residuals, Vec::new()),
        // A goal, and the edges of what is accepted.
        None => (vec![target.goal_cost(&candidate.response.value)?], target.edges(&candidate.response.value)),
    };
    residuals.extend(limited.chain(edges.iter().copied()));
    let (t, cost) = (grid.shares(design), cost.of(candidate));
    Some(Point { design: *design, t, residuals, constraints: limits.len() + edges.len(), cost })
}

/// dr_i/dt_j by one-sided differences inwards, one row per residual; `None` where a neighbour has no
/// response on either side.
pub(crate) fn difference_quotients(
    grid: &Grid,
    here: &Point,
    cost: &Cost,
    free: &[usize],
    local: &mut LocalArchive<'_>,
) -> Option<Vec<Vector>> {
    let mut jacobian = vec![[0.0; MOST_DIMENSIONS]; here.residuals.len()];
    for &axis in free {
        let inwards = if here.t[axis] <= 0.5 { DIFFERENCE } else { -DIFFERENCE };
        let neighbour = [inwards, -inwards].into_iter().find_map(|difference| {
            // On a coarse grid the neighbour is some differences away.
            let mut t = here.t;
            for _ in 0..((1.0 / DIFFERENCE) as usize) {
                t[axis] += difference;
                let design = grid.design(&t)?;
                if design != here.design {
                    return visit(grid, &design, cost, local);
                }
            }
            None
        })?;
        let difference = neighbour.t[axis] - here.t[axis];
        for (row, (there, here)) in jacobian.iter_mut().zip(neighbour.residuals.iter().zip(&here.residuals)) {
            row[axis] = (there - here) / difference;
        }
    }
    Some(jacobian)
}

/// The damped step within the bounds that respects the constraints to first order; `None` where no
/// share can move. The last rows of the Jacobian and the last residuals are the constraints'. With `of_largest` the step
/// that brings the largest residual down.
fn damped_step(
    jacobian: &[Vector],
    here: &Point,
    free: &[usize],
    of_largest: bool,
    damping: f64,
    margins: &[f64],
) -> Option<Vector> {
    let (residuals, constraints) = here.split();
    let (rows, constraint_rows) = jacobian.split_at(residuals.len());
    let square = |axis: usize| rows.iter().map(|row| row[axis] * row[axis]).sum::<f64>();
    let largest = free.iter().map(|&axis| square(axis)).fold(0.0, f64::max);
    if largest <= 0.0 {
        return None;
    }
    let step_of = |weights: &[f64]| {
        let weighted = |((row, residual), weight): ((&Vector, &f64), &f64)| {
            let root = weight.sqrt();
            (row.map(|slope| root * slope), root * residual)
        };
        let mut system: Vec<(Vector, f64)> = rows.iter().zip(residuals).zip(weights).map(weighted).collect();
        let limits = (constraint_rows, constraints, margins);
        constrained_step(&mut system, limits, &here.t, free, damping * largest)
    };
    let mut weights = vec![1.0; rows.len()];
    let mut step = step_of(&weights)?;
    if of_largest {
        let left = |step: &Vector| -> Vec<f64> {
            let moved = |row: &Vector| row.iter().zip(step).map(|(slope, share)| slope * share).sum::<f64>();
            rows.iter().zip(residuals).map(|(row, residual)| (residual + moved(row)).abs()).collect()
        };
        let most = |left: &[f64]| left.iter().copied().fold(0.0, f64::max);
        let mut trial = step;
        for _ in 0..MOST_WEIGHTINGS {
            let now = left(&trial);
            let sum: f64 = weights.iter().zip(&now).map(|(weight, left)| weight * left).sum();
            if sum <= 0.0 {
                break;
            }
            // Of mean 1, so that the damping keeps its size.
            let count = rows.len() as f64;
            weights.iter_mut().zip(&now).for_each(|(weight, left)| *weight *= count * left / sum);
            let Some(next) = step_of(&weights) else { break };
            if most(&left(&next)) < most(&left(&step)) {
                step = next;
            }
            trial = next;
        }
    }
    let longest = step.iter().fold(0.0_f64, |longest, share| longest.max(share.abs()));
    if longest == 0.0 {
        return None;
    }
    let scale = (LONGEST_STEP / longest).min(1.0);
    Some(step.map(|share| share * scale))
}

/// The step that solves `system` within the bounds and respects the constraints (their slopes, values and margins) to
/// first order. `None` where it is singular.
pub(crate) fn constrained_step(
    system: &mut Vec<(Vector, f64)>,
    (constraint_rows, constraints, margins): (&[Vector], &[f64], &[f64]),
    t: &Vector,
    free: &[usize],
    damping: f64,
) -> Option<Vector> {
    let square = |axis: usize| system.iter().map(|(row, _)| row[axis] * row[axis]).sum::<f64>();
    let largest = free.iter().map(|&axis| square(axis)).fold(0.0, f64::max);
    let mut step = bounded_step(system, t, free, damping)?;
    let mut aimed_at = vec![false; constraints.len()];
    // A step that spares one constraint can break another: each is added once.
    loop {
        let mut added = false;
        for (place, row) in constraint_rows.iter().enumerate() {
            let slope = row.iter().zip(&step).map(|(slope, share)| slope * share).sum::<f64>();
            if !aimed_at[place] && constraints[place] + slope > 0.0 {
                let weight = CONSTRAINT_WEIGHT * largest.sqrt();
                system.push((row.map(|slope| weight * slope), weight * (constraints[place] + margins[place])));
                (aimed_at[place], added) = (true, true);
            }
        }
        if !added {
            return Some(step);
        }
        step = bounded_step(system, t, free, damping)?;
    }
}

/// Solves (J' J + damping I) s = -J' r, `system` holding the rows of J with their r, for the shares
/// that can move; those that would leave [0, 1] stop at their bound. `None` where it is singular.
fn bounded_step(system: &[(Vector, f64)], t: &Vector, free: &[usize], damping: f64) -> Option<Vector> {
    let mut moving = free.to_vec();
    let mut step = [0.0; MOST_DIMENSIONS];
    while !moving.is_empty() {
        // (J' J + lambda I) s = -J' (r + J s_stopped)
        let mut matrix = [[0.0; MOST_DIMENSIONS + 1]; MOST_DIMENSIONS];
        for (row, residual) in system {
            let stopped: f64 = row.iter().zip(&step).map(|(slope, share)| slope * share).sum();
            for (i, &axis) in moving.iter().enumerate() {
                for (j, &other) in moving.iter().enumerate() {
                    matrix[i][j] += row[axis] * row[other];
                }
                matrix[i][MOST_DIMENSIONS] -= row[axis] * (residual + stopped);
            }
        }
        for (i, row) in matrix.iter_mut().enumerate() {
            row[i] += damping;
        }
        let solution = solve(&mut matrix, moving.len())?;
        // The share that would leave the bounds furthest stops there.
        let beyond = |share: f64| (share - 1.0).max(-share).max(0.0);
        let furthest = (0..moving.len())
            .map(|i| (i, beyond(t[moving[i]] + solution[i])))
            .fold((0, 0.0), |most, next| if next.1 > most.1 { next } else { most });
        if furthest.1 == 0.0 {
            for (i, &axis) in moving.iter().enumerate() {
                step[axis] = solution[i];
            }
            break;
        }
        let axis = moving.remove(furthest.0);
        step[axis] = (t[axis] + solution[furthest.0]).clamp(0.0, 1.0) - t[axis];
    }
    Some(step)
}

/// Broyden's update: the least change of the Jacobian that explains the step from `here` to `next`.
pub(crate) fn broyden(jacobian: &mut [Vector], here: &Point, next: &Point) {
    let step: Vector = std::array::from_fn(|axis| next.t[axis] - here.t[axis]);
    let square: f64 = step.iter().map(|share| share * share).sum();
    if square == 0.0 {
        return;
    }
    for (row, (there, here)) in jacobian.iter_mut().zip(next.residuals.iter().zip(&here.residuals)) {
        let predicted: f64 = row.iter().zip(&step).map(|(slope, share)| slope * share).sum();
        let unexplained = there - here - predicted;
        for (slope, share) in row.iter_mut().zip(&step) {
            *slope += unexplained * share / square;
        }
    }
}

/// Gaussian elimination of the leading `n` rows and columns, symmetric and positive definite; the
/// right-hand side is the last column. `None` where a pivot vanishes.
fn solve(matrix: &mut [[f64; MOST_DIMENSIONS + 1]; MOST_DIMENSIONS], n: usize) -> Option<Vector> {
    for pivot in 0..n {
        let pivot_row = matrix[pivot];
        if !(pivot_row[pivot].is_finite() && pivot_row[pivot] > 0.0) {
            return None;
        }
        for row in matrix.iter_mut().take(n).skip(pivot + 1) {
            let factor = row[pivot] / pivot_row[pivot];
            for (entry, above) in row.iter_mut().zip(pivot_row) {
                *entry -= factor * above;
            }
        }
    }
    let mut solution = [0.0; MOST_DIMENSIONS];
    for i in (0..n).rev() {
        let known: f64 = (i + 1..n).map(|j| matrix[i][j] * solution[j]).sum();
        solution[i] = (matrix[i][MOST_DIMENSIONS] - known) / matrix[i][i];
    }
    Some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(t: Vector, residuals: Vec<f64>, constraints: usize) -> Point {
        let design = Pattern::new(slipgrid_pattern::Planform::Groove, 1e-4, 1e-4, 1e-5).unwrap();
        Point { design, t, residuals, constraints, cost: 1.0 }
    }

    const LINEAR: [Vector; 4] = [[4.0, 1.0, 0.0], [1.0, 3.0, -1.0], [0.0, -1.0, 2.0], [0.5, 0.5, 0.5]];

    /// r = A (t - root)
    fn residuals(t: Vector, root: Vector) -> Vec<f64> {
        LINEAR.iter().map(|row| (0..3).map(|axis| row[axis] * (t[axis] - root[axis])).sum()).collect()
    }

    fn undamped_end(start: Vector, root: Vector) -> Vector {
        let system: Vec<_> = LINEAR.into_iter().zip(residuals(start, root)).collect();
        let step = bounded_step(&system, &start, &[0, 1, 2], 0.0).unwrap();
        std::array::from_fn(|axis| start[axis] + step[axis])
    }

    #[test]
    fn one_undamped_step_solves_linear_residuals() {
        let root = [0.2, 0.4, 0.6];
        for (end, root) in undamped_end([0.3, 0.3, 0.5], root).into_iter().zip(root) {
            assert!((end - root).abs() < 1e-12);
        }
    }

    #[test]
    fn a_share_stops_at_its_bound_and_the_others_are_optimal_there() {
        let root = [-0.1, 0.4, 0.6];
        let end = undamped_end([0.1, 0.5, 0.5], root);
        assert_eq!(end[0], 0.0);
        // The gradient J' r vanishes along the shares that could move.
        let left = residuals(end, root);
        for axis in 1..3 {
            let gradient: f64 = LINEAR.iter().zip(&left).map(|(row, r)| row[axis] * r).sum();
            assert!(gradient.abs() < 1e-12, "{gradient}");
        }
    }

    #[test]
    fn a_binding_constraint_projects_the_step() {
        // r = t - (0.6, 0.6, 0.3), c = t_1 + t_2 - 1 <= 0, from the middle: nearest allowed (0.5, 0.5, 0.3).
        let rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 0.0]];
        let here = point([0.4, 0.5, 0.5], vec![-0.2, -0.1, 0.2, -0.1], 1);
        let step = damped_step(&rows, &here, &[0, 1, 2], false, 0.0, &[CONSTRAINT_MARGIN]).unwrap();
        for (axis, expected) in [(0, 0.5), (1, 0.5), (2, 0.3)] {
            assert!((here.t[axis] + step[axis] - expected).abs() < CONSTRAINT_MARGIN, "{step:?}");
        }
        assert!(step[0] + step[1] < 0.1, "from within");
    }

    #[test]
    fn two_binding_constraints_meet_in_their_corner() {
        // r = t - (0.9, 0.9, 0.3), t_1 <= 0.6 and t_2 <= 0.7, both to be seen.
        let rows = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let here = point([0.4, 0.5, 0.5], vec![-0.5, -0.4, 0.2, -0.2, -0.2], 2);
        let step = damped_step(&rows, &here, &[0, 1, 2], false, 0.0, &[CONSTRAINT_MARGIN; 2]).unwrap();
        for (axis, expected) in [(0, 0.6), (1, 0.7), (2, 0.3)] {
            assert!((here.t[axis] + step[axis] - expected).abs() <= 1.01 * CONSTRAINT_MARGIN, "{step:?}");
        }
    }

    #[test]
    fn broyden_learns_a_linear_map_from_three_steps_at_right_angles() {
        let root = [0.2, 0.4, 0.6];
        let mut jacobian = vec![[0.0; 3]; 4];
        for step in [[0.1, 0.0, 0.0], [0.0, 0.2, 0.1], [0.0, -0.1, 0.2]] {
            let at = |t| point(t, residuals(t, root), 0);
            broyden(&mut jacobian, &at([0.0; 3]), &at(step));
        }
        for (learnt, row) in jacobian.iter().flatten().zip(LINEAR.iter().flatten()) {
            assert!((learnt - row).abs() < 1e-12);
        }
    }
}
