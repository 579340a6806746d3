//! Patterned samples beside the model: a table to read and one to compute with.

use slipgrid_calibrate::{PatternedSamples, RatioAtCondition, RatioInterval, uncorrected};
use slipgrid_results::Table;
use slipgrid_results::fixed;
use slipgrid_units::{HUMIDITY_PCT, SPEED_MM_S, tidy};

/// Measured ratios beside predicted ones.
#[must_use]
pub fn table(found: &PatternedSamples) -> String {
    let mut table = Table::new([
        "F N",
        "v mm/s",
        "RH %",
        "ratio",
        "+-",
        "model",
        "95 % by modulus",
        "without this one",
        "95 %",
        "its humidity alone",
        "95 %",
    ]);
    for row in &found.rows {
        let point = &row.point;
        let bare = uncorrected(point.modelled, point.modulus_sensitivity, found.modulus_relative_std);
        table.row([
            row.flat.force_n.to_string(),
            SPEED_MM_S.from_si(row.flat.speed_m_s).to_string(),
            HUMIDITY_PCT.from_si(row.flat.humidity).to_string(),
            fixed(Some(point.measured), 3),
            fixed(Some(point.measured_std), 3),
            fixed(Some(point.modelled), 3),
            ends(Some(bare)),
            fixed(row.left_out.map(|found| found.ratio), 3),
            marked(row.left_out, point.measured),
            fixed(row.left_out_at_humidity.map(|found| found.ratio), 3),
            marked(row.left_out_at_humidity, point.measured),
        ]);
    }
    format!("{table}{}\n", coverage(found))
}

fn coverage(found: &PatternedSamples) -> String {
    let count = |left_out: fn(&RatioAtCondition) -> Option<RatioInterval>| {
        let inside = |row| left_out(row).map(|found| within(&found, row.point.measured));
        let told: Vec<bool> = found.rows.iter().filter_map(inside).collect();
        format!("{} of {}", told.iter().filter(|inside| **inside).count(), told.len())
    };
    format!(
        "measured ratios within the interval predicted without them: {} by all conditions, {} by their humidity's; ! marks those outside. Scatter between conditions {:.3}",
        count(|row| row.left_out),
        count(|row| row.left_out_at_humidity),
        found.discrepancies.all.scatter
    )
}

/// The same as [`table`] as CSV.
#[must_use]
pub fn csv(found: &PatternedSamples) -> String {
    let mut text = String::from(
        "force_n,speed_mm_s,humidity_pct,ratio,ratio_std,modelled,modulus_sensitivity,left_out,left_out_low,left_out_high,\
         left_out_humidity,left_out_humidity_low,left_out_humidity_high\n",
    );
    let three = |found: Option<RatioInterval>| {
        let numbers = found.map(|found| [found.ratio, found.interval[0], found.interval[1]]);
        let cells = numbers.map_or([const { String::new() }; 3], |all| all.map(|value| tidy(value).to_string()));
        cells.join(",")
    };
    for row in &found.rows {
        let point = &row.point;
        text += &format!(
            "{},{},{},{},{},{},{},{},{}\n",
            row.flat.force_n,
            SPEED_MM_S.from_si(row.flat.speed_m_s),
            HUMIDITY_PCT.from_si(row.flat.humidity),
            tidy(point.measured),
            tidy(point.measured_std),
            tidy(point.modelled),
            tidy(point.modulus_sensitivity),
            three(row.left_out),
            three(row.left_out_at_humidity),
        );
    }
    text
}

fn within(found: &RatioInterval, measured: f64) -> bool {
    (found.interval[0]..=found.interval[1]).contains(&measured)
}

fn ends(found: Option<RatioInterval>) -> String {
    found.map_or_else(|| "-".to_owned(), |found| format!("{:.3}-{:.3}", found.interval[0], found.interval[1]))
}

/// The interval, with a mark where the measured ratio lies outside.
fn marked(found: Option<RatioInterval>, measured: f64) -> String {
    let outside = found.is_some_and(|found| !within(&found, measured));
    format!("{}{}", if outside { "! " } else { "" }, ends(found))
}
