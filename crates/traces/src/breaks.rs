//! Breaks of a signal within the window: disturbed readings, and jumps to another level.
//!
//! Noise and stick-slip change a signal by similar amounts all over the window, and a break changes it once. Therefore
//! the largest change between the medians of two neighbouring stretches is compared with the largest changes in other
//! parts of the window. Short stretches show disturbed readings, longer ones show jumps below the noise of readings.

use crate::time_series::{highest, median};
use crate::{FLAGGED_DRIFT, zero::MIN_OFFSET};

/// Number of parts into which the window is cut.
const PARTS: usize = 20;
/// Number of parts that a break may touch. Stick-slip has at least one slip more.
const MAX_BROKEN_PARTS: usize = 3;
/// Minimum ratio of the change at a break to the largest change in the part after the ones that breaks may touch. Of
/// 24 000 windows of white and correlated noise and of stick-slip, in a test, fewer than one in a thousand reaches it.
const MIN_RATIO: f64 = 4.0;
/// Maximum length of a stretch, as a fraction of the window, so that a jump changes no more than three parts.
const MAX_STRETCH: f64 = 1.0 / 20.0;
/// Minimum number of samples on either side of a break from which the levels there are taken.
const MIN_SAMPLES_BESIDE: usize = 5;

/// Break of a signal: in the unit of the signal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Break {
    /// Index of the disturbed sample that is farthest off, or of the first sample after a jump.
    pub(crate) at: usize,
    /// Level before the break, and after it.
    pub levels: [f64; 2],
    /// Value of the disturbed sample; `None` for a jump.
    pub disturbed: Option<f64>,
    /// Change of the mean over the window by the disturbed samples; zero for a jump.
    pub shift: f64,
}

/// Finds the break of `values`, the samples of a window; `None` without one that matters.
pub(crate) fn find_break(values: &[f64]) -> Option<Break> {
    let count = values.len();
    let usual = median(values.to_vec()).abs();
    let longest = (MAX_STRETCH * count as f64) as usize;
    let lengths =
        std::iter::successors(Some(1), |length| Some(3 * length)).take_while(|&length| length <= longest.max(1));
    lengths.into_iter().find_map(|length| {
        let at = lone_change(values, length)?;
        let beside = longest.max(MIN_SAMPLES_BESIDE);
        let around = at.saturating_sub(beside)..(at + beside).min(count);
        let levels = [around.start..at, at..around.end].map(|side| median(values[side].to_vec()));
        let (change, middle) = (levels[1] - levels[0], (levels[0] + levels[1]) / 2.0);
        let off: Vec<f64> = values[around.clone()].iter().map(|value| value - middle).collect();
        let farthest = highest(&off.iter().map(|off| off.abs()).collect::<Vec<_>>(), 0..off.len());
        let shift = off.iter().sum::<f64>() / count as f64;
        if change.abs() < off[farthest].abs() / 2.0 {
            let at = around.start + farthest;
            let found = Break { at, levels, disturbed: Some(values[at]), shift };
            return (shift.abs() >= MIN_OFFSET * usual).then_some(found);
        }
        (change.abs() >= FLAGGED_DRIFT * usual).then_some(Break { at, levels, disturbed: None, shift: 0.0 })
    })
}

/// First sample after the largest change between the medians of stretches of `length` samples, a power of three;
/// `None` if it is no larger than changes in other parts of `values`.
fn lone_change(values: &[f64], length: usize) -> Option<usize> {
    let stride = length.div_ceil(3);
    let levels: Vec<f64> = values.windows(length).step_by(stride).map(|stretch| median(stretch.to_vec())).collect();
    let later = levels.get(length / stride..)?;
    let changes: Vec<f64> = levels.iter().zip(later).map(|(before, after)| (after - before).abs()).collect();
    let mut largest: Vec<f64> =
        changes.chunks(changes.len().div_ceil(PARTS).max(1)).map(|part| part[highest(part, 0..part.len())]).collect();
    largest.sort_by(|a, b| b.total_cmp(a));
    // Rounded signals may not change at all in most parts.
    let step = changes.iter().copied().filter(|change| *change > 0.0).reduce(f64::min)?;
    let usual = largest.get(MAX_BROKEN_PARTS)?.max(step);
    (largest[0] > MIN_RATIO * usual).then(|| highest(&changes, 0..changes.len()) * stride + length)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::red;
    use slipgrid_base::statistics::Noise;

    /// Friction of 0.25 in a window of 30 s with a slip every `period_s`, whose heights and periods scatter by `scatter`.
    fn slips(random: &mut Noise, samples: usize, period_s: f64, scatter: f64) -> Vec<f64> {
        let drawn = |random: &mut Noise| (1.0 + scatter * random.normal()).max(0.4);
        let (mut since_s, mut period, mut height) = (0.0, drawn(random), drawn(random));
        let values = (0..samples).map(|_| {
            since_s += 30.0 / samples as f64;
            while since_s >= period * period_s {
                since_s -= period * period_s;
                (period, height) = (drawn(random), drawn(random));
            }
            0.25 + 0.05 * height * since_s / (period * period_s) + 0.002 * random.normal()
        });
        values.collect()
    }

    #[test]
    fn noise_and_stick_slip_have_no_break() {
        let mut random = Noise::new(5);
        let (mut windows, mut found) = (0, 0);
        let mut judge = |values: &[f64]| {
            windows += 1;
            found += usize::from(find_break(values).is_some());
        };
        for samples in [20, 40, 100, 300, 1000] {
            for round in 0..600 {
                for memory_s in [1e-3, 0.1, 1.0, 5.0] {
                    let noise = red(&mut random, samples, 30.0 / samples as f64, memory_s);
                    judge(&noise.iter().map(|noise| 0.25 + 0.02 * noise).collect::<Vec<f64>>());
                }
                for period_s in [0.13, 0.5, 2.0, 5.0] {
                    judge(&slips(&mut random, samples, period_s, [0.0, 0.1, 0.2][round % 3]));
                }
            }
        }
        assert!(1000 * found <= windows, "{found} of {windows}");
    }

    #[test]
    fn a_reading_that_stands_alone_and_a_jump_are_found_where_they_are() {
        let mut random = Noise::new(6);
        for (samples, pause_s) in [(300, 0.1), (3000, 0.01)] {
            for memory_s in [1e-3, 1.0] {
                let noise = red(&mut random, samples, pause_s, memory_s);
                let steady: Vec<f64> = noise.iter().map(|noise| 0.25 + 0.002 * noise).collect();
                assert_eq!(find_break(&steady), None);
                for lasts in [1, 3] {
                    let mut disturbed = steady.clone();
                    disturbed[100..100 + lasts].iter_mut().for_each(|value| *value += 2.3);
                    let found = find_break(&disturbed).unwrap();
                    assert!((100..100 + lasts).contains(&found.at) && found.disturbed.is_some(), "{found:?}");
                    let shift = 2.3 * lasts as f64 / samples as f64;
                    assert!((found.shift / shift - 1.0).abs() < 0.1 && (found.levels[0] - 0.25).abs() < 0.01);
                }
                let mut jump = steady.clone();
                jump[150..].iter_mut().for_each(|value| *value += 0.09);
                let found = find_break(&jump).unwrap();
                assert!(found.at == 150 && found.disturbed.is_none(), "{found:?}");
                assert!((found.levels[1] - found.levels[0] - 0.09).abs() < 0.01, "{found:?}");
            }
        }
        // A jump of three standard deviations of the readings' noise.
        let mut jump = red(&mut random, 3000, 0.01, 1e-3);
        jump[1200..].iter_mut().for_each(|value| *value += 3.0);
        let found = find_break(&jump.iter().map(|noise| 0.25 + 0.05 * noise).collect::<Vec<f64>>()).unwrap();
        assert!(found.at.abs_diff(1200) < 81 && found.disturbed.is_none(), "{found:?}");
        // One reading that moves the mean by less than a thousandth, and a sensor with two levels.
        let mut small = red(&mut random, 3000, 0.01, 1e-3);
        small.iter_mut().for_each(|value| *value = 0.25 + 1e-4 * *value);
        small[700] += 0.02;
        assert_eq!(find_break(&small), None);
        assert_eq!(find_break(&(0..300).map(|i| if i == 90 { 0.26 } else { 0.25 }).collect::<Vec<f64>>()), None);
    }
}
