//! `gonio init`: the pipeline file of a project's folder, as another program left it.

use std::path::PathBuf;

use super::ending::{Answer, Ending};
use super::print::{err, out};
use crate::base::shown::quoted;
use crate::before::{Found, not_there, text, write};

/// Options of `init`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The folder of the project, with its poses, photographs and mesh
    folder: PathBuf,
    /// Print the pipeline file to standard output, and write nothing to the disk
    #[arg(long)]
    print: bool,
}

/// Looks at a folder, says what is there and what is missing, and writes `gonio.toml` into it.
pub(super) fn init(args: &Args) -> Answer {
    // What is in the way is told before a large folder is looked at.
    let file = if args.print { None } else { Some(not_there(&args.folder)?) };
    let found = Found::at(&args.folder)?;
    let (missing, folder) = (found.missing(), quoted(&args.folder.display().to_string()));
    let mut lines = found.lines();
    lines.extend(missing.iter().cloned());
    match file {
        None => {
            lines.iter().for_each(|line| err(line));
            out(text(&found).trim_end())?;
        }
        Some(file) => {
            write(&file, &text(&found))?;
            lines.push(format!("wrote {}", file.display()));
            lines.push(match missing.len() {
                0 => format!("next: gonio check {folder} looks into every file, gonio run {folder} runs it"),
                _ => format!(
                    "next: make what is missing, name it in the file if it lies elsewhere, then gonio check {folder}"
                ),
            });
            lines.iter().try_for_each(|line| out(line))?;
        }
    }
    Ok(if missing.is_empty() { Ending::Done } else { Ending::Skipped })
}
