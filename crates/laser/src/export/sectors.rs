//! Several patterns on sectors of one specimen.

use slipgrid_model::pattern::{Pattern, Planform};

use crate::export::clip::{area_m2, clip, within_side, without_slivers};
use crate::export::layout::FIT_TOLERANCE;
use crate::export::{Boundary, Cavity, ExportError, Layout, Outline, Specimen, mm};

/// Maximum number of sectors of a specimen.
pub const MAX_SECTORS: usize = 12;
/// Width of the lands between sectors, as a fraction of the smaller extent of the specimen.
const LAND_SHARE: f64 = 0.05;
/// Minimum number of periods of a pattern, along each of its axes, in the largest circle on each sector.
pub const MIN_PERIODS: f64 = 4.0;
/// Start and end of the mark on its land, as fractions of the way from the centre (or hole) to the border.
const MARK_SPAN: [f64; 2] = [0.8, 0.95];
/// Width of the mark as a fraction of the width of the land.
const MARK_SHARE: f64 = 0.2;
/// Number of steps of the ternary search for the largest circle on a sector.
const STEPS: usize = 120;

/// Division of the face of a specimen into sectors of equal angles by straight untextured lands from the centre to the
/// border.
///
/// Sectors are numbered from 1, anticlockwise; the middle of the first is at 90 degrees from x. Sectors of discs and
/// rings are rotated copies of the first: if the specimen is turned back by the angle of a sector, this sector is where
/// the first was. Sectors of a rectangle are not rotated.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Division {
    specimen: Specimen,
    count: usize,
    land_m: f64,
}

/// A pattern laid out on one sector of a specimen.
#[derive(Clone, Debug, PartialEq)]
pub struct Sector {
    division: Division,
    /// Number of the sector, from 1.
    number: usize,
    layout: Layout,
    cavities: usize,
    cavity_area_m2: f64,
}

impl Division {
    /// Divides `specimen` into `count` sectors.
    ///
    /// # Errors
    /// [`ExportError::Refused`] for fewer than two or more than [`MAX_SECTORS`], and for an invalid outline.
    pub fn new(specimen: Specimen, count: usize) -> Result<Self, ExportError> {
        specimen.outline.validate()?;
        if !(2..=MAX_SECTORS).contains(&count) {
            return Err(wrong_count(count, MAX_SECTORS));
        }
        let [extent_x_m, extent_y_m] = specimen.outline.extents_m();
        Ok(Self { specimen, count, land_m: LAND_SHARE * extent_x_m.min(extent_y_m) })
    }

    /// Number of sectors.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// The specimen.
    pub const fn specimen(&self) -> &Specimen {
        &self.specimen
    }

    /// Width of a land, in metres.
    pub const fn land_m(&self) -> f64 {
        self.land_m
    }

    /// Angle of a sector including half of the adjacent lands, in degrees.
    pub fn angle_deg(&self) -> f64 {
        360.0 / self.count as f64
    }

    /// Direction of the middle of sector `number` from x, anticlockwise, in degrees.
    pub fn middle_deg(&self, number: usize) -> f64 {
        (90.0 + self.angle_deg() * number.saturating_sub(1) as f64).rem_euclid(360.0)
    }

    /// Angle by which the pattern of sector `number` is turned with the sector, anticlockwise, in degrees: 0 on a
    /// rectangle.
    pub fn turn_deg(&self, number: usize) -> f64 {
        match self.specimen.outline {
            Outline::Rectangle { .. } => 0.0,
            _ => self.angle_deg() * number.saturating_sub(1) as f64,
        }
    }

    /// Direction of the middle of sector `number` in the axes of its pattern, in degrees.
    fn own_middle_deg(&self, number: usize) -> f64 {
        self.middle_deg(number) - self.turn_deg(number)
    }

    /// Borders of sector `number` with the lands on both sides, in the axes of its pattern: unit normals n and
    /// distances d in metres, with n x <= d for all points x of the sector.
    fn sides(&self, number: usize) -> [([f64; 2], f64); 2] {
        let at = |deg: f64| [libm::cos(deg.to_radians()), libm::sin(deg.to_radians())];
        let (middle_deg, half_deg) = (self.own_middle_deg(number), self.angle_deg() / 2.0);
        let ([rx, ry], [lx, ly]) = (at(middle_deg - half_deg), at(middle_deg + half_deg));
        [([ry, -rx], -self.land_m / 2.0), ([-ly, lx], -self.land_m / 2.0)]
    }

    /// Area of sector `number` without its lands, in square metres.
    pub fn area_m2(&self, number: usize) -> f64 {
        let [extent_x_m, extent_y_m] = self.specimen.outline.extents_m();
        let half_m = extent_x_m.hypot(extent_y_m);
        let all = vec![[-half_m, -half_m], [half_m, -half_m], [half_m, half_m], [-half_m, half_m]];
        let wedge = within(&self.sides(number), all);
        clip(wedge, &self.specimen.outline).iter().map(|part| area_m2(part)).sum()
    }

    /// Diameter of the largest circle on sector `number` with its centre on the middle line, in metres: the limit for a
    /// pin that slides on the sector.
    pub fn circle_m(&self, number: usize) -> f64 {
        let half_angle = (self.angle_deg() / 2.0).to_radians();
        let middle = self.own_middle_deg(number).to_radians();
        let [x, y] = [libm::cos(middle).abs(), libm::sin(middle).abs()];
        let [extent_x_m, extent_y_m] = self.specimen.outline.extents_m();
        // Radius of the largest circle about a point of the middle line at r: its smallest distance to lands, border
        // and hole.
        let radius_m = |r: f64| {
            let of_lands = r * libm::sin(half_angle) - self.land_m / 2.0;
            let of_rim = match self.specimen.outline {
                Outline::Rectangle { .. } => (extent_x_m / 2.0 - r * x).min(extent_y_m / 2.0 - r * y),
                Outline::Disc { diameter_m } | Outline::Ring { outer_diameter_m: diameter_m, .. } => {
                    diameter_m / 2.0 - r
                }
            };
            let hole_m = self.specimen.outline.hole_m() / 2.0;
            of_lands.min(of_rim).min(if hole_m > 0.0 { r - hole_m } else { f64::INFINITY })
        };
        // Concave in r, so that a ternary search finds the maximum.
        let (mut low, mut high) = (0.0, extent_x_m.hypot(extent_y_m) / 2.0);
        for _ in 0..STEPS {
            let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if radius_m(a) < radius_m(b) { low = a } else { high = b }
        }
        2.0 * radius_m(f64::midpoint(low, high)).max(0.0)
    }

    /// Whether all sectors are large enough for `pattern`: the largest circle holds [`MIN_PERIODS`] periods along each
    /// axis.
    pub fn holds(&self, pattern: &Pattern) -> bool {
        self.least_circle_m() >= MIN_PERIODS * period_m(pattern)
    }

    /// Smallest [`Self::circle_m`] of all sectors, in metres.
    pub fn least_circle_m(&self) -> f64 {
        (1..=self.count).map(|number| self.circle_m(number)).fold(f64::INFINITY, f64::min)
    }

    /// Corners of the mark that shows where sector 1 begins, on the land between the last sector and the first, in
    /// metres on the specimen, anticlockwise.
    pub fn mark_m(&self) -> [[f64; 2]; 4] {
        let angle = (self.middle_deg(1) - self.angle_deg() / 2.0).to_radians();
        let [cosine, sine] = [libm::cos(angle), libm::sin(angle)];
        let hole_m = self.specimen.outline.hole_m() / 2.0;
        let rim_m = self.specimen.outline.rim_m([cosine, sine]);
        let along_m = MARK_SPAN.map(|share| hole_m + share * (rim_m - hole_m));
        let half_m = MARK_SHARE * self.land_m / 2.0;
        [(0, -1.0), (1, -1.0), (1, 1.0), (0, 1.0)].map(|(end, side)| {
            let (along_m, across_m) = (along_m[end], side * half_m);
            [along_m * cosine - across_m * sine, along_m * sine + across_m * cosine]
        })
    }

    /// Lays out `patterns` on the sectors, in order.
    ///
    /// # Errors
    /// [`ExportError::Refused`] if the number of patterns differs from that of sectors, and for a pattern that is too
    /// coarse; [`ExportError`] if a pattern cannot be laid out on the specimen.
    pub fn lay(&self, patterns: &[Pattern]) -> Result<Vec<Sector>, ExportError> {
        if patterns.len() != self.count {
            return Err(wrong_count(patterns.len(), self.count));
        }
        patterns.iter().enumerate().map(|(place, pattern)| Sector::new(*self, place + 1, *pattern)).collect()
    }
}

impl Sector {
    fn new(division: Division, number: usize, pattern: Pattern) -> Result<Self, ExportError> {
        if !division.holds(&pattern) {
            let [circle_mm, period_um] = [division.least_circle_m(), 1e3 * period_m(&pattern)].map(mm);
            return Err(ExportError::Refused(format!(
                "sectors hold circles of {circle_mm} mm, fewer than {MIN_PERIODS} periods of {period_um} um: expected fewer sectors or a finer pattern"
            )));
        }
        let layout = division.specimen.layout(pattern)?;
        let sector = Self { division, number, layout, cavities: 0, cavity_area_m2: 0.0 };
        let (cavities, cavity_area_m2) =
            sector.own_boundaries().fold((0, 0.0), |(count, area_m2), own| (count + 1, area_m2 + own.area_m2()));
        Ok(Self { cavities, cavity_area_m2, ..sector })
    }

    /// Number of the sector, from 1.
    pub const fn number(&self) -> usize {
        self.number
    }

    /// Division that the sector belongs to.
    pub const fn division(&self) -> &Division {
        &self.division
    }

    /// Pattern of the sector.
    pub const fn pattern(&self) -> &Pattern {
        self.layout.pattern()
    }

    /// Layout of the pattern on the whole specimen.
    pub const fn whole(&self) -> &Layout {
        &self.layout
    }

    /// Number of cavities; each part of a cavity that is cut by border or land counts.
    pub const fn cavities(&self) -> usize {
        self.cavities
    }

    /// Area of the cavities, in square metres.
    pub const fn cavity_area_m2(&self) -> f64 {
        self.cavity_area_m2
    }

    /// Fraction of the sector without its lands that is cavity.
    pub fn areal_density(&self) -> f64 {
        self.cavity_area_m2 / self.division.area_m2(self.number)
    }

    /// Outlines of the cavities on the specimen. Grooves end at the lands; other cavities that reach into a land are
    /// left out. At the border, cavities are treated as for the whole specimen.
    pub fn boundaries(&self) -> impl Iterator<Item = Boundary> + '_ {
        let turn = self.division.turn_deg(self.number).to_radians();
        let [cosine, sine] = if turn == 0.0 { [1.0, 0.0] } else { [libm::cos(turn), libm::sin(turn)] };
        let turned = move |[x, y]: [f64; 2]| [x * cosine - y * sine, x * sine + y * cosine];
        self.own_boundaries().map(move |boundary| match boundary {
            Boundary::Circle { centre_m, radius_m } => Boundary::Circle { centre_m: turned(centre_m), radius_m },
            Boundary::Polygon { corners_m } => {
                Boundary::Polygon { corners_m: corners_m.into_iter().map(turned).collect() }
            }
        })
    }

    /// Outlines of the cavities in the axes of the pattern.
    fn own_boundaries(&self) -> impl Iterator<Item = Boundary> + '_ {
        let sides = self.division.sides(self.number);
        let slack_m = FIT_TOLERANCE * self.pattern().pitch_m();
        self.layout.iter().flat_map(move |cavity| {
            if cavity.planform == Planform::Groove {
                cut_boundaries(&cavity, &sides)
            } else {
                uncut_boundaries(&cavity, &sides, slack_m)
            }
        })
    }
}

/// Creates the error for `count` patterns on at most `most` sectors.
pub(crate) fn wrong_count(count: usize, most: usize) -> ExportError {
    let expected = format!("expected 2 to {most}, one for each sector");
    ExportError::Refused(format!("{count} textures on sectors of one specimen: {expected}"))
}

/// The longer period of `pattern`, in metres.
fn period_m(pattern: &Pattern) -> f64 {
    pattern.pitch_across_m().unwrap_or(0.0).max(pattern.pitch_m())
}

/// Part of a convex polygon between two lands, given by `sides` as in `Division::sides`.
fn within(sides: &[([f64; 2], f64); 2], polygon: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    sides.iter().fold(polygon, |left, &(normal, limit_m)| within_side(&left, normal, limit_m))
}

/// Parts of a groove between two lands. Parts of an uncrossed groove with less area than a square of its width are left
/// out.
fn cut_boundaries(cavity: &Cavity, sides: &[([f64; 2], f64); 2]) -> Vec<Boundary> {
    let corners = cavity.corners_m().to_vec();
    let parts = match &cavity.crossed_by {
        Some(crossing) => crossing.outside(corners),
        None => vec![corners],
    };
    let least_m2 = if cavity.crossed_by.is_some() { 0.0 } else { cavity.width_m * cavity.width_m };
    let cut = |part: Vec<[f64; 2]>| {
        let left = within(sides, part);
        match &cavity.cut_by {
            Some(outline) => clip(left, outline),
            None => without_slivers(vec![left]),
        }
    };
    let left = parts.into_iter().flat_map(cut).filter(|part| area_m2(part) >= least_m2);
    left.map(|corners_m| Boundary::Polygon { corners_m }).collect()
}

/// Outlines of a cavity, complete or cut at the border, if it reaches into neither land by more than `slack_m`;
/// otherwise empty.
fn uncut_boundaries(cavity: &Cavity, sides: &[([f64; 2], f64); 2], slack_m: f64) -> Vec<Boundary> {
    let boundaries = cavity.boundaries();
    let is_beside = |&([nx, ny], limit_m): &([f64; 2], f64)| {
        let reach_m = |[x, y]: &[f64; 2]| x * nx + y * ny - limit_m;
        boundaries.iter().all(|boundary| match boundary {
            Boundary::Circle { centre_m, radius_m } => reach_m(centre_m) + radius_m <= slack_m,
            other => other.polygon_m().iter().all(|corner| reach_m(corner) <= slack_m),
        })
    };
    if sides.iter().all(is_beside) { boundaries } else { Vec::new() }
}

#[cfg(test)]
mod tests;
