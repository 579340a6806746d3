//! Keys of a pattern for the rims at the edges of cavities.

use slipgrid_base::units::{LENGTH_UM, RIM_HEIGHT_UM};
use slipgrid_model::pattern::{Rim, RimProfile};
use toml::Spanned;

use super::document::Document;
use super::pattern::TextureFile;
use super::values::NumberList;
use crate::formats::diagnostic::Diagnostic;

/// Keys that give the height of a rim.
const HEIGHTS: &str = "rim_height_um, or rim_heights_um = [[depth, height], ...], beside it";

/// Reads the rims of a texture, including rims of zero height; `None` if no key of rims is present.
///
/// # Errors
/// [`Diagnostic`] if a height has no width, if a width, profile or scatter has no height, if heights of both kinds are
/// given, if pairs are malformed or their depths do not ascend, if the profile is unknown, or if numbers are out of
/// range.
pub fn read_rim(document: &Document, file: &TextureFile) -> Result<Option<Rim>, Diagnostic> {
    let height = file.rim_height_um.as_ref();
    let (heights, place) = match (height, &file.rim_heights_um) {
        (None, None) => {
            let spans = [
                file.rim_width_um.as_ref().map(Spanned::span),
                file.rim_profile.as_ref().map(Spanned::span),
                file.rim_height_std_um.as_ref().map(Spanned::span),
            ];
            return match spans.into_iter().flatten().next() {
                Some(span) => Err(document.refuse(span, "stands without a height of the rims").expected(HEIGHTS)),
                None => Ok(None),
            };
        }
        (Some(_), Some(pairs)) => {
            return Err(document
                .refuse(pairs.span(), "stands beside rim_height_um")
                .expected("either rim_height_um or rim_heights_um"));
        }
        (Some(height), None) => (vec![[0.0, document.number(height, RIM_HEIGHT_UM)?]], height.span()),
        (None, Some(pairs)) => (read_pairs(document, pairs)?, pairs.span()),
    };
    let Some(width) = &file.rim_width_um else {
        return Err(document
            .refuse(place, "stands without a width of the rims")
            .expected("rim_width_um, the distance from the edge at which a rim ends, beside it"));
    };
    let width_m = document.number(width, LENGTH_UM)?;
    let profile = match &file.rim_profile {
        Some(name) => document.choice(name, &RimProfile::ALL, RimProfile::name)?,
        None => RimProfile::default(),
    };
    let std_m = document.optional(file.rim_height_std_um.as_ref(), RIM_HEIGHT_UM)?.unwrap_or(0.0);
    Rim::following_depth(&heights, width_m, profile)
        .and_then(|rim| rim.with_height_std_m(std_m))
        .map(Some)
        .map_err(|error| document.refuse(place, error.to_string()))
}

/// Reads pairs of depth and height, in metres.
fn read_pairs(document: &Document, pairs: &Spanned<Vec<NumberList>>) -> Result<Vec<[f64; 2]>, Diagnostic> {
    let most = Rim::MAX_HEIGHTS;
    if pairs.get_ref().is_empty() || pairs.get_ref().len() > most {
        let reason = format!("has {} pairs", pairs.get_ref().len());
        return Err(document
            .refuse(pairs.span(), reason)
            .expected(format!("1 to {most} pairs [depth, height], in um")));
    }
    let mut read: Vec<[f64; 2]> = Vec::new();
    for pair in pairs.get_ref() {
        let [depth, height] = &pair.get_ref()[..] else {
            let reason = format!("has {} numbers", pair.get_ref().len());
            return Err(document.refuse(pair.span(), reason).expected("a depth and a height, in um"));
        };
        let found = [document.number(depth, LENGTH_UM.or_zero())?, document.number(height, RIM_HEIGHT_UM)?];
        if read.last().is_some_and(|[before_m, _]| *before_m >= found[0]) {
            let reason = "is no deeper than the cavity before it";
            return Err(document.refuse(depth.span(), reason).expected("depths that ascend from pair to pair"));
        }
        read.push(found);
    }
    Ok(read)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(keys: &str) -> Result<Option<Rim>, String> {
        let document = Document::new("a.toml", keys);
        let file: TextureFile = document.parse().map_err(|refused| refused.to_string())?;
        read_rim(&document, &file).map_err(|refused| refused.to_string())
    }

    #[test]
    fn heights_stand_alone_or_follow_the_depth() {
        let rim = read("rim_height_um = 0.1\nrim_width_um = 10").unwrap().unwrap();
        let um = |um: f64| LENGTH_UM.to_si(um);
        assert_eq!(rim, Rim::new(um(0.1), um(10.0), RimProfile::Round).unwrap());
        let keys = "rim_heights_um = [[5.2, 0.1], [20, 0.5]]\nrim_width_um = 12.5\nrim_profile = \"flat\"\n\
                    rim_height_std_um = 0.02";
        let pairs = [[um(5.2), um(0.1)], [um(20.0), um(0.5)]];
        let expected = Rim::following_depth(&pairs, um(12.5), RimProfile::Flat).unwrap();
        assert_eq!(read(keys).unwrap().unwrap(), expected.with_height_std_m(um(0.02)).unwrap());
        assert_eq!(read("planform = \"groove\"").unwrap(), None);
        assert!(!read("rim_height_um = 0\nrim_width_um = 10").unwrap().unwrap().stands());
    }

    #[test]
    fn refusals_name_line_key_and_value_and_what_is_accepted() {
        for (keys, refused) in [
            ("rim_height_um = 0.1", "1: rim_height_um: 0.1 stands without a width of the rims; expected rim_width_um"),
            (
                "rim_width_um = 10.0",
                "1: rim_width_um: 10.0 stands without a height of the rims; expected rim_height_um",
            ),
            ("rim_profile = \"flat\"", "1: rim_profile: \"flat\" stands without a height"),
            ("rim_height_std_um = 0.1", "1: rim_height_std_um: 0.1 stands without a height"),
            (
                "rim_height_um = 0.1\nrim_heights_um = [[1.0, 0.1]]",
                "2: rim_heights_um: [[1.0, 0.1]] stands beside rim_height_um; expected either rim_height_um or rim_heights_um",
            ),
            (
                "rim_height_um = 0.1\nrim_width_um = 10\nrim_profile = \"rund\"",
                "3: rim_profile: \"rund\" is not known; expected \"round\" or \"flat\" or \"ramp\" (did you mean `round`?)",
            ),
            (
                "rim_height_um = -0.1\nrim_width_um = 10",
                "1: rim_height_um: -0.1 is out of range; expected a number from 0",
            ),
            (
                "rim_height_um = 0.1\nrim_width_um = 0",
                "2: rim_width_um: 0 is out of range; expected a number from 0.000001",
            ),
            (
                "rim_heights_um = [[5.0, 0.1], [5.0, 0.2]]\nrim_width_um = 10",
                "1: rim_heights_um: 5.0 is no deeper than the cavity before it; expected depths that ascend",
            ),
            (
                "rim_heights_um = [[5.0, 0.1, 1.0]]\nrim_width_um = 10",
                "1: rim_heights_um: [5.0, 0.1, 1.0] has 3 numbers",
            ),
            ("rim_heights_um = []\nrim_width_um = 10", "1: rim_heights_um: has 0 pairs; expected 1 to 8 pairs"),
            ("rim_heights_um = 0.1\nrim_width_um = 10", "1: rim_heights_um: 0.1 has the wrong type"),
            ("rim_hight_um = 0.1", "1: rim_hight_um: is not a known key"),
        ] {
            let found = read(keys).unwrap_err();
            assert!(found.starts_with(&format!("a.toml:{refused}")), "{keys}: {found}");
        }
    }
}
