//! In the plane or in space: what that means to callers.

use slipgrid_pattern::{Pattern, Texture};

/// Where scenes and cells are solved. It is decided here; what follows from it has names, so that no other crate compares dimensions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dimension {
    /// In the vertical plane along the sliding direction.
    Plane,
    /// In space.
    Space,
}

impl Dimension {
    /// Where patterns of `texture` are solved: where it is `asked` for, otherwise in the plane if every section is the same.
    #[must_use]
    pub fn of(asked: Option<u8>, texture: &Texture) -> Self {
        asked.map_or_else(|| Self::serving([texture]), Self::numbered)
    }

    /// The one that serves patterns of all `textures`: space where one of them needs it.
    #[must_use]
    pub fn serving<'t>(textures: impl IntoIterator<Item = &'t Texture>) -> Self {
        if textures.into_iter().all(Texture::is_one_section) { Self::Plane } else { Self::Space }
    }

    /// The one that is written as `number`, 2 or 3.
    #[must_use]
    pub const fn numbered(number: u8) -> Self {
        if number == 3 { Self::Space } else { Self::Plane }
    }

    /// The number that is written for it.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Plane => 2,
            Self::Space => 3,
        }
    }

    /// Whether thousands of steady cells can be solved: one takes milliseconds, in space a hundred times as much.
    #[must_use]
    pub const fn is_cheap_per_design(self) -> bool {
        matches!(self, Self::Plane)
    }

    /// Whether a specimen is solved strip by strip, as the flat sample of a calibration is: in space, where a whole one is hundreds of
    /// cells and a billion blocks, one cell stands for it.
    #[must_use]
    pub const fn takes_strips(self) -> bool {
        matches!(self, Self::Plane)
    }

    /// Whether the whole interface is seen, with what lies between rows of cavities: the plane sees one line along the sliding direction.
    #[must_use]
    pub const fn sees_face(self) -> bool {
        matches!(self, Self::Space)
    }

    /// `pattern` where only a section of it is solved, and the planform is more than that.
    #[must_use]
    pub fn section_of(self, pattern: &Pattern) -> Option<&Pattern> {
        Some(pattern).filter(|pattern| !self.sees_face() && !pattern.texture().is_one_section())
    }
}
