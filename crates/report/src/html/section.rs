//! Two periods of a pattern in vertical section, both axes at one scale.

use slipgrid_results::fixed;

/// Width of the picture, and of the two periods in it.
const WIDTH: f64 = 900.0;
const DRAWN: f64 = 760.0;
const LEFT: f64 = 70.0;
/// Material drawn above a cavity's ceiling, and the most, in picture units.
const MOST_HEIGHT: f64 = 420.0;

/// The section through the centres of cavities along their row, the counterface below; lengths in micrometres.
/// Empty where a length is not positive.
pub fn section(width_um: f64, spacing_um: f64, depth_um: f64) -> String {
    let pitch_um = width_um + spacing_um;
    let positive = [width_um, spacing_um, depth_um].iter().all(|length_um| length_um.is_finite() && *length_um > 0.0);
    if !positive {
        return String::new();
    }
    let scale = DRAWN / (2.0 * pitch_um);
    let (width, pitch, depth) = (width_um * scale, pitch_um * scale, depth_um * scale);
    let body = (3.0 * depth).clamp(40.0, MOST_HEIGHT);
    let depth = depth.min(body);
    let (top, face) = (46.0, 46.0 + body);
    let height = face + 78.0;
    let unit = |value: f64| fixed(Some(value), 2);
    let starts = [0.5 * (pitch - width), 0.5 * (pitch - width) + pitch].map(|start| LEFT + start);
    let mut outline = format!("M{} {}H{}V{}", unit(LEFT), unit(top), unit(LEFT + DRAWN), unit(face));
    for start in starts.iter().rev() {
        outline += &format!("H{}V{}H{}V{}", unit(start + width), unit(face - depth), unit(*start), unit(face));
    }
    outline += &format!("H{}z", unit(LEFT));
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{}\" viewBox=\"0 0 {WIDTH} {}\" \
         font-family=\"sans-serif\" font-size=\"15\" fill=\"#333\">\n<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n\
         <path d=\"{outline}\" fill=\"#cfe3f0\" stroke=\"#333\"/>\n\
         <path d=\"M{LEFT} {}H{}\" stroke=\"#333\" stroke-width=\"3\"/>\n",
        unit(height),
        unit(height),
        unit(face + 2.0),
        unit(LEFT + DRAWN),
    );
    let mut label = |x: f64, y: f64, anchor: &str, text: &str| {
        svg += &format!("<text x=\"{}\" y=\"{}\" text-anchor=\"{anchor}\">{text}</text>\n", unit(x), unit(y));
    };
    label(LEFT, 24.0, "start", "textured body");
    label(LEFT + DRAWN, 24.0, "end", "both axes at one scale");
    label(LEFT, face + 22.0, "start", "counterface");
    let middle = starts[0] + width / 2.0;
    label(middle, face - depth - 8.0, "middle", &format!("depth {} µm", unit(depth_um)));
    label(middle, face + 42.0, "middle", &format!("width {} µm", unit(width_um)));
    label(
        starts[0] + width + (pitch - width) / 2.0,
        face + 42.0,
        "middle",
        &format!("spacing {} µm", unit(spacing_um)),
    );
    label(starts[0] + pitch / 2.0, face + 66.0, "middle", &format!("pitch {} µm", unit(pitch_um)));
    for x in [starts[0], starts[0] + width, starts[1]] {
        svg += &format!("<path d=\"M{x} {}V{}\" stroke=\"#333\"/>\n", unit(face + 6.0), unit(face + 30.0), x = unit(x));
    }
    svg + "</svg>\n"
}
