//! Write-once files, and the unit records that say which files count.
//!
//! Invariants:
//! - **Whole or not there.** A file is written under a temporary name, flushed, synced, given its name, and its folder
//!   synced. Under its own name there is the whole file or none. Finishing is typed: [`Draft::commit`] consumes the
//!   draft, and a draft that is dropped leaves nothing.
//! - **Once.** A committed file is never written again, so it can be mapped into memory. Only a file that is renewed as a
//!   whole (a table of materials) is replaced, by the same steps; whoever has the old file open keeps it.
//! - **The first one wins.** Of two files that want one name, one gets it, in one step of the filesystem, and the other
//!   is told so. Hence several processes may work on one run.
//! - **The record comes last.** Files first, then the unit record that names them. A file whose name carries the run's id
//!   and that no record names is the rubbish of a broken run; the holder of [`Lock`] sweeps it. Nothing else is removed.
//! - **A folder that is not ours is never changed.** A run takes a folder that is empty or not there, and its first file is
//!   the mark ([`mark`]). A folder that holds files and no mark is refused.
//! - **No link is followed.** A run's folder is held open, and what is below it is named relative to it ([`folder`]). Where
//!   a link, a pipe or a device has a file's name, it is refused.
//! - **What is built on is durable.** Whoever takes the lock syncs the folders that are there before it changes anything.
//! - **Scratch is never committed.** [`Scratch`] has a temporary name and goes when it is dropped.
//! - **Nothing is trusted.** A file's size is checked when a run is opened, its bytes when it is read: sealed files by
//!   their footer, others by their unit record's checksum. Names cannot leave the store. A folder, link or device under
//!   a file's name is an obstacle: it is set aside as it is.

mod atomic;
mod corrupt;
pub(crate) mod dir;
mod done;
#[cfg(test)]
pub(crate) mod faulty;
mod folder;
pub(crate) mod frozen;
#[cfg(test)]
#[cfg(unix)]
pub(crate) mod journal;
pub(crate) mod ledger;
pub(crate) mod lock;
pub(crate) mod mark;
pub(crate) mod mem;
pub(crate) mod names;
#[cfg(test)]
#[cfg(unix)]
pub(crate) mod power;
pub(crate) mod scratch;
pub(crate) mod sealed;
mod sealed_json;
pub(crate) mod space;
pub(crate) mod store;
pub(crate) mod unit;
mod unit_record;
mod verify;

pub(crate) use atomic::{WriteSeek, write_atomic};
pub use dir::DirStore;
pub(crate) use frozen::Damage;
pub use ledger::Ledger;
pub(crate) use ledger::{Finding, Findings};
pub use lock::Lock;
pub use mem::MemStore;
pub(crate) use names::Committed;
pub(crate) use sealed::{Seal, Sealed, SealedWriter};
pub(crate) use space::Space;
pub use store::Store;
pub(crate) use store::{Content, Draft, FileEntry};
pub use unit::Recipe;
pub(crate) use unit::{Difference, UnitName};
pub(crate) use verify::{Held, Rotten, verify};

#[cfg(test)]
mod tests;
