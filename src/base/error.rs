//! One error type for everything that can break a run. Faults of a pipeline file are not errors but a list
//! (`pipeline::check`), and a bad frame is not an error but a skipped item.

use std::path::{Path, PathBuf};

/// The result of anything that can break a run.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Why something could not be done, in words that a user can act on.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The operating system refused.
    #[error("cannot {verb} {}: {source}", path.display())]
    Io {
        /// What was tried: "read", "create", "rename".
        verb: &'static str,
        /// On which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A file is not what its format says it should be.
    #[error("{}: {found}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Where in it, what was found, what is allowed.
        found: String,
    },
    /// A request that cannot be met, whatever the files hold.
    #[error("{0}")]
    Invalid(String),
    /// A thread of the dataflow panicked.
    #[error("stage {stage} panicked: {message}")]
    Panic {
        /// The stage's name.
        stage: String,
        /// The panic's own words.
        message: String,
    },
    /// Asked to stop (SIGINT, SIGTERM); what was committed stays.
    #[error("interrupted; the same command goes on from here")]
    Interrupted,
    /// An error with the doing that it interrupted.
    #[error("{doing}: {source}")]
    Context {
        /// What was being done.
        doing: String,
        /// What went wrong.
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

    /// A malformed file, in words.
    pub fn malformed(path: impl AsRef<Path>, found: impl Into<String>) -> Error {
        Error::Malformed { path: path.as_ref().to_owned(), found: found.into() }
    }

    /// An impossible request, in words.
    pub fn invalid(what: impl Into<String>) -> Error {
        Error::Invalid(what.into())
    }

    /// The same error, with what was being done put before it.
    pub fn doing(self, doing: impl Into<String>) -> Error {
        Error::Context { doing: doing.into(), source: Box::new(self) }
    }

    /// What went wrong, without what was being done.
    fn cause(&self) -> &Error {
        match self {
            Error::Context { source, .. } => source.cause(),
            cause => cause,
        }
    }

    /// The file that is not what its format says it should be, if that is what is wrong.
    pub fn malformed_file(&self) -> Option<&Path> {
        if let Error::Malformed { path, .. } = self.cause() { Some(path) } else { None }
    }

    /// Whether a disk is full.
    pub fn is_disk_full(&self) -> bool {
        let full = [std::io::ErrorKind::StorageFull, std::io::ErrorKind::QuotaExceeded];
        matches!(self.cause(), Error::Io { source, .. } if full.contains(&source.kind()))
    }

    /// Whether the run was asked to stop, rather than broken.
    pub fn is_interrupt(&self) -> bool {
        matches!(self.cause(), Error::Interrupted)
    }
}
