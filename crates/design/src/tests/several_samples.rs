//! Samples to cut at once: apart, on sectors of one disc, and with warnings of the laser.

use super::*;
use slipgrid_infer::calibrate::{CutSample, CutSpecimen};

#[test]
fn several_samples_are_apart_and_the_same_each_time() {
    let mut task = task(Planform::Groove);
    reached_by(&mut task, [120e-6, 300e-6, 15e-6], 0.02);
    let options = NextOptions { count: 4, ..NextOptions::default() };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| next_trials(&task, &options, &Unwatched)).unwrap()
    };
    let found = on(2);
    assert_eq!((found.report.trials, &*found.report.advice, found.patterns.len()), (0, "trial", 4));
    for (place, pattern) in found.patterns.iter().enumerate() {
        let is_other = |other: &Pattern| !is_same(&Features::from(other), &Features::from(pattern));
        assert!(found.patterns[..place].iter().all(is_other));
    }
    let first = &found.report.samples[0];
    let chance = first.chance.unwrap();
    assert!(chance > 0.0 && chance < 0.3 && found.report.one_on_target.unwrap() >= chance - 0.03, "{chance}");
    assert!(first.expected.iter().all(|at| at.low_95 < at.median && at.median < at.high_95));
    assert_eq!(on(1).report, found.report);
    let text = found.report.text();
    assert!(text.contains("next 4") && text.contains("\nlearns: how much a measured sample"), "{text}");
}

#[test]
fn sectors_of_one_disc_hold_what_is_chosen_for_them() {
    let task = task(Planform::Groove);
    let asked = |count, one_disc| {
        let options = NextOptions { count, one_disc, ..NextOptions::default() };
        next_trials(&task, &options, &*KNOWN)
    };
    let (disc, apart) = (asked(7, true).unwrap(), asked(7, false).unwrap());
    assert_eq!((disc.patterns.len(), disc.sectors.len(), apart.sectors.len()), (7, 7, 0));
    let (of, report) = (disc.sectors[0].division(), disc.report.one_disc.as_ref().unwrap());
    assert!(apart.report.one_disc.is_none());
    // Seven sectors of a disc of 10 mm contain circles of 2.7 mm: periods of at most 0.68 mm, while the bounds reach 1
    // mm.
    assert!(of.least_circle_m() > 2.6e-3 && of.least_circle_m() < 2.8e-3);
    assert!(disc.patterns.iter().all(|pattern| 4.0 * pattern.pitch_m() <= of.least_circle_m()));
    assert!(disc.report.compared < apart.report.compared, "{} {}", disc.report.compared, apart.report.compared);
    for (sector, own) in disc.sectors.iter().zip(&report.sectors) {
        assert!((own.areal_density / sector.pattern().areal_density() - 1.0).abs() < 0.1, "{own:?}");
    }
    let text = disc.report.text();
    assert!(text.contains("disc 1: 7 sectors") && text.contains("a mean of all sectors"), "{text}");
    assert_eq!(asked(7, true).unwrap().report, disc.report);
    for (count, says) in [(1, "expected 2 to 12"), (13, "expected 2 to 12")] {
        assert!(asked(count, true).unwrap_err().to_string().contains(says));
    }
    let mut small = task.clone();
    small.specimen.outline = Outline::Disc { diameter_m: 1e-3 };
    let options = NextOptions { count: 4, one_disc: true, ..NextOptions::default() };
    let refused = next_trials(&small, &options, &*KNOWN).unwrap_err().to_string();
    assert!(refused.contains("expected fewer sectors"), "{refused}");
    // Sectors of a rectangle have a note; names of specimens already cut are not reused.
    small.specimen.outline = Outline::Rectangle { length_m: 12e-3, width_m: 12e-3 };
    let options = NextOptions { discs: vec![format!("{}, rectangle 1", disc.report.name)], ..options };
    let rectangle = next_trials(&small, &options, &*KNOWN).unwrap().report.text();
    assert!(
        rectangle.contains("rectangle 2: 4 sectors") && rectangle.contains("the specimen is a rectangle"),
        "{rectangle}"
    );
}

/// Tests that samples of one disc share an error: the larger the disc error, the less a further sector helps.
#[test]
fn the_chance_of_one_of_several_counts_what_one_disc_is_off_by() {
    let mut task = task(Planform::Groove);
    // Grooves reach a target set by their modelled ratios.
    reached_by(&mut task, [120e-6, 300e-6, 15e-6], 0.02);
    let together = |task: &DesignTask, options: &NextOptions| {
        next_trials(task, options, &*KNOWN).unwrap().report.one_on_target.unwrap()
    };
    // Without model error a texture on target is found, and the disc alone may miss it.
    let prior = Hyperparameters {
        amplitude_std: 0.0,
        pressure_std: 0.0,
        inverse_pressure_std: 0.0,
        ..Hyperparameters::default()
    };
    let with = |sample_std: f64| {
        let prior = Hyperparameters { speed_std: 0.0, humidity_std: 0.0, sample_std, ..prior.clone() };
        Discrepancy::new(prior, Conditions::default(), 0.0, Vec::new()).unwrap()
    };
    let mut chance_of = |sample_std: f64, options: &NextOptions| {
        let known = MaterialUncertainty { learned: Some(with(sample_std)), ..MaterialUncertainty::default() };
        task.material = Some(crate::task::KnownMaterial { uncertainty: known, ..task.material.clone().unwrap() });
        together(&task, options)
    };
    let three = |one_disc| NextOptions { count: 3, one_disc, ..NextOptions::default() };
    let mut chance = |sample_std: f64, one_disc| chance_of(sample_std, &three(one_disc));
    assert_eq!(chance(0.0, true).to_bits(), chance(0.0, false).to_bits());
    let (little, much) = (chance(0.002, true), chance(0.04, true));
    assert!(little > 0.9 && much < 0.8, "{little} {much}");
    // So do samples that were cut and are not measured yet: four sectors of one disc promise less than four discs.
    let width_m = [118e-6, 119e-6, 121e-6, 122e-6];
    let cut = |disc: Option<&str>| {
        let pattern = |width_m| Pattern::new(Planform::Groove, width_m, 300e-6, 15e-6).unwrap();
        let cut = |width_m| CutSample {
            name: String::new(),
            date: String::new(),
            notes: String::new(),
            pattern: pattern(width_m),
            relief: None,
            map: None,
            land: None,
            dimensions_std_m: [0.0; 3],
            sample_std: None,
            disc: disc.map(str::to_owned),
            specimen: CutSpecimen::default(),
            measured: Vec::new(),
        };
        NextOptions { count: 1, pending: width_m.map(cut).to_vec(), ..NextOptions::default() }
    };
    let (disc, apart) = (chance_of(0.04, &cut(Some("disc 1"))), chance_of(0.04, &cut(None)));
    assert!(disc < apart - 0.1, "{disc} {apart}");
}

#[test]
fn what_the_laser_cannot_cut_is_said_with_the_number_of_the_sample() {
    let mut task = task(Planform::Groove);
    task.constraints.limits = ManufacturingLimits { spot_m: Some(20e-6), ..ManufacturingLimits::default() };
    // 20 um spots every 2 um on lines at most 10 um apart.
    task.laser = Laser {
        spot_um: Some(20.0),
        repetition_hz: Some(50e3),
        speed_mm_s: Some(100.0),
        hatch_um: Some(10.0),
        depth_per_burst_um: Some(0.2),
        ..Laser::default()
    };
    let groove = Pattern::new(Planform::Groove, 120e-6, 300e-6, 10e-6).unwrap();
    let step_um = task.laser.depth_step_um(&groove).unwrap();
    let said = |width_um: f64, depth_um: f64| -> Vec<String> {
        let whole = Pattern::new(Planform::Groove, 120e-6, 300e-6, 4e-6 * step_um).unwrap();
        let own = Pattern::new(Planform::Groove, width_um * 1e-6, 300e-6, depth_um * 1e-6).unwrap();
        laser_warnings(&task, [whole, own].iter())
    };
    assert_eq!(said(120.0, 4.01 * step_um), Vec::<String>::new());
    let off = said(120.0, 4.4 * step_um);
    assert!(
        off.len() == 1
            && off[0].starts_with("sample 2: 4 passes make ")
            && off[0].contains(" mm/s instead of 100 makes"),
        "{off:?}"
    );
    let narrow = said(15.0, 4.0 * step_um);
    assert!(narrow[0].contains("laser spot") && narrow.iter().all(|said| said.starts_with("sample 2: ")), "{narrow:?}");
}

/// Of the texture of a sector, which has no ends, another sample is cut on a whole specimen.
#[test]
fn another_sample_of_a_sector_has_the_chance_of_its_texture_on_the_specimen() {
    let grooves = task(Planform::Groove);
    let mut sector = trial(&grooves, [100e-6, 300e-6, 10e-6], [0.87, 0.87]);
    sector.measured.iter_mut().for_each(|at| at.modelled *= 0.95);
    for disc in [None, Some("disc 1".to_owned())] {
        let known = Trial { disc: disc.clone(), ..sector.clone() };
        let task = taught(&DesignTask { target: near(0.87, 0.03), ..grooves.clone() }, vec![known.clone()]);
        searched(&task, |search| {
            let best = search.best(&|_| true, 1).solved.remove(0);
            let pattern = search.task.space.pattern([100e-6, 300e-6, 10e-6]).unwrap();
            let whole = search.as_cut(&search.solved(&pattern).unwrap()).chance();
            let another = search.another_of(&known, &best).unwrap();
            assert_eq!((another - whole).abs() < 1e-12, disc.is_some(), "{another} {whole}");
        });
    }
}

#[test]
fn smaller_blocks_change_ratios_in_every_direction() {
    let mut task = task(Planform::Square);
    task.layer.height_m = 40e-6;
    let refined = |task: &DesignTask| {
        searched(task, |search| {
            let pattern = task.space.pattern([120e-6, 200e-6, 10e-6]).unwrap();
            let ratios = search.models.own.steady(&pattern).unwrap().ratio;
            search.models.refined(&pattern, &ratios, false).unwrap().0
        })
    };
    let one = refined(&task);
    task.directions.different_deg = vec![90.0];
    // Squares slide alike along both of their sides.
    let two = refined(&task);
    assert!(one.iter().all(|shift| shift.abs() > 1e-4), "{one:?}");
    for (own, other) in one.iter().chain(&one).zip(&two) {
        assert!((own - other).abs() < 1e-5, "{one:?} {two:?}");
    }
}
