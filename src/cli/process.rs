//! What the process is set up with before there are threads.

use crate::base::memory;
use crate::model;

/// Sets the process up: the allocator gives back what is freed, and the embedded engine starts no threads beside the workers.
///
/// # Safety
/// No other thread runs yet.
pub unsafe fn prepare_process() {
    memory::return_what_is_freed();
    // SAFETY: the caller says so.
    unsafe { model::one_thread() };
}
