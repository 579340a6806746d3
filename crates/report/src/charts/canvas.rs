//! Canvas of a picture: lines, marks, text, entries of a legend, and palette.

use plotters::coord::Shift;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use slipgrid_laser::export::is_xml_letter;

use super::ChartError;

/// Palette of Okabe and Ito: blue, vermilion, bluish green, reddish purple, orange.
pub(super) const PALETTE: [RGBColor; 5] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
];
pub(super) const INK: RGBColor = RGBColor(51, 51, 51);
pub(super) const GRID: RGBColor = RGBColor(225, 225, 225);
/// Grey that is dark enough for text: the contrast ratio to white is 5.1.
pub(super) const GREY: RGBColor = RGBColor(110, 110, 110);

/// Width of a picture, in picture units.
pub(super) const WIDTH: f64 = 900.0;
/// Width of a picture for a phone or a narrow column, in picture units.
pub(super) const NARROW: f64 = 480.0;
/// Margin left of the axes, for the texts of the ticks and the axis title, in picture units.
pub(super) const LEFT: f64 = 88.0;
/// Margin right of the axes, in picture units.
pub(super) const RIGHT: f64 = 28.0;

/// Ratio of drawing coordinates to picture units. The drawing library rounds to whole pixels, so pictures are drawn
/// larger by this factor, and the view box scales them back.
pub(super) const PRECISION: f64 = 8.0;
/// Factor on font sizes, because the drawing library divides a font size by 1.24.
const FONT_FACTOR: f64 = 1.24;
/// Upper estimate of the mean character width, relative to the font size.
const CHARACTER_WIDTH: f64 = 0.58;

const TITLE_SIZE: f64 = 18.0;
pub(super) const TEXT_SIZE: f64 = 16.0;
pub(super) const SMALL_SIZE: f64 = 12.5;
const LEGEND_HEIGHT: f64 = 25.0;
const SWATCH: f64 = 26.0;

/// Symbol beside a name in the legend.
#[derive(Clone, Copy)]
pub(super) enum Swatch {
    Line(RGBColor),
    Dashed(RGBColor),
    Band(RGBColor, f64),
    Mark(Mark, RGBColor),
    /// Downward arrow.
    Arrow(RGBColor),
    /// Arrow along a unit vector; y points up.
    Toward([f64; 2], RGBColor),
}

/// Shapes of marks.
#[derive(Clone, Copy)]
pub(super) enum Mark {
    Circle,
    /// Larger open circle that leaves a mark inside it visible.
    Ring,
    Square,
    Diamond,
    Triangle,
}

impl Mark {
    /// All shapes, in the order in which series of a chart take them.
    pub(super) const ALL: [Self; 5] = [Self::Circle, Self::Square, Self::Triangle, Self::Diamond, Self::Ring];
    /// Shapes that fit inside a ring.
    pub(super) const FILLED: [Self; 4] = [Self::Circle, Self::Square, Self::Triangle, Self::Diamond];
}

/// Picture under construction, in picture units, with y pointing down.
pub(super) struct Canvas<'a> {
    root: DrawingArea<SVGBackend<'a>, Shift>,
}

/// Draws a picture of the given width and height in picture units with `draw`, and returns it as SVG text.
pub(super) fn picture(
    [width, height]: [f64; 2],
    draw: impl FnOnce(&Canvas<'_>) -> Result<(), ChartError>,
) -> Result<String, ChartError> {
    // Side lengths are a few hundred units, so that the casts are exact.
    let size = ((width * PRECISION) as u32, (height * PRECISION) as u32);
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(failed)?;
        let canvas = Canvas { root };
        draw(&canvas)?;
        canvas.root.present().map_err(failed)?;
    }
    let drawn = format!("<svg width=\"{}\" height=\"{}\"", size.0, size.1);
    Ok(svg.replacen(&drawn, &format!("<svg width=\"{width}\" height=\"{height}\""), 1))
}

/// Converts an error of the drawing library.
pub(super) fn failed(error: impl std::fmt::Display) -> ChartError {
    ChartError::Drawing { reason: error.to_string() }
}

fn pixel(point: [f64; 2]) -> (i32, i32) {
    // Positions lie on the page, so that the casts do not saturate.
    ((point[0] * PRECISION).round() as i32, (point[1] * PRECISION).round() as i32)
}

fn pixels(points: &[[f64; 2]]) -> Vec<(i32, i32)> {
    points.iter().copied().map(pixel).collect()
}

fn font(size: f64) -> FontDesc<'static> {
    ("sans-serif", size * FONT_FACTOR * PRECISION).into_font()
}

fn stroke(color: RGBColor, width: f64) -> ShapeStyle {
    ShapeStyle::from(&color).stroke_width((width * PRECISION).round() as u32)
}

impl Canvas<'_> {
    pub(super) fn line(&self, points: &[[f64; 2]], color: RGBColor, width: f64) -> Result<(), ChartError> {
        if points.len() < 2 {
            return Ok(());
        }
        self.root.draw(&PathElement::new(pixels(points), stroke(color, width))).map_err(failed)
    }

    /// Draws an arrow from `from` to `tip`.
    pub(super) fn arrow(&self, from: [f64; 2], tip: [f64; 2], color: RGBColor) -> Result<(), ChartError> {
        let length = (tip[0] - from[0]).hypot(tip[1] - from[1]).max(f64::MIN_POSITIVE);
        let along = [0, 1].map(|axis| (tip[axis] - from[axis]) / length);
        let barb = |side: f64| [tip[0] - 5.0 * along[0] - side * along[1], tip[1] - 5.0 * along[1] + side * along[0]];
        self.line(&[from, tip], color, 1.6)?;
        self.line(&[barb(3.5), tip, barb(-3.5)], color, 1.6)
    }

    /// Draws a straight dashed line; `width` is in picture units.
    pub(super) fn dashed(&self, [from, to]: [[f64; 2]; 2], color: RGBColor, width: f64) -> Result<(), ChartError> {
        const DASH: f64 = 6.0;
        const GAP: f64 = 4.0;
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let at = |distance: f64| {
            let share = distance.min(length) / length;
            [from[0] + share * (to[0] - from[0]), from[1] + share * (to[1] - from[1])]
        };
        let mut start = 0.0;
        while start < length {
            self.line(&[at(start), at(start + DASH)], color, width)?;
            start += DASH + GAP;
        }
        Ok(())
    }

    pub(super) fn polygon(&self, points: &[[f64; 2]], color: RGBColor, opacity: f64) -> Result<(), ChartError> {
        self.root.draw(&Polygon::new(pixels(points), color.mix(opacity))).map_err(failed)
    }

    pub(super) fn rectangle(&self, [from, to]: [[f64; 2]; 2], color: RGBColor, opacity: f64) -> Result<(), ChartError> {
        self.root.draw(&Rectangle::new([pixel(from), pixel(to)], color.mix(opacity).filled())).map_err(failed)
    }

    pub(super) fn mark(&self, mark: Mark, [x, y]: [f64; 2], color: RGBColor) -> Result<(), ChartError> {
        const RADIUS: f64 = 5.0;
        let polygon = |corners: &[[f64; 2]]| {
            let points: Vec<[f64; 2]> = corners.iter().map(|[dx, dy]| [x + RADIUS * dx, y + RADIUS * dy]).collect();
            self.polygon(&points, color, 1.0)
        };
        match mark {
            Mark::Circle => {
                self.root.draw(&Circle::new(pixel([x, y]), RADIUS * PRECISION, color.filled())).map_err(failed)
            }
            Mark::Ring => {
                let ring = Circle::new(pixel([x, y]), 1.7 * RADIUS * PRECISION, stroke(color, 2.0));
                self.root.draw(&ring).map_err(failed)
            }
            Mark::Square => polygon(&[[-0.9, -0.9], [0.9, -0.9], [0.9, 0.9], [-0.9, 0.9]]),
            Mark::Diamond => polygon(&[[0.0, -1.3], [1.3, 0.0], [0.0, 1.3], [-1.3, 0.0]]),
            Mark::Triangle => polygon(&[[0.0, -1.2], [1.15, 0.9], [-1.15, 0.9]]),
        }
    }

    pub(super) fn text(
        &self,
        text: &str,
        at: [f64; 2],
        anchor: (HPos, VPos),
        color: RGBColor,
    ) -> Result<(), ChartError> {
        self.write(text, at, anchor, color, font(TEXT_SIZE))
    }

    /// Writes small text for a label beside a point; the text starts at `at`.
    pub(super) fn small_text(&self, text: &str, at: [f64; 2], color: RGBColor) -> Result<(), ChartError> {
        self.write(text, at, (HPos::Left, VPos::Center), color, font(SMALL_SIZE))
    }

    /// Writes text that reads upwards, as for the title of a vertical axis.
    pub(super) fn upward_text(&self, text: &str, at: [f64; 2]) -> Result<(), ChartError> {
        let upward = font(TEXT_SIZE).transform(FontTransform::Rotate270);
        self.write(text, at, (HPos::Center, VPos::Top), INK, upward)
    }

    fn write(
        &self,
        text: &str,
        at: [f64; 2],
        (horizontal, vertical): (HPos, VPos),
        color: RGBColor,
        font: FontDesc<'_>,
    ) -> Result<(), ChartError> {
        let text: String = text.chars().filter(|c| is_xml_letter(*c)).collect();
        let style = font.color(&color).pos(Pos::new(horizontal, vertical));
        self.root.draw(&Text::new(text, pixel(at), style)).map_err(failed)
    }

    /// Writes the title at the top of the picture.
    pub(super) fn title(&self, title: &str) -> Result<(), ChartError> {
        let bold = font(TITLE_SIZE).style(FontStyle::Bold);
        self.write(title, [LEFT, 24.0], (HPos::Left, VPos::Center), INK, bold)
    }

    /// Draws an entry of the legend, symbol and label, from `[x, y]` to the right.
    pub(super) fn entry(&self, swatch: Swatch, label: &str, [x, y]: [f64; 2]) -> Result<(), ChartError> {
        let ends = [[x, y], [x + SWATCH, y]];
        match swatch {
            Swatch::Line(color) => self.line(&ends, color, 2.5),
            Swatch::Dashed(color) => self.dashed(ends, color, 2.0),
            Swatch::Band(color, opacity) => self.rectangle([[x, y - 6.0], [x + SWATCH, y + 6.0]], color, opacity),
            Swatch::Mark(mark, color) => self.mark(mark, [x + SWATCH / 2.0, y], color),
            Swatch::Toward([along, up], color) => {
                let half = SWATCH / 2.0;
                let at = |side: f64| [x + half + side * half * along, y - side * half * up];
                self.arrow(at(-1.0), at(1.0), color)
            }
            Swatch::Arrow(color) => self.arrow([x + SWATCH / 2.0, y - 8.0], [x + SWATCH / 2.0, y + 7.0], color),
        }?;
        self.text(label, [x + SWATCH + 8.0, y], (HPos::Left, VPos::Center), INK)
    }
}

/// Arranges the entries of a legend below `title` in a picture of `width`. Returns their positions, and the height of
/// title and legend, in picture units.
pub(super) fn arranged(title: &str, legend: &[(Swatch, &str)], width: f64) -> (Vec<[f64; 2]>, f64) {
    // A narrow picture needs the whole width for its legend.
    let left = if width < WIDTH { RIGHT } else { LEFT };
    let mut next = [left, if title.is_empty() { 24.0 } else { 52.0 }];
    let mut places = Vec::new();
    for (_, label) in legend {
        let own = SWATCH + 8.0 + text_width(label) + 22.0;
        // The gap after the last label may lie in the margin.
        if next[0] > left && next[0] + own > width {
            next = [left, next[1] + LEGEND_HEIGHT];
        }
        places.push(next);
        next[0] += own;
    }
    let height = if legend.is_empty() { 48.0 } else { next[1] + LEGEND_HEIGHT };
    (places, height)
}

/// Estimated width of small text, in picture units.
pub(super) fn small_text_width(text: &str) -> f64 {
    text_width(text) * SMALL_SIZE / TEXT_SIZE
}

/// Estimated width of text in the default size, in picture units.
fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * CHARACTER_WIDTH * TEXT_SIZE
}
