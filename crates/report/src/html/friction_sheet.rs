//! Sheet of friction measurements on a page.

use super::page::Page;
use crate::friction_sheet::{FRICTION_TITLES, FRICTION_WORDS, FrictionSheet, TEXTURE_TITLES};

/// Adds the folded sheet of the measurements.
pub fn part(page: &mut Page, sheet: &FrictionSheet) {
    page.part("Statements for a publication", |page| {
        page.fold("Sheet of the friction measurements, with the items of ASTM G115", |page| {
            for section in &sheet.sections {
                page.table(section.title, &["item", "value"], &cells(&section.rows()));
            }
            if !sheet.textures.is_empty() {
                page.table("Textured samples", &TEXTURE_TITLES, &cells(&sheet.textures));
            }
            page.table(FRICTION_WORDS, &FRICTION_TITLES, &cells(&sheet.friction_cells()));
        });
    });
}

fn cells<const N: usize>(rows: &[[String; N]]) -> Vec<Vec<String>> {
    rows.iter().map(|row| row.to_vec()).collect()
}
