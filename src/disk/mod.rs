//! Write-once files and the manifest that names them.
//!
//! Invariants:
//! - **Whole or not there.** A file is written under a temporary name, flushed, synced, renamed, and its folder synced.
//!   Under its own name there is the whole file or none. Finishing is typed: [`Draft::commit`] consumes the draft, and a
//!   draft that is dropped leaves nothing.
//! - **Once.** What is committed is never written again, so that it can be mapped into memory. Only what is renewed as a
//!   whole (the manifest, a table of materials) is replaced, by the same steps; who has the old one open keeps it.
//! - **The manifest comes last and names all that counts.** Files first, then the manifest. What a run owns and the
//!   manifest does not name is the rubbish of a broken run, and is swept when the run is opened again. Nothing else is
//!   ever removed: a run may live in a folder with other files.
//! - **Scratch is nobody's.** What is worked on and not kept ([`Scratch`]) has a temporary name and is never committed.
//! - **One writer.** [`Lock`] keeps a second run out of the folder. What checks and then acts here relies on it.
//! - **Nothing is trusted.** A file's size is checked when a run is opened, its bytes when it is read: sealed files by
//!   their footer, others by the manifest's checksum or their own. Names cannot leave the store.

mod atomic;
pub mod dir;
#[cfg(test)]
pub(crate) mod faulty;
pub mod lock;
pub mod manifest;
pub mod mem;
mod recipe;
pub mod room;
pub mod scratch;
pub mod sealed;
pub mod store;

pub use atomic::{WriteSeek, write_atomic};
pub use dir::DirStore;
pub use lock::Lock;
pub use manifest::{Manifest, Opening, Unit};
pub use mem::MemStore;
pub use recipe::Recipe;
pub use room::Room;
pub use scratch::{Scratch, Working};
pub use sealed::{Seal, Sealed, SealedWriter};
pub use store::{Content, Draft, FileEntry, Store};

#[cfg(test)]
mod tests;
