//! Helpers shared by the test targets: scenes of the published polymer, and the comparison with numbers quoted in the
//! book.

mod quoted;

pub use quoted::Quoted;

use std::path::{Path, PathBuf};

use slipgrid_model::material::{AreaLaw, Elastic, LocalFriction};
use slipgrid_model::pattern::{Pattern, PatternError, Planform};
use slipgrid_model::springblock::{Extent, Fidelity, Layer, Load, RunOptions, Scene};
use slipgrid_surface::contact::closed_form::persson_area_fraction;

/// Local coefficients of the source paper: static mean 0.30, dynamic mean 0.27, relative standard deviation 5 %.
///
/// # Errors
/// None: the numbers are valid.
pub fn published_friction() -> Result<LocalFriction, slipgrid_model::material::MaterialError> {
    LocalFriction::new(0.30, 0.27, 0.05)
}

/// Persson's area law A(P) = erf(sqrt(2) P / (E* h'rms)) with E* h'rms = 4 MPa, up to 20 MPa.
///
/// # Errors
/// None: the table is valid.
pub fn persson_law() -> Result<AreaLaw, Box<dyn std::error::Error>> {
    let pressure_pa: Vec<f64> = (1..=200).map(|step| 0.1e6 * f64::from(step)).collect();
    // Only the product of modulus and slope counts.
    let area: Vec<f64> = pressure_pa.iter().map(|p| persson_area_fraction(*p, 4e8, 0.01)).collect::<Result<_, _>>()?;
    Ok(AreaLaw::from_area_curve(&pressure_pa, &area, slipgrid_model::material::THRESHOLD_PRESSURE_PA)?)
}

/// The published pattern as simulated in the source: grooves 130 um wide, 370 um apart, 20 um deep.
///
/// # Errors
/// None: the lengths are valid.
pub fn published_groove() -> Result<Pattern, PatternError> {
    published(Planform::Groove)
}

/// The published lengths, 130 um wide, 370 um apart, 20 um deep, in any planform.
///
/// # Errors
/// [`PatternError`] for planforms that take a length more.
pub fn published(planform: Planform) -> Result<Pattern, PatternError> {
    Pattern::new(planform, 130e-6, 370e-6, 20e-6)
}

/// A scene of the published polymer with [`persson_law`] and [`published_friction`], sliding at 2 mm/s.
///
/// # Errors
/// None: the numbers are valid.
pub fn polymer_scene(
    pattern: Option<Pattern>,
    pressures_mpa: &[f64],
    fidelity: Fidelity,
    extent: Extent,
) -> Result<Scene, Box<dyn std::error::Error>> {
    let friction = published_friction()?;
    Ok(Scene {
        elastic: Elastic::new(0.38e9, 900.0)?,
        area_law: Some(persson_law()?),
        pattern,
        relief: None,
        layer: Layer { length_m: 9960e-6, height_m: 200e-6, block_m: 10e-6, thickness_m: None, holder: None },
        loads: pressures_mpa.iter().map(|p| Load { pressure_pa: p * 1e6, friction }).collect(),
        speed_m_s: 2e-3,
        run: RunOptions { fidelity, extent, ..RunOptions::default() },
    })
}

/// Root folder of the repository.
pub fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().map_or_else(PathBuf::new, Path::to_owned)
}

/// Runs the program within this process; returns its exit code and what it wrote to stdout and stderr.
pub fn slipgrid<T: AsRef<str>>(arguments: &[T]) -> (u8, String, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let arguments = arguments.iter().map(AsRef::as_ref);
    let code = slipgrid_cli::run(std::iter::once("slipgrid").chain(arguments), &mut out, &mut err);
    let [out, err] = [out, err].map(|bytes| String::from_utf8_lossy(&bytes).into_owned());
    (code, out, err)
}
