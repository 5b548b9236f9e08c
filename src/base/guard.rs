//! Code of others that may panic where it should answer with an error. Such a panic becomes an error in words, and is no defect to
//! be reported: nobody else is told of it.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Runs code of others on this thread. Its panic becomes an error: the panic's own words.
///
/// # Errors
/// The panic of `work`.
pub(crate) fn guarded<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let before = GUARDED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(before);
    done.map_err(|panic| words(&*panic).to_owned())
}

/// Whether this thread runs guarded code.
pub(crate) fn is_guarded() -> bool {
    GUARDED.try_with(Cell::get).unwrap_or(false)
}

/// The words of a panic.
pub(crate) fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("without words")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_its_words() {
        assert_eq!(guarded(is_guarded), Ok(true));
        assert_eq!(guarded::<()>(|| panic!("on {}", "purpose")), Err("on purpose".to_owned()));
        assert_eq!(guarded::<()>(|| std::panic::panic_any(1)), Err("without words".to_owned()));
        let nested = || guarded::<()>(|| panic!("inner")).is_err() && is_guarded();
        assert_eq!(guarded(nested), Ok(true), "the outer guard outlives the inner");
        assert!(!is_guarded());
    }
}
