use slipgrid_base::statistics::extremes;
use slipgrid_model::pattern::{Contour, Pattern, Planform};

use crate::export::crossing::Crossing;
use crate::export::{Boundary, Cavity, ExportError, Outline, Specimen};

/// Maximum number of cavities of a layout: a DXF file of so many takes about 2.5 GB.
pub const MAX_CAVITIES: usize = 10_000_000;

/// Fraction of a pitch by which a cavity may cross the outline and still count as inside: more than rounding errors,
/// and far below the positioning accuracy of a laser.
pub(crate) const FIT_TOLERANCE: f64 = 1e-9;

/// Cavities of a pattern laid out on a specimen.
///
/// One cavity lies at the specimen's centre and the others on the pattern's lattice around it: row j at y = j times the
/// pitch across, with cavities at x = i times the pitch, or at x = (i + 1/2) times the pitch in odd rows of a staggered
/// arrangement. Grooves lie at i times the pitch along the pattern's x axis, which is at right angles to them. A ring
/// has the same lattice, centred in the hole. Cavities are ordered by rows from the smallest y, and within a row from
/// the smallest x; grooves by position along the pattern's x axis. If two families of grooves cross, the second comes
/// after the first and excludes the area of the first, so that no area is counted twice.
///
/// [`Layout::new`] lays out complete cavities only. A cavity that crosses the border is left out. A groove is the
/// longest rectangle of its width that fits inside the border (on a ring, one on each side of the hole); a groove
/// shorter than its width is left out. [`Layout::clipped`] lays out all cavities that reach onto the specimen and cuts
/// them at the border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pattern: Pattern,
    specimen: Specimen,
    /// Largest index of columns and of rows, which run from minus to plus this value; grooves have no rows.
    reach: [i64; 2],
    cavities: usize,
    cavity_area_m2: f64,
}

/// One cell of the pattern's lattice.
#[derive(Clone, Debug)]
pub(crate) struct Cell {
    /// Cavities in the cell: at most one, or for each family of grooves up to two parts of a groove on a ring. For
    /// polygons in interlocking rows also the neighbours.
    pub(crate) cavities: Vec<Cavity>,
    /// End of the cell towards larger x, at the y of the query, in metres.
    pub(crate) end_x_m: f64,
}

/// Position of a cavity relative to the border and the hole of the specimen.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Position {
    Inside,
    Across,
    Outside,
}

impl Layout {
    /// Lays out complete cavities of `pattern` on `outline`.
    ///
    /// # Errors
    /// See [`Specimen::layout`].
    pub fn new(pattern: Pattern, outline: Outline) -> Result<Self, ExportError> {
        Specimen { outline, is_clipped: false }.layout(pattern)
    }

    /// Lays out cavities of `pattern` on `outline` and cuts those that cross the border.
    ///
    /// # Errors
    /// See [`Specimen::layout`].
    pub fn clipped(pattern: Pattern, outline: Outline) -> Result<Self, ExportError> {
        Specimen { outline, is_clipped: true }.layout(pattern)
    }

    /// Lays out `pattern` on `specimen`, see [`Specimen::layout`].
    pub(crate) fn on(specimen: Specimen, pattern: Pattern) -> Result<Self, ExportError> {
        let mut layout = Self::planned(pattern, specimen)?;
        let (mut cavities, mut area_m2) = (0, 0.0);
        let mut whole = 0_usize;
        if let Some(count) = layout.whole_cavities() {
            (cavities, whole) = (count, count);
        } else {
            for cavity in layout.iter() {
                cavities += 1;
                if cavity.planform != Planform::Groove && cavity.face.is_none() && cavity.cut_by.is_none() {
                    whole += 1;
                } else {
                    area_m2 += cavity.area_m2();
                }
            }
        }
        if cavities == 0 {
            return Err(no_cavity_fits(&pattern, &specimen.outline));
        }
        layout.cavities = cavities;
        let around_m2 = whole as f64 * pattern.width_m() * pattern.length_m().unwrap_or(0.0);
        layout.cavity_area_m2 = area_m2 + pattern.planform().contour().fill() * around_m2;
        Ok(layout)
    }

    /// Checks whether `pattern` can be laid out on `specimen`, see [`Specimen::check`].
    pub(crate) fn check(specimen: Specimen, pattern: Pattern) -> Result<(), ExportError> {
        let first = Self::planned(pattern, specimen)?.iter().next();
        first.map(|_| ()).ok_or_else(|| no_cavity_fits(&pattern, &specimen.outline))
    }

    /// Number of complete rectangles or discs, if the layout holds nothing else; otherwise `None`. Cavities are counted
    /// without a list, because a search lays out thousands of designs with up to a thousand lattice points each.
    fn whole_cavities(&self) -> Option<usize> {
        let length_m = self
            .pattern
            .length_m()
            .filter(|_| !self.specimen.is_clipped && self.pattern.texture().outline().is_none())?;
        let [columns, rows] = self.reach;
        let is_inside =
            |column: i64, row: i64| self.position_of(&self.cavity(column, row, length_m)) == Position::Inside;
        let in_row = |row: i64| {
            if matches!(self.specimen.outline, Outline::Ring { .. }) {
                return (-columns..=columns).filter(|&column| is_inside(column, row)).count();
            }
            // Without a hole, all places between an inside place and the middle of its row are inside.
            let right = count_before(columns + 1, |column| is_inside(column, row));
            right + count_before(columns, |column| is_inside(-1 - column, row))
        };
        Some((-rows..=rows).map(in_row).sum())
    }

    /// Creates the layout without counting cavities: their number and area are 0.
    fn planned(pattern: Pattern, specimen: Specimen) -> Result<Self, ExportError> {
        let outline = specimen.outline;
        outline.validate()?;
        let [extent_x_m, extent_y_m] = outline.extents_m();
        let along = |orientation: [f64; 2]| outline.extent_along_m(orientation) / pattern.pitch_m() + 1.0;
        let columns = match pattern.length_m() {
            None if pattern.planform() == Planform::Crosshatch => {
                pattern.families().map(|family| along(family.texture().orientation())).sum()
            }
            None => along(pattern.texture().orientation()),
            Some(_) => extent_x_m / pattern.pitch_m() + 1.0,
        };
        let rows = pattern.pitch_across_m().map_or(1.0, |pitch_m| extent_y_m / pitch_m + 1.0);
        if columns * rows > MAX_CAVITIES as f64 {
            return Err(ExportError::TooManyCavities { cavities: columns * rows, most: MAX_CAVITIES });
        }
        // Half the places, plus one on either side that may still reach in; bounded by MAX_CAVITIES.
        let reach = [columns, rows].map(|places| (places / 2.0).ceil() as i64 + 1);
        Ok(Self { pattern, specimen, reach, cavities: 0, cavity_area_m2: 0.0 })
    }

    /// Pattern of the cavities.
    pub const fn pattern(&self) -> &Pattern {
        &self.pattern
    }

    /// The specimen.
    pub const fn specimen(&self) -> &Specimen {
        &self.specimen
    }

    /// Outline of the specimen.
    pub const fn outline(&self) -> &Outline {
        &self.specimen.outline
    }

    /// Number of cavities, at least one.
    pub const fn cavities(&self) -> usize {
        self.cavities
    }

    /// Total area of the cavities seen from above, in square metres.
    pub const fn cavity_area_m2(&self) -> f64 {
        self.cavity_area_m2
    }

    /// Total volume of the cavities with vertical walls, area times depth, in cubic metres.
    pub fn cavity_volume_m3(&self) -> f64 {
        self.cavity_area_m2 * self.pattern.depth_m()
    }

    /// Fraction of the specimen's face that is cavity. It differs from the areal density of the infinite pattern at the
    /// border; on a face of many periods it is lower if complete cavities leave the border untextured.
    pub fn areal_density(&self) -> f64 {
        self.cavity_area_m2 / self.specimen.outline.area_m2()
    }

    /// The cavities in the order described for [`Layout`], computed one by one.
    pub fn iter(&self) -> impl Iterator<Item = Cavity> + '_ {
        self.families().into_iter().flat_map(|(family, crossing)| family.family_cavities(crossing))
    }

    /// Layout of each family of crossing grooves with the grooves that cut the family: none for the first family, the
    /// first family for the second. For other planforms only this layout.
    fn families(&self) -> Vec<(Self, Option<Crossing>)> {
        if self.pattern.planform() != Planform::Crosshatch {
            return vec![(*self, None)];
        }
        let families: Vec<Self> = self.pattern.families().map(|pattern| Self { pattern, ..*self }).collect();
        let first = families.first().map(|&grooves| Crossing { grooves, grown_m: 0.0 });
        let crossings = std::iter::once(None).chain(std::iter::repeat(first));
        families.into_iter().zip(crossings).collect()
    }

    /// Cavities of one family of grooves, or of a layout without families, in order. `crossed_by` are the grooves that
    /// cut the family.
    fn family_cavities(self, crossed_by: Option<Crossing>) -> impl Iterator<Item = Cavity> {
        let [columns, rows] = self.reach;
        let rows = self.pattern.length_m().map_or(0, |_| rows);
        (-rows..=rows)
            .flat_map(move |row| {
                (-columns..=columns).flat_map(move |column| match self.pattern.length_m() {
                    None => self.groove(column),
                    Some(length_m) => {
                        let cavity = self.cut(self.cavity(column, row, length_m));
                        [cavity.filter(|cavity| cavity.cut_by.is_none() || !cavity.boundaries().is_empty()), None]
                    }
                })
            })
            .flatten()
            .map(move |cavity| Cavity { crossed_by, ..cavity })
            .filter(|cavity| cavity.crossed_by.is_none() || !cavity.boundaries().is_empty())
    }

    /// Grooves at `column` as rectangles: of a clipped layout one rectangle longer than the specimen, to be cut at the
    /// border, otherwise those that `groove` returns.
    pub(crate) fn rectangles(&self, column: i64) -> [Option<Cavity>; 2] {
        if self.specimen.is_clipped { [Some(self.strip(column)), None] } else { self.groove(column) }
    }

    /// Returns the lattice cell that contains the point; for crossing grooves, the cells of both families together.
    pub(crate) fn cell(&self, [x_m, y_m]: [f64; 2]) -> Cell {
        if self.pattern.planform() == Planform::Crosshatch {
            let mut cell = Cell { cavities: Vec::new(), end_x_m: f64::INFINITY };
            for (family, _) in self.families() {
                let own = family.cell([x_m, y_m]);
                cell.cavities.extend(own.cavities);
                cell.end_x_m = cell.end_x_m.min(own.end_x_m);
            }
            return cell;
        }
        let pitch_m = self.pattern.pitch_m();
        let Some((length_m, across_m)) = self.pattern.length_m().zip(self.pattern.pitch_across_m()) else {
            let [cosine, sine] = self.pattern.texture().orientation();
            // Points lie on the specimen, which bounds the indices, so that the casts are exact.
            let column = ((x_m * cosine + y_m * sine) / pitch_m).round();
            let cavities = self.rectangles(column as i64).into_iter().flatten().collect();
            // x cos a + y sin a = (column +- 1/2) pitch; the cell of a groove along x is infinite.
            let end_x_m = ((column + 0.5_f64.copysign(cosine)) * pitch_m - y_m * sine) / cosine;
            return Cell { cavities, end_x_m: if cosine == 0.0 { f64::INFINITY } else { end_x_m } };
        };
        let row = (y_m / across_m).round() as i64;
        let shift = if self.is_shifted(row) { 0.5 } else { 0.0 };
        let column = (x_m / pitch_m - shift).round();
        // Neighbours in the rows below and above at half a pitch to either side.
        let left = column as i64 - i64::from(!self.is_shifted(row));
        let beside = [(left, row - 1), (left + 1, row - 1), (left, row + 1), (left + 1, row + 1)];
        let reaches = self.pattern.texture().outline().is_some() && length_m > across_m;
        let places = std::iter::once((column as i64, row)).chain(beside.into_iter().filter(|_| reaches));
        let laid = |(column, row)| self.cut(self.cavity(column, row, length_m));
        Cell { cavities: places.filter_map(laid).collect(), end_x_m: (column + shift + 0.5) * pitch_m }
    }

    /// Returns the cavity complete or cut at the border, of which nothing may remain; `None` if it is left out.
    fn cut(&self, cavity: Cavity) -> Option<Cavity> {
        match self.position_of(&cavity) {
            Position::Inside => Some(cavity),
            Position::Across if self.specimen.is_clipped => {
                Some(Cavity { cut_by: Some(self.specimen.outline), ..cavity })
            }
            Position::Across | Position::Outside => None,
        }
    }

    /// Position of a polygon, of a disc, or of a rectangle with sides along x and y, relative to border and hole.
    fn position_of(&self, cavity: &Cavity) -> Position {
        let slack_m = FIT_TOLERANCE * self.pattern.pitch_m();
        let (x_m, y_m) = (cavity.centre_x_m.abs(), cavity.centre_y_m.abs());
        let (half_x_m, half_y_m) = (cavity.width_m / 2.0, cavity.length_m / 2.0);
        let diameter_m = match self.specimen.outline {
            Outline::Rectangle { length_m, width_m } => {
                let inside = |at_m: f64, half_m: f64, limit_m: f64| at_m + half_m <= limit_m + slack_m;
                let outside = |at_m: f64, half_m: f64, limit_m: f64| at_m - half_m >= limit_m - slack_m;
                let (limit_x_m, limit_y_m) = (length_m / 2.0, width_m / 2.0);
                return if inside(x_m, half_x_m, limit_x_m) && inside(y_m, half_y_m, limit_y_m) {
                    Position::Inside
                } else if outside(x_m, half_x_m, limit_x_m) || outside(y_m, half_y_m, limit_y_m) {
                    Position::Outside
                } else {
                    Position::Across
                };
            }
            Outline::Disc { diameter_m } | Outline::Ring { outer_diameter_m: diameter_m, .. } => diameter_m,
        };
        // Smallest and largest distance from the specimen's centre.
        let [near_m, far_m] = cavity.polygon_reach_m().unwrap_or_else(|| match cavity.planform.contour() {
            Contour::Circle => {
                let distance_m = x_m.hypot(y_m);
                [(distance_m - half_x_m).max(0.0), distance_m + half_x_m]
            }
            Contour::Rectangle => {
                [(x_m - half_x_m).max(0.0).hypot((y_m - half_y_m).max(0.0)), (x_m + half_x_m).hypot(y_m + half_y_m)]
            }
        });
        let (rim_m, hole_m) = (diameter_m / 2.0, self.specimen.outline.hole_m() / 2.0);
        if near_m >= rim_m - slack_m || far_m <= hole_m + slack_m {
            Position::Outside
        } else if far_m <= rim_m + slack_m && near_m >= hole_m - slack_m {
            Position::Inside
        } else {
            Position::Across
        }
    }

    /// Whether a row is shifted along x by half a pitch.
    fn is_shifted(&self, row: i64) -> bool {
        self.pattern.texture().arrangement().shifts_rows() && row.rem_euclid(2) == 1
    }

    fn cavity(&self, column: i64, row: i64, length_m: f64) -> Cavity {
        let shift = if self.is_shifted(row) { 0.5 } else { 0.0 };
        let centre_x_m = (column as f64 + shift) * self.pattern.pitch_m();
        let centre_y_m = row as f64 * self.pattern.pitch_across_m().unwrap_or(0.0);
        Cavity::new(&self.pattern, [centre_x_m, centre_y_m], length_m)
    }

    /// Groove at `column` pitches along the pattern's x axis, between two positions along the groove, in metres.
    fn groove_between(&self, column: i64, [low_m, high_m]: [f64; 2]) -> Cavity {
        let [cosine, sine] = self.pattern.texture().orientation();
        let (offset_m, middle_m) = (column as f64 * self.pattern.pitch_m(), f64::midpoint(low_m, high_m));
        let centre_m = [offset_m * cosine - middle_m * sine, offset_m * sine + middle_m * cosine];
        Cavity { planform: Planform::Groove, ..Cavity::new(&self.pattern, centre_m, high_m - low_m) }
    }

    /// Groove at `column`, longer than the specimen, to be cut at the border.
    fn strip(&self, column: i64) -> Cavity {
        let [extent_x_m, extent_y_m] = self.specimen.outline.extents_m();
        let half_m = extent_x_m.hypot(extent_y_m);
        Cavity { cut_by: Some(self.specimen.outline), ..self.groove_between(column, [-half_m, half_m]) }
    }

    /// Grooves at `column` pitches along the pattern's x axis, by increasing position along the groove: one, or one on
    /// each side of the hole of a ring. Grooves shorter than their width are left out; a clipped layout has one groove,
    /// as long as its parts on the specimen.
    fn groove(&self, column: i64) -> [Option<Cavity>; 2] {
        let (width_m, pitch_m) = (self.pattern.width_m(), self.pattern.pitch_m());
        let slack_m = FIT_TOLERANCE * pitch_m;
        let orientation = self.pattern.texture().orientation();
        let offset_m = column as f64 * pitch_m;
        let laid = |span_m: [f64; 2]| self.groove_between(column, span_m);
        if self.specimen.is_clipped {
            // Cut the strip, then set its extent to that of the remaining parts.
            let cut = self.strip(column);
            let corners = cut.boundaries().iter().flat_map(Boundary::polygon_m).collect::<Vec<_>>();
            let along = corners.iter().map(|[x, y]| y * orientation[0] - x * orientation[1]);
            let span_m = extremes(along);
            return [(!corners.is_empty()).then(|| Cavity { cut_by: cut.cut_by, ..laid(span_m) }), None];
        }
        // The outline is convex except for the hole, so that a rectangle ends where the shorter of its two sides does.
        let side_m = |side: f64| offset_m + side * (width_m / 2.0) - side * slack_m;
        let chords_m = [-1.0, 1.0].map(|side| self.specimen.outline.chord_m(orientation, side_m(side)));
        let [Some(one_m), Some(other_m)] = chords_m else { return [None; 2] };
        let (low_m, high_m) = (one_m[0].max(other_m[0]), one_m[1].min(other_m[1]));
        let fits = |span_m: [f64; 2]| (span_m[1] - span_m[0] >= width_m - slack_m).then(|| laid(span_m));
        // The hole is widest where the groove is closest to the centre.
        let (hole_m, near_m) = (self.specimen.outline.hole_m() / 2.0, (offset_m.abs() - width_m / 2.0).max(0.0));
        if near_m >= hole_m - slack_m {
            return [fits([low_m, high_m]), None];
        }
        let half_m = ((hole_m - near_m) * (hole_m + near_m)).sqrt();
        [fits([low_m, -half_m]), fits([half_m, high_m])]
    }
}

/// Counts the indices in 0..`places` for which `inside` holds, by bisection; these indices must come first.
fn count_before(places: i64, inside: impl Fn(i64) -> bool) -> usize {
    let (mut least, mut most) = (0, places);
    while least < most {
        let middle = i64::midpoint(least, most);
        if inside(middle) { least = middle + 1 } else { most = middle }
    }
    usize::try_from(least).unwrap_or(0)
}

/// Creates the error for a specimen on which no cavity fits, with the extent that is too small and the extent that is
/// needed.
fn no_cavity_fits(pattern: &Pattern, outline: &Outline) -> ExportError {
    let (width_m, length_m) = (pattern.width_m(), pattern.length_m().unwrap_or(pattern.width_m()));
    let [extent_x_m, extent_y_m] = outline.extents_m();
    let turned = pattern.texture().orientation() != [1.0, 0.0];
    let (needed_m, extent_m) = match *outline {
        // Discs touch the circle, corners of other cavities lie on it; a turned square fits if its diagonal does.
        Outline::Disc { .. } => match pattern.planform().contour() {
            Contour::Circle => (width_m, extent_x_m),
            Contour::Rectangle => (width_m.hypot(length_m), extent_x_m),
        },
        Outline::Rectangle { .. } if turned => (width_m.hypot(length_m), extent_x_m.min(extent_y_m)),
        Outline::Rectangle { .. } if width_m == length_m => (width_m, extent_x_m.min(extent_y_m)),
        Outline::Rectangle { .. } if extent_x_m < width_m => (width_m, extent_x_m),
        Outline::Rectangle { .. } => (length_m, extent_y_m),
        // For any position of the lattice, between border and hole.
        Outline::Ring { outer_diameter_m, inner_diameter_m } => {
            (pattern.pitch_m() + width_m.hypot(length_m), (outer_diameter_m - inner_diameter_m) / 2.0)
        }
    };
    ExportError::NoCavityFits { width_m, extent_m, needed_m }
}

/// A texture of every kind, each with different numbers, for tests of exports.
#[cfg(test)]
pub(crate) fn every_kind() -> Vec<slipgrid_model::pattern::Texture> {
    use slipgrid_model::pattern::{Arrangement, Texture};
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
    // A polygon without symmetry, and two families of grooves.
    let bent = [[0.0, 0.0], [100.0, 10.0], [90.0, 60.0], [65.0, 55.0], [60.0, 110.0], [5.0, 105.0]];
    let bent =
        Texture::new(Planform::Polygon).with_outline(slipgrid_model::pattern::Polygon::new(&bent).unwrap()).unwrap();
    let crossed = Texture::new(Planform::Crosshatch);
    kinds.extend([
        bent,
        bent.with_arrangement(Arrangement::Staggered).unwrap().with_spacing_across_m(55.5e-6).unwrap(),
        crossed,
        crossed.with_crossing_angle_deg(62.0).unwrap().with_groove_angle_deg(-25.0).unwrap(),
    ]);
    kinds
}

#[cfg(test)]
mod tests;
