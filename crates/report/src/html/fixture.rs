//! A design's report with all its parts, for tests of its page.

use slipgrid_design::records::{
    ChanceReport, ConditionReport, ConditionValue, ConditionsReport, ConflictReport, Dimensions, DiscrepancyReport,
    Distribution, ExplanationReport, FactorReport, GoalReport, ImprovementReport, InputReport, ListedDesign,
    NearestReport, NodeReport, OptimumReport, PartReport, PressureParts, PressureReport, ReachableReport, Reading,
    ReliefReport, RobustnessReport, ScatterReport, SelectionReport, SensitivityReport, SlopesReport, SpreadReport,
    TableReport, TargetReport, Tolerance, TradeOffsReport,
};
use slipgrid_design::{DesignReport, MisfitReport};
use slipgrid_export::{Ablation, Exposure, Laser, Removal};
use slipgrid_results::{
    ErrorReport, ErrorsReport, LoadReport, MaterialReport, PartsReport, PatternReport, PressureErrors,
};

/// A value with its standard deviation, of which no parts are known.
pub fn number(value: f64, std: Option<f64>) -> ErrorReport {
    ErrorReport { value: Some(value), std, ..ErrorReport::default() }
}

/// A report that holds every part that a page can show.
pub fn report() -> DesignReport {
    let design = PatternReport {
        planform: "groove".into(),
        width_um: 130.0,
        spacing_um: 370.0,
        depth_um: 20.0,
        areal_density: 0.26,
        angle_deg: Some(30.0),
        ..PatternReport::default()
    };
    let nearest = NearestReport { design: design.clone(), misfit: 1.75 };
    let node = NodeReport { design: design.clone(), cost: 0.5, misfit: 0.5, feasible: true };
    DesignReport {
        date: Some("2026-11-22".to_owned()),
        program: "slipgrid".into(),
        version: "0.0.0".into(),
        name: "a <b> & \"c\"".into(),
        status: "met".into(),
        chance: Some(chance()),
        advice: None,
        selection: Some(SelectionReport {
            words: "chosen of 3".into(),
            designs: 9,
            on_target: 3,
            chance: 0.16,
            greatest_chance: 0.17,
            alike: 0.01,
            effort: "laser_time_s".into(),
            effort_value: 10.0,
            effort_of_greatest_chance: 12.0,
        }),
        specimen_areal_density: 0.2512,
        passes: Some(4),
        removal: Some(Removal {
            passes: 4,
            depth_per_pass_um: 1.31,
            depth_um: 5.24,
            mean_depth_um: 4.1,
            edge_ramp_um: 25.0,
            speed_for_depth_mm_s: Some(201.5),
            warnings: vec!["the mean depth over cavities is 4.1 um".into()],
        }),
        bursts: Some(12),
        dimensions: 2,
        target: TargetReport {
            quantity: "ratio".into(),
            pressure_mpa: vec![0.65, 2.6],
            value: Some(vec![0.97, 0.83]),
            tolerance: Some(Tolerance::One(0.01)),
            lowest: vec![Some(0.96), Some(0.82)],
            highest: vec![Some(0.98), Some(0.84)],
            ..TargetReport::default()
        },
        predicted: vec![
            LoadReport { peak_pressure_mpa: 1.9, ratio_discretization_error: Some(-0.0012), ..LoadReport::default() },
            LoadReport { peak_pressure_mpa: 7.1, ..LoadReport::default() },
        ],
        predicted_value: vec![0.9616, 0.8315],
        confirmed: vec![
            LoadReport { pressure_mpa: 0.65, status: "converged".into(), ..LoadReport::default() },
            LoadReport { pressure_mpa: 2.6, cavity_closed: true, status: "converged".into(), ..LoadReport::default() },
        ],
        errors: errors(),
        discrepancy: Some(discrepancy()),
        conditions: Some(conditions()),
        goal: None,
        misfit: MisfitReport { predicted: 0.84, confirmed: None },
        sensitivities: Some(SensitivityReport {
            quantity: "ratio".into(),
            step_um: Dimensions { width: Some(5.0), spacing: Some(5.0), depth: None },
            by_pressure: vec![SlopesReport {
                pressure_mpa: 0.65,
                per_um: Dimensions { width: Some(-3.5e-4), spacing: Some(1.2e-4), depth: None },
                error_per_um: Dimensions { width: Some(2e-6), spacing: Some(0.0), depth: None },
            }],
            errors_have_blocks: true,
            rim: None,
        }),
        robustness: Some(robustness(&design)),
        trade_offs: Some(TradeOffsReport {
            goals: vec!["misfit".into(), "depth_um".into()],
            words: vec!["misfit".into(), "depth in µm".into()],
            designs: 40,
            left_out: 2,
            front: 7,
            chosen: Some(vec![0.5, 20.0]),
            chosen_is_on_front: true,
            on_target: true,
            listed: vec![ListedDesign { design: design.clone(), goals: vec![0.5, 20.0] }],
            best: Vec::new(),
            model: "the steady cell".into(),
            none_because: None,
        }),
        reachable: vec![ReachableReport {
            pressure_mpa: 2.6,
            lowest: 0.7,
            lowest_std: Some(0.01),
            highest: 0.99,
            highest_std: None,
        }],
        explanation: Some(ExplanationReport {
            each_alone: false,
            binding: vec![
                ReliefReport {
                    what: "depth".into(),
                    unit: "um".into(),
                    limit: 20.0,
                    relaxed: 31.5,
                    suffices: true,
                    nearest: nearest.clone(),
                },
                ReliefReport {
                    what: "width".into(),
                    unit: "um".into(),
                    limit: 130.0,
                    relaxed: 199.123_45,
                    suffices: false,
                    nearest: nearest.clone(),
                },
            ],
            misfit: 2.5,
            relaxed: 2,
            tried: vec!["depth".into(), "width".into()],
            kept: Some("the laser's spot, 25 um".into()),
            together: Some(nearest),
            evaluations: 30,
        }),
        table: Some(TableReport {
            designs: 90,
            failed: 0,
            feasible: 80,
            meeting: 3,
            best: node,
            neighbour: None,
            found_cost: 0.5,
            confirms_search: true,
            by_chance: false,
        }),
        alternatives: vec![design.clone()],
        design,
        evaluations: 9,
        rounds: 1,
        seed: 1,
        history: [(1, 3.0), (9, 0.5)]
            .map(|(evaluation, misfit)| ImprovementReport { round: 1, evaluation, misfit, feasible: true })
            .into(),
        model: vec!["two dimensions".into()],
        material: MaterialReport {
            name: "m".into(),
            source: "s".into(),
            synthetic_surface: true,
            notes: vec!["n".into()],
            warnings: vec!["spikes: 5 points stand alone".into()],
        },
        laser: laser(),
        ..DesignReport::default()
    }
}

/// What became of a goal.
pub fn goal() -> GoalReport {
    GoalReport {
        goal: "even".into(),
        of: "difference of ratios".into(),
        predicted: Some(0.1),
        predicted_std: None,
        confirmed: Some(0.11),
        confirmed_std: Some(0.002),
        range_predicted: Some(0.1),
        range_confirmed: None,
    }
}

fn chance() -> ChanceReport {
    let width = PartReport { input: "width".into(), known_to: "8 um".into(), chance_without: 0.2 };
    ChanceReport {
        value: Some(0.16),
        stderr: Some(0.01),
        words: "16 % chance that a cut sample is on target (limited by Young's modulus)".into(),
        included: vec!["width".into()],
        not_known: vec!["how far the model itself is off".into()],
        limited_by: None,
        parts: vec![width],
        draws: 20_000,
        draws_of_the_model: 400,
    }
}

fn errors() -> ErrorsReport {
    ErrorsReport {
        meaning: "+-: one standard deviation of time".into(),
        includes: vec!["time".into()],
        unknown: Vec::new(),
        by_pressure: vec![
            PressureErrors {
                pressure_mpa: 0.65,
                predicted: Some(number(0.9616, Some(0.0012))),
                ratio: Some(number(0.9637, Some(0.0002))),
                mu: number(0.24, None),
                mu_flat: Some(number(0.25, Some(0.002))),
                mu_static: None,
                mu_static_flat: None,
            },
            PressureErrors {
                pressure_mpa: 2.6,
                predicted: Some(number(0.8315, None)),
                ratio: Some(ErrorReport {
                    interval_95: Some([0.8339, 0.8371]),
                    parts: vec![PartsReport { input: "time".into(), std: 0.0007 }],
                    ..number(0.8355, Some(0.0008))
                }),
                mu: ErrorReport::default(),
                mu_flat: None,
                mu_static: None,
                mu_static_flat: None,
            },
        ],
    }
}

fn discrepancy() -> DiscrepancyReport {
    let of = |physics| Reading { physics: Some(physics), std: None };
    DiscrepancyReport {
        quantity: "ratio".into(),
        trials: 1,
        by_pressure: vec![FactorReport {
            pressure_mpa: 2.6,
            factor: 0.829,
            relative_std: 0.05,
            interval_95: [0.75, 0.91],
            predicted: of(0.84),
            confirmed: of(0.8355),
            mu: of(0.21),
        }],
        physics_misfit: Some(0.8),
    }
}

fn conditions() -> ConditionsReport {
    let at = |words: &str, in_time, misfit| ConditionReport {
        speed_mm_s: 2.0,
        humidity_pct: Some(40.0),
        sliding_angle_deg: None,
        words: words.into(),
        in_time,
        by_pressure: vec![ConditionValue {
            pressure_mpa: 0.65,
            ratio: 0.96,
            ratio_std: Some(0.001),
            mu: 0.24,
            mu_std: None,
            mu_flat: 0.25,
            mu_flat_std: Some(0.002),
            factor: 1.0,
            peak_pressure_mpa: 1.9,
            friction_extrapolated: false,
        }],
        misfit,
    };
    ConditionsReport {
        meaning: "by runs in time".into(),
        at: vec![at("2 mm/s, 40 %", true, 0.5), at("2 mm/s, 80 %", false, 1.5)],
        worst: Some(1),
        held: false,
        conflict: Some(ConflictReport {
            pressure_mpa: 0.65,
            lowest_at: "40 %".into(),
            highest_at: "80 %".into(),
            flat_factor: 1.2,
            factor: 1.1,
            accepted: [0.96, 0.98],
            needed: [0.9, 1.0],
            words: "flat friction differs".into(),
        }),
    }
}

fn robustness(design: &PatternReport) -> RobustnessReport {
    let of = |mean: f64, band_95| Distribution { mean, mean_stderr: 0.0, std: 0.01, band_95 };
    let spread = SpreadReport { ratio: of(0.96, [0.94, 0.98]), mu: of(0.24, [0.23, 0.25]) };
    let samples = ScatterReport {
        draws: 500,
        failed: 3,
        redrawn: 0,
        probability: Some(0.62),
        probability_stderr: Some(0.015),
        by_pressure: vec![PressureReport { pressure_mpa: 0.65, spread }],
    };
    RobustnessReport {
        meaning: "of a mean".into(),
        condition: None,
        method: "sampled".into(),
        inputs: vec![InputReport { name: "width".into(), std: vec![8.0], unit: "um".into(), basis: "b".into() }],
        with_material: Some(ScatterReport { probability: Some(0.5), ..samples.clone() }),
        samples,
        parts: vec![PressureParts {
            pressure_mpa: 0.65,
            std: 0.02,
            of: vec![PartsReport { input: "width".into(), std: 0.01 }],
        }],
        optimum: Some(OptimumReport {
            nominal: design.clone(),
            nominal_expected_rms: None,
            expected_rms: 1.25,
            nominal_probability: Some(0.6),
            evaluations: 5,
        }),
    }
}

fn laser() -> Laser {
    Laser {
        spot_um: Some(23.0),
        wavelength_nm: Some(355.0),
        repetition_hz: Some(1e5),
        exposure: Some(Exposure::Hatch),
        ablation: Some(Ablation {
            delta_um: 1.5,
            delta_stderr_um: 0.1,
            threshold_j_cm2: 0.8,
            threshold_stderr_j_cm2: 0.05,
            fluence_j_cm2: 4.0,
            depth_per_burst_um: 2.4,
            depth_per_burst_stderr_um: 0.06,
            points: 7,
        }),
        ..Laser::default()
    }
}
