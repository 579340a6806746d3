//! Enlarged detail of two periods of the pattern.

use std::fmt::Write as _;

use slipgrid_model::pattern::{Contour, Pattern};

use super::{CAVITY_COLOUR, DETAIL_SIDE, FACE_COLOUR, INK_COLOUR, Page, TEXT_SIZE};
use crate::export::{Layout, decimal};

/// Maximum number of rows of cavities that are drawn; more would be indistinguishable.
const MAX_ROWS: usize = 100;

impl Page {
    /// Draws two periods along the pattern's x axis and the same length across, with dimension lines.
    pub(super) fn detail(&mut self, layout: &Layout, [left, top]: [f64; 2]) {
        let pattern = layout.pattern();
        let pitch = DETAIL_SIDE / 2.0;
        let width = pitch * pattern.section_density();
        self.out.push_str("<g id=\"detail\">\n");
        let stroke = self.mm(0.2);
        let frame = format!("fill=\"{FACE_COLOUR}\" stroke=\"{INK_COLOUR}\" stroke-width=\"{stroke}\"");
        self.rectangle([left, top], [DETAIL_SIDE; 2], &frame);
        let starts = [(pitch - width) / 2.0, (pitch - width) / 2.0 + pitch];
        self.detail_cavities(pattern, [left, top], pitch, width);
        // Width and spacing on one line, the pitch below.
        let [first, second] = starts.map(|start| left + start);
        let y = top + DETAIL_SIDE + 3.0;
        for x in [first, first + width, second] {
            self.line([x, top + DETAIL_SIDE + 0.8], [x, y + 0.8]);
        }
        self.dimension([first, first + width], y, "w");
        self.dimension([first + width, second], y, "s");
        for x in [first, second] {
            self.line([x, y + 0.8], [x, y + 5.8]);
        }
        self.dimension([first, second], y + 5.0, "p");
        let enlargement = DETAIL_SIDE * self.unit_mm / (2.0 * pattern.pitch_m() * 1e3);
        let decimals = if enlargement < 9.95 { 1 } else { 0 };
        let label = format!("detail, {} : 1", decimal(enlargement, decimals));
        self.text([left + DETAIL_SIDE, y + 9.0], "end", TEXT_SIZE, "", &label);
        self.out.push_str("</g>\n");
    }

    /// Draws the cavities of two periods in the frame at `left` and `top`; all lengths are in page units.
    fn detail_cavities(&mut self, pattern: &Pattern, [left, top]: [f64; 2], pitch: f64, width: f64) {
        let cavity = format!("fill=\"{CAVITY_COLOUR}\"");
        let starts = [(pitch - width) / 2.0, (pitch - width) / 2.0 + pitch];
        if let Some(crossing_deg) = pattern.texture().crossing_angle_deg() {
            self.detail_crossing(crossing_deg, [left, top], pitch, width);
            return;
        }
        let Some((pitch_across_m, length_m)) = pattern.pitch_across_m().zip(pattern.length_m()) else {
            for x in starts {
                self.rectangle([left + x, top], [width, DETAIL_SIDE], &cavity);
            }
            return;
        };
        let scale = pitch / pattern.pitch_m();
        let outline = pattern.texture().outline();
        let square = pattern.texture().length_m().is_none() && outline.is_none();
        let (pitch_across, length) = (scale * pitch_across_m, if square { width } else { scale * length_m });
        // Two complete periods need no clipping.
        let staggered = pattern.texture().arrangement().shifts_rows();
        let clipped = staggered || outline.is_some() || pitch_across_m != pattern.pitch_m();
        if clipped {
            self.out.push_str("<clipPath id=\"detail-frame\">\n");
            self.rectangle([left, top], [DETAIL_SIDE; 2], "");
            self.out.push_str("</clipPath>\n<g clip-path=\"url(#detail-frame)\">\n");
        }
        let rows: Vec<f64> = (0..MAX_ROWS)
            .map(|row| (pitch_across - length) / 2.0 + row as f64 * pitch_across)
            .take_while(|&y| y < DETAIL_SIDE * (1.0 - 1e-9))
            .collect();
        let shifted = [-pitch / 2.0, pitch / 2.0, 1.5 * pitch].map(|shift| starts[0] + shift);
        // By columns, with the shifted rows last.
        for (columns, parity) in [(starts.as_slice(), 0), (shifted.as_slice(), 1)] {
            let is_drawn = |row: usize| if staggered { row % 2 == parity } else { parity == 0 };
            for &x in columns {
                for (_, &y) in rows.iter().enumerate().filter(|(row, _)| is_drawn(*row)) {
                    if let Some(outline) = outline {
                        let (x, y) = (left + x + width / 2.0, top + y + length / 2.0);
                        let corners =
                            outline.vertices().iter().map(|corner| [x + width * corner[0], y - width * corner[1]]);
                        self.polygon(corners, &cavity);
                        continue;
                    }
                    match pattern.planform().contour() {
                        Contour::Circle => {
                            self.disc([left + x + width / 2.0, top + y + width / 2.0], width / 2.0, &cavity);
                        }
                        Contour::Rectangle => self.rectangle([left + x, top + y], [width, length], &cavity),
                    }
                }
            }
        }
        if clipped {
            self.out.push_str("</g>\n");
        }
    }

    /// Draws two families of grooves that cross in the middle of the first vertical groove.
    fn detail_crossing(&mut self, crossing_deg: f64, [left, top]: [f64; 2], pitch: f64, width: f64) {
        let cavity = format!("fill=\"{CAVITY_COLOUR}\"");
        self.out.push_str("<clipPath id=\"detail-frame\">\n");
        self.rectangle([left, top], [DETAIL_SIDE; 2], "");
        self.out.push_str("</clipPath>\n<g clip-path=\"url(#detail-frame)\">\n");
        let [x, y] = [left + pitch / 2.0, top + DETAIL_SIDE / 2.0];
        // y points down, so that anticlockwise angles are negative.
        for angle in [0.0, -crossing_deg.to_radians()] {
            let (cosine, sine) = (libm::cos(angle), libm::sin(angle));
            for place in -3..=3 {
                let offset = f64::from(place) * pitch;
                let half = 2.0 * DETAIL_SIDE;
                let corner =
                    |across: f64, along: f64| [x + across * cosine - along * sine, y + across * sine + along * cosine];
                let [low, high] = [offset - width / 2.0, offset + width / 2.0];
                self.polygon([corner(low, -half), corner(high, -half), corner(high, half), corner(low, half)], &cavity);
            }
        }
        self.out.push_str("</g>\n");
    }

    fn polygon(&mut self, corners: impl IntoIterator<Item = [f64; 2]>, style: &str) {
        let points: Vec<String> = corners.into_iter().map(|[x, y]| format!("{},{}", self.mm(x), self.mm(y))).collect();
        let _ = writeln!(self.out, "<polygon points=\"{}\" {style}/>", points.join(" "));
    }

    fn disc(&mut self, [x, y]: [f64; 2], radius: f64, style: &str) {
        let (x, y, radius) = (self.mm(x), self.mm(y), self.mm(radius));
        let _ = writeln!(self.out, "<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" {style}/>");
    }

    fn dimension(&mut self, [from, to]: [f64; 2], y: f64, label: &str) {
        self.line([from, y], [to, y]);
        let head = (0.4 * (to - from)).min(1.2);
        self.arrowhead([from, y], [-1.0, 0.0], head);
        self.arrowhead([to, y], [1.0, 0.0], head);
        self.text([(from + to) / 2.0, y + 2.4], "middle", TEXT_SIZE, " font-style=\"italic\"", label);
    }
}
