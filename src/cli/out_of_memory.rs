//! What is said where memory is out.
//!
//! Code that can do without memory asks for it and is told no. All other code ends the process, by way of `abort`: it cannot go
//! on. So the allocator notes that memory was refused, and the handler of SIGABRT says it in words and ends with exit code 1.
//! Whatever ran is resumed as after a kill.

use std::alloc::{GlobalAlloc, Layout, System};
use std::fmt::Write;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::defect::Words;
use super::ending::Ending;

/// The system's allocator, which notes what it refuses.
#[derive(Debug)]
pub struct Allocator;

/// The bytes that were refused last; 0 where none were.
static REFUSED: AtomicUsize = AtomicUsize::new(0);

fn noted(allocated: *mut u8, bytes: usize) -> *mut u8 {
    if allocated.is_null() {
        REFUSED.store(bytes, Ordering::Relaxed);
    }
    allocated
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
        signal_hook::low_level::register(libc::SIGABRT, || match REFUSED.load(Ordering::Relaxed) {
            0 => {}
            bytes => {
                let mut words = Words::default();
                let advice = "lower [run] memory, or raise the limit of the process (ulimit -v); committed work stays";
                writeln!(words, "gonio: memory is out: the system refuses another {bytes} bytes: {advice}")
                    .unwrap_or_default();
                words.say();
                signal_hook::low_level::exit(Ending::Broken as i32);
            }
        })
        .map(drop)
        .unwrap_or_default();
    }
}
