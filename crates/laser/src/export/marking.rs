//! Lines that the spot follows.
//!
//! A hatch fills a cavity with lines along its longer side (along the pattern's x axis for equal sides), in alternating
//! directions. A mask needs only the contour. Each line stands for a strip as wide as the distance of lines, and the
//! strips fill the cavity, so that the depth is the area of the spot inside the cavity: half of that in the middle falls
//! on straight walls at the ends of lines, which end on the contour. Beside the outermost lines, e inside a wall, that
//! holds for
//!
//! ```text
//! sum of c(e + k h) = 1/2 mean of sum over lines of c(x - x_k), x in the middle third      k = 0, 1, 2, ...
//! c(x) = 2 sqrt((s/2)^2 - x^2)      s: spot diameter, h: distance of lines
//! ```
//!
//! and beside a round cavity of radius R if lines end on a circle of radius R + s^2 / (24 R) (first order in s/R). Where
//! grooves cross, the lines of the second family end where the strips of the first do, e - h/2 inside the walls, so that
//! the strips of both fill the crossing. Lines stay half a spot inside the border of the specimen.

use std::f64::consts::FRAC_PI_2;

use slipgrid_base::statistics::extremes;
use slipgrid_model::pattern::Contour;
use slipgrid_model::pattern::geometry::edges;

use crate::export::crossing::Crossing;
use crate::export::{Cavity, ExportError, Exposure, Laser, Layout, Outline};

/// A straight path of the spot's centre, from start to end, in metres.
pub type Line = [[f64; 2]; 2];

/// Settings for marking cavities: exposure, radius of the spot and distance between lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marking {
    exposure: Exposure,
    /// Radius of the spot, in metres; 0 for a mask.
    pub(crate) half_spot_m: f64,
    distance_m: f64,
    /// Distance between pulses along a line, in metres; 0 if unknown.
    pulse_m: f64,
}

/// Marking of the cavities of one layout.
pub(crate) struct Hatch {
    marking: Marking,
    /// Where the centre of the spot may be; `None` on a face smaller than the spot.
    face: Option<Outline>,
    /// Lesser extent of the first cavity, and the distance of the outermost lines from walls so far apart, in metres.
    wall_inset_m: [f64; 2],
}

/// Rounding tolerance of the number of line distances that fit across a cavity.
const ROUNDING: f64 = 1e-6;
/// Minimum length of an edge, relative to the extent of its polygon along the lines, for a straight side; shorter edges
/// may be chords of an arc.
const MIN_SIDE_RATIO: f64 = 0.25;
/// Number of bisections for the place of the outermost lines, to 1e-12 of the spot.
const BISECTIONS: u32 = 40;

impl Marking {
    /// Creates the marking for `laser`.
    ///
    /// # Errors
    /// [`ExportError::Refused`] for a hatch without a spot diameter; errors of [`Laser::validate`].
    pub fn new(laser: &Laser) -> Result<Self, ExportError> {
        laser.validate()?;
        let exposure = laser.exposure.unwrap_or_default();
        let (half_spot_m, distance_m) = match (exposure, laser.spot_um.zip(laser.line_distance_um())) {
            (Exposure::Mask, _) => (0.0, 0.0),
            (Exposure::Hatch, Some((spot_um, distance_um))) => (spot_um * 0.5e-6, distance_um * 1e-6),
            (Exposure::Hatch, None) => return Err(ExportError::Refused("hatching needs laser.spot_um".to_owned())),
        };
        let pulse_m = laser.pulse_distance_um().map_or(0.0, |pulse_um| pulse_um * 1e-6);
        Ok(Self { exposure, half_spot_m, distance_m, pulse_m })
    }

    /// Creates the marking for a file of lines that a spot follows; `what` names the file in the error.
    ///
    /// # Errors
    /// [`ExportError::Refused`] for a mask, whose contours would be marked as lines; errors of [`Self::new`].
    pub fn of_lines(laser: &Laser, what: &str) -> Result<Self, ExportError> {
        let marking = Self::new(laser)?;
        if !laser.is_mask() {
            return Ok(marking);
        }
        Err(ExportError::Refused(format!(
            "{what} holds the lines of a spot, but a mask exposes whole cavities and follows none (laser.exposure = \"mask\"): \
             expected --format dxf, plt or corners for the contours, or csv for the places of cavities"
        )))
    }

    /// Marking of the cavities of `layout`.
    pub(crate) fn on(&self, layout: &Layout) -> Hatch {
        let width_m = layout.iter().next().map_or(0.0, |cavity| cavity.width_m.min(cavity.length_m));
        self.on_face(layout.outline(), width_m)
    }

    /// Marking of cavities of `width_m` on a specimen with the border `outline`.
    pub(crate) fn on_face(&self, outline: &Outline, width_m: f64) -> Hatch {
        let face = outline.inset(self.half_spot_m);
        Hatch { marking: *self, face, wall_inset_m: [width_m, self.wall_inset_m(width_m)] }
    }

    /// Direction of the lines in a cavity, as a unit vector in the specimen's axes.
    pub fn direction(&self, cavity: &Cavity) -> [f64; 2] {
        let [cosine, sine] = cavity.orientation;
        if cavity.length_m > cavity.width_m { [-sine, cosine] } else { [cosine, sine] }
    }

    /// Distance of the outermost lines from the walls of a cavity of `width_m`, in metres, so that half of the depth in
    /// its middle third falls on the walls. The fewest lines are taken that are at most the nominal distance apart.
    fn wall_inset_m(&self, width_m: f64) -> f64 {
        let (half_spot_m, most_m) = (self.half_spot_m, self.half_spot_m.min(width_m / 2.0));
        if self.exposure == Exposure::Mask || width_m <= 0.0 {
            return most_m;
        }
        // Integral of c from 0 to x; lines that do not reach x with the spot need no arcsine.
        let area_m2 = |x_m: f64| {
            let share = if x_m.abs() < half_spot_m { libm::asin(x_m / half_spot_m) } else { FRAC_PI_2.copysign(x_m) };
            x_m * ((half_spot_m - x_m) * (half_spot_m + x_m)).max(0.0).sqrt() + half_spot_m * half_spot_m * share
        };
        let is_deep_at_walls = |inset_m: f64, gaps: f64| {
            let apart_m = (width_m - 2.0 * inset_m) / gaps;
            let (mut wall_m, mut middle_m2) = (0.0, 0.0);
            for line in 0..=gaps as u64 {
                let at_m = inset_m + line as f64 * apart_m;
                wall_m += 2.0 * ((half_spot_m - at_m) * (half_spot_m + at_m)).max(0.0).sqrt();
                // Lines are symmetric about the middle.
                middle_m2 += 2.0 * area_m2(2.0 / 3.0 * width_m - at_m);
            }
            wall_m > 0.5 * middle_m2 / (width_m / 3.0)
        };
        let mut gaps = ((width_m - 2.0 * most_m) / self.distance_m - ROUNDING).ceil().max(1.0);
        loop {
            let (mut low_m, mut high_m) = (0.0, most_m);
            for _ in 0..BISECTIONS {
                let inset_m = f64::midpoint(low_m, high_m);
                *(if is_deep_at_walls(inset_m, gaps) { &mut low_m } else { &mut high_m }) = inset_m;
            }
            // Holds at the latest for the lines that fill the whole width.
            if width_m - 2.0 * high_m <= gaps * self.distance_m * (1.0 + ROUNDING) {
                return high_m;
            }
            // More lines lie nearer to the walls, so that fewer than these do not do.
            gaps = ((width_m - 2.0 * high_m) / self.distance_m - ROUNDING).ceil().max(gaps + 1.0);
        }
    }
}

impl Hatch {
    /// Lines of a cavity in marking order; empty if the cavity is smaller than the spot. For a mask, the edges of the
    /// cavity.
    pub(crate) fn lines(&self, cavity: &Cavity) -> Vec<Line> {
        self.fill(cavity).0
    }

    /// Returns the lines of a cavity, and the distance between neighbouring lines if it has several, in metres. The
    /// distance is at most the nominal one; a mask has none.
    pub(crate) fn fill(&self, cavity: &Cavity) -> (Vec<Line>, Option<f64>) {
        let marking = &self.marking;
        if marking.exposure == Exposure::Mask {
            let boundaries = cavity.boundaries().into_iter().map(|boundary| boundary.polygon_m());
            let contours =
                boundaries.flat_map(|polygon| edges(&polygon).map(|(from, to)| [from, to]).collect::<Vec<_>>());
            return (contours.collect(), None);
        }
        let least_m = cavity.width_m.min(cavity.length_m);
        let is_wide = least_m >= 2.0 * marking.half_spot_m * (1.0 - ROUNDING);
        let Some(face) = self.face.filter(|_| is_wide) else { return (Vec::new(), None) };
        let along = marking.direction(cavity);
        let [dx, dy] = along;
        // The extent across the lines, and whether the cavity ends in a side along them.
        let centre_m = cavity.centre_y_m * dx - cavity.centre_x_m * dy;
        let (mut cavity, half_m, mut has_side) = (*cavity, least_m / 2.0, [true; 2]);
        let mut extent_m = [centre_m - half_m, centre_m + half_m];
        if let Some(outline) = &cavity.face {
            let corners = outline.corners_m();
            let turned: Vec<[f64; 2]> = corners.iter().map(|[x, y]| [x * dx + y * dy, y * dx - x * dy]).collect();
            let [left_m, right_m] = extremes(turned.iter().map(|point| point[0]));
            extent_m = extremes(turned.iter().map(|point| point[1]));
            has_side = extent_m.map(|end_m| {
                let is_at_end = |v: f64| (v - end_m).abs() <= ROUNDING * half_m;
                let is_long = |length_m: f64| length_m.abs() >= MIN_SIDE_RATIO * (right_m - left_m);
                edges(&turned).any(|([u0, v0], [u1, v1])| is_at_end(v0) && is_at_end(v1) && is_long(u1 - u0))
            });
        } else if cavity.planform.contour() == Contour::Circle {
            let grown_m = marking.half_spot_m * marking.half_spot_m / (6.0 * half_m);
            cavity.width_m += 2.0 * grown_m;
            (extent_m, has_side) = ([extent_m[0] - grown_m, extent_m[1] + grown_m], [false; 2]);
        }
        let side_m = match self.wall_inset_m {
            [width_m, inset_m] if width_m == least_m => inset_m,
            _ => marking.wall_inset_m(least_m),
        };
        // At an end without a side, a line is half a distance from the outermost point, where it would have no length.
        let sides = has_side.map(|has_side| if has_side { side_m } else { 0.0 });
        let halves: f64 = has_side.map(|has_side| if has_side { 0.0 } else { 0.5 }).iter().sum();
        let across_m = (extent_m[1] - extent_m[0] - sides[0] - sides[1]).max(0.0);
        let gaps = (across_m / marking.distance_m - halves - ROUNDING).ceil().max(0.0);
        let apart_m = if gaps + halves > 0.0 { across_m / (gaps + halves) } else { 0.0 };
        let first_m = extent_m[0] + if has_side[0] { side_m } else { 0.5 * apart_m };
        // The strips of the first of two families, as wide and as far apart, end where lines of the second do.
        let crossing = cavity.crossed_by;
        let crossing = crossing.map(|of| Crossing { grown_m: of.grown_m + 0.5 * apart_m - side_m, ..of });
        let mut lines = Vec::new();
        // Bounded by the size of the cavity over the line distance, so that the cast is exact.
        for line in 0..=gaps as u64 {
            let at_m = first_m + line as f64 * apart_m;
            let (spans_m, first) = (cavity.spans_m(along, at_m), lines.len());
            let point = |along_m: f64| [along_m * dx - at_m * dy, along_m * dy + at_m * dx];
            for [low_m, high_m] in face.chords_along_m(along, at_m) {
                let inside = spans_m.iter().map(|[from_m, to_m]| [from_m.max(low_m), to_m.min(high_m)]);
                let whole = inside.filter(|[from_m, to_m]| to_m > from_m).map(|ends_m| ends_m.map(point));
                // A part between two pulses would get none or one.
                let holds = |part: &Line| length_m(part) > marking.pulse_m * (1.0 - ROUNDING);
                match &crossing {
                    None => lines.extend(whole.filter(holds)),
                    Some(of) => lines.extend(whole.flat_map(|line| of.parts_of(line)).filter(holds)),
                }
            }
            if line % 2 == 1 {
                lines[first..].reverse();
                lines[first..].iter_mut().for_each(|part| part.reverse());
            }
        }
        (lines, (gaps > 0.0).then_some(apart_m))
    }
}

/// Length of a line, in metres.
pub(crate) fn length_m([[x0, y0], [x1, y1]]: &Line) -> f64 {
    (x1 - x0).hypot(y1 - y0)
}

#[cfg(test)]
mod made_tests;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::layout::every_kind;
    use crate::export::{Layout, Outline};
    use slipgrid_model::pattern::{Pattern, Planform, Polygon, Texture};

    fn laser() -> Laser {
        Laser { spot_um: Some(23.0), hatch_um: Some(15.0), ..Laser::default() }
    }

    /// Lines of the first of the cavities of 130 um.
    fn first(planform: Planform, laser: &Laser) -> Vec<Line> {
        let pattern = Pattern::new(planform, 130e-6, 370e-6, 5e-6).unwrap();
        let layout = Layout::new(pattern, Outline::Rectangle { length_m: 1e-3, width_m: 2e-3 }).unwrap();
        Marking::new(laser).unwrap().on(&layout).lines(&layout.iter().next().unwrap())
    }

    #[test]
    fn a_square_is_filled_from_edge_to_edge() {
        let lines = first(Planform::Square, &laser());
        // Lines end on the edge. Eight gaps of 14.057 um, 8.773 um from the edges, where the outermost line alone is
        // 2 sqrt(11.5^2 - 8.773^2) = 14.87 um within the spot, half of 29.74 um in the middle third.
        assert_eq!(lines.len(), 9);
        assert!(lines.iter().all(|line| (length_m(line) - 130e-6).abs() < 1e-12));
        let apart_m = lines[1][0][1] - lines[0][0][1];
        assert!((apart_m - 14.0567e-6).abs() < 1e-9, "{apart_m}");
        assert!(lines.windows(2).all(|pair| (pair[1][0][1] - pair[0][0][1] - apart_m).abs() < 1e-12));
        // Alternating directions: the next line starts where this one ends.
        assert!(lines.windows(2).all(|pair| (pair[1][0][0] - pair[0][1][0]).abs() < 1e-12));
        // A single line would be 0.87 spots wide at half depth.
        let spot = |spot_um: f64| Laser { spot_um: Some(spot_um), hatch_um: None, ..laser() };
        assert_eq!(first(Planform::Square, &spot(130.0)).len(), 2);
        assert!(first(Planform::Square, &spot(131.0)).is_empty());
    }

    /// A groove that ends at the border of a disc is as wide as a complete one.
    #[test]
    fn a_clipped_groove_is_filled_from_edge_to_edge() {
        let pattern = Pattern::new(Planform::Groove, 130e-6, 370e-6, 5e-6).unwrap();
        let layout = Layout::clipped(pattern, Outline::Disc { diameter_m: 5e-3 }).unwrap();
        let middle = layout.iter().min_by(|a, b| a.centre_x_m.abs().total_cmp(&b.centre_x_m.abs())).unwrap();
        let (lines, apart_m) = Marking::new(&laser()).unwrap().on(&layout).fill(&middle);
        let mut across: Vec<f64> = lines.iter().map(|line| line[0][0] - middle.centre_x_m).collect();
        across.sort_by(f64::total_cmp);
        assert_eq!(across.len(), 9);
        assert!((across[1] - across[0] - apart_m.unwrap()).abs() < 1e-12);
        // As in a square.
        let square = first(Planform::Square, &laser());
        assert!((across[8] - across[0] - (square[8][0][1] - square[0][0][1])).abs() < 1e-12, "{across:?}");
        assert!((across[0] + across[8]).abs() < 1e-12 && lines.iter().all(|line| length_m(line) > 4.9e-3));
    }

    /// A hole cuts lines of the middle groove into two pieces, which are marked one after the other, as one line would be.
    #[test]
    fn pieces_of_a_line_have_one_direction_and_hold_a_pulse() {
        let pattern = Pattern::new(Planform::Groove, 130e-6, 370e-6, 5e-6).unwrap();
        let outline = Outline::Ring { outer_diameter_m: 4e-3, inner_diameter_m: 1.3e-3 };
        let layout = Layout::clipped(pattern, outline).unwrap();
        let middle = layout.iter().find(|cavity| cavity.centre_x_m.abs() < 1e-9).unwrap();
        let lines = Marking::new(&laser()).unwrap().on(&layout).lines(&middle);
        assert_eq!(lines.len(), 18);
        for (line, pieces) in lines.chunks(2).enumerate() {
            let forth = if line % 2 == 0 { 1.0 } else { -1.0 };
            let ends: Vec<f64> = pieces.iter().flatten().map(|[_, y]| forth * y).collect();
            assert!(ends.is_sorted() && (pieces[0][0][0] - pieces[1][1][0]).abs() < 1e-12, "{line}: {pieces:?}");
        }
        // Near the rim, discs are cut to chords of all lengths.
        let discs = Pattern::new(Planform::Disc, 130e-6, 70e-6, 5e-6).unwrap();
        let layout = Layout::clipped(discs, Outline::Disc { diameter_m: 4e-3 }).unwrap();
        let shortest_m = |laser: &Laser| {
            let hatch = Marking::new(laser).unwrap().on(&layout);
            layout.iter().flat_map(|disc| hatch.lines(&disc)).map(|line| length_m(&line)).fold(f64::INFINITY, f64::min)
        };
        assert!(shortest_m(&laser()) < 10e-6);
        let pulsed = Laser { speed_mm_s: Some(10.0), repetition_hz: Some(1e3), ..laser() };
        assert!(shortest_m(&pulsed) > 9.99e-6);
    }

    #[test]
    fn lines_stay_inside_every_kind_of_cavity_and_the_spot_on_the_face() {
        let marking = Marking::new(&laser()).unwrap();
        let half_m = 11.5e-6;
        for texture in every_kind() {
            let pattern = Pattern::new(texture, 131.2e-6, 370e-6, 5e-6).unwrap();
            for outline in [
                Outline::Disc { diameter_m: 4e-3 },
                Outline::Rectangle { length_m: 3e-3, width_m: 2e-3 },
                Outline::Ring { outer_diameter_m: 4e-3, inner_diameter_m: 1.3e-3 },
            ] {
                let inner = outline.inset(half_m - 1e-12).unwrap();
                for layout in [Layout::new, Layout::clipped].map(|layout| layout(pattern, outline).unwrap()) {
                    let hatch = marking.on(&layout);
                    for cavity in layout.iter() {
                        let (lines, apart_m) = hatch.fill(&cavity);
                        let points = || lines.iter().flatten();
                        assert!(points().all(|point| inner.contains(*point)), "{cavity:?}");
                        let walls = points().map(|point| Cavity { cut_by: None, ..cavity }.wall_distance_m(*point));
                        let nearest_m = walls.fold(f64::INFINITY, f64::min);
                        // Round cavities are grown by s^2 / (24 R) = 0.34 um.
                        assert!(nearest_m > -0.34e-6, "{cavity:?}: {nearest_m}");
                        assert!(apart_m.is_none_or(|apart_m| apart_m < 15e-6 * (1.0 + ROUNDING)));
                        // Strips around the lines fill the cavity, except for half a spot at the specimen's border.
                        let (swept_m, area_m2) = (lines.iter().map(length_m).sum::<f64>(), cavity.area_m2());
                        let share = swept_m * apart_m.unwrap_or(15e-6) / area_m2;
                        let is_at_border = cavity.cut_by.is_some() || cavity.length_m > 1e-3;
                        assert!(share < 1.05 && (is_at_border || share > 0.9), "{cavity:?}: {share}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_square_given_as_a_polygon_is_filled_like_the_square() {
        let outline = Polygon::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let texture = Texture::new(Planform::Polygon).with_outline(outline).unwrap();
        for outline in [Outline::Disc { diameter_m: 3e-3 }, Outline::Rectangle { length_m: 2e-3, width_m: 3e-3 }] {
            let laid =
                |texture: Texture| Layout::new(Pattern::new(texture, 130e-6, 370e-6, 5e-6).unwrap(), outline).unwrap();
            let (squares, polygons) = (laid(Planform::Square.into()), laid(texture));
            assert_eq!(squares.cavities(), polygons.cavities());
            let hatches = [&squares, &polygons].map(|layout| Marking::new(&laser()).unwrap().on(layout));
            for (square, polygon) in squares.iter().zip(polygons.iter()) {
                let lines =
                    [hatches[0].lines(&square), hatches[1].lines(&polygon)].map(|lines| lines.concat().concat());
                assert_eq!(lines[0].len(), lines[1].len());
                assert!(lines[0].iter().zip(&lines[1]).all(|(a, b)| (a - b).abs() < 1e-12));
            }
        }
    }

    #[test]
    fn crossings_are_marked_by_one_family_alone() {
        let marking = Marking::new(&laser()).unwrap();
        for (crossing_deg, outline) in [
            (90.0, Outline::Disc { diameter_m: 4e-3 }),
            (50.0, Outline::Rectangle { length_m: 3e-3, width_m: 2e-3 }),
            (50.0, Outline::Ring { outer_diameter_m: 4e-3, inner_diameter_m: 1.3e-3 }),
        ] {
            let texture = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(crossing_deg).unwrap();
            let pattern = Pattern::new(texture.with_groove_angle_deg(10.0).unwrap(), 130e-6, 270e-6, 5e-6).unwrap();
            for layout in [Layout::new, Layout::clipped] {
                let layout = layout(pattern, outline).unwrap();
                let (first, second): (Vec<Cavity>, Vec<Cavity>) =
                    layout.iter().partition(|cavity| cavity.crossed_by.is_none());
                assert!(first.len() > 3 && second.len() > 3);
                // The ends and the middle of each line of the second family lie off all strips of the first, which end
                // 8.773 - 14.057 / 2 um inside the walls.
                let hatch = marking.on(&layout);
                let points = second
                    .iter()
                    .flat_map(|groove| hatch.lines(groove))
                    .flat_map(|[from, to]| [from, to, [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])]]);
                for point in points {
                    let inside_m = first.iter().map(|groove| Cavity { cut_by: None, ..*groove }.wall_distance_m(point));
                    assert!(inside_m.fold(f64::NEG_INFINITY, f64::max) < 1.7451e-6, "{point:?}");
                }
                // The areas add up to the area from sampled points, and are close to that of the pattern if nothing is
                // left out.
                let grooves = [first.as_slice(), &second].concat();
                let inside = |point: [f64; 2]| grooves.iter().any(|groove| groove.wall_distance_m(point) >= 0.0);
                let [extent_x_m, extent_y_m] = outline.extents_m();
                let at = |k: i32, extent_m: f64| (f64::from(k) + 0.5) / 150.0 * extent_m - extent_m / 2.0;
                let points = (0..150).flat_map(|i| (0..150).map(move |j| [at(i, extent_x_m), at(j, extent_y_m)]));
                let counted = points.filter(|point| outline.contains(*point) && inside(*point)).count();
                let counted_m2 = counted as f64 / 22500.0 * extent_x_m * extent_y_m;
                assert!((layout.cavity_area_m2() / counted_m2 - 1.0).abs() < 0.02, "{counted_m2}");
                if layout.specimen().is_clipped {
                    assert!((layout.areal_density() / pattern.areal_density() - 1.0).abs() < 0.05);
                }
            }
        }
    }

    #[test]
    fn a_mask_needs_the_contour_alone() {
        let laser_of_mask = Laser { exposure: Some(Exposure::Mask), spot_um: None, hatch_um: None, ..laser() };
        let lines = first(Planform::Square, &laser_of_mask);
        assert_eq!(lines.len(), 4);
        assert!(lines.iter().all(|line| (length_m(line) - 130e-6).abs() < 1e-12));
        // Marked as lines, contours would be walls, so that no file of lines holds them.
        let mask = Laser { exposure: Some(Exposure::Mask), ..laser() };
        let refused = Marking::of_lines(&mask, "hatch.csv").unwrap_err();
        assert!(refused.to_string().starts_with("hatch.csv holds the lines of a spot, but a mask"), "{refused}");
        assert!(Marking::of_lines(&laser(), "hatch.csv").is_ok());
    }

    #[test]
    fn lines_that_do_not_meet_are_refused_with_the_limit() {
        let refused = |laser: Laser| Marking::new(&laser).unwrap_err().to_string();
        assert!(
            refused(Laser { hatch_um: Some(30.0), ..laser() }).contains("hatch_um of 30 um is above spot_um, 23 um")
        );
        let fast = Laser { speed_mm_s: Some(100.0), repetition_hz: Some(1000.0), ..laser() };
        assert!(refused(fast).contains("pulses lie 100 um apart, speed_mm_s = 100 over repetition_hz = 1000"));
        assert!(refused(Laser { spot_um: None, ..laser() }).contains("laser.spot_um"));
        assert!(refused(Laser { wall_taper_deg: Some(90.0), ..laser() }).contains("80"));
    }
}
