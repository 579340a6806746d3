//! Conversion of a layout to strips along the sliding direction, for solvers.

use slipgrid_model::springblock::Strip;

use crate::export::{Cavity, Layout, left_of};

/// Tolerance for equal strips, in metres: twice the rounding of lengths.
const STRIP_TOLERANCE_M: f64 = 2e-12;

impl Layout {
    /// Divides the face into `bands` of equal height across the sliding direction, each represented by the strip in its
    /// middle (two strips next to a hole). Equal strips are merged into one with their total width; widths times
    /// lengths add up to the area of the face. Cavities are those of the layout, cut at the border if it cuts them.
    pub(crate) fn strips(&self, bands: usize) -> Vec<Strip> {
        let sliding = self.sliding();
        let extent_m = self.outline().extent_along_m(left_of(sliding));
        let height_m = extent_m / bands as f64;
        let cavities: Vec<Cavity> = self.iter().collect();
        let mut strips: Vec<Strip> = Vec::new();
        for place in 0..bands {
            let at_m = (place as f64 + 0.5) * height_m - 0.5 * extent_m;
            let band = place.min(bands - 1 - place);
            for chord_m @ [from_m, to_m] in self.outline().chords_along_m(sliding, at_m) {
                let strip = Strip {
                    band,
                    width_m: height_m,
                    length_m: rounded(to_m - from_m),
                    cavities_m: self.along(&cavities, at_m, chord_m),
                };
                match strips.iter_mut().find(|known| alike(known, &strip)) {
                    Some(known) => known.width_m += height_m,
                    None if strip.length_m > 0.0 => strips.push(strip),
                    None => {}
                }
            }
        }
        // sum w_s L_s = A: normalizes chords in the middle of bands of a round face.
        let sampled_m2: f64 = strips.iter().map(|strip| strip.width_m * strip.length_m).sum();
        let scale = self.outline().area_m2() / sampled_m2;
        for strip in &mut strips {
            strip.width_m *= scale;
        }
        strips
    }

    /// Strip through the middle of the cavities in the row through the specimen's centre, which represents the whole
    /// face; two strips if a hole divides the row.
    pub(crate) fn central_strip(&self) -> Vec<Strip> {
        let cavities: Vec<Cavity> = self.iter().collect();
        let chords = self.outline().chords_along_m(self.sliding(), 0.0);
        let length_m: f64 = chords.iter().map(|[from_m, to_m]| to_m - from_m).sum();
        let strip = |chord_m @ &[from_m, to_m]: &[f64; 2]| Strip {
            band: 0,
            width_m: self.outline().area_m2() / length_m,
            length_m: rounded(to_m - from_m),
            cavities_m: self.along(&cavities, 0.0, *chord_m),
        };
        chords.iter().map(strip).collect()
    }

    /// Unit vector of the sliding direction in the specimen's axes.
    fn sliding(&self) -> [f64; 2] {
        self.pattern().texture().sliding_direction_on_specimen()
    }

    /// Intervals of `cavities` on a chord of the line that runs along the sliding direction, `at_m` to the left of the
    /// centre, in metres from the beginning of the chord; ascending.
    fn along(&self, cavities: &[Cavity], at_m: f64, [chord_from_m, chord_to_m]: [f64; 2]) -> Vec<[f64; 2]> {
        let sliding = self.sliding();
        let mut found: Vec<[f64; 2]> = cavities
            .iter()
            .flat_map(|cavity| cavity.spans_m(sliding, at_m))
            .filter_map(|[from_m, to_m]| {
                let from_m = from_m.max(chord_from_m) - chord_from_m;
                let to_m = to_m.min(chord_to_m) - chord_from_m;
                (to_m > from_m).then_some([rounded(from_m), rounded(to_m)])
            })
            .collect();
        found.sort_by(|a, b| a[0].total_cmp(&b[0]));
        // Merge grooves where they cross, and parts of a polygon on either side of a concave corner.
        let mut apart: Vec<[f64; 2]> = Vec::with_capacity(found.len());
        for [from_m, to_m] in found {
            match apart.last_mut() {
                Some(last) if from_m <= last[1] => last[1] = last[1].max(to_m),
                _ => apart.push([from_m, to_m]),
            }
        }
        apart
    }
}

fn alike(a: &Strip, b: &Strip) -> bool {
    let near = |a_m: f64, b_m: f64| (a_m - b_m).abs() <= STRIP_TOLERANCE_M;
    near(a.length_m, b.length_m)
        && a.cavities_m.len() == b.cavities_m.len()
        && a.cavities_m.iter().zip(&b.cavities_m).all(|(a, b)| near(a[0], b[0]) && near(a[1], b[1]))
}

/// Rounds a length in metres to the picometre, which removes rounding errors of file formats, so that a pattern that is
/// read back has bit-identical strips.
fn rounded(length_m: f64) -> f64 {
    (length_m * 1e12).round() * 1e-12
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::Outline;
    use crate::export::layout::every_kind;
    use slipgrid_model::pattern::{Pattern, Planform, Texture};

    const DISC: Outline = Outline::Disc { diameter_m: 10e-3 };

    fn grooves(width_um: f64, spacing_um: f64) -> Pattern {
        Pattern::new(Planform::Groove, width_um * 1e-6, spacing_um * 1e-6, 20e-6).unwrap()
    }

    /// Area of the face and fraction of cavities from the strips.
    fn sums(strips: &[Strip]) -> [f64; 2] {
        let cavity_m = |strip: &Strip| strip.cavities_m.iter().map(|[from, to]| to - from).sum::<f64>();
        let area_m2: f64 = strips.iter().map(|strip| strip.width_m * strip.length_m).sum();
        [area_m2, strips.iter().map(|strip| strip.width_m * cavity_m(strip)).sum::<f64>() / area_m2]
    }

    #[test]
    fn strips_of_a_disc_have_its_area_and_converge_to_its_share_of_cavities() {
        for (width_um, spacing_um) in [(400.0, 824.5), (130.0, 370.0), (40.0, 92.4)] {
            for layout in [Layout::new, Layout::clipped] {
                let layout = layout(grooves(width_um, spacing_um), DISC).unwrap();
                let errors = [16, 256].map(|bands| {
                    let [area_m2, share] = sums(&layout.strips(bands));
                    assert!((area_m2 / DISC.area_m2() - 1.0).abs() < 1e-12);
                    (share - layout.areal_density()).abs()
                });
                assert!(errors[0] < 0.012 && errors[1] < 1e-3, "{width_um}: {errors:?}");
            }
        }
    }

    #[test]
    fn strips_of_polygons_and_of_crossing_grooves_have_their_share() {
        let bent = every_kind().into_iter().find(|kind| kind.outline().is_some()).unwrap();
        let crossed = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(60.0).unwrap();
        let plate = Outline::Rectangle { length_m: 2.4e-3, width_m: 1.7e-3 };
        for texture in [bent, crossed.with_groove_angle_deg(-25.0).unwrap()] {
            let pattern = Pattern::new(texture, 130e-6, 170e-6, 20e-6).unwrap();
            for layout in [Layout::new, Layout::clipped] {
                let layout = layout(pattern, plate).unwrap();
                let strips = layout.strips(850);
                let apart = |strip: &Strip| strip.cavities_m.windows(2).all(|pair| pair[0][1] < pair[1][0]);
                assert!(strips.iter().all(apart));
                let [_, share] = sums(&strips);
                assert!(
                    (share - layout.areal_density()).abs() < 1e-3,
                    "{texture:?}: {share} {}",
                    layout.areal_density()
                );
            }
        }
    }

    #[test]
    fn bands_alike_are_one_strip() {
        // Both halves of a disc are equal, and all bands of a plate with transversal grooves.
        let disc = Layout::new(grooves(400.0, 824.5), DISC).unwrap();
        assert_eq!(disc.strips(16).len(), 8);
        let plate = Layout::new(grooves(400.0, 824.5), Outline::Rectangle { length_m: 10e-3, width_m: 6e-3 }).unwrap();
        let strips = plate.strips(16);
        // Grooves at -3 to 3 pitches of 1224.5 um; the next one would cross the edge.
        assert!(strips.len() == 1 && strips[0].cavities_m.len() == 7, "{strips:?}");
        assert!((strips[0].width_m - 6e-3).abs() < 1e-12 && (strips[0].cavities_m[3][0] - 4.8e-3).abs() < 1e-12);
        assert_eq!(plate.central_strip(), strips);
    }

    #[test]
    fn a_hole_parts_strips_and_squares_leave_rows_of_land() {
        let ring = Outline::Ring { outer_diameter_m: 10e-3, inner_diameter_m: 4e-3 };
        let layout = Layout::new(grooves(130.0, 370.0), ring).unwrap();
        let strips = layout.strips(10);
        assert!((sums(&strips)[0] / ring.area_m2() - 1.0).abs() < 1e-12);
        // Bands at 0.5 and 1.5 mm meet the hole: two strips each, mirrored and not equal.
        assert_eq!(strips.iter().filter(|strip| strip.band == 4).count(), 2);
        let squares = Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6).unwrap();
        let layout = Layout::new(squares, Outline::Rectangle { length_m: 2.13e-3, width_m: 2.13e-3 }).unwrap();
        let bare =
            layout.strips(213).iter().filter(|strip| strip.cavities_m.is_empty()).map(|s| s.width_m).sum::<f64>();
        // Five rows of 130 um in 2130.
        assert!((bare / 2.13e-3 - (1.0 - 5.0 * 130.0 / 2130.0)).abs() < 1e-9, "{bare}");
    }

    #[test]
    fn turned_with_its_sliding_direction_a_layout_has_the_same_strips() {
        let turned = |texture: Texture, by_deg: f64| {
            let texture = texture.with_sliding_angle_deg(texture.sliding_angle_deg() + by_deg).unwrap();
            let angle_deg = texture.groove_angle_deg() + by_deg;
            let is_grooves = matches!(texture.planform(), Planform::Groove | Planform::Crosshatch);
            if is_grooves { texture.with_groove_angle_deg(angle_deg).unwrap() } else { texture }
        };
        let crossed = Texture::new(Planform::Crosshatch).with_crossing_angle_deg(60.0).unwrap();
        let flown = Texture::new(Planform::Groove).with_groove_angle_deg(20.0).unwrap();
        let ring = Outline::Ring { outer_diameter_m: 5e-3, inner_diameter_m: 2e-3 };
        let [long, high] =
            [[4e-3, 1.5e-3], [1.5e-3, 4e-3]].map(|[length_m, width_m]| Outline::Rectangle { length_m, width_m });
        let squares = Texture::new(Planform::Square);
        for (texture, by_deg, [face, turned_face]) in [
            (Texture::new(Planform::Groove), 60.0, [ring, ring]),
            (crossed, -70.0, [ring, ring]),
            (flown, 33.3, [ring, ring]),
            (Texture::new(Planform::Groove), 90.0, [long, high]),
            (flown, -90.0, [long, high]),
            (squares, 90.0, [long, high]),
            (squares, 90.0, [ring, ring]),
        ] {
            for layout in [Layout::new, Layout::clipped] {
                let of = |texture: Texture, face: Outline| {
                    let layout = layout(Pattern::new(texture, 130e-6, 170e-6, 20e-6).unwrap(), face).unwrap();
                    [layout.strips(16), layout.central_strip()].concat()
                };
                let (strips, again) = (of(texture, face), of(turned(texture, by_deg), turned_face));
                assert_eq!(strips.len(), again.len(), "{texture:?}");
                for (own, turned) in strips.iter().zip(&again) {
                    let ends = |strip: &Strip| [&[[strip.width_m, strip.length_m]], &strip.cavities_m[..]].concat();
                    let (own, turned) = (ends(own), ends(turned));
                    assert_eq!(own.len(), turned.len(), "{texture:?}");
                    let apart = own.iter().flatten().zip(turned.iter().flatten()).map(|(a, b)| (a - b).abs());
                    assert!(apart.fold(0.0, f64::max) < 2e-12, "{texture:?}: {own:?} {turned:?}");
                }
            }
        }
        // Strips are mirrored for the opposite direction.
        let slid = |angle_deg: f64| {
            let texture = Texture::new(Planform::Groove).with_sliding_angle_deg(angle_deg).unwrap();
            Layout::new(Pattern::new(texture, 130e-6, 370e-6, 20e-6).unwrap(), DISC).unwrap().strips(16)
        };
        assert_eq!(slid(180.0).len(), slid(0.0).len());
    }
}
