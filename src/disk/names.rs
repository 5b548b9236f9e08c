//! The names of a store's files: which ones are allowed, who gets one that two want, and the ids in them.

use std::hash::{BuildHasher, RandomState};

use crate::base::{Error, Result};

/// The end of the names under which files are written; no committed file's name ends so.
pub(crate) const TEMPORARY: &str = ".gonio-tmp";

/// The start of the temporary names of scratch files.
pub(crate) const SCRATCH: &str = "scratch";

/// The id of a run whose folder has no mark.
pub(super) const UNMARKED: &str = "none";

/// The longest name of a file in a store, in bytes.
const LONGEST_NAME: usize = 200;

/// What a finished file does where its name is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Naming {
    /// The file that was there first stays.
    FirstWins,
    /// The file that was there gives way.
    Replace,
}

/// Whether a finished file got its name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Committed {
    /// The name was free, or its file gave way.
    Now,
    /// Another file had the name first, and stays.
    Already,
}

/// Refuses a name that is empty, temporary, too long, or could leave the store.
pub(crate) fn check_name(name: &str) -> Result<()> {
    let part_is_bad = |part: &str| part.is_empty() || part == "." || part == "..";
    let refuse = |why: &str| Err(Error::invalid(format!("{name:?} cannot name a file of a run: {why}")));
    if name.len() > LONGEST_NAME {
        return refuse("it is longer than 200 bytes");
    }
    if name.contains(|c: char| c.is_control() || c == '\\' || c == ':') {
        return refuse("it holds a backslash, a colon or a control character");
    }
    if name.split('/').any(part_is_bad) {
        return refuse("a part between slashes is empty, . or ..");
    }
    if name.ends_with(TEMPORARY) {
        return refuse("it ends as temporary names do");
    }
    Ok(())
}

/// An id that nobody else has: 16 hexadecimal digits from the system's random numbers.
pub(super) fn fresh_id() -> String {
    format!("{:016x}", RandomState::new().hash_one(0))
}
