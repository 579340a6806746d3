//! Outlines of cavities: vertices in a table, or a drawing that holds one closed outline.
//!
//! Only the shape matters, not the drawing's unit and position: a pattern scales the shape to its width. Curves become
//! chords that deviate by at most [`FLATTENING`] of the drawing's extent.

mod curves;
mod dxf;
mod svg;

use std::ops::Range;
use std::path::Path;

use slipgrid_base::key_error::Refusal;
use slipgrid_model::pattern::{PatternError, Polygon};

use crate::formats::material::existing;
use crate::formats::source::{Source, read_bytes};
use crate::formats::{Diagnostic, Document, Spanned};

/// Deviation of chords from a curve, relative to the larger extent of its control points or of the circle.
pub const FLATTENING: f64 = 1e-4;

/// Corners of an outline as `[x, y]`, in order, in the unit of the drawing.
type Corners = Vec<[f64; 2]>;

/// Description of an accepted drawing in messages.
const EXPECTED: &str = "a drawing that ends with .svg or .dxf and holds one closed outline";

/// Reads the outline of a cavity, given by a list of vertices or by a drawing, `outline`, of which a DXF `layer` may be
/// named. `table` is the span of the table that holds the keys.
///
/// # Errors
/// [`Diagnostic`] if neither or both are given, if a drawing cannot be read, or if the shape is no valid outline.
pub fn read_outline(
    document: &Document,
    vertices: Option<&Spanned<Vec<[f64; 2]>>>,
    outline: Option<&Spanned<String>>,
    layer: Option<&Spanned<String>>,
    table: Range<usize>,
) -> Result<Polygon, Diagnostic> {
    if let (Some(layer), Some(false) | None) = (layer, outline.map(|outline| has_extension(outline.get_ref(), "dxf"))) {
        return Err(document
            .refuse(layer.span(), "names a layer where no drawing has any")
            .expected("outline = \"NAME.dxf\" beside it, or no such key"));
    }
    match (vertices, outline) {
        (Some(_), Some(outline)) => Err(document
            .refuse(outline.span(), "is given beside vertices_um")
            .expected("one of both: the outline of a cavity is either a list of vertices or a drawing")),
        (None, None) => Err(document.missing(table, "vertices_um").expected(
            "vertices_um = [[x, y], ...], at least three of them in order, or outline = \"NAME.svg\" or \"NAME.dxf\"",
        )),
        (Some(vertices), None) => Polygon::new(vertices.get_ref())
            .map_err(|error| refused(document.refuse(vertices.span(), String::new()), &error)),
        (None, Some(outline)) => {
            let layer = layer.map(|layer| layer.get_ref().as_str());
            let is_drawing = ["svg", "dxf"].into_iter().any(|extension| has_extension(outline.get_ref(), extension));
            if !is_drawing {
                return Err(document.refuse(outline.span(), "is no drawing that can be read").expected(EXPECTED));
            }
            let path = existing(document, outline, outline.get_ref())?;
            read_drawing(document.source(), &path, layer).map_err(|mut inside| {
                let expected = inside.expected.take().map_or_else(|| EXPECTED.to_owned(), Into::into);
                document.refuse(outline.span(), format!("cannot be used: {inside}")).expected(expected)
            })
        }
    }
}

/// Reads the only closed outline of the SVG or DXF drawing at `path` of `source`; in a DXF drawing on `layer`, if
/// given.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub fn read_drawing(source: &Source, path: &Path, layer: Option<&str>) -> Result<Polygon, Diagnostic> {
    // Layer names may have any encoding; the parts of a drawing that are read are ASCII.
    let bytes = read_bytes(source, path, EXPECTED)?;
    let text = String::from_utf8_lossy(&bytes);
    let found =
        if has_extension(&path.to_string_lossy(), "dxf") { dxf::outline(&text, layer) } else { svg::outline(&text) };
    let (corners, line) = found.map_err(|wrong| Diagnostic { file: Some(path.into()), ..wrong })?;
    Polygon::new(&corners)
        .map_err(|error| refused(Diagnostic { line: Some(line), ..Diagnostic::file(path, "") }, &error))
}

/// Diagnostic for `error` at the position `at`.
fn refused(at: Diagnostic, error: &PatternError) -> Diagnostic {
    let refusal = Refusal::from_error(error);
    let expected = refusal.expected().unwrap_or_else(|| "a closed outline".to_owned());
    // A list of vertices is too long to repeat, so the message names the corner.
    Diagnostic { reason: refusal.to_string(), value: None, ..at }.expected(expected)
}

fn has_extension(name: &str, extension: &str) -> bool {
    Path::new(name).extension().is_some_and(|own| own.eq_ignore_ascii_case(extension))
}

/// Error in a drawing, without the path of the drawing.
fn wrong(line: impl Into<Option<u32>>, reason: impl Into<String>, expected: &str) -> Diagnostic {
    Diagnostic { line: line.into(), reason: reason.into(), ..Diagnostic::default() }.expected(expected)
}

/// Error in the `value` of `key` in a drawing, without the path of the drawing.
fn wrong_at(key: &str, value: impl Into<Box<str>>, wrong: Diagnostic) -> Diagnostic {
    Diagnostic { key: Some(key.into()), value: Some(value.into()), ..wrong }
}

/// Returns the only outline in `found` with the line in which it begins; an error unless there is exactly one outline.
fn only(mut found: Vec<(Corners, u32)>, what: &str) -> Result<(Corners, u32), Diagnostic> {
    match (found.len(), found.pop()) {
        (1, Some(one)) => Ok(one),
        (0, _) | (_, None) => Err(wrong(None, "holds no closed outline", what)),
        (count, Some((_, line))) => {
            let reason = format!("holds {count} closed outlines");
            Err(wrong(line, reason, "one: a cavity has no holes and is one piece"))
        }
    }
}

#[cfg(test)]
mod tests;
