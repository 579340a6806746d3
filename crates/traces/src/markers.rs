//! Lines of an export that number the table below them, for example `Step No. 2` or `Run # 1`.

/// Number given by a marker line: a line that numbers the table below it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Marker {
    /// Number of a run: one of several repeats of a test under equal conditions.
    Run(f64),
    /// Number of a step of a test.
    Step(f64),
}

/// First words of lines that number a step.
const STEP_WORDS: [&str; 4] = ["step", "schritt", "segment", "sequence"];
/// First word of lines that number a run.
const RUN_WORD: &str = "run";

/// Words that may stand between the first word and the number.
const NUMBER_WORDS: [&str; 3] = ["number", "no", "nr"];

/// Parses a line that numbers the table below it; `None` for other lines.
pub(crate) fn marker(line: &str) -> Option<Marker> {
    let is_sign = |letter: char| letter.is_whitespace() || ".:#=;,\"".contains(letter);
    let line = line.trim_start_matches(is_sign).to_lowercase();
    STEP_WORDS.into_iter().chain([RUN_WORD]).find_map(|word| {
        let rest = line.strip_prefix(word).filter(|rest| rest.starts_with(is_sign))?;
        let rest = rest.trim_start_matches(is_sign);
        let rest = NUMBER_WORDS.into_iter().find_map(|word| rest.strip_prefix(word)).unwrap_or(rest);
        let rest = rest.trim_start_matches(is_sign);
        let end = rest.find(|letter: char| !letter.is_ascii_digit()).unwrap_or(rest.len());
        let ends_there = !rest[end..].starts_with(|letter: char| letter.is_alphanumeric() || letter == '/');
        let number = rest[..end].parse().ok().filter(|_| ends_there)?;
        Some(if word == RUN_WORD { Marker::Run(number) } else { Marker::Step(number) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_several_houses_number_what_follows() {
        for (line, expected) in [
            ("Step No. 2", Some(Marker::Step(2.0))),
            ("Step 3 \"New film step\" started at 28/02/2017 16:09", Some(Marker::Step(3.0))),
            ("Step 1 started at 19/08/2016 09:48:51", Some(Marker::Step(1.0))),
            ("Schritt Nr. 4;;;", Some(Marker::Step(4.0))),
            ("Run # 1", Some(Marker::Run(1.0))),
            ("Run: 12", Some(Marker::Run(12.0))),
            ("Run date 12 May 2022 12:21:50", None),
            ("Step Type Code: 0", None),
            ("Step type\tBOD_TIMED\tStep description\tNew", None),
            ("Step 2nd", None),
            ("Running 3", None),
            ("Total number of runs - 1", None),
        ] {
            assert_eq!(marker(line), expected, "{line}");
        }
    }
}
