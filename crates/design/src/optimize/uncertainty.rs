//! Uncertainty of a design's dimensions and of the model's parameters.

use schemars::JsonSchema;
use serde::Deserialize;
use slipgrid_base::units::LENGTH_UM;
use slipgrid_model::pattern::Pattern;

use crate::optimize::SearchError;

/// Number of lengths: width, spacing, depth.
const AXES: usize = 3;

/// Pivots of the Cholesky factorization below this share of the variance of an input are taken as zero: the input
/// depends linearly on earlier inputs.
const VANISHING: f64 = 1e-12;

/// Standard deviations of the mean dimensions of a whole sample about the designed dimensions, normally distributed.
/// Scatter of the cavities within one sample is excluded: friction averages over the cavities, and their scatter enters
/// only through the curvature of friction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Tolerances {
    /// Standard deviation of a sample's mean width; 0 when absent.
    pub width_std_um: f64,
    /// Standard deviation of a sample's mean spacing; 0 when absent.
    pub spacing_std_um: f64,
    /// Standard deviation of a sample's mean depth; 0 when absent.
    pub depth_std_um: f64,
    // A height below the land counts as equally far above it, so that the rim heights of a design without rims are
    // half-normal.
    /// Standard deviation of the mean height of a sample's rims; 0 when absent.
    pub rim_height_std_um: f64,
    /// Correlation of width and spacing, -1 where the pitch is exact; 0 when absent.
    pub width_spacing_correlation: f64,
}

impl Tolerances {
    /// Standard deviations of width, spacing and depth, in metres.
    pub fn std_m(&self) -> [f64; AXES] {
        [self.width_std_um, self.spacing_std_um, self.depth_std_um].map(|std_um| LENGTH_UM.to_si(std_um))
    }

    /// Standard deviation of the mean rim height of a sample, in metres.
    pub fn rim_height_std_m(&self) -> f64 {
        LENGTH_UM.to_si(self.rim_height_std_um)
    }

    /// Independent errors that are not zero, each as changes of width, spacing and depth by one standard deviation, in
    /// metres.
    pub fn independent_m(&self) -> Vec<[f64; AXES]> {
        let [width, spacing, depth] = self.std_m();
        let correlation = self.width_spacing_correlation;
        // Rows of the factor's transpose: spacing = rho s z_1 + sqrt(1 - rho^2) s z_2
        let free = (1.0 - correlation * correlation).max(0.0).sqrt();
        let with_width = if width > 0.0 { correlation * spacing } else { 0.0 };
        let alone = if width > 0.0 { free * spacing } else { spacing };
        let all = [[width, with_width, 0.0], [0.0, alone, 0.0], [0.0, 0.0, depth]];
        all.into_iter().filter(|shift| shift.iter().any(|by_m| *by_m != 0.0)).collect()
    }
}

/// Joint normal distribution of the errors of a design's dimensions and of a model's parameters; the means are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Uncertainty {
    covariance: Vec<Vec<f64>>,
    /// Whether the rim height is the last input.
    has_rim: bool,
}

impl Uncertainty {
    /// Combines `tolerances` with parameters that are independent of them and have the covariance
    /// `parameter_covariance`.
    ///
    /// # Errors
    /// [`SearchError::OutOfRange`] for a negative or infinite standard deviation, a correlation beyond -1 to 1, or a
    /// matrix that is no covariance.
    pub fn new(tolerances: &Tolerances, parameter_covariance: &[Vec<f64>]) -> Result<Self, SearchError> {
        let (std_m, rim_height_std_m) = (tolerances.std_m(), tolerances.rim_height_std_m());
        for value in std_m.into_iter().chain([rim_height_std_m]) {
            if !(value.is_finite() && value >= 0.0) {
                let (quantity, expected) = ("standard deviation of a dimension", "a number that is not negative");
                return Err(SearchError::OutOfRange { quantity, value, expected });
            }
        }
        let correlation = tolerances.width_spacing_correlation;
        if !(-1.0..=1.0).contains(&correlation) {
            let quantity = "correlation of width and spacing";
            return Err(SearchError::OutOfRange { quantity, value: correlation, expected: "a number from -1 to 1" });
        }
        let count = parameter_covariance.len();
        if let Some(row) = parameter_covariance.iter().find(|row| row.len() != count) {
            let (quantity, expected) = ("entries in a row of the covariance", "a square matrix");
            return Err(SearchError::OutOfRange { quantity, value: row.len() as f64, expected });
        }
        let has_rim = rim_height_std_m > 0.0;
        let inputs = AXES + count + usize::from(has_rim);
        let mut covariance = vec![vec![0.0; inputs]; inputs];
        for (axis, std_m) in std_m.iter().enumerate() {
            covariance[axis][axis] = std_m * std_m;
        }
        let shared = correlation * std_m[0] * std_m[1];
        (covariance[0][1], covariance[1][0]) = (shared, shared);
        for (row, entries) in parameter_covariance.iter().enumerate() {
            covariance[AXES + row][AXES..AXES + count].copy_from_slice(entries);
        }
        if has_rim {
            covariance[inputs - 1][inputs - 1] = rim_height_std_m.powi(2);
        }
        factorized(&covariance)?;
        Ok(Self { covariance, has_rim })
    }

    /// Index of the rim height, the last input; `None` if its standard deviation is 0.
    pub fn rim(&self) -> Option<usize> {
        self.has_rim.then(|| self.inputs() - 1)
    }

    /// Number of inputs: dimensions, parameters and the rim height.
    pub fn inputs(&self) -> usize {
        self.covariance.len()
    }

    /// Standard deviation of one input: width, spacing, depth in metres, then the parameters, then the rim height in
    /// metres.
    pub fn std(&self, input: usize) -> f64 {
        self.covariance[input][input].sqrt()
    }

    /// Covariance of values from the inputs that `of` selects by index, one row per value: G' C G, with the derivatives
    /// G = `slopes`, one row per input and one column per value, and the covariance C of the inputs.
    pub fn covariance_of(&self, slopes: &[Vec<f64>], of: &dyn Fn(usize) -> bool) -> Vec<Vec<f64>> {
        let count = slopes.first().map_or(0, Vec::len);
        let mut covariance = vec![vec![0.0; count]; count];
        for (i, row) in self.covariance.iter().enumerate().filter(|(i, _)| of(*i)) {
            for (j, entry) in row.iter().enumerate().filter(|(j, entry)| of(*j) && **entry != 0.0) {
                for (value, sums) in covariance.iter_mut().enumerate() {
                    let left = slopes[i][value] * entry;
                    sums.iter_mut().zip(&slopes[j]).for_each(|(sum, right)| *sum += left * right);
                }
            }
        }
        covariance
    }
}

/// Returns the design with the mean rim height changed by `by_m`: |h + by|, as a height below the land counts as equally
/// far above it.
pub fn with_rim_off(design: &Pattern, by_m: f64) -> Pattern {
    let height_m = design.rim_height_m();
    let raised = design.texture().rim().map(|rim| rim.raised((height_m + by_m).abs() - height_m));
    design.to_owned().with_rim(raised)
}

/// Cholesky factor of a covariance that may be singular. Inputs of different units are compared by their own variances.
fn factorized(covariance: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, SearchError> {
    const QUANTITY: &str = "entry of the covariance";
    const EXPECTED: &str = "a symmetric matrix without negative variances in any direction";
    let n = covariance.len();
    let refused = |value: f64| SearchError::OutOfRange { quantity: QUANTITY, value, expected: EXPECTED };
    let mut factor = vec![vec![0.0; n]; n];
    for j in 0..n {
        let own = covariance[j][j];
        if !own.is_finite() || own < 0.0 {
            return Err(refused(own));
        }
        let pivot = own - factor[j][..j].iter().map(|l| l * l).sum::<f64>();
        if pivot < -VANISHING.sqrt() * own {
            return Err(refused(pivot));
        }
        let is_free = pivot > VANISHING * own;
        factor[j][j] = if is_free { pivot.sqrt() } else { 0.0 };
        for i in j + 1..n {
            let size = (own * covariance[i][i]).sqrt();
            let entry = covariance[i][j];
            if !entry.is_finite() || (entry - covariance[j][i]).abs() > 1e-9 * size {
                return Err(refused(entry));
            }
            let left = entry - (0..j).map(|k| factor[i][k] * factor[j][k]).sum::<f64>();
            if is_free {
                factor[i][j] = left / factor[j][j];
            } else if left.abs() > VANISHING.sqrt() * size {
                // A variable with zero variance must not covary with another.
                return Err(refused(entry));
            }
        }
    }
    Ok(factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tolerances(std_um: [f64; AXES], width_spacing_correlation: f64) -> Tolerances {
        let [width_std_um, spacing_std_um, depth_std_um] = std_um;
        Tolerances { width_std_um, spacing_std_um, depth_std_um, rim_height_std_um: 0.0, width_spacing_correlation }
    }

    #[test]
    fn the_factor_gives_the_covariance_back_singular_or_not() {
        for (correlation, parameters) in [
            (0.0, vec![]),
            (-1.0, vec![vec![4e-4]]),
            (0.5, vec![vec![1e-4, 1e-4, 0.0], vec![1e-4, 1e-4, 0.0], vec![0.0, 0.0, 0.0]]),
            (1.0, vec![vec![4.0, 1.2], vec![1.2, 1.0]]),
        ] {
            let known = Uncertainty::new(&tolerances([8.0, 13.0, 1.3], correlation), &parameters).unwrap();
            assert_eq!(known.inputs(), 3 + parameters.len());
            for i in 0..known.inputs() {
                for j in 0..known.inputs() {
                    let factor = factorized(&known.covariance).unwrap();
                    let product: f64 = (0..known.inputs()).map(|k| factor[i][k] * factor[j][k]).sum();
                    let size = known.std(i) * known.std(j);
                    assert!((product - known.covariance[i][j]).abs() <= 1e-9 * size, "{i} {j}");
                }
            }
        }
        // With an exact pitch, a wider cavity reduces the spacing: their sum stays constant.
        let exact_pitch = Uncertainty::new(&tolerances([8.0, 8.0, 0.0], -1.0), &[]).unwrap();
        let of_pitch = exact_pitch.covariance_of(&[vec![1.0], vec![1.0], vec![0.0]], &|_| true);
        assert!(of_pitch[0][0].abs() < 1e-24, "{of_pitch:?}");
    }

    #[test]
    fn the_height_of_rims_is_the_last_input_and_independent_of_the_others() {
        let made = Tolerances { rim_height_std_um: 5e-2, ..tolerances([8.0, 13.0, 1.3], -1.0) };
        let known = Uncertainty::new(&made, &[vec![4e-4]]).unwrap();
        assert_eq!((known.inputs(), known.rim()), (5, Some(4)));
        assert!((known.std(4) - 5e-8).abs() < 1e-22 && (0..4).all(|other| known.covariance[4][other] == 0.0));
        let exact = Uncertainty::new(&tolerances([8.0, 13.0, 1.3], -1.0), &[vec![4e-4]]).unwrap();
        assert_eq!((exact.inputs(), exact.rim()), (4, None));
        let bad = Tolerances { rim_height_std_um: -1e-2, ..Tolerances::default() };
        assert!(matches!(Uncertainty::new(&bad, &[]), Err(SearchError::OutOfRange { .. })));
    }

    #[test]
    fn what_is_no_covariance_is_refused() {
        let new = |std_um, correlation, parameters: &[Vec<f64>]| {
            Uncertainty::new(&tolerances(std_um, correlation), parameters)
        };
        let refused = |found| matches!(found, Err(SearchError::OutOfRange { .. }));
        assert!(refused(new([-1.0, 0.0, 0.0], 0.0, &[])));
        assert!(refused(new([f64::NAN, 0.0, 0.0], 0.0, &[])));
        assert!(refused(new([1.0; 3], 1.5, &[])));
        assert!(refused(new([1.0; 3], 0.0, &[vec![1.0, 2.0]])));
        assert!(refused(new([1.0; 3], 0.0, &[vec![1.0, 2.0], vec![2.0, 1.0]])), "indefinite");
        assert!(refused(new([1.0; 3], 0.0, &[vec![1.0, 0.5], vec![0.2, 1.0]])), "not symmetric");
        assert!(refused(new([1.0; 3], 0.0, &[vec![0.0, 0.5], vec![0.5, 1.0]])), "no variance, yet correlated");
    }
}
