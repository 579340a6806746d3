//! Descent to a goal: steps along the slope within a trust region, projected onto the linearized constraints.
//!
//! A lowest or highest mean is no sum of squares, and where it is lowest constraints or bounds mostly bind. With the
//! slope g of the goal and the radius D of the trust region a step solves
//!
//!   min |s + D g / |g||^2   subject to   c_k + c_k' s <= 0 and the bounds,
//!
//! and what constraints cost decides whether it was one. Slopes come from difference quotients once and from Broyden's
//! update afterwards. The simplex method polishes what this finds.

use crate::evaluation_archive::LocalArchive;
use crate::gauss_newton::{Point, Vector, broyden, constrained_step, difference_quotients, visit};
use crate::local_search::Cost;
use crate::low_discrepancy::MOST_DIMENSIONS;
use crate::space::Grid;
use slipgrid_pattern::Pattern;

/// First radius, its factors after a step that gained and one that did not, and the last radius, as shares of the
/// bounds.
const FIRST_RADIUS: f64 = 0.25;
const RADIUS_INCREASE: f64 = 1.6;
const RADIUS_DECREASE: f64 = 0.4;
const LARGEST_RADIUS: f64 = 0.5;
const LAST_RADIUS: f64 = 0.002;
/// Steps tried from one start.
const MOST_STEPS: usize = 25;
/// Constraints are aimed at from within by this much.
const MARGIN: f64 = 5e-4;

/// Steps from `start` towards the goal while they gain. Returns the best design, or `None` where `start` or its
/// neighbours have no response or the local archive was interrupted before they had.
pub(crate) fn descend(grid: &Grid, start: &Pattern, cost: &Cost, local: &mut LocalArchive<'_>) -> Option<Pattern> {
    let free = grid.free_axes();
    let mut here = visit(grid, start, cost, local)?;
    if free.is_empty() {
        return Some(here.design);
    }
    let mut slopes = difference_quotients(grid, &here, cost, &free, local)?;
    let mut margins = vec![MARGIN; here.constraints];
    let mut radius = FIRST_RADIUS;
    for _ in 0..MOST_STEPS {
        let goal = slopes.first()?;
        let length = free.iter().map(|&axis| goal[axis] * goal[axis]).sum::<f64>().sqrt();
        if radius < LAST_RADIUS || length == 0.0 {
            break;
        }
        let downhill: Vector = std::array::from_fn(|axis| -radius * goal[axis] / length);
        let Some(mut next) = step(grid, &here, &downhill, &slopes, &margins, cost, local) else { break };
        broyden(&mut slopes, &here, &next);
        if next.cost >= here.cost && next.goal() < here.goal() {
            // Constraints bend: straight back to them, with what the step taught.
            if let Some(back) = step(grid, &next, &[0.0; MOST_DIMENSIONS], &slopes, &margins, cost, local) {
                broyden(&mut slopes, &next, &back);
                next = back;
            }
        }
        margins = next.split().1.iter().map(|constraint| MARGIN + constraint.max(0.0)).collect();
        if next.cost < here.cost {
            radius = (radius * RADIUS_INCREASE).min(LARGEST_RADIUS);
            here = next;
        } else {
            radius *= RADIUS_DECREASE;
        }
        if local.interruption.is_some() {
            break;
        }
    }
    Some(here.design)
}

/// The point nearest to `wanted` from `here` that the linearized constraints allow; `None` where that is `here` itself, or
/// has no response.
fn step(
    grid: &Grid,
    here: &Point,
    wanted: &Vector,
    slopes: &[Vector],
    margins: &[f64],
    cost: &Cost,
    local: &mut LocalArchive<'_>,
) -> Option<Point> {
    let free = grid.free_axes();
    let mut system: Vec<(Vector, f64)> = free
        .iter()
        .map(|&axis| {
            let mut row = [0.0; MOST_DIMENSIONS];
            row[axis] = 1.0;
            (row, -wanted[axis])
        })
        .collect();
    let constraints = (&slopes[1..], here.split().1, margins);
    let taken = constrained_step(&mut system, constraints, &here.t, &free, 0.0)?;
    let design = grid.design(&std::array::from_fn(|axis| here.t[axis] + taken[axis]))?;
    if design == here.design { None } else { visit(grid, &design, cost, local) }
}
