//! Points x y z in scan order: line after line, each with the same positions along the line. Only their heights are
//! kept, which takes a quarter of the memory of points in arbitrary order.

use super::xyz::Point;

/// Points of a scan read so far.
#[derive(Debug, Default)]
pub(super) struct Scan {
    /// Whether x, and not y, is constant along a line.
    x_is_slow: bool,
    /// Coordinates along a line, the same on all lines.
    fast: Vec<f64>,
    /// Coordinate of each line.
    slow: Vec<f64>,
    /// Line of the text on which each scan line begins; its points follow without a gap.
    first_line: Vec<usize>,
    z: Vec<f64>,
}

impl Scan {
    /// Adds the next point, if it continues the scan; returns whether it does.
    pub(super) fn push(&mut self, point: Point) -> bool {
        let count = self.z.len();
        if count == 1 {
            // The second point shows which coordinate varies along a line.
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
            // The previous lines are complete, and this point begins another.
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

    /// Coordinates along x and along y, and the heights in the order of the file, all in the file's units; `None`
    /// unless all lines are complete.
    pub(super) fn grid(&self) -> Option<([&[f64]; 2], &[f64])> {
        let whole = self.z.len() == self.slow.len() * self.fast.len();
        let along = if self.x_is_slow { [&self.slow[..], &self.fast] } else { [&self.fast[..], &self.slow] };
        whole.then_some((along, &self.z))
    }

    /// Index of the point at row i and column j of the map, in the order of the file.
    pub(super) fn place(&self, i: usize, j: usize) -> usize {
        if self.x_is_slow { i * self.fast.len() + j } else { j * self.fast.len() + i }
    }
}
