//! Steady sliding in space with the local coefficients that runs in time draw: what a ratio has by its draw alone.

use rayon::prelude::*;

use super::seed_of;
use crate::Monitor;
use crate::draws;
use crate::outcome::{Status, SurfaceOutcome};
use crate::scene::{Load, Scene};
use crate::space::{SpaceLattice, SpaceLoad, SpaceSteadyModel};

/// Steady sliding on `lattice`.
pub fn model_of(scene: &Scene, lattice: &SpaceLattice) -> SpaceSteadyModel {
    let stiffness_pa = scene.elastic.youngs_modulus_pa();
    SpaceSteadyModel::new(lattice.clone(), scene.layer.block_m, stiffness_pa, scene.run.liftoff)
}

/// Steady sliding of `model` at each load with the coefficients `drawn` of its columns, load by load.
pub fn solve_drawn(
    scene: &Scene,
    model: &SpaceSteadyModel,
    direction: [f64; 2],
    drawn: Vec<Vec<f64>>,
    monitor: &dyn Monitor,
) -> Vec<SurfaceOutcome> {
    let lattice = model.lattice();
    let [nx, ny] = lattice.columns();
    // The coefficients of the columns that touch, over their mean.
    let relative = |(load, drawn): (&Load, Vec<f64>)| -> Vec<f64> {
        let mean = load.friction.dynamic_mean();
        let touching = (0..nx * ny).filter(|column| lattice.contact_share(column % nx, column / nx) > 0.0);
        touching.map(|column| drawn[column] / mean).collect()
    };
    let relative: Vec<Vec<f64>> = scene.loads.iter().zip(drawn).map(relative).collect();
    let mut loads = Vec::with_capacity(relative.len());
    for (load, relative) in scene.loads.iter().zip(&relative) {
        let mean = SpaceLoad::of_mean(load, scene.area_law.as_ref(), direction);
        loads.push(SpaceLoad { relative_mu: Some(relative), ..mean });
    }
    model.solve_all(&loads, monitor)
}

/// Steady ratios of a lattice over its flat companion, with mean coefficients and with those that runs in time draw: what these have by
/// their draw alone.
pub struct SteadyRatios {
    /// By load.
    mean: Vec<Option<f64>>,
    /// By draw, and by load in each.
    drawn: Vec<Vec<Option<f64>>>,
}

impl SteadyRatios {
    /// Of a patterned and a flat lattice; `None` on a face with heights, on which contacts are found anew for every draw.
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
                let model = model_of(scene, lattice);
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

    /// At the load `load`: with mean coefficients, and with those of draw number `draw`; `None` where one of the draws has none.
    pub fn at(&self, load: usize, draw: usize) -> Option<(f64, f64)> {
        let all: Option<Vec<f64>> = self.drawn.iter().map(|drawn| drawn.get(load).copied().flatten()).collect();
        Some((self.mean.get(load).copied().flatten()?, *all?.get(draw)?))
    }
}
