//! What a vectorized pass over contact blocks reads of each, in the vertical plane as in space.

use super::contact::GripPiece;

/// Numbers of every column that the pass reads, structure of arrays.
#[derive(Clone, Debug)]
pub struct ContactColumns {
    /// Friction per unit coefficient is constant + linear F_n + quadratic F_n^2 ...
    pub constant: Vec<f64>,
    /// Its share that is linear.
    pub linear: Vec<f64>,
    /// Its share that is quadratic.
    pub quadratic: Vec<f64>,
    /// ... for normal forces from `from`, above zero, up to `to`. Infinity keeps a block out of the pass.
    pub from: Vec<f64>,
    /// End of that interval.
    pub to: Vec<f64>,
    /// Friction coefficient that a block at rest is held with.
    pub starting_mu: Vec<f64>,
    /// Friction coefficient of a sliding block.
    pub dynamic_mu: Vec<f64>,
    /// Displacement per step that a unit force adds.
    pub kick: Vec<f64>,
}

impl ContactColumns {
    /// Columns that no block of the counterface stands for: they pass as at rest without forces.
    #[must_use]
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

    /// A block at column `i`, kept out of the pass until its interval of the law is known.
    pub fn set_block(&mut self, i: usize, starting_mu: f64, dynamic_mu: f64) {
        self.from[i] = f64::INFINITY;
        self.starting_mu[i] = starting_mu;
        self.dynamic_mu[i] = dynamic_mu;
    }

    /// The interval of the law that column `i` is on.
    #[must_use]
    pub fn piece(&self, i: usize) -> GripPiece {
        GripPiece {
            from: self.from[i],
            to: self.to[i],
            constant: self.constant[i],
            linear: self.linear[i],
            quadratic: self.quadratic[i],
        }
    }

    /// Lets the pass take column `i` on `piece`.
    pub fn set_piece(&mut self, i: usize, piece: GripPiece) {
        self.from[i] = piece.from.max(f64::MIN_POSITIVE);
        self.to[i] = piece.to;
        self.constant[i] = piece.constant;
        self.linear[i] = piece.linear;
        self.quadratic[i] = piece.quadratic;
    }
}
