//! Arguments of `campaign`.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Subcommand};
use slipgrid_io::campaign::{Engine, Share};

/// Arguments of `campaign`
#[derive(Args, Debug)]
#[command(after_help = "Examples:\n  \
    slipgrid campaign plan designs/campaign-rims.toml -o out/rims\n  \
    slipgrid campaign work out/rims\n  \
    slipgrid campaign merge out/rims\n\n\
    A campaign file names a scene or a design and what varies:\n  \
    base = \"scene.toml\"              # or a design\n  \
    work = \"table\"                   # every design of whole blocks and bursts\n  \
    [[grid]]                         # every combination of all grids\n  \
    key = \"pattern.width_um\"\n  \
    values = [40.0, 60.0]\n  \
    [[list]]                         # rows of keys that go together\n  \
    \"load.pressure_mpa\" = [0.65]\n\n\
    Any number of workers on any machines that see the folder compute what is missing, in any order; each writes \
    only its own results. A task that is refused or fails is a result, too. The table has the same bytes, whichever \
    worker did which task.")]
pub struct CampaignArgs {
    /// Step of the campaign.
    #[command(subcommand)]
    pub step: CampaignStep,
}

/// Steps of a campaign.
#[derive(Debug, Subcommand)]
pub enum CampaignStep {
    /// Make a task of every combination in a campaign file, with all inputs of the task
    Plan(PlanArgs),
    /// Do the tasks of a campaign that are not done yet
    Work(WorkArgs),
    /// Put all results into one table; exit code 1 if some are missing
    Merge(MergeArgs),
}

/// Arguments of `campaign plan`
#[derive(Args, Debug)]
pub struct PlanArgs {
    /// Campaign file
    pub campaign: PathBuf,
    /// Folder for the tasks and their results, shared by all workers
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// Also write the job script of an engine: DIR/slurm.sh for sbatch, DIR/hyperqueue.sh for hq submit
    #[arg(long, value_name = "ENGINE", value_parser = engines())]
    pub emit: Option<Engine>,
    /// Number of workers in the script
    #[arg(long, default_value_t = 10, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), requires = "emit")]
    pub workers: u32,
    /// Number of cores of each worker
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), requires = "emit")]
    pub cores: u32,
    /// Maximum number of workers that Slurm runs at once; all by default. HyperQueue runs as many as its own workers
    /// have cores for
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..), requires = "emit")]
    pub at_once: Option<u32>,
}

/// Arguments of `campaign work`
#[derive(Args, Debug)]
pub struct WorkArgs {
    /// Folder of the campaign
    pub folder: PathBuf,
    /// Do only the i-th of n equal shares of the tasks
    #[arg(long, value_name = "i/n", value_parser = parse_share)]
    pub share: Option<Share>,
    /// Start no task after this number of seconds; running tasks are finished
    #[arg(long, value_name = "S", value_parser = clap::value_parser!(u32))]
    pub max_seconds: Option<u32>,
}

/// Arguments of `campaign merge`
#[derive(Args, Debug)]
pub struct MergeArgs {
    /// Folder of the campaign
    pub folder: PathBuf,
    /// File of the table; table.csv in the campaign's folder by default
    #[arg(long, short, value_name = "TABLE.csv")]
    pub output: Option<PathBuf>,
}

fn engines() -> impl TypedValueParser<Value = Engine> {
    let named = |name: String| Engine::ALL.into_iter().find(|engine| engine.name() == name);
    PossibleValuesParser::new(Engine::ALL.map(Engine::name)).try_map(move |name| named(name).ok_or("an unknown engine"))
}

fn parse_share(text: &str) -> Result<Share, String> {
    let parts = text.split_once('/').map(|(number, of)| (number.parse(), of.parse()));
    match parts {
        Some((Ok(number), Ok(of))) if (1..=of).contains(&number) => Ok(Share { number, of }),
        _ => Err("expected i/n with i from 1 to n".to_owned()),
    }
}
