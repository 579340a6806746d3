//! Job scripts that run the workers of a campaign on a cluster.

use std::path::Path;

use crate::formats::Diagnostic;

/// Scheduler of a cluster for which a job script can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Engine {
    /// Slurm: a job array.
    Slurm,
    /// HyperQueue: a task array.
    HyperQueue,
}

slipgrid_base::names!(Engine { Slurm = "slurm", HyperQueue = "hyperqueue" });

impl Engine {
    /// Job script that runs `workers` workers with `threads` threads each on the campaign in `folder`. Slurm runs at
    /// most `at_once` workers at a time if given; HyperQueue ignores `at_once`. The program is `slipgrid`, or the one
    /// named by the environment variable SLIPGRID.
    ///
    /// # Errors
    /// See [`check_folder_name`](Self::check_folder_name).
    pub fn script(
        self,
        folder: &Path,
        workers: usize,
        threads: usize,
        at_once: Option<usize>,
    ) -> Result<String, Diagnostic> {
        let folder = format!("'{}'", Self::check_folder_name(folder)?.replace('\'', "'\\''"));
        let (engine, at_once) = (self.name(), at_once.unwrap_or(workers).min(workers));
        let (submit, options, threads, number) = match self {
            Self::Slurm => (
                "sbatch",
                format!(
                    "#SBATCH --job-name=slipgrid\n#SBATCH --array=1-{workers}%{at_once}\n#SBATCH --ntasks=1\n\
                     #SBATCH --cpus-per-task={threads}"
                ),
                format!("\"${{SLURM_CPUS_PER_TASK:-{threads}}}\""),
                "$SLURM_ARRAY_TASK_ID",
            ),
            // HyperQueue reads these lines as options of submit; the number of concurrent workers is limited by the
            // resources.
            Self::HyperQueue => (
                "hq submit",
                format!("#HQ --name=slipgrid\n#HQ --array=1-{workers}\n#HQ --cpus={threads}"),
                threads.to_string(),
                "$HQ_TASK_ID",
            ),
        };
        Ok(format!(
            "#!/bin/bash\n\
             # By slipgrid: {submit} {engine}.sh, and in the end slipgrid campaign merge {folder}\n\
             {options}\n\
             exec \"${{SLIPGRID:-slipgrid}}\" --threads {threads} --quiet campaign work {folder} --share \"{number}/{workers}\"\n"
        ))
    }

    /// Checks that the name of `folder` can be part of a script; a line break in it would begin a line of the script.
    ///
    /// # Errors
    /// [`Diagnostic`] for a name with control characters, or one that is not UTF-8.
    pub fn check_folder_name(folder: &Path) -> Result<&str, Diagnostic> {
        folder.to_str().filter(|name| !name.contains(char::is_control)).ok_or_else(|| {
            let reason = "cannot stand in a job script";
            Diagnostic::flag("--output", folder.to_string_lossy(), reason)
                .expected("a folder without control characters in its path, in UTF-8")
        })
    }
}
