//! Picture of several patterns on sectors of one specimen.

use std::fmt::Write as _;
use std::io;

use super::{CAVITY_COLOUR, CONTENT, INK_COLOUR, LINE_HEIGHT, MARGIN, Page, TEXT_SIZE, TITLE_SIZE, title, wrap};
use crate::export::{
    Boundary, Heading, Laser, MEASURE_EACH_ALONE, MICROMETRE_DECIMALS, Sector, cavities, decimal, flush_full,
    flush_rest, steps,
};

/// Space for the sectors' numbers around the specimen, in page units.
const NUMBER_SPACE: f64 = 6.0;
/// Maximum number of characters per line of text.
const LINE_CHARACTERS: usize = 78;

/// Note for sectors whose patterns are turned.
const TURNED: &str = "the arrow is the sliding direction on sector 1; the others slide along it when the specimen is turned back by their angle";

/// Writes `sectors` of one specimen as an SVG picture like [`super::svg`]: a separate group for each sector, with its
/// number next to it, and the mark.
///
/// # Errors
/// Errors of the writer `to`.
pub fn svg_of_sectors(sectors: &[Sector], laser: &Laser, heading: &Heading, to: &mut dyn io::Write) -> io::Result<()> {
    let Some(first) = sectors.first() else { return Ok(()) };
    let division = first.division();
    let outline = &division.specimen().outline;
    let [extent_x_mm, extent_y_mm] = outline.extents_m().map(|extent_m| extent_m * 1e3);
    let unit_mm = extent_x_mm.max(extent_y_mm) / (CONTENT - 2.0 * NUMBER_SPACE);
    let title = title(heading);
    let mut lines: Vec<String> =
        sectors.iter().flat_map(|sector| wrap(&words(sector, laser), LINE_CHARACTERS)).collect();
    if division.turn_deg(2) != 0.0 {
        lines.extend(wrap(TURNED, LINE_CHARACTERS));
    }
    for note in std::iter::once(&MEASURE_EACH_ALONE).chain(heading.notes) {
        lines.extend(wrap(note, LINE_CHARACTERS));
    }
    lines.push(format!("slipgrid {}", heading.version));

    let top = MARGIN + title.len() as f64 * 1.4 * TITLE_SIZE + 2.0 + NUMBER_SPACE;
    let height = extent_y_mm / unit_mm;
    let bar_top = top + height + NUMBER_SPACE + 1.0;
    let text_top = bar_top + 9.0;
    let mut page = Page { out: String::new(), unit_mm };
    page.open(2.0 * MARGIN + CONTENT, text_top + lines.len() as f64 * LINE_HEIGHT + MARGIN);
    page.title(&title);
    let centre = [MARGIN + CONTENT / 2.0, top + height / 2.0];
    let stroke = page.begin_specimen(outline, centre);
    for sector in sectors {
        let _ = write!(page.out, "<path id=\"sector-{}\" fill=\"{CAVITY_COLOUR}\" d=\"", sector.number());
        for boundary in sector.boundaries() {
            page.outline_of(None, &boundary);
            page.out.push('z');
            flush_full(&mut page.out, to)?;
        }
        page.out.push_str("\"/>\n");
    }
    let _ = write!(page.out, "<path id=\"mark\" fill=\"{INK_COLOUR}\" d=\"");
    page.outline_of(None, &Boundary::Polygon { corners_m: division.mark_m().to_vec() });
    page.out.push_str("z\"/>\n");
    page.end_specimen(&stroke);
    for sector in sectors {
        // Next to the border, on the sector's middle line.
        let angle = division.middle_deg(sector.number()).to_radians();
        let [cosine, sine] = [libm::cos(angle), libm::sin(angle)];
        let away = outline.rim_m([cosine, sine]) * 1e3 / unit_mm + NUMBER_SPACE / 2.0;
        let at = [centre[0] + away * cosine, centre[1] - away * sine + 0.35 * TITLE_SIZE];
        page.text(at, "middle", TITLE_SIZE, " font-weight=\"bold\"", &sector.number().to_string());
    }
    page.sliding_direction(first.pattern().texture(), [MARGIN, bar_top + 3.0]);
    page.scale_bar([MARGIN + CONTENT, bar_top + 3.0]);
    for (line, text) in lines.iter().enumerate() {
        page.text([MARGIN, text_top + (line as f64 + 0.7) * LINE_HEIGHT], "start", TEXT_SIZE, "", text);
    }
    page.out.push_str("</svg>\n");
    flush_rest(&mut page.out, to)
}

/// Describes a sector in one line.
fn words(sector: &Sector, laser: &Laser) -> String {
    let pattern = sector.pattern();
    let um = |length_m: f64| decimal(length_m * 1e6, MICROMETRE_DECIMALS);
    let steps = steps(sector.whole(), laser);
    format!(
        "{}: {} {} µm wide, spacing {} µm, {} µm deep{steps}; {:.2} % of the sector, {:.2} % of the pattern",
        sector.number(),
        cavities(pattern.planform()),
        um(pattern.width_m()),
        um(pattern.spacing_m()),
        um(pattern.depth_m()),
        100.0 * sector.areal_density(),
        100.0 * pattern.areal_density(),
    )
}
