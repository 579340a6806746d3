//! `completions` and `man`: generate shell completions and manual pages from the command line definition.

use clap::{Command, CommandFactory};
use clap_mangen::Man;

use crate::args::{Arguments, CompletionsArgs, ManArgs};
use crate::output::{Place, ResultFolder, add};
use crate::{CliError, Console};
use slipgrid_report::Outputs;

/// Prints the completion script for a shell.
pub fn completions(args: &CompletionsArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    // The generator does not report write errors, so it writes to memory first.
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Arguments::command(), "slipgrid", &mut script);
    Ok(console.out.write_all(&script)?)
}

/// Prints the manual page, or writes one page per command.
pub fn man(args: &ManArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    let mut program = Arguments::command();
    program.build();
    let Some(folder) = &args.output else {
        return Ok(console.out.write_all(&page(program)?)?);
    };
    let place = ResultFolder::open(Place::output(folder), &["slipgrid*.1"], &[])?;
    let mut pages = Outputs::default();
    add_pages(&program, "slipgrid", &mut pages)?;
    add(&pages, &place)?;
    for name in pages.names() {
        writeln!(console.out, "{}", folder.join(name).display())?;
    }
    Ok(())
}

/// Adds the pages of `command`, called `name`, and of its subcommands.
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
