//! The `gonio` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    gonio::cli::main(std::env::args_os()).into()
}
