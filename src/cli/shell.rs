//! `gonio completions` and `gonio man`: what shells and `man` know of the command line.

use std::path::PathBuf;

use clap::Command;
use clap_complete::Shell;

use super::ending::{Answer, Ending};
use super::streams::write_out;
use crate::base::{Error, Result};

/// Options of `completions`.
#[derive(Debug, clap::Args)]
pub(super) struct CompletionsArgs {
    /// The shell
    shell: Shell,
}

/// Options of `man`.
#[derive(Debug, clap::Args)]
pub(super) struct ManArgs {
    /// Write the pages of all commands into this folder, a file each, instead
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Prints the completions of a shell.
pub(super) fn completions(args: &CompletionsArgs, mut command: Command) -> Answer {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut command, "gonio", &mut script);
    printed(&script)
}

/// Prints the manual page of `gonio`, or writes those of all commands.
pub(super) fn man(args: &ManArgs, command: Command) -> Answer {
    if let Some(folder) = &args.out {
        let made = std::fs::create_dir_all(folder).and_then(|()| clap_mangen::generate_to(command, folder));
        made.map_err(Error::io("write pages into", folder))?;
        return Ok(Ending::Done);
    }
    let mut page = Vec::new();
    let rendered: Result<()> = clap_mangen::Man::new(command).render(&mut page).map_err(Error::io("make", "gonio.1"));
    rendered?;
    printed(&page)
}

fn printed(bytes: &[u8]) -> Answer {
    write_out(|to| to.write_all(bytes))?;
    Ok(Ending::Done)
}
