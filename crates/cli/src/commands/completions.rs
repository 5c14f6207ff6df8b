//! `curvmesh completions`: completions for shells.

use clap::{Args, Command};
use clap_complete::{Shell, generate};

use crate::failure::Failure;
use crate::save::save_bytes;
use crate::session::Outcome;

/// Print the completions for a shell
///
///     curvmesh completions bash > ~/.local/share/bash-completion/completions/curvmesh
///     curvmesh completions zsh > ~/.zfunc/_curvmesh
///     curvmesh completions fish > ~/.config/fish/completions/curvmesh.fish
#[derive(Debug, Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Completions {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// `whole` is the command line of the program.
pub(crate) fn run(options: &Completions, mut whole: Command) -> Result<Outcome, Failure> {
    let mut script = Vec::new();
    generate(options.shell, &mut whole, "curvmesh", &mut script);
    save_bytes("-".as_ref(), &script)?;
    Ok(Outcome::Done)
}
