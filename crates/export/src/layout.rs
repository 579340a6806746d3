use slipgrid_pattern::{Pattern, Planform};

use crate::{ExportError, Outline};

/// Largest number of cavities accepted: a DXF file of them takes about 2.5 GB.
pub const MOST_CAVITIES: usize = 10_000_000;

/// Part of a pitch by which a cavity may pass the outline and still count as inside: what rounding
/// leaves where dimensions are whole, and far below what a laser can place.
const FIT_TOLERANCE: f64 = 1e-9;

/// One cavity seen from above: a rectangle with sides along x, the sliding direction, and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cavity {
    /// Position of its centre along the sliding direction, from the specimen's centre, in metres.
    pub centre_x_m: f64,
    /// Position of its centre across the sliding direction, in metres.
    pub centre_y_m: f64,
    /// Extent along the sliding direction, in metres.
    pub width_m: f64,
    /// Extent across the sliding direction, in metres; of a square its width.
    pub length_m: f64,
}

impl Cavity {
    /// Its corners as `[x, y]`, anticlockwise from the least x and y, in metres.
    #[must_use]
    pub fn corners_m(&self) -> [[f64; 2]; 4] {
        let (left, right) = (self.centre_x_m - self.width_m / 2.0, self.centre_x_m + self.width_m / 2.0);
        let (low, high) = (self.centre_y_m - self.length_m / 2.0, self.centre_y_m + self.length_m / 2.0);
        [[left, low], [right, low], [right, high], [left, high]]
    }

    /// Area, in square metres.
    #[must_use]
    pub fn area_m2(&self) -> f64 {
        self.width_m * self.length_m
    }
}

/// The cavities of a pattern on a specimen.
///
/// One cavity sits on the specimen's centre and the others a whole number of pitches from it:
/// squares at (i pitch, j pitch), grooves at x = i pitch. Only whole cavities are laid: a square
/// with a corner outside the outline is left out, a groove is as long as a rectangle can be
/// between the two sides of the outline, and one shorter than it is wide is left out. Squares come
/// row by row from the least y, each row from the least x; grooves from the least x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pattern: Pattern,
    outline: Outline,
    /// Rows go from -`row_reach` to `row_reach`.
    row_reach: i64,
    cavities: usize,
    cavity_area_m2: f64,
}

impl Layout {
    /// Lays `pattern` on `outline`. Time goes with the number of rows of squares, or of grooves.
    ///
    /// # Errors
    /// [`ExportError::NotPositive`] if the outline has no extent, [`ExportError::NoCavityFits`] if
    /// it is smaller than a cavity, [`ExportError::TooManyCavities`] beyond [`MOST_CAVITIES`].
    pub fn new(pattern: Pattern, outline: Outline) -> Result<Self, ExportError> {
        outline.validate()?;
        let [extent_x_m, extent_y_m] = outline.extents_m();
        let per_row = extent_x_m / pattern.pitch_m() + 1.0;
        let estimate = match pattern.planform() {
            Planform::Groove => per_row,
            Planform::Square => per_row * (extent_y_m / pattern.pitch_m() + 1.0),
        };
        if estimate > MOST_CAVITIES as f64 {
            return Err(ExportError::TooManyCavities { cavities: estimate, most: MOST_CAVITIES });
        }

        let half_m = pattern.width_m() / 2.0;
        let no_cavity_fits = || ExportError::NoCavityFits {
            width_m: pattern.width_m(),
            extent_m: extent_x_m.min(extent_y_m),
            needed_m: match outline {
                // A square's corners on the circle.
                Outline::Disc { .. } => pattern.width_m() * std::f64::consts::SQRT_2,
                Outline::Rectangle { .. } => pattern.width_m(),
            },
        };
        let row_reach = match pattern.planform() {
            Planform::Groove => 0,
            // Half a chord along y at the edge of a cavity on the axis.
            Planform::Square => outline
                .half_chord_m(false, half_m)
                .and_then(|chord_m| reach(chord_m - half_m, pattern.pitch_m()))
                .ok_or_else(no_cavity_fits)?,
        };
        let mut layout = Self { pattern, outline, row_reach, cavities: 0, cavity_area_m2: 0.0 };
        if layout.column_reach(0).is_none() {
            return Err(no_cavity_fits());
        }
        for row in -row_reach..=row_reach {
            let Some(columns) = layout.column_reach(row) else { continue };
            // At most MOST_CAVITIES: the cast is exact.
            layout.cavities += (2 * columns + 1) as usize;
        }
        layout.cavity_area_m2 = match pattern.planform() {
            Planform::Square => layout.cavities as f64 * pattern.width_m() * pattern.width_m(),
            Planform::Groove => layout.iter().map(|groove| groove.area_m2()).sum(),
        };
        Ok(layout)
    }

    /// The pattern.
    #[must_use]
    pub const fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The specimen's outline.
    #[must_use]
    pub const fn outline(&self) -> &Outline {
        &self.outline
    }

    /// Number of cavities, at least one.
    #[must_use]
    pub const fn cavities(&self) -> usize {
        self.cavities
    }

    /// Sum of the cavities' areas seen from above, in square metres.
    #[must_use]
    pub const fn cavity_area_m2(&self) -> f64 {
        self.cavity_area_m2
    }

    /// Sum of the cavities' volumes, area times depth, in cubic metres.
    #[must_use]
    pub fn cavity_volume_m3(&self) -> f64 {
        self.cavity_area_m2 * self.pattern.depth_m()
    }

    /// Share of the specimen's face that is cavity: near the pattern's own areal density, below
    /// it where whole cavities leave a rim untextured.
    #[must_use]
    pub fn areal_density(&self) -> f64 {
        self.cavity_area_m2 / self.outline.area_m2()
    }

    /// The cavities in the order stated above, made one by one.
    pub fn iter(&self) -> impl Iterator<Item = Cavity> + '_ {
        (-self.row_reach..=self.row_reach).flat_map(move |row| {
            self.column_reach(row)
                .into_iter()
                .flat_map(|columns| -columns..=columns)
                .map(move |column| self.cavity(column, row))
        })
    }

    /// Columns of a row go from minus this to this; `None` where no cavity of the row fits.
    fn column_reach(&self, row: i64) -> Option<i64> {
        let half_m = self.pattern.width_m() / 2.0;
        // The row's outer edge decides. A groove at least as long as wide fits where the square
        // of row 0 does.
        let edge_m = (row.abs() as f64) * self.pattern.pitch_m() + half_m;
        let inside_m = edge_m - FIT_TOLERANCE * self.pattern.pitch_m();
        reach(self.outline.half_chord_m(true, inside_m)? - half_m, self.pattern.pitch_m())
    }

    fn cavity(&self, column: i64, row: i64) -> Cavity {
        let width_m = self.pattern.width_m();
        let centre_x_m = column as f64 * self.pattern.pitch_m();
        let length_m = match self.pattern.planform() {
            Planform::Square => width_m,
            Planform::Groove => {
                // L = 2 c(|x| + w/2), c half the chord across the sliding direction
                let edge_m = centre_x_m.abs() + width_m / 2.0;
                let inside_m = edge_m - FIT_TOLERANCE * self.pattern.pitch_m();
                2.0 * self.outline.half_chord_m(false, inside_m).unwrap_or(0.0)
            }
        };
        Cavity { centre_x_m, centre_y_m: row as f64 * self.pattern.pitch_m(), width_m, length_m }
    }
}

/// The largest whole number of pitches within `limit_m`, a distance from the centre.
fn reach(limit_m: f64, pitch_m: f64) -> Option<i64> {
    let pitches = limit_m / pitch_m + FIT_TOLERANCE;
    // Bounded by MOST_CAVITIES: the cast is exact.
    (pitches >= 0.0).then(|| pitches.floor() as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn squares(width_um: f64, spacing_um: f64) -> Pattern {
        Pattern::new(Planform::Square, width_um * 1e-6, spacing_um * 1e-6, 5.2e-6).unwrap()
    }

    const DISC: Outline = Outline::Disc { diameter_m: 10e-3 };

    #[test]
    fn squares_on_the_published_disc_are_those_whose_corners_lie_inside() {
        let layout = Layout::new(squares(130.0, 370.0), DISC).unwrap();
        // The obvious way: every lattice point, in whole micrometres, corners inside the circle.
        let inside = |i: i64, j: i64| {
            let (x, y) = (500 * i.abs() + 65, 500 * j.abs() + 65);
            x * x + y * y <= 5000 * 5000
        };
        let expected: Vec<(i64, i64)> =
            (-20..=20).flat_map(|j| (-20..=20).map(move |i| (i, j))).filter(|&(i, j)| inside(i, j)).collect();
        let laid: Vec<(i64, i64)> = layout
            .iter()
            .map(|c| ((c.centre_x_m / 500e-6).round() as i64, (c.centre_y_m / 500e-6).round() as i64))
            .collect();
        assert_eq!(laid, expected);
        assert_eq!(layout.cavities(), expected.len());
        assert_eq!(layout.cavity_area_m2(), expected.len() as f64 * 130e-6 * 130e-6);
        let density = expected.len() as f64 * 0.13 * 0.13 / (std::f64::consts::PI * 25.0);
        assert!((layout.areal_density() - density).abs() < 1e-12);
        assert!((layout.cavity_volume_m3() - layout.cavity_area_m2() * 5.2e-6).abs() < 1e-22);
    }

    #[test]
    fn grooves_on_a_disc_end_on_the_circle() {
        let pattern = squares(130.0, 370.0).as_groove();
        let layout = Layout::new(pattern, DISC).unwrap();
        assert_eq!(layout.iter().count(), layout.cavities());
        assert_eq!(layout.cavities(), 19);
        for groove in layout.iter() {
            let farthest = groove.corners_m().iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
            assert!((farthest - 5e-3).abs() < 1e-12, "{groove:?}");
            assert!(groove.length_m >= groove.width_m);
        }
    }

    #[test]
    fn a_rectangle_takes_cavities_that_touch_its_edge() {
        // 2 (0.9) + 0.1 = 1.9 mm: the outermost cavities end on the outline.
        let outline = Outline::Rectangle { length_m: 1.9e-3, width_m: 0.7e-3 };
        let layout = Layout::new(squares(100.0, 200.0), outline).unwrap();
        assert_eq!(layout.cavities(), 7 * 3);
        let grooves = Layout::new(squares(100.0, 200.0).as_groove(), outline).unwrap();
        assert_eq!(grooves.cavities(), 7);
        assert!(grooves.iter().all(|groove| (groove.length_m - 0.7e-3).abs() < 1e-15));
        assert!((grooves.areal_density() - 7.0 * 0.1 / 1.9).abs() < 1e-12);
    }

    #[test]
    fn the_density_on_large_specimens_tends_to_the_patterns_own() {
        for pattern in [squares(130.0, 370.0), squares(130.0, 370.0).as_groove()] {
            let error = |diameter_m| {
                let layout = Layout::new(pattern, Outline::Disc { diameter_m }).unwrap();
                (layout.areal_density() / pattern.areal_density() - 1.0).abs()
            };
            // Rim over area: the error falls at least as 1/diameter.
            assert!(error(0.4) < 3e-3, "{}", error(0.4));
            assert!(error(0.04) < 3e-2, "{}", error(0.04));
        }
    }

    #[test]
    fn every_corner_of_a_hundred_thousand_cavities_lies_inside() {
        let layout = Layout::new(squares(20.0, 8.0), DISC).unwrap();
        assert!(layout.cavities() > 90_000);
        assert_eq!(layout.iter().count(), layout.cavities());
        assert!(layout.iter().flat_map(|cavity| cavity.corners_m()).all(|[x, y]| x.hypot(y) <= 5e-3 + 1e-12));
    }

    #[test]
    fn specimens_that_hold_no_cavity_or_too_many_are_refused() {
        let pattern = squares(130.0, 370.0);
        for outline in [
            Outline::Disc { diameter_m: 0.18e-3 },
            Outline::Rectangle { length_m: 1e-3, width_m: 0.12e-3 },
            Outline::Rectangle { length_m: 0.12e-3, width_m: 1e-3 },
        ] {
            for pattern in [pattern, pattern.as_groove()] {
                let refused = Layout::new(pattern, outline);
                assert!(matches!(refused, Err(ExportError::NoCavityFits { .. })), "{outline:?}: {refused:?}");
            }
        }
        let one = Layout::new(pattern, Outline::Disc { diameter_m: 0.184e-3 }).unwrap();
        assert_eq!(one.cavities(), 1);
        let refused = Layout::new(pattern, Outline::Disc { diameter_m: 10.0 }).unwrap_err();
        assert!(matches!(refused, ExportError::TooManyCavities { .. }));
        let refused = Layout::new(pattern, Outline::Disc { diameter_m: f64::NAN }).unwrap_err();
        assert!(refused.to_string().contains("diameter_m"));
    }
}
