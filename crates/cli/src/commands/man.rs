//! `curvmesh man`: manual pages.

use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_mangen::Man;

use crate::failure::Failure;
use crate::save::{make_folder_of, save_bytes};
use crate::session::Outcome;

/// Print the manual page, or write the pages of all commands to a folder
///
///     curvmesh man | man -l -
///     curvmesh man -o ~/.local/share/man/man1
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Manual {
    /// A folder for the pages of the program and all its commands
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
}

/// `whole` is the command line of the program.
pub(crate) fn run(options: &Manual, whole: Command) -> Result<Outcome, Failure> {
    let Some(folder) = &options.output else {
        save_bytes("-".as_ref(), &page(whole)?)?;
        return Ok(Outcome::Done);
    };
    // Global options become options of each command.
    let mut whole = whole.disable_help_subcommand(true);
    whole.build();
    for command in whole.get_subcommands().filter(|command| !command.is_hide_set()) {
        let name = command.get_display_name().unwrap_or_else(|| command.get_name());
        save_page(&folder.join(format!("{name}.1")), command.clone())?;
    }
    save_page(&folder.join("curvmesh.1"), whole)?;
    Ok(Outcome::Done)
}

fn save_page(path: &Path, command: Command) -> Result<(), Failure> {
    make_folder_of(path)?;
    save_bytes(path, &page(command)?)
}

fn page(command: Command) -> Result<Vec<u8>, Failure> {
    let mut text = Vec::new();
    Man::new(command).render(&mut text).map_err(Failure::Stdout)?;
    Ok(text)
}
