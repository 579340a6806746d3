//! The command that goes on where an interrupted one stopped.

use std::path::Path;

use super::{OptimizeArgs, WorkArgs};

/// Characters that a shell does not take for themselves.
const QUOTED: &str = " '\"\\$`&;()<>|*?";

impl OptimizeArgs {
    /// The command line that takes over what this one left in its study.
    #[must_use]
    pub fn resuming(&self, no_cache: bool) -> String {
        let output = self.output.as_ref().map(|folder| format!(" -o {}", word(folder))).unwrap_or_default();
        let given = [(self.table, " --table"), (self.no_explorer, " --no-explorer"), (no_cache, " --no-cache")];
        let flags: String = given.into_iter().filter_map(|(is_given, flag)| is_given.then_some(flag)).collect();
        format!("slipgrid optimize {}{output}{flags} --resume", word(&self.design))
    }
}

impl WorkArgs {
    /// The command that does what these arguments' command leaves.
    pub fn resuming(&self) -> String {
        let share = self.share.map_or_else(String::new, |share| format!(" --share {}/{}", share.number, share.of));
        format!("slipgrid campaign work {}{share}", word(&self.folder))
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
            args.resuming(true),
            r"slipgrid optimize 'my designs/it'\''s.toml' -o out/a --table --no-explorer --no-cache --resume"
        );
    }
}
