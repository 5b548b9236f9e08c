//! Errors that may pass: a network's disk is away for a moment, a signal comes in between, a handle is stale. What failed is
//! tried again after a short wait.

use std::io::ErrorKind;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::Duration;

use super::{Error, Result};

/// The milliseconds to wait before a further try; tests do not wait.
const WAITS: [u64; 3] = if cfg!(test) { [0; 3] } else { [20, 80, 320] };

/// How often all waits may be for nothing before nothing is waited for: a thousand files that are simply not there must not
/// take a thousand times as long.
const MOST: u32 = 8;

/// Tries again what may pass, as long as that helps. Threads may share it.
#[derive(Debug, Default)]
pub(crate) struct Patience {
    /// How often all waits were for nothing since one helped.
    fruitless: AtomicU32,
}

impl Patience {
    /// Does something, and does it again if its error may pass.
    pub(crate) fn with<T>(&self, mut act: impl FnMut() -> Result<T>) -> Result<T> {
        let mut done = act();
        if self.fruitless.load(Ordering::Relaxed) >= MOST {
            return done;
        }
        for wait in WAITS {
            if !done.as_ref().is_err_and(may_pass) {
                return done;
            }
            thread::sleep(Duration::from_millis(wait));
            done = act();
            if done.is_ok() {
                self.fruitless.store(0, Ordering::Relaxed);
                return done;
            }
        }
        self.fruitless.fetch_add(1, Ordering::Relaxed);
        done
    }
}

/// Whether the same may go well a moment later.
fn may_pass(why: &Error) -> bool {
    use ErrorKind::{InvalidInput, IsADirectory, OutOfMemory, PermissionDenied};
    why.system_error().is_some_and(|kind| !matches!(kind, InvalidInput | IsADirectory | OutOfMemory | PermissionDenied))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// How often something is tried that fails so many times.
    fn tries(patience: &Patience, failures: u32, kind: ErrorKind) -> (bool, u32) {
        let mut tried = 0;
        let done = patience.with(|| {
            tried += 1;
            if tried > failures { Ok(()) } else { Err(Error::io("read", "a.jpg")(kind.into())) }
        });
        (done.is_ok(), tried)
    }

    #[test]
    fn what_may_pass_is_tried_again_and_nothing_else() {
        let patience = Patience::default();
        assert_eq!(tries(&patience, 0, ErrorKind::NotFound), (true, 1));
        for kind in [ErrorKind::NotFound, ErrorKind::Interrupted, ErrorKind::StaleNetworkFileHandle, ErrorKind::Other] {
            assert_eq!(tries(&patience, 2, kind), (true, 3));
        }
        assert_eq!(tries(&patience, 1, ErrorKind::PermissionDenied), (false, 1));
        assert!(patience.with(|| Err::<(), _>(Error::malformed("a.jpg", "cut short"))).is_err());
    }

    #[test]
    fn patience_ends_and_comes_back() {
        let patience = Patience { fruitless: AtomicU32::new(MOST - 1) };
        assert_eq!(tries(&patience, 9, ErrorKind::NotFound), (false, 4));
        assert_eq!(tries(&patience, 9, ErrorKind::NotFound), (false, 1));
        let patience = Patience { fruitless: AtomicU32::new(MOST - 1) };
        assert_eq!(tries(&patience, 1, ErrorKind::NotFound), (true, 2));
        assert_eq!(patience.fruitless.load(Ordering::Relaxed), 0);
    }
}
