//! Values that stand beside a design: trade-offs, and the sliders of the page.

use slipgrid_base::units::tidy;

use super::*;
use crate::explorer::explore_bounds;
use crate::{TradeOffGoal, TradeOffsWanted, trade_offs};

#[test]
fn a_trade_off_beside_the_design_has_its_chance() {
    for mut task in three_tasks() {
        let goals = vec![TradeOffGoal::Chance, TradeOffGoal::Volume];
        task.trade_offs = Some(TradeOffsWanted { goals, designs: 200 });
        searched(&task, |search| {
            let best = search.best(&|_| true, 1).solved.remove(0);
            let beside = best.texture.pattern.lengths_m().map(|length_m| length_m * (1.0 - 1e-9));
            let beside = search.solved(&search.task.space.pattern(beside).unwrap()).unwrap();
            let (report, compared) =
                trade_offs::of(search, (&best, best.texture.run.as_deref()), std::slice::from_ref(&beside)).unwrap();
            assert_eq!(report.chosen[0], tidy(best.chance()));
            let mut all = compared.front.iter().chain(&compared.dominated);
            let known = all.find(|known| known.design == beside.texture.pattern).unwrap();
            assert!((known.goals[0] - best.chance()).abs() < 1e-4, "{known:?} {}", best.chance());
        });
    }
}

#[test]
fn a_page_begins_with_what_is_reported_of_its_design() {
    searched(&three_tasks()[1], |search| {
        let best = search.best(&|_| true, 1).solved.remove(0);
        let run = best.texture.run.clone().unwrap();
        let explorer = Explorer::new(search, &best, Some(&run)).unwrap();
        let about_um = best.texture.pattern.lengths_m().map(|m| 1e6 * m);
        let face = search.task.specimen.layout(best.texture.pattern).unwrap();
        let (expected, chance) = explorer.sample(&face);
        assert!((chance - best.chance()).abs() < 1e-9, "{chance} {}", best.chance());
        let off = expected.iter().zip(best.medians()).map(|(own, median)| (own - median).abs());
        assert!(off.fold(0.0, f64::max) < 1e-9, "{expected:?}");
        let beside = explorer.beside.at(&about_um);
        assert!((beside[0].exp() / (1e-6 * run.peak_pressure_pa()) - 1.0).abs() < 1e-9, "{beside:?}");
        assert!((beside[4] / face.areal_density() - 1.0).abs() < 1e-9, "{beside:?}");
    });
}

#[test]
fn a_page_begins_at_a_texture_with_an_answer() {
    let mut task = task(Planform::Groove);
    let known = &mut task.material.as_mut().unwrap().material;
    known.area_law = Some(AreaLaw::new(vec![0.7e6, 1.3e6, 2.6e6, 10e6], vec![1.0, 0.9, 0.7, 0.3]).unwrap());
    let points = [(0.65e6, 0.95), (2.6e6, 0.88)].map(|(pressure_pa, value)| TargetPoint { pressure_pa, value });
    task.target = Target::new(Quantity::Ratio, points.to_vec(), 0.02).unwrap();
    // Wide cavities of a soft, thick specimen close where they are shallow.
    task.space = DesignSpace::new(Planform::Groove, [380e-6; 2], [300e-6, 1000e-6], [2e-6, 10e-6]).unwrap();
    task.constraints.limits.depth_per_burst_m = Some(2.6e-6);
    task.layer = Layer { height_m: 200e-6, block_m: 10e-6, thickness_m: Some(7e-3), ..task.layer };
    let best = searched(&task, |search| search.greatest(&|_| true).0.unwrap().texture.pattern);
    let found = explore_bounds(&task, &*KNOWN).unwrap();
    let at = |pattern: &Pattern| found.predict(pattern.lengths_m().map(|m| 1e6 * m));
    assert!(at(&best).is_none() && at(&found.pattern).is_some(), "{best:?} {:?}", found.pattern);
}

/// Whole passes or bursts, and the lines or spots that a width takes, are counted; what is interpolated is smooth.
#[test]
fn sliders_have_the_time_under_the_laser_of_every_texture() {
    let spots =
        Laser { spot_um: Some(23.0), repetition_hz: Some(1e3), depth_per_burst_um: Some(2.6), ..Laser::default() };
    let lines = Laser { speed_mm_s: Some(9.0), hatch_um: Some(15.0), ..spots };
    let mut normals = Normals::new(11);
    for laser in [spots, lines] {
        let mut task = task(Planform::Groove);
        task.laser = laser;
        let found = explore_bounds(&task, &*KNOWN).unwrap();
        let mut off = Vec::new();
        while off.len() < 60 {
            let pattern = random(&task, &mut normals);
            let Some(read) = found.predict(pattern.lengths_m().map(|m| 1e6 * m)) else { continue };
            off.push((read.laser_s.unwrap() / task.laser_time_s(&pattern).unwrap()).ln().abs());
        }
        let worst = off.iter().copied().fold(0.0, f64::max);
        assert!(worst < 0.005, "{laser:?}: {worst}");
    }
}
