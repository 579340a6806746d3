//! Ordinary kriging (Matheron, Econ. Geol. 58, 1246, 1963): interpolation of quantities that are known at some places.

use crate::statistics::cholesky::{cholesky, is_regular, solve};

/// Added to the diagonal of the covariance matrix, so that the matrix stays non-singular for close points.
const NUGGET: f64 = 1e-12;

/// Interpolator of quantities that are known at common places: exact at these places; far from all places, each
/// quantity tends to a weighted mean of its known values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Kriging<const D: usize> {
    range: f64,
    places: Vec<[f64; D]>,
    /// Mean of each quantity, and weights of its values.
    quantities: Vec<(f64, Vec<f64>)>,
}

impl<const D: usize> Kriging<D> {
    /// Interpolates `quantities`, each with a value at every one of `places`; `range` is the correlation length, in the
    /// unit of the places. Without places, interpolated quantities are zero.
    pub fn new(range: f64, places: Vec<[f64; D]>, quantities: Vec<Vec<f64>>) -> Self {
        let n = places.len();
        let nugget = |i: usize, j: usize| if i == j { NUGGET } else { 0.0 };
        let covariances: Vec<f64> =
            (0..n * n).map(|e| covariance(&places[e / n], &places[e % n], range) + nugget(e / n, e % n)).collect();
        // If the matrix is singular within rounding, the quantities are replaced by their mean.
        let factor = cholesky(&covariances, n).filter(|factor| n > 0 && is_regular(factor, n));
        let solved = |factor: &[f64], mut right: Vec<f64>| {
            solve(factor, n, &mut right);
            right
        };
        let regular = factor.as_ref().map(|factor| (factor, solved(factor, vec![1.0; n])));
        let quantity = |known: Vec<f64>| {
            let Some((factor, ones)) = &regular else {
                return (known.iter().sum::<f64>() / n.max(1) as f64, vec![0.0; n]);
            };
            // m = 1' C^-1 d / 1' C^-1 1,   w = C^-1 (d - m 1)
            let weights = solved(factor, known);
            let mean = weights.iter().sum::<f64>() / ones.iter().sum::<f64>();
            (mean, weights.iter().zip(ones).map(|(weight, one)| weight - mean * one).collect())
        };
        let quantities = quantities.into_iter().map(quantity).collect();
        Self { range, places, quantities }
    }

    /// Interpolates the quantities at `place`: d(t) = m + sum `w_i` C(t, `t_i`), with the mean m, the weights `w_i`,
    /// the covariance C, and the places `t_i` of the known values.
    pub fn at(&self, place: &[f64; D]) -> Vec<f64> {
        let near: Vec<f64> = self.places.iter().map(|known| covariance(known, place, self.range)).collect();
        let interpolate = |(mean, weights): &(f64, Vec<f64>)| {
            mean + weights.iter().zip(&near).map(|(weight, c)| weight * c).sum::<f64>()
        };
        self.quantities.iter().map(interpolate).collect()
    }
}

/// Euclidean distance between two places.
pub fn distance<const D: usize>(left: &[f64; D], right: &[f64; D]) -> f64 {
    square(left, right).sqrt()
}

fn square<const D: usize>(left: &[f64; D], right: &[f64; D]) -> f64 {
    left.iter().zip(right).map(|(left, right)| (left - right).powi(2)).sum()
}

/// Matern covariance of smoothness 3/2, (1 + sqrt(3) r / L) exp(-sqrt(3) r / L), with the distance r and L = `range`.
fn covariance<const D: usize>(left: &[f64; D], right: &[f64; D], range: f64) -> f64 {
    let r = (3.0 * square(left, right)).sqrt() / range;
    (1.0 + r) * libm::exp(-r)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_exact_where_they_are_known_and_their_mean_far_away() {
        let places = vec![[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]];
        let known = [vec![1.0, 3.0, 0.5], vec![-2.0, -2.0, -2.0]];
        let found = Kriging::new(1.5, places.clone(), known.to_vec());
        for (row, place) in places.iter().enumerate() {
            let at = found.at(place);
            assert!((at[0] - known[0][row]).abs() < 1e-9 && (at[1] + 2.0).abs() < 1e-9, "{at:?}");
        }
        // Between two places the result is between their values; far from all places it is the common mean.
        let between = found.at(&[0.5, 0.0])[0];
        assert!(between > 1.0 && between < 3.0, "{between}");
        let far = [[90.0, 0.0], [0.0, -90.0]].map(|place| found.at(&place));
        assert!(far[0] == far[1] && far[0][0] > 0.5 && far[0][0] < 3.0, "{far:?}");
        // With one of two equal quantities only, and without any.
        assert_eq!(Kriging::new(1.0, vec![[0.0]], vec![vec![4.0]]).at(&[7.0]), [4.0]);
        assert_eq!(Kriging::<1>::new(1.0, Vec::new(), vec![Vec::new()]).at(&[7.0]), [0.0]);
        // For two values at one place the mean.
        assert_eq!(Kriging::new(1.0, vec![[0.0]; 2], vec![vec![4.0, 6.0]]).at(&[0.0]).len(), 1);
    }
}
