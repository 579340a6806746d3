//! Statistics of time series with uneven samples.

use std::ops::Range;

use slipgrid_base::statistics::upper_median;

/// Value at the time `t`, interpolated linearly between samples; outside the samples the nearest value.
pub fn value_at(time_s: &[f64], values: &[f64], t: f64) -> f64 {
    let next = time_s.partition_point(|&sample| sample <= t);
    if next == 0 {
        return values[0];
    }
    if next == time_s.len() {
        return values[next - 1];
    }
    let share = (t - time_s[next - 1]) / (time_s[next] - time_s[next - 1]);
    values[next - 1] + share * (values[next] - values[next - 1])
}

/// Mean of `values` over the time from `from` to `to`, interpolated linearly between samples. Outside the samples the
/// nearest value is used.
pub fn mean_between(time_s: &[f64], values: &[f64], from: f64, to: f64) -> f64 {
    let at = |t: f64| value_at(time_s, values, t);
    let inside = time_s.partition_point(|&t| t <= from)..time_s.partition_point(|&t| t < to);
    let (mut last, mut area) = ((from, at(from)), 0.0);
    for i in inside {
        area += (time_s[i] - last.0) * (values[i] + last.1) / 2.0;
        last = (time_s[i], values[i]);
    }
    area += (to - last.0) * (at(to) + last.1) / 2.0;
    area / (to - from)
}

/// Least-squares line through evenly spaced values.
pub struct Line {
    /// Mean of the values.
    pub mean: f64,
    /// Change of the line over as many steps as there are values.
    pub change: f64,
    /// Residual variance about the line.
    pub variance: f64,
}

/// Fits a least-squares line to `values`; the variance is NaN for fewer than three values.
pub fn line_through(values: &[f64]) -> Line {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    // x from -1/2 to 1/2 over the whole interval: change = sum(x y) / sum(x^2).
    let x = |i: usize| (i as f64 + 0.5) / count - 0.5;
    let sum_xx: f64 = (0..values.len()).map(|i| x(i) * x(i)).sum();
    let change = values.iter().enumerate().map(|(i, y)| x(i) * (y - mean)).sum::<f64>() / sum_xx;
    let left: f64 = values.iter().enumerate().map(|(i, y)| (y - mean - change * x(i)).powi(2)).sum();
    let variance = if values.len() < 3 { f64::NAN } else { left / (count - 2.0) };
    Line { mean, change, variance }
}

/// Index of the first maximum of `values` within `range`, which must be within `values` and not empty.
pub fn highest(values: &[f64], range: Range<usize>) -> usize {
    range.clone().fold(range.start, |best, i| if values[i] > values[best] { i } else { best })
}

/// Median, the upper median for an even count; zero for no values.
pub fn median(mut values: Vec<f64>) -> f64 {
    upper_median(&mut values).unwrap_or(0.0)
}

/// Running median of three: removes single outliers and keeps edges.
pub fn median_of_three(values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    (0..values.len())
        .map(|i| {
            let (a, b, c) = (values[i.saturating_sub(1)], values[i], values[(i + 1).min(last)]);
            a.max(b).min(a.min(b).max(c))
        })
        .collect()
}

/// Standard deviation of the noise from sample to sample, from the median of second differences; slow changes and rare
/// jumps have no influence.
pub fn sample_noise(values: &[f64]) -> f64 {
    // y[i-1] - 2 y[i] + y[i+1] of white noise s has the standard deviation sqrt(6) s, and the median of its amount is
    // 0.67449 times that.
    let second = values.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).abs()).collect();
    median(second) / (0.674_489_75 * 6.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_line_is_exact_between_samples() {
        let time = [0.0, 1.0, 1.5, 4.0];
        let values = time.map(|t| 2.0 + 3.0 * t);
        assert!((mean_between(&time, &values, 0.25, 3.75) - 8.0).abs() < 1e-12);
        assert!((mean_between(&time, &values, 1.1, 1.2) - 5.45).abs() < 1e-12);
    }

    #[test]
    fn medians_remove_outliers() {
        assert_eq!(median_of_three(&[1.0, 9.0, 1.0, 2.0, 2.0, -5.0]), [1.0, 1.0, 2.0, 2.0, 2.0, -5.0]);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), 2.0);
    }

    #[test]
    fn noise_is_found_under_a_sawtooth() {
        let mut noise = slipgrid_base::statistics::Noise::new(3);
        let values: Vec<f64> = (0..3000).map(|i| f64::from(i % 60) * 1e-3 + 2e-3 * noise.normal()).collect();
        assert!((sample_noise(&values) / 2e-3 - 1.0).abs() < 0.07, "{}", sample_noise(&values));
    }
}
