//! Standard output and standard error as the process was given them: each may be closed, full, slow or without a reader.
//!
//! What is written to standard output is a result, so that a failure is an error. Only a reader that left (`| head`) is none: it
//! has all that it wanted, and the command goes on to its own end. What is written to standard error never changes how a command
//! ends.

use std::io::{self, ErrorKind, StdoutLock, Write};
#[cfg(unix)]
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::sleep;
use std::time::Duration;

use crate::base::{Error, Result};

/// Writes to standard output, to the last byte.
///
/// # Errors
/// Whatever keeps a byte from being written, but for a reader that left.
pub(super) fn write_out(write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<()> {
    let wrote = if UNWRITABLE.load(Ordering::Relaxed) {
        Err(io::Error::other("it is closed, or not open for writing"))
    } else {
        let mut out = Patient(io::stdout().lock());
        write(&mut out).and_then(|()| out.flush())
    };
    match wrote {
        Err(why) if why.kind() == ErrorKind::BrokenPipe => Ok(()),
        wrote => wrote.map_err(Error::io("write", "standard output")),
    }
}

/// Standard output that waits for a slow reader also where the reader has made the pipe or the terminal one that does not wait.
struct Patient(StdoutLock<'static>);

impl Patient {
    fn ask<T>(&mut self, mut ask: impl FnMut(&mut StdoutLock<'static>) -> io::Result<T>) -> io::Result<T> {
        loop {
            match ask(&mut self.0) {
                Err(why) if why.kind() == ErrorKind::WouldBlock => sleep(Duration::from_millis(10)),
                asked => return asked,
            }
        }
    }
}

impl Write for Patient {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.ask(|out| out.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.ask(Write::flush)
    }
}

/// Whether standard output could not be written to when the process began. It must be asked before `main`: the standard library
/// opens /dev/null in place of a closed stream, and takes a write to a stream that is only open for reading for done.
static UNWRITABLE: AtomicBool = AtomicBool::new(false);

#[cfg(any(target_os = "linux", target_os = "macos"))]
#[used]
#[cfg_attr(target_os = "linux", unsafe(link_section = ".init_array"))]
#[cfg_attr(target_os = "macos", unsafe(link_section = "__DATA,__mod_init_func"))]
static BEFORE_MAIN: extern "C" fn() = {
    extern "C" fn look() {
        // SAFETY: the call only asks about the number.
        let flags = unsafe { libc::fcntl(libc::STDOUT_FILENO, libc::F_GETFL) };
        UNWRITABLE.store(flags < 0 || flags & libc::O_ACCMODE == libc::O_RDONLY, Ordering::Relaxed);
    }
    look
};

/// Writes words to standard error where that can be done at once: it waits for no lock and for no reader.
pub(super) fn last_words(words: &[u8]) {
    #[cfg(unix)]
    say_at_once(rustix::stdio::stderr(), words);
    #[cfg(not(unix))]
    io::stderr().write_all(words).unwrap_or_default();
}

/// Writes the last words of standard error at once, on a line of their own: what other threads write from now on is lost. It
/// allocates nothing.
pub(super) fn parting_words(words: &[u8]) {
    #[cfg(unix)]
    {
        use rustix::fs::{Mode, OFlags, open};
        let kept = rustix::io::dup(rustix::stdio::stderr());
        if let (Ok(kept), Ok(null)) = (&kept, open(c"/dev/null", OFlags::WRONLY, Mode::empty()))
            && rustix::stdio::dup2_stderr(null).is_ok()
        {
            say_at_once(kept.as_fd(), b"\n");
            return say_at_once(kept.as_fd(), words);
        }
    }
    last_words(words);
}

#[cfg(unix)]
fn say_at_once(stderr: BorrowedFd<'_>, words: &[u8]) {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let mut writable = [PollFd::new(&stderr, PollFlags::OUT)];
    if poll(&mut writable, Some(&Timespec { tv_sec: 0, tv_nsec: 0 })) == Ok(1) {
        rustix::io::write(stderr, words).unwrap_or_default();
    }
}
