//! Comparison of test results with the rows and sentences that the book's evidence quotes.

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

/// Environment variable that makes the book take over the current results.
const UPDATES: &str = "SLIPGRID_UPDATE_GUIDE";

/// Chapter of the evidence, compared with the results of a test.
#[derive(Debug)]
pub struct Quoted {
    path: PathBuf,
    chapter: String,
    /// Rows of the chapter and their replacements.
    taken_over: Vec<[String; 2]>,
    differences: Vec<String>,
}

/// Lock held while a chapter is written, because several tests have rows in the same chapter.
static WRITING: Mutex<()> = Mutex::new(());

impl Quoted {
    /// Reads `crates/book/src/evidence/<chapter>.md`.
    ///
    /// # Errors
    /// Returns an error if the chapter cannot be read.
    pub fn new(chapter: &str) -> std::io::Result<Self> {
        let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../crates/book/src/evidence"));
        let path = path.join(chapter).with_extension("md");
        let chapter = std::fs::read_to_string(&path)?;
        Ok(Self { path, chapter, taken_over: Vec::new(), differences: Vec::new() })
    }

    /// Compares a table row, `| title | number | ...`, with the row of the same title in the chapter, within the
    /// tolerance of its numbers.
    pub fn row(&mut self, row: &str) {
        let title = |line: &str| line.split('|').nth(1).map(|cell| cell.trim().to_owned());
        let Some(kept) = self.chapter.lines().find(|line| line.starts_with('|') && title(line) == title(row)) else {
            self.differences.push(format!("no row has the title of {row}"));
            return;
        };
        if kept == row {
            return;
        }
        if std::env::var_os(UPDATES).is_some() {
            self.taken_over.push([kept.to_owned(), row.to_owned()]);
        } else if !are_alike(&words(kept), &words(row)) {
            self.differences.push(format!("the chapter has {kept}\n     now it is {row}"));
        }
    }

    /// Compares a sentence, or a part of one, with the chapter, within the tolerance of its numbers.
    pub fn sentence(&mut self, sentence: &str) {
        let now = words(sentence);
        if !words(&self.chapter).windows(now.len()).any(|kept| are_alike(kept, &now)) {
            self.differences.push(format!("the chapter does not say: {sentence}"));
        }
    }

    /// Differences between the chapter and the results, in lines. In an update, the rows of the chapter are replaced
    /// first.
    ///
    /// # Errors
    /// Returns an error if the chapter cannot be read or written.
    pub fn differences(self) -> std::io::Result<String> {
        if !self.taken_over.is_empty() {
            let _writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
            let chapter = std::fs::read_to_string(&self.path)?;
            let chapter = self.taken_over.iter().fold(chapter, |chapter, [kept, now]| chapter.replace(kept, now));
            std::fs::write(&self.path, chapter)?;
        }
        Ok(self.differences.join("\n"))
    }
}

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

/// `word` without trailing punctuation.
fn without_stop(word: &str) -> &str {
    word.trim_end_matches([',', '.', ';', ')'])
}

/// Whether the words are equal, and the numbers equal up to rounding on other processors and three standard errors.
fn are_alike(kept: &[&str], now: &[&str]) -> bool {
    let is_alike = |place: usize| {
        let [was, is] = [kept, now].map(|words| without_stop(words[place]));
        let (Ok(value), Ok(found)) = (was.parse::<f64>(), is.parse::<f64>()) else {
            // A part of a sentence may end before a full stop.
            return kept[place] == now[place] || (place + 1 == now.len() && was == is);
        };
        let error = if matches!(kept.get(place + 1), Some(&"+-" | &"±")) {
            kept.get(place + 2).and_then(|error| without_stop(error).parse().ok()).unwrap_or(0.0)
        } else {
            0.0
        };
        (value - found).abs() <= 1.5 * last_place(was) + 3.0 * error
    };
    kept.len() == now.len() && (0..kept.len()).all(is_alike)
}

/// One unit of the last decimal of a number; for an integer one hundredth of it, at least 1.
fn last_place(number: &str) -> f64 {
    let (digits, exponent) = number.split_once('e').unwrap_or((number, "0"));
    let power = 10_f64.powi(exponent.parse().unwrap_or(0));
    digits.split_once('.').map_or_else(
        || (0.01 * digits.parse::<f64>().unwrap_or(0.0).abs()).max(1.0),
        |(_, decimals)| 0.1_f64.powi(i32::try_from(decimals.len()).unwrap_or(0)) * power,
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_alike_to_their_last_place_and_three_standard_errors() {
        let is_alike = |kept: &str, now: &str| are_alike(&words(kept), &words(now));
        let kept = "| step 8 ns | 1.64 +- 0.01 % | 0.9288 +- 0.0002 | 536 | 9.3e8 |";
        assert!(is_alike(kept, "| step 8 ns | 1.68 +- 0.02 % | 0.9282 +- 0.0002 | 541 | 9.4e8 |"));
        assert!(is_alike("0.2425 ± 0.0003, apart", "0.2433 ± 0.0003, apart"));
        for wrong in [
            "| step 8 ns | 1.70 +- 0.01 % | 0.9288 +- 0.0002 | 536 | 9.3e8 |",
            "| step 8 ns | 1.64 +- 0.01 % | 0.9298 +- 0.0002 | 536 | 9.3e8 |",
            "| step 8 ns | 1.64 +- 0.01 % | 0.9288 +- 0.0002 | 550 | 9.3e8 |",
            "| step 8 ns | 1.64 +- 0.01 % | 0.9288 +- 0.0002 | 536 | 9.5e8 |",
            "| step 8 us | 1.64 +- 0.01 % | 0.9288 +- 0.0002 | 536 | 9.3e8 |",
            "| step 8 ns | 1.64 +- 0.01 % | 0.9288 +- 0.0002 | 536 |",
        ] {
            assert!(!is_alike(kept, wrong), "{wrong}");
        }
    }

    #[test]
    fn a_chapter_is_compared_by_titles_and_sentences() {
        let mut quoted = Quoted::new("verification").unwrap();
        quoted.sentence("Verification asks whether the equations are solved correctly.");
        quoted.sentence("from rest and warm, with 2 um of travel");
        quoted.row("| convergence of nothing | 1 |");
        quoted.sentence("with 21 um of travel");
        let found = quoted.differences().unwrap();
        assert!(found.starts_with("no row") && found.ends_with("with 21 um of travel") && found.lines().count() == 2);
    }
}
