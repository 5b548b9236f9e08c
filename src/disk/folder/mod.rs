//! A folder that is held open: files are named relative to it, so nobody can put another folder in its place meanwhile,
//! and no link is followed below it. Names are single parts of a path.

#[cfg(not(unix))]
mod elsewhere;
mod kind;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub(super) use elsewhere::{Folder, has_no_links};
pub(super) use kind::Kind;
#[cfg(unix)]
pub(super) use unix::{Folder, has_no_links};
