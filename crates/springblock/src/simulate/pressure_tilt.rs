//! What it would change that friction tilts the pressure of a specimen.
//!
//! Friction at the face and the pull of the holder at the back, the thickness H above it, make a couple mu P A H. Where the
//! holder does not let the specimen turn, face and back bear half of it each, and the pressure on a face of area A and second
//! moment I about its middle across the sliding direction is
//!
//! ```text
//! p(x) = P (1 + mu H A x / (2 I)),     I = int x^2 dA
//! ```
//!
//! On a rectangle as long as L it departs from P by 3 mu H / L at the ends. Where that is more than P the end leaves the
//! counterface; what is left is taken as the positive part of p, scaled to the load. Coefficients that change with pressure make a ratio
//! of it that is not that at P:
//!
//! ```text
//! r = int p mu_cell(p) dA / int p mu_flat(p) dA
//! ```
//!
//! A holder that lets the specimen align itself, or a face that has been run in, takes the tilt away. As nobody says which, the
//! ratio is left as it is without, and anything up to all of the change is equally likely. The change has another sign at low loads than
//! at high ones, and is known to half of itself (`it_changes_ratios_as_all_blocks_of_a_specimen_say`), so that the largest of all loads
//! counts at each.

use slipgrid_pattern::Pattern;

use super::load_sharing::{Borne, balanced, borne_friction};
use super::widest;
use crate::Monitor;
use crate::cell::SteadyCell;
use crate::dimension::Dimension;
use crate::face::Face;
use crate::scene::{Extent, Load, Scene};

/// Standard error over the largest change: anything from 0 to 1 of it is equally likely, and it is known to half of itself,
/// sqrt((1 + 0.55^2) / 3).
const STD: f64 = 0.66;
/// Parts of a strip, each of which bears one pressure.
const PARTS: usize = 16;
/// Tilt below which nothing is said.
const SMALL: f64 = 0.01;

/// A rectangular part of the face, about whose middle the pressure tilts: width across and length along the sliding direction, in metres.
pub type Rectangle = [f64; 2];

/// What a tilt of the pressure would change.
#[derive(Clone, Debug, Default)]
pub struct PressureTilt {
    /// Largest departure of the pressure from its mean, over the mean, by load.
    departures: Vec<f64>,
    /// Of the ratio of the cell, by load.
    changes: Vec<Option<f64>>,
}

impl PressureTilt {
    /// Of a specimen whose face is made of `rectangles`, with the cells of `scene` over `pattern` everywhere; nothing where the scene does
    /// not say how thick the specimen is, or once `monitor` has cancelled.
    pub fn new(scene: &Scene, pattern: &Pattern, rectangles: &[Rectangle], monitor: &dyn Monitor) -> Self {
        let Some(height_m) = scene.layer.thickness_m else { return Self::default() };
        let dimension = scene.dimension();
        let cells = SteadyCell::solved(scene, dimension).solve_heeding(pattern, monitor);
        let each = scene.loads.iter().zip(&cells).map(|(load, cell)| {
            let of_flat = load.flat_mu(scene.area_law.as_ref());
            let tilted = |mu: f64| tilted(rectangles, mu * height_m);
            let (flat, most) = tilted(of_flat);
            let change = || {
                monitor.heed().ok()?;
                let own = tilted(cell.surface.mu_dynamic?).0;
                let one = Scene { loads: vec![Load { ..*load }], ..scene.clone() };
                let friction = |of: Option<(&Pattern, Dimension)>, parts: &[Borne]| {
                    borne_friction(&one, of, &parts.iter().collect::<Vec<_>>())[0]
                };
                let (own, flat) = (friction(Some((pattern, dimension)), &own)?, friction(None, &flat)?);
                Some(own / flat - cell.ratio?)
            };
            (most, change())
        });
        let (departures, changes) = each.unzip();
        Self { departures, changes }
    }

    /// The same of the sample of `scene`, one strip as long as its layer; nothing of a cell, which has no ends.
    pub fn of_sample(scene: &Scene, pattern: &Pattern, monitor: &dyn Monitor) -> Self {
        match scene.run.extent {
            Extent::Cell => Self::default(),
            Extent::Sample => Self::new(scene, pattern, &[[1.0, scene.layer.length_m]], monitor),
        }
    }

    /// The same of `face`, of whose cavities a period's ratio takes `share`.
    pub fn of_face(scene: &Scene, pattern: &Pattern, face: &Face, share: f64, monitor: &dyn Monitor) -> Self {
        let rectangles: Vec<Rectangle> = face.strips().iter().map(|strip| [strip.width_m, strip.length_m]).collect();
        let mut found = Self::new(scene, pattern, &rectangles, monitor);
        found.changes.iter_mut().flatten().for_each(|change| *change *= share);
        found
    }

    /// Standard error of the ratio at every load.
    pub fn std(&self) -> f64 {
        STD * widest(self.changes.iter().copied().flatten()).abs()
    }

    /// What is to be said of it, as the end of a sentence.
    pub fn statement(&self) -> Option<String> {
        let most = self.departures.iter().copied().fold(0.0, f64::max);
        let end = if most > 1.0 {
            "friction would lift one end of a specimen that its holder keeps from turning off the counterface"
                .to_owned()
        } else {
            let percent = 100.0 * most;
            format!(
                "on a specimen that its holder keeps from turning, friction tilts the pressure by up to {percent:.0} %"
            )
        };
        let change = widest(self.changes.iter().copied().flatten());
        (most >= SMALL)
            .then(|| format!("{end}, which would change the ratio by {change:+.4} at most; the error includes it"))
    }
}

/// Standard error of the ratios of cells of `scene` over `pattern`, in that the pressure on the specimen with the face `face`, of whose
/// cavities a period's ratio takes `share`, may tilt; and what is to be said of it.
#[must_use]
pub fn tilt_error(
    scene: &Scene,
    pattern: &Pattern,
    face: &Face,
    share: f64,
    monitor: &dyn Monitor,
) -> (f64, Option<String>) {
    let tilt = PressureTilt::of_face(scene, pattern, face, share, monitor);
    (tilt.std(), tilt.statement())
}

/// Pressures on parts of `rectangles` under the couple of friction with the lever `lever_m` = mu H, and the largest departure from
/// their mean before any end is lifted.
fn tilted(rectangles: &[Rectangle], lever_m: f64) -> (Vec<Borne>, f64) {
    let sum =
        |of: &dyn Fn(f64) -> f64| rectangles.iter().map(|[width_m, length_m]| width_m * of(*length_m)).sum::<f64>();
    // A, and I = sum w L^3 / 12
    let (area_m2, moment_m4) = (sum(&|length_m| length_m), sum(&|length_m| length_m.powi(3) / 12.0));
    let per_m = lever_m * area_m2 / (2.0 * moment_m4);
    let longest_m = rectangles.iter().map(|[_, length_m]| *length_m).fold(0.0, f64::max);
    let parts = rectangles.iter().flat_map(|[width_m, length_m]| {
        (0..PARTS).map(move |part| {
            let x_m = length_m * ((part as f64 + 0.5) / PARTS as f64 - 0.5);
            Borne::solid(width_m * length_m / PARTS as f64, (1.0 + per_m * x_m).max(0.0))
        })
    });
    (balanced(parts.collect()), 0.5 * per_m * longest_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::face::Strip;
    use crate::samples;
    use crate::scene::{Layer, RunOptions};
    use crate::{Unwatched, steady_face_ratios};

    #[test]
    fn pressures_bear_the_load_and_half_of_the_couple() {
        let discs: Vec<Rectangle> = (0..64)
            .map(|band| ((f64::from(band) + 0.5) / 32.0 - 1.0, 1.0 / 32.0))
            .map(|(y, width)| [width, 2.0 * (1.0 - y * y).sqrt()])
            .collect();
        // 3 mu H / L on a rectangle, 2 mu H / R on a disc.
        for (rectangles, expected) in [(vec![[3.0, 10.0], [1.0, 10.0]], 0.3), (discs, 2.0)] {
            let (parts, most) = tilted(&rectangles, 1.0);
            assert!((most / expected - 1.0).abs() < 0.01, "{most} {expected}");
            let mean = parts.iter().map(Borne::force).sum::<f64>() / parts.iter().map(Borne::area_m2).sum::<f64>();
            assert!((mean - 1.0).abs() < 1e-12);
        }
    }

    /// All blocks of a whole specimen, whose back does not turn, against strips of its layer, to which the rest is added.
    #[test]
    fn it_changes_ratios_as_all_blocks_of_a_specimen_say() {
        for [length_mm, height_mm] in [[6.0_f64, 2.0_f64], [6.0, 3.0], [4.0, 2.0]] {
            let groove = samples::groove(200.0, 200.0, 40.0);
            let run = RunOptions { extent: Extent::Sample, ..RunOptions::default() };
            let base = samples::scene(groove, &[0.65, 1.3, 2.6], run);
            let length_m = length_mm * 1e-3;
            let count = (length_m / 400e-6).round() as u32;
            let start_m = |number: u32| 100e-6 + 400e-6 * f64::from(number);
            let cavities_m = (0..count).map(|number| [start_m(number), start_m(number) + 200e-6]).collect();
            let strip = Strip { band: 0, width_m: 1e-3, length_m, cavities_m };
            let face = Face::new(vec![strip], 0.5).unwrap();
            let layer = Layer { length_m, block_m: 40e-6, ..base.layer };
            let of = |height_m: f64, thickness_m: Option<f64>, mu: f64| {
                let friction = slipgrid_material::LocalFriction::new(mu * 1.01, mu, 0.0).unwrap();
                let loads = base.loads.iter().map(|load| Load { friction, ..*load }).collect();
                Scene { layer: Layer { height_m, thickness_m, ..layer }, loads, ..base.clone() }
            };
            let ratios = |scene: &Scene| -> Vec<f64> {
                let found = steady_face_ratios(scene, &groove, &face, &Unwatched).unwrap();
                found.into_iter().map(Option::unwrap).collect()
            };
            let height_m = height_mm * 1e-3;
            // What friction changes of the distance between both is the tilt.
            let off = |mu: f64| -> Vec<f64> {
                let (all, added) = (ratios(&of(height_m, None, mu)), ratios(&of(200e-6, Some(height_m), mu)));
                all.iter().zip(added).map(|(all, added)| all - added).collect()
            };
            let found = PressureTilt::of_face(&of(200e-6, Some(height_m), 0.27), &groove, &face, 1.0, &Unwatched);
            let largest = |of: &[f64]| of.iter().fold(0.0, |most: f64, of| most.max(of.abs()));
            let by_blocks: Vec<f64> = off(0.27).iter().zip(off(0.01)).map(|(all, little)| all - little).collect();
            let changes: Vec<f64> = found.changes.iter().copied().map(Option::unwrap).collect();
            let share = largest(&by_blocks) / largest(&changes);
            assert!(share > 0.7 && share < 1.5, "{length_mm} x {height_mm} mm: {changes:?}, all blocks {by_blocks:?}");
            for (found, all) in changes.iter().zip(&by_blocks) {
                assert!((found - all).abs() < 0.7 * largest(&changes), "{found} {all}");
            }
        }
    }
}
