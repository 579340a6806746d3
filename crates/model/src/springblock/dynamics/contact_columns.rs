//! Per-column data of contact blocks that the vectorized pass reads, in the plane and in space.

use super::contact::GripPiece;

/// Data of every column as a structure of arrays.
#[derive(Clone, Debug)]
pub struct ContactColumns {
    /// Constant term of the friction per unit coefficient, constant + linear F_n + quadratic F_n^2.
    pub constant: Vec<f64>,
    /// Linear coefficient.
    pub linear: Vec<f64>,
    /// Quadratic coefficient.
    pub quadratic: Vec<f64>,
    /// Lower end of the interval of normal forces in which the polynomial holds, above zero. Infinity excludes a block
    /// from the vectorized pass.
    pub from: Vec<f64>,
    /// Upper end of the interval.
    pub to: Vec<f64>,
    /// Threshold friction coefficient of a block at rest.
    pub starting_mu: Vec<f64>,
    /// Friction coefficient of a sliding block.
    pub dynamic_mu: Vec<f64>,
    /// Displacement per step caused by a unit force.
    pub kick: Vec<f64>,
}

impl ContactColumns {
    /// Creates columns without contact blocks, which the pass treats as at rest without forces.
    pub fn without_blocks(kick: Vec<f64>) -> Self {
        let count = kick.len();
        let zero = || vec![0.0; count];
        Self {
            constant: zero(),
            linear: zero(),
            quadratic: zero(),
            from: vec![f64::NEG_INFINITY; count],
            to: vec![f64::INFINITY; count],
            starting_mu: zero(),
            dynamic_mu: zero(),
            kick,
        }
    }

    /// Puts a block at column `i`, excluded from the pass until its interval of the law is known.
    pub fn set_block(&mut self, i: usize, starting_mu: f64, dynamic_mu: f64) {
        self.from[i] = f64::INFINITY;
        self.starting_mu[i] = starting_mu;
        self.dynamic_mu[i] = dynamic_mu;
    }

    /// Returns the polynomial of column `i`.
    pub fn piece(&self, i: usize) -> GripPiece {
        GripPiece {
            from: self.from[i],
            to: self.to[i],
            constant: self.constant[i],
            linear: self.linear[i],
            quadratic: self.quadratic[i],
        }
    }

    /// Sets the polynomial of column `i`, which includes it in the pass.
    pub fn set_piece(&mut self, i: usize, piece: GripPiece) {
        self.from[i] = piece.from.max(f64::MIN_POSITIVE);
        self.to[i] = piece.to;
        self.constant[i] = piece.constant;
        self.linear[i] = piece.linear;
        self.quadratic[i] = piece.quadratic;
    }
}
