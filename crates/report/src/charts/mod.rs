//! Charts of results: pure functions from values to SVG text.
//!
//! | function | picture |
//! |---|---|
//! | `friction_trace` | friction coefficient against time, averaging window and mean |
//! | `interface_pressure` | pressure along the interface |
//! | `target` | target, expected friction of a cut sample, and the model alone against pressure |
//! | `area_law` | real contact area and the factor f against pressure |
//! | `flat_friction` | friction of flat samples against pressure, measured and by the fitted model |
//! | `residuals` | model minus measurement |
//! | `ratios` | measured and modelled ratios |
//! | `trade_offs` | designs by two or three goals, with the Pareto front |
//! | `trials` | measured and predicted ratios of trials, and ratios against texture features |
//! | `left_out` | measured ratios against those predicted by all other trials |
//! | `literature` | published ratios beside those of trials |
//! | `mechanisms` | ratios of both sectors of a disc by mechanism of the model error, with intervals |
//! | `friction_loops` | friction against position in reciprocating sliding |
//! | `tribometer` | repeats of a test against time, with the values read from them |
//! | `surface_map` | a surface seen from above, with heights as colours |
//! | `height_histogram` | histogram of heights, and the bearing curve |
//! | `section` | height along a line |
//! | `edge_profile` | height against the distance from the edges of cavities, with the rim |
//! | `spectrum` | power against wave number |
//! | `work_precision` | wall time against error, with the front |
//!
//! Each function describes its picture as a chart: a title, a legend, and plots of layers, which one renderer checks
//! and draws. A picture is 900 units wide, or 480 units without a title, for a narrow column of a page that has the
//! title. Text stays text, and the legend stands outside the axes. Colours are from the palette of Okabe and Ito, which
//! is distinguishable with common colour vision deficiencies; marks also differ in shape. Identical values give
//! identical bytes.

mod axis;
mod calibration;
mod canvas;
mod chart;
mod design;
mod run;
mod surface;
mod trials;
mod work_precision;

pub use calibration::{AreaPoint, area_law, ratios};
pub(crate) use calibration::{FlatSeries, flat_friction, residuals};
pub use design::{MECHANISMS_FILE, mechanisms};
pub(crate) use design::{flat_of, is_at_condition, model_alone, target, trade_offs};
pub(crate) use run::{RepeatTrace, friction_loops, tribometer};
pub use run::{Trace, friction_trace, interface_pressure};
pub(crate) use surface::{SurfaceValues, edge_profile, height_histogram, section, spectrum, surface_map};
pub(crate) use trials::{left_out, literature, trials};
pub use work_precision::{WorkPoint, WorkPrecisionPanel, work_precision};

use axis::Axis;
pub(crate) use axis::extremes;
use canvas::{
    Canvas, GREY, GRID, INK, LEFT, Mark, NARROW, PALETTE, PRECISION, RIGHT, SMALL_SIZE, Swatch, TEXT_SIZE, WIDTH,
    arranged, failed, picture, small_text_width,
};
use chart::{Chart, Frame, Layer, Plot, lines, width};

/// Line of a chart with a label.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<'a> {
    /// Name in the legend.
    pub label: &'a str,
    /// `[x, y]`, x not decreasing, in the units of the chart's axes.
    pub points: Vec<[f64; 2]>,
}

/// Value with its standard error or standard deviation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// Half the length of the error bar; `None` draws no bar.
    pub error: Option<f64>,
}

impl Estimate {
    /// Lower and upper end of the error bar; both are the value if the error is unknown.
    fn ends(&self) -> [f64; 2] {
        let error = self.error.unwrap_or(0.0);
        [self.value - error, self.value + error]
    }
}

impl From<f64> for Estimate {
    /// Makes an estimate without an error.
    fn from(value: f64) -> Self {
        Self { value, error: None }
    }
}

/// Errors of drawing a chart.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChartError {
    /// The chart has no values.
    #[error("chart \"{title}\": there are no values to draw")]
    Empty {
        /// Title of the chart.
        title: String,
    },
    /// A value is infinite or not a number.
    #[error("chart \"{title}\": {value} cannot be drawn, expected a finite number")]
    NotFinite {
        /// Title of the chart.
        title: String,
        /// The value.
        value: f64,
    },
    /// The drawing library failed.
    #[error("drawing failed: {reason}")]
    Drawing {
        /// Message of the drawing library.
        reason: String,
    },
}

/// Checks that there are values and that all values are finite; `title` names the chart in errors.
fn check(title: &str, values: impl IntoIterator<Item = f64>) -> Result<(), ChartError> {
    let mut values = values.into_iter().peekable();
    if values.peek().is_none() {
        return Err(ChartError::Empty { title: title.to_owned() });
    }
    match values.find(|value| !value.is_finite()) {
        Some(value) => Err(ChartError::NotFinite { title: title.to_owned(), value }),
        None => Ok(()),
    }
}
