//! Triangle meshes. Each format is a file or folder here; those that are read stand in one list (`list`).

mod format;
pub(crate) mod glb;
mod gltf;
mod lines;
mod list;
mod obj;
mod off;
pub(crate) mod ply;
mod stl;
#[cfg(test)]
mod tests;
mod two_passes;

pub use list::read;
pub(crate) use list::{is_named, look, read_from, sample};
