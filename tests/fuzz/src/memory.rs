//! Counts the bytes that Rust code holds, so that a target can say how many its reader may take.

use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::atomic::{AtomicI64, Ordering::Relaxed};

/// The system's allocator, counted.
pub struct Counted;

static HELD: AtomicI64 = AtomicI64::new(0);
static MOST: AtomicI64 = AtomicI64::new(0);

fn add(bytes: usize) {
    MOST.fetch_max(HELD.fetch_add(bytes as i64, Relaxed) + bytes as i64, Relaxed);
}

// SAFETY: every call goes to the system's allocator as it came.
unsafe impl GlobalAlloc for Counted {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        add(layout.size());
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        HELD.fetch_sub(layout.size() as i64, Relaxed);
        unsafe { System.dealloc(at, layout) }
    }

    unsafe fn realloc(&self, at: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // Both may be held for a moment.
        add(size);
        HELD.fetch_sub(layout.size() as i64, Relaxed);
        unsafe { System.realloc(at, layout, size) }
    }
}

/// Runs `work`, and gives the most bytes that were held beyond what was held before.
pub fn most<T>(work: impl FnOnce() -> T) -> (T, u64) {
    let (before, outer) = (HELD.load(Relaxed), MOST.load(Relaxed));
    MOST.store(before, Relaxed);
    let done = work();
    let most = MOST.load(Relaxed);
    MOST.store(most.max(outer), Relaxed);
    (done, (most - before).max(0) as u64)
}
