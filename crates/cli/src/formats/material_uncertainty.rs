//! What a material file says of its own errors.

use slipgrid_calibrate::uncertainty::{Covariance, Knowledge, ScaleError, with_scale};
use slipgrid_calibrate::{Discrepancy, TrialDomain};
use slipgrid_material::{AreaLaw, Condition, Material, MaterialError, between};
use slipgrid_springblock::Load;
use toml::Spanned;

use super::discrepancy::{Discrepancies, read_discrepancies, read_trials};
use super::document::Document;
use super::file_kind::FileKind;
use super::material::{ConditionTable, FrictionFile, MaterialFile, existing, read_material};
use super::values::{NumberList, Numbers, PathOr, for_each, increasing};
use crate::diagnostic::Diagnostic;
use slipgrid_units::{
    EXCESS, FRICTION, FRICTION_STD, HUMIDITY_PCT, MODULUS_GPA, MODULUS_STD_GPA, PRESSURE_MPA, SPEED_MM_S,
};

/// Errors of a material's numbers, as far as its file has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MaterialUncertainty {
    /// Fitted dynamic coefficients with their standard errors; empty where a file gives none.
    friction: Vec<FrictionError>,
    /// Fitted static coefficients likewise.
    static_friction: Vec<FrictionError>,
    /// Dynamic over steady friction of the flat sample beside the coefficients; empty where a file gives none.
    excess: Vec<FrictionError>,
    /// The file has errors of the coefficients at the given area law beside those whatever it is.
    pub has_marginal_errors: bool,
    /// Standard deviation of Young's modulus over itself.
    pub modulus_relative_std: Option<f64>,
    /// The area law's scale was fitted to friction: the modulus does not move it.
    pub law_is_fitted: bool,
    /// The law is measured flat friction itself: the modulus does not move it either.
    pub law_is_measured: bool,
    /// Covariance of the one relative error of mu_d and of the logarithm of that scale, where both are known.
    pub scale_covariance: Option<[[f64; 2]; 2]>,
    /// Measured over modelled ratio on patterned samples, at every humidity.
    discrepancies: Option<Discrepancies>,
    /// The patterned samples behind it, in words.
    pub discrepancy_pattern: Option<String>,
    /// The patterns that it is used for, where the file says what the samples were.
    pub discrepancy_domain: Option<TrialDomain>,
}

/// A fitted coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
struct FrictionError {
    /// `None` where it holds for any.
    pressure_pa: Option<f64>,
    condition: Option<Condition>,
    mean: f64,
    std_error: f64,
}

/// Reads `file`, in `document`, and what it says of its errors; `place` is where a table stands as a whole.
///
/// # Errors
/// [`Diagnostic`] for anything refused in it.
pub fn read_known(
    document: &Document,
    file: &MaterialFile,
    place: &std::ops::Range<usize>,
) -> Result<(Material, MaterialUncertainty), Diagnostic> {
    Ok((read_material(document, file, place)?, read_uncertainty(document, file)?))
}

/// The same of the material that a key of `document` names or holds.
///
/// # Errors
/// [`Diagnostic`] for a file that cannot be read, or anything refused in it.
pub fn read_referenced(
    document: &Document,
    material: &Spanned<PathOr<MaterialFile>>,
) -> Result<(Material, MaterialUncertainty), Diagnostic> {
    match material.get_ref() {
        PathOr::Table(table) => read_known(document, table, &material.span()),
        PathOr::Path(path) => {
            let named = Document::read(&existing(document, material, path)?, FileKind::Material)?;
            read_known(&named, &named.parse()?, &(0..0))
        }
    }
}

fn read_uncertainty(document: &Document, file: &MaterialFile) -> Result<MaterialUncertainty, Diagnostic> {
    let modulus_pa = document.number(&file.youngs_modulus_gpa, MODULUS_GPA)?;
    let modulus_std_pa = document.optional(file.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?;
    let origin = file.area_law.as_ref().and_then(|law| law.get_ref().origin.as_deref());
    let discrepancies = file.discrepancy.as_ref().map(|table| read_discrepancies(document, table)).transpose()?;
    Ok(MaterialUncertainty {
        friction: friction_errors(document, file.friction.get_ref(), Column::Dynamic)?,
        static_friction: friction_errors(document, file.friction.get_ref(), Column::Static)?,
        excess: friction_errors(document, file.friction.get_ref(), Column::Excess)?,
        has_marginal_errors: {
            let friction = file.friction.get_ref();
            let tables = friction.conditions.iter().map(|table| &table.get_ref().dynamic_std_error_given_law);
            tables.chain([&friction.dynamic_std_error_given_law]).any(Option::is_some)
        },
        modulus_relative_std: modulus_std_pa.map(|std_pa| std_pa / modulus_pa),
        law_is_fitted: origin == Some("fit"),
        law_is_measured: origin == Some("measured"),
        scale_covariance: scale_covariance(document, file.friction.get_ref())?,
        discrepancies,
        discrepancy_domain: file
            .discrepancy
            .as_ref()
            .and_then(|table| read_trials(document, table.get_ref()).transpose())
            .transpose()?,
        discrepancy_pattern: file.discrepancy.as_ref().map(|table| table.get_ref().pattern.clone()),
    })
}

fn scale_covariance(document: &Document, file: &FrictionFile) -> Result<Option<[[f64; 2]; 2]>, Diagnostic> {
    let (Some(given), Some(mean)) = (&file.scale_covariance, &file.dynamic_mean) else { return Ok(None) };
    let refuse = || {
        document
            .refuse(given.span(), "is no covariance of two numbers")
            .expected("[[a, b], [b, c]] with a and c positive and b^2 at most a c, beside one dynamic_mean")
    };
    let (Numbers::One(mean), [first, second]) = (mean.get_ref(), &given.get_ref()[..]) else { return Err(refuse()) };
    let ([a, b], [c, d]) = (&first[..], &second[..]) else { return Err(refuse()) };
    let is_covariance = *a >= 0.0 && *d >= 0.0 && b == c && b * b <= a * d * (1.0 + 1e-9);
    if !(is_covariance && *mean > 0.0) {
        return Err(refuse());
    }
    Ok(Some([[a / (mean * mean), b / mean], [c / mean, *d]]))
}

/// What is read beside a mean coefficient.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Column {
    /// Standard errors of the static coefficients.
    Static,
    /// Those of the dynamic ones at the given area law, which are those of flat friction.
    Dynamic,
    /// Dynamic over steady friction.
    Excess,
}

/// Means of the static coefficients, or of the dynamic ones, with what stands in a column beside them.
fn friction_errors(document: &Document, file: &FrictionFile, column: Column) -> Result<Vec<FrictionError>, Diagnostic> {
    let mut errors = Vec::new();
    for table in &file.conditions {
        let table: &ConditionTable = table.get_ref();
        let condition = Condition {
            speed_m_s: document.number(&table.speed_mm_s, SPEED_MM_S)?,
            humidity: document.number(&table.humidity_pct, HUMIDITY_PCT)?,
        };
        let (mean, beside) = match column {
            Column::Static => (&table.static_mean, &table.static_std_error),
            Column::Dynamic if table.dynamic_std_error_given_law.is_some() => {
                (&table.dynamic_mean, &table.dynamic_std_error_given_law)
            }
            Column::Dynamic => (&table.dynamic_mean, &table.dynamic_std_error),
            Column::Excess => (&table.dynamic_mean, &table.dynamic_over_steady),
        };
        let Some(beside) = beside else { continue };
        errors.extend(rows(document, Some(&table.pressure_mpa), mean, (beside, column), Some(condition))?);
    }
    let (mean, beside) = match column {
        Column::Static => (&file.static_mean, &file.static_std_error),
        Column::Dynamic if file.dynamic_std_error_given_law.is_some() => {
            (&file.dynamic_mean, &file.dynamic_std_error_given_law)
        }
        Column::Dynamic => (&file.dynamic_mean, &file.dynamic_std_error),
        Column::Excess => (&file.dynamic_mean, &file.dynamic_over_steady),
    };
    if let (Some(mean), Some(beside)) = (mean, beside) {
        errors.extend(rows(document, file.pressure_mpa.as_ref(), mean, (beside, column), None)?);
    }
    Ok(errors)
}

fn rows(
    document: &Document,
    pressures: Option<&NumberList>,
    mean: &Spanned<Numbers>,
    (beside, column): (&Spanned<Numbers>, Column),
    condition: Option<Condition>,
) -> Result<Vec<FrictionError>, Diagnostic> {
    let pressures_pa = pressures.map(|list| increasing(document, list, PRESSURE_MPA)).transpose()?;
    let count = pressures_pa.as_ref().map_or(1, Vec::len);
    let means = for_each(document, mean, FRICTION, count, "pressure")?;
    let range = if column == Column::Excess { EXCESS } else { FRICTION_STD };
    let errors = for_each(document, beside, range, count, "pressure")?;
    let row = |place: usize| FrictionError {
        pressure_pa: pressures_pa.as_ref().map(|list| list[place]),
        condition,
        mean: means[place],
        std_error: errors[place],
    };
    Ok((0..count).map(row).collect())
}

impl MaterialUncertainty {
    /// Measured over modelled ratio on patterned samples at a humidity, from 0 to 1: its own where one was estimated, what
    /// lies between those of two about it, that of all conditions otherwise.
    #[must_use]
    pub fn discrepancy_at(&self, humidity: Option<f64>) -> Option<Discrepancy> {
        self.discrepancies.as_ref().map(|found| found.at(humidity))
    }

    /// Covariance of the relative errors of mu_d at `pressures_pa`: fitted coefficients are independent of one another,
    /// what stands between two of them shares both, and one pair for all loads is off alike at all. `None` where the
    /// file has no standard errors for the condition.
    #[must_use]
    pub fn friction_covariance(&self, pressures_pa: &[f64], condition: Option<&Condition>) -> Option<Covariance> {
        covariance(&self.friction, pressures_pa, condition)
    }

    /// Dynamic friction of the flat sample over that in steady sliding at `pressures_pa`, as the calibration found it: linear
    /// between measurements. `None` where the file does not say it for the condition.
    #[must_use]
    pub fn excess(&self, pressures_pa: &[f64], condition: Option<&Condition>) -> Option<Vec<f64>> {
        let (known, weights) = shares(&self.excess, pressures_pa, condition)?;
        let at = |row: &Vec<f64>| row.iter().zip(&known).map(|(share, known)| share * known.std_error).sum();
        Some(weights.iter().map(at).collect())
    }

    /// What is known at `loads` under `condition` of a material with this `area_law`.
    ///
    /// # Errors
    /// [`MaterialError`] where the law cannot be moved by its scale's error.
    pub fn knowledge(
        &self,
        area_law: Option<&AreaLaw>,
        loads: &[Load],
        condition: Option<&Condition>,
    ) -> Result<Knowledge, MaterialError> {
        let pressures_pa: Vec<f64> = loads.iter().map(|load| load.pressure_pa).collect();
        let variance =
            |known: Covariance| known.iter().enumerate().map(|(place, row)| row[place]).collect::<Vec<f64>>();
        let count = loads.len();
        let static_friction = covariance(&self.static_friction, &pressures_pa, condition).map(variance);
        if let (Some(known), Some(law)) = (&self.scale_covariance, area_law) {
            // Fitted together: flat friction and the law's scale are off together.
            let joint = with_scale(known, law, loads)?;
            let scale = ScaleError {
                is_fitted: true,
                variance: joint[count][count],
                with_friction: joint[..count].iter().map(|row| row[count]).collect(),
            };
            let flat_friction = Some((0..count).map(|load| joint[load][load]).collect());
            return Ok(Knowledge { flat_friction, static_friction, scale: Some(scale), discrepancy: None });
        }
        Ok(Knowledge {
            flat_friction: self.friction_covariance(&pressures_pa, condition).map(variance),
            static_friction,
            scale: self.modulus_std(area_law).map(|std| ScaleError::of_modulus(std, count)),
            discrepancy: None,
        })
    }

    /// Standard deviation of the logarithm of Young's modulus, where that moves `area_law`: ln(1 + x) of a relative one x is
    /// x to first order.
    #[must_use]
    pub fn modulus_std(&self, area_law: Option<&AreaLaw>) -> Option<f64> {
        self.modulus_relative_std
            .filter(|std| *std > 0.0 && !self.law_is_fitted && !self.law_is_measured && area_law.is_some())
    }

    /// What a material with this `area_law` does not say of its own errors, of which `knowledge` is what it says.
    #[must_use]
    pub fn unknown(&self, knowledge: &Knowledge, area_law: Option<&AreaLaw>) -> Vec<&'static str> {
        let mut unknown = Vec::new();
        if knowledge.flat_friction.is_none() {
            unknown.push("flat friction");
        }
        let Some(law) = area_law else { return unknown };
        let fitted_together = self.scale_covariance.is_some();
        if self.law_is_fitted && !fitted_together {
            unknown.push("scale of the area law");
        }
        if !self.law_is_fitted && !self.law_is_measured && !fitted_together && self.modulus_relative_std.is_none() {
            unknown.push("Young's modulus");
        }
        if !fitted_together && law.factor_std().is_none() {
            unknown.push("area law");
        }
        unknown
    }
}

/// Those of `known` coefficients that stand for `condition`, and the share of each at each of `pressures_pa`.
fn shares<'a>(
    known: &'a [FrictionError],
    pressures_pa: &[f64],
    condition: Option<&Condition>,
) -> Option<(Vec<&'a FrictionError>, Vec<Vec<f64>>)> {
    let measured: Vec<Condition> = known.iter().filter_map(|row| row.condition).collect();
    let shares: Vec<(Option<Condition>, f64)> = if measured.is_empty() {
        vec![(None, 1.0)]
    } else {
        between(&measured, condition?)?.into_iter().map(|(own, share)| (Some(own), share)).collect()
    };
    let is_of = |row: &&FrictionError, own: &Option<Condition>| match (&row.condition, own) {
        (Some(condition), Some(own)) => condition.matches(own),
        (condition, own) => condition.is_none() && own.is_none(),
    };
    let groups: Vec<(Vec<&FrictionError>, f64)> =
        shares.iter().map(|(own, share)| (known.iter().filter(|row| is_of(row, own)).collect(), *share)).collect();
    let known: Vec<&FrictionError> = groups.iter().flat_map(|(rows, _)| rows.iter().copied()).collect();
    let at = |at_pa: f64| -> Option<Vec<f64>> {
        let each = groups.iter().map(|(rows, share)| {
            Some(weights(rows, at_pa)?.into_iter().map(|weight| share * weight).collect::<Vec<f64>>())
        });
        Some(each.collect::<Option<Vec<_>>>()?.concat())
    };
    let weights: Vec<Vec<f64>> = pressures_pa.iter().map(|&at_pa| at(at_pa)).collect::<Option<_>>()?;
    Some((known, weights))
}

/// Covariance of the relative errors of `known` coefficients at `pressures_pa` under `condition`.
fn covariance(known: &[FrictionError], pressures_pa: &[f64], condition: Option<&Condition>) -> Option<Covariance> {
    let (known, weights) = shares(known, pressures_pa, condition)?;
    let mean = |row: &Vec<f64>| row.iter().zip(&known).map(|(w, known)| w * known.mean).sum::<f64>();
    // cov(mu_i, mu_j) = sum_k w_ik w_jk s_k^2, relative to mu_i mu_j
    let covariance = |left: &Vec<f64>, right: &Vec<f64>| {
        let shared: f64 =
            left.iter().zip(right).zip(&known).map(|((l, r), known)| l * r * known.std_error.powi(2)).sum();
        shared / (mean(left) * mean(right))
    };
    Some(weights.iter().map(|left| weights.iter().map(|right| covariance(left, right)).collect()).collect())
}

/// The share of each of `known` in the coefficient at a pressure: linear between measurements, the nearest beyond.
fn weights(known: &[&FrictionError], at_pa: f64) -> Option<Vec<f64>> {
    let mut weights = vec![0.0; known.len()];
    let pressure = |place: usize| known[place].pressure_pa;
    let mut order: Vec<usize> = (0..known.len()).collect();
    order.sort_by(|&a, &b| pressure(a).unwrap_or(0.0).total_cmp(&pressure(b).unwrap_or(0.0)));
    let (&first, &last) = (order.first()?, order.last()?);
    let (Some(first_pa), Some(last_pa)) = (pressure(first), pressure(last)) else {
        weights[first] = 1.0;
        return Some(weights);
    };
    if at_pa <= first_pa || at_pa >= last_pa {
        weights[if at_pa <= first_pa { first } else { last }] = 1.0;
        return Some(weights);
    }
    let next = order.partition_point(|&place| pressure(place).is_some_and(|own_pa| own_pa <= at_pa));
    let (low, high) = (order[next - 1], order[next]);
    let (low_pa, high_pa) = (pressure(low)?, pressure(high)?);
    let t = (at_pa - low_pa) / (high_pa - low_pa);
    (weights[low], weights[high]) = (1.0 - t, t);
    Some(weights)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(friction: &str, more: &str) -> MaterialUncertainty {
        let text = format!(
            "youngs_modulus_gpa = 0.4\nyoungs_modulus_std_gpa = 0.1\ndensity_g_cm3 = 0.9\n[friction]\n{friction}\n{more}"
        );
        let document = Document::new("m.toml", text);
        read_uncertainty(&document, &document.parse().unwrap()).unwrap()
    }

    #[test]
    fn one_pair_is_off_alike_at_every_load() {
        let known = read("static_mean = 0.3\ndynamic_mean = 0.25\ndynamic_std_error = 0.005", "");
        let covariance = known.friction_covariance(&[1e6, 2e6], None).unwrap();
        assert!(covariance.iter().flatten().all(|entry| (entry - 4e-4).abs() < 1e-15), "{covariance:?}");
        assert_eq!((known.modulus_relative_std, known.law_is_fitted), (Some(0.25), false));
        assert_eq!(known.discrepancy_at(Some(0.15)), None);
        let silent = read("static_mean = 0.3\ndynamic_mean = 0.25", "");
        assert_eq!(silent.friction_covariance(&[1e6], None), None);
    }

    #[test]
    fn a_fitted_scale_comes_with_its_covariance() {
        let single = "static_mean = 0.3\ndynamic_mean = 0.25\ndynamic_std_error = 0.005\n";
        let known = read(&format!("{single}scale_covariance = [[2.5e-5, -1e-3], [-1e-3, 0.09]]"), "");
        let covariance = known.scale_covariance.unwrap();
        let expected = [[4e-4, -4e-3], [-4e-3, 0.09]];
        assert!(covariance.iter().flatten().zip(expected.iter().flatten()).all(|(a, b)| (a - b).abs() < 1e-12));
        for wrong in ["[[1.0]]", "[[1e-4, 1.0], [1.0, 1e-4]]", "[[1e-4, 0.0], [1e-5, 1e-4]]"] {
            let text = format!(
                "youngs_modulus_gpa = 0.4\ndensity_g_cm3 = 0.9\n[friction]\n{single}scale_covariance = {wrong}\n"
            );
            let document = Document::new("m.toml", text);
            let refused = read_uncertainty(&document, &document.parse().unwrap()).unwrap_err().to_string();
            assert!(refused.contains("scale_covariance"), "{refused}");
        }
    }

    #[test]
    fn between_measurements_errors_are_shared() {
        let known = read(
            "relative_std = 0.05\n[[friction.conditions]]\nspeed_mm_s = 2.0\nhumidity_pct = 15.0\npressure_mpa = [1.0, 2.0]\n\
             static_mean = 0.3\ndynamic_mean = [0.2, 0.3]\ndynamic_std_error = [0.004, 0.003]",
            "[area_law]\norigin = \"fit\"\npressure_mpa = [0.7, 2.6]\nfactor = [1.0, 0.9]",
        );
        assert!(known.law_is_fitted);
        let condition = Condition { speed_m_s: 2e-3, humidity: 0.15 };
        // mu(1.5) = 0.25 with half of each error; mu(0.5) and mu(3) are the ends'.
        let covariance = known.friction_covariance(&[0.5e6, 1.5e6, 3e6], Some(&condition)).unwrap();
        let expected = [
            [4e-4, 0.5 * 1.6e-5 / 0.05, 0.0],
            [0.5 * 1.6e-5 / 0.05, 0.25 * (1.6e-5 + 9e-6) / 0.0625, 0.5 * 9e-6 / 0.075],
            [0.0, 0.5 * 9e-6 / 0.075, 1e-4],
        ];
        for (row, expected) in covariance.iter().zip(expected) {
            for (entry, expected) in row.iter().zip(expected) {
                assert!((entry - expected).abs() < 1e-12, "{covariance:?}");
            }
        }
        assert_eq!(known.friction_covariance(&[1e6], Some(&Condition { humidity: 0.8, ..condition })), None);
    }

    #[test]
    fn between_conditions_errors_are_shared_too() {
        let condition = |speed: f64, mean: f64, error: f64| {
            format!(
                "[[friction.conditions]]\nspeed_mm_s = {speed}\nhumidity_pct = 15.0\npressure_mpa = [1.0]\n\
                 static_mean = 0.3\ndynamic_mean = {mean}\ndynamic_std_error = {error}\n"
            )
        };
        let known = read(&format!("{}{}", condition(1.0, 0.2, 0.004), condition(4.0, 0.3, 0.003)), "");
        let covariance =
            known.friction_covariance(&[1e6], Some(&Condition { speed_m_s: 2e-3, humidity: 0.15 })).unwrap();
        // Half of each: mean 0.25, variance (0.004^2 + 0.003^2) / 4.
        assert!((covariance[0][0] - 0.25 * 2.5e-5 / 0.0625).abs() < 1e-12, "{covariance:?}");
    }
}
