//! Lines that the spot follows.
//!
//! A hatch fills a cavity with lines along its longer side (along the pattern's x axis for equal sides), in alternating
//! directions. The edge of the spot, not its centre, reaches the edge of the cavity, so that lines lie half a spot
//! inside. A mask needs only the contour. Where grooves cross, lines of the second family end at a distance d before
//! the walls of the first, at which the round ends of neighbouring lines meet and no wall remains between them:
//!
//! ```text
//! d = sqrt((s/2)^2 - (h / (2 sin a))^2)      s: spot diameter, h: distance of lines, a: angle of the families
//! ```

use slipgrid_base::statistics::extremes;
use slipgrid_model::pattern::geometry::edges;

use crate::export::crossing::Crossing;
use crate::export::{Boundary, Cavity, ExportError, Exposure, Laser};

/// A straight path of the spot's centre, from start to end, in metres.
pub type Line = [[f64; 2]; 2];

/// Settings for marking cavities: exposure, radius of the spot and distance between lines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marking {
    exposure: Exposure,
    /// Radius of the spot, in metres, by which lines lie inside the edge of a cavity; 0 for a mask.
    inset_m: f64,
    distance_m: f64,
}

/// Rounding tolerance of the number of line distances that fit across a cavity.
const ROUNDING: f64 = 1e-6;
/// Minimum length of an edge, relative to the extent of its polygon along the lines, for a straight side; shorter edges
/// may be chords of an arc.
const MIN_SIDE_RATIO: f64 = 0.25;

impl Marking {
    /// Creates the marking for `laser`.
    ///
    /// # Errors
    /// [`ExportError::Refused`] for a hatch without a spot diameter; errors of [`Laser::validate`].
    pub fn new(laser: &Laser) -> Result<Self, ExportError> {
        laser.validate()?;
        let exposure = laser.exposure.unwrap_or_default();
        let (inset_m, distance_m) = match (exposure, laser.spot_um.zip(laser.line_distance_um())) {
            (Exposure::Mask, _) => (0.0, 0.0),
            (Exposure::Hatch, Some((spot_um, distance_um))) => (spot_um * 0.5e-6, distance_um * 1e-6),
            (Exposure::Hatch, None) => return Err(ExportError::Refused("hatching needs laser.spot_um".to_owned())),
        };
        Ok(Self { exposure, inset_m, distance_m })
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

    /// Distance of the spot's centre from a cavity's edge, in metres.
    pub const fn spot_compensation_m(&self) -> f64 {
        self.inset_m
    }

    /// Direction of the lines in a cavity, as a unit vector in the specimen's axes.
    pub fn direction(&self, cavity: &Cavity) -> [f64; 2] {
        let [cosine, sine] = cavity.orientation;
        if cavity.length_m > cavity.width_m { [-sine, cosine] } else { [cosine, sine] }
    }

    /// Lines of a cavity in marking order; empty if the cavity is smaller than the spot. For a mask, the edges of the
    /// cavity.
    pub fn lines(&self, cavity: &Cavity) -> Vec<Line> {
        self.fill(cavity).0
    }

    /// Returns the lines of a cavity, and the distance between neighbouring lines in each part of the cavity that has
    /// several lines, in metres. Distances are at most the nominal one; a mask has none.
    pub(crate) fn fill(&self, cavity: &Cavity) -> (Vec<Line>, Vec<f64>) {
        if self.exposure == Exposure::Mask {
            let boundaries = cavity.boundaries().into_iter().map(|boundary| boundary.polygon_m());
            let contours =
                boundaries.flat_map(|polygon| edges(&polygon).map(|(from, to)| [from, to]).collect::<Vec<_>>());
            return (contours.collect(), Vec::new());
        }
        let Some(inner) = cavity.inset(self.inset_m, self.inset_m) else { return (Vec::new(), Vec::new()) };
        let direction = self.direction(cavity);
        let (mut lines, mut apart_m) = (Vec::new(), Vec::new());
        let keep_off = |crossing: Crossing| {
            let grown_m = crossing.grown_m + self.end_before_m(cavity, &crossing);
            Crossing { grown_m, ..crossing }
        };
        let inner = Cavity { crossed_by: cavity.crossed_by.map(keep_off), ..inner };
        if inner.face.is_some() {
            apart_m.extend(self.hatch_face(&inner, direction, &mut lines));
        } else if let (Some(crossing), None) = (&inner.crossed_by, &inner.cut_by) {
            apart_m.extend(self.hatch_rectangle(&inner, direction, &mut lines));
            lines = lines.into_iter().flat_map(|line| crossing.parts_of(line)).collect();
        } else if inner.is_rectangle() {
            apart_m.extend(self.hatch_rectangle(&inner, direction, &mut lines));
        } else {
            let part = |part: Boundary| self.hatch_polygon(&part.polygon_m(), direction, &mut lines);
            apart_m.extend(inner.boundaries().into_iter().filter_map(part));
        }
        for line in lines.iter_mut().skip(1).step_by(2) {
            line.reverse();
        }
        (lines, apart_m)
    }

    /// Distance, in metres, at which the lines of `cavity` end before the walls of the crossing grooves.
    fn end_before_m(&self, cavity: &Cavity, crossing: &Crossing) -> f64 {
        let [[cosine, sine], [x, y]] = [cavity.orientation, crossing.grooves.pattern().texture().orientation()];
        let half_apart_m = 0.5 * self.distance_m / (cosine * y - sine * x).abs();
        // d = sqrt((s/2)^2 - (h / (2 sin a))^2)
        ((self.inset_m - half_apart_m) * (self.inset_m + half_apart_m)).max(0.0).sqrt()
    }

    /// Positions of evenly spaced lines over an extent of `across_m`, including both ends, as fractions of it; the
    /// middle for a single line. Also returns the distance between lines, in metres, if there are several.
    fn evenly(&self, across_m: f64) -> (impl Iterator<Item = f64>, Option<f64>) {
        let gaps = (across_m / self.distance_m - ROUNDING).ceil().max(0.0);
        // Bounded by the size of the cavity over the line distance, so that the cast is exact.
        let shares = (0..=gaps as u64).map(move |line| if gaps > 0.0 { line as f64 / gaps } else { 0.5 });
        (shares, (gaps > 0.0).then(|| across_m / gaps))
    }

    /// Fills a polygonal cavity with evenly spaced lines along `[dx, dy]`, including both outermost positions of the
    /// spot, where the spot fits inside the walls and on the specimen. Returns the distance between lines, in metres,
    /// if there are several.
    fn hatch_face(&self, inner: &Cavity, [dx, dy]: [f64; 2], lines: &mut Vec<Line>) -> Option<f64> {
        let face = inner.face.as_ref()?;
        let across = face.corners_m().into_iter().map(|[x, y]| y * dx - x * dy);
        let [low_m, high_m] = extremes(across);
        let (low_m, across_m) = (low_m + face.inset_m, high_m - low_m - 2.0 * face.inset_m);
        let (shares, apart_m) = self.evenly(across_m);
        for share in shares {
            let at_m = low_m + across_m * share;
            let mut spans_m = face.spans_m([dx, dy], at_m);
            if let Some(outline) = &inner.cut_by {
                let both = |[from_m, to_m]: [f64; 2], [low_m, high_m]: [f64; 2]| [from_m.max(low_m), to_m.min(high_m)];
                let on_face = outline.chords_along_m([dx, dy], at_m).into_iter();
                let parts = on_face.flat_map(|chord_m| spans_m.iter().map(move |span_m| both(*span_m, chord_m)));
                spans_m = parts.filter(|[from_m, to_m]| to_m > from_m).collect();
            }
            let point = |along_m: f64| [along_m * dx - at_m * dy, along_m * dy + at_m * dx];
            lines.extend(spans_m.into_iter().map(|ends_m| ends_m.map(point)));
        }
        apart_m
    }

    /// Fills a rectangle with evenly spaced lines along `[dx, dy]`, from one edge to the other, including both. Returns
    /// the distance between lines, in metres, if there are several.
    fn hatch_rectangle(&self, inner: &Cavity, [dx, dy]: [f64; 2], lines: &mut Vec<Line>) -> Option<f64> {
        let (along_m, across_m) = (inner.length_m.max(inner.width_m), inner.length_m.min(inner.width_m));
        let (shares, apart_m) = self.evenly(across_m);
        lines.extend(shares.map(|share| {
            let offset_m = across_m * (share - 0.5);
            [-along_m / 2.0, along_m / 2.0].map(|half_m| {
                [inner.centre_x_m + half_m * dx - offset_m * dy, inner.centre_y_m + half_m * dy + offset_m * dx]
            })
        }));
        apart_m
    }

    /// Fills a polygon with evenly spaced lines along `[dx, dy]`. The first line lies on the outermost edge if this
    /// edge runs along the lines, as in clipped grooves, and otherwise half a line distance from the outermost point,
    /// where a line would have no length. Returns the distance between lines, in metres, if there are several.
    fn hatch_polygon(&self, polygon: &[[f64; 2]], [dx, dy]: [f64; 2], lines: &mut Vec<Line>) -> Option<f64> {
        let turned: Vec<[f64; 2]> = polygon.iter().map(|[x, y]| [x * dx + y * dy, y * dx - x * dy]).collect();
        let [[left_m, right_m], [low_m, high_m]] = [0, 1].map(|axis| extremes(turned.iter().map(|point| point[axis])));
        let range_m = high_m - low_m;
        if range_m <= 0.0 {
            return None;
        }
        let rounding_m = range_m * 1e-9;
        // Half a distance if the polygon ends in a point or an arc.
        let short_of = |end_m: f64| {
            let is_edge = |([u0, v0], [u1, v1]): ([f64; 2], [f64; 2])| {
                let is_at_end = (v0 - end_m).abs() <= rounding_m && (v1 - end_m).abs() <= rounding_m;
                is_at_end && (u1 - u0).abs() >= MIN_SIDE_RATIO * (right_m - left_m)
            };
            if edges(&turned).any(is_edge) { 0.0 } else { 0.5 }
        };
        let (below, above) = (short_of(low_m), short_of(high_m));
        // n - 1 distances between n lines, plus the distances of the first and last line from the ends.
        let between = (range_m / self.distance_m - below - above - ROUNDING).ceil().max(0.0);
        let distances = between + below + above;
        for line in 0..=between as u64 {
            let share = if distances > 0.0 { (line as f64 + below) / distances } else { 0.5 };
            let at_m = (low_m + range_m * share).clamp(low_m + rounding_m, high_m - rounding_m);
            let mut ends_m: Vec<f64> = edges(&turned)
                .filter(|([_, from], [_, to])| (*from <= at_m) != (*to <= at_m))
                .map(|([u0, v0], [u1, v1])| u0 + (at_m - v0) / (v1 - v0) * (u1 - u0))
                .collect();
            ends_m.sort_by(f64::total_cmp);
            let back = |along_m: f64| [along_m * dx - at_m * dy, along_m * dy + at_m * dx];
            lines.extend(ends_m.chunks_exact(2).map(|ends| [back(ends[0]), back(ends[1])]));
        }
        (between > 0.0).then(|| range_m / distances)
    }
}

/// Length of a line, in metres.
pub(crate) fn length_m([[x0, y0], [x1, y1]]: &Line) -> f64 {
    (x1 - x0).hypot(y1 - y0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::layout::every_kind;
    use crate::export::{Layout, Outline};
    use slipgrid_model::pattern::geometry::point_to_segment;
    use slipgrid_model::pattern::{Pattern, Planform, Polygon, Texture};

    fn laser() -> Laser {
        Laser { spot_um: Some(23.0), hatch_um: Some(15.0), ..Laser::default() }
    }

    fn first(planform: Planform) -> Cavity {
        let pattern = Pattern::new(planform, 130e-6, 370e-6, 5e-6).unwrap();
        let outline = Outline::Rectangle { length_m: 1e-3, width_m: 2e-3 };
        Layout::new(pattern, outline).unwrap().iter().next().unwrap()
    }

    #[test]
    fn a_square_is_filled_from_edge_to_edge() {
        let marking = Marking::new(&laser()).unwrap();
        let lines = marking.lines(&first(Planform::Square));
        // 130 - 23 = 107 um across: eight gaps of 13.375 um.
        assert_eq!(lines.len(), 9);
        assert!(lines.iter().all(|line| (length_m(line) - 107e-6).abs() < 1e-12));
        assert!(lines.windows(2).all(|pair| (pair[1][0][1] - pair[0][0][1] - 13.375e-6).abs() < 1e-12));
        // Alternating directions: the next line starts where this one ends.
        assert!(lines.windows(2).all(|pair| (pair[1][0][0] - pair[0][1][0]).abs() < 1e-12));
        let wide = Marking::new(&Laser { spot_um: Some(130.0), hatch_um: None, ..laser() }).unwrap();
        assert_eq!(wide.lines(&first(Planform::Square)).len(), 1);
        let wider = Marking::new(&Laser { spot_um: Some(131.0), hatch_um: None, ..laser() }).unwrap();
        assert!(wider.lines(&first(Planform::Square)).is_empty());
    }

    /// A groove that ends at the border of a disc is as wide as a complete one.
    #[test]
    fn a_clipped_groove_is_filled_from_edge_to_edge() {
        let marking = Marking::new(&laser()).unwrap();
        let pattern = Pattern::new(Planform::Groove, 130e-6, 370e-6, 5e-6).unwrap();
        let layout = Layout::clipped(pattern, Outline::Disc { diameter_m: 5e-3 }).unwrap();
        let middle = layout.iter().min_by(|a, b| a.centre_x_m.abs().total_cmp(&b.centre_x_m.abs())).unwrap();
        let (lines, apart_m) = marking.fill(&middle);
        let mut across: Vec<f64> = lines.iter().map(|line| line[0][0] - middle.centre_x_m).collect();
        across.sort_by(f64::total_cmp);
        // 130 - 23 = 107 um across: eight gaps of 13.375 um, as in a square.
        assert_eq!((across.len(), apart_m.len()), (9, 1));
        assert!((apart_m[0] - 13.375e-6).abs() < 1e-12);
        assert!((across[0] + 53.5e-6).abs() < 1e-12 && (across[8] - 53.5e-6).abs() < 1e-12, "{across:?}");
        assert!(lines.iter().all(|line| length_m(line) > 4.5e-3));
    }

    #[test]
    fn the_spots_edge_stays_inside_every_kind_of_cavity_and_reaches_its_edge() {
        let marking = Marking::new(&laser()).unwrap();
        let half_m = 11.5e-6;
        for texture in every_kind() {
            let pattern = Pattern::new(texture, 131.2e-6, 370e-6, 5e-6).unwrap();
            for outline in [
                Outline::Disc { diameter_m: 4e-3 },
                Outline::Rectangle { length_m: 3e-3, width_m: 2e-3 },
                Outline::Ring { outer_diameter_m: 4e-3, inner_diameter_m: 1.3e-3 },
            ] {
                for cavity in Layout::clipped(pattern, outline).unwrap().iter() {
                    let lines = marking.lines(&cavity);
                    let distances =
                        lines.iter().flatten().map(|point| Cavity { cut_by: None, ..cavity }.wall_distance_m(*point));
                    let nearest = distances.fold(f64::INFINITY, f64::min);
                    assert!(nearest > half_m - 1e-10, "{cavity:?}: {nearest}");
                    if cavity.cut_by.is_none() {
                        assert!(nearest < half_m + 7.6e-6, "{cavity:?}: {nearest}");
                    } else {
                        let inner = outline.inset(half_m - 1.1e-8).unwrap();
                        assert!(lines.iter().flatten().all(|point| inner.contains(*point)), "{cavity:?}");
                    }
                    // The area swept by the lines is the area within half a spot, except for the ends of strips.
                    let swept: f64 = lines.iter().map(length_m).sum::<f64>();
                    assert!(swept * 15e-6 < 1.3 * cavity.area_m2());
                }
            }
        }
    }

    #[test]
    fn a_square_given_as_a_polygon_is_filled_like_the_square() {
        let marking = Marking::new(&laser()).unwrap();
        let outline = Polygon::new(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]).unwrap();
        let texture = Texture::new(Planform::Polygon).with_outline(outline).unwrap();
        for outline in [Outline::Disc { diameter_m: 3e-3 }, Outline::Rectangle { length_m: 2e-3, width_m: 3e-3 }] {
            let laid =
                |texture: Texture| Layout::new(Pattern::new(texture, 130e-6, 370e-6, 5e-6).unwrap(), outline).unwrap();
            let (squares, polygons) = (laid(Planform::Square.into()), laid(texture));
            assert_eq!(squares.cavities(), polygons.cavities());
            for (square, polygon) in squares.iter().zip(polygons.iter()) {
                let lines = [square, polygon].map(|cavity| marking.lines(&cavity).concat().concat());
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
                // The ends and the middle of each line of the second family lie off all grooves of the first, at the
                // distance where the ends of lines 15 um apart meet.
                let end_before_m = (11.5_f64.powi(2) - (7.5 / crossing_deg.to_radians().sin()).powi(2)).sqrt() * 1e-6;
                let points = second
                    .iter()
                    .flat_map(|groove| marking.lines(groove))
                    .flat_map(|[from, to]| [from, to, [f64::midpoint(from[0], to[0]), f64::midpoint(from[1], to[1])]]);
                for point in points {
                    let inside_m = first.iter().map(|groove| Cavity { cut_by: None, ..*groove }.wall_distance_m(point));
                    assert!(inside_m.fold(f64::NEG_INFINITY, f64::max) < -end_before_m + 1e-10, "{point:?}");
                }
                // No wall remains at a crossing: one family or the other sweeps all of complete grooves except their
                // corners.
                for groove in second.iter().filter(|_| !layout.specimen().is_clipped).take(3) {
                    let lines = marking.lines(groove);
                    let alone = Cavity { crossed_by: None, ..*groove };
                    let [[cosine, sine], half_m] = [groove.orientation, [groove.width_m / 2.0, groove.length_m / 2.0]];
                    for place in 0..20_000 {
                        let share = [(place % 20) as f64 / 9.5 - 1.0, (place / 20) as f64 / 499.5 - 1.0];
                        let [across_m, along_m] = [share[0] * half_m[0], share[1] * half_m[1]];
                        let point = [
                            groove.centre_x_m + across_m * cosine - along_m * sine,
                            groove.centre_y_m + across_m * sine + along_m * cosine,
                        ];
                        let is_swept = |[from, to]: &Line| point_to_segment(point, *from, *to) < 11.5e-6 + 1e-10;
                        let is_of_first = || first.iter().any(|groove| groove.wall_distance_m(point) > -1e-10);
                        // Off the groove's corners, and off the ends of grooves at border and hole.
                        let is_between_ends = (0.9e-3..1.6e-3).contains(&point[0].hypot(point[1]));
                        let is_inner = is_between_ends && alone.wall_distance_m(point) > 11.5e-6;
                        assert!(!is_inner || is_of_first() || lines.iter().any(is_swept), "{groove:?}: {point:?}");
                    }
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
        let marking =
            Marking::new(&Laser { exposure: Some(Exposure::Mask), spot_um: None, hatch_um: None, ..laser() }).unwrap();
        let lines = marking.lines(&first(Planform::Square));
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
