//! Words of a command line, quoted for a shell.

/// Quotes `word` for a shell if it contains special characters; on Windows, if it contains a space.
pub fn quoted_word(word: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "/._-+,:@%".contains(letter);
    if cfg!(windows) {
        // Paths of Windows contain no double quotes.
        return if word.contains(' ') { format!("\"{word}\"") } else { word.to_owned() };
    }
    if word.chars().all(plain) { word.to_owned() } else { format!("'{}'", word.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(not(windows))]
    fn paths_are_one_word_of_a_shell() {
        for (path, word) in [
            ("my-material/calibration.toml", "my-material/calibration.toml"),
            ("polym\u{e8}re.toml", "polym\u{e8}re.toml"),
            ("my material.toml", "'my material.toml'"),
            ("Anna's (2).toml", r"'Anna'\''s (2).toml'"),
            ("a$b.toml", "'a$b.toml'"),
        ] {
            assert_eq!(quoted_word(path), word);
        }
    }
}
