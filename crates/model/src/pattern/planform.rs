/// Shape of a cavity seen from above. Its sides lie along the pattern's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Planform {
    /// A groove along the pattern's y axis, as long as the surface. Grooves across the sliding direction correspond to
    /// the two-dimensional model.
    Groove,
    /// A square.
    Square,
    /// A rectangle, `width` along x and `length` along y.
    Rectangle,
    /// A disc; the width is the diameter.
    Disc,
    /// A [`Polygon`](crate::pattern::Polygon); the width is the extent along x.
    Polygon,
    /// Two families of equal grooves that cross, each `width` wide and `spacing` apart. Crossings are as deep as the
    /// grooves.
    Crosshatch,
}

names!(Planform {
    Groove = "groove",
    Square = "square",
    Rectangle = "rectangle",
    Disc = "disc",
    Polygon = "polygon",
    Crosshatch = "crosshatch",
});

impl Planform {
    /// Whether cavities are grooves, crossing or not; grooves have no ends.
    pub const fn is_grooves(self) -> bool {
        matches!(self, Self::Groove | Self::Crosshatch)
    }
}

/// Arrangement of the rows of cavities. Rows run along the pattern's x axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// Rows are not shifted along x.
    #[default]
    Square,
    /// Every second row is shifted along x by half a pitch.
    Staggered,
    /// Staggered rows sqrt(3)/2 of a pitch apart, so that each cavity has six neighbours at the distance of one pitch.
    Hexagonal,
}

names!(Arrangement { Square = "square", Staggered = "staggered", Hexagonal = "hexagonal" });

impl Arrangement {
    /// Whether every second row is shifted along x by half a pitch.
    pub const fn shifts_rows(self) -> bool {
        matches!(self, Self::Staggered | Self::Hexagonal)
    }
}
