//! Pareto front of cost and error: methods without a faster method that is at least as accurate.

/// Cost and error of a method.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Cost of the method.
    pub cost: f64,
    /// Upper bound of the error.
    pub error: f64,
}

/// Whether each of `points` is on the front. Errors below `floor` are indistinguishable and count as equal.
pub fn front(points: &[Point], floor: f64) -> Vec<bool> {
    points.iter().map(|point| points.iter().all(|other| !dominates(other, point, floor))).collect()
}

/// Times whose ratio exceeds this value count as equal: runs of one method differ by as much.
const SAME_COST: f64 = 0.9;

/// Whether `a` dominates `b`.
fn dominates(a: &Point, b: &Point, floor: f64) -> bool {
    let (error_a, error_b) = (a.error.max(floor), b.error.max(floor));
    (a.cost < SAME_COST * b.cost && error_a <= error_b) || (SAME_COST * a.cost <= b.cost && error_a < error_b)
}

/// Index of a point that dominates `points[index]`, on the front if possible.
pub fn better(points: &[Point], index: usize, floor: f64) -> Option<usize> {
    let on = front(points, floor);
    let dominating = || (0..points.len()).filter(|&other| dominates(&points[other], &points[index], floor));
    dominating().find(|&other| on[other]).or_else(|| dominating().next())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(cost: f64, error: f64) -> Point {
        Point { cost, error }
    }

    #[test]
    fn neither_faster_nor_better_is_not_on_the_front() {
        let points = [point(1.0, 3.0), point(2.0, 1.0), point(3.0, 2.0), point(4.0, 0.5), point(1.0, 4.0)];
        assert_eq!(front(&points, 0.0), [true, true, false, true, false]);
        assert_eq!(
            (better(&points, 2, 0.0), better(&points, 4, 0.0), better(&points, 1, 0.0)),
            (Some(1), Some(0), None)
        );
    }

    #[test]
    fn below_the_floor_only_the_fastest_counts() {
        let points = [point(1.0, 3.0), point(2.0, 0.4), point(3.0, 0.2), point(4.0, 0.0)];
        assert_eq!(front(&points, 0.5), [true, true, false, false]);
        assert_eq!(front(&points, 0.0), [true, true, true, true]);
    }

    #[test]
    fn equals_are_both_on_the_front() {
        assert_eq!(front(&[point(1.0, 1.0), point(1.05, 1.0)], 0.0), [true, true]);
        assert_eq!(front(&[point(1.0, 1.0), point(1.05, 0.5), point(1.2, 0.5)], 0.0), [false, true, false]);
        assert!(front(&[], 0.0).is_empty());
    }
}
