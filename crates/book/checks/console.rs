//! Fenced blocks of a chapter, and whether a command prints what the chapter shows.

/// A line of a chapter that stands for lines left out.
pub const LEFT_OUT: &str = "[...]";
/// Numbers may differ by this share, beyond one unit of their last digit: other processors round differently.
const TOLERANCE: f64 = 2e-3;

/// A fenced block: what follows the fence, and its lines with their place in the chapter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// What follows the fence: the kind of the block, and the file that it belongs to.
    pub info: String,
    /// Number of lines of the chapter before the block's first.
    pub start: usize,
    /// The lines between the fences.
    pub lines: Vec<String>,
}

/// The fenced blocks of a chapter, and whether its last one is closed.
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

/// Words and numbers of a line; numbers without the signs around them.
fn tokens(line: &str) -> Vec<&str> {
    line.split(|c: char| c.is_whitespace() || "(),:;%".contains(c)).filter(|token| !token.is_empty()).collect()
}

/// What a line is about: its tokens that are no numbers.
fn subject(line: &str) -> Vec<&str> {
    tokens(line).into_iter().filter(|token| token.parse::<f64>().is_err()).collect()
}

/// Whether a printed line is the shown one, but for the last digits of its numbers.
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

/// Compares what a chapter shows of `command` with what it printed. Returns what stands there now, passage by passage as the
/// chapter chose them, and appends to `differ` what is not alike.
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
