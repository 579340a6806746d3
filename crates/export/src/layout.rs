use slipgrid_pattern::{Pattern, Planform};

use crate::crossing::Crossing;
use crate::face::Face;
use crate::{Boundary, Cavity, ExportError, Outline};

/// Largest number of cavities accepted: a DXF file of them takes about 2.5 GB.
pub const MAX_CAVITIES: usize = 10_000_000;

/// Part of a pitch by which a cavity may pass the outline and still count as inside: what rounding
/// leaves where dimensions are whole, and far below what a laser can place.
const FIT_TOLERANCE: f64 = 1e-9;

/// The cavities of a pattern on a specimen.
///
/// One cavity sits on the specimen's centre and the others on the pattern's lattice about it: row j at
/// y = j pitch across with cavities at x = i pitch, odd rows of a staggered arrangement at
/// x = (i + 1/2) pitch, grooves at i pitch along their own x axis; on a ring the centre is a place like any
/// other. Cavities come row by row from the least y, each row from the least x; grooves from the least of
/// their own x. Where two families of grooves cross, the second comes after the first and is what that leaves of it: no area is
/// taken twice.
///
/// [`Layout::new`] lays whole cavities only: one that passes the rim is left out, a groove is the longest
/// rectangle of its width that fits between the sides of the rim (on a ring one on each side of the hole),
/// and one shorter than it is wide is left out. [`Layout::clipped`] lays all that reach onto the specimen
/// and cuts them at its rim.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layout {
    pattern: Pattern,
    outline: Outline,
    is_clipped: bool,
    /// Columns and rows go from minus these to these; grooves have no rows.
    reach: [i64; 2],
    cavities: usize,
    cavity_area_m2: f64,
}

/// One cell of the pattern's lattice.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    /// What is laid in it: one cavity or none, of grooves on a ring up to two parts, of each family, and of polygons whose rows
    /// reach between each other those beside it.
    pub(crate) cavities: [Option<Cavity>; 5],
    /// Where it ends towards larger x at the y it was asked at, in metres.
    pub(crate) end_x_m: f64,
}

/// How a cavity lies to the specimen's rim and hole.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Lies {
    Inside,
    Across,
    Outside,
}

impl Layout {
    /// Lays whole cavities of `pattern` on `outline`. Time goes with the number of lattice points.
    ///
    /// # Errors
    /// [`ExportError::NotPositive`] if the outline has no extent, [`ExportError::NoRing`] if its hole leaves
    /// nothing, [`ExportError::NoCavityFits`] if it is smaller than a cavity, [`ExportError::TooManyCavities`]
    /// beyond [`MAX_CAVITIES`].
    pub fn new(pattern: Pattern, outline: Outline) -> Result<Self, ExportError> {
        Self::laid(pattern, outline, false)
    }

    /// Lays cavities of `pattern` on `outline` and cuts those that pass the rim.
    ///
    /// # Errors
    /// As [`Layout::new`].
    pub fn clipped(pattern: Pattern, outline: Outline) -> Result<Self, ExportError> {
        Self::laid(pattern, outline, true)
    }

    /// Whether `pattern` can be laid on `outline`, without laying all of it.
    ///
    /// # Errors
    /// As [`Layout::new`].
    pub fn check(pattern: Pattern, outline: Outline, is_clipped: bool) -> Result<(), ExportError> {
        let layout = Self::planned(pattern, outline, is_clipped)?;
        let first = layout.iter().next();
        first.map(|_| ()).ok_or_else(|| no_cavity_fits(&pattern, &outline))
    }

    fn laid(pattern: Pattern, outline: Outline, is_clipped: bool) -> Result<Self, ExportError> {
        let mut layout = Self::planned(pattern, outline, is_clipped)?;
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
            return Err(no_cavity_fits(&pattern, &outline));
        }
        layout.cavities = cavities;
        let square_m2 = whole as f64 * pattern.width_m() * pattern.length_m().unwrap_or(0.0);
        let disc = pattern.planform() == Planform::Disc;
        layout.cavity_area_m2 = area_m2 + if disc { std::f64::consts::FRAC_PI_4 * square_m2 } else { square_m2 };
        Ok(layout)
    }

    /// Number of whole rectangles or discs where nothing else is laid; `None` of other layouts. A search asks it of thousands of
    /// designs, with up to some thousand places each: none is made into a list.
    fn whole_cavities(&self) -> Option<usize> {
        let length_m =
            self.pattern.length_m().filter(|_| !self.is_clipped && self.pattern.texture().outline().is_none())?;
        let [columns, rows] = self.reach;
        let is_inside = |column: i64, row: i64| self.lies(&self.cavity(column, row, length_m)) == Lies::Inside;
        let in_row = |row: i64| {
            if matches!(self.outline, Outline::Ring { .. }) {
                return (-columns..=columns).filter(|&column| is_inside(column, row)).count();
            }
            // Without a hole what is inside has all between it and the middle of its row inside.
            let right = count_before(columns + 1, |column| is_inside(column, row));
            right + count_before(columns, |column| is_inside(-1 - column, row))
        };
        Some((-rows..=rows).map(in_row).sum())
    }

    /// The places on the specimen; its cavities are not counted yet.
    fn planned(pattern: Pattern, outline: Outline, is_clipped: bool) -> Result<Self, ExportError> {
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
        // Half the places, and one more on either side that may still reach in; bounded by MAX_CAVITIES.
        let reach = [columns, rows].map(|places| (places / 2.0).ceil() as i64 + 1);
        Ok(Self { pattern, outline, is_clipped, reach, cavities: 0, cavity_area_m2: 0.0 })
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

    /// Whether cavities that pass the rim are cut there instead of left out.
    #[must_use]
    pub const fn is_clipped(&self) -> bool {
        self.is_clipped
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

    /// Sum of the cavities' volumes with vertical walls, area times depth, in cubic metres.
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
        self.families().into_iter().flat_map(|(family, crossing)| family.own(crossing))
    }

    /// The layouts of each family of crossing grooves with what crosses it; of others the layout alone.
    fn families(&self) -> Vec<(Self, Option<Crossing>)> {
        if self.pattern.planform() != Planform::Crosshatch {
            return vec![(*self, None)];
        }
        let families: Vec<Self> = self.pattern.families().map(|pattern| Self { pattern, ..*self }).collect();
        let first = families.first().map(|&grooves| Crossing { grooves, grown_m: 0.0 });
        let crossings = std::iter::once(None).chain(std::iter::repeat(first));
        families.into_iter().zip(crossings).collect()
    }

    /// The cavities of one family.
    fn own(self, crossed_by: Option<Crossing>) -> impl Iterator<Item = Cavity> {
        let [columns, rows] = self.reach;
        let rows = self.pattern.length_m().map_or(0, |_| rows);
        (-rows..=rows)
            .flat_map(move |row| {
                (-columns..=columns).flat_map(move |column| match self.pattern.length_m() {
                    None => self.groove(column),
                    Some(length_m) => [self.place(self.cavity(column, row, length_m)), None],
                })
            })
            .flatten()
            .map(move |cavity| Cavity { crossed_by, ..cavity })
            .filter(|cavity| cavity.crossed_by.is_none() || !cavity.boundaries().is_empty())
    }

    /// The grooves at `column` as rectangles, longer than the specimen where its rim cuts them.
    pub(crate) fn uncut_grooves(&self, column: i64) -> [Option<Cavity>; 2] {
        if self.is_clipped { [Some(Cavity { cut_by: None, ..self.strip(column) }), None] } else { self.groove(column) }
    }

    /// The lattice cell that holds the point.
    pub(crate) fn cell(&self, [x_m, y_m]: [f64; 2]) -> Cell {
        if self.pattern.planform() == Planform::Crosshatch {
            let mut cell = Cell { cavities: [None; 5], end_x_m: f64::INFINITY };
            for (place, (family, _)) in self.families().iter().enumerate().take(2) {
                let own = family.cell([x_m, y_m]);
                cell.cavities[2 * place..2 * place + 2].copy_from_slice(&own.cavities[..2]);
                cell.end_x_m = cell.end_x_m.min(own.end_x_m);
            }
            return cell;
        }
        let pitch_m = self.pattern.pitch_m();
        let Some((length_m, across_m)) = self.pattern.length_m().zip(self.pattern.pitch_across_m()) else {
            let [cosine, sine] = self.pattern.texture().orientation();
            // Points lie on the specimen, whose places are bounded: the casts are exact.
            let column = ((x_m * cosine + y_m * sine) / pitch_m).round();
            let place = column as i64;
            let [one, other] = if self.is_clipped { [Some(self.strip(place)), None] } else { self.groove(place) };
            let cavities = [one, other, None, None, None];
            // x cos a + y sin a = (column +- 1/2) pitch; a groove along x never ends.
            let end_x_m = ((column + 0.5_f64.copysign(cosine)) * pitch_m - y_m * sine) / cosine;
            return Cell { cavities, end_x_m: if cosine == 0.0 { f64::INFINITY } else { end_x_m } };
        };
        let row = (y_m / across_m).round() as i64;
        let shift = if self.is_shifted(row) { 0.5 } else { 0.0 };
        let column = (x_m / pitch_m - shift).round();
        let laid = |column: i64, row: i64| {
            let cavity = self.cavity(column, row, length_m);
            match self.lies(&cavity) {
                Lies::Inside => Some(cavity),
                Lies::Across if self.is_clipped => Some(Cavity { cut_by: Some(self.outline), ..cavity }),
                Lies::Across | Lies::Outside => None,
            }
        };
        let mut cavities = [laid(column as i64, row), None, None, None, None];
        if self.pattern.texture().outline().is_some() && length_m > across_m {
            // Those of the rows below and above at half a pitch to either side.
            let left = column as i64 - i64::from(!self.is_shifted(row));
            for (place, (row, side)) in [(row - 1, 0), (row - 1, 1), (row + 1, 0), (row + 1, 1)].into_iter().enumerate()
            {
                cavities[place + 1] = laid(left + side, row);
            }
        }
        Cell { cavities, end_x_m: (column + shift + 0.5) * pitch_m }
    }

    /// The cavity as it is laid: whole, cut, or not at all.
    fn place(&self, cavity: Cavity) -> Option<Cavity> {
        match self.lies(&cavity) {
            Lies::Inside => Some(cavity),
            Lies::Across if self.is_clipped => {
                let cut = Cavity { cut_by: Some(self.outline), ..cavity };
                (!cut.boundaries().is_empty()).then_some(cut)
            }
            Lies::Across | Lies::Outside => None,
        }
    }

    /// How a disc, or a rectangle with its sides along x and y, lies to rim and hole.
    fn lies(&self, cavity: &Cavity) -> Lies {
        let slack_m = FIT_TOLERANCE * self.pattern.pitch_m();
        let (x_m, y_m) = (cavity.centre_x_m.abs(), cavity.centre_y_m.abs());
        let (half_x_m, half_y_m) = (cavity.width_m / 2.0, cavity.length_m / 2.0);
        let diameter_m = match self.outline {
            Outline::Rectangle { length_m, width_m } => {
                let inside = |at_m: f64, half_m: f64, limit_m: f64| at_m + half_m <= limit_m + slack_m;
                let outside = |at_m: f64, half_m: f64, limit_m: f64| at_m - half_m >= limit_m - slack_m;
                let (limit_x_m, limit_y_m) = (length_m / 2.0, width_m / 2.0);
                return if inside(x_m, half_x_m, limit_x_m) && inside(y_m, half_y_m, limit_y_m) {
                    Lies::Inside
                } else if outside(x_m, half_x_m, limit_x_m) || outside(y_m, half_y_m, limit_y_m) {
                    Lies::Outside
                } else {
                    Lies::Across
                };
            }
            Outline::Disc { diameter_m } | Outline::Ring { outer_diameter_m: diameter_m, .. } => diameter_m,
        };
        // Nearest and farthest points from the specimen's centre.
        let (near_m, far_m) = if let Some([near_m, far_m]) = cavity.polygon_reach_m() {
            (near_m, far_m)
        } else if cavity.planform == Planform::Disc {
            let distance_m = x_m.hypot(y_m);
            ((distance_m - half_x_m).max(0.0), distance_m + half_x_m)
        } else {
            ((x_m - half_x_m).max(0.0).hypot((y_m - half_y_m).max(0.0)), (x_m + half_x_m).hypot(y_m + half_y_m))
        };
        let (rim_m, hole_m) = (diameter_m / 2.0, self.outline.hole_m() / 2.0);
        if near_m >= rim_m - slack_m || far_m <= hole_m + slack_m {
            Lies::Outside
        } else if far_m <= rim_m + slack_m && near_m >= hole_m - slack_m {
            Lies::Inside
        } else {
            Lies::Across
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
        let width_m = self.pattern.width_m();
        let face = |outline| Face { outline, centre_m: [centre_x_m, centre_y_m], width_m, inset_m: 0.0 };
        Cavity {
            centre_x_m,
            centre_y_m,
            width_m,
            length_m,
            orientation: self.pattern.texture().orientation(),
            planform: self.pattern.planform(),
            cut_by: None,
            face: self.pattern.texture().outline().map(face),
            crossed_by: None,
        }
    }

    /// The groove at `column` pitches along its own x axis, from one to the other of its own y.
    fn groove_between(&self, column: i64, [low_m, high_m]: [f64; 2]) -> Cavity {
        let orientation = self.pattern.texture().orientation();
        let [cosine, sine] = orientation;
        let (offset_m, middle_m) = (column as f64 * self.pattern.pitch_m(), f64::midpoint(low_m, high_m));
        Cavity {
            centre_x_m: offset_m * cosine - middle_m * sine,
            centre_y_m: offset_m * sine + middle_m * cosine,
            width_m: self.pattern.width_m(),
            length_m: high_m - low_m,
            orientation,
            planform: Planform::Groove,
            cut_by: None,
            face: None,
            crossed_by: None,
        }
    }

    /// The groove at `column` longer than the specimen, to be cut at its rim.
    fn strip(&self, column: i64) -> Cavity {
        let [extent_x_m, extent_y_m] = self.outline.extents_m();
        let half_m = extent_x_m.hypot(extent_y_m);
        Cavity { cut_by: Some(self.outline), ..self.groove_between(column, [-half_m, half_m]) }
    }

    /// The grooves at `column` pitches along their own x axis, from the least of their own y: one, or on a
    /// ring one on either side of the hole. Those shorter than wide are left out.
    fn groove(&self, column: i64) -> [Option<Cavity>; 2] {
        let (width_m, pitch_m) = (self.pattern.width_m(), self.pattern.pitch_m());
        let slack_m = FIT_TOLERANCE * pitch_m;
        let orientation = self.pattern.texture().orientation();
        let offset_m = column as f64 * pitch_m;
        let laid = |span_m: [f64; 2]| self.groove_between(column, span_m);
        if self.is_clipped {
            // Cut, and then named by what is left of it.
            let cut = self.strip(column);
            let corners = cut.boundaries().iter().flat_map(Boundary::polygon_m).collect::<Vec<_>>();
            let along = corners.iter().map(|[x, y]| y * orientation[0] - x * orientation[1]);
            let span_m = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| [low.min(at), high.max(at)]);
            return [(!corners.is_empty()).then(|| Cavity { cut_by: cut.cut_by, ..laid(span_m) }), None];
        }
        // The outline is convex but for the hole: a rectangle ends where the nearer of its two sides does.
        let side_m = |side: f64| offset_m + side * (width_m / 2.0) - side * slack_m;
        let chords_m = [-1.0, 1.0].map(|side| self.outline.chord_m(orientation, side_m(side)));
        let [Some(one_m), Some(other_m)] = chords_m else { return [None; 2] };
        let (low_m, high_m) = (one_m[0].max(other_m[0]), one_m[1].min(other_m[1]));
        let fits = |span_m: [f64; 2]| (span_m[1] - span_m[0] >= width_m - slack_m).then(|| laid(span_m));
        // The hole is widest where the groove is nearest to the centre.
        let (hole_m, near_m) = (self.outline.hole_m() / 2.0, (offset_m.abs() - width_m / 2.0).max(0.0));
        if near_m >= hole_m - slack_m {
            return [fits([low_m, high_m]), None];
        }
        let half_m = ((hole_m - near_m) * (hole_m + near_m)).sqrt();
        [fits([low_m, -half_m]), fits([half_m, high_m])]
    }
}

/// How many of the places 0..`places` are `inside`, none of which lies behind one that is not.
fn count_before(places: i64, inside: impl Fn(i64) -> bool) -> usize {
    let (mut least, mut most) = (0, places);
    while least < most {
        let middle = i64::midpoint(least, most);
        if inside(middle) { least = middle + 1 } else { most = middle }
    }
    usize::try_from(least).unwrap_or(0)
}

/// Why the specimen takes none: the extent that falls short, or of a disc the diameter.
fn no_cavity_fits(pattern: &Pattern, outline: &Outline) -> ExportError {
    let (width_m, length_m) = (pattern.width_m(), pattern.length_m().unwrap_or(pattern.width_m()));
    let [extent_x_m, extent_y_m] = outline.extents_m();
    let turned = pattern.texture().orientation() != [1.0, 0.0];
    let (needed_m, extent_m) = match *outline {
        // Discs touch the circle, corners of others lie on it; a square fits turned if its diagonal does.
        Outline::Disc { .. } if pattern.planform() == Planform::Disc => (width_m, extent_x_m),
        Outline::Disc { .. } => (width_m.hypot(length_m), extent_x_m),
        Outline::Rectangle { .. } if turned => (width_m.hypot(length_m), extent_x_m.min(extent_y_m)),
        Outline::Rectangle { .. } if width_m == length_m => (width_m, extent_x_m.min(extent_y_m)),
        Outline::Rectangle { .. } if extent_x_m < width_m => (width_m, extent_x_m),
        Outline::Rectangle { .. } => (length_m, extent_y_m),
        // Wherever the lattice lies, between rim and hole.
        Outline::Ring { outer_diameter_m, inner_diameter_m } => {
            (pattern.pitch_m() + width_m.hypot(length_m), (outer_diameter_m - inner_diameter_m) / 2.0)
        }
    };
    ExportError::NoCavityFits { width_m, extent_m, needed_m }
}

/// A texture of every kind, each with numbers of its own, for tests of what is written.
#[cfg(test)]
pub(crate) fn every_kind() -> Vec<slipgrid_pattern::Texture> {
    use slipgrid_pattern::{Arrangement, Texture};
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
    // A bent one without symmetry, and two families of grooves.
    let bent = [[0.0, 0.0], [100.0, 10.0], [90.0, 60.0], [65.0, 55.0], [60.0, 110.0], [5.0, 105.0]];
    let bent = Texture::new(Planform::Polygon).with_outline(slipgrid_pattern::Polygon::new(&bent).unwrap()).unwrap();
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
