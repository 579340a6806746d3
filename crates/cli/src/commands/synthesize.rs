//! `synthesize`: makes a synthetic self-affine altitude map, with optional cavities.

use slipgrid_surface::topography::{
    CutPattern, CutRim, CutShape, HeightMap, LengthUnit, MapError, MatrixStyle, SelfAffine,
};

use crate::args::SynthesizeArgs;
use crate::output::{Place, check_map_file, write_file};
use crate::{CliError, Console};
use slipgrid_base::monitor::Unwatched;
use slipgrid_base::units::{LENGTH_MM, LENGTH_UM, SLOPE};
use slipgrid_design::results::fixed;
use slipgrid_io::formats::{Diagnostic, checked};

/// Makes the map and writes it.
pub fn run(args: &SynthesizeArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    check_map_file(Place::output(&args.output), &[])?;
    check_waves(args)?;
    let mut parameters = SelfAffine {
        pixels: args.pixels,
        side_m: checked("--side-mm", args.side_mm, LENGTH_MM)?,
        hurst: args.hurst,
        min_wave: args.waves.0,
        max_wave: args.waves.1,
        sa_m: checked("--sa-um", args.sa_um, LENGTH_UM)?,
        seed: args.seed,
    };
    if let Some(rms_slope) = args.rms_slope {
        parameters = parameters.with_rms_slope(checked("--rms-slope", rms_slope, SLOPE)?).map_err(refuse)?;
    }
    let mut map = parameters.map().map_err(refuse)?;
    let rms_slope = map.rms_slope_spectral(&Unwatched).map_err(refuse)?;
    let mut comments = parameters.description().to_vec();
    let cavities = pattern(args)?.map(|pattern| cut(&mut map, &pattern, &mut comments)).transpose()?;
    // 1e-5 of Sa is far below the resolution of a contact computation.
    let decimals = (5.0 - (parameters.sa_m * 1e9).log10().ceil()).clamp(0.0, 15.0) as u8;
    let style = MatrixStyle { channel: "altitude".to_owned(), comments, unit: LengthUnit::Nanometre, decimals };
    write_file(&args.output, map.to_matrix_text(&style).as_bytes())?;
    Ok(console.answer(&format!(
        "{}: synthetic, {} x {} pixels of {} um, Sa {} um, rms slope {}{}\n",
        args.output.display(),
        map.rows(),
        map.cols(),
        LENGTH_UM.from_si(map.dx_m()),
        fixed(Some(LENGTH_UM.from_si(parameters.sa_m)), 4),
        fixed(Some(rms_slope), 6),
        cavities.map_or_else(String::new, |count| format!(" before {count} cavities were cut")),
    ))?)
}

/// Checks that the pixels resolve the shortest wave; does not check the number of pixels.
fn check_waves(args: &SynthesizeArgs) -> Result<(), Diagnostic> {
    let (longest, shortest) = args.waves;
    let most = args.pixels.saturating_sub(1) / 2;
    if args.pixels < 4 || shortest as usize <= most {
        return Ok(());
    }
    let reason = format!("has waves that {} pixels per side do not resolve", args.pixels);
    Err(Diagnostic::flag("--waves", format!("{longest}:{shortest}"), reason)
        .expected(format!("at most {most} waves per side, or more --pixels")))
}

fn refuse(error: MapError) -> Diagnostic {
    Diagnostic { reason: error.to_string(), ..Diagnostic::default() }
}

/// Cavities requested by the flags; `None` without `--cavities`.
fn pattern(args: &SynthesizeArgs) -> Result<Option<CutPattern>, Diagnostic> {
    let Some(lengths_um) = args.cavities else { return Ok(None) };
    let [width_m, spacing_m, depth_m] = lengths_um.map(|length_um| checked("--cavities", length_um, LENGTH_UM));
    let std_um = args.cavity_std.unwrap_or_default();
    let [width_std_m, pitch_std_m, depth_std_m] =
        std_um.map(|std_um| checked("--cavity-std", std_um, LENGTH_UM.or_zero()));
    Ok(Some(CutPattern {
        shape: args.cavity_shape,
        width_m: width_m?,
        spacing_m: spacing_m?,
        depth_m: depth_m?,
        wall_m: checked("--wall-um", args.wall_um, LENGTH_UM.or_zero())?,
        width_std_m: width_std_m?,
        pitch_std_m: pitch_std_m?,
        depth_std_m: depth_std_m?,
        rim: rim(args)?,
        seed: args.seed.into(),
    }))
}

/// Rims requested by the flags; `None` without `--rims`.
fn rim(args: &SynthesizeArgs) -> Result<Option<CutRim>, Diagnostic> {
    let Some([height_um, width_um]) = args.rims else { return Ok(None) };
    Ok(Some(CutRim {
        height_m: checked("--rims", height_um, LENGTH_UM)?,
        width_m: checked("--rims", width_um, LENGTH_UM)?,
        profile: args.rim_profile,
        height_std_m: checked("--rim-std-um", args.rim_std_um, LENGTH_UM.or_zero())?,
    }))
}

/// Cuts the cavities, adds a comment about them, and returns their number.
fn cut(map: &mut HeightMap, pattern: &CutPattern, comments: &mut Vec<String>) -> Result<usize, Diagnostic> {
    let count = map.cut_cavities(pattern).map_err(refuse)?.len();
    if count == 0 {
        let side_um = LENGTH_UM.from_si(map.dx_m() * map.rows() as f64);
        let given = [pattern.width_m, pattern.spacing_m, pattern.depth_m].map(|length_m| LENGTH_UM.from_si(length_m));
        let given = given.map(|length_um| length_um.to_string()).join(",");
        return Err(Diagnostic::flag("--cavities", given, "cuts none into this map")
            .expected(format!("a width and a spacing that fit into its side of {side_um} um")));
    }
    // The period of the pattern seldom matches the period of the roughness.
    comments.retain(|comment| !comment.contains("one period"));
    let um = |length_m: f64| LENGTH_UM.from_si(length_m);
    comments.push(format!(
        "{count} {} cut: width {} +- {} um, spacing {} um, pitch +- {} um, depth {} +- {} um, walls {} um",
        match pattern.shape {
            CutShape::Groove => "grooves",
            CutShape::Square => "squares",
            CutShape::Disc => "discs",
        },
        um(pattern.width_m),
        um(pattern.width_std_m),
        um(pattern.spacing_m),
        um(pattern.pitch_std_m),
        um(pattern.depth_m),
        um(pattern.depth_std_m),
        um(pattern.wall_m),
    ));
    if let Some(rim) = pattern.rim {
        comments.push(format!(
            "rims raised: {}, height {} +- {} um, width {} um",
            rim.profile,
            um(rim.height_m),
            um(rim.height_std_m),
            um(rim.width_m),
        ));
    }
    Ok(count)
}
