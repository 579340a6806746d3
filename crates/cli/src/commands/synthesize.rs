//! `synthesize`: a synthetic self-affine altitude map.

use slipgrid_topography::{LengthUnit, MapError, MatrixStyle, SelfAffine};

use crate::args::SynthesizeArgs;
use crate::diagnostic::Diagnostic;
use crate::output::{check_file, write_file};
use crate::report::table::fixed;
use crate::units::{LENGTH_MM, LENGTH_UM, Quantity};
use crate::{CliError, Console, exit_code};

/// Makes the map and writes it.
pub fn run(args: &SynthesizeArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    check_file(&args.output)?;
    let checked = |flag: &str, value: f64, quantity: Quantity| {
        if quantity.accepts(value) {
            Ok(quantity.to_si(value))
        } else {
            Err(Diagnostic::flag(flag, value.to_string(), "is out of range").expected(quantity.to_string()))
        }
    };
    let parameters = SelfAffine {
        pixels: args.pixels,
        side_m: checked("--side-mm", args.side_mm, LENGTH_MM)?,
        hurst: args.hurst,
        min_wave: args.waves.0,
        max_wave: args.waves.1,
        sa_m: checked("--sa-um", args.sa_um, LENGTH_UM)?,
        seed: args.seed,
    };
    let refuse = |error: MapError| Diagnostic { reason: error.to_string(), ..Diagnostic::default() };
    let map = parameters.map().map_err(refuse)?;
    let rms_slope = map.rms_slope_spectral().map_err(refuse)?;
    // A hundred thousandth of Sa is far below what a contact computation sees.
    let decimals = (5.0 - (args.sa_um * 1e3).log10().ceil()).clamp(0.0, 15.0) as u8;
    let style = MatrixStyle {
        channel: "altitude".to_owned(),
        comments: parameters.description().to_vec(),
        unit: LengthUnit::Nanometre,
        decimals,
    };
    write_file(&args.output, map.to_matrix_text(&style).as_bytes())?;
    writeln!(
        console.out,
        "{}: synthetic, {} x {} pixels of {} um, Sa {} um, rms slope {}",
        args.output.display(),
        map.rows(),
        map.cols(),
        LENGTH_UM.from_si(map.dx_m()),
        fixed(Some(LENGTH_UM.from_si(map.sa_m())), 4),
        fixed(Some(rms_slope), 6),
    )?;
    Ok(exit_code::DONE)
}
