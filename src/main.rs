//! The `gonio` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    // SAFETY: no other thread runs yet.
    unsafe { gonio::prepare_process() };
    gonio::main(std::env::args_os()).into()
}
