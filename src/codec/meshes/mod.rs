//! Triangle meshes. Each format is a file or folder here; those that are read stand in one list (`list`). A mesh may have several
//! files (`files`).

mod files;
mod format;
pub(crate) mod glb;
mod gltf;
mod lines;
mod list;
mod obj;
mod off;
pub(crate) mod ply;
mod shifted;
mod stl;
#[cfg(test)]
mod tests;

pub use files::read;
pub(crate) use files::{MeshFiles, sample};
pub(in crate::codec) use lines::line_end;
pub(crate) use list::{is_named, look};
