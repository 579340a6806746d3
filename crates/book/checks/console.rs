//! Fenced blocks of a chapter, and the comparison of a command's output with blocks and numbers of the chapter.

/// Line of a chapter that stands for omitted output.
pub const LEFT_OUT: &str = "[...]";
/// Relative difference that numbers may have in addition to 1.5 units of the last digit shown, because other processors
/// round differently.
const TOLERANCE: f64 = 2e-3;

/// Start of the comment after a number of the prose that a command of the chapter prints. Up to its end,
/// [`PRINTED_END`], the comment contains a part of the printed line with `#` in place of the number.
const PRINTED: &str = "<!-- printed: ";
/// End of the comment that [`PRINTED`] starts.
const PRINTED_END: &str = " -->";

/// Fenced block of a chapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Text after the opening fence: the kind of the block and, for a file, its name.
    pub info: String,
    /// Number of lines of the chapter before the first line of the block.
    pub start: usize,
    /// Lines between the fences.
    pub lines: Vec<String>,
}

/// Returns the fenced blocks of a chapter, and whether the last one is closed.
#[must_use]
pub fn blocks(lines: &[String]) -> (Vec<Block>, bool) {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (number, line) in lines.iter().enumerate() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(info), None) => open = Some(Block { info: info.to_owned(), start: number + 1, lines: Vec::new() }),
            (None, Some(block)) => block.lines.push(line.clone()),
            (None, None) => {}
        }
    }
    (blocks, open.is_none())
}

/// Splits a line into words and numbers, without the punctuation around them.
fn tokens(line: &str) -> Vec<&str> {
    line.split(|c: char| c.is_whitespace() || "(),:;%".contains(c)).filter(|token| !token.is_empty()).collect()
}

/// Tokens of a line that are not numbers.
fn subject(line: &str) -> Vec<&str> {
    tokens(line).into_iter().filter(|token| token.parse::<f64>().is_err()).collect()
}

/// Whether a printed line equals the shown one up to the tolerance of its numbers.
#[must_use]
pub fn agree(shown: &str, printed: &str) -> bool {
    let (shown, printed) = (tokens(shown), tokens(printed));
    shown.len() == printed.len()
        && shown.iter().zip(&printed).all(|(a, b)| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(x), Ok(y)) => {
                let decimals = a.split_once('.').map_or(0, |(_, digits)| digits.len() as i32);
                (x - y).abs() <= TOLERANCE * y.abs() + 1.5 * 10_f64.powi(-decimals)
            }
            _ => a == b,
        })
}

/// Compares the lines that a chapter shows for `command` with the printed lines, passage by passage; [`LEFT_OUT`]
/// separates passages. Returns the printed lines of these passages, and appends the differences to `differ`.
pub fn compare(command: &str, shown: &[String], printed: &str, differ: &mut Vec<String>) -> Vec<String> {
    let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let mut now = Vec::new();
    let mut from = 0;
    for (order, passage) in shown.split(|line| line == LEFT_OUT).enumerate() {
        if order > 0 {
            now.push(LEFT_OUT.to_owned());
        }
        let Some(first) = passage.first() else { continue };
        // A passage begins at the next printed line that starts with the same words.
        let start = printed.iter().enumerate().skip(from).find(|(_, line)| {
            if order == 0 { true } else { subject(line).starts_with(&subject(first)[..subject(first).len().min(3)]) }
        });
        let Some((start, _)) = start else {
            differ.push(format!("{command}\n  no line like: {first}"));
            continue;
        };
        for (offset, line) in passage.iter().enumerate() {
            let own = printed.get(start + offset).copied().unwrap_or_default();
            if !agree(line, own) {
                differ.push(format!("{command}\n  shown:   {line}\n  printed: {own}"));
            }
            now.push(own.to_owned());
        }
        from = start + passage.len();
    }
    now
}

/// Returns the number in place of `#` in the last line of `printed` that contains `pattern`, or `None`; several spaces
/// count as one.
fn printed_number(printed: &str, pattern: &str) -> Option<String> {
    let single_spaced = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let pattern = single_spaced(pattern);
    let (before, after) = pattern.split_once('#')?;
    let is_digit = |c: char| c.is_ascii_digit() || c == '.';
    printed.lines().rev().find_map(|line| {
        let line = single_spaced(line);
        let starts = line.match_indices(is_digit).map(|(start, _)| start);
        let found =
            starts.map(|start| (start, line[start..].find(|c| !is_digit(c)).map_or(line.len(), |end| start + end)));
        let mut fitting = found.filter(|(start, end)| {
            line[..*start].ends_with(before) && line[*end..].starts_with(after) && !line[..*start].ends_with(is_digit)
        });
        fitting.next().map(|(start, end)| line[start..end].trim_end_matches('.').to_owned())
    })
}

/// Compares the numbers of a chapter's prose that are marked as printed with the output `printed` of commands.
/// Returns the chapter with the printed numbers, and appends the differences to `differ`.
pub fn compare_prose(chapter: &str, printed: &str, differ: &mut Vec<String>) -> String {
    let mut now = String::new();
    let mut rest = chapter;
    while let Some((before, (pattern, after))) =
        rest.split_once(PRINTED).and_then(|(before, rest)| Some((before, rest.split_once(PRINTED_END)?)))
    {
        // The last number before the comment; its unit may stand between them.
        let end = before.rfind(|c: char| c.is_ascii_digit()).map_or(0, |last| last + 1);
        let digits = before[..end].bytes().rev().take_while(|byte| byte.is_ascii_digit() || *byte == b'.').count();
        let (start, shown) = (end - digits, &before[end - digits..end]);
        let found = printed_number(printed, pattern);
        match found.as_deref().filter(|found| !agree(shown, found)) {
            Some(found) => now.extend([&before[..start], found, &before[end..]]),
            None => now.push_str(before),
        }
        if !found.as_deref().is_some_and(|found| agree(shown, found)) {
            differ.push(format!(
                "{pattern}\n  shown:   {shown}\n  printed: {}",
                found.as_deref().unwrap_or("no such line")
            ));
        }
        now.extend([PRINTED, pattern, PRINTED_END]);
        rest = after;
    }
    now + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(text: &str) -> Vec<String> {
        text.lines().map(str::to_owned).collect()
    }

    #[test]
    fn blocks_know_their_kind_and_their_place() {
        let (found, closed) = blocks(&lines("a\n```toml d.toml\nx = 1\n```\nb\n```console\n$ c\n"));
        assert_eq!(found, [Block { info: "toml d.toml".to_owned(), start: 2, lines: lines("x = 1") }]);
        assert!(!closed);
    }

    #[test]
    fn passages_are_found_where_lines_were_left_out_and_a_wrong_number_is_told() {
        let printed = "head\nmany 1\nratio  0.91 of it\nlast 3\n";
        let mut differ = Vec::new();
        let now = compare("c", &lines("head\n[...]\nratio 0.90 of it"), printed, &mut differ);
        assert_eq!((now, differ.len()), (lines("head\n[...]\nratio  0.91 of it"), 0));
        compare("c", &lines("head\n[...]\nratio 0.81 of it"), printed, &mut differ);
        compare("c", &lines("[...]\nnothing like it"), printed, &mut differ);
        assert_eq!(differ.len(), 2, "{differ:?}");
    }

    #[test]
    fn numbers_of_the_prose_are_those_printed() {
        let printed = "a: 56 % chance\n  P MPa  ratio\n   0.65  0.8214\n";
        let page = |chance: &str, ratio: &str| {
            format!("It has {chance} %<!-- printed: # % chance --> at {ratio}<!-- printed: 0.65 # -->.\n")
        };
        let mut differ = Vec::new();
        assert_eq!(compare_prose(&page("56", "0.82"), printed, &mut differ), page("56", "0.82"));
        assert!(differ.is_empty(), "{differ:?}");
        assert_eq!(compare_prose(&page("50", "0.92"), printed, &mut differ), page("56", "0.8214"));
        assert_eq!(differ.len(), 2);
        compare_prose("1<!-- printed: nothing # -->", printed, &mut differ);
        assert_eq!(differ.len(), 3);
    }
}
