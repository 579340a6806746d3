//! The command that goes on where an interrupted one stopped.

use std::path::Path;

use super::OptimizeArgs;

/// Characters that a shell does not take for themselves.
const QUOTED: &str = " '\"\\$`&;()<>|*?";

impl OptimizeArgs {
    /// The command line that takes over what this one left in its study.
    #[must_use]
    pub fn resuming(&self) -> String {
        let output = self.output.as_ref().map(|folder| format!(" -o {}", word(folder))).unwrap_or_default();
        let table = if self.table { " --table" } else { "" };
        let explorer = if self.no_explorer { " --no-explorer" } else { "" };
        format!("slipgrid optimize {}{output}{table}{explorer} --resume", word(&self.design))
    }
}

/// A path as a shell reads it.
fn word(path: &Path) -> String {
    let text = path.display().to_string();
    if text.contains(|c: char| QUOTED.contains(c)) { format!("'{}'", text.replace('\'', "'\\''")) } else { text }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_shell_reads_the_command_back() {
        let args = OptimizeArgs {
            design: "my designs/it's.toml".into(),
            output: Some("out/a".into()),
            table: true,
            no_explorer: true,
            resume: false,
            json: true,
        };
        assert_eq!(
            args.resuming(),
            r"slipgrid optimize 'my designs/it'\''s.toml' -o out/a --table --no-explorer --resume"
        );
    }
}
