//! CSV files of cavities, of their corners, and of marking lines.

use std::fmt::Write as _;
use std::io::{self, Write};

use slipgrid_model::pattern::{Contour, Planform};

use crate::export::number::COORDINATE_DECIMALS;
use crate::export::{Layout, MICROMETRE_DECIMALS, Marking, decimal, degrees, flush_full, flush_rest, push_decimal};

/// Header line of the table that [`csv`] writes. It has an angle if the sides of cavities do not lie along x and y, and
/// a diameter for discs.
pub fn csv_header(layout: &Layout) -> &'static str {
    let texture = layout.pattern().texture();
    let is_turned = texture.groove_angle_deg() != 0.0 || texture.planform() == Planform::Crosshatch;
    match texture.planform().contour() {
        Contour::Circle => "index,centre_x_mm,centre_y_mm,diameter_mm,depth_um,bursts",
        Contour::Rectangle if is_turned => "index,centre_x_mm,centre_y_mm,width_mm,length_mm,angle_deg,depth_um,bursts",
        Contour::Rectangle => "index,centre_x_mm,centre_y_mm,width_mm,length_mm,depth_um,bursts",
    }
}

/// Writes one row per cavity in the order of the layout, counted from 1, with lengths in millimetres from the
/// specimen's centre, rounded to one nanometre. Width is along x and length along y, both turned by the angle,
/// anticlockwise. `bursts` is the number per cavity, empty if unknown. Lengths are those before the border cuts the
/// cavity, and those of the bounding box for a polygon; see [`corners_csv`] for corners.
///
/// # Errors
/// Errors of the writer `to`.
pub fn csv(layout: &Layout, bursts: Option<u32>, to: &mut dyn Write) -> io::Result<()> {
    let texture = layout.pattern().texture();
    let angle = match texture.groove_angle_deg() {
        0.0 => String::new(),
        angle_deg => format!(",{}", degrees(angle_deg)),
    };
    let is_crossed = texture.planform() == Planform::Crosshatch;
    let rest = format!(
        "{},{},{}\n",
        if is_crossed { "" } else { &angle },
        decimal(layout.pattern().depth_m() * 1e6, MICROMETRE_DECIMALS),
        bursts.map_or_else(String::new, |bursts| bursts.to_string())
    );
    let lengths = match texture.planform().contour() {
        Contour::Circle => 3,
        Contour::Rectangle => 4,
    };
    let mut out = format!("{}\n", csv_header(layout));
    for (index, cavity) in layout.iter().enumerate() {
        let lengths_m = [cavity.centre_x_m, cavity.centre_y_m, cavity.width_m, cavity.length_m];
        push_row(&mut out, &[index + 1], &lengths_m[..lengths]);
        if is_crossed {
            let [cosine, sine] = cavity.orientation;
            out.push(',');
            out.push_str(&degrees(libm::atan2(sine, cosine).to_degrees()));
        }
        out.push_str(&rest);
        flush_full(&mut out, to)?;
    }
    flush_rest(&mut out, to)
}

/// Writes one row per corner, anticlockwise: `index` of the cavity as in [`csv`], `part` of the cavity from 1 (several
/// if the border or other grooves cut it), `corner` from 1, and position in millimetres. Complete round cavities are
/// written as polygons.
///
/// # Errors
/// Errors of the writer `to`.
pub fn corners_csv(layout: &Layout, to: &mut dyn Write) -> io::Result<()> {
    let mut out = "index,part,corner,x_mm,y_mm\n".to_owned();
    for (index, cavity) in layout.iter().enumerate() {
        for (part, boundary) in cavity.boundaries().iter().enumerate() {
            for (corner, corner_m) in boundary.polygon_m().iter().enumerate() {
                push_row(&mut out, &[index + 1, part + 1, corner + 1], corner_m);
                out.push('\n');
            }
        }
        flush_full(&mut out, to)?;
    }
    flush_rest(&mut out, to)
}

/// Writes one row per marking line, in marking order: `index` of the cavity as in [`csv`], number of the line in the
/// cavity from 1, and start and end of the path of the spot's centre, in millimetres.
///
/// # Errors
/// Errors of the writer `to`.
pub fn hatch_csv(layout: &Layout, marking: &Marking, to: &mut dyn Write) -> io::Result<()> {
    let mut out = "index,line,from_x_mm,from_y_mm,to_x_mm,to_y_mm\n".to_owned();
    let hatch = marking.on(layout);
    for (index, cavity) in layout.iter().enumerate() {
        for (line, [from_m, to_m]) in hatch.lines(&cavity).iter().enumerate() {
            push_row(&mut out, &[index + 1, line + 1], &[from_m[0], from_m[1], to_m[0], to_m[1]]);
            out.push('\n');
        }
        flush_full(&mut out, to)?;
    }
    flush_rest(&mut out, to)
}

/// Appends `counts`, and `lengths_m` in millimetres, without an end of line.
fn push_row(out: &mut String, counts: &[usize], lengths_m: &[f64]) {
    for (place, count) in counts.iter().enumerate() {
        let _ = write!(out, "{}{count}", if place > 0 { "," } else { "" });
    }
    for &length_m in lengths_m {
        out.push(',');
        push_decimal(out, length_m * 1e3, COORDINATE_DECIMALS);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::Outline;
    use crate::export::layout::every_kind;
    use crate::export::stream::text;
    use slipgrid_model::pattern::{Pattern, Texture};

    #[test]
    fn reads_back_to_the_same_cavities_within_a_nanometre() {
        for texture in every_kind() {
            let pattern = Pattern::new(texture, 131.2347e-6, 369.9999e-6, 5.2e-6).unwrap();
            let layout = Layout::new(pattern, Outline::Disc { diameter_m: 10e-3 }).unwrap();
            let text = text(|to| csv(&layout, Some(2), to));
            let mut lines = text.lines();
            let names: Vec<&str> = lines.next().unwrap().split(',').collect();
            let mut read = 0;
            for (index, (line, cavity)) in lines.by_ref().zip(layout.iter()).enumerate() {
                let values: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
                assert_eq!(values.len(), names.len());
                for (value, name) in values.iter().zip(&names) {
                    let expected = match *name {
                        "index" => (index + 1) as f64,
                        "centre_x_mm" => cavity.centre_x_m * 1e3,
                        "centre_y_mm" => cavity.centre_y_m * 1e3,
                        "width_mm" | "diameter_mm" => cavity.width_m * 1e3,
                        "length_mm" => cavity.length_m * 1e3,
                        "angle_deg" => cavity.orientation[1].atan2(cavity.orientation[0]).to_degrees(),
                        "depth_um" => 5.2,
                        "bursts" => 2.0,
                        _ => panic!("{name}"),
                    };
                    assert!((value - expected).abs() <= 0.5001e-6, "{line}");
                }
                read += 1;
            }
            assert_eq!(read, layout.cavities());
            assert_eq!(lines.next(), None);
        }
    }

    #[test]
    fn columns_say_what_a_cavity_has() {
        let header = |texture: Texture| {
            let pattern = Pattern::new(texture, 130e-6, 370e-6, 20e-6).unwrap();
            csv_header(&Layout::new(pattern, Outline::Disc { diameter_m: 10e-3 }).unwrap())
        };
        let groove = Texture::new(Planform::Groove);
        assert!(header(Planform::Disc.into()).contains(",diameter_mm,depth_um"));
        assert!(header(groove.with_groove_angle_deg(10.0).unwrap()).contains(",length_mm,angle_deg,depth_um"));
        assert_eq!(header(groove), header(Planform::Rectangle.into()));
    }

    #[test]
    fn unknown_bursts_are_an_empty_field() {
        let pattern = Pattern::new(Planform::Square, 130e-6, 370e-6, 20e-6).unwrap();
        let layout = Layout::new(pattern, Outline::Rectangle { length_m: 0.2e-3, width_m: 0.2e-3 }).unwrap();
        let header = "index,centre_x_mm,centre_y_mm,width_mm,length_mm,depth_um,bursts";
        assert_eq!(text(|to| csv(&layout, None, to)), format!("{header}\n1,0,0,0.13,0.13,20,\n"));
    }
}
