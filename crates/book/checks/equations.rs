//! Equations of a chapter: LaTeX between dollar signs becomes MathML, which browsers draw without a script.

use pulldown_latex::config::{DisplayMode, RenderConfig};
use pulldown_latex::event::Event;
use pulldown_latex::{Parser, Storage, push_mathml};

/// Punctuation that stays in the line of the equation before it, although browsers may break lines after every
/// equation.
const SIGNS: [char; 5] = [',', '.', ';', ':', ')'];

/// Replaces the equations of a chapter in Markdown by MathML: LaTeX between two lines `$$`, and LaTeX between single
/// dollar signs of one line. Code is left as it is. `\tag{3}` numbers a block.
///
/// # Errors
/// Returns the equation and its fault if it is not closed, or contains LaTeX that the converter does not know.
pub fn convert(chapter: &str) -> Result<String, String> {
    let (mut converted, mut prose) = (String::new(), String::new());
    let mut lines = chapter.split_inclusive('\n');
    while let Some(line) = lines.next() {
        let opening = line.trim();
        let end = if opening.starts_with("```") { "```" } else { "$$" };
        if !opening.starts_with(end) {
            prose.push_str(line);
            continue;
        }
        converted += &convert_prose(&std::mem::take(&mut prose))?;
        let inside: String = lines.by_ref().take_while(|line| line.trim() != end).collect();
        if end == "$$" {
            let indent = &line[..line.len() - line.trim_start().len()];
            converted += &format!("{indent}{}\n", block(&inside)?);
        } else {
            converted += &format!("{line}{inside}{}\n", line.replace(opening, end).trim_end());
        }
    }
    Ok(converted + &convert_prose(&prose)?)
}

/// Converts the equations between single dollar signs, except in code between backticks.
fn convert_prose(prose: &str) -> Result<String, String> {
    let mut pieces = Vec::new();
    for (place, text) in prose.split('`').enumerate() {
        let is_code = place % 2 == 1;
        if is_code {
            pieces.push(text.to_owned());
            continue;
        }
        let mut converted = String::new();
        let parts: Vec<&str> = text.split('$').collect();
        for (place, part) in parts.iter().enumerate() {
            let sign = |part: &str| part.chars().next().filter(|sign| SIGNS.contains(sign));
            let is_equation = place % 2 == 1;
            if !is_equation {
                let is_written = place > 0 && sign(part).is_some();
                converted += &part[usize::from(is_written)..];
                continue;
            }
            let element = mathml(part, DisplayMode::Inline)?;
            converted += &match parts.get(place + 1).and_then(|next| sign(next)) {
                Some(sign) => format!("<span class=\"unbroken\">{element}{sign}</span>"),
                None => element,
            };
        }
        if text.matches('$').count() % 2 == 1 {
            return Err(format!("a dollar sign has no other: {}", text.trim()));
        }
        pieces.push(converted);
    }
    Ok(pieces.join("`"))
}

/// Returns the element of a page for an equation on its own line, with its number if it has a `\tag`.
fn block(latex: &str) -> Result<String, String> {
    let (latex, number) =
        match latex.split_once("\\tag{").and_then(|(before, rest)| Some((before, rest.split_once('}')?))) {
            Some((before, (number, after))) => (format!("{before}{after}"), format!("<span>({number})</span>")),
            None => (latex.to_owned(), String::new()),
        };
    Ok(format!("<div class=\"equation\">{}{number}</div>", mathml(&latex, DisplayMode::Block)?))
}

/// Converts one equation to a MathML element on one line, in which characters that Markdown would interpret are
/// escaped.
fn mathml(latex: &str, display_mode: DisplayMode) -> Result<String, String> {
    let fault = |fault: &dyn std::fmt::Display| format!("{}: {fault}", latex.trim());
    if latex.trim().is_empty() || (display_mode == DisplayMode::Inline && latex.contains('\n')) {
        return Err(fault(&"an equation is empty or not closed in its line"));
    }
    let storage = Storage::new();
    let events: Vec<Event<'_>> =
        Parser::new(latex, &storage).collect::<Result<_, _>>().map_err(|error| fault(&error))?;
    let mut element = String::new();
    let config = RenderConfig { display_mode, ..RenderConfig::default() };
    push_mathml(&mut element, events.into_iter().map(Ok::<_, std::fmt::Error>), config)
        .map_err(|error| fault(&error))?;
    let safe = element.replace("<mo><</mo>", "<mo>&lt;</mo>").replace("<mo>></mo>", "<mo>&gt;</mo>");
    // The converter writes the sign of micro for the Greek letter, which browsers do not slant.
    let safe = safe.replace('\u{b5}', "\u{3bc}");
    Ok([('\n', " "), ('*', "&#42;"), ('|', "&#124;"), ('_', "&#95;")]
        .iter()
        .fold(safe, |safe, (sign, code)| safe.replace(*sign, code)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_and_lines_are_converted_and_code_is_not() {
        let page =
            convert("A $p < 1$ and `$x`, $y$.\n\n$$\nx^2 \\tag{3}\n$$\n\n```console\n$ slipgrid\n```\nEnd.\n").unwrap();
        assert!(
            page.starts_with("A <math display=\"inline\"><mi>p</mi><mo>&lt;</mo><mn>1</mn></math> and `$x`, <span class=\"unbroken\"><math "),
            "{page}"
        );
        assert!(page.contains("<mi>y</mi></math>.</span>\n"), "{page}");
        assert!(page.contains("<div class=\"equation\"><math display=\"block\"><msup>"), "{page}");
        assert!(page.ends_with("</math><span>(3)</span></div>\n\n```console\n$ slipgrid\n```\nEnd.\n"), "{page}");
    }

    #[test]
    fn faults_are_told() {
        for wrong in ["a $x", "$\\nonsense$", "$$\n\\frac{1}{2\n$$\n", "$x\ny$", "$ $"] {
            assert!(convert(wrong).is_err(), "{wrong}");
        }
    }
}
