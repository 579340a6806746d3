//! Notes of a text about the model: statements that matter for a decision first, and the numerical method in the last
//! note.

use slipgrid_base::units::counted;

/// Formats every statement of `model` as a line that begins with `- `, and `method` as the last line.
pub fn notes<'a>(model: impl IntoIterator<Item = &'a str>, method: &[String]) -> String {
    let mut text: String = model.into_iter().map(|statement| format!("- {statement}\n")).collect();
    if !method.is_empty() {
        text += &format!("- how it was computed: {}\n", method.join("; "));
    }
    text
}

/// Breaks `text` between words into lines of at most `width` characters, of which all but the first begin with
/// `indent`; at most `most` lines are kept. A longer word gets a line of its own.
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

/// Option that shows all details, as named on the screen. A report has them too, but not every job writes one.
pub const WHERE_ALL: &str = "with --details";

/// Maximum number of doubts that the screen lists; the others are counted.
const MAX_DOUBTS: usize = 3;

/// Formats the first doubts for the screen, with the number of the others.
pub fn doubts_in_brief(doubts: &[String]) -> String {
    let mut text: String = doubts.iter().take(MAX_DOUBTS).map(|doubt| doubt_in_brief(doubt)).collect();
    if doubts.len() > MAX_DOUBTS {
        text += &format!("! {}: {WHERE_ALL}\n", counted(doubts.len() - MAX_DOUBTS, "more doubt"));
    }
    text
}

/// Beginning of a doubt about the material.
pub const ABOUT_MATERIAL: &str = "the material is doubtful: ";

/// Formats a doubt as at most three lines of the screen, without [`ABOUT_MATERIAL`] and without the explanation after
/// the first semicolon, which only reports give.
pub fn doubt_in_brief(doubt: &str) -> String {
    let doubt = doubt.strip_prefix(ABOUT_MATERIAL).unwrap_or(doubt);
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
