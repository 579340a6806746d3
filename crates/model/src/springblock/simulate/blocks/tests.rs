use super::*;
use crate::springblock::RunOptions;
use crate::springblock::tests::samples;

#[test]
fn a_series_of_known_order_is_bounded_and_not_by_much() {
    for order in [0.5_f64, 0.7, 1.0, 1.5, 2.0] {
        // r(l) = c l^p
        let ratio = |block: f64| 0.01 * block.powf(order);
        for (blocks, first) in [([1.0, 0.5, 0.25], 0), ([2.0, 1.0, 0.5], 1), ([4.0, 2.0, 1.0], 2)] {
            let [coarse, middle, fine] = blocks.map(ratio);
            let found = error([middle - coarse, fine - middle], first);
            assert!(found >= ratio(1.0) && found <= 1.51 * ratio(1.0), "{order} {first}: {found}");
        }
    }
}

#[test]
fn loads_are_as_uncertain_as_their_neighbours() {
    let errors = [0.1, 0.5, 0.2, 0.0, 0.0];
    assert_eq!(largest_near(&errors, 1), [0.5, 0.5, 0.5, 0.2, 0.0]);
    assert_eq!(largest_near(&errors, 5), [0.5; 5]);
}

#[test]
fn the_groove_of_a_cavity_with_rims_has_as_much_edge() {
    let rim = crate::pattern::Rim::new(0.8e-6, 60e-6, crate::pattern::RimProfile::Flat).unwrap();
    for planform in [Planform::Groove, Planform::Square, Planform::Disc] {
        let pattern = crate::springblock::tests::samples::pattern(planform, 130.0, 370.0, 5.2);
        assert_eq!(edge_groove(&pattern), None);
        let pattern = pattern.with_rim(rim);
        let groove = edge_groove(&pattern).unwrap();
        assert!((groove.edge_per_area_1_m() / pattern.edge_per_area_1_m() - 1.0).abs() < 1e-12, "{planform}");
        assert_eq!((groove.width_m(), groove.depth_m()), (pattern.width_m(), pattern.depth_m()));
        assert_eq!(groove.texture().rim(), pattern.texture().rim());
    }
    let dense = crate::springblock::tests::samples::pattern(Planform::Square, 100.0, 20.0, 5.2).with_rim(rim);
    assert_eq!(edge_groove(&dense), None);
}

#[test]
fn raised_lands_are_open_by_what_finer_blocks_change_and_leave() {
    let is = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-12, "{found} {expected}");
    is(raised_error([-0.016, 0.002], 0), 2.0 * 0.014_f64.hypot(0.003));
    is(raised_error([-0.016, 0.002], 1), 2.0 * 0.002_f64.hypot(0.003));
    is(raised_error([-0.016, 0.002], 2), 0.006);
}

#[test]
fn rough_changes_of_shallow_cavities_are_those_of_finer_blocks() {
    for (width, spacing) in [(40.0, 1000.0), (120.0, 200.0)] {
        let pattern = samples::groove(width, spacing, 2.0);
        let scene = samples::scene(pattern, &[0.65, 1.3, 2.6], RunOptions::default());
        let [rough, fine] = [(2e8, true), (2e9, false)].map(|(most, is_rough)| {
            block_refinement(&scene, &[], most, is_rough).unwrap_or_else(|| panic!("{width} {is_rough}"))
        });
        assert_eq!((rough.factor, fine.factor), (0.125, 0.0625));
        for (rough, fine) in rough.shifts.iter().zip(&fine.shifts) {
            // Interpolation between few textures leaves 0.0036 of these changes.
            let off = (rough - fine).abs();
            assert!(off < 0.0036 && off < 0.5 * fine.abs(), "{width}: {rough} {fine}");
        }
    }
}

#[test]
fn differences_that_change_sign_do_not_cancel() {
    let found = error([0.004, -0.003], 0);
    assert!((found - (0.007 + 1.5 * 0.003 / (2.0_f64.sqrt() - 1.0))).abs() < 1e-12);
    assert_eq!((error([0.0, 0.0], 0), error([0.001, 0.0], 0), error([0.001, 0.0], 1)), (0.0, 0.001, 0.0));
}

#[test]
fn ratios_that_are_not_taken_to_smaller_blocks_say_why() {
    use crate::springblock::simulate;
    let statements = |pattern: Pattern, refine: bool| {
        let mut scene = samples::scene(pattern, &[2.6], RunOptions { refine, ..RunOptions::default() });
        scene.layer.height_m = 40e-6;
        let model = simulate(&scene, &Unwatched).unwrap().statements.model;
        model.into_iter().filter(|statement| statement.starts_with("refine")).collect::<Vec<String>>()
    };
    let crossing = samples::pattern(crate::pattern::Planform::Crosshatch, 60.0, 60.0, 20.0);
    let unrefined = "refine = true changes nothing: ratios stay those of blocks of 10 um, since ";
    let of_space = "cells in space with rims or measured heights are like no grooves in the plane";
    let rim = crate::pattern::Rim::new(0.2e-6, 20e-6, crate::pattern::RimProfile::Flat).unwrap();
    assert_eq!(statements(crossing.with_rim(rim), true), [format!("{unrefined}{of_space}")]);
    let shallow = "cavities 0.5 um deep are shallower than two of the finest blocks, of 0.313 um";
    assert_eq!(statements(samples::groove(60.0, 60.0, 0.5), true), [format!("{unrefined}{shallow}")]);
    assert!(
        [crossing, samples::groove(60.0, 60.0, 2.0)].into_iter().all(|pattern| statements(pattern, false).is_empty())
    );
    // Grooves of sufficient depth are refined, without such a statement.
    assert!(
        statements(samples::groove(60.0, 60.0, 20.0), true).iter().all(|statements| !statements.contains("not taken"))
    );
    let groove = samples::groove(60.0, 60.0, 20.0);
    let scene = samples::scene(groove, &[2.6], RunOptions::default());
    let dear = "steady cells in blocks of 10 um are too dear".to_owned();
    assert_eq!(refine_in_plane(&scene, &groove, (1.0, Finest::AS_SOLVED), &Unwatched), Err(dear));
    let found = BlockRefinement { factor: 0.125, shifts: vec![0.0], errors: vec![0.002] };
    assert_eq!(require_improvement(&[], found.clone(), 1.0, 10e-6), Err(UNKNOWN.to_owned()));
    let simulation = simulate(&scene, &Unwatched).unwrap();
    let own = simulation.loads[0].correction(Effect::Blocks).unwrap().std.unwrap() * 2.0;
    let not_better = BlockRefinement { errors: vec![2.0 * own], ..found.clone() };
    let refused = require_improvement(&simulation.loads, not_better, 1.0, 10e-6).unwrap_err();
    assert!(refused.contains("blocks of 1.25 um would leave them open by"), "{refused:?}");
    let good = BlockRefinement { errors: vec![0.5 * own], ..found };
    assert!(require_improvement(&simulation.loads, good, 1.0, 10e-6).is_ok());
}
