//! Fenced blocks of a chapter, and the comparison of a command's output with the chapter.

/// Line of a chapter that stands for omitted output.
pub const LEFT_OUT: &str = "[...]";
/// Relative difference that numbers may have in addition to 1.5 units of the last digit shown, because other processors
/// round differently.
const TOLERANCE: f64 = 2e-3;

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

/// Compares the lines that a chapter shows for `command` with the printed ones, passage by passage. Returns the printed
/// lines of these passages, and appends the differences to `differ`.
pub fn compare(command: &str, shown: &[String], printed: &str, differ: &mut Vec<String>) -> Vec<String> {
    let printed: Vec<&str> = printed.lines().map(str::trim_end).collect();
    let mut now = Vec::new();
    let mut from = 0;
    for (order, passage) in shown.split(|line| line == LEFT_OUT).enumerate() {
        if order > 0 {
            now.push(LEFT_OUT.to_owned());
        }
        let Some(first) = passage.first() else { continue };
        // A passage begins at the next line about the same.
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
}
