//! The one error type for everything that can break a run. Problems of a pipeline file are not errors but a list, and a bad
//! frame is not an error but a skipped item.

use std::path::{Path, PathBuf};

use super::shown::Plain;

/// The result of work that can break a run.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something could not be done, in words that the user can act on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("cannot {verb} {}: {}", Plain(path.display()), Plain(source))]
    Io {
        /// The attempt: "read", "create", "rename".
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// The system's error.
        source: std::io::Error,
    },
    /// A file is not what its format says it should be.
    #[error("{}: {}", Plain(path.display()), Plain(found))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in the file, what was found, what is allowed.
        found: String,
    },
    /// A request that cannot be met, whatever the files hold.
    #[error("{}", Plain(.0))]
    Invalid(String),
    /// A thread of the dataflow panicked.
    #[error("stage {stage} panicked: {}", Plain(message))]
    Panic {
        /// The stage's name.
        stage: String,
        /// The panic's own words.
        message: String,
    },
    /// The run was asked to stop; committed work stays.
    #[error("interrupted; the same command goes on from here")]
    Interrupted,
    /// An error and what was being done.
    #[error("{}: {source}", Plain(doing))]
    Context {
        /// What was being done.
        doing: String,
        /// The error.
        #[source]
        source: Box<Error>,
    },
}

impl Error {
    /// For `map_err` on an I/O call: `File::open(p).map_err(Error::io("open", p))`.
    pub fn io(verb: &'static str, path: impl AsRef<Path>) -> impl FnOnce(std::io::Error) -> Error {
        let path = path.as_ref().to_owned();
        move |source| Error::Io { verb, path, source }
    }

    /// A malformed file.
    pub fn malformed(path: impl AsRef<Path>, found: impl Into<String>) -> Error {
        Error::Malformed { path: path.as_ref().to_owned(), found: found.into() }
    }

    /// A request that cannot be met.
    pub fn invalid(what: impl Into<String>) -> Error {
        Error::Invalid(what.into())
    }

    /// The error with `doing` put before it.
    pub fn doing(self, doing: impl Into<String>) -> Error {
        Error::Context { doing: doing.into(), source: Box::new(self) }
    }

    /// The error without what was being done.
    fn cause(&self) -> &Error {
        match self {
            Error::Context { source, .. } => source.cause(),
            cause => cause,
        }
    }

    /// The file, if the error is a malformed file.
    pub fn malformed_file(&self) -> Option<&Path> {
        if let Error::Malformed { path, .. } = self.cause() { Some(path) } else { None }
    }

    /// What the system said, if it is the system that refused.
    pub(crate) fn system_error(&self) -> Option<std::io::ErrorKind> {
        if let Error::Io { source, .. } = self.cause() { Some(source.kind()) } else { None }
    }

    /// Whether the error is a full disk.
    pub fn is_disk_full(&self) -> bool {
        let full = [std::io::ErrorKind::StorageFull, std::io::ErrorKind::QuotaExceeded];
        matches!(self.cause(), Error::Io { source, .. } if full.contains(&source.kind()))
    }

    /// Whether the error is a file that would be larger than the system allows.
    pub fn is_file_too_large(&self) -> bool {
        matches!(self.cause(), Error::Io { source, .. } if source.kind() == std::io::ErrorKind::FileTooLarge)
    }

    /// Whether the run was asked to stop and did not break.
    pub fn is_interrupt(&self) -> bool {
        matches!(self.cause(), Error::Interrupted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_message_steers_a_terminal() {
        let escape = "a\u{1b}[2Jb";
        for error in [
            Error::io("open", escape)(std::io::Error::other(escape)),
            Error::malformed(escape, escape),
            Error::invalid(escape).doing(escape),
            Error::Panic { stage: "cast".to_owned(), message: escape.to_owned() },
        ] {
            let said = error.to_string();
            assert!(said.contains(r"a\u{1b}[2Jb") && !said.contains(char::is_control), "{said:?}");
        }
    }
}
