//! Solver options: the table `[run]` of scenes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_model::springblock::{Extent, Fidelity, MAX_DRAWS, RunOptions, Springs};

use super::values::Number;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{DAMPING, LENGTH_UM, STEP_NS, TOLERANCE};

/// Run options in the form of a file; absent ones have the defaults of `RunOptions`.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RunFile {
    /// Method of solution: `steady`, `dynamic` or `reference`; `steady` when absent.
    pub fidelity: Option<Spanned<String>>,
    /// `cell`, one period; `sample`, the whole specimen; or `strip`, a strip of it in space, one period wide with periodic sides and with two
    /// ends; `cell` when absent. On a `[specimen]` that is solved in space, a sample is one cell, and a strip the row of cavities through
    /// its middle.
    pub extent: Option<Spanned<String>>,
    /// Seed of the local coefficients; 1 when absent.
    pub seed: Option<u64>,
    /// Planned travel of the bulk in dynamic runs; 2 when absent.
    pub sliding_um: Option<Number>,
    /// A block under tension leaves the counterface instead of being pinned; false when absent.
    pub liftoff: Option<bool>,
    /// Relative standard error of mu at which a dynamic run may end; without it no such error is sought.
    pub mu_stderr: Option<Number>,
    /// Time step; without it 0.34 sqrt(m/k) for `dynamic`, which is 6 ns for the published polymer in blocks of 10 um, and 1 ns for
    /// `reference`.
    pub step_ns: Option<Number>,
    /// Damping frequency over sqrt(k/m); 0.01 when absent.
    pub damping: Option<Number>,
    /// Start dynamic runs from the sheared steady equilibrium; false when absent.
    pub warm_start: Option<bool>,
    /// `linear` springs, for small displacements, or `exact` springs; without it the fidelity decides.
    pub springs: Option<Spanned<String>>,
    /// 2 solves in the vertical plane, 3 in space; the planform decides when absent, and a strip is solved in space.
    pub dimensions: Option<Spanned<u64>>,
    /// Surfaces with independent coefficients in dynamic runs, 1 to 64; 1 when absent.
    pub draws: Option<Spanned<u64>>,
    /// Extrapolate ratios to vanishing block size from steady cells in smaller blocks; false when absent. Applies in
    /// the vertical plane. In space it applies without rims, through smaller cells and the changes found in similar
    /// grooves, if such cells are affordable, if cavities are at least two of their blocks deep, and if the error
    /// decreases. Otherwise ratios remain those of the blocks of `[sample]`, and the result's model states the reason.
    pub refine: Option<bool>,
}

/// Choices of the command line that override a scene's.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides {
    /// `--fidelity`.
    pub fidelity: Option<Fidelity>,
    /// `--extent`.
    pub extent: Option<Extent>,
}

/// Reads the table. On a specimen, patterns of three dimensions are solved as one cell, or as a strip.
///
/// # Errors
/// [`Diagnostic`] if names are unknown, numbers are out of range, or options contradict each other.
pub fn read_run(
    document: &Document,
    file: &RunFile,
    overrides: Overrides,
    has_specimen: bool,
) -> Result<RunOptions, Diagnostic> {
    let default = RunOptions::default();
    let fidelity =
        file.fidelity.as_ref().map(|name| document.choice(name, &Fidelity::ALL, Fidelity::name)).transpose()?;
    let extent = file.extent.as_ref().map(|name| document.choice(name, &Extent::ALL, Extent::name)).transpose()?;
    let springs = file.springs.as_ref().map(|name| document.choice(name, &Springs::ALL, Springs::name)).transpose()?;
    let fidelity = overrides.fidelity.or(fidelity).unwrap_or(default.fidelity);
    let extent = overrides.extent.or(extent).unwrap_or(default.extent);
    let dimensions = read_dimensions(document, file.dimensions.as_ref())?;
    if let Some(given) = &file.dimensions {
        let is_in_space = fidelity != Fidelity::Reference
            && (extent != Extent::Sample || has_specimen)
            && springs != Some(Springs::Exact);
        let refused = match dimensions {
            Some(2) if extent == Extent::Strip => {
                Some(("solves in the vertical plane, and extent = \"strip\" in space", "3, or extent = \"sample\""))
            }
            Some(3) if !is_in_space => Some((
                "is solved for fidelity = \"steady\" or \"dynamic\" with linear springs and extent = \"cell\" or \"strip\" alone",
                "2, which models the vertical section along the sliding direction",
            )),
            _ => None,
        };
        if let Some((reason, expected)) = refused {
            return Err(document.refuse(given.span(), reason).expected(expected));
        }
    }
    if let Some(draws) = file.draws.as_ref().filter(|draws| !(1..=MAX_DRAWS).contains(draws.get_ref())) {
        return Err(document
            .refuse(draws.span(), "is no number of draws")
            .expected(format!("a whole number from 1 to {MAX_DRAWS}")));
    }
    Ok(RunOptions {
        fidelity,
        extent,
        seed: file.seed.unwrap_or(default.seed),
        sliding_m: document.optional(file.sliding_um.as_ref(), LENGTH_UM)?.unwrap_or(default.sliding_m),
        liftoff: file.liftoff.unwrap_or(default.liftoff),
        mu_stderr: document.optional(file.mu_stderr.as_ref(), TOLERANCE)?,
        step_s: document.optional(file.step_ns.as_ref(), STEP_NS)?,
        damping: document.optional(file.damping.as_ref(), DAMPING)?.unwrap_or(default.damping),
        warm_start: file.warm_start.unwrap_or(default.warm_start),
        springs,
        dimensions: dimensions.or((extent == Extent::Strip).then_some(3)),
        draws: file.draws.as_ref().map_or(default.draws, |draws| *draws.get_ref()),
        refine: file.refine.unwrap_or(default.refine),
    })
}

/// Reads the number of dimensions of the model.
///
/// # Errors
/// [`Diagnostic`] for other numbers than 2 and 3.
fn read_dimensions(document: &Document, dimensions: Option<&Spanned<u64>>) -> Result<Option<u8>, Diagnostic> {
    let Some(given) = dimensions else { return Ok(None) };
    match given.get_ref() {
        2 => Ok(Some(2)),
        3 => Ok(Some(3)),
        _ => Err(document.refuse(given.span(), "dimensions do not exist here").expected("2 or 3")),
    }
}
