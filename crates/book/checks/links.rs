//! Links and anchors of a chapter in Markdown.

/// Returns the targets of the links and pictures of `text` outside fenced blocks, in order.
#[must_use]
pub fn targets(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let prose = prose(text);
    for (place, _) in prose.match_indices("](") {
        let rest = &prose[place + 2..];
        // A title may follow the target.
        found.extend(rest.split([')', ' ']).next().map(|target| target.replace('\n', "")));
    }
    for (place, _) in prose.match_indices("src=\"") {
        found.extend(prose[place + 5..].split('"').next().map(str::to_owned));
    }
    found
}

/// Returns `text` without fenced and indented blocks, and without code between backticks.
fn prose(text: &str) -> String {
    let mut is_fenced = false;
    let lines = text.lines().filter(|line| {
        let is_fence = line.starts_with("```");
        is_fenced ^= is_fence;
        !is_fenced && !is_fence && !line.starts_with("    ")
    });
    let kept: String = lines.flat_map(|line| [line, "\n"]).collect();
    kept.split('`').step_by(2).collect::<Vec<_>>().join("`")
}

/// Returns the anchors of the headings of `text`, as mdBook and GitHub make them: lower case, hyphens instead of
/// spaces, no other signs, and a number after an anchor that occurs again.
#[must_use]
pub fn anchors(text: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut is_fenced = false;
    for line in text.lines() {
        is_fenced ^= line.starts_with("```");
        let title = line.trim_start_matches('#');
        if is_fenced || title.len() == line.len() || !title.starts_with(' ') {
            continue;
        }
        let letters = title.trim().to_lowercase();
        let kept = letters.chars().filter(|letter| letter.is_alphanumeric() || " -_".contains(*letter));
        let anchor: String = kept.map(|letter| if letter == ' ' { '-' } else { letter }).collect();
        let again = found.iter().filter(|other| **other == anchor || other.starts_with(&format!("{anchor}-"))).count();
        let is_new = !found.contains(&anchor);
        found.push(if is_new { anchor } else { format!("{anchor}-{again}") });
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_are_found_and_code_is_none() {
        let text = "See [a](one.md#x) and ![b](b.svg \"title\").\n```text\n[c](no.md)\n```\n`[d](no.md)` <img src=\"e.png\">\n";
        assert_eq!(targets(text), ["one.md#x", "b.svg", "e.png"]);
    }

    #[test]
    fn headings_make_the_anchors_that_pages_have() {
        assert_eq!(
            anchors("# One, two\n```\n# no\n```\n## `code` & more\n## One, two\n"),
            ["one-two", "code--more", "one-two-1"]
        );
    }
}
