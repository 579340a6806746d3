//! Chi-square distribution.

/// Probability Q(n) that the sum of the squares of n = `degrees` independent standard normal deviates is at least
/// x = `chi_square`; 1 for zero degrees.
///
/// ```text
/// Q(n + 2) = Q(n) + (x / 2)^(n / 2) exp(-x / 2) / Gamma(n / 2 + 1),     Q(0) = 0,     Q(1) = erfc(sqrt(x / 2))
/// ```
pub fn chi_square_beyond(chi_square: f64, degrees: usize) -> f64 {
    if degrees == 0 || chi_square <= 0.0 {
        return 1.0;
    }
    if chi_square == f64::INFINITY {
        return 0.0;
    }
    let half = 0.5 * chi_square;
    let mut sum = if degrees.is_multiple_of(2) { 0.0 } else { libm::erfc(half.sqrt()) };
    let mut next = degrees % 2;
    while next < degrees {
        let power = 0.5 * next as f64;
        sum += libm::exp(power * libm::log(half) - half - libm::lgamma(power + 1.0));
        next += 2;
    }
    sum.min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tabulated quantiles of 5 %, 1 % and 0.1 %.
    #[test]
    fn tabulated_quantiles_are_exceeded_as_often_as_they_say() {
        for (degrees, quantiles) in [
            (1, [3.841_459, 6.634_897, 10.827_566]),
            (2, [5.991_465, 9.210_340, 13.815_511]),
            (3, [7.814_728, 11.344_867, 16.266_236]),
            (4, [9.487_729, 13.276_704, 18.466_827]),
            (9, [16.918_978, 21.665_994, 27.877_165]),
        ] {
            for (quantile, share) in quantiles.into_iter().zip([0.05, 0.01, 0.001]) {
                let found = chi_square_beyond(quantile, degrees);
                assert!((found / share - 1.0).abs() < 1e-5, "{degrees} {quantile}: {found}");
            }
        }
        assert_eq!([chi_square_beyond(3.0, 0), chi_square_beyond(0.0, 2)], [1.0, 1.0]);
        assert!(chi_square_beyond(1e6, 3) == 0.0 && chi_square_beyond(f64::INFINITY, 2) == 0.0);
    }
}
