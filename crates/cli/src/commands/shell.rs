//! `completions` and `man`: what a shell and a manual reader need, from the command line itself.

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use crate::args::{Arguments, CompletionsArgs, ManArgs};
use crate::output::{Place, ResultFolder, add};
use crate::{CliError, Console, exit_code};
use slipgrid_report::Outputs;

/// Prints the completions of a shell.
pub fn completions(args: &CompletionsArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    // Into memory first: the generator does not say when writing fails.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Arguments::command(), "slipgrid", &mut script);
    console.out.write_all(&script)?;
    Ok(exit_code::DONE)
}

/// Prints the manual page, or writes one for each command.
pub fn man(args: &ManArgs, console: &mut Console<'_>) -> Result<u8, CliError> {
    let mut program = Arguments::command();
    program.build();
    let Some(folder) = &args.output else {
        console.out.write_all(&page(program)?)?;
        return Ok(exit_code::DONE);
    };
    let place = ResultFolder::open(Place::output(folder), &["slipgrid*.1"], &[])?;
    let mut pages = Outputs::default();
    add_pages(&program, "slipgrid", &mut pages)?;
    add(&pages, &place)?;
    for name in pages.names() {
        writeln!(console.out, "{}", folder.join(name).display())?;
    }
    Ok(exit_code::DONE)
}

/// Adds the pages of `command`, which is called `name`, and of the commands below it.
fn add_pages(command: &Command, name: &str, pages: &mut Outputs) -> Result<(), CliError> {
    for below in command.get_subcommands().filter(|below| below.get_name() != "help") {
        add_pages(below, &format!("{name}-{}", below.get_name()), pages)?;
    }
    pages.add(format!("{name}.1"), page(command.clone())?);
    Ok(())
}

fn page(command: Command) -> Result<Vec<u8>, CliError> {
    let mut page = Vec::new();
    Man::new(command).render(&mut page)?;
    Ok(page)
}
