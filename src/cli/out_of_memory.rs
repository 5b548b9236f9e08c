//! What is said where memory is out.
//!
//! Code that can do without memory asks for it and is told no. All other code ends the process, by way of `abort` or of a panic:
//! it cannot go on. So the allocator notes that memory was refused, and the handler of SIGABRT and the hook of panics say it in
//! words and end with exit code 1. Whatever ran is resumed as after a kill.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::fmt::{self, Write};
use std::panic::PanicHookInfo;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use super::ending::Ending;
use super::stack_words::{OneLine, Words};

/// The system's allocator, which notes what it refuses.
#[derive(Debug)]
pub struct Allocator;

thread_local! {
    /// The bytes that this thread was refused last; 0 where it never was.
    static REFUSED: Cell<usize> = const { Cell::new(0) };
}

/// More than this is taken for the claim of a file, whose refusal is no sign that memory is out.
const CLAIM: usize = 1 << 28;

fn noted(allocated: *mut u8, bytes: usize) -> *mut u8 {
    if allocated.is_null() {
        REFUSED.try_with(|refused| refused.set(bytes)).unwrap_or_default();
    }
    allocated
}

fn refused() -> usize {
    REFUSED.try_with(Cell::get).unwrap_or_default()
}

// SAFETY: every call is the system's allocator's own.
unsafe impl GlobalAlloc for Allocator {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        // SAFETY: the caller keeps the contract, which is the same.
        noted(unsafe { System.alloc(layout) }, layout.size())
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        // SAFETY: as above.
        noted(unsafe { System.alloc_zeroed(layout) }, layout.size())
    }

    unsafe fn realloc(&self, old: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: as above.
        noted(unsafe { System.realloc(old, layout, size) }, size)
    }

    unsafe fn dealloc(&self, old: *mut u8, layout: Layout) {
        // SAFETY: as above.
        unsafe { System.dealloc(old, layout) }
    }
}

/// Says in words where memory is out, from now on.
pub(super) fn tell() {
    #[cfg(unix)]
    // SAFETY: the handler allocates nothing, takes no lock, and makes only system calls. A handler that could not be registered
    // leaves the standard library's words.
    unsafe {
        signal_hook::low_level::register(libc::SIGABRT, || match refused() {
            0 => {}
            bytes => end(format_args!("the system refuses another {bytes} bytes")),
        })
        .map(drop)
        .unwrap_or_default();
    }
}

/// Ends the process in words where memory is what a panic is about.
pub(super) fn end_where_out(panic: &PanicHookInfo<'_>) {
    let words = panic.payload_as_str().unwrap_or_default();
    // What the standard library says where it cannot make the stack of a thread.
    let no_stack = words.contains("Cannot allocate memory");
    match refused() {
        0 if no_stack => end(format_args!("{}", OneLine(words))),
        bytes @ 1..CLAIM => end(format_args!("the system refuses another {bytes} bytes ({})", OneLine(words))),
        _ => {}
    }
}

/// Tells it, and ends the process.
fn end(what: fmt::Arguments<'_>) {
    // Other threads may be refused too: the first one tells.
    static TOLD: AtomicBool = AtomicBool::new(false);
    if TOLD.swap(true, Ordering::Relaxed) {
        loop {
            thread::sleep(Duration::from_secs(1));
        }
    }
    let mut words = Words::default();
    let advice = "lower [run] memory, or raise the limit of the process (ulimit -v); committed work stays";
    writeln!(words, "gonio: memory is out: {what}: {advice}").unwrap_or_default();
    words.say_in_parting();
    signal_hook::low_level::exit(Ending::Broken as i32);
}
