//! What is said of a panic: it is a defect of gonio itself. The words are put together on the stack, since memory may be out.

use std::env;
use std::fmt::{self, Write};
use std::panic::{self, PanicHookInfo};
use std::thread;

use super::out_of_memory;
use super::stack_words::{OneLine, Words};
use crate::base::guard;

/// Tells of every panic, in place of the standard library; with its backtrace after it where `RUST_BACKTRACE` asks for one.
pub(super) fn tell_of_panics() {
    let traced = env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0");
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        out_of_memory::end_where_out(panic);
        // What is guarded becomes an error in words.
        if guard::is_guarded() {
            return;
        }
        let mut words = Words::default();
        tell(&mut words, panic).unwrap_or_default();
        words.say();
        if traced {
            usual(panic);
        }
    }));
}

fn tell(words: &mut Words, panic: &PanicHookInfo<'_>) -> fmt::Result {
    let thread = thread::current();
    write!(words, "gonio: a defect of gonio itself: thread {} panicked", thread.name().unwrap_or("without a name"))?;
    if let Some(at) = panic.location() {
        write!(words, " at {at}")?;
    }
    writeln!(words, ": {}", OneLine(panic.payload_as_str().unwrap_or("without words")))?;
    let advice = "gonio: please report these lines and the command that led to them, once more with RUST_BACKTRACE=1; committed \
                  work stays";
    writeln!(words, "{advice}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In a process of its own, since the hook is the whole process's.
    #[test]
    #[ignore = "run by a_panic_is_told_in_two_lines"]
    fn panic_twice() {
        tell_of_panics();
        assert_eq!(guard::guarded::<()>(|| panic!("guarded")), Err("guarded".to_owned()));
        panic!("on\npurpose");
    }

    #[test]
    fn a_panic_is_told_in_two_lines() {
        let child = ["cli::defect::tests::panic_twice", "--exact", "--ignored", "--nocapture"];
        for traced in [false, true] {
            let mut command = std::process::Command::new(env::current_exe().unwrap());
            command.args(child).env_remove("RUST_BACKTRACE");
            if traced {
                command.env("RUST_BACKTRACE", "1");
            }
            let said = String::from_utf8_lossy(&command.output().unwrap().stderr).into_owned();
            let ours: Vec<&str> = said.lines().filter(|line| line.starts_with("gonio: ")).collect();
            assert_eq!(ours.len(), 2, "{said}");
            assert!(ours[0].contains("panicked at src/cli/defect.rs:") && ours[0].ends_with(": on purpose"), "{said}");
            assert!(ours[1].contains("please report") && !said.contains("guarded"), "{said}");
            assert_eq!(said.contains("stack backtrace"), traced, "{said}");
        }
    }
}
