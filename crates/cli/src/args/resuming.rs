//! Command lines that resume an interrupted command.

use super::{OptimizeArgs, WorkArgs};
use crate::output::quoted;

impl OptimizeArgs {
    /// Command line that resumes the search from the study that this command left.
    pub fn resuming(&self, no_cache: bool) -> String {
        format!("{} --resume", self.again(no_cache))
    }

    /// Command line that gives the same results again.
    pub fn again(&self, no_cache: bool) -> String {
        let output = self.output.as_ref().map(|folder| format!(" -o {}", quoted(folder))).unwrap_or_default();
        let given = [
            (self.table, " --table"),
            (self.no_explorer, " --no-explorer"),
            (self.details, " --details"),
            (no_cache, " --no-cache"),
        ];
        let flags: String = given.into_iter().filter_map(|(is_given, flag)| is_given.then_some(flag)).collect();
        format!("slipgrid optimize {}{output}{flags}", quoted(&self.design))
    }
}

impl WorkArgs {
    /// Command line that does the remaining tasks of this command.
    pub fn resuming(&self) -> String {
        let share = self.share.map_or_else(String::new, |share| format!(" --share {}/{}", share.number, share.of));
        format!("slipgrid campaign work {}{share}", quoted(&self.folder))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(not(windows))]
    fn a_shell_reads_the_command_back() {
        let args = OptimizeArgs {
            design: "my designs/it's.toml".into(),
            output: Some("out/a".into()),
            table: true,
            no_explorer: true,
            resume: false,
            details: false,
            json: true,
        };
        assert_eq!(
            args.resuming(true),
            r"slipgrid optimize 'my designs/it'\''s.toml' -o out/a --table --no-explorer --no-cache --resume"
        );
    }
}
