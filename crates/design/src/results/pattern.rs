//! Record of a texture in result files.

use serde::{Deserialize, Serialize};
use slipgrid_base::units::{LENGTH_UM, tidy};
use slipgrid_model::pattern::{Arrangement, Pattern, Planform, Polygon};

use super::rim::RimReport;

/// Texture of a sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PatternReport {
    /// Width of a cavity along the sliding direction.
    pub width_um: f64,
    /// Gap between two cavities.
    pub spacing_um: f64,
    /// Depth of a cavity.
    pub depth_um: f64,
    /// Shape of the cavities seen from above.
    pub planform: String,
    /// Length of a rectangle across its row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub length_um: Option<f64>,
    /// Corners of a polygon as `[x, y]`, anticlockwise; the origin is the middle of its bounding box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vertices_um: Option<Vec<[f64; 2]>>,
    /// Gap between rows, if it differs from the gap within a row.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spacing_across_um: Option<f64>,
    /// Arrangement of rows, `staggered` or `hexagonal`; left out for the square arrangement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub arrangement: Option<String>,
    /// Angle of grooves from the direction across the specimen's x axis; left out if zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Angle of the second family of crossing grooves from the first.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crossing_angle_deg: Option<f64>,
    /// Angle of the sliding direction from the specimen's x axis; left out if zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sliding_angle_deg: Option<f64>,
    /// Rims along the edges of the cavities, if there are any.
    #[serde(flatten)]
    pub rim: Option<RimReport>,
    /// Share of the surface that is cavity.
    pub areal_density: f64,
    /// Share of the section through the cavities' centres that is cavity.
    pub section_density: f64,
}

impl From<&Pattern> for PatternReport {
    /// Converts a pattern; default values are left out.
    fn from(pattern: &Pattern) -> Self {
        let texture = pattern.texture();
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        let turned = |angle_deg: f64| (angle_deg != 0.0).then(|| tidy(angle_deg));
        let arrangement = texture.arrangement();
        Self {
            width_um: um(pattern.width_m()),
            spacing_um: um(pattern.spacing_m()),
            depth_um: um(pattern.depth_m()),
            planform: texture.planform().name().to_owned(),
            length_um: pattern.length_m().filter(|_| texture.planform() == Planform::Rectangle).map(um),
            vertices_um: texture.outline().map(|outline| vertices_um(outline, pattern.width_m())),
            spacing_across_um: texture.spacing_across_m().map(um),
            arrangement: (arrangement != Arrangement::Square).then(|| arrangement.name().to_owned()),
            angle_deg: turned(texture.groove_angle_deg()),
            crossing_angle_deg: texture.crossing_angle_deg().map(tidy),
            sliding_angle_deg: turned(texture.sliding_angle_deg()),
            rim: texture.rim().and_then(RimReport::of),
            areal_density: tidy(pattern.areal_density()),
            section_density: tidy(pattern.section_density()),
        }
    }
}

/// Corners of an outline at its width, in um, with 15 digits, which identify the outline exactly.
fn vertices_um(outline: Polygon, width_m: f64) -> Vec<[f64; 2]> {
    let written = |share: f64| {
        let at_um = share * LENGTH_UM.from_si(width_m);
        format!("{at_um:.14e}").parse().unwrap_or(at_um)
    };
    outline.vertices().iter().map(|vertex| vertex.map(written)).collect()
}

/// Formats a length in micrometres, rounded to 0.01 um, which no laser resolves.
#[must_use]
pub fn length_in_words(length_um: f64) -> String {
    ((100.0 * length_um).round() / 100.0).to_string()
}

/// Formats a laser time: in seconds, and in minutes from ten minutes on. It has two decimals below 1 s, one below 100
/// s, none below 600 s, and one in minutes. The explorer formats times alike.
#[must_use]
pub fn duration_in_words(seconds: f64) -> String {
    match seconds {
        _ if seconds < 0.995 => format!("{seconds:.2} s"),
        _ if seconds < 99.95 => format!("{seconds:.1} s"),
        _ if seconds < 599.5 => format!("{seconds:.0} s"),
        _ => format!("{:.1} min", seconds / 60.0),
    }
}

impl PatternReport {
    /// Formats width, spacing and depth as `130 / 370 / 5.2`, in um.
    #[must_use]
    pub fn lengths_in_words(&self) -> String {
        [self.width_um, self.spacing_um, self.depth_um].map(length_in_words).join(" / ")
    }

    /// Describes the properties of the texture that the name of the planform does not give; empty if there are none.
    #[must_use]
    pub fn texture_words(&self) -> String {
        let lengths = [("long", self.length_um), ("between rows", self.spacing_across_um)];
        let lengths =
            lengths.into_iter().filter_map(|(what, um)| um.map(|um| format!(", {} um {what}", length_in_words(um))));
        let angles = [
            ("grooves turned by", self.angle_deg),
            ("crossing at", self.crossing_angle_deg),
            ("sliding at", self.sliding_angle_deg),
        ];
        let angles = angles.into_iter().filter_map(|(what, angle)| angle.map(|angle| format!(", {what} {angle} deg")));
        let arrangement = self.arrangement.iter().map(|name| format!(", {name}"));
        let corners = self.vertices_um.iter().map(|vertices| format!(", {} corners", vertices.len()));
        let rim = self.rim.iter().map(|rim| format!(", {}", rim.words(self.depth_um)));
        lengths.chain(corners).chain(arrangement).chain(angles).chain(rim).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_digits_that_rank_them() {
        let times = [0.042, 0.996, 2.34, 2.65, 13.0, 99.96, 480.0, 600.0, 5400.0].map(duration_in_words);
        assert_eq!(times, ["0.04 s", "1.0 s", "2.3 s", "2.6 s", "13.0 s", "100 s", "480 s", "10.0 min", "90.0 min"]);
    }
}
