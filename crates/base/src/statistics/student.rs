//! Quantiles of Student's t distribution.

/// The 97.5 % quantile of the standard normal distribution: 95 % lie between its negative and this value.
pub const NORMAL_95: f64 = 1.959_964;

/// A two-sided confidence level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Confidence {
    /// Two-sided quantile of the standard normal distribution at this level.
    normal: f64,
    /// Two-sided quantiles of Student's t for the first degrees of freedom: 1, 2 and so on.
    few: &'static [f64],
}

impl Confidence {
    /// 95 %: within 1.96 standard deviations of a normal distribution.
    pub const PERCENT_95: Self = Self { normal: NORMAL_95, few: &[12.706_205, 4.302_653, 3.182_446] };
    /// 95.45 %: within two standard deviations of a normal distribution.
    pub const TWO_SIGMA: Self = Self { normal: 2.0, few: &[13.968, 4.527, 3.307, 2.869] };
    /// 99.5 %: within 2.81 standard deviations of a normal distribution.
    pub const PERCENT_99_5: Self =
        Self { normal: 2.807_034, few: &[127.321_34, 14.089_05, 7.453_319, 5.597_568, 4.773_341, 4.316_827] };

    /// Two-sided quantile of Student's t: tabulated for few degrees of freedom, Fisher's expansion for more. Zero
    /// degrees of freedom count as one.
    pub fn student_t(self, degrees_of_freedom: usize) -> f64 {
        let degrees_of_freedom = degrees_of_freedom.max(1);
        if let Some(&tabulated) = self.few.get(degrees_of_freedom - 1) {
            return tabulated;
        }
        let (z, n) = (self.normal, degrees_of_freedom as f64);
        let (z3, z5, z7) = (z.powi(3), z.powi(5), z.powi(7));
        z + (z3 + z) / (4.0 * n)
            + (5.0 * z5 + 16.0 * z3 + 3.0 * z) / (96.0 * n * n)
            + (3.0 * z7 + 19.0 * z5 + 17.0 * z3 - 15.0 * z) / (384.0 * n.powi(3))
    }
}
