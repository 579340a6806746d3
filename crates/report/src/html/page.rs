//! Parts of a page: text, sortable tables, pictures on cards.

use maud::{DOCTYPE, Markup, PreEscaped, Render, html};
use slipgrid_design::results::{PatternReport, fixed};
use slipgrid_laser::export::{is_xml_letter, not_modelled};

use super::section::section;
use crate::Outputs;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("sort.js");

/// Line end, written after every block element.
const NL: PreEscaped<&str> = PreEscaped("\n");

/// Picture size in bytes above which a page only names the file: browsers draw tens of thousands of shapes slowly.
const LARGEST_PICTURE: usize = 3_000_000;

/// Minimum displayed height of a drawing's smallest text, in pixels of the page.
const MIN_TEXT_PX: f64 = 9.0;

/// Maximum length of a number with its error and unit; longer cells are treated as sentences.
const LONGEST_NUMBER: usize = 24;

/// Text that is escaped when written, without control characters other than line ends.
pub(super) struct Text<'a>(pub(super) &'a str);

impl Render for Text<'_> {
    fn render_to(&self, buffer: &mut String) {
        self.0.replace(|c: char| !is_xml_letter(c) && c != '\n', "").render_to(buffer);
    }
}

/// Column of a table of records: its name, and a function that formats the cell of a record.
pub type Column<T> = (&'static str, fn(&T) -> String);

/// Note on a page without accompanying files.
const ALONE: &str = "This page holds all its numbers itself: no files belong to it.";

/// Page under construction, empty by default.
#[derive(Clone, Debug, Default)]
pub struct Page {
    body: String,
    pictures: usize,
    /// No files accompany the page.
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

    /// Adds a script verbatim.
    pub(super) fn script(&mut self, text: &str) {
        self.body.push_str(text);
        self.body.push('\n');
    }

    /// Adds the title of the page.
    pub fn title(&mut self, text: &str) {
        self.add(&html! { h1 { (Text(text)) } });
    }

    /// Adds a heading.
    pub fn heading(&mut self, text: &str) {
        self.add(&html! { h2 { (Text(text)) } });
    }

    /// Adds a subheading.
    pub fn subheading(&mut self, text: &str) {
        self.add(&html! { h3 { (Text(text)) } });
    }

    /// Adds the content written by `write` under a heading; adds nothing if `write` adds nothing.
    pub fn part(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        let before = std::mem::take(&mut self.body);
        write(self);
        let inside = std::mem::replace(&mut self.body, before);
        if !inside.is_empty() {
            self.heading(name);
            self.body.push_str(&inside);
        }
    }

    /// Adds the content written by `write`, folded under a name; adds nothing if `write` adds nothing.
    pub fn fold(&mut self, name: &str, write: impl FnOnce(&mut Self)) {
        let before = std::mem::take(&mut self.body);
        write(self);
        let inside = std::mem::replace(&mut self.body, before);
        if !inside.is_empty() {
            self.add(&html! { details { summary { (Text(name)) } (NL) (PreEscaped(inside)) } });
        }
    }

    /// Adds two parts side by side if there is room, with one picture at the right.
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

    /// Adds names with their values; adds nothing for an empty list.
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

    /// Adds terms with their definitions, folded.
    pub fn terms(&mut self, terms: &[(&str, &str)]) {
        self.add(&html! {
            details { summary { "What the words mean" } dl { (NL) @for (term, meaning) in terms { dt { (term) } dd { (meaning) } (NL) } } }
        });
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: &str) {
        self.add(&html! { p { (Text(text)) } });
    }

    /// Adds a paragraph with a class of the style sheet.
    pub fn marked(&mut self, class: &str, text: &str) {
        self.add(&html! { p class=(class) { (Text(text)) } });
    }

    /// Adds a warning.
    pub fn warning(&mut self, text: &str) {
        self.marked("warning", text);
    }

    /// Adds warnings: the first one, which is the most important, visible and the others folded.
    pub fn doubts(&mut self, all: Vec<String>) {
        let mut all = all.into_iter();
        if let Some(first) = all.next() {
            self.warning(&first);
        }
        let others: Vec<String> = all.collect();
        if !others.is_empty() {
            self.fold("Further doubts", |page| others.iter().for_each(|doubt| page.warning(doubt)));
        }
    }

    /// Adds a bar for a share from 0 to 1; adjacent text states the share too.
    pub fn bar(&mut self, share: f64) {
        let percent = 100.0 * share.clamp(0.0, 1.0);
        self.add(&html! {
            div class="bar" aria-hidden="true" { div style=(format!("width:{percent:.1}%")) {} }
        });
    }

    /// Adds the main sentence of the page.
    pub fn lead(&mut self, text: &str) {
        self.marked("chance", text);
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

    /// Adds a table whose columns sort by a click; adds nothing without rows.
    pub fn table(&mut self, caption: &str, header: &[&str], rows: &[Vec<String>]) {
        if rows.is_empty() {
            return;
        }
        // Sentences are left-aligned and numbers right-aligned; each column is one or the other.
        let is_words = |column: usize| {
            rows.iter().filter_map(|row| row.get(column)).any(|cell| cell.chars().count() > LONGEST_NUMBER)
        };
        let classes: Vec<Option<&str>> = (0..header.len()).map(|column| is_words(column).then_some("words")).collect();
        let class = |column: usize| classes.get(column).copied().flatten();
        self.add(&html! {
            div class="scroll" {
                table { (NL)
                    @if !caption.is_empty() { caption { (Text(caption)) } (NL) }
                    thead {
                        tr {
                            @for (column, name) in header.iter().enumerate() {
                                th scope="col" class=[class(column)] { button type="button" { (Text(name)) } }
                            }
                        }
                    } (NL)
                    tbody { (NL)
                        @for row in rows {
                            tr { @for (column, cell) in row.iter().enumerate() { td class=[class(column)] { (Text(cell)) } } } (NL)
                        }
                    } (NL)
                }
            }
        });
    }

    /// Adds a table with one row per record.
    pub fn records<T>(&mut self, caption: &str, records: &[T], columns: &[Column<T>]) {
        let header: Vec<&str> = columns.iter().map(|(name, _)| *name).collect();
        let row = |record: &T| columns.iter().map(|(_, cell)| cell(record)).collect();
        self.table(caption, &header, &records.iter().map(row).collect::<Vec<_>>());
    }

    /// Adds a picture on a card that is white in any colour scheme, with a caption.
    pub fn picture(&mut self, svg: &str, caption: &str) {
        if svg.len() > LARGEST_PICTURE {
            self.paragraph(&format!("{caption} The picture is too large for this page: it is a file beside the page."));
            return;
        }
        let card = self.card(svg, caption);
        self.add(&html! { figure { (card) figcaption { (Text(caption)) } } });
    }

    /// Puts a picture on its card, with ids that are unique on the page.
    fn card(&mut self, svg: &str, caption: &str) -> Markup {
        self.pictures += 1;
        let start = svg.find("<svg").unwrap_or(0);
        let prefix = format!("p{}-", self.pictures);
        // Ids within one page must be unique: the ids of each picture get their own prefix.
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

    /// Adds the picture `name` of `outputs`, with a variant for narrow windows if one exists.
    pub fn picture_of_both(&mut self, outputs: &Outputs, name: &str, narrow: Option<String>, caption: &str) {
        let (Some(wide), Some(narrow)) = (outputs.text(name), narrow) else {
            return self.picture_of(outputs, name, caption);
        };
        let [wide, narrow] = [self.card(&wide, caption), self.card(&narrow, caption)];
        self.add(&html! {
            figure { div class="wide" { (wide) } (NL) div class="narrow" { (narrow) } (NL) figcaption { (Text(caption)) } }
        });
    }

    /// Adds two periods of a pattern in vertical section without labels; adds nothing if a length is not positive.
    pub(super) fn outline(&mut self, pattern: &PatternReport) {
        let rim = pattern.rim.as_ref().and_then(|rim| rim.rim().ok());
        let svg = section(pattern.width_um, pattern.spacing_um, pattern.depth_um, rim.as_ref(), false);
        if !svg.is_empty() {
            self.picture(&svg, "Section of two periods, to scale");
        }
    }

    /// Adds two periods of a pattern in vertical section; adds nothing if a length is not positive.
    pub fn section(&mut self, pattern: &PatternReport) {
        let rim = pattern.rim.as_ref().and_then(|rim| rim.rim().ok());
        let svg = section(pattern.width_um, pattern.spacing_um, pattern.depth_um, rim.as_ref(), true);
        if !svg.is_empty() {
            let words = pattern.rim.as_ref().map_or_else(String::new, |rim| format!("; {}", rim.words()));
            self.picture(&svg, &format!("Vertical section through the centres of cavities, along their row{words}"));
        }
    }

    /// Adds model assumptions, numerical methods, and effects that are never modelled.
    pub fn model(&mut self, [model, method]: [&[String]; 2], has_rim: bool) {
        self.heading("What was modelled, and why");
        self.list(model);
        if !method.is_empty() {
            self.paragraph(&format!("How it was computed: {}.", method.join("; ")));
        }
        self.paragraph(&format!("Not modelled: {}.", not_modelled(has_rim).join("; ")));
    }

    /// Adds pictures side by side if there is room.
    pub fn pictures<'a>(&mut self, pictures: impl IntoIterator<Item = (&'a str, &'a str)>) {
        self.body.push_str("<div class=\"pair\">\n");
        for (svg, caption) in pictures {
            self.picture(svg, caption);
        }
        self.body.push_str("</div>\n");
    }

    /// Adds the text of a file, folded.
    pub fn folded(&mut self, name: &str, text: &str) {
        self.add(&html! { details { summary { (Text(name)) } pre { (Text(text.trim_end())) } } });
    }
}

/// Width of a drawing at which its smallest text has the height [`MIN_TEXT_PX`]; `None` without text.
fn least_width_px(svg: &str) -> Option<f64> {
    let after = |text: &'static str| svg.split(text).skip(1).filter_map(|rest| rest.split('"').next());
    let width: f64 = after("viewBox=\"").next()?.split_whitespace().nth(2)?.parse().ok()?;
    let smallest = after("font-size=\"").filter_map(|size| size.parse::<f64>().ok()).fold(f64::INFINITY, f64::min);
    (smallest > 0.0 && smallest.is_finite()).then(|| (MIN_TEXT_PX * width / smallest).ceil())
}

/// Finite value; `None` for infinities and NaN.
pub fn known(value: impl Into<Option<f64>>) -> Option<f64> {
    value.into().filter(|value| value.is_finite())
}

/// Formats words as a sentence. A key or file name at the beginning keeps its case.
pub fn sentence(words: &str) -> String {
    let first = words.split_whitespace().next().unwrap_or_default().trim_end_matches([':', ',', ';', '.']);
    if first.contains(['_', '.', '/', '`', '[']) {
        return format!("{words}.");
    }
    let mut letters = words.chars();
    let first = letters.next().map_or_else(String::new, |letter| letter.to_uppercase().collect());
    format!("{first}{}.", letters.as_str())
}

/// Formats a number with `digits` decimals, or a dash.
pub fn number(value: impl Into<Option<f64>>, digits: usize) -> String {
    fixed(value.into(), digits)
}

/// Formats a number with the fewest digits that represent it exactly, or a dash: 50, not 50.0.
pub fn plain(value: impl Into<Option<f64>>) -> String {
    known(value).map_or_else(|| "-".to_owned(), |value| value.to_string())
}

/// Replaces the unit of micrometres by µm.
pub fn micrometres(words: &str) -> String {
    let one = |word: &str| match word.trim_end_matches([',', '.', ';']) {
        "um" => word.replacen("um", "µm", 1),
        _ => word.to_owned(),
    };
    words.split(' ').map(one).collect::<Vec<_>>().join(" ")
}

/// Formats a length in micrometres, to a tenth of a nanometre.
pub fn length_um(value: f64) -> String {
    plain((value * 1e4).round() / 1e4)
}

/// Formats a share from 0 to 1 in per cent, or a dash.
pub fn percent(share: impl Into<Option<f64>>, digits: usize) -> String {
    number(share.into().map(|share| 100.0 * share), digits)
}

/// Formats a number with its error, or whichever of them is known.
pub fn with_error(value: impl Into<Option<f64>>, error: impl Into<Option<f64>>, digits: usize) -> String {
    let value = known(value);
    match known(error).filter(|_| value.is_some()) {
        Some(error) => format!("{} ± {}", number(value, digits), number(error.abs(), digits)),
        None => number(value, digits),
    }
}

/// Formats the ends of an interval, or a dash.
pub fn ends(interval: Option<[f64; 2]>, digits: usize) -> String {
    interval.map_or_else(|| "-".to_owned(), |[from, to]| format!("{} to {}", number(from, digits), number(to, digits)))
}

/// Formats a Boolean as yes or no.
pub fn yes_or_no(is_so: bool) -> String {
    if is_so { "yes" } else { "no" }.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sentences_begin_with_a_capital_but_names_of_keys_and_files_stay_as_they_are() {
        assert_eq!(sentence("rows are left out"), "Rows are left out.");
        for named in
            ["dynamic_mean: fitted", "traces.csv: 3 rows", "static_mean 2: not determined", "[learned] is used"]
        {
            assert_eq!(sentence(named), format!("{named}."));
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
