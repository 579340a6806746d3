use std::fmt;
use std::str::FromStr;

use crate::pattern::PatternError;

/// Shape of a cavity seen from above. Its sides lie along the pattern's axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Planform {
    /// A groove along the pattern's y axis, as long as the surface. Across the sliding direction, it corresponds to the
    /// two-dimensional model.
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

impl Planform {
    /// All planforms, in the order in which help texts list them.
    pub const ALL: [Self; 6] =
        [Self::Groove, Self::Square, Self::Rectangle, Self::Disc, Self::Polygon, Self::Crosshatch];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Groove => "groove",
            Self::Square => "square",
            Self::Rectangle => "rectangle",
            Self::Disc => "disc",
            Self::Polygon => "polygon",
            Self::Crosshatch => "crosshatch",
        }
    }

    /// Whether cavities are grooves, which have no ends.
    #[must_use]
    pub const fn is_grooves(self) -> bool {
        matches!(self, Self::Groove | Self::Crosshatch)
    }
}

impl fmt::Display for Planform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Planform {
    type Err = PatternError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|planform| planform.name() == name)
            .ok_or_else(|| PatternError::UnknownPlanform { name: name.to_owned() })
    }
}

/// Arrangement of the rows of cavities. Rows run along the pattern's x axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Arrangement {
    /// All rows are equal.
    #[default]
    Square,
    /// Every second row is shifted along x by half a pitch.
    Staggered,
    /// Staggered rows sqrt(3)/2 of a pitch apart, so that each cavity has six neighbours at the distance of one pitch.
    Hexagonal,
}

impl Arrangement {
    /// All arrangements, in the order in which help texts list them.
    pub const ALL: [Self; 3] = [Self::Square, Self::Staggered, Self::Hexagonal];

    /// The name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Square => "square",
            Self::Staggered => "staggered",
            Self::Hexagonal => "hexagonal",
        }
    }

    /// Whether every second row is shifted along x by half a pitch.
    #[must_use]
    pub const fn shifts_rows(self) -> bool {
        matches!(self, Self::Staggered | Self::Hexagonal)
    }
}

impl fmt::Display for Arrangement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Arrangement {
    type Err = PatternError;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        Self::ALL
            .into_iter()
            .find(|arrangement| arrangement.name() == name)
            .ok_or_else(|| PatternError::UnknownArrangement { name: name.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_read_back() {
        for planform in Planform::ALL {
            assert_eq!(planform.name().parse::<Planform>().unwrap(), planform);
        }
        for arrangement in Arrangement::ALL {
            assert_eq!(arrangement.name().parse::<Arrangement>().unwrap(), arrangement);
        }
    }

    #[test]
    fn refused_names_are_told_with_all_that_are_accepted() {
        let refused = "hexagon".parse::<Planform>().unwrap_err().to_string();
        assert!(refused.contains("hexagon") && Planform::ALL.iter().all(|planform| refused.contains(planform.name())));
        let refused = "triangular".parse::<Arrangement>().unwrap_err().to_string();
        assert!(refused.contains("triangular") && Arrangement::ALL.iter().all(|a| refused.contains(a.name())));
    }
}
