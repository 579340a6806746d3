use std::ops::RangeInclusive;

use slipgrid_pattern::{Arrangement, Pattern, Planform};

use crate::{Cavity, ExportError, Outline};

/// Largest number of cavities accepted: a DXF file of them takes about 2.5 GB.
pub const MOST_CAVITIES: usize = 10_000_000;

/// Part of a pitch by which a cavity may pass the outline and still count as inside: what rounding
/// leaves where dimensions are whole, and far below what a laser can place.
const FIT_TOLERANCE: f64 = 1e-9;

/// The cavities of a pattern on a specimen.
///
/// One cavity sits on the specimen's centre and the others on the pattern's lattice about it: row j at
/// y = j pitch across with cavities at x = i pitch, odd rows of a staggered arrangement at
/// x = (i + 1/2) pitch, grooves at i pitch along their own x axis. Only whole cavities are laid: one
/// that passes the outline is left out, a groove is the longest rectangle of its width between the
/// two sides of the outline, and one shorter than it is wide is left out. Cavities come row by row
/// from the least y, each row from the least x; grooves from the least of their own x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pattern: Pattern,
    outline: Outline,
    /// Rows, or grooves, go from minus this to this.
    reach: i64,
    cavities: usize,
    cavity_area_m2: f64,
}

impl Layout {
    /// Lays `pattern` on `outline`. Time goes with the number of rows, or of grooves.
    ///
    /// # Errors
    /// [`ExportError::NotPositive`] if the outline has no extent, [`ExportError::NoCavityFits`] if
    /// it is smaller than a cavity, [`ExportError::TooManyCavities`] beyond [`MOST_CAVITIES`].
    pub fn new(pattern: Pattern, outline: Outline) -> Result<Self, ExportError> {
        outline.validate()?;
        let orientation = pattern.texture().orientation();
        let per_row = outline.extent_along_m(orientation) / pattern.pitch_m() + 1.0;
        let [_, extent_y_m] = outline.extents_m();
        let rows = pattern.pitch_across_m().map_or(1.0, |pitch_m| extent_y_m / pitch_m + 1.0);
        if per_row * rows > MOST_CAVITIES as f64 {
            return Err(ExportError::TooManyCavities { cavities: per_row * rows, most: MOST_CAVITIES });
        }
        let mut layout = Self { pattern, outline, reach: 0, cavities: 0, cavity_area_m2: 0.0 };
        let reach = match pattern.pitch_across_m() {
            None => (0..).take_while(|&column| layout.groove(column).is_some()).last(),
            Some(pitch_m) => layout.half_span_m(false, 0.0, 0.0).and_then(|half_m| reach(half_m, pitch_m)),
        };
        layout.reach = reach.ok_or_else(|| no_cavity_fits(&pattern, &outline))?;
        match pattern.length_m() {
            None => {
                // At most MOST_CAVITIES: this cast and the next are exact.
                layout.cavities = (2 * layout.reach + 1) as usize;
                layout.cavity_area_m2 = layout.iter().map(|groove| groove.area_m2()).sum();
            }
            Some(length_m) => {
                let rows = (-layout.reach..=layout.reach).filter_map(|row| layout.columns(row));
                layout.cavities = rows.map(|columns| (columns.end() - columns.start() + 1) as usize).sum();
                let square_m2 = layout.cavities as f64 * pattern.width_m() * length_m;
                let disc = pattern.planform() == Planform::Disc;
                layout.cavity_area_m2 = if disc { std::f64::consts::FRAC_PI_4 * square_m2 } else { square_m2 };
            }
        }
        if layout.cavities == 0 {
            return Err(no_cavity_fits(&pattern, &outline));
        }
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
        let rows = self.pattern.length_m().map_or(0, |_| self.reach);
        (-rows..=rows).flat_map(move |row| {
            let columns = match self.pattern.length_m() {
                None => Some(-self.reach..=self.reach),
                Some(_) => self.columns(row),
            };
            columns.into_iter().flatten().filter_map(move |column| match self.pattern.length_m() {
                None => self.groove(column),
                Some(length_m) => Some(self.cavity(column, row, length_m)),
            })
        })
    }

    /// Half the range, about the specimen's centre, of the centres of cavities `offset_m` aside of it,
    /// `along_x` saying which way the range goes; `None` where no cavity fits. Cavities may pass the
    /// outline aside by `slack_m`.
    fn half_span_m(&self, along_x: bool, offset_m: f64, slack_m: f64) -> Option<f64> {
        let (width_m, length_m) = (self.pattern.width_m(), self.pattern.length_m()?);
        match (self.pattern.planform(), self.outline) {
            // A disc lies within a disc where its centre lies within one smaller by its diameter.
            (Planform::Disc, Outline::Disc { diameter_m }) => {
                let centres = Outline::Disc { diameter_m: diameter_m - width_m };
                if diameter_m < width_m { None } else { centres.half_chord_m(along_x, (offset_m - slack_m).max(0.0)) }
            }
            _ => {
                let (along_m, aside_m) = if along_x { (width_m, length_m) } else { (length_m, width_m) };
                // The outer edge decides.
                let edge_m = offset_m + aside_m / 2.0;
                Some(self.outline.half_chord_m(along_x, edge_m - slack_m)? - along_m / 2.0)
            }
        }
    }

    /// Whether a row is shifted along x by half a pitch.
    fn is_shifted(&self, row: i64) -> bool {
        self.pattern.texture().arrangement() == Arrangement::Staggered && row.rem_euclid(2) == 1
    }

    /// Columns of a row; `None` where no cavity of the row fits.
    fn columns(&self, row: i64) -> Option<RangeInclusive<i64>> {
        let pitch_m = self.pattern.pitch_m();
        let offset_m = (row.abs() as f64) * self.pattern.pitch_across_m()?;
        let half_m = self.half_span_m(true, offset_m, FIT_TOLERANCE * pitch_m)?;
        if self.is_shifted(row) {
            reach(half_m - pitch_m / 2.0, pitch_m).map(|columns| -columns - 1..=columns)
        } else {
            reach(half_m, pitch_m).map(|columns| -columns..=columns)
        }
    }

    fn cavity(&self, column: i64, row: i64, length_m: f64) -> Cavity {
        let shift = if self.is_shifted(row) { 0.5 } else { 0.0 };
        Cavity {
            centre_x_m: (column as f64 + shift) * self.pattern.pitch_m(),
            centre_y_m: row as f64 * self.pattern.pitch_across_m().unwrap_or(0.0),
            width_m: self.pattern.width_m(),
            length_m,
            orientation: self.pattern.texture().orientation(),
            planform: self.pattern.planform(),
        }
    }

    /// The groove at `column` pitches along its own x axis; `None` where it is shorter than wide.
    fn groove(&self, column: i64) -> Option<Cavity> {
        let (width_m, pitch_m) = (self.pattern.width_m(), self.pattern.pitch_m());
        let orientation = self.pattern.texture().orientation();
        let [cosine, sine] = orientation;
        let offset_m = column as f64 * pitch_m;
        // The outline is convex: a rectangle ends where the nearer of its two sides does.
        let side_m = |side: f64| offset_m + side * (width_m / 2.0) - side * (FIT_TOLERANCE * pitch_m);
        let one_m = self.outline.chord_m(orientation, side_m(-1.0))?;
        let other_m = self.outline.chord_m(orientation, side_m(1.0))?;
        let (low_m, high_m) = (one_m[0].max(other_m[0]), one_m[1].min(other_m[1]));
        let length_m = high_m - low_m;
        let middle_m = f64::midpoint(low_m, high_m);
        (length_m >= width_m - FIT_TOLERANCE * pitch_m).then_some(Cavity {
            centre_x_m: offset_m * cosine - middle_m * sine,
            centre_y_m: offset_m * sine + middle_m * cosine,
            width_m,
            length_m,
            orientation,
            planform: Planform::Groove,
        })
    }
}

/// Why the specimen takes none: the extent that falls short, or of a disc the diameter.
fn no_cavity_fits(pattern: &Pattern, outline: &Outline) -> ExportError {
    let (width_m, length_m) = (pattern.width_m(), pattern.length_m().unwrap_or(pattern.width_m()));
    let [extent_x_m, extent_y_m] = outline.extents_m();
    let turned = pattern.texture().orientation() != [1.0, 0.0];
    let (needed_m, extent_m) = match outline {
        // Discs touch the circle, corners of others lie on it; a square fits turned if its diagonal does.
        Outline::Disc { .. } if pattern.planform() == Planform::Disc => (width_m, extent_x_m),
        Outline::Disc { .. } => (width_m.hypot(length_m), extent_x_m),
        Outline::Rectangle { .. } if turned => (width_m.hypot(length_m), extent_x_m.min(extent_y_m)),
        Outline::Rectangle { .. } if width_m == length_m => (width_m, extent_x_m.min(extent_y_m)),
        Outline::Rectangle { .. } if extent_x_m < width_m => (width_m, extent_x_m),
        Outline::Rectangle { .. } => (length_m, extent_y_m),
    };
    ExportError::NoCavityFits { width_m, extent_m, needed_m }
}

/// The largest whole number of pitches within `limit_m`, a distance from the centre.
fn reach(limit_m: f64, pitch_m: f64) -> Option<i64> {
    let pitches = limit_m / pitch_m + FIT_TOLERANCE;
    // Bounded by MOST_CAVITIES: the cast is exact.
    (pitches >= 0.0).then(|| pitches.floor() as i64)
}

/// A texture of every kind, each with numbers of its own, for tests of what is written.
#[cfg(test)]
pub(crate) fn every_kind() -> Vec<slipgrid_pattern::Texture> {
    use slipgrid_pattern::Texture;
    let groove = Texture::new(Planform::Groove);
    let mut kinds =
        vec![groove, groove.with_groove_angle_deg(33.3).unwrap(), groove.with_groove_angle_deg(-90.0).unwrap()];
    for planform in [Planform::Square, Planform::Rectangle, Planform::Disc] {
        let texture = Texture::new(planform);
        let staggered = texture.with_arrangement(Arrangement::Staggered).unwrap();
        kinds.extend([
            texture,
            staggered.with_spacing_across_m(77.7e-6).unwrap().with_sliding_angle_deg(-45.0).unwrap(),
        ]);
    }
    kinds.push(Texture::new(Planform::Rectangle).with_length_m(288.8e-6).unwrap());
    kinds
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Boundary;
    use slipgrid_pattern::Texture;

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

    /// Textures of every kind with their dimensions, in micrometres.
    fn patterns(width_um: f64, spacing_um: f64) -> Vec<Pattern> {
        let pattern = |texture| Pattern::new(texture, width_um * 1e-6, spacing_um * 1e-6, 5.2e-6).unwrap();
        every_kind().into_iter().map(pattern).collect()
    }

    const OUTLINES: [Outline; 2] = [DISC, Outline::Rectangle { length_m: 6e-3, width_m: 3.1e-3 }];

    /// How far a cavity passes the outline, in metres; negative inside.
    fn excess_m(cavity: &Cavity, outline: &Outline) -> f64 {
        let reach_m = match cavity.boundary() {
            Boundary::Circle { centre_m: [x, y], radius_m } => vec![[x, y, radius_m]],
            Boundary::Rectangle { corners_m } => corners_m.map(|[x, y]| [x, y, 0.0]).to_vec(),
        };
        let excess = |[x, y, radius_m]: [f64; 3]| match *outline {
            Outline::Disc { diameter_m } => x.hypot(y) + radius_m - diameter_m / 2.0,
            Outline::Rectangle { length_m, width_m } => {
                (x.abs() - length_m / 2.0).max(y.abs() - width_m / 2.0) + radius_m
            }
        };
        reach_m.into_iter().map(excess).fold(f64::NEG_INFINITY, f64::max)
    }

    #[test]
    fn every_cavity_that_fits_whole_is_laid_and_no_other() {
        for (pattern, outline) in patterns(131.2, 97.0).into_iter().flat_map(|p| OUTLINES.map(|o| (p, o))) {
            let layout = Layout::new(pattern, outline).unwrap();
            assert_eq!(layout.iter().count(), layout.cavities());
            assert!(layout.iter().all(|cavity| excess_m(&cavity, &outline) < 1e-12), "{pattern:?}");
            let area_m2: f64 = layout.iter().map(|cavity| cavity.area_m2()).sum();
            assert!((layout.cavity_area_m2() / area_m2 - 1.0).abs() < 1e-12);
            let Some(length_m) = pattern.length_m() else { continue };
            // The obvious way: every cavity of every cell about the specimen.
            let [cell_x_m, cell_y_m] = pattern.cell_m();
            let mut fitting = 0;
            for (i, j) in (-60..=60).flat_map(|i| (-60..=60).map(move |j| (f64::from(i), f64::from(j)))) {
                for [x_m, y_m] in pattern.centres_m() {
                    let cavity = Cavity {
                        centre_x_m: x_m + i * cell_x_m,
                        centre_y_m: y_m + j * cell_y_m,
                        width_m: pattern.width_m(),
                        length_m,
                        orientation: [1.0, 0.0],
                        planform: pattern.planform(),
                    };
                    fitting += usize::from(excess_m(&cavity, &outline) < 1e-12);
                }
            }
            assert_eq!(layout.cavities(), fitting, "{pattern:?} on {outline:?}");
        }
    }

    #[test]
    fn turned_grooves_are_as_long_as_the_outline_lets_them() {
        let groove = Texture::new(Planform::Groove);
        for angle_deg in [-90.0, -33.3, 10.0, 45.0, 90.0] {
            let turned = groove.with_groove_angle_deg(angle_deg).unwrap();
            let pattern = Pattern::new(turned, 130e-6, 370e-6, 5.2e-6).unwrap();
            // A disc takes the same grooves at any angle.
            let layout = Layout::new(pattern, DISC).unwrap();
            let across = Layout::new(pattern.as_groove(), DISC).unwrap();
            assert_eq!(layout.cavities(), across.cavities());
            assert!((layout.cavity_area_m2() / across.cavity_area_m2() - 1.0).abs() < 1e-12);
            for outline in OUTLINES {
                let layout = Layout::new(pattern, outline).unwrap();
                assert!(layout.cavities() >= 5);
                for groove in layout.iter() {
                    assert!(excess_m(&groove, &outline).abs() < 1e-12, "{angle_deg}: {groove:?}");
                    // Both ends lie on the outline: a groove longer at one end alone passes it.
                    for end in [-1.0, 1.0] {
                        let [cosine, sine] = groove.orientation;
                        let longer = Cavity {
                            length_m: groove.length_m + 1e-9,
                            centre_x_m: groove.centre_x_m - end * 0.5e-9 * sine,
                            centre_y_m: groove.centre_y_m + end * 0.5e-9 * cosine,
                            ..groove
                        };
                        assert!(excess_m(&longer, &outline) > 1e-11, "{angle_deg}: {groove:?}");
                    }
                }
            }
        }
        // Longitudinal on a rectangle: along its length.
        let along = groove.with_groove_angle_deg(90.0).unwrap();
        let along = Pattern::new(along, 100e-6, 200e-6, 5.2e-6).unwrap();
        let layout = Layout::new(along, Outline::Rectangle { length_m: 5e-3, width_m: 0.7e-3 }).unwrap();
        assert_eq!(layout.cavities(), 3);
        assert!(layout.iter().all(|groove| (groove.length_m - 5e-3).abs() < 1e-15));
    }

    #[test]
    fn staggered_rows_lie_half_a_pitch_aside() {
        let staggered = Texture::new(Planform::Square).with_arrangement(Arrangement::Staggered).unwrap();
        let pattern = Pattern::new(staggered, 100e-6, 200e-6, 5.2e-6).unwrap();
        // 1 mm holds centres from -0.45 to 0.45 mm.
        let layout = Layout::new(pattern, Outline::Rectangle { length_m: 1e-3, width_m: 1e-3 }).unwrap();
        let laid: Vec<(i64, i64)> =
            layout.iter().map(|c| ((c.centre_x_m * 1e6).round() as i64, (c.centre_y_m * 1e6).round() as i64)).collect();
        let row = |x: &[i64], y: i64| x.iter().map(|&x| (x, y)).collect::<Vec<_>>();
        let expected =
            [row(&[-450, -150, 150, 450], -300), row(&[-300, 0, 300], 0), row(&[-450, -150, 150, 450], 300)].concat();
        assert_eq!(laid, expected);
    }

    #[test]
    fn one_disc_fits_on_a_disc_of_its_size_and_none_on_a_smaller_one() {
        let pattern = Pattern::new(Planform::Disc, 130e-6, 370e-6, 5.2e-6).unwrap();
        assert_eq!(Layout::new(pattern, Outline::Disc { diameter_m: 130e-6 }).unwrap().cavities(), 1);
        let refused = Layout::new(pattern, Outline::Disc { diameter_m: 129e-6 });
        assert!(matches!(refused, Err(ExportError::NoCavityFits { needed_m: 130e-6, .. })), "{refused:?}");
        let long = Texture::new(Planform::Rectangle).with_length_m(400e-6).unwrap();
        let long = Pattern::new(long, 130e-6, 370e-6, 5.2e-6).unwrap();
        let refused = Layout::new(long, Outline::Rectangle { length_m: 0.3e-3, width_m: 0.39e-3 });
        assert!(matches!(refused, Err(ExportError::NoCavityFits { needed_m: 400e-6, extent_m: 0.39e-3, .. })));
    }
}
