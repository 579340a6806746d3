//! Parts of an HTML page: text, sortable tables, pictures on cards.

use maud::{DOCTYPE, Markup, PreEscaped, Render, html};
use slipgrid_base::units::counted;
use slipgrid_design::results::{PatternReport, Table};
use slipgrid_laser::export::{is_xml_letter, not_modelled};

use super::section::section;
use super::words::brief;
pub use super::words::{known, length_um, micrometres, number, percent, plain, sentence, with_error};
use crate::Outputs;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("sort.js");

/// Line end, written after every block element.
const NL: PreEscaped<&str> = PreEscaped("\n");

/// Picture size in bytes above which a page only refers to the file, because browsers draw tens of thousands of shapes
/// slowly.
const LARGEST_PICTURE: usize = 3_000_000;

/// Minimum displayed height of a drawing's smallest text, in pixels of the page.
const MIN_TEXT_PX: f64 = 9.0;

/// Beginnings of file names, each with a description of the content of such files.
const FILES: [(&str, &str); 17] = [
    ("pattern.dxf", "cavities and outline for the laser, in mm"),
    ("pattern.svg", "drawing to scale, for people"),
    ("pattern.csv", "cavities with their positions"),
    ("process.toml", "process sheet: depth, bursts, hatch and tolerances"),
    ("scene.toml", "the confirming run, for slipgrid simulate"),
    ("result.json", "every number of this page"),
    ("friction.csv", "friction in time"),
    ("friction-", "its pictures, one a load"),
    ("interface.csv", "pressure along the interface"),
    ("interface-", "its pictures, one a load"),
    ("target.svg", "target and expected values"),
    ("trade-offs", "designs compared by goals"),
    ("table.csv", "designs of a lattice"),
    ("timings.json", "seconds by stage"),
    ("uncertainty.csv", "uncertainty budget"),
    ("corners.csv", "corners of cavities"),
    ("hatch.csv", "lines of the hatch"),
];

/// Maximum number of doubts (warnings) on the first screen; a list below the first screen has all doubts.
const MAX_BADGES: usize = 3;

/// Maximum number of characters of a cell that holds a number with its error and unit; a column with a longer cell is
/// treated as sentences.
const LONGEST_NUMBER: usize = 24;

/// Text that is escaped when rendered, without control characters other than line ends, and with the unit um as µm.
pub(super) struct Text<'a>(pub(super) &'a str);

impl Render for Text<'_> {
    fn render_to(&self, buffer: &mut String) {
        micrometres(self.0).replace(|c: char| !is_xml_letter(c) && c != '\n', "").render_to(buffer);
    }
}

/// Titles and units in tables: as shown on the screen, and as written on a page.
const LONG: [(&str, &str); 9] = [
    ("F N", "force in N"),
    ("P MPa", "P in MPa"),
    ("v mm/s", "speed in mm/s"),
    ("RH %", "humidity in %"),
    ("depth um", "depth in µm"),
    ("mean um", "mean in µm"),
    ("std um", "standard deviation in µm"),
    ("um", "µm"),
    ("deg", "°"),
];

/// Footer of a page without accompanying files.
const ALONE: &str = "This page holds all its numbers itself: no files belong to it.";

/// Page under construction, empty by default.
#[derive(Clone, Debug, Default)]
pub struct Page {
    body: String,
    pictures: usize,
    /// Whether what is added stands in a part with a heading.
    is_in_part: bool,
    /// Whether the page has no accompanying files.
    is_alone: bool,
}

impl Page {
    /// Creates a page without accompanying files.
    pub fn alone() -> Self {
        Self { is_alone: true, ..Self::default() }
    }

    /// Renders the whole page; `version` is the program's version.
    pub fn finish(self, title: &str, version: &str) -> String {
        let (title, version) = (Text(title), Text(version));
        let beside = if self.is_alone { ALONE } else { "Every number stands in the files beside this page." };
        let page = html! {
            (DOCTYPE) (NL)
            html lang="en" { (NL)
                head { (NL)
                    meta charset="utf-8"; (NL)
                    meta name="viewport" content="width=device-width, initial-scale=1"; (NL)
                    meta name="generator" content={ "slipgrid " (version) }; (NL)
                    title { (title) } (NL)
                    style { (NL) (PreEscaped(STYLE)) } (NL)
                } (NL)
                body { (NL)
                    main { (NL) (PreEscaped(self.body)) } (NL)
                    footer { "Made by slipgrid " (version) ". " (beside) } (NL)
                    script { (NL) (PreEscaped(SCRIPT)) } (NL)
                } (NL)
            } (NL)
        };
        page.into_string()
    }

    /// Appends an element and a line end.
    pub(super) fn add(&mut self, element: &Markup) {
        self.body.push_str(&element.0);
        self.body.push('\n');
    }

    /// Adds the title of the page.
    pub fn title(&mut self, text: &str) {
        self.add(&html! { h1 { (Text(text)) } });
    }

    /// Adds a heading of a section.
    pub fn heading(&mut self, text: &str) {
        self.add(&html! { h2 { (Text(text)) } });
    }

    /// Adds a heading of a subsection; outside of all parts its level is that of a section, so that no level is left
    /// out.
    pub fn subheading(&mut self, text: &str) {
        self.add(&if self.is_in_part {
            html! { h3 { (Text(text)) } }
        } else {
            html! { h2 class="sub" { (Text(text)) } }
        });
    }

    /// Returns the content written by `write`, which is not added.
    fn written(&mut self, write: impl FnOnce(&mut Self)) -> String {
        let before = std::mem::take(&mut self.body);
        write(self);
        std::mem::replace(&mut self.body, before)
    }

    /// Adds the content written by `write` under a heading; adds nothing if `write` adds nothing.
    pub fn part(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        let outer = std::mem::replace(&mut self.is_in_part, true);
        let inside = self.written(write);
        self.is_in_part = outer;
        if !inside.is_empty() {
            self.heading(name);
            self.body.push_str(&inside);
        }
    }

    /// Adds the content written by `write`, folded under a name; adds nothing if `write` adds nothing.
    pub fn fold(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        let inside = self.written(write);
        if !inside.is_empty() {
            self.add(&html! { details { summary { (Text(name)) } (NL) (PreEscaped(inside)) } });
        }
    }

    /// Adds two parts side by side if the window is wide enough; the right one is meant for a picture.
    pub fn beside_picture(&mut self, left: impl FnOnce(&mut Self), right: impl FnOnce(&mut Self)) {
        self.block("first tall", |page| {
            page.block("", left);
            page.block("", right);
        });
    }

    /// Adds the content written by `write` in a block with a class of the style sheet.
    pub(super) fn block(&mut self, class: &str, write: impl FnOnce(&mut Self)) {
        self.body.push_str(&format!("<div class=\"{class}\">\n"));
        write(self);
        self.body.push_str("</div>\n");
    }

    /// Adds a table of names with their values; adds nothing for an empty list.
    pub fn facts(&mut self, caption: &str, rows: &[(&str, String)]) {
        if rows.is_empty() {
            return;
        }
        self.add(&html! {
            table class="facts" { (NL)
                @if !caption.is_empty() { caption { (Text(caption)) } (NL) }
                tbody { (NL) @for (name, value) in rows { tr { th scope="row" { (Text(name)) } td { (Text(value)) } } (NL) } }
            }
        });
    }

    /// Adds a folded list of terms with their definitions.
    pub fn terms(&mut self, terms: &[(&str, &str)]) {
        self.add(&html! {
            details { summary { "What the words mean" } dl { (NL) @for (term, meaning) in terms { dt { (term) } dd { (meaning) } (NL) } } }
        });
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.add(&html! { p { (Text(text)) } });
    }

    /// Adds a paragraph with a class of the style sheet, such as `chance` for the main sentence of the page, or `warning`.
    pub fn marked(&mut self, class: &str, text: &str) {
        self.add(&html! { p class=(class) { (Text(text)) } });
    }

    /// Adds the list of all `doubts`, the gravest first. The list is not folded, so that all doubts are printed. Adds
    /// nothing for an empty list.
    pub fn doubts(&mut self, doubts: &[String]) {
        if !doubts.is_empty() {
            self.add(&html! {
                ul id="doubts" class="doubts" { (NL) @for doubt in doubts { li { (Text(&sentence(doubt))) } (NL) } }
            });
        }
    }

    /// Adds the first few `doubts` in brief, each with a link to the list of [`Page::doubts`].
    pub fn badges(&mut self, doubts: &[String]) {
        let more = doubts.len().saturating_sub(MAX_BADGES);
        if !doubts.is_empty() {
            self.add(&html! {
                ul class="badges" aria-label="Doubts, the gravest first" { (NL)
                    @for doubt in &doubts[..doubts.len() - more] { li { a href="#doubts" { (Text(brief(doubt))) } } (NL) }
                    @if more > 0 { li { a href="#doubts" { (counted(more, "more doubt")) } } (NL) }
                }
            });
        }
    }

    /// Adds a hundred dots, of which the share `chance`, from 0 to 1, is filled, with the number in words. The dots
    /// show a probability, not 100 samples: the error of the model is common to all samples of a texture.
    pub fn dots(&mut self, chance: f64) {
        let Some(chance) = known(chance) else { return };
        let count = (100.0 * chance.clamp(0.0, 1.0)).round();
        let words = format!("{} chance", slipgrid_design::percent(chance));
        self.add(&html! {
            div class="odds" {
                svg viewBox="0 0 110 110" role="img" aria-label={ (words) " that a cut sample is on target" } {
                    @for dot in 0_u8..100 {
                        circle class=[(f64::from(dot) < count).then_some("on")] cx=(11 * (dot % 10) + 5) cy=(11 * (dot / 10) + 5) r="4" {}
                    }
                }
                p aria-hidden="true" { (words) }
            }
        });
    }

    /// Adds numbered steps under a name; adds nothing for an empty list.
    pub fn steps(&mut self, name: &str, steps: &[String]) {
        if !steps.is_empty() {
            self.subheading(name);
            self.add(&html! { ol { (NL) @for step in steps { li { (Text(step)) } (NL) } } });
        }
    }

    /// Adds a bulleted list under a name; adds nothing for an empty list.
    pub fn named_list(&mut self, name: &str, items: &[String]) {
        if !items.is_empty() {
            self.subheading(name);
            self.list(items);
        }
    }

    /// Adds a bulleted list; adds nothing for an empty list.
    pub fn list(&mut self, items: &[String]) {
        if items.is_empty() {
            return;
        }
        self.add(&html! { ul { (NL) @for item in items { li { (Text(item)) } (NL) } } });
    }

    /// Adds a bulleted list of words, formatted as sentences; adds nothing for an empty list.
    pub fn sentences(&mut self, items: &[String]) {
        self.list(&items.iter().map(|words| sentence(words)).collect::<Vec<_>>());
    }

    /// Adds a table that a click on a column title sorts. Writes `+-` as ±, and replaces short titles and units by
    /// those of a page. Adds nothing for a table without rows.
    pub fn table(&mut self, caption: &str, table: &Table) {
        let rows = table.body();
        if rows.is_empty() {
            return;
        }
        let own = |words: &str| {
            let long = LONG.iter().find(|(short, _)| *short == words).map(|(_, long)| (*long).to_owned());
            long.unwrap_or_else(|| words.replace("+-", "±"))
        };
        // Names and notes of users stay unchanged; only cells of the column `unit` are units.
        let in_cell = |name: &str, cell: &str| if name == "unit" { own(cell) } else { cell.replace("+-", "±") };
        // Sentences are left-aligned and numbers right-aligned; each column is one or the other.
        let class = |column: usize| {
            let mut cells = rows.iter().filter_map(|row| row.get(column));
            cells.any(|cell| cell.chars().count() > LONGEST_NUMBER).then_some("words")
        };
        let classes: Vec<Option<&str>> = (0..table.header().len()).map(class).collect();
        self.add(&html! {
            div class="scroll" {
                table { (NL)
                    @if !caption.is_empty() { caption { (Text(&own(caption))) } (NL) }
                    thead {
                        tr {
                            @for (name, class) in table.header().iter().zip(&classes) {
                                th scope="col" class=[class] { button type="button" { (Text(&own(name))) } }
                            }
                        }
                    } (NL)
                    tbody { (NL)
                        @for row in rows {
                            tr {
                                @for ((cell, name), class) in row.iter().zip(table.header()).zip(&classes) {
                                    td class=[class] { (Text(&in_cell(name, cell))) }
                                }
                            } (NL)
                        }
                    } (NL)
                }
            }
        });
    }

    /// Adds a picture on a card, with a caption; adds only a note if the picture is too large for the page.
    pub fn picture(&mut self, svg: &str, caption: &str) {
        if svg.len() > LARGEST_PICTURE {
            self.paragraph(&format!("{caption} The picture is too large for this page: it is a file beside the page."));
            return;
        }
        let card = self.card(svg, caption);
        self.add(&html! { figure { (card) figcaption { (Text(caption)) } } });
    }

    /// Puts a picture on a card and makes its ids unique on the page.
    fn card(&mut self, svg: &str, caption: &str) -> Markup {
        self.pictures += 1;
        let start = svg.find("<svg").unwrap_or(0);
        let prefix = format!("p{}-", self.pictures);
        // Ids within one page must be unique, so that each picture gets a prefix for its ids.
        let named = svg[start..]
            .replace(" id=\"", &format!(" id=\"{prefix}"))
            .replace("url(#", &format!("url(#{prefix}"))
            .replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", Text(caption).render().0), 1);
        // The minimum width keeps the smallest text readable: a narrower window scrolls.
        let least = least_width_px(&named).map(|px| format!("--least:{px:.0}px"));
        html! { div class="card" style=[least] { (PreEscaped(named.trim_end())) } }
    }

    /// Adds the picture `name` of `outputs`, if it exists.
    pub fn picture_of(&mut self, outputs: &Outputs, name: &str, caption: &str) {
        if let Some(svg) = outputs.text(name) {
            self.picture(&svg, caption);
        }
    }

    /// Adds the picture `name` of `outputs`, with the variant `narrow` for narrow windows if there is one.
    pub fn picture_of_both(&mut self, outputs: &Outputs, name: &str, narrow: Option<String>, caption: &str) {
        let (Some(wide), Some(narrow)) = (outputs.text(name), narrow) else {
            return self.picture_of(outputs, name, caption);
        };
        let [wide, narrow] = [self.card(&wide, caption), self.card(&narrow, caption)];
        self.add(&html! {
            figure { div class="wide" { (wide) } (NL) div class="narrow" { (narrow) } (NL) figcaption { (Text(caption)) } }
        });
    }

    /// Adds a picture of two periods of a pattern in vertical section; adds nothing if a length is not positive.
    pub fn section(&mut self, pattern: &PatternReport, is_labelled: bool) {
        let svg = section(pattern, is_labelled);
        let caption = if is_labelled {
            let rim = pattern.rim_words().map_or_else(String::new, |rim| format!("; {rim}"));
            format!("Vertical section through the centres of cavities, along their row{rim}")
        } else {
            "Section of two periods, to scale".to_owned()
        };
        if !svg.is_empty() {
            self.picture(&svg, &caption);
        }
    }

    /// Adds model assumptions, effects that are never modelled, and numerical methods. `has_rim` tells whether the
    /// model includes rims.
    pub fn model(&mut self, [model, method]: [&[String]; 2], has_rim: bool) {
        self.heading("What was modelled, and why");
        self.sentences(model);
        self.paragraph(&format!("Not modelled: {}.", not_modelled(has_rim).join("; ")));
        self.fold("How it was computed", |page| page.sentences(method));
    }

    /// Adds pictures of `outputs`, each a name and a caption, folded under a heading and side by side if the window is
    /// wide enough; adds nothing without pictures.
    pub(super) fn pictures<'a>(
        &mut self,
        heading: &str,
        outputs: &Outputs,
        captioned: impl Iterator<Item = (&'a str, String)>,
    ) {
        let mut captioned = captioned.peekable();
        if captioned.peek().is_some() {
            self.fold(heading, |page| {
                page.block("pair", |page| {
                    captioned.for_each(|(name, caption)| page.picture_of(outputs, name, &caption))
                });
            });
        }
    }

    /// Adds links to the accompanying files, with a description of each kind of file; files of an unknown kind get no
    /// description.
    pub(super) fn files(&mut self, names: &[&str]) {
        let mut rest = names.to_vec();
        let mut kinds: Vec<(Vec<&str>, &str)> = Vec::new();
        for (start, words) in FILES {
            let (own, others) = rest.into_iter().partition(|name| name.starts_with(start));
            kinds.push((own, words));
            rest = others;
        }
        kinds.push((rest, ""));
        kinds.retain(|(own, _)| !own.is_empty());
        if !kinds.is_empty() {
            self.add(&html! {
                ul class="files" { (NL)
                    @for (own, words) in &kinds {
                        li {
                            @for (place, name) in own.iter().enumerate() { @if place > 0 { ", " } a href=(name) { (name) } }
                            @if !words.is_empty() { ": " (words) }
                        } (NL)
                    }
                }
            });
        }
    }
}

/// Width of a drawing, in pixels of the page, at which its smallest text has the height [`MIN_TEXT_PX`]; `None` for a
/// drawing without text.
fn least_width_px(svg: &str) -> Option<f64> {
    let after = |text: &'static str| svg.split(text).skip(1).filter_map(|rest| rest.split('"').next());
    let width: f64 = after("viewBox=\"").next()?.split_whitespace().nth(2)?.parse().ok()?;
    let smallest = after("font-size=\"").filter_map(|size| size.parse::<f64>().ok()).fold(f64::INFINITY, f64::min);
    (smallest > 0.0 && smallest.is_finite()).then(|| (MIN_TEXT_PX * width / smallest).ceil())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chances_are_dots_of_a_hundred() {
        for (chance, filled, words) in [(0.614, 61, "61 %"), (0.001, 0, "less than 1 %"), (1.0, 100, "more than 99 %")]
        {
            let mut page = Page::default();
            page.dots(chance);
            let page = page.finish("t", "0");
            assert_eq!((page.matches("class=\"on\"").count(), page.matches("<circle").count()), (filled, 100));
            assert!(page.contains(&format!("aria-label=\"{words} chance that a cut sample is on target\"")), "{page}");
        }
    }

    #[test]
    fn drawings_are_so_wide_that_their_smallest_text_can_be_read() {
        let svg =
            "<svg viewBox=\"0 0 7200 4000\"><text font-size=\"128\">a</text><text font-size=\"100\">b</text></svg>";
        assert_eq!(least_width_px(svg), Some(648.0));
        assert_eq!(least_width_px("<svg viewBox=\"0 0 9 9\"/>"), None);
        let mut page = Page::default();
        page.picture(svg, "c");
        assert!(page.finish("t", "0").contains("style=\"--least:648px\""));
    }
}
