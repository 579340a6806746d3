//! Mean period of a patterned surface, as matrix text and in words.

use slipgrid_base::units::LENGTH_UM;
use slipgrid_surface::topography::{LengthUnit, MatrixStyle, MeanPeriod};

/// Decimals of heights in um.
const PERIOD_DECIMALS: u8 = 6;

/// Formats the mean period as matrix text, which states whether the surface is `synthetic`.
pub fn period_text(period: &MeanPeriod, synthetic: bool) -> String {
    let mut comments = period.description().to_vec();
    comments.extend(synthetic.then(|| "of a synthetic surface, not a measurement".to_owned()));
    comments.push(period_relief(period));
    let style = MatrixStyle {
        channel: "mean period".to_owned(),
        comments,
        unit: LengthUnit::Micrometre,
        decimals: PERIOD_DECIMALS,
    };
    period.map.to_matrix_text(&style)
}

/// States the roughness that remains on the land of the mean period.
fn period_relief(period: &MeanPeriod) -> String {
    match period.relief_left_m {
        Some(left_m) => format!("roughness left in the mean, on land: {:.4} um", LENGTH_UM.from_si(left_m)),
        None => "no land lies beyond the rims: roughness left in the mean is not known".to_owned(),
    }
}

/// Describes the mean period and the roughness that remains on its land.
pub fn period_note(period: &MeanPeriod) -> String {
    let map = &period.map;
    let side_um = |count: usize, pixel_m: f64| LENGTH_UM.from_si(count as f64 * pixel_m);
    let missing = match map.missing() {
        0 => String::new(),
        missing => format!("; {missing} of its points are missing in every period"),
    };
    format!(
        "mean period of {} cavities, {}, {:.2} x {:.2} um, {} x {} pixels; {}{missing}",
        period.cavities,
        period.arrangement,
        side_um(map.rows(), map.dx_m()),
        side_um(map.cols(), map.dy_m()),
        map.rows(),
        map.cols(),
        period_relief(period),
    )
}
