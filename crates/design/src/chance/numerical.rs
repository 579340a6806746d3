//! How exactly values were computed.

/// Standard deviations of values, one per load of each condition.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numerical {
    /// Of what scatters from load to load, as time averages do.
    pub scatter: Vec<f64>,
    /// Of what all loads have in common: how the lattice stands for the specimen. Smaller blocks, for one, move the ratios at all loads
    /// to the same side.
    pub common: Vec<f64>,
    /// Of how far friction tilts the pressure of the specimen, with the signs that loads have against one another.
    pub tilt: Vec<f64>,
}

/// Standard deviation of a number in blocks of l that differs by `difference` from the same in blocks of l/2: half of its distance
/// to that of vanishing blocks, if the order of convergence is one half.
pub fn block_std(difference: f64) -> f64 {
    // |r_l - r_(l/2)| (1 + 1 / (2^(1/2) - 1)), as two standard deviations
    0.5 * difference.abs() * (1.0 + 1.0 / (std::f64::consts::SQRT_2 - 1.0))
}

impl Numerical {
    /// What scatters as `scatter` has it, with nothing in common.
    pub fn scattered(scatter: Vec<f64>) -> Self {
        Self { common: vec![0.0; scatter.len()], tilt: vec![0.0; scatter.len()], scatter }
    }

    /// Loads have nothing but `common`.
    pub fn in_common(common: Vec<f64>) -> Self {
        Self { scatter: vec![0.0; common.len()], tilt: vec![0.0; common.len()], common }
    }

    /// The largest of them all.
    pub fn most(&self) -> f64 {
        let each = self.scatter.iter().zip(&self.common).zip(&self.tilt);
        each.map(|((scatter, common), tilt)| scatter.hypot(*common).hypot(*tilt)).fold(0.0, f64::max)
    }

    /// Number of deviates: one per load, the common one and that of the tilt.
    pub const fn deviates(loads: usize) -> usize {
        loads + 2
    }

    /// What is added to the value at `load` where the deviates are as `off` says.
    pub fn off(&self, load: usize, off: impl Fn(usize) -> f64) -> f64 {
        let first = self.scatter.len();
        self.scatter[load] * off(load) + self.common[load] * off(first) + self.tilt[load] * off(first + 1)
    }

    /// Enters slopes along these deviates, one row each.
    pub fn enter(&self, slopes: &mut [Vec<f64>]) {
        if let [scatter @ .., common, tilt] = slopes {
            scatter.iter_mut().zip(&self.scatter).enumerate().for_each(|(load, (slopes, std))| slopes[load] = *std);
            common.clone_from(&self.common);
            tilt.clone_from(&self.tilt);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_say_what_deviates_do() {
        let numerical = Numerical { scatter: vec![0.1, 0.2], common: vec![0.3, -0.4], tilt: vec![-0.1, 0.5] };
        let mut slopes = vec![vec![0.0; 2]; Numerical::deviates(2)];
        numerical.enter(&mut slopes);
        assert_eq!(slopes, [[0.1, 0.0], [0.0, 0.2], [0.3, -0.4], [-0.1, 0.5]]);
        let deviates = [1.0, -2.0, 0.5, 3.0];
        for load in 0..2 {
            let by_slopes: f64 = deviates.iter().zip(&slopes).map(|(off, slopes)| off * slopes[load]).sum();
            assert!((numerical.off(load, |place| deviates[place]) - by_slopes).abs() < 1e-15);
        }
        assert!((numerical.most() - 0.2_f64.hypot(0.4).hypot(0.5)).abs() < 1e-15);
    }
}
