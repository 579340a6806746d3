//! `campaign`: runs many scenes or designs with any number of workers.

use std::path::Path;
use std::sync::Arc;
use std::time::SystemTime;

use slipgrid_base::units::counted;
use slipgrid_io::campaign::{Engine, Folder, Share, plan};

use crate::args::{CampaignArgs, CampaignStep, MergeArgs, PlanArgs, WorkArgs};
use crate::interruption::goes_on_with;
use crate::output::{Place, ResultFolder, check_file, quoted, write_file};
use crate::progress::Job;
use crate::{CliError, Console, exit_code};
use slipgrid_io::disk::{Disk, disk};

/// Plans a campaign, works on its tasks or merges their results.
pub fn run(args: &CampaignArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    match &args.step {
        CampaignStep::Plan(args) => planned(args, console),
        CampaignStep::Work(args) => work(args, console),
        CampaignStep::Merge(args) => merge(args, console),
    }
}

fn at(folder: &Path) -> Folder {
    Folder::new(Arc::new(Disk::default()), folder)
}

fn planned(args: &PlanArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    if args.emit.is_some() {
        let absolute = std::path::absolute(&args.output).unwrap_or_else(|_| args.output.clone());
        Engine::check_folder_name(&absolute)?;
    }
    let _locked = ResultFolder::open(Place::output(&args.output), &[], &[])?;
    let planned = plan(&disk(), &args.campaign, &Job::new(console))?;
    at(&args.output).keep(&planned)?;
    let folder = args.output.display();
    if let Some(engine) = args.emit {
        let absolute = args.output.canonicalize().unwrap_or_else(|_| args.output.clone());
        let [workers, cores] = [args.workers, args.cores].map(|count| count as usize);
        let script = engine.script(&absolute, workers, cores, args.at_once.map(|count| count as usize))?;
        write_file(&args.output.join(format!("{}.sh", engine.name())), script.as_bytes())?;
    }
    console.answer(&format!(
        "{}: {} in {folder}\nnext: slipgrid campaign work {}\n",
        planned.campaign.name,
        counted(planned.tasks.len(), "task"),
        quoted(&args.output)
    ))?;
    Ok(exit_code::DONE)
}

fn work(args: &WorkArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    // Seed of the task order: any number that no other worker has.
    let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
    let seed = u64::from(std::process::id()).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ u64::from(since.subsec_nanos());
    let (share, most_s) = (args.share.unwrap_or(Share::ALL), args.max_seconds.map(f64::from));
    let threads = console.threads;
    goes_on_with(args.resuming());
    let worked = at(&args.folder).work(share, threads, most_s, seed, &Job::new(console))?;
    let damaged = match worked.damaged {
        0 => String::new(),
        count => format!("; {count} had damaged results"),
    };
    console.answer(&format!("{}; {} were done before{damaged}\n", worked.counts.words(), worked.known))?;
    Ok(exit_code::DONE)
}

fn merge(args: &MergeArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let path = args.output.clone().unwrap_or_else(|| args.folder.join("table.csv"));
    check_file(Place::output(&path), &[])?;
    let (table, counts) = at(&args.folder).merge(|results| (results.csv().to_owned(), results.counts()))?;
    write_file(&path, table.as_bytes())?;
    console.answer(&format!("{}, in {}\n", counts.words(), path.display()))?;
    Ok(if counts.missing == 0 { exit_code::DONE } else { exit_code::FAILURE })
}
