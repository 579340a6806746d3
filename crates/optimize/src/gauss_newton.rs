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
//! stops at its bound and the others are solved again. The limit on the peak pressure p_max is the
//! constraint c = ln(p / p_max) <= 0: a step that would break it to first order is solved again with
//! c + c' s = 0 as one more, heavily weighted residual.

use crate::ledger::Notebook;
use crate::polish::Cost;
use crate::sequence::MOST_DIMENSIONS;
use crate::space::Grid;
use crate::{COMFORTABLE_RMS, TargetPoint};
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

/// The constraint where there is none: far from binding.
const UNCONSTRAINED: f64 = -1e3;

type Vector = [f64; MOST_DIMENSIONS];

/// A design, its shares, its residuals in tolerances and, as the last entry of `residuals`, the constraint.
struct Point {
    design: Pattern,
    t: Vector,
    residuals: Vec<f64>,
    cost: f64,
}

/// Steps from `start` towards the target while they gain. Returns the best design, or `None`
/// where `start` or its neighbours have no response or the notebook was interrupted before they had.
pub(crate) fn descend(grid: &Grid, start: &Pattern, cost: &Cost, notebook: &mut Notebook<'_>) -> Option<Pattern> {
    let free = grid.free_axes();
    let mut here = visit(grid, start, cost, notebook)?;
    if !free.is_empty() && here.cost > COMFORTABLE_RMS {
        let mut jacobian = difference_quotients(grid, &here, cost, &free, notebook)?;
        let (mut damping, mut vain, mut margin) = (FIRST_DAMPING, 0, CONSTRAINT_MARGIN);
        for _ in 0..MOST_STEPS {
            let Some(step) = damped_step(&jacobian, &here, &free, damping, margin) else { break };
            let Some(design) = grid.design(&std::array::from_fn(|axis| here.t[axis] + step[axis])) else { break };
            if design == here.design {
                break;
            }
            let next = visit(grid, &design, cost, notebook);
            if notebook.interruption.is_some() {
                break;
            }
            let gain = next.as_ref().map_or(0.0, |next| here.cost - next.cost);
            vain = if gain > WORTHWHILE_GAIN * here.cost { 0 } else { vain + 1 };
            damping *= if gain > 0.0 { DAMPING_DECREASE } else { DAMPING_INCREASE };
            if let Some(next) = next {
                broyden(&mut jacobian, &here, &next);
                // A constraint broken by its curvature is aimed at from further within the next time.
                margin = CONSTRAINT_MARGIN + next.residuals.last().map_or(0.0, |&constraint| constraint.max(0.0));
                if gain > 0.0 {
                    here = next;
                }
            }
            if here.cost <= COMFORTABLE_RMS || vain >= MOST_VAIN_STEPS {
                break;
            }
        }
    }
    Some(here.design)
}

/// The point at `design`; `None` where it has no response or may not be evaluated.
fn visit(grid: &Grid, design: &Pattern, cost: &Cost, notebook: &mut Notebook<'_>) -> Option<Point> {
    let (target, max_peak_pressure_pa) = (notebook.target(), notebook.max_peak_pressure_pa());
    let candidate = notebook.look(design)?.candidate()?;
    // r_i = (value_i - target_i) / tolerance
    let residual = |(point, value): (&TargetPoint, &f64)| (value - point.value) / target.tolerance();
    let mut residuals: Vec<f64> = target.points().iter().zip(&candidate.response.value).map(residual).collect();
    // c = ln(p / p_max); a peak pressure that is not positive breaks no limit.
    let constraint = max_peak_pressure_pa
        .map(|max_peak_pressure_pa| (candidate.response.peak_pressure_pa / max_peak_pressure_pa).ln())
        .filter(|constraint| constraint.is_finite());
    residuals.push(constraint.unwrap_or(UNCONSTRAINED));
    Some(Point { design: *design, t: grid.shares(design), residuals, cost: cost.of(candidate) })
}

/// dr_i/dt_j by one-sided differences inwards, one row per residual; `None` where a neighbour has no
/// response on either side.
fn difference_quotients(
    grid: &Grid,
    here: &Point,
    cost: &Cost,
    free: &[usize],
    notebook: &mut Notebook<'_>,
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
                    return visit(grid, &design, cost, notebook);
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

/// The damped step within the bounds that respects the constraint to first order; `None` where no
/// share can move. The last row of the Jacobian and the last residual are the constraint's.
fn damped_step(jacobian: &[Vector], here: &Point, free: &[usize], damping: f64, margin: f64) -> Option<Vector> {
    let (constraint_row, rows) = jacobian.split_last()?;
    let (constraint, residuals) = here.residuals.split_last()?;
    let square = |axis: usize| rows.iter().map(|row| row[axis] * row[axis]).sum::<f64>();
    let largest = free.iter().map(|&axis| square(axis)).fold(0.0, f64::max);
    if largest <= 0.0 {
        return None;
    }
    let mut system: Vec<(Vector, f64)> = rows.iter().copied().zip(residuals.iter().copied()).collect();
    let mut step = bounded_step(&system, &here.t, free, damping * largest)?;
    let slope = constraint_row.iter().zip(&step).map(|(slope, share)| slope * share).sum::<f64>();
    if constraint + slope > 0.0 {
        let weight = CONSTRAINT_WEIGHT * largest.sqrt();
        system.push((constraint_row.map(|slope| weight * slope), weight * (constraint + margin)));
        step = bounded_step(&system, &here.t, free, damping * largest)?;
    }
    let longest = step.iter().fold(0.0_f64, |longest, share| longest.max(share.abs()));
    if longest == 0.0 {
        return None;
    }
    let scale = (LONGEST_STEP / longest).min(1.0);
    Some(step.map(|share| share * scale))
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
fn broyden(jacobian: &mut [Vector], here: &Point, next: &Point) {
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

    fn point(t: Vector, residuals: Vec<f64>) -> Point {
        let design = Pattern::new(slipgrid_pattern::Planform::Groove, 1e-4, 1e-4, 1e-5).unwrap();
        Point { design, t, residuals, cost: 1.0 }
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
        let here = point([0.4, 0.5, 0.5], vec![-0.2, -0.1, 0.2, -0.1]);
        let step = damped_step(&rows, &here, &[0, 1, 2], 0.0, CONSTRAINT_MARGIN).unwrap();
        for (axis, expected) in [(0, 0.5), (1, 0.5), (2, 0.3)] {
            assert!((here.t[axis] + step[axis] - expected).abs() < CONSTRAINT_MARGIN, "{step:?}");
        }
        assert!(step[0] + step[1] < 0.1, "from within");
    }

    #[test]
    fn broyden_learns_a_linear_map_from_three_steps_at_right_angles() {
        let root = [0.2, 0.4, 0.6];
        let mut jacobian = vec![[0.0; 3]; 4];
        for step in [[0.1, 0.0, 0.0], [0.0, 0.2, 0.1], [0.0, -0.1, 0.2]] {
            broyden(&mut jacobian, &point([0.0; 3], residuals([0.0; 3], root)), &point(step, residuals(step, root)));
        }
        for (learnt, row) in jacobian.iter().flatten().zip(LINEAR.iter().flatten()) {
            assert!((learnt - row).abs() < 1e-12);
        }
    }
}
