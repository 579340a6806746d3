//! Detects mistaken dimensions of a cut sample by comparison with other samples: width and spacing exchanged, or the
//! decimal point of a depth misplaced.

use crate::formats::spanned::Spanned;
use slipgrid_infer::calibrate::CutSample;
use slipgrid_model::pattern::Pattern;

use super::document::Document;
use super::pattern::PatternFile;
use crate::formats::diagnostic::Diagnostic;
use slipgrid_base::units::{LENGTH_UM, tidy};

/// Relative difference below which lengths belong to one sample, as designed and as measured.
const SAME: f64 = 0.02;
/// Relative difference below which width and spacing cannot be told apart.
const APART: f64 = 0.1;

/// Warns if the `pattern` in the table `file` has exchanged width and spacing of one of the `others`.
pub(crate) fn check(
    document: &Document,
    file: &Spanned<PatternFile>,
    pattern: &Pattern,
    others: &[CutSample],
) -> Option<Diagnostic> {
    let [width_m, spacing_m] = [pattern.width_m(), pattern.spacing_m()];
    let near = |a: f64, b: f64, part: f64| (a - b).abs() <= part * a.max(b);
    if near(width_m, spacing_m, APART) {
        return None;
    }
    let is_turned = |other: &&CutSample| {
        other.pattern.texture().planform() == pattern.texture().planform()
            && near(other.pattern.width_m(), spacing_m, SAME)
            && near(other.pattern.spacing_m(), width_m, SAME)
    };
    let other = others.iter().find(is_turned)?;
    let [width_um, spacing_um] = [width_m, spacing_m].map(|length_m| LENGTH_UM.from_si(length_m));
    let reason = format!(
        "um beside spacing_um = {spacing_um} is \"{}\" with width and spacing exchanged: it has {:.0} % cavities, this one {:.0} %",
        other.name,
        100.0 * other.pattern.areal_density(),
        100.0 * pattern.areal_density(),
    );
    let expected = format!(
        "the width of a cavity, and in spacing_um the gap between two; width_um = {spacing_um} and spacing_um = {width_um} if they are \
         exchanged here"
    );
    Some(document.refuse(file.get_ref().width_um.span(), reason).expected(expected))
}

/// Ratio of the depths of two samples within which the decimal point was probably misplaced.
const TENFOLD: [f64; 2] = [9.0, 11.0];

/// Warns if the `pattern` in the table `file` has width and spacing of one of the `others`, but ten times or a tenth of
/// the depth.
pub(crate) fn check_depth(
    document: &Document,
    file: &Spanned<PatternFile>,
    pattern: &Pattern,
    others: &[CutSample],
) -> Option<Diagnostic> {
    let near = |a: f64, b: f64| (a - b).abs() <= APART * a.max(b);
    let ratio = |other: &CutSample| pattern.depth_m() / other.pattern.depth_m();
    let is_tenfold = |ratio: f64| (TENFOLD[0]..=TENFOLD[1]).contains(&ratio);
    let other = others.iter().find(|other| {
        near(other.pattern.width_m(), pattern.width_m())
            && near(other.pattern.spacing_m(), pattern.spacing_m())
            && (is_tenfold(ratio(other)) || is_tenfold(1.0 / ratio(other)))
    })?;
    let other_um = tidy(LENGTH_UM.from_si(other.pattern.depth_m()));
    let times = if ratio(other) > 1.0 { "ten times" } else { "a tenth of" };
    let reason = format!("um is {times} the depth of \"{}\", {other_um} um, at the same width and spacing", other.name);
    let told = document.refuse(file.get_ref().depth_um.span(), reason);
    Some(told.expected("the depth as measured, with its decimal point in the right place"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::pattern::read_pattern;
    use crate::formats::trials::of_tables;
    use slipgrid_infer::calibrate::CutSpecimen;

    fn said(own: [f64; 2], other: [f64; 2], planform: &str) -> Option<String> {
        let read = |[width, spacing]: [f64; 2], planform: &str| {
            let text =
                format!("width_um = {width:?}\nspacing_um = {spacing:?}\ndepth_um = 5.2\nplanform = \"{planform}\"\n");
            let document = Document::new("c.toml", text);
            let file: PatternFile = document.parse().unwrap();
            let file = Spanned::new(0..0, file);
            let pattern = read_pattern(&document, &file).unwrap();
            (document, file, pattern)
        };
        let (document, file, pattern) = read(own, planform);
        let others = [of_tables(read(other, "square").2, None, CutSpecimen::default(), &[])];
        check(&document, &file, &pattern, &others).map(|told| told.to_string())
    }

    #[test]
    fn a_depth_ten_times_that_of_another_sample_is_named() {
        let read = |depth: f64, width: f64| {
            let text =
                format!("width_um = {width:?}\nspacing_um = 370.0\ndepth_um = {depth:?}\nplanform = \"square\"\n");
            let document = Document::new("c.toml", text);
            let file: PatternFile = document.parse().unwrap();
            let pattern = read_pattern(&document, &Spanned::new(0..0, file.clone())).unwrap();
            (document, Spanned::new(0..0, file), pattern)
        };
        let said = |depth: f64, width: f64| {
            let (document, file, pattern) = read(depth, width);
            let others = [of_tables(read(5.2, 130.0).2, None, CutSpecimen::default(), &[])];
            check_depth(&document, &file, &pattern, &others).map(|told| told.to_string())
        };
        let told = said(52.0, 132.0).unwrap();
        assert!(
            told.starts_with("c.toml:3: depth_um: 52.0 um is ten times the depth of \"patterned samples\", 5.2 um"),
            "{told}"
        );
        assert!(said(0.52, 130.0).unwrap().contains("is a tenth of the depth"));
        for (depth, width) in [(5.2, 130.0), (20.8, 130.0), (52.0, 200.0)] {
            assert_eq!(said(depth, width), None, "{depth} {width}");
        }
    }

    #[test]
    fn a_sample_that_is_another_one_with_its_lengths_exchanged_is_named() {
        let told = said([372.0, 130.0], [130.0, 370.0], "square").unwrap();
        assert!(
            told.starts_with("c.toml:1: width_um: 372.0 um beside spacing_um = 130 is \"patterned samples\""),
            "{told}"
        );
        assert!(told.contains("it has 7 % cavities, this one 55 %"), "{told}");
        assert!(told.ends_with("width_um = 130 and spacing_um = 372 if they are exchanged here"), "{told}");
        for (own, other, planform) in [
            ([130.0, 370.0], [130.0, 370.0], "square"),
            ([370.0, 130.0], [130.0, 300.0], "square"),
            ([370.0, 130.0], [130.0, 370.0], "groove"),
            ([260.0, 240.0], [240.0, 260.0], "square"),
        ] {
            assert_eq!(said(own, other, planform), None, "{own:?} {other:?} {planform}");
        }
    }
}
