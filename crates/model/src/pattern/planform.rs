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

slipgrid_base::names!(Planform {
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

    /// Curve around a single cavity; the outline of a polygon, where it is set, takes its place.
    pub const fn contour(self) -> Contour {
        match self {
            Self::Groove | Self::Square | Self::Rectangle | Self::Polygon | Self::Crosshatch => Contour::Rectangle,
            Self::Disc => Contour::Circle,
        }
    }
}

/// Curve around a single cavity, inscribed in its width and length. Geometry matches it in full, so that a new curve
/// does not compile until every question about it has an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contour {
    /// Sides along the axes of the cavity.
    Rectangle,
    /// A circle.
    Circle,
}

impl Contour {
    /// Fraction of width times length inside the curve.
    pub const fn fill(self) -> f64 {
        match self {
            Self::Rectangle => 1.0,
            Self::Circle => std::f64::consts::FRAC_PI_4,
        }
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

slipgrid_base::names!(Arrangement { Square = "square", Staggered = "staggered", Hexagonal = "hexagonal" });

impl Arrangement {
    /// Whether every second row is shifted along x by half a pitch.
    pub const fn shifts_rows(self) -> bool {
        matches!(self, Self::Staggered | Self::Hexagonal)
    }
}
