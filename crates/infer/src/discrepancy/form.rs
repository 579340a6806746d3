//! Forms: growth of the discrepancy with the removed area, edge length and depth.

use crate::discrepancy::Features;

/// Form of the discrepancy: its growth with the texture, 0 without cavities.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// 0: the texture has no effect beyond the model, and samples only scatter.
    None,
    /// Proportional to the areal density a, for effects over the cavities.
    Density,
    /// Proportional to the edge length per area e, for effects at edges, as of rims and menisci.
    Edge,
    /// 1 - exp(-a / scale), with the areal density a: saturates at low density, as in the capture of wear debris.
    Saturating {
        /// Areal density at which the form reaches 63 % of its limit.
        scale: f64,
    },
    /// a (1 - exp(-depth / scale)), with the areal density a: a smaller effect of shallow cavities.
    DepthDensity {
        /// Depth, in metres, at which the form reaches 63 % of its limit.
        scale_m: f64,
    },
    /// e (1 - exp(-depth / scale)), with the edge length per area e: a smaller effect of edges of shallow cavities.
    DepthEdge {
        /// Depth, in metres, at which the form reaches 63 % of its limit.
        scale_m: f64,
    },
}

impl Form {
    /// Returns the forms with their prior weights, which sum to 1. The weight of [`Form::None`] is so small that the
    /// scatter of samples stays as stated after one trial. The other families have equal weight, except
    /// [`Form::DepthEdge`], which has about half of it.
    pub fn usual() -> Vec<(Self, f64)> {
        let family = |share: f64, members: Vec<Self>| {
            let each = share / members.len() as f64;
            members.into_iter().map(move |form| (form, each)).collect::<Vec<_>>()
        };
        [
            family(0.209, vec![Self::Density]),
            family(0.209, vec![Self::Edge]),
            family(0.209, [0.02, 0.04, 0.08, 0.16].map(|scale| Self::Saturating { scale }).to_vec()),
            family(0.209, [2e-6, 5e-6, 10e-6, 20e-6].map(|scale_m| Self::DepthDensity { scale_m }).to_vec()),
            family(0.114, [3e-6, 10e-6].map(|scale_m| Self::DepthEdge { scale_m }).to_vec()),
            family(0.05, vec![Self::None]),
        ]
        .concat()
    }

    /// Evaluates the form for a texture; the unit depends on the form (1, or 1/m for edges).
    pub fn value(&self, of: &Features) -> f64 {
        // 1 - exp(-x / x0)
        let reached = |x: f64, scale: f64| -libm::expm1(-x / scale);
        match self {
            Self::None => 0.0,
            Self::Density => of.areal_density,
            Self::Edge => of.edge_1_m,
            Self::Saturating { scale } => reached(of.areal_density, *scale),
            Self::DepthDensity { scale_m } => of.areal_density * reached(of.depth_m, *scale_m),
            Self::DepthEdge { scale_m } => of.edge_1_m * reached(of.depth_m, *scale_m),
        }
    }

    /// Evaluates the form for a texture on its face: cavities lower the friction of a specimen in proportion to the
    /// share of the face that they take, as in the modelled ratio.
    pub fn on_face(&self, of: &Features) -> f64 {
        of.face_share * self.value(of)
    }

    /// Family of the form: the feature that it grows with.
    pub const fn family(&self) -> &'static str {
        match self {
            Self::None => "no effect of the texture",
            Self::Density => "areal density",
            Self::Edge => "edge length",
            Self::Saturating { .. } => "saturating areal density",
            Self::DepthDensity { .. } => "areal density and depth",
            Self::DepthEdge { .. } => "edge length and depth",
        }
    }

    /// Describes the form by its family and scale.
    pub fn name(&self) -> String {
        let um = |length_m: f64| (length_m * 1e9).round() / 1e3;
        match self {
            Self::None | Self::Density | Self::Edge => self.family().to_owned(),
            Self::Saturating { scale } => format!("areal density, saturating at {scale}"),
            Self::DepthDensity { scale_m } => format!("areal density of cavities deeper than {} um", um(*scale_m)),
            Self::DepthEdge { scale_m } => format!("edges of cavities deeper than {} um", um(*scale_m)),
        }
    }
}
