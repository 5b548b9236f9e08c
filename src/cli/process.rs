//! What the process is set up with before there are threads.

use super::{defect, out_of_memory};
use crate::base::memory;
use crate::flow::signal;
use crate::model;

/// Sets the process up: the allocator gives back what is freed, the embedded engine starts no threads beside the workers, and
/// limits on memory and on the size of files, and defects, end in words.
///
/// # Safety
/// No other thread runs yet.
pub unsafe fn prepare_process() {
    memory::return_what_is_freed();
    signal::ignore_limits_of_file_size();
    defect::tell_of_panics();
    out_of_memory::tell();
    // SAFETY: the caller says so.
    unsafe { model::one_thread() };
}
