//! Solver options: the table `[run]` of scenes.

use slipgrid_model::springblock::{Extent, Fidelity, MAX_DRAWS, RunOptions, Springs};

use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::key_error::KeyError;
use slipgrid_base::units::{DAMPING, LENGTH_UM, STEP_NS, TOLERANCE};

/// Flags of the command line that override the table `[run]` of a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Overrides {
    /// Value of `--fidelity`, if given.
    pub fidelity: Option<Fidelity>,
    /// Value of `--extent`, if given.
    pub extent: Option<Extent>,
}

/// Checks the solver options in `table` and returns them with `overrides` applied. On a specimen, three-dimensional
/// patterns are solved as one cell or as a strip.
///
/// # Errors
/// [`Diagnostic`] if numbers are out of range, or options contradict each other.
pub fn read_run(
    document: &Document,
    table: &Spanned<RunOptions>,
    overrides: Overrides,
    has_specimen: bool,
) -> Result<RunOptions, Diagnostic> {
    let given = table.get_ref();
    let refuse = |error: KeyError| document.refuse_key(&table.span(), &error);
    let fidelity = overrides.fidelity.unwrap_or(given.fidelity);
    let extent = overrides.extent.unwrap_or(given.extent);
    let is_in_space = fidelity != Fidelity::Reference
        && (extent != Extent::Sample || has_specimen)
        && given.springs != Some(Springs::Exact);
    let refused = match given.dimensions {
        Some(2) if extent == Extent::Strip => {
            Some(("solves in the vertical plane, and extent = \"strip\" in space", "3, or extent = \"sample\""))
        }
        Some(3) if !is_in_space => Some((
            "is solved for fidelity = \"steady\" or \"dynamic\" with linear springs and extent = \"cell\" or \"strip\" alone",
            "2, which models the vertical section along the sliding direction",
        )),
        None | Some(2 | 3) => None,
        Some(_) => Some(("dimensions do not exist here", "2 or 3")),
    };
    if let Some((reason, expected)) = refused {
        return Err(refuse(KeyError::rule("dimensions", reason, expected)));
    }
    if !(1..=MAX_DRAWS).contains(&given.draws) {
        let expected = format!("a whole number from 1 to {MAX_DRAWS}");
        return Err(refuse(KeyError::rule("draws", "is no number of draws", expected)));
    }
    for (key, si, quantity) in [
        ("sliding_um", Some(given.sliding_m), LENGTH_UM),
        ("mu_stderr", given.mu_stderr, TOLERANCE),
        ("step_ns", given.step_s, STEP_NS),
        ("damping", Some(given.damping), DAMPING),
    ] {
        si.map(|si| KeyError::number(key, quantity.from_si(si), quantity)).transpose().map_err(refuse)?;
    }
    let dimensions = given.dimensions.or((extent == Extent::Strip).then_some(3));
    Ok(RunOptions { fidelity, extent, dimensions, ..*given })
}
