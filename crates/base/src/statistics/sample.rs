//! Median, mean and standard deviation of a sample.

/// Median of `values`, for an even count the larger of the two middle values; `None` for an empty slice. Reorders
/// `values`.
pub fn upper_median(values: &mut [f64]) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Median of `values`, for an even count the mean of the two middle values; `None` for an empty slice. Reorders
/// `values`.
pub fn median(values: &mut [f64]) -> Option<f64> {
    let upper = upper_median(values)?;
    if !values.len().is_multiple_of(2) {
        return Some(upper);
    }
    let lower = values[..values.len() / 2].iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Some(0.5 * (lower + upper))
}

/// Smallest and largest of `values`; infinities of the opposite sign without values.
pub fn extremes(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let wider = |[least, most]: [f64; 2], value: f64| [least.min(value), most.max(value)];
    values.into_iter().fold([f64::INFINITY, f64::NEG_INFINITY], wider)
}

/// Mean and, for two or more values, standard deviation (n - 1) of a sample; `None` for an empty sample.
pub fn mean_and_std<I>(values: I) -> Option<(f64, Option<f64>)>
where
    I: IntoIterator<Item = f64>,
    I::IntoIter: Clone,
{
    let values = values.into_iter();
    let count = values.clone().count();
    if count == 0 {
        return None;
    }
    let mean = values.clone().sum::<f64>() / count as f64;
    let squares: f64 = values.map(|value| (value - mean).powi(2)).sum();
    Some((mean, (count > 1).then(|| (squares / (count as f64 - 1.0)).sqrt())))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians() {
        assert_eq!(median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(&mut [4.0, 1.0, 3.0, 2.0]), Some(2.5));
        assert_eq!(median(&mut []), None);
        assert_eq!(upper_median(&mut [3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(upper_median(&mut [4.0, 1.0, 3.0, 2.0]), Some(3.0));
        assert_eq!(upper_median(&mut []), None);
    }

    #[test]
    fn one_value_has_no_scatter() {
        assert_eq!((mean_and_std([]), mean_and_std([2.0])), (None, Some((2.0, None))));
        assert_eq!(mean_and_std([1.0, 3.0]), Some((2.0, Some(2.0_f64.sqrt()))));
    }
}
