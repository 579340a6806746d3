use super::*;

fn point(pressure_pa: f64, value: f64) -> TargetPoint {
    TargetPoint { pressure_pa, value }
}

fn demands(wanted: &[(Wanted, f64)]) -> Vec<Demand> {
    let demand = |(place, &(wanted, weight)): (usize, &(Wanted, f64))| Demand {
        pressure_pa: 1e6 * (place + 1) as f64,
        wanted,
        weight,
    };
    wanted.iter().enumerate().map(demand).collect()
}

#[test]
fn misfit_counts_in_tolerances() {
    let target = Target::new(Quantity::Ratio, vec![point(1e6, 0.9), point(2e6, 0.8)], 0.01).unwrap();
    let misfit = target.misfit(&[0.93, 0.76]);
    assert!((misfit.max - 4.0).abs() < 1e-12);
    assert!((misfit.rms - 12.5_f64.sqrt()).abs() < 1e-12 && misfit.cost == misfit.rms);
    assert!(!misfit.is_met() && target.misfit(&[0.905, 0.795]).is_met());
}

#[test]
fn at_several_conditions_every_value_counts() {
    let near = |value| Wanted::Near { value, tolerance: 0.01 };
    let alone = Target::of(Quantity::Ratio, demands(&[(near(0.9), 1.0), (near(0.8), 2.0)]), None).unwrap();
    let both = alone.at_conditions(2);
    assert_eq!((both.points(), both.conditions(), both.values()), (alone.points(), 2, 4));
    // Residuals 0.5, 0.5 at the first condition and 2, -1 at the second, weights 1 and 2.
    let values = [0.905, 0.805, 0.92, 0.79];
    let misfit = both.misfit(&values);
    assert!((misfit.max - 2.0).abs() < 1e-9 && alone.misfit(&values).is_met() && !misfit.is_met());
    assert!((misfit.rms - ((0.25 + 0.5 + 4.0 + 2.0) / 6.0_f64).sqrt()).abs() < 1e-9);
    let residuals = both.residuals(&values).unwrap();
    assert!(((residuals.iter().map(|r| r * r).sum::<f64>() / 4.0).sqrt() - misfit.rms).abs() < 1e-12);
    // The search minimizes that of the worst condition.
    assert!(
        (misfit.cost - 2.0_f64.sqrt()).abs() < 1e-9
            && misfit.cost == both.misfit(&[&values[2..], &values[..2]].concat()).cost
    );
    assert_eq!(both.edges(&values).len(), 8);
    // The first condition's values alone have their own largest residual.
    assert_eq!(both.misfit(&values[..2]).max, alone.misfit(&values[..2]).max);
    // Robust searches ask all that of every sample.
    assert_eq!(both.repeated(3).values(), 12);
    let lowest = Target::of(Quantity::Ratio, demands(&[(Wanted::Anything, 1.0)]), Some(Goal::Lowest)).unwrap();
    assert_eq!(lowest.at_conditions(2).goal_value(&[0.8, 0.9]), Some(0.9));
    let highest = Target::of(Quantity::Ratio, demands(&[(Wanted::Anything, 1.0)]), Some(Goal::Highest)).unwrap();
    assert_eq!(highest.at_conditions(2).goal_value(&[0.8, 0.9]), Some(0.8));
    // Even over the pressures at each condition, whatever lies between conditions.
    let even = Target::of(Quantity::Ratio, demands(&[(Wanted::Anything, 1.0); 2]), Some(Goal::Even)).unwrap();
    let even = even.at_conditions(2);
    assert_eq!((even.goal_value(&[0.8, 0.8, 0.9, 0.9]), even.misfit(&[0.8, 0.8, 0.9, 0.9]).cost), (Some(0.0), 0.0));
    assert!(even.residuals(&[0.8, 0.8, 0.9, 0.9]).unwrap().iter().all(|residual| *residual == 0.0));
    assert!((even.goal_value(&[0.8, 0.8, 0.5, 1.3]).unwrap() - 0.4 / 0.9).abs() < 1e-12);
    // Samples of robust searches, one after the other, each at both conditions: the worst over its samples.
    let samples = lowest.at_conditions(2).repeated(2);
    assert!((samples.goal_value(&[0.8, 0.9, 0.6, 0.7]).unwrap() - 0.8).abs() < 1e-12);
    assert_eq!(alone.at_conditions(1), alone);
}

#[test]
fn every_kind_of_demand_is_met_up_to_its_edge() {
    let near = Wanted::Near { value: 0.9, tolerance: 0.02 };
    let between = Wanted::Between { lowest: 0.88, highest: 0.92 };
    let least = Wanted::AtLeast { lowest: 0.88, margin: 0.02 };
    let most = Wanted::AtMost { highest: 0.92, margin: 0.02 };
    for (value, residuals) in [
        (0.86, [-2.0, -2.0, -2.0, 0.0]),
        (0.88, [-1.0, -1.0, -1.0, 0.0]),
        (0.9, [0.0; 4]),
        (0.91, [0.5, 0.5, 0.0, 0.5]),
        (0.92, [1.0, 1.0, 0.0, 1.0]),
        (1.2, [15.0, 15.0, 0.0, 15.0]),
    ] {
        for (wanted, residual) in [near, between, least, most].into_iter().zip(residuals) {
            assert!((wanted.residual(value) - residual).abs() < 1e-9, "{wanted:?} {value}");
        }
    }
    assert_eq!(Wanted::Anything.residual(5.0), 0.0);
    assert_eq!(least.band(), [Some(0.88), None]);
    assert_eq!(most.tolerance(), Some(0.02));
}

#[test]
fn weights_count_in_the_mean_square_and_not_in_what_is_met() {
    let near = |value| Wanted::Near { value, tolerance: 0.01 };
    let target = Target::of(Quantity::Ratio, demands(&[(near(0.9), 3.0), (near(0.8), 1.0)]), None).unwrap();
    // sqrt((3 * 1^2 + 1 * 2^2) / 4)
    let values = [0.91, 0.82];
    let misfit = target.misfit(&values);
    assert!((misfit.max - 2.0).abs() < 1e-9 && (misfit.rms - 1.75_f64.sqrt()).abs() < 1e-9);
    let residuals = target.residuals(&values).unwrap();
    let rms = (residuals.iter().map(|r| r * r).sum::<f64>() / 2.0).sqrt();
    assert!((rms - misfit.cost).abs() < 1e-12);
}

#[test]
fn goals_rank_by_their_mean_or_their_spread() {
    let free = |goal| Target::of(Quantity::Ratio, demands(&[(Wanted::Anything, 1.0); 2]), Some(goal)).unwrap();
    let (low, high, uneven) = ([0.8, 0.9], [0.9, 0.9], [0.5, 1.3]);
    let (lowest, highest, even) = (free(Goal::Lowest), free(Goal::Highest), free(Goal::Even));
    assert!(lowest.misfit(&low).cost < lowest.misfit(&high).cost);
    assert!(highest.misfit(&high).cost < highest.misfit(&low).cost);
    assert_eq!(even.misfit(&high).cost, 0.0);
    // Standard deviation 0.4 of mean 0.9, in per cent; residuals say the same.
    assert!((even.misfit(&uneven).cost - 100.0 * 0.4 / 0.9).abs() < 1e-9);
    let residuals = even.residuals(&uneven).unwrap();
    assert!(((residuals.iter().map(|r| r * r).sum::<f64>() / 2.0).sqrt() - 100.0 * 0.4 / 0.9).abs() < 1e-9);
    assert_eq!(even.goal_value(&high), Some(0.0));
    assert!((lowest.goal_value(&low).unwrap() - 0.85).abs() < 1e-12);
    // A hundredth less is 1 cheaper, whatever the mean.
    for mean in [0.2, 0.9] {
        let gain = lowest.misfit(&[mean; 2]).cost - lowest.misfit(&[mean * 0.99; 2]).cost;
        assert!((gain - 1.005).abs() < 1e-3, "{gain}");
    }
    assert!(lowest.misfit(&low).is_met() && lowest.residuals(&low).is_none());
}

#[test]
fn a_goal_within_a_band_pays_more_for_leaving_it_than_it_can_gain() {
    let between = Wanted::Between { lowest: 0.8, highest: 0.9 };
    let target = Target::of(Quantity::Ratio, demands(&[(between, 1.0)]), Some(Goal::Lowest)).unwrap();
    let cost = |value| target.misfit(&[value]).cost;
    assert!(cost(0.81) < cost(0.85) && cost(0.81) < cost(0.799) && cost(0.799) < cost(0.7));
    assert!(target.misfit(&[0.8001]).is_met() && !target.misfit(&[0.799]).is_met());
}

#[test]
fn targets_that_mean_nothing_are_refused() {
    let new = |points, tolerance| Target::new(Quantity::Ratio, points, tolerance);
    assert_eq!(new(vec![], 0.01), Err(SearchError::NoTargetPoints));
    assert!(matches!(new(vec![point(1e6, 0.9); 2], 0.01), Err(SearchError::RepeatedPressure { .. })));
    for (pressure_pa, value, tolerance) in [(0.0, 0.9, 0.01), (1e6, f64::NAN, 0.01), (1e6, 0.9, 0.0)] {
        assert!(matches!(new(vec![point(pressure_pa, value)], tolerance), Err(SearchError::OutOfRange { .. })));
    }
    let of = |wanted, weight, goal| Target::of(Quantity::Ratio, demands(&[(wanted, weight)]), goal);
    assert_eq!(of(Wanted::Anything, 1.0, None), Err(SearchError::NothingWanted));
    assert_eq!(of(Wanted::Anything, 1.0, Some(Goal::Even)), Err(SearchError::OnePressure));
    assert!(matches!(of(Wanted::Anything, 0.0, Some(Goal::Lowest)), Err(SearchError::OutOfRange { .. })));
    let reversed = Wanted::Between { lowest: 0.9, highest: 0.8 };
    assert!(matches!(of(reversed, 1.0, None), Err(SearchError::OutOfRange { .. })));
}
