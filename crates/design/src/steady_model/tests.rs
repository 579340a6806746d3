use super::*;
use crate::operating_conditions::turned;
use slipgrid_laser::export::{Outline, Specimen};
use slipgrid_model::material::{Elastic, LocalFriction};
use slipgrid_model::pattern::{Planform, Rim, RimProfile, Texture};
use slipgrid_model::springblock::{Dimension, Layer, simulate};

fn scene() -> Scene {
    let friction = LocalFriction::new(0.30, 0.27, 0.05).unwrap();
    Scene {
        elastic: Elastic::new(0.38e9, 900.0).unwrap(),
        area_law: Some(AreaLaw::new(vec![0.7e6, 10e6], vec![1.0, 0.6]).unwrap()),
        pattern: None,
        relief: None,
        layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None },
        loads: vec![Load { pressure_pa: 0.65e6, friction }, Load { pressure_pa: 2.6e6, friction }],
        speed_m_s: 2e-3,
        run: RunOptions::default(),
    }
}

/// Loads of `scene` with a third more friction.
fn louder(scene: &Scene) -> Vec<Load> {
    let friction = LocalFriction::new(0.4, 0.36, 0.05).unwrap();
    scene.loads.iter().map(|load| Load { friction, ..*load }).collect()
}

fn space(planform: Planform) -> DesignSpace {
    DesignSpace::new(planform, [40e-6, 400e-6], [40e-6, 1000e-6], [2e-6, 50e-6]).unwrap()
}

/// Tolerance for ratios, and relative for pressures, of cells in space compared to `simulate`, which balances forces to
/// 1e-10 of the load; a search stops at 1e-7.
const LOOSE: f64 = 1e-7;
const LOOSE_PRESSURE: f64 = 1e-5;

#[test]
fn the_search_sees_what_simulate_reports() {
    for (planform, dimensions, expected) in
        [(Planform::Groove, None, 2), (Planform::Square, None, 3), (Planform::Square, Some(2), 2)]
    {
        let design = Pattern::new(planform, 130.3e-6, 171e-6, 13e-6).unwrap();
        let run = RunOptions { dimensions, ..RunOptions::default() };
        let model = SteadyModel::new(&Scene { run, ..scene() }, &[], &[], &space(planform));
        assert_eq!([model.dimension(), model.cell(&design, false).dimension()].map(Dimension::number), [expected; 2]);
        let simulation = simulate(&model.cell(&design, false), &Unwatched).unwrap();
        let [ratio, pressure] = if expected == 3 { [LOOSE, LOOSE_PRESSURE] } else { [1e-9; 2] };
        let answer = model.steady(&design).unwrap();
        for (found, outcome) in answer.ratio.iter().zip(&simulation.loads) {
            assert!((found - outcome.ratio().unwrap()).abs() < ratio);
        }
        let peak = simulation.peak_pressure_pa();
        assert!((answer.peak_pressure_pa() / peak - 1.0).abs() < pressure);
        let points = simulation
            .loads
            .iter()
            .flat_map(|load| load.surface.interface.iter().map(|point| point.pressure_pa / load.pressure_pa));
        assert!((answer.least_pressure - points.fold(f64::INFINITY, f64::min)).abs() < pressure);
        assert!(answer.clearance_m().is_some_and(|least_m| least_m > 0.0 && least_m < design.depth_m()));
    }
    let deep = Pattern::new(Planform::Groove, 130e-6, 370e-6, 250e-6).unwrap();
    let model = SteadyModel::new(&scene(), &[], &[], &space(Planform::Groove));
    assert!(matches!(model.steady(&deep), Err(ModelFailure::Trial(_))));
}

#[test]
fn a_guide_in_larger_blocks_is_near() {
    let design = Pattern::new(Planform::Square, 130e-6, 170e-6, 20e-6).unwrap();
    let model = SteadyModel::new(&scene(), &[], &[], &space(Planform::Square));
    let [own, guided] = [false, true].map(|coarse| model.tabulated(&design, coarse).unwrap().ratio);
    assert_eq!(own, model.steady(&design).unwrap().ratio);
    assert!(own.iter().zip(&guided).all(|(own, guide)| own != guide && (own - guide).abs() < 0.01));
    let block_m = |model: &SteadyModel<'_>, design: &Pattern| model.cell(design, true).layer.block_m;
    assert!((block_m(&model, &design) - 40e-6).abs() < 1e-12);
    // A guide saves nothing in the plane, and a pitch of 60 um cannot have blocks of 40 um.
    assert!(!SteadyModel::new(&scene(), &[], &[], &space(Planform::Groove)).has_guide());
    let narrow = DesignSpace::new(Planform::Square, [20e-6, 400e-6], [40e-6; 2], [5e-6; 2]).unwrap();
    assert!((block_m(&SteadyModel::new(&scene(), &[], &[], &narrow), &design) - 20e-6).abs() < 1e-12);
}

#[test]
fn further_conditions_are_solved_with_their_own_coefficients_and_limits_are_the_worst_of_all() {
    let scene = scene();
    let louder = louder(&scene);
    let design = Pattern::new(Planform::Groove, 130e-6, 170e-6, 20e-6).unwrap();
    let model = SteadyModel::new(&scene, &[&louder], &[], &space(Planform::Groove));
    let there = Scene { loads: louder, ..scene.clone() };
    let alone = |scene: &Scene| SteadyModel::new(scene, &[], &[], &space(Planform::Groove));
    let own = [alone(&scene), alone(&there)].map(|model| model.steady(&design).unwrap());
    let both = model.steady(&design).unwrap();
    assert_eq!(both.ratio, [&own[0].ratio[..], &own[1].ratio[..]].concat());
    assert!(own[1].ratio[1] != own[0].ratio[1]);
    let worst = own[0].peak_pressure_mpa.max(own[1].peak_pressure_mpa);
    assert_eq!((both.peak_pressure_mpa, own[1].peak_pressure_mpa), (worst, worst));
    assert_eq!(both.least_pressure, own[0].least_pressure.min(own[1].least_pressure));
}

#[test]
fn further_directions_are_those_of_the_turned_design_solved_alone() {
    let scene = scene();
    let louder = louder(&scene);
    let texture = Texture::new(Planform::Rectangle).with_length_m(80e-6).unwrap();
    let space = DesignSpace::new(texture, [40e-6, 400e-6], [40e-6, 1000e-6], [2e-6, 50e-6]).unwrap();
    let design = Pattern::new(texture, 160e-6, 80e-6, 20e-6).unwrap();
    let coarse = Scene { layer: Layer { block_m: 20e-6, ..scene.layer }, ..scene };
    // Two conditions in each of two directions.
    let further = [&louder[..], &coarse.loads[..], &louder[..]];
    let model = SteadyModel::new(&coarse, &further, &[90.0], &space);
    let found = model.steady(&design).unwrap();
    let alone = |angle_deg: f64, loads: &[Load]| {
        let scene = Scene { loads: loads.to_vec(), ..coarse.clone() };
        SteadyModel::new(&scene, &[], &[], &space).steady(&turned(&design, Some(angle_deg))).unwrap()
    };
    let each = [(0.0, &coarse.loads), (0.0, &louder), (90.0, &coarse.loads), (90.0, &louder)]
        .map(|(angle_deg, loads)| alone(angle_deg, loads));
    let expected: Vec<f64> = each.iter().flat_map(|answer| answer.ratio.clone()).collect();
    assert!(found.ratio.iter().zip(&expected).all(|(a, b)| (a - b).abs() < LOOSE), "{found:?} {expected:?}");
    assert!((expected[1] - expected[5]).abs() > 1e-4, "long cavities slide otherwise across: {expected:?}");
    let worst = each.iter().map(|answer| answer.peak_pressure_mpa).fold(0.0, f64::max);
    assert!((found.peak_pressure_mpa / worst - 1.0).abs() < LOOSE_PRESSURE);
    let beside = model.beside(|scene| Ok::<_, ()>(scene.clone())).unwrap();
    assert_eq!(beside.steady(&design).unwrap().ratio.len(), 8);
    // Slopes are computed in the guide's blocks.
    assert!((beside.steady(&design).unwrap().ratio[0] - found.ratio[0]).abs() > 1e-4);
}

#[test]
fn samples_whose_rims_are_of_another_height_have_answers_of_their_own() {
    let rimmed = |height_um: f64| {
        let rim = Rim::new(height_um * 1e-6, 20e-6, RimProfile::Flat).unwrap();
        Texture::new(Planform::Groove).with_rim(rim)
    };
    let space = DesignSpace::new(rimmed(0.1), [40e-6, 400e-6], [40e-6, 1000e-6], [2e-6, 50e-6]).unwrap();
    let model = SteadyModel::new(&scene(), &[], &[], &space);
    let ratio = |height_um: f64| {
        let design = Pattern::new(rimmed(height_um), 130e-6, 370e-6, 13e-6).unwrap();
        model.steady(&design).unwrap().ratio[0]
    };
    let (own, higher, again) = (ratio(0.1), ratio(0.2), ratio(0.1));
    assert!(own == again && higher < own - 0.01, "{own} {higher}");
    assert_eq!(ratio(0.2), higher);
    // A design without rims equals one with rims of zero height.
    let plain = SteadyModel::new(&scene(), &[], &[], &self::space(Planform::Groove));
    let bare = plain.steady(&Pattern::new(Planform::Groove, 130e-6, 370e-6, 13e-6).unwrap()).unwrap().ratio[0];
    assert_eq!(ratio(0.0), bare);
    assert!(own < bare);
}

#[test]
fn a_sample_made_of_a_design_has_as_many_cavities_as_it() {
    let texture = Texture::new(Planform::Disc);
    let design = Pattern::new(texture, 188e-6, 76e-6, 12e-6).unwrap();
    let coarse = Scene { layer: Layer { block_m: 20e-6, ..scene().layer }, ..scene() };
    let specimen = Specimen { outline: Outline::Disc { diameter_m: 2e-3 }, is_clipped: false };
    let cell = SteadyModel::new(&coarse, &[], &[], &space(Planform::Disc));
    let laid = SteadyModel::new(&coarse, &[], &[], &space(Planform::Disc)).on(specimen);
    let wider = |by_m: f64| Pattern::new(texture, 188e-6 + by_m, 76e-6, 12e-6).unwrap();
    let (thin, wide) = (wider(-8e-6), wider(8e-6));
    let change = |of: &dyn Fn(&Pattern) -> f64| of(&wide) - of(&thin);
    let of_cell = change(&|at| cell.steady(at).unwrap().ratio[1]);
    let made = change(&|at| laid.ratios_made(at, &laid.lay(&design).unwrap()).unwrap()[1]);
    let designed = change(&|at| laid.steady(at).unwrap().ratio[1]);
    // The number of cavities stays constant: 264 um of the face as designed scale with the period as made.
    let share = laid.lay(&design).unwrap().share(&design);
    let on = |at: &Pattern| 1.0 - share * (at.pitch_m() / 264e-6).powi(2) * (1.0 - cell.steady(at).unwrap().ratio[1]);
    assert!((made - change(&on)).abs() < 1e-9 && made / of_cell > 1.0, "{made} of {of_cell}, share {share}");
    // A new layout keeps the number of cavities.
    assert!((designed - made).abs() < 1e-9, "{designed}");
}

#[test]
fn spacing_that_is_off_moves_cavities_and_makes_none() {
    let specimen = Specimen { outline: Outline::Rectangle { length_m: 8e-3, width_m: 4e-3 }, is_clipped: false };
    let model = SteadyModel::new(&scene(), &[], &[], &space(Planform::Groove)).on(specimen);
    let grooves = |spacing_um: f64| Pattern::new(Planform::Groove, 200e-6, spacing_um * 1e-6, 20e-6).unwrap();
    let ratio = |made_um: f64, designed_um: f64| {
        model.ratios_made(&grooves(made_um), &model.lay(&grooves(designed_um)).unwrap()).unwrap().iter().sum::<f64>()
    };
    // 21 of 383 um and a width of 200 um end 140 um before the sides; 23 of 353 um end 34 um before them, and fit no longer at 356.
    for (made_um, designed_um) in [(184.0, 183.0), (182.0, 183.0), (154.0, 153.0), (152.0, 153.0)] {
        let (made, anew) = (ratio(made_um, designed_um), ratio(made_um, made_um));
        assert!((made - anew).abs() < 1e-9, "{made_um}: {made} and {anew}");
    }
    let (made, anew, own) = (ratio(156.0, 153.0), ratio(156.0, 156.0), ratio(153.0, 153.0));
    assert!((made - own).abs() < 0.1 * (anew - own).abs(), "{made}, laid anew {anew}, designed {own}");
}
