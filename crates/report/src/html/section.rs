//! Picture of two periods of a pattern in vertical section, with both axes to one scale; very low rims are drawn
//! higher.

use slipgrid_base::units::LENGTH_UM;
use slipgrid_design::results::{PatternReport, fixed};
use slipgrid_model::pattern::{Rim, RimProfile};

/// Width of the picture, in picture units.
const WIDTH: f64 = 900.0;
/// Width of the two drawn periods, in picture units.
const DRAWN: f64 = 760.0;
/// Margin left of the periods, in picture units.
const LEFT: f64 = 70.0;
/// Maximum drawn height of the textured body, in picture units.
const MAX_HEIGHT: f64 = 420.0;

/// A rim whose height to scale is below this value is drawn higher, in picture units.
const MIN_RIM: f64 = 1.5;
/// Drawn height of a rim below `MIN_RIM`, before the stretch is rounded to one digit, in picture units.
const STRETCHED_RIM: f64 = 8.0;

/// Number of line segments with which a half-sine rim is drawn.
const HALF_SINE_PIECES: u32 = 16;

/// Rim as drawn, in picture units.
struct Drawn {
    profile: RimProfile,
    height: f64,
    /// Width of the rim.
    width: f64,
    /// Distance from the edge at which the drawn rim ends: at most half-way to the next cavity.
    end: f64,
    /// Drawn height over the height to scale.
    stretch: f64,
}

impl Drawn {
    fn new(rim: &Rim, [spacing_um, depth_um]: [f64; 2], scale: f64) -> Option<Self> {
        let to_scale = LENGTH_UM.from_si(rim.height_m(LENGTH_UM.to_si(depth_um))) * scale;
        let width = LENGTH_UM.from_si(rim.width_m()) * scale;
        if to_scale <= 0.0 {
            return None;
        }
        // One digit, so that the text can state the factor.
        let wanted = STRETCHED_RIM / to_scale;
        let stretch = if to_scale < MIN_RIM { format!("{wanted:.0e}").parse().unwrap_or(wanted) } else { 1.0 };
        let end = width.min(0.5 * spacing_um * scale);
        Some(Self { profile: rim.profile(), height: stretch * to_scale, width, end, stretch })
    }

    /// SVG path of the rim from the land at the height `face` to the cavity's edge at `x`. The rim lies right of the
    /// edge for `sign` 1 and left of it for -1. If `back`, the path runs from the edge to the land.
    fn outline(&self, x: f64, face: f64, sign: f64, back: bool) -> String {
        let unit = |value: f64| fixed(Some(value), 2);
        let outer = x + sign * self.end;
        let height = |away: f64| face + self.height * self.profile.height((away / self.width).min(1.0 - f64::EPSILON));
        let (edge, step) = (height(0.0), height(self.end));
        let [(x0, y0), (x1, y1)] = if back { [(x, edge), (outer, step)] } else { [(outer, step), (x, edge)] };
        // The tangents of a parabola meet half-way, at the height of the crest if the crest lies at the edge.
        let way = match self.profile {
            RimProfile::Round => {
                format!("Q{} {} {} {}", unit(x + 0.5 * sign * self.end), unit(edge), unit(x1), unit(y1))
            }
            RimProfile::HalfSine => (1..=HALF_SINE_PIECES)
                .map(|piece| {
                    let part = f64::from(piece) / f64::from(HALF_SINE_PIECES);
                    let at = x0 + part * (x1 - x0);
                    format!("L{} {}", unit(at), unit(height((at - x).abs())))
                })
                .collect(),
            RimProfile::Flat | RimProfile::Ramp => format!("L{} {}", unit(x1), unit(y1)),
        };
        let last = if back { format!("V{}", unit(face)) } else { String::new() };
        format!("H{}V{}{way}{last}", unit(x0), unit(y0))
    }
}

/// Draws the section through the centres of cavities along a row, with the counterface below, as SVG text. Has no
/// labels unless `is_labelled`. The text is empty if a length is not positive.
pub fn section(pattern: &PatternReport, is_labelled: bool) -> String {
    let &PatternReport { width_um, spacing_um, depth_um, .. } = pattern;
    let pitch_um = width_um + spacing_um;
    let positive = [width_um, spacing_um, depth_um].iter().all(|length_um| length_um.is_finite() && *length_um > 0.0);
    if !positive {
        return String::new();
    }
    let scale = DRAWN / (2.0 * pitch_um);
    let (width, pitch, depth) = (width_um * scale, pitch_um * scale, depth_um * scale);
    let body = (3.0 * depth).clamp(40.0, MAX_HEIGHT);
    let depth = depth.min(body);
    let (top, face) = (46.0, 46.0 + body);
    let rim = pattern.rim().and_then(|rim| Drawn::new(&rim, [spacing_um, depth_um], scale));
    // The body stands on its rims.
    let counterface = face + rim.as_ref().map_or(0.0, |rim| rim.height);
    let height = counterface + 78.0;
    let unit = |value: f64| fixed(Some(value), 2);
    let starts = [0.5 * (pitch - width), 0.5 * (pitch - width) + pitch].map(|start| LEFT + start);
    let mut outline = format!("M{} {}H{}V{}", unit(LEFT), unit(top), unit(LEFT + DRAWN), unit(face));
    for start in starts.iter().rev() {
        if let Some(rim) = &rim {
            outline += &rim.outline(start + width, face, 1.0, false);
            outline += &format!("V{}", unit(face - depth));
            outline += &rim.outline(*start, face, -1.0, true);
            continue;
        }
        outline += &format!("H{}V{}H{}V{}", unit(start + width), unit(face - depth), unit(*start), unit(face));
    }
    outline += &format!("H{}z", unit(LEFT));
    if !is_labelled {
        return format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"{} {} {} {}\">\n\
             <path d=\"{outline}\" fill=\"#cfe3f0\" stroke=\"#333\" stroke-width=\"2.5\"/>\n\
             <path d=\"M{LEFT} {}H{}\" stroke=\"#333\" stroke-width=\"6\"/>\n</svg>\n",
            unit(LEFT - 2.0),
            unit(top - 4.0),
            unit(DRAWN + 4.0),
            unit(counterface - top + 14.0),
            unit(counterface + 4.0),
            unit(LEFT + DRAWN),
        );
    }
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{}\" viewBox=\"0 0 {WIDTH} {}\" \
         font-family=\"sans-serif\" font-size=\"15\" fill=\"#333\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <path d=\"{outline}\" fill=\"#cfe3f0\" stroke=\"#333\"/>\n\
         <path d=\"M{LEFT} {}H{}\" stroke=\"#333\" stroke-width=\"3\"/>\n",
        unit(height),
        unit(height),
        unit(counterface + 2.0),
        unit(LEFT + DRAWN),
    );
    let scales = match &rim {
        Some(rim) if rim.stretch != 1.0 => format!("both axes at one scale, rims {} times as high", rim.stretch),
        _ => "both axes at one scale".to_owned(),
    };
    let mut label = |x: f64, y: f64, anchor: &str, text: &str| {
        svg += &format!("<text x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\">{text}</text>\n", unit(x), unit(y));
    };
    label(LEFT, 24.0, "start", "textured body");
    label(LEFT + DRAWN, 24.0, "end", &scales);
    label(LEFT, counterface + 22.0, "start", "counterface");
    let middle = starts[0] + width / 2.0;
    label(middle, face - depth - 8.0, "middle", &format!("depth {} µm", unit(depth_um)));
    label(middle, counterface + 42.0, "middle", &format!("width {} µm", unit(width_um)));
    label(
        starts[0] + width + (pitch - width) / 2.0,
        counterface + 42.0,
        "middle",
        &format!("spacing {} µm", unit(spacing_um)),
    );
    label(starts[0] + pitch / 2.0, counterface + 66.0, "middle", &format!("pitch {} µm", unit(pitch_um)));
    for x in [starts[0], starts[0] + width, starts[1]] {
        svg += &format!(
            "<path d=\"M{x} {}V{}\" stroke=\"#333\"/>\n",
            unit(counterface + 6.0),
            unit(counterface + 30.0),
            x = unit(x)
        );
    }
    svg + "</svg>\n"
}
