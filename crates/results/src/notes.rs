//! What a model says of itself, as notes of a text: what bears on a decision first, and last, in one note, how it was computed.

use slipgrid_units::counted;

/// `model` as lines that begin with `- `, in their order, and `method` as the last one.
#[must_use]
pub fn notes<'a>(model: impl IntoIterator<Item = &'a str>, method: &[String]) -> String {
    let mut text: String = model.into_iter().map(|statement| format!("- {statement}\n")).collect();
    if !method.is_empty() {
        text += &format!("- how it was computed: {}\n", method.join("; "));
    }
    text
}

/// `text` in lines of at most `width` characters, those after the first indented by `indent`, and cut after `most` lines. Longer words stand
/// alone.
#[must_use]
pub fn wrapped(text: &str, width: usize, indent: &str, most: usize) -> String {
    let start = text.len() - text.trim_start().len();
    let mut lines = vec![text[..start].to_owned()];
    let mut is_first = true;
    for word in text.split_whitespace() {
        let line = lines.last_mut().map_or(0, |line| line.chars().count());
        if !is_first && line + 1 + word.chars().count() > width {
            if lines.len() == most {
                lines.iter_mut().last().into_iter().for_each(|line| line.push_str(" ..."));
                break;
            }
            lines.push(indent.to_owned() + word);
        } else if let Some(line) = lines.last_mut() {
            line.push_str(if is_first { "" } else { " " });
            line.push_str(word);
        }
        is_first = false;
    }
    lines.join("\n")
}

/// Width of the screen, in characters.
pub const SCREEN_WIDTH: usize = 100;

/// Where the screen sends for what it leaves out.
pub const WHERE_ALL: &str = "in the report, or with --details";

/// Maximum number of doubts that the screen lists; the others are counted.
const MAX_DOUBTS: usize = 3;

/// Lines of the screen about the first doubts, with the number of the others.
#[must_use]
pub fn doubts_in_brief(doubts: &[String]) -> String {
    let mut text: String = doubts.iter().take(MAX_DOUBTS).map(|doubt| doubt_in_brief(doubt)).collect();
    if doubts.len() > MAX_DOUBTS {
        text += &format!("! {}: {WHERE_ALL}\n", counted(doubts.len() - MAX_DOUBTS, "more doubt"));
    }
    text
}

/// A line of the screen about a doubt: what follows a semicolon explains it and is left to reports.
#[must_use]
pub fn doubt_in_brief(doubt: &str) -> String {
    let first = doubt.split("; ").next().unwrap_or(doubt);
    wrapped(&format!("! {first}"), SCREEN_WIDTH, "  ", 3) + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words() {
        assert_eq!(wrapped("  one two three", 10, "    ", 3), "  one two\n    three");
        assert_eq!(wrapped("a bb ccc dddd", 4, "", 2), "a bb\nccc ...");
        assert_eq!(wrapped("incomprehensible words", 5, " ", 9), "incomprehensible\n words");
        assert_eq!(wrapped("", 5, " ", 1), "");
    }

    #[test]
    fn how_it_was_computed_is_the_last_note() {
        let method = ["cell: one period".to_owned(), "two dimensions: plane stress".to_owned()];
        let said = notes(["no area law: Amontons-Coulomb friction", "b"], &method);
        let expected = "- no area law: Amontons-Coulomb friction\n- b\n\
                        - how it was computed: cell: one period; two dimensions: plane stress\n";
        assert_eq!(said, expected);
        assert_eq!(notes(["b"], &[]), "- b\n");
        assert_eq!(notes([], &[]), "");
    }
}
