//! Points x y z in the order of a scan: line after line, each with the same points. Of these only the heights are
//! kept, a quarter of what points in any order take.

use super::xyz::Point;

/// Points of a scan so far.
#[derive(Debug, Default)]
pub(super) struct Scan {
    /// x is the same along a line, not y.
    x_is_slow: bool,
    /// The coordinate along a line, the same on all lines.
    fast: Vec<f64>,
    /// The coordinate of each line.
    slow: Vec<f64>,
    /// The text's line on which each begins; its points follow without a gap.
    first_line: Vec<usize>,
    z: Vec<f64>,
}

impl Scan {
    /// Points so far.
    pub(super) const fn len(&self) -> usize {
        self.z.len()
    }

    /// Takes the next point if the scan goes on with it.
    pub(super) fn push(&mut self, point: Point) -> bool {
        let count = self.z.len();
        if count == 1 {
            // The second point says which coordinate runs.
            let first = [self.slow[0], self.fast[0]];
            self.x_is_slow = point.x == first[0];
            if !self.x_is_slow {
                (self.slow[0], self.fast[0]) = (first[1], first[0]);
            }
        }
        let (slow, fast) = if self.x_is_slow || count == 0 { (point.x, point.y) } else { (point.y, point.x) };
        let along = match self.slow.len() {
            0 => 0,
            1 if slow == self.slow[0] => count,
            _ => count % self.fast.len(),
        };
        if along == 0 {
            // The lines before are whole, and this one is another.
            if self.slow.last() == Some(&slow) || self.fast.first().is_some_and(|first| *first != fast) {
                return false;
            }
            self.slow.push(slow);
            self.first_line.push(point.line);
        } else if self.slow.last() != Some(&slow) || self.first_line.last() != Some(&(point.line - along)) {
            return false;
        }
        match self.fast.get(along) {
            Some(expected) if *expected != fast => return false,
            Some(_) => {}
            None => self.fast.push(fast),
        }
        self.z.push(point.z);
        true
    }

    /// The points one by one.
    pub(super) fn points(&self) -> impl Iterator<Item = Point> {
        self.z.iter().enumerate().map(|(n, &z)| {
            let (line, along) = (n / self.fast.len(), n % self.fast.len());
            let (slow, fast) = (self.slow[line], self.fast[along]);
            let (x, y) = if self.x_is_slow { (slow, fast) } else { (fast, slow) };
            Point { x, y, z, line: self.first_line[line] + along }
        })
    }

    /// Coordinates along x and y, if all lines are whole, and the heights.
    pub(super) fn grid(&self) -> Option<([&[f64]; 2], &[f64])> {
        let whole = self.z.len() == self.slow.len() * self.fast.len();
        let along = if self.x_is_slow { [&self.slow[..], &self.fast] } else { [&self.fast[..], &self.slow] };
        whole.then_some((along, &self.z))
    }

    /// The place among the points of row i and column j.
    pub(super) fn place(&self, i: usize, j: usize) -> usize {
        if self.x_is_slow { i * self.fast.len() + j } else { j * self.fast.len() + i }
    }
}
