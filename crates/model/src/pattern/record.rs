//! A texture as keys of a file: the one definition for files that are read and for records that are written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_base::key_error::{KeyError, Refusal};
use slipgrid_base::units::{
    CROSSING_ANGLE_DEG, GROOVE_ANGLE_DEG, LENGTH_UM, Quantity, RIM_HEIGHT_UM, SLIDING_ANGLE_DEG, tidy,
};

use super::{Arrangement, Pattern, PatternError, Planform, Polygon, Rim, RimProfile, Texture};

/// Texture as keys of a file. Keys that are absent have their default.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TextureRecord {
    /// Shape seen from above; `groove` when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub planform: Option<String>,
    /// Extent of a rectangle across its row.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length_um: Option<f64>,
    /// Outline of a polygon: corners as `[x, y]` in order, the last joined to the first. A file that is read may have them in
    /// any unit and order, as the shape is scaled to the width; a result has them in um, anticlockwise, from the middle of the
    /// bounding box.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub vertices_um: Option<Vec<[f64; 2]>>,
    /// Gap between rows; equal to the gap along the row when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub spacing_across_um: Option<f64>,
    /// `square`, `staggered` or `hexagonal`; `square` when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub arrangement: Option<String>,
    /// Angle of grooves (of the first family of crossing grooves) from the direction across the specimen's x axis,
    /// anticlockwise; 0 when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub angle_deg: Option<f64>,
    /// Angle of the second family of crossing grooves from the first, anticlockwise; 90 when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub crossing_angle_deg: Option<f64>,
    /// Angle of the sliding direction from the specimen's x axis, anticlockwise; 0 when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sliding_angle_deg: Option<f64>,
    /// Height of the rims at the edges of cavities, for any depth; no rims when neither `rim_height_um` nor
    /// `rim_heights_um` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rim_height_um: Option<f64>,
    /// Pairs of cavity depth and rim height, in ascending order.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rim_heights_um: Option<Vec<Vec<f64>>>,
    /// Distance from the edge at which a rim ends.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rim_width_um: Option<f64>,
    /// Outward profile of rims: `round`, `flat` or `ramp`; `round` when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rim_profile: Option<String>,
    /// Standard deviation of the height between rims of one sample; 0 when absent.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rim_height_std_um: Option<f64>,
}

/// Text of error messages: the keys that give the height of a rim.
const HEIGHTS: &str = "rim_height_um, or rim_heights_um = [[depth, height], ...], beside it";
/// Text of error messages: the planforms whose rows can be arranged.
const WITH_ROWS: &str = "planform = \"square\", \"rectangle\", \"disc\" or \"polygon\", or no such key";

impl TextureRecord {
    /// Writes `texture`, with cavities `width_m` wide, as keys. The planform, the length of rectangles, the outline of
    /// polygons, the crossing angle of a crosshatch and the profile of rims are always written, other properties only
    /// if they differ from their default.
    pub fn new(texture: &Texture, width_m: f64) -> Self {
        let um = |length_m: f64| LENGTH_UM.from_si(length_m);
        let turned = |angle_deg: f64| (angle_deg != 0.0).then(|| tidy(angle_deg));
        let arrangement = texture.arrangement();
        let rim = texture.rim().filter(|rim| rim.stands());
        let (height_m, by_depth) = match rim.map(Rim::heights_m) {
            Some([[depth_m, height_m]]) if *depth_m == 0.0 => (Some(*height_m), None),
            pairs => (None, pairs),
        };
        let length_m = texture.length_m().unwrap_or(width_m);
        Self {
            planform: Some(texture.planform().name().to_owned()),
            length_um: (texture.planform() == Planform::Rectangle).then(|| um(length_m)),
            vertices_um: texture.outline().map(|outline| vertices_um(outline, width_m)),
            spacing_across_um: texture.spacing_across_m().map(um),
            arrangement: (arrangement != Arrangement::Square).then(|| arrangement.name().to_owned()),
            angle_deg: turned(texture.groove_angle_deg()),
            crossing_angle_deg: texture.crossing_angle_deg().map(tidy),
            sliding_angle_deg: turned(texture.sliding_angle_deg()),
            rim_height_um: height_m.map(um),
            rim_heights_um: by_depth.map(|pairs| pairs.iter().map(|pair| pair.map(um).to_vec()).collect()),
            rim_width_um: rim.map(|rim| um(rim.width_m())),
            rim_profile: rim.map(|rim| rim.profile().name().to_owned()),
            rim_height_std_um: rim.map(|rim| um(rim.height_std_m())).filter(|std_um| *std_um > 0.0),
        }
    }

    /// Converts the keys to a texture. `drawn`, the outline of a polygon from a drawing, replaces `vertices_um` if
    /// given.
    ///
    /// # Errors
    /// [`KeyError`] if a name is unknown, a number is out of range, a key that the planform needs is absent, or the
    /// planform does not use a key.
    pub fn texture(&self, drawn: Option<Polygon>) -> Result<Texture, KeyError> {
        let planform = self.planform()?;
        // A property that the planform lacks is refused at the key that needs it.
        let refused = |key: &'static str, expected: &'static str| {
            move |error: PatternError| match error {
                PatternError::NoSuchProperty { .. } => {
                    KeyError::rule(key, format!("has no meaning for planform \"{planform}\""), expected)
                }
                _ => KeyError::from_error(key, &error),
            }
        };
        let mut texture = Texture::new(planform);
        let is_polygon = planform == Planform::Polygon;
        if self.vertices_um.is_some() && !is_polygon {
            let reason = format!("has no meaning for planform \"{planform}\"");
            return Err(KeyError::rule("vertices_um", reason, "planform = \"polygon\", or no such key"));
        }
        let written = self.vertices_um.as_ref().filter(|_| drawn.is_none()).map(|vertices| Polygon::new(vertices));
        let written = written.transpose().map_err(|error| KeyError::from_error("vertices_um", &error))?;
        if is_polygon {
            let missing = KeyError { key: "vertices_um", refusal: Refusal::Missing };
            let refused = |error| KeyError::from_error("vertices_um", &error);
            texture = texture.with_outline(drawn.or(written).ok_or(missing)?).map_err(refused)?;
        }
        if let Some(length_m) = si("length_um", self.length_um, LENGTH_UM)? {
            let expected = "planform = \"rectangle\", or no such key";
            texture = texture.with_length_m(length_m).map_err(refused("length_um", expected))?;
        } else if planform == Planform::Rectangle {
            return Err(KeyError { key: "length_um", refusal: Refusal::Missing });
        }
        if let Some(spacing_m) = si("spacing_across_um", self.spacing_across_um, LENGTH_UM)? {
            texture = texture.with_spacing_across_m(spacing_m).map_err(refused("spacing_across_um", WITH_ROWS))?;
        }
        if let Some(name) = &self.arrangement {
            let arrangement = KeyError::choice("arrangement", name, &Arrangement::ALL, Arrangement::name)?;
            texture = texture.with_arrangement(arrangement).map_err(refused("arrangement", WITH_ROWS))?;
        }
        if let Some(angle_deg) = si("angle_deg", self.angle_deg, GROOVE_ANGLE_DEG)? {
            let expected = "planform = \"groove\" or \"crosshatch\", or sliding_angle_deg instead";
            texture = texture.with_groove_angle_deg(angle_deg).map_err(refused("angle_deg", expected))?;
        }
        if let Some(angle_deg) = si("crossing_angle_deg", self.crossing_angle_deg, CROSSING_ANGLE_DEG)? {
            let expected = "planform = \"crosshatch\", or no such key";
            texture = texture.with_crossing_angle_deg(angle_deg).map_err(refused("crossing_angle_deg", expected))?;
        }
        if let Some(angle_deg) = si("sliding_angle_deg", self.sliding_angle_deg, SLIDING_ANGLE_DEG)? {
            texture = texture
                .with_sliding_angle_deg(angle_deg)
                .map_err(|error: PatternError| KeyError::from_error("sliding_angle_deg", &error))?;
        }
        // A rim without height is left out.
        Ok(texture.with_rim(self.rim()?.filter(Rim::stands)))
    }

    /// Planform of the cavities.
    ///
    /// # Errors
    /// [`KeyError`] if its name is unknown.
    pub fn planform(&self) -> Result<Planform, KeyError> {
        let name = self.planform.as_deref().unwrap_or(Planform::Groove.name());
        KeyError::choice("planform", name, &Planform::ALL, Planform::name)
    }

    /// Rims, including rims of zero height; `None` if no key of rims is present.
    ///
    /// # Errors
    /// [`KeyError`] if a height has no width, if a width, profile or scatter has no height, if both `rim_height_um` and
    /// `rim_heights_um` are given, if `[depth, height]` pairs are malformed or their depths do not ascend, if the
    /// profile is unknown, or if numbers are out of range.
    pub fn rim(&self) -> Result<Option<Rim>, KeyError> {
        let (key, heights_m) = match (self.rim_height_um, &self.rim_heights_um) {
            (None, None) => {
                let alone = [
                    ("rim_width_um", self.rim_width_um.is_some()),
                    ("rim_profile", self.rim_profile.is_some()),
                    ("rim_height_std_um", self.rim_height_std_um.is_some()),
                ];
                return match alone.into_iter().find(|(_, is_given)| *is_given) {
                    Some((key, _)) => Err(KeyError::rule(key, "stands without a height of the rims", HEIGHTS)),
                    None => Ok(None),
                };
            }
            (Some(_), Some(_)) => {
                let expected = "either rim_height_um or rim_heights_um";
                return Err(KeyError::rule("rim_heights_um", "stands beside rim_height_um", expected));
            }
            (Some(height_um), None) => {
                ("rim_height_um", vec![[0.0, KeyError::number("rim_height_um", height_um, RIM_HEIGHT_UM)?]])
            }
            (None, Some(pairs)) => ("rim_heights_um", heights_m(pairs)?),
        };
        let Some(width_m) = si("rim_width_um", self.rim_width_um, LENGTH_UM)? else {
            let expected = "rim_width_um, the distance from the edge at which a rim ends, beside it";
            return Err(KeyError::rule(key, "stands without a width of the rims", expected));
        };
        let profile = self.rim_profile.as_ref();
        let profile = profile
            .map(|name| KeyError::choice("rim_profile", name, &RimProfile::IN_FILES, RimProfile::name))
            .transpose()?;
        let std_m = si("rim_height_std_um", self.rim_height_std_um, RIM_HEIGHT_UM)?.unwrap_or(0.0);
        Rim::following_depth(&heights_m, width_m, profile.unwrap_or_default())
            .and_then(|rim| rim.with_height_std_m(std_m))
            .map(Some)
            .map_err(|error| KeyError::from_error(key, &error))
    }
}

impl From<&Pattern> for TextureRecord {
    fn from(pattern: &Pattern) -> Self {
        Self::new(pattern.texture(), pattern.width_m())
    }
}

/// Converts the number of the optional key `key` to SI units; `None` if the key is absent.
fn si(key: &'static str, value: Option<f64>, quantity: Quantity) -> Result<Option<f64>, KeyError> {
    value.map(|value| KeyError::number(key, value, quantity)).transpose()
}

/// Checks pairs of depth and height in um, and converts them to metres.
fn heights_m(pairs: &[Vec<f64>]) -> Result<Vec<[f64; 2]>, KeyError> {
    const KEY: &str = "rim_heights_um";
    let refuse = |reason: String, expected: &str| Err(KeyError::rule(KEY, reason, expected));
    if pairs.is_empty() || pairs.len() > Rim::MAX_HEIGHTS {
        let expected = format!("1 to {} pairs [depth, height], in um", Rim::MAX_HEIGHTS);
        return refuse(format!("has {} pairs", pairs.len()), &expected);
    }
    let mut read: Vec<[f64; 2]> = Vec::new();
    for pair in pairs {
        let [depth_um, height_um] = pair[..] else {
            return refuse(format!("has a pair of {} numbers", pair.len()), "a depth and a height, in um");
        };
        let depth_m = KeyError::number(KEY, depth_um, LENGTH_UM.or_zero())?;
        if read.last().is_some_and(|[before_m, _]| *before_m >= depth_m) {
            let reason = format!("has a depth of {depth_um} um that is no greater than the one before it");
            return refuse(reason, "depths that ascend from pair to pair");
        }
        read.push([depth_m, KeyError::number(KEY, height_um, RIM_HEIGHT_UM)?]);
    }
    Ok(read)
}

/// Corners, in um, of `outline` scaled to the width `width_m`, with 15 digits, which identify the outline exactly.
fn vertices_um(outline: Polygon, width_m: f64) -> Vec<[f64; 2]> {
    let written = |share: f64| {
        let at_um = share * LENGTH_UM.from_si(width_m);
        format!("{at_um:.14e}").parse().unwrap_or(at_um)
    };
    outline.vertices().iter().map(|vertex| vertex.map(written)).collect()
}
