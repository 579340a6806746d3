//! The dimension of a model, plane or space, and its consequences for callers.

use crate::pattern::{Pattern, Texture};

/// Dimension in which scenes and cells are solved. The methods name the consequences of the dimension, so that other
/// crates need not compare dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// In the vertical plane along the sliding direction.
    Plane,
    /// In space.
    Space,
}

impl Dimension {
    /// Returns the dimension for patterns of `texture`: `asked` if it is given, otherwise the plane if all sections of
    /// the texture are equal, and space if not.
    pub fn of(asked: Option<u8>, texture: &Texture) -> Self {
        asked.map_or_else(|| Self::required_for([texture]), Self::numbered)
    }

    /// Returns the lowest dimension that represents all of `textures`.
    pub fn required_for<'t>(textures: impl IntoIterator<Item = &'t Texture>) -> Self {
        if textures.into_iter().all(Texture::is_one_section) { Self::Plane } else { Self::Space }
    }

    /// Converts from a number of dimensions: 3 is space, every other number the plane.
    pub const fn numbered(number: u8) -> Self {
        if number == 3 { Self::Space } else { Self::Plane }
    }

    /// Number of spatial dimensions: 2 or 3.
    pub const fn number(self) -> u8 {
        match self {
            Self::Plane => 2,
            Self::Space => 3,
        }
    }

    /// Whether thousands of steady cells can be solved: a plane cell takes milliseconds, a cell in space a hundred
    /// times as long.
    pub const fn is_cheap_per_design(self) -> bool {
        matches!(self, Self::Plane)
    }

    /// Whether a specimen is solved strip by strip, like the flat sample of a calibration. In space a whole specimen
    /// has hundreds of cells and a billion blocks, so one cell represents it.
    pub const fn takes_strips(self) -> bool {
        matches!(self, Self::Plane)
    }

    /// Whether the model includes the whole interface, with the land between rows of cavities. The interface of the
    /// plane model is one line along the sliding direction.
    pub const fn sees_face(self) -> bool {
        matches!(self, Self::Space)
    }

    /// Returns `pattern` if this dimension is the plane, and the pattern's sections along the sliding direction differ,
    /// so that only one section is represented; `None` otherwise.
    pub fn section_of(self, pattern: &Pattern) -> Option<&Pattern> {
        Some(pattern).filter(|pattern| !self.sees_face() && !pattern.texture().is_one_section())
    }
}
