//! The parts of a page: text, tables that sort, pictures on cards.

use std::fmt::Write as _;

use serde_json::Value;

use slipgrid_results::fixed;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("sort.js");

/// Bytes of a picture above which a page only names it: browsers draw tens of thousands of shapes slowly.
const LARGEST_PICTURE: usize = 3_000_000;

/// Characters of a number with its error and unit; longer cells are sentences.
const LONGEST_NUMBER: usize = 24;

/// A page under construction.
pub struct Page {
    body: String,
    pictures: usize,
}

impl Page {
    /// A page with nothing on it.
    #[must_use]
    pub const fn new() -> Self {
        Self { body: String::new(), pictures: 0 }
    }

    /// The whole page. `version` of the program that made it.
    pub fn finish(self, title: &str, version: &str) -> String {
        let (title, version) = (escape(title), escape(version));
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"generator\" content=\"slipgrid {version}\">\n<title>{title}</title>\n\
             <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n{}</main>\n\
             <footer>Made by slipgrid {version}. Every number stands in the files beside this page.</footer>\n\
             <script>\n{SCRIPT}</script>\n</body>\n</html>\n",
            self.body
        )
    }

    /// A heading, from level 1 on.
    pub fn heading(&mut self, level: u8, text: &str) {
        let _ = writeln!(self.body, "<h{level}>{}</h{level}>", escape(text));
    }

    /// A paragraph of a class, or of none.
    pub fn paragraph(&mut self, class: &str, text: &str) {
        let class = if class.is_empty() { String::new() } else { format!(" class=\"{class}\"") };
        let _ = writeln!(self.body, "<p{class}>{}</p>", escape(text));
    }

    /// A share from 0 to 1 as a bar, which words beside it say too.
    pub fn bar(&mut self, share: f64) {
        let percent = 100.0 * share.clamp(0.0, 1.0);
        let _ = writeln!(
            self.body,
            "<div class=\"bar\" aria-hidden=\"true\"><div style=\"width:{percent:.1}%\"></div></div>"
        );
    }

    /// A list with bullets; nothing where there are no items.
    pub fn list(&mut self, items: &[String]) {
        if items.is_empty() {
            return;
        }
        self.body.push_str("<ul>\n");
        for item in items {
            let _ = writeln!(self.body, "<li>{}</li>", escape(item));
        }
        self.body.push_str("</ul>\n");
    }

    /// A table whose columns sort by a click; nothing where it has no rows.
    pub fn table(&mut self, caption: &str, header: &[&str], rows: &[Vec<String>]) {
        if rows.is_empty() {
            return;
        }
        self.body.push_str("<div class=\"scroll\"><table>\n");
        if !caption.is_empty() {
            let _ = writeln!(self.body, "<caption>{}</caption>", escape(caption));
        }
        // Sentences read from the left, numbers line up at the right: a column is one or the other.
        let is_words = |column: usize| {
            rows.iter().filter_map(|row| row.get(column)).any(|cell| cell.chars().count() > LONGEST_NUMBER)
        };
        let classes: Vec<&str> =
            (0..header.len()).map(|column| if is_words(column) { " class=\"words\"" } else { "" }).collect();
        self.body.push_str("<thead><tr>");
        for (name, class) in header.iter().zip(&classes) {
            let name = escape(name);
            let _ = write!(self.body, "<th scope=\"col\"{class}><button type=\"button\">{name}</button></th>");
        }
        self.body.push_str("</tr></thead>\n<tbody>\n");
        for row in rows {
            self.body.push_str("<tr>");
            for (column, cell) in row.iter().enumerate() {
                let class = classes.get(column).copied().unwrap_or_default();
                let _ = write!(self.body, "<td{class}>{}</td>", escape(cell));
            }
            self.body.push_str("</tr>\n");
        }
        self.body.push_str("</tbody>\n</table></div>\n");
    }

    /// A picture on a white card, in any colour scheme; `alt` says what it shows.
    pub fn picture(&mut self, svg: &str, caption: &str) {
        if svg.len() > LARGEST_PICTURE {
            self.paragraph("", &format!("{caption} The picture is too large for this page: it stands beside it."));
            return;
        }
        self.pictures += 1;
        let start = svg.find("<svg").unwrap_or(0);
        let prefix = format!("p{}-", self.pictures);
        // Names within one page are unique: those of several pictures are told apart.
        let named = svg[start..]
            .replace(" id=\"", &format!(" id=\"{prefix}"))
            .replace("url(#", &format!("url(#{prefix}"))
            .replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escape(caption)), 1);
        let caption = escape(caption);
        let _ = writeln!(
            self.body,
            "<figure><div class=\"card\">{}</div><figcaption>{caption}</figcaption></figure>",
            named.trim_end()
        );
    }

    /// Pictures side by side where there is room.
    pub fn pictures<'a>(&mut self, pictures: impl IntoIterator<Item = (&'a str, &'a str)>) {
        self.body.push_str("<div class=\"pair\">\n");
        for (svg, caption) in pictures {
            self.picture(svg, caption);
        }
        self.body.push_str("</div>\n");
    }

    /// A file's text, folded away.
    pub fn folded(&mut self, name: &str, text: &str) {
        let _ = writeln!(
            self.body,
            "<details><summary>{}</summary><pre>{}</pre></details>",
            escape(name),
            escape(text.trim_end())
        );
    }
}

/// `text` as HTML; control characters other than line ends are left out.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars().filter(|c| !c.is_control() || *c == '\n') {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            c => out.push(c),
        }
    }
    out
}

/// The text at `key`, empty where there is none.
pub fn text<'a>(value: &'a Value, key: &str) -> &'a str {
    value[key].as_str().unwrap_or("")
}

/// A number with its decimals, or a dash.
pub fn number(value: &Value, digits: usize) -> String {
    fixed(value.as_f64(), digits)
}

/// A number as it is written in the result, or a dash.
pub fn plain(value: &Value) -> String {
    match value {
        Value::Null => "-".to_owned(),
        Value::String(text) => text.clone(),
        Value::Bool(true) => "yes".to_owned(),
        Value::Bool(false) => "no".to_owned(),
        // 50, not 50.0
        Value::Number(number) if number.is_f64() => {
            number.as_f64().map_or_else(String::new, |number| number.to_string())
        }
        other => other.to_string(),
    }
}

/// A number with its error.
pub fn with_error(value: &Value, error: &Value, digits: usize) -> String {
    match error.as_f64() {
        Some(error) if value.is_number() => format!("{} ± {}", number(value, digits), fixed(Some(error.abs()), digits)),
        _ => number(value, digits),
    }
}

/// The elements of a list, none where it is none.
pub fn each<'a>(value: &'a Value, key: &str) -> &'a [Value] {
    value[key].as_array().map_or(&[], Vec::as_slice)
}

/// The texts of a list.
pub fn texts(value: &Value, key: &str) -> Vec<String> {
    each(value, key).iter().filter_map(|item| item.as_str().map(str::to_owned)).collect()
}
