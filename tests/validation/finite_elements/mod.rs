//! Interface pressure of a cell of squares compared with finite elements: trilinear hexahedra by scikit-fem with its
//! own mesh, equations and solver (`cell_pressure.py` in this folder wrote the table).

use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{SpaceLattice, SpaceLoad, SpaceSteadyModel, Status};

/// Rows of the table for squares of 10 um: mu, x and y in micrometres, mean pressure over the nominal one extrapolated
/// to vanishing elements, and the change by the extrapolation.
fn table() -> Vec<[f64; 5]> {
    include_str!("cell_pressure.csv")
        .lines()
        .skip(1)
        .map(|line| {
            let fields: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            let [finest, extrapolated] = [5, 6].map(|field: usize| fields[field]);
            [fields[0], fields[1], fields[2], extrapolated, (extrapolated - finest).abs()]
        })
        .collect()
}

/// Largest and root mean square difference from the table for blocks of `block_um`, relative to the nominal pressure.
fn difference(mu: f64, block_um: f64) -> [f64; 2] {
    let pattern = Pattern::new(Planform::Square, 60e-6, 100e-6, 20e-6).unwrap();
    let rows = (80.0 / block_um).round() as usize;
    let model =
        SpaceSteadyModel::new(SpaceLattice::cell(&pattern, block_um * 1e-6, rows), block_um * 1e-6, 0.38e9, false);
    let load = SpaceLoad { pressure_pa: 1e6, dynamic_mu: mu, relative_mu: None, area_law: None, direction: [1.0, 0.0] };
    let outcome = model.solve(&load);
    assert!(matches!(outcome.status, Status::Converged | Status::NoFriction), "{:?}", outcome.residual);
    // Means over squares of 10 um.
    let mut mean = [[0.0; 16]; 16];
    let share = (block_um / 10.0).powi(2);
    for point in &outcome.interface {
        let patch = |at_m: f64| (at_m * 1e5) as usize;
        mean[patch(point.x_m)][patch(point.y_m)] += share * point.pressure_pa / 1e6;
    }
    let rows: Vec<[f64; 5]> = table().into_iter().filter(|row| row[0] == mu).collect();
    let differences: Vec<f64> = rows
        .iter()
        .map(|[_, x_um, y_um, pressure, _]| mean[(x_um / 10.0) as usize][(y_um / 10.0) as usize] - pressure)
        .collect();
    let largest = differences.iter().fold(0.0, |most: f64, d| most.max(d.abs()));
    [largest, (differences.iter().map(|d| d * d).sum::<f64>() / differences.len() as f64).sqrt()]
}

/// The root mean square difference decreases about in proportion to the block size, the largest one, at corners and
/// edges, somewhat more slowly.
#[test]
fn pressure_under_squares_converges_to_that_of_finite_elements() {
    for (mu, root_mean_square, largest) in [(0.0, 0.006, 0.017), (0.27, 0.0095, 0.036)] {
        let [coarse, middle, fine] = [10.0, 5.0, 2.5].map(|block_um| difference(mu, block_um));
        let said = format!("mu {mu}: {coarse:.4?} {middle:.4?} {fine:.4?}");
        assert!(fine[0] < largest && fine[1] < root_mean_square, "{said}");
        assert!(coarse[1] > 1.8 * middle[1] && middle[1] > 1.8 * fine[1], "{said}");
        assert!(coarse[0] > 1.7 * middle[0] && middle[0] > 1.7 * fine[0], "{said}");
    }
}
