//! A chart as data, and its drawing.

use plotters::style::RGBColor;
use plotters::style::text_anchor::{HPos, VPos};

use super::{
    Axis, Canvas, ChartError, Estimate, GREY, GRID, INK, LEFT, Mark, NARROW, PALETTE, RIGHT, Series, Swatch, WIDTH,
    arranged, check, picture,
};

/// Rectangle in a picture, in picture units: left, top, right, bottom; y points down.
pub(super) type Frame = [f64; 4];

/// Function that draws additional elements in or beside a plot.
type Drawing<'a> = Box<dyn Fn(&Canvas<'_>, &Plot<'_>) -> Result<(), ChartError> + 'a>;

/// Height below the frame of a single plot, in picture units, for the ticks and the title of the horizontal axis.
const BELOW: f64 = 62.0;

/// Title, legend and plots. A chart without a title gives a narrow picture, for a column of a page that shows the title
/// itself.
pub(super) struct Chart<'a> {
    title: &'a str,
    height: f64,
    legend: Vec<(Swatch, &'a str)>,
    pub(super) plots: Vec<Plot<'a>>,
}

/// Plot: a frame with two axes, and layers drawn over the axes.
pub(super) struct Plot<'a> {
    pub(super) frame: Frame,
    x: Axis,
    y: Axis,
    pub(super) layers: Vec<Layer<'a>>,
}

/// Part of a plot: values in the units of the axes, with the properties of their drawing. Widths are in picture units.
pub(super) enum Layer<'a> {
    /// Line through points, its colour and its width; dense points are reduced to their extremes.
    Line(Vec<[f64; 2]>, RGBColor, f64),
    /// Straight dashed line.
    Dashed([[f64; 2]; 2], RGBColor),
    /// Dashed line at y over the width of the plot.
    Horizontal(f64),
    /// Dashed line at x over the height of the plot, and the label at its top.
    Vertical(f64, &'a str),
    /// Shaded range of x over the height of the plot, and its opacity.
    Span([f64; 2], f64),
    /// Filled polygon, its colour and its opacity.
    Area(Vec<[f64; 2]>, RGBColor, f64),
    /// Filled rectangle between two corners, its colour and its opacity.
    Rectangle([[f64; 2]; 2], RGBColor, f64),
    /// Error bar at x between two values, its colour and its horizontal offset in picture units.
    Bar(f64, [f64; 2], RGBColor, f64),
    /// Marks, each at x and a value with an error bar, their colour and their horizontal offset in picture units.
    Marks(Mark, Vec<(f64, Estimate)>, RGBColor, f64),
    /// Small squares at points, their colour and half their side in picture units.
    Dots(Vec<[f64; 2]>, RGBColor, f64),
    /// Small text at a position in the picture, in picture units.
    Note(String, [f64; 2]),
    /// Drawing by a function, which must check the values that it draws.
    Own(Drawing<'a>),
}

/// Width of a chart with `title`, in picture units; a chart without a title is narrower.
pub(super) fn width(title: &str) -> f64 {
    if title.is_empty() { NARROW } else { WIDTH }
}

/// Legend entries and lines of all `series`, each with a colour of the palette; `width` is in picture units.
pub(super) fn lines<'a>(
    series: impl IntoIterator<Item = &'a Series<'a>>,
    width: f64,
) -> (Vec<(Swatch, &'a str)>, Vec<Layer<'a>>) {
    let coloured = series.into_iter().zip(PALETTE.into_iter().cycle());
    coloured.map(|(of, color)| ((Swatch::Line(color), of.label), Layer::Line(of.points.clone(), color, width))).unzip()
}

impl<'a> Chart<'a> {
    /// Creates a chart without plots; `height` is in picture units.
    pub(super) fn new(title: &'a str, height: f64, legend: Vec<(Swatch, &'a str)>) -> Self {
        Self { title, height, legend, plots: Vec::new() }
    }

    /// Frame of a single plot that fills the chart below the legend.
    pub(super) fn frame(&self) -> Frame {
        let width = width(self.title);
        let (_, top) = arranged(self.title, &self.legend, width);
        [LEFT, top, width - RIGHT, self.height - BELOW]
    }

    /// Adds a plot within [`Self::frame`].
    pub(super) fn plot(&mut self, x: Axis, y: Axis, layers: impl IntoIterator<Item = Layer<'a>>) -> &mut Self {
        self.plot_in(self.frame(), x, y, layers)
    }

    /// Adds a plot within `frame`.
    pub(super) fn plot_in(
        &mut self,
        frame: Frame,
        x: Axis,
        y: Axis,
        layers: impl IntoIterator<Item = Layer<'a>>,
    ) -> &mut Self {
        self.plots.push(Plot { frame, x, y, layers: layers.into_iter().collect() });
        self
    }

    /// Draws the chart.
    ///
    /// # Errors
    /// [`ChartError`] if there is no plot, a plot has no values, or a value or the end of an axis is not finite.
    pub(super) fn svg(&self) -> Result<String, ChartError> {
        let is_empty = |plot: &Plot<'_>| !plot.layers.iter().any(Layer::has_values);
        if self.plots.is_empty() || self.plots.iter().any(is_empty) {
            return Err(ChartError::Empty { title: self.title.to_owned() });
        }
        check(self.title, self.plots.iter().flat_map(Plot::values))?;
        let width = width(self.title);
        picture([width, self.height], |canvas| {
            canvas.title(self.title)?;
            let (places, _) = arranged(self.title, &self.legend, width);
            for ((swatch, label), place) in self.legend.iter().zip(places) {
                canvas.entry(*swatch, label, place)?;
            }
            self.plots.iter().try_for_each(|plot| plot.draw(canvas))
        })
    }
}

impl<'a> Layer<'a> {
    /// Marks without error bars at `points`.
    pub(super) fn marks(mark: Mark, points: impl IntoIterator<Item = [f64; 2]>, color: RGBColor) -> Self {
        Self::Marks(mark, points.into_iter().map(|[x, value]| (x, value.into())).collect(), color, 0.0)
    }

    /// Whether the layer draws values, not only guides such as reference lines, shaded spans and notes.
    fn has_values(&self) -> bool {
        match self {
            Self::Line(points, ..) | Self::Area(points, ..) | Self::Dots(points, ..) => !points.is_empty(),
            Self::Marks(_, points, ..) => !points.is_empty(),
            Self::Rectangle(..) | Self::Bar(..) | Self::Own(_) => true,
            Self::Dashed(..) | Self::Horizontal(_) | Self::Vertical(..) | Self::Span(..) | Self::Note(..) => false,
        }
    }

    /// All numbers of the layer that are in the units of the axes, to check that they are finite.
    fn values(&self) -> Vec<f64> {
        match self {
            Self::Line(points, ..) | Self::Area(points, ..) | Self::Dots(points, ..) => points.as_flattened().to_vec(),
            Self::Dashed(ends, _) | Self::Rectangle(ends, ..) => ends.as_flattened().to_vec(),
            Self::Horizontal(value) | Self::Vertical(value, _) => vec![*value],
            Self::Span(ends, _) => ends.to_vec(),
            Self::Bar(x, [low, high], ..) => vec![*x, *low, *high],
            Self::Marks(_, points, ..) => points.iter().flat_map(|(x, of)| [&[*x][..], &of.ends()].concat()).collect(),
            Self::Note(..) | Self::Own(_) => Vec::new(),
        }
    }
}

impl Plot<'_> {
    /// Creates a plot without layers.
    pub(super) fn new(frame: Frame, x: Axis, y: Axis) -> Self {
        Self { frame, x, y, layers: Vec::new() }
    }

    /// Position in the picture, in picture units, of the point `[x, y]`, which is in the units of the axes.
    pub(super) fn at(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [left, top, right, bottom] = self.frame;
        [left + self.x.share(x) * (right - left), bottom - self.y.share(y) * (bottom - top)]
    }

    /// All values of the layers, and the ends of the axes.
    fn values(&self) -> Vec<f64> {
        let ends = [self.x.range, self.y.range].concat();
        self.layers.iter().flat_map(Layer::values).chain(ends).collect()
    }

    fn draw(&self, canvas: &Canvas<'_>) -> Result<(), ChartError> {
        self.axes(canvas)?;
        self.layers.iter().try_for_each(|layer| self.layer(canvas, layer))
    }

    fn axes(&self, canvas: &Canvas<'_>) -> Result<(), ChartError> {
        let [left, top, right, bottom] = self.frame;
        for (value, text) in &self.x.ticks {
            let x = self.at([*value, self.y.range[0]])[0];
            canvas.line(&[[x, top], [x, bottom]], GRID, 1.0)?;
            canvas.text(text, [x, bottom + 7.0], (HPos::Center, VPos::Top), INK)?;
        }
        for (value, text) in &self.y.ticks {
            let y = self.at([self.x.range[0], *value])[1];
            canvas.line(&[[left, y], [right, y]], GRID, 1.0)?;
            canvas.text(text, [left - 9.0, y], (HPos::Right, VPos::Center), INK)?;
        }
        canvas.line(&[[left, top], [left, bottom], [right, bottom]], INK, 1.2)?;
        let middle = [(left + right) / 2.0, (top + bottom) / 2.0];
        canvas.text(&self.x.title, [middle[0], bottom + 32.0], (HPos::Center, VPos::Top), INK)?;
        canvas.upward_text(&self.y.title, [left - 74.0, middle[1]])
    }

    fn layer(&self, canvas: &Canvas<'_>, layer: &Layer<'_>) -> Result<(), ChartError> {
        let all_at = |points: &[[f64; 2]]| points.iter().map(|point| self.at(*point)).collect::<Vec<_>>();
        let aside = |[x, y]: [f64; 2], aside: f64| [x + aside, y];
        let ([left, right], [bottom, top]) = (self.x.range, self.y.range);
        match layer {
            Layer::Line(points, color, width) => canvas.line(&thinned(&all_at(points)), *color, *width),
            Layer::Dashed(ends, color) => canvas.dashed(ends.map(|end| self.at(end)), *color, 2.0),
            Layer::Horizontal(y) => canvas.dashed([self.at([left, *y]), self.at([right, *y])], GREY, 2.0),
            Layer::Vertical(x, label) => {
                let [foot, head] = [bottom, top].map(|y| self.at([*x, y]));
                canvas.dashed([foot, head], GREY, 1.2)?;
                canvas.text(label, [head[0] + 6.0, head[1] + 10.0], (HPos::Left, VPos::Center), GREY)
            }
            Layer::Span(ends, opacity) => {
                let [from, to] = ends.map(|x| x.clamp(left, right));
                canvas.rectangle([self.at([from, top]), self.at([to, bottom])], GREY, *opacity)
            }
            Layer::Area(points, ..) if points.is_empty() => Ok(()),
            Layer::Area(points, color, opacity) => canvas.polygon(&all_at(points), *color, *opacity),
            Layer::Rectangle(corners, color, opacity) => {
                canvas.rectangle(corners.map(|corner| self.at(corner)), *color, *opacity)
            }
            Layer::Bar(x, ends, color, offset) => {
                const CAP: f64 = 4.0;
                let ends = ends.map(|y| aside(self.at([*x, y]), *offset));
                canvas.line(&ends, *color, 1.6)?;
                ends.iter().try_for_each(|[x, y]| canvas.line(&[[x - CAP, *y], [x + CAP, *y]], *color, 1.6))
            }
            Layer::Marks(mark, points, color, offset) => points.iter().try_for_each(|(x, of)| {
                if of.error.is_some() {
                    self.layer(canvas, &Layer::Bar(*x, of.ends(), *color, *offset))?;
                }
                canvas.mark(*mark, aside(self.at([*x, of.value]), *offset), *color)
            }),
            Layer::Dots(points, color, half) => all_at(points)
                .iter()
                .try_for_each(|[x, y]| canvas.rectangle([[x - half, y - half], [x + half, y + half]], *color, 1.0)),
            Layer::Note(text, at) => canvas.small_text(text, *at, GREY),
            Layer::Own(draw) => draw(canvas, self),
        }
    }
}

/// Keeps only the first, lowest, highest and last point within each picture unit of x, in order. The visible line does
/// not change, because pages show a picture unit as at most one pixel.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    const BIN: f64 = 1.0;
    let bin = |point: &[f64; 2]| (point[0] / BIN).floor();
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| bin(a) == bin(b)) {
        let extreme = |better: fn(f64, f64) -> bool| {
            (1..group.len()).fold(0, |best, i| if better(group[i][1], group[best][1]) { i } else { best })
        };
        let mut indices = [0, extreme(|a, b| a < b), extreme(|a, b| a > b), group.len() - 1];
        indices.sort_unstable();
        for (position, &index) in indices.iter().enumerate() {
            if position == 0 || indices[position - 1] != index {
                kept.push(group[index]);
            }
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chart_needs_values_in_every_plot_and_finite_ends_of_axes() {
        let drawn = |ends: [f64; 2], points: &[[f64; 2]]| {
            let layers = [Layer::Horizontal(0.5), Layer::Line(points.to_vec(), PALETTE[0], 1.0)];
            Chart::new("t", 400.0, Vec::new()).plot(Axis::over("x", ends), Axis::over("y", [0.0, 1.0]), layers).svg()
        };
        let points = [[0.0, 0.0], [1.0, 1.0]];
        assert!(drawn([0.0, 1.0], &points).is_ok());
        assert!(matches!(drawn([0.0, 1.0], &[]), Err(ChartError::Empty { .. })));
        assert!(matches!(drawn([0.0, f64::INFINITY], &points), Err(ChartError::NotFinite { .. })));
        assert!(matches!(drawn([0.0, 1.0], &[[0.0, f64::NAN]]), Err(ChartError::NotFinite { .. })));
        assert!(matches!(Chart::new("t", 400.0, Vec::new()).svg(), Err(ChartError::Empty { .. })));
    }

    #[test]
    fn without_a_title_a_picture_is_narrow() {
        let svg = |title| {
            let line = Layer::Line(vec![[0.0, 0.0], [1.0, 1.0]], PALETTE[0], 1.0);
            let axis = Axis::over("", [0.0, 1.0]);
            Chart::new(title, 400.0, Vec::new()).plot(axis.clone(), axis, [line]).svg().unwrap()
        };
        assert!(svg("t").starts_with("<svg width=\"900\" height=\"400\""));
        assert!(svg("").starts_with("<svg width=\"480\" height=\"400\""));
    }

    #[test]
    fn thinning_keeps_extremes_and_short_lines_whole() {
        let points: Vec<[f64; 2]> = (0..100_000).map(|i| [f64::from(i) * 1e-3, f64::from(i * 7919 % 1000)]).collect();
        let kept = thinned(&points);
        assert!(kept.len() <= 404);
        let high = |points: &[[f64; 2]]| points.iter().map(|p| p[1]).fold(0.0, f64::max);
        assert_eq!(high(&kept), high(&points));
        assert_eq!((kept[0], kept[kept.len() - 1]), (points[0], points[99_999]));
        assert!(kept.windows(2).all(|pair| pair[0][0] <= pair[1][0]));
        let few = [[0.0, 1.0], [5.0, 2.0], [9.0, 0.0]];
        assert_eq!(thinned(&few), few);
    }
}
