//! Test fixture: a design's report with all parts.

use slipgrid_design::records::{
    GoalReport, LiftedReport, ListedDesign, SlopeReport, TableReport, TargetReport, Tolerance, TradeOffsReport,
};
use slipgrid_design::results::{LoadReport, MadeBy, PatternReport};
use slipgrid_design::{DesignReport, Expected, LimitedBy, ModelledRatio, SampleReport};
use slipgrid_laser::export::{Ablation, Exposure, Laser, Removal};
use slipgrid_model::material::Provenance;
use slipgrid_model::pattern::TextureRecord;
use slipgrid_model::springblock::{Correction, Effect};

/// Report that contains every part that a page can show.
pub fn report() -> DesignReport {
    let design = PatternReport {
        width_um: 130.0,
        spacing_um: 370.0,
        depth_um: 20.0,
        areal_density: 0.26,
        texture: TextureRecord { planform: Some("groove".into()), angle_deg: Some(30.0), ..TextureRecord::default() },
        ..PatternReport::default()
    };
    let sample = sample(&design);
    DesignReport {
        date: Some("2026-11-22".to_owned()),
        made_by: MadeBy { version: "0.0.0".into(), ..MadeBy::slipgrid(0) },
        name: "a <b> & \"c\"".into(),
        advice: "trial".into(),
        words: "cut a trial: 16 % chance that a cut sample is on target".into(),
        trials: 1,
        others: vec![SampleReport { chance: Some(0.12), limited_by: Vec::new(), ..sample.clone() }],
        sample,
        slopes: vec![
            SlopeReport { dimension: "width_um".to_owned(), per_um: vec![-3.5e-4, -6e-4] },
            SlopeReport { dimension: "depth_um".to_owned(), per_um: vec![1.2e-4, 2e-4] },
        ],
        compared: 4321,
        table: TableReport {
            nodes: 1820,
            holes: 3,
            checked: 60,
            median_error: 2e-4,
            worst_error: 3e-3,
            ..TableReport::default()
        },
        specimen_areal_density: 0.2512,
        passes: Some(4),
        removal: Some(Removal {
            passes: 4,
            depth_per_pass_um: 1.31,
            depth_um: 5.24,
            floor_um: [4.1, 5.6],
            mean_depth_um: 4.1,
            width_um: 130.0,
            edge_ramp_um: 25.0,
            speed_for_depth_mm_s: Some(201.5),
            warnings: vec!["the floor is 4.1 to 5.6 um deep".into()],
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
        confirmed: vec![
            LoadReport {
                pressure_mpa: 0.65,
                ratio: Some(0.9637),
                ratio_stderr: Some(0.0002),
                corrections: vec![Correction { effect: Effect::Blocks, change: 0.0, std: Some(0.0006) }],
                mu_flat: Some(0.25),
                status: "converged".into(),
                ..LoadReport::default()
            },
            LoadReport {
                pressure_mpa: 2.6,
                ratio: Some(0.8355),
                cavity_closed: true,
                status: "no_onset".into(),
                ..LoadReport::default()
            },
        ],
        trade_offs: Some(TradeOffsReport {
            goals: vec!["misfit_tolerances".into(), "volume_mm3".into()],
            words: vec!["misfit".into(), "volume in mm3".into()],
            designs: 40,
            front: 7,
            chosen: vec![0.5, 20.0],
            listed: vec![ListedDesign { design, goals: vec![0.5, 20.0] }],
            best: Vec::new(),
        }),
        seed: 1,
        model: vec!["two dimensions".into()],
        material: Provenance {
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

fn sample(design: &PatternReport) -> SampleReport {
    let at = |pressure_mpa, [low_95, median, high_95]: [f64; 3], [low, high]: [f64; 2]| Expected {
        pressure_mpa,
        speed_mm_s: 2.0,
        humidity_pct: 40.0,
        median,
        low_95,
        high_95,
        target_low: Some(low),
        target_high: Some(high),
        ..Expected::default()
    };
    let modelled = |pressure_mpa, ratio| ModelledRatio { pressure_mpa, ratio, std: 0.0123, flat: 1.0 };
    let limit = |input: &str, known_to: &str, std: [f64; 2], chance_if_known| LimitedBy {
        input: input.into(),
        known_to: known_to.into(),
        std: std.into(),
        chance_if_known,
    };
    SampleReport {
        design: design.clone(),
        chance: Some(0.16),
        expected: vec![at(0.65, [0.93, 0.954, 0.98], [0.96, 0.98]), at(2.6, [0.702, 0.791, 0.88], [0.82, 0.84])],
        modelled: vec![modelled(0.65, 0.9616), modelled(2.6, 0.8315)],
        limited_by: vec![
            limit("model error", "known from one trial", [0.02, 0.04], 0.4),
            limit("Young's modulus", "known to 8.0 %", [0.01, 0.02], 0.18),
            limit("numerical error", "up to 0.0004", [1e-4, 2e-4], 0.16),
        ],
        information_bits: 1.25,
        laser_s: Some(13.0),
        violations: Vec::new(),
        is_as_cut: true,
    }
}

/// Result without one limit.
pub fn lifted() -> LiftedReport {
    let design = PatternReport { width_um: 40.0, spacing_um: 60.0, depth_um: 10.0, ..PatternReport::default() };
    LiftedReport { what: "the smallest land, 80 um".into(), chance: 0.35, design, is_within_reach: true }
}

/// Result for a goal.
pub fn goal() -> GoalReport {
    GoalReport {
        goal: "even".into(),
        of: "standard deviation of the ratio over its mean".into(),
        expected: 0.1,
        interval_95: None,
        modelled: 0.11,
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
