//! Uncertainty budgets in the form of the GUM (JCGM 100:2008), from the records of results.
//!
//! A budget repeats numbers of a record and computes no further uncertainty. The standard uncertainty of an input is
//! its effect on the result, because records hold effects.

use slipgrid_base::statistics::NORMAL_95;
use slipgrid_base::units::{significant, tidy};
use slipgrid_design::DesignReport;
use slipgrid_design::results::errors::{DRAWS, STATIC, TIME_AVERAGE};
use slipgrid_design::results::{ErrorReport, SimulationReport, Table, fixed};
use slipgrid_infer::calibrate::uncertainty::Source;

use crate::charts::flat_of;

/// File name of the uncertainty budgets.
pub const FILE: &str = "uncertainty.csv";
/// Inputs of type A, which are evaluated by statistics of observations or of runs; all others are of type B.
const TYPE_A: [&str; 6] =
    [TIME_AVERAGE, DRAWS, STATIC, Source::FlatFriction.name(), Source::FittedScale.name(), Source::AreaLaw.name()];
/// Name of the input that stands for the part of the combined variance that the other inputs do not explain: correlations
/// between them, as of the local law and the model error that the same trials teach, and mixtures that are not normal.
/// Its uncertainty is the root of this part, negative where the others exceed the combined variance.
const NOT_ATTRIBUTED: &str = "not attributed";
/// Minimum share of the combined variance for which [`NOT_ATTRIBUTED`] is listed; smaller shares are rounding errors.
const MIN_NOT_ATTRIBUTED: f64 = 1e-6;
/// Explanation of the budget tables on a page.
pub(crate) const WORDS: &str = "Type A: by statistics of observations or of runs; type B: by other means. The standard uncertainty of an input is its effect \
     on the ratio. The sensitivity is 1 for a ratio, and flat friction for a coefficient. Degrees of freedom: ∞ for type B (GUM, G.4.3); a dash \
     where the result does not hold the number. Shares of the combined variance sum to 100 %. Not attributed: \
     correlations and a distribution that is not normal, which close the budget; negative where the other inputs exceed it.";

/// Uncertainty budget of one quantity at one load.
#[derive(Clone, Debug, PartialEq)]
pub struct UncertaintyBudget {
    quantity: &'static str,
    pressure_mpa: f64,
    speed_mm_s: f64,
    humidity_pct: Option<f64>,
    sliding_angle_deg: Option<f64>,
    value: f64,
    inputs: Vec<Input>,
    combined: f64,
    interval_95: [f64; 2],
}

/// Uncertain input of a budget.
#[derive(Clone, Debug, PartialEq)]
struct Input {
    name: String,
    std: f64,
    sensitivity: f64,
}

impl Input {
    fn is_type_a(&self) -> bool {
        TYPE_A.contains(&self.name.as_str())
    }

    fn kind(&self) -> &'static str {
        if self.is_type_a() { "A" } else { "B" }
    }

    fn contribution(&self) -> f64 {
        self.sensitivity * self.std
    }
}

impl UncertaintyBudget {
    /// Budgets of the friction ratio and the friction coefficients of a scene at all loads; quantities without a known
    /// error have no budget.
    pub fn of_scene(report: &SimulationReport) -> Vec<Self> {
        let mut all = Vec::new();
        for at in &report.errors.by_pressure {
            let quantities = [
                ("ratio of dynamic friction", at.ratio.as_ref()),
                ("dynamic friction", Some(&at.mu)),
                ("dynamic friction of the flat surface", at.mu_flat.as_ref()),
                ("static friction", at.mu_static.as_ref()),
                ("static friction of the flat surface", at.mu_static_flat.as_ref()),
            ];
            let budget = |(quantity, errors): (&'static str, Option<&ErrorReport>)| {
                let errors = errors?;
                let input = |(name, std): (&String, f64)| Input { name: name.clone(), std, sensitivity: 1.0 };
                Some(Self {
                    quantity,
                    pressure_mpa: at.pressure_mpa,
                    speed_mm_s: report.speed_mm_s,
                    humidity_pct: None,
                    sliding_angle_deg: None,
                    value: errors.value?,
                    inputs: errors.parts.iter().map(|part| input((&part.input, part.std))).collect(),
                    combined: errors.std?,
                    interval_95: errors.interval_95?,
                })
            };
            all.extend(quantities.into_iter().filter_map(budget).map(Self::closed));
        }
        all
    }

    /// Budgets of the expected value of a cut sample, one per load; loads whose inputs were not analysed have no
    /// budget. The combined uncertainty is half the width of the record's 95 % interval over 1.96, as for a normal
    /// distribution.
    pub fn of_design(report: &DesignReport) -> Vec<Self> {
        let (sample, is_ratio) = (&report.sample, report.is_ratio());
        let budget = |(row, at): (usize, &slipgrid_design::Expected)| {
            // A ratio times the friction of the flat surface is the coefficient.
            let sensitivity = flat_of(report, row)?;
            let inputs: Option<Vec<Input>> = sample
                .limited_by
                .iter()
                .map(|limit| Some(Input { name: limit.input.clone(), std: *limit.std.get(row)?, sensitivity }))
                .collect();
            Some(Self {
                quantity: if is_ratio { "ratio of dynamic friction" } else { "dynamic friction" },
                pressure_mpa: at.pressure_mpa,
                speed_mm_s: at.speed_mm_s,
                humidity_pct: Some(at.humidity_pct),
                sliding_angle_deg: at.sliding_angle_deg,
                value: at.median,
                inputs: inputs.filter(|inputs| !inputs.is_empty())?,
                combined: tidy((at.high_95 - at.low_95) / (2.0 * NORMAL_95)),
                interval_95: [at.low_95, at.high_95],
            })
        };
        sample.expected.iter().enumerate().filter_map(budget).map(Self::closed).collect()
    }

    /// Adds the input `NOT_ATTRIBUTED` unless the squared contributions of the listed inputs sum to the combined variance.
    fn closed(mut self) -> Self {
        let listed: f64 = self.inputs.iter().map(|input| input.contribution().powi(2)).sum();
        let rest = self.combined.powi(2) - listed;
        let sensitivity = self.inputs.first().map_or(1.0, |input| input.sensitivity);
        if rest.abs() > MIN_NOT_ATTRIBUTED * self.combined.powi(2) && sensitivity > 0.0 {
            let std = tidy(rest.abs().sqrt().copysign(rest) / sensitivity);
            self.inputs.push(Input { name: NOT_ATTRIBUTED.to_owned(), std, sensitivity });
        }
        self
    }

    /// Share of `input` in the combined variance: its squared contribution over the squared combined uncertainty, with the
    /// sign of the contribution. The shares of all inputs sum to 1.
    fn variance_share(&self, input: &Input) -> Option<f64> {
        let share = input.contribution() / self.combined;
        (self.combined > 0.0).then(|| share * share.abs())
    }

    /// Expanded uncertainty: half the width of the 95 % interval.
    fn expanded(&self) -> f64 {
        let [low, high] = self.interval_95;
        0.5 * (high - low)
    }

    /// Expanded over combined uncertainty; `None` without any uncertainty.
    fn coverage_factor(&self) -> Option<f64> {
        (self.combined > 0.0).then(|| self.expanded() / self.combined)
    }

    /// States value, combined uncertainty, coverage factor and expanded uncertainty in one sentence.
    pub(crate) fn result_in_words(&self) -> String {
        let humidity = self.humidity_pct.map_or_else(String::new, |humidity| format!(", {humidity} %"));
        let angle = self.sliding_angle_deg.map_or_else(String::new, |angle_deg| format!(", sliding at {angle_deg}°"));
        format!(
            "{} at {} MPa, {} mm/s{humidity}{angle}: {}; combined standard uncertainty {}, coverage factor {}, expanded uncertainty {} (95 %)",
            self.quantity,
            self.pressure_mpa,
            self.speed_mm_s,
            fixed(Some(self.value), 4),
            fixed(Some(self.combined), 4),
            fixed(self.coverage_factor(), 2),
            fixed(Some(self.expanded()), 4)
        )
    }

    /// Table with one row per input, the largest contribution first.
    pub(crate) fn table(&self) -> Table {
        let mut inputs: Vec<&Input> = self.inputs.iter().collect();
        inputs.sort_by(|a, b| b.contribution().abs().total_cmp(&a.contribution().abs()));
        let mut table = Table::of(&inputs);
        table.column("input", |input| input.name.clone());
        table.column("type", |input| input.kind().to_owned());
        table.column("standard uncertainty", |input| fixed(Some(input.std), 4));
        table.column("degrees of freedom", |input| if input.is_type_a() { "-" } else { "∞" }.to_owned());
        table.column("sensitivity", |input| fixed(Some(input.sensitivity), 3));
        table.column("contribution", |input| fixed(Some(input.contribution()), 4));
        table.column("variance %", |input| fixed(self.variance_share(input).map(|share| 100.0 * share), 1));
        table.table()
    }

    /// Formats `budgets` as CSV, one row per input.
    pub fn csv(budgets: &[Self]) -> String {
        let rows: Vec<(&Self, &Input)> =
            budgets.iter().flat_map(|of| of.inputs.iter().map(move |input| (of, input))).collect();
        let six = |value: f64| significant(value, 6);
        let mut table = Table::of(&rows);
        table.column("quantity", |(of, _)| of.quantity.to_owned());
        table.numbers("pressure_mpa", |(of, _)| of.pressure_mpa);
        table.numbers("speed_mm_s", |(of, _)| of.speed_mm_s);
        table.numbers("humidity_pct", |(of, _)| of.humidity_pct);
        table.numbers("sliding_angle_deg", |(of, _)| of.sliding_angle_deg);
        table.numbers("value", |(of, _)| six(of.value));
        table.column("input", |(_, input)| input.name.clone());
        table.column("type", |(_, input)| input.kind().to_owned());
        table.numbers("standard_uncertainty", |(_, input)| six(input.std));
        table.numbers("degrees_of_freedom", |(_, input)| (!input.is_type_a()).then_some(f64::INFINITY));
        table.numbers("sensitivity", |(_, input)| six(input.sensitivity));
        table.numbers("contribution", |(_, input)| six(input.contribution()));
        table.numbers("variance_share", |(of, input)| of.variance_share(input).map(six));
        table.numbers("combined_uncertainty", |(of, _)| six(of.combined));
        table.numbers("coverage_factor", |(of, _)| of.coverage_factor().map(six));
        table.numbers("expanded_uncertainty", |(of, _)| six(of.expanded()));
        table.numbers("low_95", |(of, _)| six(of.interval_95[0]));
        table.numbers("high_95", |(of, _)| six(of.interval_95[1]));
        table.table().csv()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_design::results::{ErrorsReport, PartsReport, PressureErrors};

    #[test]
    fn a_budget_of_independent_inputs_adds_up_with_a_factor_of_1_96() {
        let part = |input: &str, std: f64| PartsReport { input: input.to_owned(), std };
        let mu = ErrorReport::new(Some(0.4), vec![part(TIME_AVERAGE, 0.03), part("size of blocks", 0.04)], None);
        let at =
            PressureErrors { pressure_mpa: 2.6, ratio: None, mu, mu_flat: None, mu_static: None, mu_static_flat: None };
        let report: SimulationReport = serde_json::from_value(serde_json::json!({
            "program": "slipgrid", "version": "0", "fidelity": "steady", "extent": "cell", "dimensions": 2, "model": [],
            "material": {"name": "", "source": "", "synthetic_surface": false, "notes": []}, "pattern": null,
            "section_model": false, "areal_density": null, "section_density": null, "block_um": 5.0, "speed_mm_s": 2.0,
            "seed": 1, "draws": 1, "results": [], "discrepancy": null,
            "errors": ErrorsReport::new(vec![at], Vec::new()),
        }))
        .unwrap();
        let found = UncertaintyBudget::of_scene(&report);
        let [budget] = &found[..] else { panic!("{found:?}") };
        assert!((budget.combined - 0.05).abs() < 1e-12 && (budget.coverage_factor().unwrap() - 1.96).abs() < 1e-3);
        let table = budget.table();
        let rows = table.body();
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0][..4], ["size of blocks", "B", "0.0400", "∞"].map(str::to_owned));
        assert_eq!(rows[1][..4], [TIME_AVERAGE, "A", "0.0300", "-"].map(str::to_owned));
        let wider = UncertaintyBudget { combined: 0.13, ..budget.clone() }.closed();
        assert_eq!(wider.table().body()[0][..3], [NOT_ATTRIBUTED, "B", "0.1200"].map(str::to_owned));
        // Correlated inputs of 0.03 and 0.04 that give 0.04 together: 0.04^2 - 0.05^2 = -0.03^2.
        let narrower = UncertaintyBudget { combined: 0.04, ..budget.clone() }.closed();
        assert_eq!(narrower.table().body()[2][2..], ["-0.0300", "∞", "1.000", "-0.0300", "-56.2"].map(str::to_owned));
        for budget in [budget, &wider, &narrower] {
            let shares = budget.inputs.iter().map(|input| budget.variance_share(input).unwrap());
            assert!((shares.sum::<f64>() - 1.0).abs() < 1e-9, "{budget:?}");
        }
        let csv = UncertaintyBudget::csv(&found);
        assert!(
            csv.contains("\ndynamic friction,2.6,2,,,0.4,time average,A,0.03,,1,0.03,0.36,0.05,1.95996,0.0979982,"),
            "{csv}"
        );
    }
}
