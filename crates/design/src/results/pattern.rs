//! Record of a texture in result files.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::key_error::{KeyError, Refusal};
use slipgrid_base::units::{LENGTH_UM, significant, tidy};
use slipgrid_model::pattern::{Pattern, Planform, Rim, TextureRecord};

/// Texture of a sample.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PatternReport {
    /// Width of a cavity along the sliding direction.
    pub width_um: f64,
    /// Gap between two cavities.
    pub spacing_um: f64,
    /// Depth of a cavity.
    pub depth_um: f64,
    /// Shape, arrangement, directions and rims.
    #[serde(flatten)]
    pub texture: TextureRecord,
    /// Areal density: share of a period of the infinite pattern that is cavity.
    pub areal_density: f64,
    /// Share of the section through the cavities' centres that is cavity.
    pub section_density: f64,
}

impl From<&Pattern> for PatternReport {
    fn from(pattern: &Pattern) -> Self {
        let [width_um, spacing_um, depth_um] = pattern.lengths_m().map(|length_m| LENGTH_UM.from_si(length_m));
        Self {
            width_um,
            spacing_um,
            depth_um,
            texture: pattern.into(),
            areal_density: tidy(pattern.areal_density()),
            section_density: tidy(pattern.section_density()),
        }
    }
}

/// Formats a length in micrometres, rounded to 0.01 um, finer than any laser resolves.
pub fn length_in_words(length_um: f64) -> String {
    ((100.0 * length_um).round() / 100.0).to_string()
}

/// Formats a laser time: in seconds, and in minutes from ten minutes on. It has two decimals below 1 s, one below 100
/// s, none below 600 s, and one in minutes. The explorer formats times alike.
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
    pub fn lengths_in_words(&self) -> String {
        [self.width_um, self.spacing_um, self.depth_um].map(length_in_words).join(" / ")
    }

    /// Converts the record back into the pattern.
    ///
    /// # Errors
    /// [`KeyError`] at the key whose value gives no valid pattern.
    pub fn pattern(&self) -> Result<Pattern, KeyError> {
        if self.texture.planform.is_none() {
            return Err(KeyError { key: "planform", refusal: Refusal::Missing });
        }
        let texture = self.texture.texture(None)?;
        let length_m = |key, length_um| KeyError::number(key, length_um, LENGTH_UM);
        let (width_m, spacing_m) = (length_m("width_um", self.width_um)?, length_m("spacing_um", self.spacing_um)?);
        let pattern = Pattern::new(texture, width_m, spacing_m, length_m("depth_um", self.depth_um)?);
        pattern.map_err(|error| KeyError::from_error("spacing_um", &error))
    }

    /// Name of the planform.
    pub fn planform(&self) -> &str {
        self.texture.planform.as_deref().unwrap_or(Planform::Groove.name())
    }

    /// Rims, if there are any.
    pub fn rim(&self) -> Option<Rim> {
        self.texture.rim().ok().flatten()
    }

    /// Describes the rims of cavities of this depth, with lengths in um; `None` if there are none.
    pub fn rim_words(&self) -> Option<String> {
        let rim = self.rim()?;
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        let height_um = significant(um(rim.height_m(LENGTH_UM.to_si(self.depth_um))), 3);
        let std_um = Some(um(rim.height_std_m())).filter(|std_um| *std_um > 0.0);
        let scatter = std_um.map_or_else(String::new, |std_um| format!(", scattering by {std_um} um"));
        Some(format!("{} rims {height_um} um high, {} um wide{scatter}", rim.profile(), um(rim.width_m())))
    }

    /// Describes the properties of the texture that the name of the planform does not give; empty if there are none.
    pub fn texture_words(&self) -> String {
        let lengths = [("long", self.texture.length_um), ("between rows", self.texture.spacing_across_um)];
        let lengths =
            lengths.into_iter().filter_map(|(what, um)| um.map(|um| format!(", {} um {what}", length_in_words(um))));
        let angles = [
            ("grooves turned by", self.texture.angle_deg),
            ("crossing at", self.texture.crossing_angle_deg),
            ("sliding at", self.texture.sliding_angle_deg),
        ];
        let angles = angles.into_iter().filter_map(|(what, angle)| angle.map(|angle| format!(", {what} {angle} deg")));
        let arrangement = self.texture.arrangement.iter().map(|name| format!(", {name}"));
        let corners = self.texture.vertices_um.iter().map(|vertices| format!(", {} corners", vertices.len()));
        let rim = self.rim_words().map(|rim| format!(", {rim}"));
        lengths.chain(corners).chain(arrangement).chain(angles).chain(rim).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipgrid_model::pattern::{RimProfile, Texture};

    #[test]
    fn times_have_the_digits_that_rank_them() {
        let times = [0.042, 0.996, 2.34, 2.65, 13.0, 99.96, 480.0, 600.0, 5400.0].map(duration_in_words);
        assert_eq!(times, ["0.04 s", "1.0 s", "2.3 s", "2.6 s", "13.0 s", "100 s", "480 s", "10.0 min", "90.0 min"]);
    }

    #[test]
    fn what_is_written_reads_back_to_the_last_bit_and_a_rim_of_no_height_is_not_written() {
        for n in 1..400_u32 {
            let um = |hundredths: u32| LENGTH_UM.to_si(f64::from(hundredths) / 100.0);
            let pairs = [[um(n), um(n + 7)], [um(2 * n), um(3 * n)]];
            let profile = RimProfile::IN_FILES[n as usize % 3];
            for rim in [
                Rim::new(um(n), um(900 + n), profile).unwrap().with_height_std_m(um(n / 3)).unwrap(),
                Rim::following_depth(&pairs, um(1700 + n), profile).unwrap(),
                Rim::following_depth(&pairs[..1], um(n), profile).unwrap(),
            ] {
                let pattern =
                    Pattern::new(Texture::new(Planform::Groove).with_rim(rim), 1e-4, 2e-4, um(300 + n)).unwrap();
                let json = crate::results::json(&PatternReport::from(&pattern)).unwrap();
                let read: PatternReport = serde_json::from_str(&json).unwrap();
                assert_eq!(read.pattern().unwrap(), pattern, "{json}");
            }
        }
        let none = Rim::new(0.0, 1e-5, RimProfile::Flat).unwrap();
        let report = |texture| PatternReport::from(&Pattern::new(texture, 1e-4, 2e-4, 1e-5).unwrap());
        let without = report(Texture::new(Planform::Groove));
        assert_eq!(report(Texture::new(Planform::Groove).with_rim(none)), without);
        let json = crate::results::json(&without).unwrap();
        assert!(!json.contains("rim") && serde_json::from_str::<PatternReport>(&json).unwrap() == without, "{json}");
        assert!(report(Texture::new(Planform::Groove).with_rim(none.with_height_std_m(1e-8).unwrap())).rim().is_some());
    }

    #[test]
    fn rims_have_the_height_of_their_cavities_and_bad_records_are_refused_by_their_key() {
        let with = |rim: Rim, depth_m: f64| {
            let texture = Texture::new(Planform::Groove).with_rim(rim);
            PatternReport::from(&Pattern::new(texture, 1e-4, 2e-4, depth_m).unwrap())
        };
        let whole = with(Rim::new(1e-7, 1e-5, RimProfile::Round).unwrap(), 5e-6);
        assert_eq!(whole.rim_words().unwrap(), "round rims 0.1 um high, 10 um wide");
        // 0.05 um + 0.1 um * (5.2 - 2.6) / (10.4 - 2.6)
        let pairs = [[2.6e-6, 5e-8], [10.4e-6, 15e-8]];
        let by_depth = with(Rim::following_depth(&pairs, 2e-5, RimProfile::Round).unwrap(), 5.2e-6);
        assert_eq!(by_depth.rim_words().unwrap(), "round rims 0.0833 um high, 20 um wide");
        let texture = whole.texture;
        for (key, bad) in [
            ("rim_height_um", TextureRecord { rim_height_um: Some(-1.0), ..texture.clone() }),
            ("rim_heights_um", TextureRecord { rim_heights_um: Some(vec![vec![1.0, 1.0]]), ..texture.clone() }),
            ("rim_width_um", TextureRecord { rim_height_um: None, ..texture.clone() }),
            ("rim_width_um", TextureRecord { rim_width_um: Some(0.0), ..texture.clone() }),
            ("rim_profile", TextureRecord { rim_profile: Some("square".to_owned()), ..texture.clone() }),
            ("rim_height_std_um", TextureRecord { rim_height_std_um: Some(f64::NAN), ..texture.clone() }),
            ("arrangement", TextureRecord { arrangement: Some("staggered".to_owned()), ..texture.clone() }),
            ("sliding_angle_deg", TextureRecord { sliding_angle_deg: Some(200.0), ..texture.clone() }),
        ] {
            assert_eq!(bad.texture(None).unwrap_err().key, key);
        }
    }
}
