//! Checks of the measurements of a calibration before any computation. Diagnostics name the file position of a
//! measurement.

use std::path::PathBuf;

use slipgrid_infer::calibrate::{Measurement, StaticPeak};

use crate::formats::diagnostic::Diagnostic;
use crate::formats::plausible::{
    FORCE, FRICTION, PRESSURE, RATIO, RELATIVE_DEVIATION, SPEED, STRAIN, exchanged_forces, share_of_one,
};
use slipgrid_base::units::{HUMIDITY_PCT, PRESSURE_MPA, SPEED_MM_S, significant, tidy};

mod collinear;

/// A measurement with its file position: a row of a table, or the traces of a condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// The measurement.
    pub measurement: Measurement,
    /// File that holds the measurement.
    pub path: PathBuf,
    /// Line in the file, counted from 1.
    pub line: u32,
    /// Distance slid up to the middle of the averaging window, in metres; `None` if unknown.
    pub sliding_m: Option<f64>,
    /// Rank of the measurement in the order in which all measurements were made; `None` if not given.
    pub order: Option<f64>,
}

/// Remarks about measurements that are accepted.
#[derive(Debug, Default)]
pub(crate) struct Remarks {
    /// Diagnostics of unusual values.
    pub(crate) told: Vec<Diagnostic>,
    /// Ratios that are probably mistakes.
    pub(crate) doubts: Vec<Diagnostic>,
    /// Rows that repeat the numbers of another row.
    pub(crate) repeated: Vec<Diagnostic>,
}

impl Remarks {
    /// Texts of `doubts` and `repeated`, each preceded by the name of the warning.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let doubts = self.doubts.iter().map(|doubt| format!("measured ratio: {doubt}"));
        doubts.chain(self.repeated.iter().map(|repeated| format!("repeated row: {repeated}"))).collect()
    }
}

/// Relative difference up to which a pressure counts as the pressure at which a flat sample was measured, because forces
/// are set in round numbers. Friction changes by at most a tenth of this difference.
const SET_PRESSURE_TOLERANCE: f64 = 0.01;

/// If the highest pressure of a table, in MPa, is below this value, forces are probably in another unit: flat faces
/// usually bear a higher pressure.
const LOW_PRESSURE_MPA: f64 = 0.01;
/// If the highest speed of a table, in mm/s, is below this value, speeds are probably in another unit.
const LOW_SPEED_MM_S: f64 = 0.02;

/// Maximum number of conditions listed in a message.
const MAX_NAMED: usize = 4;

/// Properties of the specimens by which measurements are checked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Specimens {
    /// Area of one specimen's face, in square metres.
    pub area_m2: f64,
    /// Young's modulus, in pascals.
    pub modulus_pa: f64,
}

impl Placed {
    /// Replaces the force on a face of `own` by the force that gives the same pressure on a face of `specimens`. If a
    /// `flat` sample was measured at nearly this force, the force on the flat sample is used.
    pub(crate) fn on(&self, own: &Specimens, specimens: &Specimens, flat: &[Self]) -> Self {
        let mut row = self.clone();
        // P = F / A
        let force_n = row.measurement.force_n * specimens.area_m2 / own.area_m2;
        let off = |other: &f64| (other / force_n - 1.0).abs();
        let forces = flat.iter().map(|other| other.measurement.force_n);
        let nearest =
            forces.min_by(|a, b| off(a).total_cmp(&off(b))).filter(|other| off(other) <= SET_PRESSURE_TOLERANCE);
        row.measurement.force_n = nearest.unwrap_or(force_n);
        row
    }

    /// Creates a diagnostic at `key` of the measurement, with `value` in the unit of the key and no reason yet.
    pub fn at(&self, key: &str, value: f64) -> Diagnostic {
        Diagnostic {
            line: Some(self.line),
            key: Some(key.into()),
            // A trace gives more digits than it knows.
            value: Some(significant(value, 6).to_string().into()),
            ..Diagnostic::file(&self.path, "")
        }
    }

    /// Describes force, speed and humidity of the measurement in words.
    pub fn condition(&self) -> String {
        self.measurement.condition_in_words()
    }
}

/// Checks `rows`, the measurements on one kind of sample; returns diagnostics of unusual values.
///
/// # Errors
/// [`Diagnostic`] at file and line of the first measurement that is impossible or unusable.
pub fn check(rows: &[Placed], specimens: &Specimens) -> Result<Vec<Diagnostic>, Diagnostic> {
    let mut told = Vec::new();
    for row in rows {
        let measured = &row.measurement;
        let speed_mm_s = SPEED_MM_S.from_si(measured.speed_m_s);
        let pressure_pa = measured.force_n / specimens.area_m2;
        let pressure_mpa = PRESSURE_MPA.from_si(pressure_pa);
        let by_area = |value: f64, of: &str| {
            let mut at = row.at("force_n", measured.force_n);
            let digits = if (0.01..1e4).contains(&value) { format!("{value:.3}") } else { format!("{value:.2e}") };
            at.value = Some(format!("{} ({digits} {of}, on the specimen's area)", measured.force_n).into());
            at
        };
        told.extend(FORCE.check(measured.force_n, || row.at("force_n", measured.force_n))?);
        told.extend(SPEED.check(speed_mm_s, || row.at("speed_mm_s", speed_mm_s))?);
        told.extend(PRESSURE.check(pressure_mpa, || by_area(pressure_mpa, "MPa"))?);
        let strain = pressure_pa / specimens.modulus_pa;
        let strained = STRAIN.check(strain, || by_area(strain, "of Young's modulus"));
        told.extend(strained.map_err(|refused| match (FORCE.slip(measured.force_n), refused.expected.clone()) {
            (Some(slip), Some(expected)) => refused.expected(format!("{expected}; {slip}")),
            _ => refused,
        })?);
        told.extend(FRICTION.check(measured.mu_dynamic, || row.at("mu_dynamic", measured.mu_dynamic))?);
        told.extend(check_deviation(
            row,
            ["mu_dynamic", "mu_dynamic_std"],
            [measured.mu_dynamic, measured.mu_dynamic_std],
        )?);
        if let Some(StaticPeak { mu: peak, std }) = measured.static_peak {
            told.extend(FRICTION.check(peak, || row.at("mu_static", peak))?);
            told.extend(check_deviation(row, ["mu_static", "mu_static_std"], [peak, std])?);
            if peak <= measured.mu_dynamic {
                let reason = format!("is no static peak: dynamic friction is {}", measured.mu_dynamic);
                return Err(Diagnostic { reason, ..row.at("mu_static", peak) }
                    .expected("more than mu_dynamic, or nothing in mu_static and mu_static_std of this row"));
            }
        }
    }
    told.extend(low_force(rows, specimens).into_iter().chain(low_speed(rows)).chain(low_humidity(rows)));
    told.extend(high_friction(rows).into_iter().chain(collinear::check(rows)));
    Ok(told)
}

/// Checks the standard deviation `std` of a friction coefficient with the mean `mean`; `keys` are their columns. Returns
/// a warning if their ratio is unusual.
///
/// # Errors
/// [`Diagnostic`] at the standard deviation if the ratio cannot be measured.
fn check_deviation(
    row: &Placed,
    [of, key]: [&str; 2],
    [mean, std]: [f64; 2],
) -> Result<Option<Diagnostic>, Diagnostic> {
    RELATIVE_DEVIATION.check(std / mean, || row.at(key, std)).map_err(|refused| {
        let reason = format!(
            "is {} times the {of} {}, which {}",
            significant(std / mean, 3),
            significant(mean, 6),
            refused.reason
        );
        let is_exchanged = std > mean && RELATIVE_DEVIATION.judge(mean / std) == Ok(None);
        let place = format!("; with {of} and {key} in each other's place it is {}", significant(mean / std, 3));
        let expected = refused.expected.as_deref().unwrap_or_default().to_owned();
        let expected = expected + if is_exchanged { &place } else { "" };
        Diagnostic { reason, ..refused }.expected(expected)
    })
}

/// Warns, at the row of the greatest friction, if friction is so high in nearly all `rows` that friction force and
/// normal force are probably swapped; otherwise `None`.
fn high_friction(rows: &[Placed]) -> Option<Diagnostic> {
    let (row, mu_dynamic) = greatest(rows, |measured| measured.mu_dynamic)?;
    let friction: Vec<f64> = rows.iter().map(|row| row.measurement.mu_dynamic).collect();
    Some(Diagnostic { reason: exchanged_forces(&friction)?, ..row.at("mu_dynamic", mu_dynamic) })
}

/// Row with the greatest of the values that `of` takes from the measurements, and this value; `None` without rows.
fn greatest(rows: &[Placed], of: fn(&Measurement) -> f64) -> Option<(&Placed, f64)> {
    let values = rows.iter().map(|row| (row, of(&row.measurement)));
    values.max_by(|(_, a), (_, b)| a.total_cmp(b))
}

/// Warns, at the row of the greatest force, if the forces in all `rows` are so low that the unit is probably kN;
/// otherwise `None`.
fn low_force(rows: &[Placed], specimens: &Specimens) -> Option<Diagnostic> {
    let (row, force_n) = greatest(rows, |measured| measured.force_n)?;
    let pressure_mpa = PRESSURE_MPA.from_si(force_n / specimens.area_m2);
    let is_usual = FORCE.judge(force_n) == Ok(None) && PRESSURE.judge(pressure_mpa) == Ok(None);
    let slip = FORCE.greater(force_n).filter(|_| is_usual && pressure_mpa < LOW_PRESSURE_MPA)?;
    let reason = format!(
        "is the greatest of its table and presses the specimen with {} MPa, less than the {LOW_PRESSURE_MPA} MPa from which on most samples \
         are measured; {slip}",
        significant(pressure_mpa, 3)
    );
    Some(Diagnostic { reason, ..row.at("force_n", force_n) })
}

/// Warns, at the row of the greatest speed, if the speeds in all `rows` are so low that the unit is probably m/s;
/// otherwise `None`.
fn low_speed(rows: &[Placed]) -> Option<Diagnostic> {
    let (row, speed_m_s) = greatest(rows, |measured| measured.speed_m_s)?;
    let speed_mm_s = SPEED_MM_S.from_si(speed_m_s);
    let is_usual = SPEED.judge(speed_mm_s) == Ok(None);
    let slip = SPEED.greater(speed_mm_s).filter(|_| is_usual && speed_mm_s < LOW_SPEED_MM_S)?;
    let reason = format!(
        "is the greatest of its table, less than the {LOW_SPEED_MM_S} mm/s from which on most samples are measured; {slip}"
    );
    Some(Diagnostic { reason, ..row.at("speed_mm_s", speed_mm_s) })
}

/// Warns, at the row of the greatest humidity, if humidities in all `rows` are so low that they are probably fractions
/// of 1; otherwise `None`.
fn low_humidity(rows: &[Placed]) -> Option<Diagnostic> {
    let (row, humidity) = greatest(rows, |measured| measured.humidity)?;
    let humidity_pct = tidy(HUMIDITY_PCT.from_si(humidity));
    let reason = format!("is the greatest of its table, {}", share_of_one(humidity_pct)?);
    Some(Diagnostic { reason, ..row.at("humidity_pct", humidity_pct) })
}

/// Warns of `rows` of a patterned sample for which no `flat` sample was measured at equal force, speed and humidity:
/// such rows have no ratio and are left out. Forces in `rows` refer to the face of the calibration's specimen;
/// `written` holds the same rows with forces as in their table.
///
/// # Errors
/// [`Diagnostic`] if no row has a matching flat sample.
pub fn check_partners(rows: &[Placed], written: &[Placed], flat: &[Placed]) -> Result<Vec<Diagnostic>, Diagnostic> {
    let is_alone = |row: &Placed| !flat.iter().any(|other| other.measurement.is_at(&row.measurement));
    let alone: Vec<(&Placed, &Placed)> = rows.iter().zip(written).filter(|(row, _)| is_alone(row)).collect();
    if alone.is_empty() {
        return Ok(Vec::new());
    }
    let named = |(row, written): &(&Placed, &Placed), so: &str| {
        let own = row.measurement;
        // Humidity or speed is at fault if a flat sample differs by nothing else.
        let differs = |but: fn(Measurement, &Measurement) -> Measurement| -> Vec<&Placed> {
            flat.iter().filter(|other| other.measurement.is_at(&but(own, &other.measurement))).collect()
        };
        let by_humidity = differs(|own, other| Measurement { humidity: other.humidity, ..own });
        let by_speed = differs(|own, other| Measurement { speed_m_s: other.speed_m_s, ..own });
        let (key, value, beside) = if !by_humidity.is_empty() {
            ("humidity_pct", HUMIDITY_PCT.from_si(own.humidity), by_humidity)
        } else if !by_speed.is_empty() {
            ("speed_mm_s", SPEED_MM_S.from_si(own.speed_m_s), by_speed)
        } else {
            ("force_n", written.measurement.force_n, flat.iter().collect())
        };
        let measured = beside.iter().take(MAX_NAMED).map(|row| row.condition()).collect::<Vec<_>>().join("; ");
        let more =
            if beside.len() > MAX_NAMED { format!("; {} more", beside.len() - MAX_NAMED) } else { String::new() };
        let (mut reason, mut there) = (String::new(), "");
        if key == "force_n" && (own.force_n / written.measurement.force_n - 1.0).abs() > SET_PRESSURE_TOLERANCE {
            reason = format!("N on this face press as {} N do on the calibration's: it ", significant(own.force_n, 6));
            there = ", with forces on the calibration's face";
        }
        reason += &format!("has no flat sample beside it, measured at {}: {so}", row.condition());
        let at = Diagnostic { reason, ..row.at(key, value) };
        at.expected(format!("a condition of the flat samples{there}: {measured}{more}"))
    };
    if alone.len() == rows.len() {
        return Err(named(&alone[0], "no row of this sample has a ratio"));
    }
    Ok(alone.iter().map(|row| named(row, "this row has no ratio and is left out")).collect())
}

/// Warns of `rows` of a patterned sample whose ratio to the friction of the `flat` sample is probably a mistake.
pub fn doubtful_ratios(rows: &[Placed], flat: &[Placed]) -> Vec<Diagnostic> {
    let doubtful = |row: &Placed| {
        let partner = flat.iter().find(|other| other.measurement.is_at(&row.measurement))?;
        let ratio = row.measurement.mu_dynamic / partner.measurement.mu_dynamic;
        // Rounded to the digits of the message.
        RATIO.tell((ratio * 1e3).round() / 1e3, || {
            let [own, flat] = [row, partner].map(|row| significant(row.measurement.mu_dynamic, 6));
            let place = format!("{}:{}", partner.path.display(), partner.line);
            let mut at = row.at("mu_dynamic", row.measurement.mu_dynamic);
            at.value = Some(format!("{own} ({ratio:.3} times {flat} of the flat sample, {place})").into());
            at
        })
    };
    rows.iter().filter_map(doubtful).collect()
}

/// Refuses two `rows` at one condition. Used for flat samples if coefficients are fitted per condition, and for each
/// cut sample, whose two ratios would count as independent.
///
/// # Errors
/// [`Diagnostic`] at the second occurrence.
pub fn refuse_repeated(rows: &[Placed]) -> Result<(), Diagnostic> {
    for (place, row) in rows.iter().enumerate() {
        if let Some(first) = rows[..place].iter().find(|first| first.measurement.is_at(&row.measurement)) {
            let reason = format!("has {} again, as line {} has", row.condition(), first.line);
            return Err(Diagnostic { line: Some(row.line), ..Diagnostic::file(&row.path, reason) }
                .expected("one row a condition: mean and standard deviation of its repeats"));
        }
    }
    Ok(())
}

/// Warns of each of the `rows` that has the numbers of an earlier row or of one of `others`: a repeated measurement
/// would differ by its scatter. A single row may equal a row of another table by chance, within the written digits, so
/// that at least two rows must.
pub(crate) fn identical(others: &[Placed], rows: &[Placed]) -> Vec<Diagnostic> {
    let same = |place: usize| {
        let row = &rows[place];
        let first = others.iter().chain(&rows[..place]).find(|first| first.measurement == row.measurement)?;
        Some((first, row))
    };
    let found: Vec<(&Placed, &Placed)> = (0..rows.len()).filter_map(same).collect();
    let least = rows.len().min(2);
    let is_meant = |(first, row): &&(&Placed, &Placed)| {
        let alike = found.iter().filter(|(other, of)| (&other.path, &of.path) == (&first.path, &row.path)).count();
        first.path == row.path || alike >= least
    };
    let told = found.iter().filter(is_meant).map(|(first, row)| {
        let what = match (first.path == row.path, first.line) {
            (true, line) if line == row.line => "is read a second time".to_owned(),
            (true, line) => format!("has the same numbers as line {line}"),
            (false, line) => format!("has the same numbers as line {line} of {}", first.path.display()),
        };
        let (condition, mu) = (row.condition(), row.measurement.mu_dynamic);
        let reason = format!("{what}, {condition} with mu_dynamic = {mu}, and counts as a measurement of its own");
        let refused = Diagnostic { line: Some(row.line), ..Diagnostic::file(&row.path, reason) };
        refused.expected("each measurement once: two measurements differ by their scatter")
    });
    told.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A row of a table.
    fn row_of(force_n: f64, speed_m_s: f64, line: u32) -> Placed {
        let measurement = Measurement {
            force_n,
            speed_m_s,
            humidity: 0.5,
            mu_dynamic: 0.27,
            mu_dynamic_std: 0.003,
            static_peak: None,
        };
        Placed { measurement, path: PathBuf::from("flat.csv"), line, sliding_m: None, order: None }
    }

    #[test]
    fn computed_friction_is_shown_with_the_digits_that_it_has() {
        let mut row = row_of(50.0, 2e-3, 2);
        (row.measurement.mu_dynamic, row.measurement.mu_dynamic_std) = (0.358_159_562_345, 29.7e-9);
        let refused =
            check_deviation(&row, ["mu_dynamic", "mu_dynamic_std"], [0.358_159_562_345, 29.7e-9]).unwrap_err();
        let said = "mu_dynamic_std: 0.0000000297 is 0.0000000829 times the mu_dynamic 0.35816, which";
        assert!(refused.to_string().contains(said), "{refused}");
        row.measurement.force_n = 5e3 / 9.0;
        assert_eq!(row.condition(), "555.556 N, 2 mm/s, 50 %");
    }

    #[test]
    fn forces_in_kilonewtons_and_speeds_in_metres_a_second_are_asked_about() {
        let specimens = Specimens { area_m2: 78.5e-6, modulus_pa: 380e6 };
        let said = |rows: &[Placed]| -> Vec<String> {
            check(rows, &specimens).unwrap().iter().map(Diagnostic::to_string).collect()
        };
        let kilonewtons = said(&[row_of(0.05, 2e-3, 2), row_of(0.2, 0.4e-3, 3)]);
        assert_eq!(kilonewtons.len(), 1, "{kilonewtons:?}");
        assert!(kilonewtons[0].starts_with("flat.csv:3: force_n: 0.2 is the greatest of its table"), "{kilonewtons:?}");
        assert!(kilonewtons[0].contains("0.00255 MPa") && kilonewtons[0].ends_with("in kN, that would be 200 N"));
        let refused = check(&[row_of(50e3, 2e-3, 2)], &specimens).unwrap_err().to_string();
        assert!(refused.ends_with("in mN, that would be 50 N"), "{refused}");
        let metres = said(&[row_of(50.0, 4e-6, 2), row_of(200.0, 2e-6, 3)]);
        assert_eq!(metres.len(), 1, "{metres:?}");
        assert!(metres[0].starts_with("flat.csv:2: speed_mm_s: 0.004 is the greatest of its table"), "{metres:?}");
        assert!(metres[0].ends_with("in m/s, that would be 4 mm/s"), "{metres:?}");
        // One usual row is sufficient; a small pin bears a small force.
        assert_eq!(said(&[row_of(0.2, 4e-6, 2), row_of(50.0, 2e-3, 3)]), Vec::<String>::new());
        let pin = Specimens { area_m2: 1e-6, ..specimens };
        assert_eq!(check(&[row_of(0.2, 2e-3, 2)], &pin).unwrap(), []);
    }

    #[test]
    fn a_mean_and_a_deviation_in_each_others_place_are_refused_by_their_ratio() {
        let specimens = Specimens { area_m2: 78.5e-6, modulus_pa: 380e6 };
        let refused = |mu_dynamic: f64, mu_dynamic_std: f64| {
            let mut row = row_of(50.0, 2e-3, 2);
            row.measurement = Measurement { mu_dynamic, mu_dynamic_std, ..row.measurement };
            check(&[row], &specimens).unwrap_err().to_string()
        };
        let exchanged = refused(0.005, 0.25);
        assert!(
            exchanged.starts_with("flat.csv:2: mu_dynamic_std: 0.25 is 50 times the mu_dynamic 0.005, which lies"),
            "{exchanged}"
        );
        assert!(
            exchanged.ends_with("with mu_dynamic and mu_dynamic_std in each other's place it is 0.02"),
            "{exchanged}"
        );
        assert!(!refused(0.25, 0.3).contains("place"), "{}", refused(0.25, 0.3));
    }

    #[test]
    fn humidities_as_shares_of_1_are_asked_about() {
        let specimens = Specimens { area_m2: 78.5e-6, modulus_pa: 380e6 };
        let said = |humidities: &[f64]| -> Vec<String> {
            let row = |(line, humidity): (u32, &f64)| {
                let mut row = row_of(50.0, 2e-3, line);
                row.measurement.humidity = *humidity;
                row
            };
            let rows: Vec<Placed> = (2..).zip(humidities).map(row).collect();
            check(&rows, &specimens).unwrap().iter().map(Diagnostic::to_string).collect()
        };
        assert_eq!(
            said(&[0.004, 0.0045]),
            [
                "flat.csv:3: humidity_pct: 0.45 is the greatest of its table, at most 1 %, and only dried gas has so little; as a share of 1, \
              that would be 45 %"
            ]
        );
        assert_eq!(said(&[0.0]), Vec::<String>::new());
        assert_eq!(said(&[0.004, 0.5]), Vec::<String>::new());
    }

    #[test]
    fn a_row_without_a_partner_is_named_with_the_force_of_its_own_table() {
        let [own, face] = [0.25, 1.0].map(|share| Specimens { area_m2: share * 78.5e-6, modulus_pa: 380e6 });
        let flat = [row_of(50.0, 2e-3, 2), row_of(200.0, 2e-3, 3)];
        let written = [row_of(12.5, 2e-3, 2), row_of(60.0, 2e-3, 4)];
        let on_face: Vec<Placed> = written.iter().map(|row| row.on(&own, &face, &flat)).collect();
        let said: Vec<String> =
            check_partners(&on_face, &written, &flat).unwrap().iter().map(Diagnostic::to_string).collect();
        assert_eq!(said.len(), 1);
        assert!(
            said[0].starts_with(
                "flat.csv:4: force_n: 60 N on this face press as 240 N do on the calibration's: it has no flat sample beside it, measured at 240 N"
            ),
            "{said:?}"
        );
        assert!(said[0].contains("the flat samples, with forces on the calibration's face: 50 N"), "{said:?}");
        // Where force and speed are those of a flat sample, humidity is named.
        let mut humid = written[0].clone();
        humid.measurement.force_n = 50.2;
        humid.measurement.humidity += 0.01;
        let on_face = [humid.on(&face, &face, &flat)];
        let refused = check_partners(&on_face, &[humid], &flat).unwrap_err().to_string();
        assert!(refused.starts_with("flat.csv:2: humidity_pct: ") && !refused.contains("face"), "{refused}");
        // On a face of the calibration's size no force is converted.
        let refused = check_partners(&written[1..], &written[1..], &flat).unwrap_err().to_string();
        assert!(refused.starts_with("flat.csv:4: force_n: 60 has no flat sample beside it"), "{refused}");
        assert!(!refused.contains("face"), "{refused}");
    }

    #[test]
    fn a_row_that_was_copied_is_named_with_both_lines() {
        let row = |line, mu_dynamic| {
            let mut row = row_of(40.0, 5e-3, line);
            row.measurement.mu_dynamic = mu_dynamic;
            row
        };
        // Repeats of a condition differ by their scatter.
        assert_eq!(identical(&[], &[row(2, 0.27), row(3, 0.271)]), []);
        let of_cut = |line, mu_dynamic| Placed { path: PathBuf::from("cut.csv"), ..row(line, mu_dynamic) };
        let rows = [row(2, 0.27), row(3, 0.271), row(5, 0.27), row(6, 0.29), of_cut(4, 0.271), of_cut(5, 0.29)];
        let said: Vec<String> = identical(&[], &rows).iter().map(Diagnostic::to_string).collect();
        assert!(
            said[0]
                .starts_with("flat.csv:5: has the same numbers as line 2, 40 N, 5 mm/s, 50 % with mu_dynamic = 0.27, "),
            "{said:?}"
        );
        assert!(said[1].starts_with("cut.csv:4: has the same numbers as line 3 of flat.csv, "), "{said:?}");
        let twice = identical(&rows, &[of_cut(4, 0.271), of_cut(5, 0.29), of_cut(6, 0.3)]);
        assert!(
            twice[0].to_string().starts_with("cut.csv:4: has the same numbers as line 3 of flat.csv, "),
            "{twice:?}"
        );
        assert_eq!(twice.len(), 2);
        // One of two rows may agree by chance.
        assert_eq!(identical(&rows, &[of_cut(4, 0.271), of_cut(6, 0.3)]), []);
        let twice = identical(&rows[4..], &[of_cut(4, 0.271)]);
        assert!(twice[0].to_string().starts_with("cut.csv:4: is read a second time, 40 N"), "{twice:?}");
        assert_eq!(said.len(), 3);
    }
}
