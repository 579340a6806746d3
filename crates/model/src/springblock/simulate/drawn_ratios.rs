//! Steady sliding in space with the local coefficients drawn for dynamic runs, to separate the effect of the random
//! draw from the ratio.

use rayon::prelude::*;

use super::seed_of;
use crate::springblock::{
    Load, Monitor, Scene, SpaceLattice, SpaceLoad, SpaceSteadyModel, Status, SurfaceOutcome, draws,
};

/// Solves steady sliding of `model` along the unit vector `direction` at each load, with the dynamic coefficients
/// `drawn`, one list of all columns per load.
pub fn solve_drawn(
    scene: &Scene,
    model: &SpaceSteadyModel,
    direction: [f64; 2],
    drawn: Vec<Vec<f64>>,
    monitor: &dyn Monitor,
) -> Vec<SurfaceOutcome> {
    // Coefficients of the columns that touch, over their mean.
    let relative = |(load, drawn): (&Load, Vec<f64>)| -> Vec<f64> {
        let mean = load.friction.dynamic_mean();
        model.lattice().contacts().map(|column| drawn[column] / mean).collect()
    };
    let relative: Vec<Vec<f64>> = scene.loads.iter().zip(drawn).map(relative).collect();
    let mut loads = Vec::with_capacity(relative.len());
    for (load, relative) in scene.loads.iter().zip(&relative) {
        let mean = SpaceLoad::with_mean_friction(load, scene.area_law.as_ref(), direction);
        loads.push(SpaceLoad { relative_mu: Some(relative), ..mean });
    }
    model.solve_all(&loads, monitor)
}

/// Steady friction of a lattice over that of its flat counterpart, with mean local coefficients and with the
/// coefficients drawn for dynamic runs. The difference is the effect of the random draw.
pub struct SteadyRatios {
    /// Ratios with mean coefficients, by load.
    mean: Vec<Option<f64>>,
    /// Ratios with drawn coefficients: `drawn[draw][load]`.
    drawn: Vec<Vec<Option<f64>>>,
}

impl SteadyRatios {
    /// Solves a patterned and a flat lattice; `None` for a face with height variations, on which the set of touching
    /// blocks differs from draw to draw.
    pub fn new(
        scene: &Scene,
        lattices: [&SpaceLattice; 2],
        direction: [f64; 2],
        monitor: &dyn Monitor,
    ) -> Option<Self> {
        if lattices[0].is_raised() {
            return None;
        }
        let draws = scene.run.draws as usize;
        let friction: Vec<Vec<Vec<Option<f64>>>> = lattices
            .into_par_iter()
            .map(|lattice| {
                let model = SpaceSteadyModel::for_scene(scene, lattice.clone());
                let [nx, ny] = lattice.columns();
                let of_draw = |draw: Option<usize>| {
                    let of_load = |load: &Load| match draw {
                        None => vec![load.friction.dynamic_mean(); nx * ny],
                        Some(draw) => draws::draw(&load.friction, seed_of(scene, draw), nx * ny)
                            .iter()
                            .map(|drawn| drawn.dynamic_mu)
                            .collect(),
                    };
                    let coefficients = scene.loads.iter().map(of_load).collect();
                    let mu = |surface: SurfaceOutcome| {
                        surface.mu_dynamic.filter(|mu| *mu != 0.0 && surface.status == Status::Converged)
                    };
                    solve_drawn(scene, &model, direction, coefficients, monitor).into_iter().map(mu).collect()
                };
                std::iter::once(None).chain((0..draws).map(Some)).map(of_draw).collect()
            })
            .collect();
        let [own, flat] = <[_; 2]>::try_from(friction).ok()?;
        let ratio = |(own, flat): (&Option<f64>, &Option<f64>)| Some((*own)? / (*flat)?);
        let mut each = own.iter().zip(&flat).map(|(own, flat)| own.iter().zip(flat).map(ratio).collect());
        Some(Self { mean: each.next()?, drawn: each.collect() })
    }

    /// Ratios at load number `load` with mean coefficients and with draw number `draw`, in this order; `None` if the
    /// ratio with mean coefficients or that of any draw is missing.
    pub fn get(&self, load: usize, draw: usize) -> Option<(f64, f64)> {
        let all: Option<Vec<f64>> = self.drawn.iter().map(|drawn| drawn.get(load).copied().flatten()).collect();
        Some((self.mean.get(load).copied().flatten()?, *all?.get(draw)?))
    }
}
