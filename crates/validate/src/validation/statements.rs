//! Conclusions from the numbers of a validation, and their basis.

use slipgrid_base::units::{LENGTH_MM, LENGTH_UM};
use slipgrid_design::results::fixed;
use slipgrid_io::formats::scene::{DEFAULT_LAYER, DEFAULT_THICKNESS_M};

use super::ratios::{ModelledRatio, RatioReport};
use super::report::ValidationReport;

/// Statement of what the mechanism can and cannot explain, whatever the results.
const LEFT_OPEN: &str = "What the mechanism can explain: a reduction that grows with load, by pressure under the edges of cavities where real \
     contact area saturates. What it cannot: a reduction at vanishing load, and how friction depends on speed and humidity, \
     which enters through the flat measurements alone. Adhesion and menisci, plasticity, heating and wear are not modelled, \
     and rims are not in these numbers";

/// Remark on the part of the reduction that the area law does not explain.
const ELSEWHERE: &str = "the rest comes from elsewhere, or from another surface.";

/// Statement of the measurements that would discriminate between the area law and measured flat friction as the local
/// law.
const DECIDES: &str = "Flat samples cannot tell them apart: in these local and nominal pressure are one. Samples with uneven pressure \
     of a known shape would decide: a sphere or a cylinder of the same material and finish, whose pressure is Hertz's, or patterns of \
     one areal density with more and with fewer edges. By the area law friction falls with the pressure under edges, by the \
     measured law it rises with it where flat friction does with load.";

/// Conclusions from the numbers of `report`, in sentences.
pub fn statements(report: &ValidationReport) -> Vec<String> {
    let rims =
        if report.has_squares() { ": what some of unknown height would do stands in a table of its own" } else { "" };
    let synthetic = "The surface behind the area law is synthetic, not measured: these ratios are no test of the model until it is.";
    let said = [
        Some(measured(report)),
        modelled(report),
        Some(explained(report)),
        trend(report),
        two_laws(report),
        Some(format!("{LEFT_OPEN}{rims}.")),
        other_slopes(report),
        depth(report),
        thickness(report),
        report.synthetic_surface.then(|| synthetic.to_owned()),
        Some("Nothing was tuned to the patterned samples.".to_owned()),
    ];
    said.into_iter().flatten().collect()
}

/// Formats a share from 0 to 1 in per cent, with the sign %, or as a dash if it is unknown.
pub fn percent(share: impl Into<Option<f64>>) -> String {
    share.into().map_or_else(|| "-".to_owned(), |share| format!("{} %", fixed(Some(100.0 * share), 1)))
}

fn signed(value: f64) -> String {
    let text = fixed(Some(value), 4);
    if value > 0.0 { format!("+{text}") } else { text }
}

fn measured(report: &ValidationReport) -> String {
    let summary = &report.summary;
    let spread = summary.reduction_measured_std.map_or_else(String::new, |std| {
        format!(", standard deviation {} between {} conditions", percent(std), summary.conditions)
    });
    format!("Measured: the pattern lowers dynamic friction by {}{spread}.", percent(summary.reduction_measured))
}

fn modelled(report: &ValidationReport) -> Option<String> {
    let given = report.summary.modelled.iter().find(|modelled| modelled.slope_factor == 1.0)?;
    let squares = report.has_squares().then(|| {
        format!(
            ", by {} as square cavities ({}, in space; {} by the strip estimate)",
            percent(given.square),
            percent(report.areal_density_square),
            percent(given.square_estimate),
        )
    });
    Some(format!(
        "Modelled: by {} as grooves ({} of the surface){}.",
        percent(given.groove),
        percent(report.pattern.areal_density),
        squares.unwrap_or_default()
    ))
}

fn explained(report: &ValidationReport) -> String {
    let shares = [report.summary.explained_by_grooves, report.summary.explained_by_squares];
    let squares = match report.cut_as.as_deref() {
        Some("square") => "the squares they are",
        _ => "squares of the same lengths",
    };
    match shares.map(|share| share.map(|share| format!("{:.0} %", 100.0 * share))) {
        [Some(grooves), _] if !report.has_squares() => {
            format!("The area law alone explains {grooves} of the measured reduction: {ELSEWHERE}")
        }
        [Some(grooves), Some(share)] => format!(
            "The area law alone explains {grooves} of the measured reduction if the cavities were grooves, {share} as {squares}: {ELSEWHERE}"
        ),
        _ => "No share of the measured reduction can be given.".to_owned(),
    }
}

/// Describes the change of the measured and of the modelled reduction from the lowest to the highest pressure; `None`
/// for several speeds or humidities, or one pressure.
fn trend(report: &ValidationReport) -> Option<String> {
    let rows = report.by_pressure();
    let (low, high) = (rows.first()?, rows.last()?);
    if !report.has_one_condition() || high.measured.pressure_mpa <= low.measured.pressure_mpa {
        return None;
    }
    let groove = |row: &RatioReport| percent(row.groove().map(|ratio| 1.0 - ratio));
    Some(format!(
        "From {} to {} MPa the measured reduction goes from {} to {}, the grooves' from {} to {}.",
        fixed(Some(low.measured.pressure_mpa), 3),
        fixed(Some(high.measured.pressure_mpa), 3),
        percent(1.0 - low.measured.ratio),
        percent(1.0 - high.measured.ratio),
        groove(low),
        groove(high),
    ))
}

/// Describes the ratios by the area law and by measured flat friction as the local law, and the measurements that would
/// discriminate between the two; `None` if either law gives no ratio.
fn two_laws(report: &ValidationReport) -> Option<String> {
    let by_measured_law =
        |row: &RatioReport| row.measured_law.iter().filter_map(|law| law.ratio_groove).collect::<Vec<_>>();
    let ends = |of: &dyn Fn(&RatioReport) -> Vec<f64>| {
        let all: Vec<f64> = report.results.iter().flat_map(of).collect();
        let least = all.iter().copied().reduce(f64::min)?;
        Some(format!("{least:.3} to {:.3}", all.iter().copied().fold(least, f64::max)))
    };
    let grooves = ends(&by_measured_law)?;
    let by_area = ends(&|row| row.groove().into_iter().collect())?;
    let is_below = |row: &RatioReport| {
        let least = by_measured_law(row).into_iter().chain(row.groove()).reduce(f64::min);
        least.is_some_and(|least| row.measured.ratio < least)
    };
    let measured = if report.results.iter().all(is_below) { " The measured ratios lie below both." } else { "" };
    Some(format!(
        "Two laws fit the flat samples alike: coefficients of each load times the area law (grooves: {by_area}), or measured flat friction \
         itself as the law of local pressure (grooves: {grooves}). {DECIDES}{measured}"
    ))
}

fn other_slopes(report: &ValidationReport) -> Option<String> {
    let others = report.summary.modelled.iter().filter(|modelled| modelled.slope_factor != 1.0);
    let others = others.map(|m| {
        let squares = report.has_squares().then(|| format!(" and {} as squares", percent(m.square)));
        format!("{} as grooves{} at {} times the slope", percent(m.groove), squares.unwrap_or_default(), m.slope_factor)
    });
    let others: Vec<String> = others.collect();
    (!others.is_empty())
        .then(|| format!("The surface's slope decides how much: the model gives {}.", others.join(", ")))
}

fn depth(report: &ValidationReport) -> Option<String> {
    let (summary, measured_um) = (&report.summary, report.measured_depth_um);
    Some(format!(
        "Depth: {} um is modelled, {measured_um} um was measured. At {measured_um} um the groove's ratio changes by {} on average, by {} at most, that of squares by {}.",
        report.pattern.depth_um,
        signed(summary.ratio_change_at_measured_depth?),
        signed(summary.largest_ratio_change_at_measured_depth?),
        summary.square_ratio_change_at_measured_depth.map_or_else(|| "-".to_owned(), signed),
    ))
}

/// Describes the error due to the source's layer instead of the whole specimen; `None` if the whole specimen is
/// modelled.
fn thickness(report: &ValidationReport) -> Option<String> {
    let largest = |of: fn(&ModelledRatio) -> Option<f64>| {
        let each = report.results.iter().filter_map(|row| of(row.given()?));
        each.reduce(|largest, own| if own.abs() > largest.abs() { own } else { largest }).map(signed)
    };
    Some(format!(
        "Layer: the source's {} um are modelled; all of its specimen's {} mm would change the groove's ratio by {} at most, that of squares by {}.",
        LENGTH_UM.from_si(DEFAULT_LAYER.height_m),
        LENGTH_MM.from_si(DEFAULT_THICKNESS_M),
        largest(|modelled| modelled.ratio_groove_thick_difference)?,
        largest(|modelled| modelled.ratio_square_thick_difference)?,
    ))
}
