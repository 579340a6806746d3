//! Scene on which methods are compared: of the source paper or of a user, and its reduced form.

use slipgrid_infer::calibrate::area_law::{DEFAULT_PRESSURES_MPA, area_law, persson_curve};
use slipgrid_model::material::{Elastic, LocalFriction, THRESHOLD_PRESSURE_PA};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Layer, Load, RunOptions, Scene, shear_modulus_pa, shear_period_s};

use crate::Failure;
use slipgrid_base::units::PRESSURE_MPA;
use slipgrid_io::formats::scene::DEFAULT_LAYER;

/// Rms slope of the synthetic map that replaces the unpublished map.
const STAND_IN_RMS_SLOPE: f64 = 0.0137;
/// Poisson's ratio of the lattice.
const POISSON_RATIO: f64 = 1.0 / 3.0;

/// Number of columns of the reduced specimen.
const REDUCED_COLUMNS: usize = 50;
/// Number of rows of the reduced layer, unless cavities need more rows.
const REDUCED_ROWS: usize = 6;
/// Minimum number of rows of the reduced layer above a cavity.
const ROWS_ABOVE_CAVITY: usize = 2;
/// Travel of a reduced run relative to the travel at the onset of sliding. Friction is averaged from 60 % of the run
/// on, which is after the onset.
const TRAVEL_OVER_ONSET: f64 = 2.0;
/// Minimum duration of a reduced run, in periods of the first shear mode of the layer: fast drives reach the onset of
/// sliding within a few periods, which are too few for a mean.
const MIN_PERIODS: f64 = 100.0;

/// Polymer sample of Balestra et al., J. Tribol. 144, 031704, with the area law by Persson's theory for the rms slope
/// of a synthetic map, because the measured map is unpublished.
///
/// # Errors
/// [`Failure::Failed`] if one of the numbers is refused.
pub fn paper_scene() -> Result<Scene, Failure> {
    let refuse = |error: &dyn std::fmt::Display| Failure::Failed(format!("the built-in scene: {error}"));
    let elastic = Elastic::new(0.38e9, 900.0).map_err(|error| refuse(&error))?;
    let pressures_pa = DEFAULT_PRESSURES_MPA.map(|pressure_mpa| PRESSURE_MPA.to_si(pressure_mpa));
    let contact_modulus_pa = elastic.contact_modulus_pa(POISSON_RATIO);
    let curve = persson_curve(STAND_IN_RMS_SLOPE, contact_modulus_pa, &pressures_pa).map_err(|error| refuse(&error))?;
    Ok(Scene {
        elastic,
        area_law: Some(area_law(&curve, THRESHOLD_PRESSURE_PA).map_err(|error| refuse(&error))?),
        pattern: Some(Pattern::new(Planform::Groove, 130e-6, 370e-6, 20e-6).map_err(|error| refuse(&error))?),
        relief: None,
        layer: DEFAULT_LAYER,
        loads: vec![Load {
            pressure_pa: 1.3e6,
            friction: LocalFriction::new(0.30, 0.27, 0.05).map_err(|error| refuse(&error))?,
        }],
        speed_m_s: 2e-3,
        run: RunOptions::default(),
    })
}

/// Base scene that all methods change: the whole specimen by the paper's integration scheme, at the first load of
/// `scene`. Seed, travel, damping and lift-off are taken from `scene`.
pub fn base(scene: &Scene) -> Scene {
    let run = RunOptions {
        fidelity: Fidelity::Reference,
        extent: Extent::Sample,
        mu_stderr: None,
        step_s: None,
        warm_start: false,
        springs: None,
        ..scene.run
    };
    Scene { loads: scene.loads.iter().take(1).copied().collect(), run, ..scene.clone() }
}

/// Reduces the scene to a shorter specimen with a thinner layer and less travel, so that the reference takes seconds.
pub fn reduced(scene: &Scene) -> Scene {
    let block_m = scene.layer.block_m;
    let cavity_rows = scene.pattern.map_or(0, |pattern| (pattern.depth_m() / block_m).ceil() as usize);
    let rows = scene.layer.rows().min(REDUCED_ROWS.max(cavity_rows + ROWS_ABOVE_CAVITY));
    let columns = scene.layer.columns().min(REDUCED_COLUMNS);
    let layer = Layer {
        length_m: columns as f64 * block_m,
        height_m: rows as f64 * block_m,
        block_m,
        thickness_m: None,
        holder: None,
    };
    let onset_m = scene.loads.first().map_or(0.0, |load| onset_travel_m(scene, &layer, load));
    let wanted_m = (TRAVEL_OVER_ONSET * onset_m)
        .max(MIN_PERIODS * shear_period_s(&scene.elastic, layer.height_m) * scene.speed_m_s);
    let sliding_m = if wanted_m > 0.0 { wanted_m.min(scene.run.sliding_m) } else { scene.run.sliding_m };
    Scene { layer, run: RunOptions { sliding_m, ..scene.run }, ..scene.clone() }
}

/// Travel of the bulk, in metres, at which the shear stress of the layer reaches static friction.
fn onset_travel_m(scene: &Scene, layer: &Layer, load: &Load) -> f64 {
    let factor = scene.area_law.as_ref().map_or(1.0, |law| law.factor(load.pressure_pa));
    // Travel u: mu_s f P = G u / h, with shear modulus G, height h, pressure P, area factor f.
    load.friction.static_mean() * factor * load.pressure_pa * layer.height_m / shear_modulus_pa(&scene.elastic)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_scene_is_the_papers() {
        let scene = paper_scene().unwrap();
        scene.validate().unwrap();
        assert_eq!((scene.layer.columns(), scene.layer.rows()), (996, 20));
        // f = erf(sqrt 2 P / (E* h')) / erf(sqrt 2 P0 / (E* h')) P0 / P at 1.3 MPa, E* h' = 5.857 MPa
        let factor = scene.area_law.as_ref().unwrap().factor(1.3e6);
        assert!((factor - 0.976_8).abs() < 2e-3, "{factor}");
    }

    #[test]
    fn the_reduced_scene_keeps_blocks_pattern_and_load() {
        let scene = paper_scene().unwrap();
        let small = reduced(&scene);
        small.validate().unwrap();
        assert_eq!((small.layer.columns(), small.layer.rows()), (50, 6));
        assert_eq!((small.pattern, small.layer.block_m), (scene.pattern, scene.layer.block_m));
        // u = mu_s f P h / G = 0.3 x 0.977 x 1.3 MPa x 60 um / 142.5 MPa = 0.160 um
        assert!((small.run.sliding_m - 2.0 * 0.160e-6).abs() < 1e-8, "{}", small.run.sliding_m);
        // Ten times faster, 100 periods of 4 x 60 um / 397.9 m/s at 20 mm/s are more than twice the onset.
        let mut fast = scene.clone();
        fast.speed_m_s *= 10.0;
        assert!((reduced(&fast).run.sliding_m - 100.0 * 240e-6 / 397.9 * 20e-3).abs() < 1e-9);
        let mut deep = scene.clone();
        deep.pattern = Some(Pattern::new(Planform::Groove, 130e-6, 370e-6, 85e-6).unwrap());
        assert_eq!(reduced(&deep).layer.rows(), 11);
    }
}
