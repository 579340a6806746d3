//! `validate`: compares measured ratios patterned/flat with the model.

use slipgrid_base::units::{LENGTH_UM, POSITIVE, Quantity};
use slipgrid_infer::calibrate::CutSample;
use slipgrid_io::formats::calibration::Calibration;
use slipgrid_io::formats::scene::DEFAULT_LAYER;
use slipgrid_io::formats::{Diagnostic, checked};
use slipgrid_model::pattern::{Pattern, Planform};
use slipgrid_validate::validation::{self, Patterns, ValidationTask, validate};

use crate::args::ValidateArgs;
use crate::output::open;
use crate::progress::Job;
use crate::{CliError, Console};
use slipgrid_io::disk::disk;

/// Range of the pattern's lengths: ten centimetres exceed any specimen.
const PATTERN_UM: Quantity = LENGTH_UM.at_most(1e5);
/// Range of the travel of a transient run: sliding is steady after a few micrometres.
const TRAVEL_UM: Quantity = LENGTH_UM.or_zero().at_most(100.0);
/// Range of slope factors that occur on real surfaces.
const SLOPE_FACTORS: std::ops::RangeInclusive<f64> = 0.01..=100.0;

/// Patterns of the names of files that this command may write.
const FILES: [&str; 11] = [
    "report.html",
    "result.json",
    "timings.json",
    "ratios.*",
    "rims.*",
    "area-law.*",
    "friction.*",
    "interface.*",
    "interface-end.svg",
    "interface-squares.svg",
    "friction-*.svg",
];

/// Reads the measurements, models every condition and reports.
pub fn run(args: &ValidateArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let folder = open(args.output.as_ref(), &FILES, std::slice::from_ref(&args.calibration))?;
    // Flags are checked before any file is read.
    patterns(args, None)?;
    let slope_factors = slope_factors(&args.slope_factors)?;
    let sliding_m = Some(checked("--sliding-um", args.sliding_um, TRAVEL_UM)?).filter(|sliding_m| *sliding_m > 0.0);
    let mut calibration = Calibration::read(&disk(), &args.calibration)?;
    console.warn(&calibration.stated.notes);
    let own = calibration.pattern.filter(|_| !validation::is_published(&calibration.stated.source));
    let mut compared = None;
    let patterns = match calibration.compared_trial(&args.calibration, args.trial.as_deref())?.cloned() {
        None => patterns(args, own)?,
        Some(cut) => {
            refuse_lengths(args, &cut)?;
            console.note(&format!("trial \"{}\": its measurements, and grooves of its lengths", cut.name));
            let lengths_m = [cut.pattern.width_m(), cut.pattern.spacing_m()];
            let groove = grooves(lengths_m, checked_depth("depth_um", LENGTH_UM.from_si(cut.pattern.depth_m()))?)?;
            calibration.patterned.clone_from(&cut.measured);
            compared = Some(cut.name);
            Patterns { modelled: groove, measured: groove }
        }
    };
    let task = ValidationTask {
        path: &args.calibration,
        calibration: &calibration,
        trial: compared,
        patterns,
        slope_factors,
        all: args.all,
        sliding_m,
        figures: args.output.is_some(),
    };
    let (report, outputs) = validate(&task, &disk(), &Job::new(console))?;
    if let Some(folder) = &folder {
        console.keep(&outputs, folder)?;
    }
    console.report(args.json, &report, || validation::text(&report))
}

/// Refuses length flags together with the trial `cut`, which defines its lengths.
fn refuse_lengths(args: &ValidateArgs, cut: &CutSample) -> Result<(), Diagnostic> {
    let Some((flag, Some(length_um), _)) = lengths(args, None).into_iter().find(|of| of.1.is_some()) else {
        return Ok(());
    };
    let reason = format!("stands beside the trial \"{}\", which has lengths of its own", cut.name);
    Err(Diagnostic::flag(flag, length_um.to_string(), reason).expected("no lengths beside a trial"))
}

/// Lengths of the pattern in micrometres, each as flag, given value and default. Defaults are the values of the
/// calibration's `own` pattern, otherwise the published values, as modelled and as measured in the paper.
fn lengths(args: &ValidateArgs, own: Option<Pattern>) -> [(&'static str, Option<f64>, f64); 4] {
    let or = |of: fn(&Pattern) -> f64, published| own.as_ref().map_or(published, |own| LENGTH_UM.from_si(of(own)));
    [
        ("--width-um", args.width_um, or(Pattern::width_m, 130.0)),
        ("--spacing-um", args.spacing_um, or(Pattern::spacing_m, 370.0)),
        ("--depth-um", args.depth_um, or(Pattern::depth_m, 20.0)),
        ("--measured-depth-um", args.measured_depth_um, or(Pattern::depth_m, 5.2)),
    ]
}

/// Checks that a depth is less than the layer's height; returns metres.
fn checked_depth(flag: &str, depth_um: f64) -> Result<f64, Diagnostic> {
    let layer_um = LENGTH_UM.from_si(DEFAULT_LAYER.height_m);
    let depth_m = checked(flag, depth_um, PATTERN_UM)?;
    if depth_m < DEFAULT_LAYER.height_m {
        Ok(depth_m)
    } else {
        Err(Diagnostic::flag(flag, depth_um.to_string(), format!("leaves nothing of the layer of {layer_um} um"))
            .expected(format!("a depth below {layer_um}")))
    }
}

fn grooves([width_m, spacing_m]: [f64; 2], depth_m: f64) -> Result<Pattern, Diagnostic> {
    Pattern::new(Planform::Groove, width_m, spacing_m, depth_m)
        .map_err(|error| Diagnostic { reason: error.to_string(), ..Diagnostic::default() })
}

/// Patterns with the modelled and with the measured depth, from the flags or their defaults.
fn patterns(args: &ValidateArgs, own: Option<Pattern>) -> Result<Patterns, Diagnostic> {
    let given = lengths(args, own).map(|(flag, given, usual)| (flag, given.unwrap_or(usual)));
    let [width, spacing, depth, measured] = given;
    let lengths_m = [checked(width.0, width.1, PATTERN_UM)?, checked(spacing.0, spacing.1, PATTERN_UM)?];
    Ok(Patterns {
        modelled: grooves(lengths_m, checked_depth(depth.0, depth.1)?)?,
        measured: grooves(lengths_m, checked_depth(measured.0, measured.1)?)?,
    })
}

/// Requested slope factors and 1, increasing; refuses factors outside [`SLOPE_FACTORS`].
fn slope_factors(asked: &[f64]) -> Result<Vec<f64>, Diagnostic> {
    let mut factors = vec![1.0];
    for &factor in asked {
        if !SLOPE_FACTORS.contains(&factor) {
            let expected = format!("a factor from {} to {}", SLOPE_FACTORS.start(), SLOPE_FACTORS.end());
            return Err(Diagnostic::flag("--slope-factors", factor.to_string(), "is out of range").expected(expected));
        }
        factors.push(checked("--slope-factors", factor, POSITIVE)?);
    }
    factors.sort_by(f64::total_cmp);
    factors.dedup();
    Ok(factors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_surface_as_given_is_always_among_the_factors() {
        assert_eq!(slope_factors(&[2.0, 0.5, 2.0]).unwrap(), [0.5, 1.0, 2.0]);
        assert_eq!(slope_factors(&[]).unwrap(), [1.0]);
        for bad in [0.0, -1.0, f64::NAN, 1e3] {
            assert!(slope_factors(&[1.0, bad]).is_err(), "{bad}");
        }
    }
}
