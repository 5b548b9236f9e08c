//! The command line: the only code that prints.
//!
//! What was typed ([`args`]) is one type, what it means another ([`Pipeline`](crate::pipeline::Pipeline)). Each command has a
//! file with its options and one function, from the options to an answer. Results go to standard output, everything else to
//! standard error.

mod args;
mod check;
mod deadline;
mod defect;
mod ending;
mod entry;
mod eval;
mod explain;
mod export;
mod found;
mod init;
mod inspect;
#[cfg(test)]
mod layouts;
mod light;
mod out_of_memory;
mod pipeline_args;
mod plan;
mod poses;
mod print;
mod process;
mod progress;
mod rate;
mod render;
mod report;
mod run;
mod shell;
mod stack_words;
mod streams;
mod synth;
mod verify;

pub use ending::Ending;
pub use entry::main;
pub use out_of_memory::Allocator;
pub use process::prepare_process;
