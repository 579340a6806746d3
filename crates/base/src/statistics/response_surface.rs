//! Response surface of a model as a function of three lengths, from its values on a lattice.
//!
//! The surface is the tensor product of cubic B-splines in the logarithms of the lengths (de Boor, A Practical Guide to
//! Splines, 2001, chapters IX and XVII). The third derivative is continuous at the second and second last node of every
//! axis, so that cubic polynomials are reproduced exactly, and the error decreases with the fourth power of the node
//! distance for smooth models.

/// Nodes of one length: positive and evenly spaced in the logarithm.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axis {
    /// Minimum length, in any unit.
    pub from: f64,
    /// Maximum length, in the unit of `from`.
    pub to: f64,
    /// Number of nodes: one for a fixed length, otherwise at least [`Axis::MIN_NODES`].
    pub nodes: usize,
}

impl Axis {
    /// Minimum number of nodes of a length that is not fixed.
    pub const MIN_NODES: usize = 4;

    /// Creates an axis with `nodes` nodes, or with one if both ends are equal.
    pub fn new([from, to]: [f64; 2], nodes: usize) -> Self {
        Self { from, to, nodes: if to > from { nodes.max(Self::MIN_NODES) } else { 1 } }
    }

    /// Length at the node with index `node`.
    pub fn at(&self, node: usize) -> f64 {
        if self.nodes == 1 {
            self.from
        } else {
            self.from * (self.to / self.from).powf(node as f64 / (self.nodes - 1) as f64)
        }
    }

    /// Number of coefficients along the axis: two more than nodes, or one.
    pub const fn coefficients(&self) -> usize {
        if self.nodes == 1 { 1 } else { self.nodes + 2 }
    }

    /// Distance of `length` from the first node, in node distances; a length outside the axis is moved to the nearest
    /// end.
    fn place(&self, length: f64) -> f64 {
        let place = (length / self.from).ln() / (self.to / self.from).ln() * (self.nodes - 1) as f64;
        place.clamp(0.0, (self.nodes - 1) as f64)
    }

    /// Indices of the nodes below and above `length`; equal at a node, and outside the axis, where both are the end
    /// node.
    fn around(&self, length: f64) -> [usize; 2] {
        if self.nodes == 1 {
            return [0; 2];
        }
        let place = self.place(length);
        // Lengths of nodes are rounded.
        [(place + 1e-9).floor() as usize, (place - 1e-9).ceil() as usize]
    }

    /// Index of the first of the four coefficients that contribute at `length`, and the weights of the four; a length
    /// outside the axis is moved to the nearest end.
    fn weights(&self, length: f64) -> (usize, [f64; 4]) {
        if self.nodes == 1 {
            return (0, [1.0, 0.0, 0.0, 0.0]);
        }
        let place = self.place(length);
        let first = (place.floor() as usize).min(self.nodes - 2);
        let t = place - first as f64;
        // The four pieces of the cubic B-spline.
        let weights = [
            (1.0 - t).powi(3),
            3.0 * t.powi(3) - 6.0 * t.powi(2) + 4.0,
            -3.0 * t.powi(3) + 3.0 * t.powi(2) + 3.0 * t + 1.0,
            t.powi(3),
        ];
        (first, weights.map(|weight| weight / 6.0))
    }

    /// Rows of the matrix that converts values at the nodes, between two zeros for the end conditions, into
    /// coefficients: the inverse of the matrix of the splines at the nodes.
    fn inverse(&self) -> Vec<Vec<f64>> {
        let count = self.coefficients();
        let mut left = vec![vec![0.0; count]; count];
        for (node, row) in left[1..=self.nodes].iter_mut().enumerate() {
            row[node..node + 3].copy_from_slice(&[1.0 / 6.0, 4.0 / 6.0, 1.0 / 6.0]);
        }
        // Jump of the third derivative at the second and second last node.
        const JUMP: [f64; 5] = [-1.0, 4.0, -6.0, 4.0, -1.0];
        left[0][..5].copy_from_slice(&JUMP);
        left[count - 1][count - 5..].copy_from_slice(&JUMP);
        let mut right: Vec<Vec<f64>> =
            (0..count).map(|row| (0..count).map(|column| f64::from(u8::from(row == column))).collect()).collect();
        // Gauss-Jordan elimination with pivoting.
        for column in 0..count {
            let pivot = (column..count).max_by(|a, b| left[*a][column].abs().total_cmp(&left[*b][column].abs()));
            let pivot = pivot.unwrap_or(column);
            left.swap(column, pivot);
            right.swap(column, pivot);
            let scale = left[column][column];
            for side in [&mut left, &mut right] {
                side[column].iter_mut().for_each(|entry| *entry /= scale);
            }
            for row in (0..count).filter(|row| *row != column) {
                let factor = left[row][column];
                for side in [&mut left, &mut right] {
                    let pivoted = side[column].clone();
                    side[row].iter_mut().zip(&pivoted).for_each(|(entry, own)| *entry -= factor * own);
                }
            }
        }
        right
    }
}

/// Response surface of three lengths with any number of outputs.
#[derive(Clone, Debug, PartialEq)]
pub struct ResponseSurface {
    axes: [Axis; 3],
    outputs: usize,
    /// B-spline coefficients; the index of the first axis varies slowest, the index of the output fastest.
    coefficients: Vec<f64>,
}

impl ResponseSurface {
    /// Interpolates `values` at the nodes of `axes`; the first axis varies slowest, and the `outputs` values of a node
    /// are adjacent.
    pub fn through(axes: [Axis; 3], outputs: usize, values: Vec<f64>) -> Self {
        let mut coefficients = values;
        // One axis after the other; `before` counts the slower indices, `after` the faster ones.
        let mut before = 1;
        for (place, axis) in axes.iter().enumerate() {
            let after = axes[place + 1..].iter().map(|axis| axis.nodes).product::<usize>() * outputs;
            if axis.nodes > 1 {
                let (inverse, count) = (axis.inverse(), axis.coefficients());
                let mut found = vec![0.0; before * count * after];
                for outer in 0..before {
                    for (row, weights) in inverse.iter().enumerate() {
                        let into = &mut found[(outer * count + row) * after..][..after];
                        for node in 0..axis.nodes {
                            let from = &coefficients[(outer * axis.nodes + node) * after..][..after];
                            // The first and last column belong to the jumps, which are zero.
                            into.iter_mut().zip(from).for_each(|(into, value)| *into += weights[node + 1] * value);
                        }
                    }
                }
                coefficients = found;
            }
            before *= axis.coefficients();
        }
        Self { axes, outputs, coefficients }
    }

    /// Axes of the three lengths.
    pub const fn axes(&self) -> &[Axis; 3] {
        &self.axes
    }

    /// Number of outputs per node.
    pub const fn outputs(&self) -> usize {
        self.outputs
    }

    /// All B-spline coefficients; the index of the first axis varies slowest, the index of the output fastest.
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Lengths of all nodes of `axes`; the first axis varies slowest.
    pub fn nodes(axes: &[Axis; 3]) -> Vec<[f64; 3]> {
        let [first, second, third] = axes;
        let for_first = |a: usize| (0..second.nodes).flat_map(move |b| (0..third.nodes).map(move |c| [a, b, c]));
        (0..first.nodes).flat_map(for_first).map(|[a, b, c]| [first.at(a), second.at(b), third.at(c)]).collect()
    }

    /// Whether one of `nodes`, indices in the order of `Self::nodes`, is a corner of the lattice cell that contains
    /// `lengths`.
    pub fn is_beside(&self, nodes: &[usize], lengths: &[f64; 3]) -> bool {
        let [_, rows, columns] = self.axes.map(|axis| axis.nodes);
        let around: [_; 3] = std::array::from_fn(|axis| self.axes[axis].around(lengths[axis]));
        nodes.iter().any(|node| {
            let place = [node / (rows * columns), node / columns % rows, node % columns];
            place.iter().zip(around).all(|(own, [first, last])| (first..=last).contains(own))
        })
    }

    /// Interpolates the outputs at `lengths`; beyond the ends of an axis the outputs are constant.
    pub fn at(&self, lengths: &[f64; 3]) -> Vec<f64> {
        let [(a, u), (b, v), (c, w)] = std::array::from_fn(|axis| self.axes[axis].weights(lengths[axis]));
        let [_, rows, columns] = self.axes.map(|axis| axis.coefficients());
        let mut found = vec![0.0; self.outputs];
        for (i, u) in u.iter().enumerate().filter(|(_, u)| **u != 0.0) {
            for (j, v) in v.iter().enumerate().filter(|(_, v)| **v != 0.0) {
                for (k, w) in w.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                    let first = (((a + i) * rows + b + j) * columns + c + k) * self.outputs;
                    let own = &self.coefficients[first..first + self.outputs];
                    found.iter_mut().zip(own).for_each(|(found, own)| *found += u * v * w * own);
                }
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_node_is_a_corner_of_all_cells_around_it() {
        let axes = [Axis::new([1.0, 8.0], 4), Axis::new([1.0, 8.0], 4), Axis::new([5.0, 5.0], 1)];
        let surface = ResponseSurface::through(axes, 1, vec![0.0; 16]);
        // The node at 2 and 4.
        let is_beside = |width: f64, spacing: f64| surface.is_beside(&[6], &[width, spacing, 5.0]);
        for [width, spacing] in [[2.0, 4.0], [1.1, 4.0], [3.9, 7.9], [1.5, 2.5], [2.5, 3.0]] {
            assert!(is_beside(width, spacing), "{width} {spacing}");
        }
        for [width, spacing] in [[1.0, 4.0], [4.0, 4.0], [2.0, 8.0], [2.0, 2.0], [2.0, 9.0], [4.1, 4.0], [2.0, 1.9]] {
            assert!(!is_beside(width, spacing), "{width} {spacing}");
        }
        assert!(!surface.is_beside(&[], &[2.0, 4.0, 5.0]));
    }

    fn surface(nodes: [usize; 3], model: impl Fn(&[f64; 3]) -> Vec<f64>) -> ResponseSurface {
        let axes = [
            Axis::new([40.0, 400.0], nodes[0]),
            Axis::new([50.0, 1000.0], nodes[1]),
            Axis::new([if nodes[2] == 1 { 50.0 } else { 2.0 }, 50.0], nodes[2]),
        ];
        let values = ResponseSurface::nodes(&axes).iter().flat_map(model).collect();
        ResponseSurface::through(axes, 2, values)
    }

    fn points() -> impl Iterator<Item = [f64; 3]> {
        (0..200).map(|k| {
            let share = |step: f64| (f64::from(k) * step).fract();
            [40.0 * 10.0_f64.powf(share(0.618)), 50.0 * 20.0_f64.powf(share(0.414)), 2.0 * 25.0_f64.powf(share(0.732))]
        })
    }

    #[test]
    fn cubic_polynomials_of_the_logarithms_are_met_exactly() {
        let model = |at: &[f64; 3]| {
            let [x, y, z] = at.map(f64::ln);
            vec![1.0 + x * y.powi(3) - 0.2 * z.powi(2) * x.powi(3), z.powi(3) - y]
        };
        let surface = surface([4, 5, 7], model);
        for at in points() {
            for (found, exact) in surface.at(&at).iter().zip(model(&at)) {
                assert!((found - exact).abs() < 1e-9 * (1.0 + exact.abs()), "{at:?}: {found} {exact}");
            }
        }
    }

    #[test]
    fn the_error_falls_with_the_fourth_power_of_the_distance() {
        let model = |at: &[f64; 3]| {
            let [x, y, z] = at.map(f64::ln);
            vec![(1.3 * x + y).sin() * (0.7 * z).cos(), 0.0]
        };
        let worst = |nodes: usize| {
            let surface = surface([nodes; 3], model);
            points().map(|at| (surface.at(&at)[0] - model(&at)[0]).abs()).fold(0.0, f64::max)
        };
        let order = (worst(11) / worst(21)).log2();
        assert!((3.4..5.0).contains(&order), "{order}");
    }

    #[test]
    fn a_fixed_length_needs_one_node_and_ends_hold_beyond_them() {
        let surface = surface([6, 6, 1], |at| vec![at[0].ln(), at[1]]);
        assert_eq!(surface.axes()[2].nodes, 1);
        assert!((surface.at(&[100.0, 200.0, 7.0])[0] - 100.0_f64.ln()).abs() < 1e-12);
        assert_eq!(surface.at(&[1e9, 200.0, 50.0]), surface.at(&[400.0, 200.0, 50.0]));
    }
}
