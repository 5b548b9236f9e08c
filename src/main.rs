//! The `gonio` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    gonio::base::memory::return_what_is_freed();
    gonio::cli::main(std::env::args_os()).into()
}
