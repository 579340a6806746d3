//! Per-column data of contact blocks that the vectorized pass reads, in the plane and in space.

use super::contact::GripPiece;

/// Friction law and kick of the contact block in every column, as a structure of arrays. Forces are in units of k l
/// (spring stiffness times lattice spacing).
#[derive(Clone, Debug)]
pub struct ContactColumns {
    /// Constant term of the friction per unit friction coefficient, constant + linear F_n + quadratic F_n^2, with the
    /// normal force F_n.
    pub constant: Vec<f64>,
    /// Factor of the normal force F_n in the friction per unit friction coefficient.
    pub linear: Vec<f64>,
    /// Factor of the square of the normal force F_n in the friction per unit friction coefficient.
    pub quadratic: Vec<f64>,
    /// Lower end of the interval of normal forces in which the polynomial of friction holds, above zero. Infinity
    /// excludes a block from the vectorized pass.
    pub from: Vec<f64>,
    /// Upper end of the interval of normal forces in which the polynomial of friction holds.
    pub to: Vec<f64>,
    /// Friction coefficient above which a block at rest starts to slide.
    pub starting_mu: Vec<f64>,
    /// Friction coefficient of a sliding block.
    pub dynamic_mu: Vec<f64>,
    /// Displacement in one step from rest under a unit force, with the mass of the block.
    pub kick: Vec<f64>,
}

impl ContactColumns {
    /// Creates columns without contact blocks, which the vectorized pass treats as blocks at rest without forces.
    /// `kick` is the displacement in one step under a unit force, by column.
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

    /// Puts a block with these friction coefficients at column `i`. The vectorized pass excludes the block until
    /// [`Self::set_piece`] is called.
    pub fn set_block(&mut self, i: usize, starting_mu: f64, dynamic_mu: f64) {
        self.from[i] = f64::INFINITY;
        self.starting_mu[i] = starting_mu;
        self.dynamic_mu[i] = dynamic_mu;
    }

    /// Returns the polynomial of the friction law in column `i`, with the interval of normal forces in which it holds.
    pub fn piece(&self, i: usize) -> GripPiece {
        GripPiece {
            from: self.from[i],
            to: self.to[i],
            constant: self.constant[i],
            linear: self.linear[i],
            quadratic: self.quadratic[i],
        }
    }

    /// Sets the polynomial of the friction law in column `i`, which includes the column in the vectorized pass.
    pub fn set_piece(&mut self, i: usize, piece: GripPiece) {
        self.from[i] = piece.from.max(f64::MIN_POSITIVE);
        self.to[i] = piece.to;
        self.constant[i] = piece.constant;
        self.linear[i] = piece.linear;
        self.quadratic[i] = piece.quadratic;
    }
}
