//! The `gonio` command.

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: gonio::Allocator = gonio::Allocator;

fn main() -> ExitCode {
    // SAFETY: no other thread runs yet.
    unsafe { gonio::prepare_process() };
    gonio::main(std::env::args_os()).into()
}
