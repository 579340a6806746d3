//! Checks whether the cavity lengths of a cut sample were probably written in another unit.

use crate::formats::spanned::Spanned;

use super::document::Document;
use super::pattern::PatternFile;
use crate::formats::diagnostic::Diagnostic;
use crate::formats::plausible::{CAVITY_DEPTH, CAVITY_WIDTH, Plausible};

/// Warns of lengths in the `table` that no cut cavity has.
pub(crate) fn unusual(document: &Document, table: &Spanned<PatternFile>) -> Vec<Diagnostic> {
    let file = table.get_ref();
    let length = file.texture.record.length_um;
    let length = length.map(|length| Spanned::new(document.value_span(&table.span(), "length_um"), length));
    let lengths = [
        (CAVITY_WIDTH, Some(&file.width_um)),
        (CAVITY_WIDTH, Some(&file.spacing_um)),
        (CAVITY_WIDTH, length.as_ref()),
        (CAVITY_DEPTH, Some(&file.depth_um)),
    ];
    let told = |(quantity, length): (Plausible, Option<&Spanned<f64>>)| {
        let length = length?;
        quantity.tell(*length.get_ref(), || document.refuse(length.span(), ""))
    };
    lengths.into_iter().filter_map(told).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> Vec<String> {
        let document = Document::new("c.toml", text);
        unusual(&document, &document.parse().unwrap()).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn millimetres_in_place_of_micrometres_are_asked_about() {
        let said = said("width_um = 0.08\nspacing_um = 0.16\ndepth_um = 0.001\n");
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(
            said[0].starts_with("c.toml:1: width_um: 0.08 is unusual")
                && said[0].ends_with("in mm, that would be 80 um")
        );
        assert!(said[1].ends_with("in mm, that would be 160 um"), "{said:?}");
        assert!(said[2].starts_with("c.toml:3: depth_um: 0.001") && said[2].ends_with("in mm, that would be 1 um"));
    }

    #[test]
    fn lengths_that_are_cut_are_not_told() {
        for text in [
            "width_um = 130.0\nspacing_um = 372.0\ndepth_um = 5.2\n",
            "width_um = 5.0\nspacing_um = 10.0\ndepth_um = 0.5\nlength_um = 8000.0\n",
        ] {
            assert_eq!(said(text), [""; 0]);
        }
    }
}
