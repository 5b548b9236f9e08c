//! Named threads, where the system may grant fewer than are asked for.

use std::io;
use std::sync::{Arc, Mutex};
use std::thread::{Builder, Scope, sleep};
use std::time::Duration;

use super::mutex::lock;
use crate::base::Error;

/// The waits before further tries, milliseconds: threads that ended a moment ago still count against a limit.
const AGAIN: [u64; 4] = [1, 4, 16, 64];

/// Starts a named thread. One that is `needed` is asked for a few times.
///
/// # Errors
/// The system's; `body` has not run.
pub(crate) fn start<'scope, 'env>(
    scope: &'scope Scope<'scope, 'env>,
    name: &str,
    needed: bool,
    body: impl FnOnce() + Send + 'scope,
) -> io::Result<()> {
    // A thread that is not granted takes its closure with it, so the closure must not hold the body.
    let body = Arc::new(Mutex::new(Some(body)));
    let once = || {
        let slot = Arc::clone(&body);
        let run = move || {
            let body = lock(&slot).take();
            if let Some(body) = body {
                body();
            }
        };
        Builder::new().name(name.to_owned()).spawn_scoped(scope, run).map(drop)
    };
    let mut started = once();
    for wait in AGAIN.into_iter().filter(|_| needed) {
        match &started {
            Err(why) if why.kind() == io::ErrorKind::WouldBlock => sleep(Duration::from_millis(wait)),
            _ => break,
        }
        started = once();
    }
    started
}

/// The error where a thread that is needed is not granted.
pub(crate) fn refused(name: &str, why: &dyn std::error::Error) -> Error {
    Error::invalid(format!(
        "cannot start thread {name}: {why}; the system allows this process too few threads, or too little memory for them \
         (ulimit -u, ulimit -v, the limits of a container): raise that limit, or ask for fewer by [run] threads"
    ))
}
