//! Warns where the measurements of a sample cannot separate two influences on friction.

use crate::formats::diagnostic::Diagnostic;
use crate::formats::measured::Placed;
use slipgrid_base::units::{LENGTH_MM, SPEED_MM_S, significant, tidy};

/// Correlation at or above which two influences cannot be separated. At 0.95 the standard error of either effect is
/// three times as large as without correlation.
const COLLINEAR: f64 = 0.95;
/// Minimum ratio of the highest to the lowest speed for a warning about speed and sliding distance.
const SPEEDS_APART: f64 = 1.05;
/// Minimum number of rows with a known order of runs for a warning about load and order.
const MIN_ORDERED: usize = 3;

/// Warns if sliding distance rises with speed, or load rises or falls with the order of the runs, in `rows`, all of one
/// kind of sample.
pub(super) fn check(rows: &[Placed]) -> Vec<Diagnostic> {
    speed_and_distance(rows).into_iter().chain(load_and_order(rows)).collect()
}

fn speed_and_distance(rows: &[Placed]) -> Option<Diagnostic> {
    let points: Vec<(f64, f64)> =
        rows.iter().map(|row| Some((row.measurement.speed_m_s, row.sliding_m?))).collect::<Option<_>>()?;
    let by_speed = |a: &&(f64, f64), b: &&(f64, f64)| a.0.total_cmp(&b.0);
    let (slow, fast) = (points.iter().min_by(by_speed)?, points.iter().max_by(by_speed)?);
    let logs: Vec<[f64; 2]> =
        points.iter().map(|(speed, distance)| [libm::log(*speed), libm::log(*distance)]).collect();
    if fast.0 < SPEEDS_APART * slow.0 || correlation(&logs) < COLLINEAR {
        return None;
    }
    let named = |(speed_m_s, distance_m): &(f64, f64)| {
        let [distance, speed] = [LENGTH_MM.from_si(*distance_m), SPEED_MM_S.from_si(*speed_m_s)];
        format!("{} mm at {} mm/s", tidy(significant(distance, 3)), tidy(significant(speed, 3)))
    };
    let reason = format!(
        "sliding distance rises with speed, {} and {}: an effect of speed cannot be told from run-in",
        named(slow),
        named(fast)
    );
    Some(at_first(rows, reason).expected("averaging windows at equal distances, sliding_mm, at every speed"))
}

fn load_and_order(rows: &[Placed]) -> Option<Diagnostic> {
    let mut ranks = Vec::new();
    for (place, row) in rows.iter().enumerate() {
        let own = &row.measurement;
        let is_alike =
            |other: &Placed| other.measurement.speed_m_s == own.speed_m_s && other.measurement.humidity == own.humidity;
        // Each speed and humidity once, at its first row.
        if rows[..place].iter().any(is_alike) {
            continue;
        }
        let group: Vec<[f64; 2]> = rows
            .iter()
            .filter(|other| is_alike(other))
            .map(|other| Some([other.measurement.force_n, other.order?]))
            .collect::<Option<_>>()?;
        if group.len() < 2 {
            continue;
        }
        let centred = |axis: usize, at: &[f64; 2]| {
            let below = group.iter().filter(|other| other[axis] < at[axis]).count() as f64;
            below - group.iter().filter(|other| other[axis] > at[axis]).count() as f64
        };
        ranks.extend(group.iter().map(|at| [centred(0, at), centred(1, at)]));
    }
    let correlated = correlation(&ranks);
    if ranks.len() < MIN_ORDERED || correlated.abs() < COLLINEAR {
        return None;
    }
    let how = if correlated > 0.0 { "rise" } else { "fall" };
    let reason =
        format!("loads {how} with the order of the runs: an effect of load cannot be told from wear or run-in");
    Some(at_first(rows, reason).expected("loads in random order"))
}

/// Diagnostic with `reason` at the first row.
fn at_first(rows: &[Placed], reason: String) -> Diagnostic {
    let (path, line) = rows.first().map_or_else(Default::default, |row| (row.path.clone(), row.line));
    Diagnostic { line: Some(line), ..Diagnostic::file(&path, reason) }
}

/// Pearson correlation of the two coordinates of `points`; 0 if a coordinate is constant.
fn correlation(points: &[[f64; 2]]) -> f64 {
    let mean = |axis: usize| points.iter().map(|at| at[axis]).sum::<f64>() / points.len().max(1) as f64;
    let means = [mean(0), mean(1)];
    let moment = |a: usize, b: usize| points.iter().map(|at| (at[a] - means[a]) * (at[b] - means[b])).sum::<f64>();
    let found = moment(0, 1) / (moment(0, 0) * moment(1, 1)).sqrt();
    if found.is_finite() { found } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::measurements;
    use std::path::Path;

    /// Warnings about a table with these rows of force, speed, distance and order.
    fn told(rows: &str) -> Vec<String> {
        let header = "force_n,speed_mm_s,sliding_mm,order,humidity_pct,mu_dynamic,mu_dynamic_std";
        let row = |row: &str| format!("{row},15,0.25,0.002");
        let text = format!("{header}\n{}\n", rows.split(' ').map(row).collect::<Vec<_>>().join("\n"));
        let rows = measurements::parse(Path::new("flat.csv"), &text).unwrap();
        check(&rows).iter().map(Diagnostic::to_string).collect()
    }

    #[test]
    fn speed_and_distance_that_rise_together_are_named() {
        let equal_times = told("100,0.4,10,1 100,2,50,3 100,4,100,2");
        assert_eq!(equal_times.len(), 1, "{equal_times:?}");
        assert!(
            equal_times[0]
                .starts_with("flat.csv:2: sliding distance rises with speed, 10 mm at 0.4 mm/s and 100 mm at 4 mm/s"),
            "{equal_times:?}"
        );
        assert_eq!(told("100,0.4,50,1 100,2,50,3 100,4,50,2"), [""; 0]);
        // One speed, or distances that nobody wrote down.
        assert_eq!(told("50,2,10,2 100,2,50,3 150,2,100,1"), [""; 0]);
        assert_eq!(told("100,0.4,,1 100,2,50,3 100,4,100,2"), [""; 0]);
    }

    #[test]
    fn loads_in_the_order_of_the_runs_are_named() {
        for (rows, how) in
            [("50,2,9,1 100,2,9,2 150,2,9,3 200,2,9,4", "rise"), ("50,2,9,3 100,2,9,2 150,2,9,1", "fall")]
        {
            let found = told(rows);
            assert!(found[0].contains(&format!("loads {how} with the order of the runs")), "{found:?}");
        }
        // At each of two speeds loads rise, whichever speed was first.
        assert_eq!(told("50,2,9,5 100,2,9,6 150,2,9,7 50,4,9,1 100,4,9,2").len(), 1);
        assert_eq!(told("50,2,9,2 100,2,9,4 150,2,9,1 200,2,9,3"), [""; 0]);
        assert_eq!(told("50,2,9,1 100,2,9,2"), [""; 0]);
    }
}
