//! Triangle meshes. Each format is a file or folder here; those that are read stand in one list (`list`).

mod format;
pub(crate) mod glb;
mod list;
mod obj;
pub(crate) mod ply;
mod two_passes;

pub use list::read;
pub(crate) use list::{is_named, look, read_from};
