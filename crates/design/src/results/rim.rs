//! Record of the rims of a pattern, with the keys of input files.

use serde::{Deserialize, Serialize};
use slipgrid_base::units::{LENGTH_UM, significant};
use slipgrid_model::pattern::{PatternError, Rim, RimProfile};

/// Rims along the edges of cavities.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RimReport {
    /// Height at the edge for any depth of the cavity; left out if the height depends on depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_height_um: Option<f64>,
    /// Pairs of the depth of a cavity and the height of its rim, by increasing depth.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_heights_um: Option<Vec<[f64; 2]>>,
    /// Distance from the edge at which a rim ends.
    pub rim_width_um: f64,
    /// Profile of a rim from the edge outward: `round`, `flat` or `ramp`.
    pub rim_profile: String,
    /// Standard deviation of heights from rim to rim of one sample; left out if all are equal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rim_height_std_um: Option<f64>,
}

impl RimReport {
    /// Converts a rim; `None` if it does not rise above the land.
    #[must_use]
    pub fn of(rim: &Rim) -> Option<Self> {
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        let (one, several) = match rim.heights_m() {
            [[depth_m, height_m]] if *depth_m == 0.0 => (Some(um(*height_m)), None),
            pairs => (None, Some(pairs.iter().map(|pair| pair.map(um)).collect())),
        };
        rim.stands().then(|| Self {
            rim_height_um: one,
            rim_heights_um: several,
            rim_width_um: um(rim.width_m()),
            rim_profile: rim.profile().name().to_owned(),
            rim_height_std_um: Some(um(rim.height_std_m())).filter(|std_um| *std_um > 0.0),
        })
    }

    /// Converts the record back into the rim.
    ///
    /// # Errors
    /// Key at fault and the error: heights of both kinds or of neither, an unknown profile, or a number out of range.
    pub fn rim(&self) -> Result<Rim, (&'static str, PatternError)> {
        let m = |um: f64| LENGTH_UM.to_si(um);
        let profile: RimProfile = self.rim_profile.parse().map_err(|error| ("rim_profile", error))?;
        let width_m = m(self.rim_width_um);
        let (key, rim) = match (self.rim_height_um, &self.rim_heights_um) {
            (Some(height_um), None) => ("rim_height_um", Rim::new(m(height_um), width_m, profile)),
            (None, pairs) => {
                let pairs: Vec<[f64; 2]> = pairs.iter().flatten().map(|pair| pair.map(m)).collect();
                ("rim_heights_um", Rim::following_depth(&pairs, width_m, profile))
            }
            (Some(_), Some(pairs)) => {
                ("rim_heights_um", Err(PatternError::RimHeights { count: pairs.len() + 1, most: Rim::MAX_HEIGHTS }))
            }
        };
        let keyed = |error: PatternError| match error {
            PatternError::NotALength { .. } => ("rim_width_um", error),
            _ => (key, error),
        };
        let std_m = m(self.rim_height_std_um.unwrap_or(0.0));
        rim.map_err(keyed)?.with_height_std_m(std_m).map_err(|error| ("rim_height_std_um", error))
    }

    /// Describes the rim of cavities of depth `depth_um` in words, with lengths in um.
    #[must_use]
    pub fn words(&self, depth_um: f64) -> String {
        let height_um = |rim: Rim| significant(LENGTH_UM.from_si(rim.height_m(LENGTH_UM.to_si(depth_um))), 3);
        let height = self.rim().map_or("of unknown height".to_owned(), |rim| format!("{} um high", height_um(rim)));
        let scatter = self.rim_height_std_um.map_or_else(String::new, |std_um| format!(", scattering by {std_um} um"));
        format!("{} rims {height}, {} um wide{scatter}", self.rim_profile, self.rim_width_um)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::PatternReport;
    use slipgrid_model::pattern::{Pattern, Planform, Texture};

    #[test]
    fn what_is_written_reads_back_to_the_last_bit_and_a_rim_of_no_height_is_not_written() {
        for n in 1..400_u32 {
            let um = |hundredths: u32| LENGTH_UM.to_si(f64::from(hundredths) / 100.0);
            let pairs = [[um(n), um(n + 7)], [um(2 * n), um(3 * n)]];
            let profile = RimProfile::ALL[n as usize % 3];
            for rim in [
                Rim::new(um(n), um(900 + n), profile).unwrap().with_height_std_m(um(n / 3)).unwrap(),
                Rim::following_depth(&pairs, um(1700 + n), profile).unwrap(),
                Rim::following_depth(&pairs[..1], um(n), profile).unwrap(),
            ] {
                let pattern =
                    Pattern::new(Texture::new(Planform::Groove).with_rim(rim), 1e-4, 2e-4, um(300 + n)).unwrap();
                let json = crate::results::json(&PatternReport::from(&pattern)).unwrap();
                let read: PatternReport = serde_json::from_str(&json).unwrap();
                assert_eq!(read.rim.unwrap().rim().unwrap(), rim, "{json}");
            }
        }
        let none = Rim::new(0.0, 1e-5, RimProfile::Flat).unwrap();
        let pattern = |texture| Pattern::new(texture, 1e-4, 2e-4, 1e-5).unwrap();
        let without = PatternReport::from(&pattern(Texture::new(Planform::Groove)));
        assert_eq!(PatternReport::from(&pattern(Texture::new(Planform::Groove).with_rim(none))), without);
        let json = crate::results::json(&without).unwrap();
        assert!(!json.contains("rim") && serde_json::from_str::<PatternReport>(&json).unwrap() == without, "{json}");
        assert!(RimReport::of(&none.with_height_std_m(1e-8).unwrap()).is_some());
    }

    #[test]
    fn records_that_are_no_rim_are_refused_by_their_key() {
        let whole = RimReport::of(&Rim::new(1e-7, 1e-5, RimProfile::Round).unwrap()).unwrap();
        assert_eq!(whole.words(5.0), "round rims 0.1 um high, 10 um wide");
        // 0.05 um + 0.1 um * (5.2 - 2.6) / (10.4 - 2.6)
        let pairs = [[2.6e-6, 5e-8], [10.4e-6, 15e-8]];
        let by_depth = RimReport::of(&Rim::following_depth(&pairs, 2e-5, RimProfile::Round).unwrap()).unwrap();
        assert_eq!(by_depth.words(5.2), "round rims 0.0833 um high, 20 um wide");
        for (key, bad) in [
            ("rim_height_um", RimReport { rim_height_um: Some(-1.0), ..whole.clone() }),
            ("rim_heights_um", RimReport { rim_heights_um: Some(vec![[1.0, 1.0]]), ..whole.clone() }),
            ("rim_heights_um", RimReport { rim_height_um: None, ..whole.clone() }),
            ("rim_width_um", RimReport { rim_width_um: 0.0, ..whole.clone() }),
            ("rim_profile", RimReport { rim_profile: "square".to_owned(), ..whole.clone() }),
            ("rim_height_std_um", RimReport { rim_height_std_um: Some(f64::NAN), ..whole.clone() }),
        ] {
            assert_eq!(bad.rim().unwrap_err().0, key);
        }
    }
}
