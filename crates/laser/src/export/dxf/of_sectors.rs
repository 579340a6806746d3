//! Drawing of several patterns on sectors of one specimen: one layer per sector, because depths differ.

use std::io::{self, Write};

use super::{Arrow, LAYER_ORIGIN, LAYER_OUTLINE, LAYER_SLIDING_DIRECTION, Writer, half_extents_mm, pattern_words};
use crate::export::{Heading, Laser, Sector, flush_full, flush_rest, steps};

/// Layer of the mark, which the laser cuts into a land so that sectors can be identified.
pub const LAYER_MARK: &str = "MARK";
/// AutoCAD colour numbers of the sectors, used cyclically.
const COLOURS: [&str; 4] = ["1", "4", "6", "2"];

/// Layer of the cavities of sector `number`.
pub fn sector_layer(number: usize) -> String {
    format!("CAVITIES_{number}")
}

/// Writes `sectors` of one specimen as an R12 drawing like [`super::dxf`]. Each sector has its own layer, whose depth
/// and bursts are stated in comments; the mark has a separate layer.
///
/// # Errors
/// Errors of the writer `to`.
pub fn dxf_of_sectors(sectors: &[Sector], laser: &Laser, heading: &Heading, to: &mut dyn Write) -> io::Result<()> {
    let Some(first) = sectors.first() else { return Ok(()) };
    let division = first.division();
    let outline = &division.specimen().outline;
    let (half_x_mm, half_y_mm) = half_extents_mm(outline);
    let arrow = Arrow::below(half_x_mm, half_y_mm, first.pattern().texture().sliding_direction_on_specimen());
    let mut file = Writer { out: String::new() };
    file.comment(&format!("slipgrid {}: {}", heading.version, heading.name));
    file.comment("Units: millimetres. Origin: centre of the specimen. The arrow is the sliding direction of sector 1.");
    file.comment(&format!(
        "{} sectors, anticlockwise from the one in the middle of +y; the mark stands on the land before the first",
        division.count()
    ));
    for sector in sectors {
        let (number, steps) = (sector.number(), steps(sector.whole(), laser));
        file.comment(&format!(
            "{}: {}{steps}, turned by {:.6} degrees",
            sector_layer(number),
            pattern_words(sector.pattern()),
            division.turn_deg(number),
        ));
    }
    for note in heading.notes {
        file.comment(note);
    }
    let names: Vec<String> = sectors.iter().map(|sector| sector_layer(sector.number())).collect();
    let mut layers = vec![(LAYER_OUTLINE, "7"), (LAYER_SLIDING_DIRECTION, "5"), (LAYER_ORIGIN, "3"), (LAYER_MARK, "2")];
    layers.extend(names.iter().map(String::as_str).zip(COLOURS.into_iter().cycle()));
    file.head([half_x_mm, half_y_mm], &arrow, &layers);
    file.face(outline);
    file.polygon(LAYER_MARK, &division.mark_m().map(|[x_m, y_m]| [x_m * 1e3, y_m * 1e3]));
    for (sector, layer) in sectors.iter().zip(&names) {
        for boundary in sector.boundaries() {
            file.boundary(layer, boundary);
            flush_full(&mut file.out, to)?;
        }
    }
    file.end(&arrow);
    flush_rest(&mut file.out, to)
}
